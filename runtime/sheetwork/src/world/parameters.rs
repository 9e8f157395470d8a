//! Parameters that can be changed while a world runs, by path.

use std::borrow::Cow;

use glam::DVec3;

use crate::error::InputError;
use crate::scene::Air;
use crate::sheet::Sheet;
use crate::units::{DisplayUnit, Quantity};
use crate::world::World;

/// A parameter with its present value.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Path, as in `sheets.strip.material.young`.
    pub path: String,
    /// Value as text that [`World::set`] accepts.
    pub value: String,
    /// Unit; empty for a name or a dimensionless number.
    pub unit: &'static str,
    /// Smallest and largest value of a number.
    pub range: Option<(f64, f64)>,
}

impl Parameter {
    /// Kind of the value: "number" (or "none" for an optional one), "vector" of three numbers,
    /// "boolean" (true or false), or "name".
    pub fn kind(&self) -> &'static str {
        if self.value.starts_with('(') {
            "vector"
        } else if self.range.is_some() {
            "number"
        } else if ["true", "false"].contains(&self.value.as_str()) {
            "boolean"
        } else {
            "name"
        }
    }
}

/// Parameters of each sheet: name, unit, range.
const SHEET_PARAMETERS: &[(&str, &str, (f64, f64))] = &[
    ("material.young", "Pa", (1e-3, 2e12)),
    ("material.thickness", "m", (1e-7, 1.0)),
    ("material.poisson", "", (-0.99, 0.499)),
    ("damping", "of critical", (0.0, 10.0)),
    ("damping_ratio", "of critical", (0.0, 10.0)),
    ("drag.0", "", (0.0, 10.0)),
    ("drag.1", "", (0.0, 10.0)),
    ("pressure", "Pa", (-1e6, 1e6)),
    ("friction", "", (0.0, 10.0)),
    ("restitution", "", (0.0, 1.0)),
    ("temperature", "°C", (-273.15, 5000.0)),
    ("flexion_limit", "degrees", (1.0, 180.0)),
];

impl World {
    /// All parameters that [`World::set`] accepts, with their present values, except the states
    /// `sheets.NAME.grid` and `viewpoint`.
    pub fn parameters(&self) -> Vec<Parameter> {
        let new = |path: &str, value: String, unit, range| Parameter { path: path.into(), value, unit, range };
        let text = |v: DVec3| format!("({}, {}, {})", v.x, v.y, v.z);
        let mut all = vec![
            new("gravity", text(self.gravity), "m/s²", Some((-1e3, 1e3))),
            new("engine", self.engine.to_string(), "", None),
            new("dt", self.dt.to_string(), "s", Some((1e-7, 1.0))),
            new("tolerance", self.tolerance.to_string(), "m", Some((1e-15, 1.0))),
            new("air.factor", self.air.factor.to_string(), "", Some((1e-6, 1.0))),
            new("air.per", self.air.per.to_string(), "s", Some((1e-6, 1e3))),
            new("air.density", self.air.density.to_string(), "kg/m³", Some((0.0, 1e4))),
            new("air.wind", text(self.air.wind), "m/s", Some((-1e3, 1e3))),
        ];
        for dial in self.heat.iter().flat_map(|h| h.parameters()) {
            all.push(if is_switch(&dial.path) {
                new(&dial.path, (dial.value >= 0.5).to_string(), "", None)
            } else {
                new(&dial.path, dial.value.to_string(), dial.unit, Some(dial.range))
            });
        }
        if self.has_detail() {
            let budget = self.detail_budget().map_or_else(|| "none".to_owned(), |b| b.to_string());
            all.push(new("detail_budget", budget, "ms", Some((1e-3, 1e6))));
        }
        for sheet in &self.sheets {
            for (name, unit, range) in SHEET_PARAMETERS {
                if let Some(value) = value_of(sheet, name) {
                    all.push(new(&format!("sheets.{}.{name}", sheet.name), value, unit, Some(*range)));
                }
            }
            let policy = sheet.when_unstable().to_string();
            all.push(new(&format!("sheets.{}.when_unstable", sheet.name), policy, "", None));
        }
        all
    }

