//! Parameters of a running world: values and setters of the rows of
//! [`ParameterRow`](crate::ParameterRow), by path.

use std::borrow::Cow;

use glam::DVec3;

use crate::error::{InputError, ParameterError};
use crate::scene::{Air, IntegratorKind, Material, contact_surface};
use crate::sheet::{Sheet, inter_layer};
use crate::units::DisplayUnit;
use crate::units::parameters::{ParameterId as Id, ParameterKind, ParameterRow, ParameterScope};
use crate::world::World;
use crate::world::remap::Grid;

/// A parameter with its present value.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Parameter {
    /// Row of the table of parameters.
    pub id: Id,
    /// Path, as in `sheets.strip.material.young`.
    pub path: String,
    /// Value as text that [`World::set`] accepts.
    pub value: String,
    /// Unit; empty for a name or a dimensionless number.
    pub unit: &'static str,
    /// Smallest and largest value of a number.
    pub range: Option<(f64, f64)>,
    /// Kind of the value.
    pub kind: ParameterKind,
}

impl Parameter {
    fn new(id: Id, object: &str, value: String) -> Self {
        let row = id.row();
        Self { id, path: row.path_of(object), value, unit: row.unit, range: row.range, kind: row.kind }
    }
}

/// Value and setter of a parameter.
enum Accessor {
    /// Parameter of the world, with the setter of a text at a path. `None`: the world has none.
    World(fn(&World) -> Option<String>, fn(&mut World, &str, &str) -> Result<(), InputError>),
    /// Number of a sheet. `None`: the sheet has none.
    Sheet(fn(&Sheet) -> Option<f64>, fn(&mut Sheet, f64) -> Result<(), InputError>),
    /// Text of a sheet, given by its index.
    SheetText(fn(&Sheet) -> Option<String>, fn(&mut World, usize, &str, &str) -> Result<(), InputError>),
}

use Accessor::{SheetText, World as Global};

/// Accessor of a number of the air.
macro_rules! number_of_air {
    ($field:ident) => {
        Global(|w| Some(w.air.$field.to_string()), |w, path, v| w.set_air(Air { $field: number(path, v)?, ..w.air }))
    };
}

/// Accessor of a number of a sheet's material.
macro_rules! number_of_material {
    ($field:ident) => {
        Accessor::Sheet(
            |s| Some(s.material().$field),
            |s, v| s.set_material(Material { $field: v, ..s.material().clone() }),
        )
    };
}

/// Accessor of a contact coefficient of a sheet. Setting the material again would discard the
/// factors of its stiffness.
macro_rules! contact_coefficient {
    ($field:ident) => {
        Accessor::Sheet(
            |s| Some(s.parameters.$field),
            |s, v| {
                s.parameters.$field = v;
                s.wake();
                Ok(())
            },
        )
    };
}

/// Accessor of a coefficient of a sheet's material that only a scene with the thesis's heat mode
/// has.
macro_rules! thesis_coefficient {
    ($field:ident) => {
        SheetText(
            |s| s.material().$field.map(|value| value.to_string()),
            |w, i, path, v| {
                w.sheets[i].parameters.material.$field = optional(path, v)?;
                w.sheets[i].wake();
                Ok(())
            },
        )
    };
}

/// Set the integrator of every sheet, if all of them support it.
fn set_engine(world: &mut World, engine: IntegratorKind) -> Result<(), InputError> {
    for sheet in &world.sheets {
        contact_surface::check_integrator(sheet.model.contact_surface, engine).map_err(|e| {
            InputError::new("engine", format!("the contact_surface of sheet `{}` {}", sheet.name, e.problem))
        })?;
    }
    world.set_engine(engine);
    Ok(())
}

