//! Defaults of the parameters, read from the specifications.

use serde_json::Value;

use crate::scene::{HeatGunSpec, HeaterSpec, Material, MaterialChoice, OvenSpec, Room, Scene, SheetSpec};
use crate::units::parameters::{DefaultSource, ParameterRow};

impl ParameterRow {
    /// Default in a scene file, as text that [`Scene::with_override`] accepts; `None` for a field
    /// without default.
    pub fn default_text(&self) -> Option<String> {
        let path = match self.default {
            DefaultSource::Required => return None,
            DefaultSource::Text(text) => return Some(text.to_owned()),
            DefaultSource::SameAs(path) => path.to_owned(),
            DefaultSource::Field => self.path_of("0"),
        };
        let tree = serde_json::to_value(reference()).ok()?;
        let field = path.split('.').try_fold(&tree, |at, name| match at {
            Value::Array(items) => items.get(name.parse::<usize>().ok()?),
            other => other.get(name),
        });
        text(field?)
    }
}

/// Scene with one object of each kind that has a default.
fn reference() -> Scene {
    Scene {
        room: Some(Room { x: (-1.0, 1.0), y: (0.0, 1.0), z: (-1.0, 1.0), grid: Room::default_grid(), back_wall: true }),
        oven: Some(OvenSpec::default()),
        heat_gun: Some(HeatGunSpec::default()),
        heaters: vec![HeaterSpec::default()],
        sheets: vec![SheetSpec { material: MaterialChoice::Inline(Material::default()), ..SheetSpec::default() }],
        ..Scene::default()
    }
}

fn text(value: &Value) -> Option<String> {
    Some(match value {
        Value::Null => "none".to_owned(),
        Value::String(name) => name.clone(),
        Value::Array(items) => format!("({})", items.iter().map(text).collect::<Option<Vec<_>>>()?.join(", ")),
        Value::Object(_) => return None,
        plain => plain.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_a_value_of_its_parameter_and_the_default_of_its_field() {
        for row in ParameterRow::all() {
            let text = row.default_text();
            assert_eq!(text.is_none(), row.default == DefaultSource::Required, "{row:?}");
            let Some(text) = text else { continue };
            let parts = text.trim_matches(['(', ')']).split(", ").filter_map(|part| part.parse::<f64>().ok());
            for number in parts {
                let (min, max) = row.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                assert!((min..=max).contains(&number), "{row:?}: {number}");
            }
            if row.default == DefaultSource::Field && !row.path.starts_with("heaters.") {
                let scene = Scene { heaters: Vec::new(), ..reference() };
                let set = scene.with_override(&row.path_of("0"), &text);
                assert_eq!(set.unwrap_or_else(|e| panic!("{e}")), scene, "{row:?}: {text}");
            }
        }
    }
}