    /// `value` in the unit of the parameter at `path`, as text: `2.1 GPa` of a modulus is
    /// `2100000000`. Plain numbers, other texts and values of unknown parameters are returned
    /// unchanged.
    ///
    /// # Errors
    /// When the unit does not fit the parameter; the message names the units that do.
    pub fn in_own_unit<'a>(&self, path: &str, value: &'a str) -> Result<Cow<'a, str>, InputError> {
        let value = value.trim();
        let begins = value.trim_start_matches(['+', '-', '−', '.', ',']).starts_with(|c: char| c.is_ascii_digit());
        if !begins || value.parse::<f64>().is_ok() {
            return Ok(value.into());
        }
        let parameter = self.parameters().into_iter().find(|p| p.path == canonical(&self.sheets, path));
        let Some(parameter) = parameter.filter(|p| p.kind() == "number" || p.value == "none") else {
            return Ok(value.into());
        };
        let Some(quantity) = Quantity::from_unit(parameter.unit) else { return Ok(value.into()) };
        let shown = DisplayUnit::fixed(quantity, parameter.unit, 1.0);
        let number = shown.parse(value).map_err(|e| InputError::new(path, e.to_string()))?;
        Ok(number.to_string().into())
    }

    /// Set the parameter at `path` from the next step on. A number may have a unit: `2.1 GPa`, `0.3
    /// mm`, `70 °F`; a plain number has the parameter's own. Returns the old value as text.
    ///
    /// # Errors
    /// When there is no such parameter, or the value has another kind or is out of range; nothing
    /// changes then.
    pub fn set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        let value = &*self.in_own_unit(path, value)?;
        let old = |world: &Self| world.parameters().into_iter().find(|p| p.path == path).map(|p| p.value);
        let before = old(self).unwrap_or_default();
        let named = |e: InputError| InputError::new(path, e.problem);
        match path {
            "gravity" => self.set_gravity(vector(path, value)?).map_err(named)?,
            "engine" => self.set_engine(value.parse().map_err(named)?),
            "dt" => self.set_dt(number(path, value)?).map_err(named)?,
            "tolerance" => self.set_tolerance(number(path, value)?).map_err(named)?,
            "air.factor" => self.set_air(Air { factor: number(path, value)?, ..self.air }).map_err(named)?,
            "air.per" => self.set_air(Air { per: number(path, value)?, ..self.air }).map_err(named)?,
            "air.density" => self.set_air(Air { density: number(path, value)?, ..self.air }).map_err(named)?,
            "air.wind" => self.set_air(Air { wind: vector(path, value)?, ..self.air }).map_err(named)?,
            "detail_budget" if self.has_detail() => {
                let budget = if value == "none" { None } else { Some(number(path, value)?) };
                self.set_detail_budget(budget)?;
            }
            "viewpoint" if self.has_detail() => {
                let eye = if value == "none" { None } else { Some(vector(path, value)?) };
                self.set_viewpoint(eye)?;
            }
            _ if self.set_source_parameter(path, value)? => {}
            _ => return self.set_sheet_parameter(path, value),
        }
        Ok(before)
    }

    /// Set a parameter of the thermal model. Returns `false` when the path is not one of these.
    fn set_source_parameter(&mut self, path: &str, value: &str) -> Result<bool, InputError> {
        let Some(heat) = &mut self.heat else { return Ok(false) };
        if !heat.parameters().iter().any(|d| d.path == path) {
            return Ok(false);
        }
        let value = if is_switch(path) { f64::from(u8::from(boolean(path, value)?)) } else { number(path, value)? };
        let turned = heat.set_parameter(path, value)?;
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(turned)
    }

    fn set_sheet_parameter(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        let unknown = || self.no_such_parameter(path);
        let rest = path.strip_prefix("sheets.").and_then(|r| r.split_once('.'));
        let Some((which, name)) = rest else { return Err(unknown()) };
        let by_name = self.sheets.iter().position(|s| s.name == which);
        let index = by_name.or_else(|| which.parse().ok()).filter(|i| *i < self.sheets.len());
        if let (Some(index), "when_unstable") = (index, name) {
            let before = self.sheets[index].when_unstable().to_string();
            let set = value.trim_matches('"').parse().and_then(|policy| self.sheets[index].set_when_unstable(policy));
            return set.map(|()| before).map_err(|e| InputError::new(path, e.problem));
        }
        if let (Some(index), "grid") = (index, name) {
            let before = grid_text(&self.sheets[index]);
            let set = grid(path, value).and_then(|grid| self.remap_index(index, grid));
            return set.map(|()| before).map_err(|e| InputError::new(path, e.problem));
        }
        let row = SHEET_PARAMETERS.iter().find(|(n, _, _)| *n == name);
        let (Some(index), Some((name, unit, range))) = (index, row) else { return Err(unknown()) };
        let value = if *name == "flexion_limit" && value == "none" { None } else { Some(number(path, value)?) };
        if let Some(value) = value {
            crate::error::check_range(path, value, range.0, range.1, unit)?;
        }
        let sheet = &mut self.sheets[index];
        let before = value_of(sheet, name).unwrap_or_default();
        if before.is_empty() && name.starts_with("damping") {
            let other = if *name == "damping" { "damping_ratio" } else { "damping" };
            return Err(InputError::new(path, format!("does nothing to this sheet, which has {other}")));
        }
        set_value(sheet, name, value).map_err(|e| InputError::new(path, e.problem))?;
        Ok(before)
    }
}