/// Values and setters, in the order of the listing. Those of heat sources are in `thermal/source`.
const ACCESSORS: &[(Id, Accessor)] = &[
    (Id::Gravity, Global(|w| Some(vector_text(w.gravity)), |w, path, v| w.set_gravity(vector(path, v)?))),
    (Id::Engine, Global(|w| Some(w.engine.to_string()), |w, _, v| set_engine(w, v.parse()?))),
    (Id::TimeStep, Global(|w| Some(w.dt.to_string()), |w, path, v| w.set_dt(number(path, v)?))),
    (Id::Tolerance, Global(|w| Some(w.tolerance.to_string()), |w, path, v| w.set_tolerance(number(path, v)?))),
    (Id::AirFactor, number_of_air!(factor)),
    (Id::AirPer, number_of_air!(per)),
    (Id::AirDensity, number_of_air!(density)),
    (
        Id::AirWind,
        Global(|w| Some(vector_text(w.air.wind)), |w, path, v| w.set_air(Air { wind: vector(path, v)?, ..w.air })),
    ),
    (
        Id::DetailBudget,
        Global(
            |w| w.has_detail().then(|| optional_text(w.detail_budget())),
            |w, path, v| w.set_detail_budget(optional(path, v)?),
        ),
    ),
    (
        Id::Viewpoint,
        Global(
            |w| w.has_detail().then(String::new),
            |w, path, v| w.set_viewpoint(if v == "none" { None } else { Some(vector(path, v)?) }),
        ),
    ),
    (Id::MaterialYoung, number_of_material!(young)),
    (Id::MaterialThickness, number_of_material!(thickness)),
    (Id::MaterialPoisson, number_of_material!(poisson)),
    (Id::MaterialThesisSensitivity, thesis_coefficient!(thesis_sensitivity)),
    (Id::MaterialThesisConductivity, thesis_coefficient!(thesis_conductivity)),
    (Id::Damping, Accessor::Sheet(|s| (!s.follows_material()).then(|| s.damping()), Sheet::set_damping)),
    (Id::DampingRatio, Accessor::Sheet(|s| s.follows_material().then(|| s.damping_ratio()), Sheet::set_damping_ratio)),
    (
        Id::InterLayerStiffness,
        SheetText(
            |s| inter_layer::stiffness(s).map(|_| optional_text(inter_layer::own_stiffness(s))),
            |w, i, path, v| w.sheets[i].set_inter_layer_stiffness(optional(path, v)?),
        ),
    ),
    (Id::DragAcross, Accessor::Sheet(|s| Some(s.drag().0), |s, v| s.set_drag(v, s.drag().1))),
    (Id::DragAlong, Accessor::Sheet(|s| Some(s.drag().1), |s, v| s.set_drag(s.drag().0, v))),
    (Id::Pressure, Accessor::Sheet(|s| Some(s.pressure()), Sheet::set_pressure)),
    (Id::Friction, contact_coefficient!(friction)),
    (Id::Restitution, contact_coefficient!(restitution)),
    (Id::Temperature, Accessor::Sheet(Sheet::temperature, Sheet::set_temperature)),
    (
        Id::FlexionLimit,
        SheetText(
            |s| (!s.parameters.flexion.triples.is_empty()).then(|| optional_text(s.flexion_angle_limit())),
            |w, i, path, v| w.sheets[i].set_flexion_limit(optional(path, v)?),
        ),
    ),
    (
        Id::WhenUnstable,
        SheetText(
            |s| Some(s.when_unstable().to_string()),
            |w, i, _, v| w.sheets[i].set_when_unstable(v.trim_matches('"').parse()?),
        ),
    ),
    (
        Id::Grid,
        SheetText(
            |s| Some(format!("{}x{}", s.model.grid.0, s.model.grid.2)),
            |w, i, path, v| w.set_grid(i, grid(path, v)?),
        ),
    ),
];

/// Object of a parameter.
#[derive(Clone, Copy)]
enum Owner<'a> {
    World,
    /// Heat source, by name.
    Source(&'a str),
    /// Sheet, by index.
    Sheet(usize),
}

impl World {
    /// All parameters that [`World::set`] accepts, with their present values, except the states
    /// `sheets.NAME.grid` and `viewpoint`.
    pub fn parameters(&self) -> Vec<Parameter> {
        let live = || ACCESSORS.iter().filter(|(id, _)| id.row().scope == ParameterScope::Live);
        let of_world = |(id, accessor): &(Id, Accessor)| match accessor {
            Global(get, _) => Some(Parameter::new(*id, "", get(self)?)),
            _ => None,
        };
        let of_heat = |(id, name, value): (Id, &str, f64)| Parameter::new(id, name, source_text(id, value));
        let is_budget = |(id, _): &&(Id, Accessor)| *id == Id::DetailBudget;
        let mut all: Vec<Parameter> = live().filter(|row| !is_budget(row)).filter_map(of_world).collect();
        all.extend(self.heat.iter().flat_map(|heat| heat.parameters()).map(of_heat));
        all.extend(live().filter(is_budget).filter_map(of_world));
        for sheet in &self.sheets {
            all.extend(
                live()
                    .filter_map(|(id, accessor)| Some(Parameter::new(*id, &sheet.name, sheet_text(sheet, accessor)?))),
            );
        }
        all
    }

