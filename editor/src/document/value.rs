//! Values of a scene's fields as text, by path: initial values, values of a material's preset,
//! changed values.

use std::collections::BTreeMap;

use serde_json::Value;
use sheetwork::scene::{MaterialChoice, Scene, material};

/// Scene as a tree, with the constants of its materials.
fn tree(scene: &Scene) -> Value {
    let mut scene = scene.clone();
    for sheet in &mut scene.sheets {
        if let Ok(found) = sheet.material.resolve(&scene.base) {
            sheet.material = MaterialChoice::Inline(found);
        }
    }
    // A scene that was parsed can be serialised.
    serde_json::to_value(&scene).unwrap_or(Value::Null)
}

/// Value in the notation of parameters: vectors in round brackets, `none` for an absent value.
fn text(value: &Value) -> Option<String> {
    Some(match value {
        Value::Null => "none".to_owned(),
        Value::Bool(yes) => yes.to_string(),
        Value::Number(n) => n.to_string(),
        Value::String(s) => s.clone(),
        Value::Array(items) => format!("({})", items.iter().map(text).collect::<Option<Vec<_>>>()?.join(", ")),
        Value::Object(_) => return None,
    })
}

/// Value at `path` (lists by index); `None` where there is no such field.
pub fn at(scene: &Scene, path: &str) -> Option<String> {
    let all = tree(scene);
    let found = path.split('.').try_fold(&all, |at, name| match at {
        Value::Array(items) => items.get(name.parse::<usize>().ok()?),
        Value::Object(fields) => fields.get(name),
        _ => None,
    });
    text(found?)
}

/// Value of the preset of a sheet's material at `path`, `sheets.N.material.X`; `None` for another
/// path or an unnamed material.
pub fn of_preset(scene: &Scene, path: &str) -> Option<String> {
    let (index, field) = path.strip_prefix("sheets.")?.split_once(".material.")?;
    let sheet = scene.sheets.get(index.parse::<usize>().ok()?)?;
    let preset = material::by_name(&sheet.material.name()).ok()?;
    text(serde_json::to_value(preset).ok()?.get(field)?)
}

/// Fields that differ between two scenes, with the value in the second.
pub fn changed(old: &Scene, new: &Scene) -> Vec<(String, String)> {
    let (old, new) = (leaves(old), leaves(new));
    let differs = |(path, value): &(&String, &String)| old.get(*path) != Some(*value);
    new.iter().filter(differs).map(|(path, value)| (path.clone(), value.clone())).collect()
}

/// All fields with plain values.
fn leaves(scene: &Scene) -> BTreeMap<String, String> {
    fn walk(at: &Value, path: &str, out: &mut BTreeMap<String, String>) {
        let under = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match at {
            Value::Object(fields) => fields.iter().for_each(|(name, value)| walk(value, &under(name), out)),
            Value::Array(items) => items.iter().enumerate().for_each(|(i, v)| walk(v, &under(&i.to_string()), out)),
            plain => _ = text(plain).map(|t| out.insert(path.to_owned(), t)),
        }
    }
    let mut out = BTreeMap::new();
    walk(&tree(scene), "", &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::SheetSpec;

    #[test]
    fn values_are_found_by_path_and_presets_by_the_materials_name() {
        let spec = SheetSpec { material: "hips".into(), ..SheetSpec::thesis() };
        let scene = Scene { sheets: vec![spec], ..Scene::thesis() };
        assert_eq!(at(&scene, "gravity").as_deref(), Some("(0.0, -9.81, 0.0)"));
        assert_eq!(at(&scene, "sheets.0.material.young").as_deref(), Some("2000000000.0"));
        assert_eq!(at(&scene, "sheets.0.friction").as_deref(), Some("none"));
        assert_eq!(at(&scene, "sheets.3.friction"), None);
        let softer = scene.with_override("sheets.0.material.young", "1e9").expect("valid");
        assert_eq!(of_preset(&softer, "sheets.0.material.young").as_deref(), Some("2000000000.0"));
        assert_eq!(of_preset(&softer, "dt"), None);
        assert_eq!(changed(&scene, &softer), [("sheets.0.material.young".into(), "1000000000.0".into())]);
        assert!(changed(&scene, &scene).is_empty());
    }
}