/// The path with the sheet's name in place of its number.
fn canonical(sheets: &[Sheet], path: &str) -> String {
    let rest = path.strip_prefix("sheets.").and_then(|r| r.split_once('.'));
    let named = rest.and_then(|(which, name)| Some((sheets.get(which.parse::<usize>().ok()?)?, name)));
    named.map_or_else(|| path.to_owned(), |(sheet, name)| format!("sheets.{}.{name}", sheet.name))
}

/// Numbers of nodes along length and width, as `21x11`.
fn grid_text(sheet: &Sheet) -> String {
    format!("{}x{}", sheet.grid.0, sheet.grid.2)
}

fn grid(path: &str, value: &str) -> Result<(u32, u32), InputError> {
    let text = value.trim_matches('"');
    let two = text.split_once('x').and_then(|(u, v)| Some((u.trim().parse().ok()?, v.trim().parse().ok()?)));
    two.ok_or_else(|| InputError::new(path, format!("\"{text}\" is no grid: masses along length and width, as 21x11")))
}

fn value_of(sheet: &Sheet, name: &str) -> Option<String> {
    Some(match name {
        "material.young" => sheet.material().young.to_string(),
        "material.thickness" => sheet.material().thickness.to_string(),
        "material.poisson" => sheet.material().poisson.to_string(),
        "damping" if sheet.follows_material() => return None,
        "damping" => sheet.damping().to_string(),
        "damping_ratio" if !sheet.follows_material() => return None,
        "damping_ratio" => sheet.damping_ratio().to_string(),
        "drag.0" => sheet.drag().0.to_string(),
        "drag.1" => sheet.drag().1.to_string(),
        "pressure" => sheet.pressure().to_string(),
        "friction" => sheet.friction.to_string(),
        "restitution" => sheet.restitution.to_string(),
        "temperature" => sheet.temperature()?.to_string(),
        "flexion_limit" if sheet.flexion.triples.is_empty() => return None,
        "flexion_limit" => sheet.flexion_angle_limit().map_or_else(|| "none".to_owned(), |l| l.to_string()),
        _ => return None,
    })
}