    /// The parameter at `path`, with its present value. Sheets may be given by index.
    ///
    /// # Errors
    /// When the world has no such parameter; the message names similar ones.
    pub fn get(&self, path: &str) -> Result<Parameter, ParameterError> {
        let found = self.resolve(path).filter(|(id, _)| id.row().scope == ParameterScope::Live);
        let value = found.and_then(|(id, owner)| Some((id, owner, self.value_of(id, owner)?)));
        let (id, owner, value) = value.ok_or_else(|| self.no_such_parameter(path))?;
        let object = match owner {
            Owner::World => "",
            Owner::Source(name) => name,
            Owner::Sheet(index) => &self.sheets[index].name,
        };
        Ok(Parameter::new(id, object, value))
    }

    /// `value` in the unit of the parameter at `path`, as text: `2.1 GPa` of a modulus is
    /// `2100000000`. Plain numbers, other texts and values of unknown parameters are returned
    /// unchanged.
    ///
    /// # Errors
    /// When the unit does not fit the parameter; the message names the units that do.
    pub fn in_own_unit<'a>(&self, path: &str, value: &'a str) -> Result<Cow<'a, str>, ParameterError> {
        let value = value.trim();
        let begins = value.trim_start_matches(['+', '-', '−', '.', ',']).starts_with(|c: char| c.is_ascii_digit());
        if !begins || value.parse::<f64>().is_ok() {
            return Ok(value.into());
        }
        let row = self.resolve(path).map(|(id, _)| id.row());
        let is_number = |row: &&ParameterRow| matches!(row.kind, ParameterKind::Number | ParameterKind::Optional);
        let Some(row) = row.filter(is_number) else { return Ok(value.into()) };
        let Some(quantity) = row.quantity() else { return Ok(value.into()) };
        let shown = DisplayUnit::fixed(quantity, row.unit, 1.0);
        let number = shown.parse(value).map_err(|e| ParameterError::WrongUnit(InputError::new(path, e.to_string())))?;
        Ok(number.to_string().into())
    }

    /// Set the parameter at `path` from the next step on. A number may have a unit: `2.1 GPa`, `0.3
    /// mm`, `70 °F`; a plain number has the parameter's own. Returns the old value as text.
    ///
    /// # Errors
    /// When there is no such parameter, or the value has another kind or is out of range; nothing
    /// changes then.
    pub fn set(&mut self, path: &str, value: &str) -> Result<String, ParameterError> {
        let value = &*self.in_own_unit(path, value)?;
        let Some((id, owner)) = self.resolve(path) else { return Err(self.no_such_parameter(path)) };
        let before = self.value_of(id, owner).unwrap_or_default();
        check(id, path, value)?;
        if before.is_empty() && matches!(id, Id::Damping | Id::DampingRatio) {
            let other = if id == Id::Damping { "damping_ratio" } else { "damping" };
            let problem = format!("does nothing to this sheet, which has {other}");
            return Err(ParameterError::Refused(InputError::new(path, problem)));
        }
        let set = match (owner, accessor(id)) {
            (Owner::Source(name), _) => self.set_source(id, name, path, value),
            (Owner::World, Some(Global(_, set))) => set(self, path, value),
            (Owner::Sheet(index), Some(SheetText(_, set))) => set(self, index, path, value),
            (Owner::Sheet(index), Some(Accessor::Sheet(_, set))) => {
                number(path, value).and_then(|value| set(&mut self.sheets[index], value))
            }
            _ => return Err(self.no_such_parameter(path)),
        };
        // The setter names its field; the caller knows the path.
        let kind =
            if id.row().kind == ParameterKind::Name { ParameterError::WrongKind } else { ParameterError::Refused };
        set.map(|()| before).map_err(|e| kind(InputError::new(path, e.problem)))
    }

    /// Parameter and object at `path`; `None` when the world has no such object or parameter.
    fn resolve<'a>(&self, path: &'a str) -> Option<(Id, Owner<'a>)> {
        let id = Id::from_whole_path(path).filter(|id| id.row().scope != ParameterScope::Scene)?;
        let object = if id.row().path.contains('*') { path.split('.').nth(1)? } else { "" };
        match accessor(id) {
            Some(Global(get, _)) => get(self).map(|_| (id, Owner::World)),
            Some(_) => {
                let by_name = self.sheets.iter().position(|s| s.name == object);
                let index = by_name.or_else(|| object.parse().ok()).filter(|i| *i < self.sheets.len())?;
                Some((id, Owner::Sheet(index)))
            }
            None => {
                let heat = self.heat.as_ref()?;
                heat.parameters().any(|p| (p.0, p.1) == (id, object)).then_some((id, Owner::Source(object)))
            }
        }
    }

    /// Present value of a parameter; `None` where the object has none.
    fn value_of(&self, id: Id, owner: Owner) -> Option<String> {
        match owner {
            Owner::World => match accessor(id)? {
                Global(get, _) => get(self),
                _ => None,
            },
            Owner::Sheet(index) => sheet_text(&self.sheets[index], accessor(id)?),
            Owner::Source(name) => {
                let mut all = self.heat.as_ref()?.parameters();
                all.find(|p| (p.0, p.1) == (id, name)).map(|p| source_text(id, p.2))
            }
        }
    }

    /// Set a parameter of a heat source.
    fn set_source(&mut self, id: Id, name: &str, path: &str, value: &str) -> Result<(), InputError> {
        let value = if id.row().kind == ParameterKind::Boolean {
            f64::from(u8::from(boolean(path, value)?))
        } else {
            number(path, value)?
        };
        if let Some(heat) = &mut self.heat {
            heat.set_parameter(id, name, value);
        }
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }
}