fn set_value(sheet: &mut Sheet, name: &str, value: Option<f64>) -> Result<(), InputError> {
    let Some(value) = value else { return sheet.set_flexion_limit(None) };
    let mut material = sheet.material().clone();
    match name {
        "material.young" => material.young = value,
        "material.thickness" => material.thickness = value,
        "material.poisson" => material.poisson = value,
        "damping" => return sheet.set_damping(value),
        "damping_ratio" => return sheet.set_damping_ratio(value),
        "drag.0" => return sheet.set_drag(value, sheet.drag().1),
        "drag.1" => return sheet.set_drag(sheet.drag().0, value),
        "flexion_limit" => return sheet.set_flexion_limit(Some(value)),
        "pressure" => return sheet.set_pressure(value),
        "temperature" => return sheet.set_temperature(value),
        // Contact coefficients only: setting the material again would discard the factors of its
        // stiffness.
        _ => {
            *(if name == "friction" { &mut sheet.friction } else { &mut sheet.restitution }) = value;
            sheet.wake();
            return Ok(());
        }
    }
    sheet.set_material(material)
}

/// Whether the parameter switches a heat source on and off.
fn is_switch(path: &str) -> bool {
    path.ends_with(".on")
}

/// Parse `true` or `false`, or 1 or 0.
fn boolean(path: &str, value: &str) -> Result<bool, InputError> {
    match value {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(InputError::new(path, format!("\"{value}\" is neither true nor false"))),
    }
}

fn number(path: &str, value: &str) -> Result<f64, InputError> {
    match value.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(InputError::new(path, format!("\"{value}\" is not a finite number"))),
    }
}

fn vector(path: &str, value: &str) -> Result<DVec3, InputError> {
    let inner = value.trim_matches(|c| "()[] ".contains(c));
    let parts: Result<Vec<f64>, InputError> = inner.split(',').map(|p| number(path, p.trim())).collect();
    match parts?.as_slice() {
        [x, y, z] => Ok(DVec3::new(*x, *y, *z)),
        other => Err(InputError::new(path, format!("{} numbers, but it takes 3: (x, y, z)", other.len()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn values_may_have_units_and_a_wrong_unit_is_rejected_with_the_valid_ones() {
        let scene =
            Scene::parse(r#"(sheets: [(name: "card", structure: "shell", grid: (5, 1, 5), material: "card")])"#);
        let mut world = World::new(&scene.expect("valid")).expect("valid");
        for (path, value, wanted) in [
            ("sheets.card.material.young", "2.1 GPa", 2.1e9),
            ("sheets.0.material.young", "3e9", 3e9),
            ("sheets.0.material.thickness", "0.4 mm", 4e-4),
            ("sheets.card.pressure", "-2 Pa", -2.0),
            ("sheets.card.friction", "30 %", 0.3),
            ("dt", "4 ms", 0.004),
            ("air.density", "1.2e-3 g/cm3", 1.2),
        ] {
            world.set(path, value).expect(path);
            let path = canonical(&world.sheets, path);
            let now: f64 = world
                .parameters()
                .into_iter()
                .find(|p| p.path == path)
                .expect("known")
                .value
                .parse()
                .expect("a number");
            assert!((now / wanted - 1.0).abs() < 1e-12, "{path}: {now}");
        }
        let refused = |world: &mut World, path: &str, value: &str| world.set(path, value).expect_err(value).to_string();
        let told = refused(&mut world, "sheets.card.material.young", "3 furlongs");
        assert!(told.contains("material.young") && told.contains("Pa, kPa, MPa, GPa"), "{told}");
        assert!(refused(&mut world, "sheets.0.material.young", "0.3 mm").contains("mm is a unit of length"));
        assert!(refused(&mut world, "sheets.0.material.young", "4e15 Pa").contains("Pa"));
        assert!(refused(&mut world, "gravity", "3 m/s²").contains("3 m/s²"));
        assert!(refused(&mut world, "engine", "4 stroke").contains("4 stroke"));
        assert!(refused(&mut world, "no.such", "1 mm").contains("no.such"));
    }
}