/// Check kind and range of the text of a value; the setter checks a name.
fn check(id: Id, path: &str, value: &str) -> Result<(), ParameterError> {
    let numbers = match id.row().kind {
        ParameterKind::Number => number(path, value).map(|v| vec![v]),
        ParameterKind::Optional => optional(path, value).map(|v| v.into_iter().collect()),
        ParameterKind::Vector => vector(path, value).map(|v| v.to_array().to_vec()),
        ParameterKind::OptionalVector if value != "none" => vector(path, value).map(|v| v.to_array().to_vec()),
        ParameterKind::Boolean => boolean(path, value).map(|_| Vec::new()),
        _ => Ok(Vec::new()),
    };
    let mut numbers = numbers.map_err(ParameterError::WrongKind)?.into_iter();
    numbers.try_for_each(|v| id.check(path, v)).map_err(ParameterError::OutOfRange)
}

/// Value and setter of a parameter; `None` for one of a heat source.
fn accessor(id: Id) -> Option<&'static Accessor> {
    ACCESSORS.iter().find(|row| row.0 == id).map(|row| &row.1)
}

/// Value of a parameter of a sheet as text.
fn sheet_text(sheet: &Sheet, accessor: &Accessor) -> Option<String> {
    match accessor {
        Accessor::Sheet(get, _) => get(sheet).map(|value| value.to_string()),
        SheetText(get, _) => get(sheet),
        Global(..) => None,
    }
}

/// Value of a parameter of a heat source as text.
fn source_text(id: Id, value: f64) -> String {
    if id.row().kind == ParameterKind::Boolean { (value >= 0.5).to_string() } else { value.to_string() }
}

fn vector_text(v: DVec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

fn optional_text(value: Option<f64>) -> String {
    value.map_or_else(|| "none".to_owned(), |value| value.to_string())
}

/// Parse a grid, as `21x11`.
fn grid(path: &str, value: &str) -> Result<Grid, InputError> {
    let text = value.trim_matches('"');
    let two = text.split_once('x').and_then(|(u, v)| Some((u.trim().parse().ok()?, v.trim().parse().ok()?)));
    two.ok_or_else(|| InputError::new(path, format!("\"{text}\" is no grid: masses along length and width, as 21x11")))
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

/// Parse a number or `none`.
fn optional(path: &str, value: &str) -> Result<Option<f64>, InputError> {
    if value == "none" { Ok(None) } else { number(path, value).map(Some) }
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
            let now: f64 = world.get(path).expect("known").value.parse().expect("a number");
            assert!((now / wanted - 1.0).abs() < 1e-12, "{path}: {now}");
        }
        for (path, value, kind) in [
            ("no.such", "1", "UnknownPath"),
            ("dt", "3 GPa", "WrongUnit"),
            ("dt", "soon", "WrongKind"),
            ("engine", "steam", "WrongKind"),
            ("gravity", "(0, 1)", "WrongKind"),
            ("dt", "2", "OutOfRange"),
            ("gravity", "(0, 1e9, 0)", "OutOfRange"),
            ("sheets.card.damping", "0.1", "Refused"),
        ] {
            let error = world.set(path, value).expect_err(path);
            assert!(format!("{error:?}").starts_with(kind), "{path} = {value}: {error:?}");
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
