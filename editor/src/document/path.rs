//! Field of the scene for a parameter of the world.
//!
//! Both have paths, which mostly coincide. Sheets and heaters without a name have one given by the
//! world; the pressure on a sheet is a list of times in the scene; the temperature of a heater is
//! that of its hot faces.

use sheetwork::scene::{HeaterSpec, HotFaceSpec, PressureKey, Scene};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, ParameterId};

/// Path with the index of a sheet in place of its name.
pub fn numbered(sheets: &[Sheet], path: &str) -> String {
    let found = path.strip_prefix("sheets.").and_then(|rest| {
        let (name, field) = rest.split_once('.')?;
        let index = sheets.iter().position(|s| s.name == name)?;
        Some(format!("sheets.{index}.{field}"))
    });
    found.unwrap_or_else(|| path.to_owned())
}

/// `scene` with the parameter at `path` (sheets by index) set to `value`.
///
/// # Errors
/// When there is no such field, or the value is of another type or out of range.
pub fn with_value(scene: &Scene, path: &str, value: &str) -> Result<Scene, InputError> {
    let parts: Vec<&str> = path.split('.').collect();
    match parts.as_slice() {
        ["sheets", index, "pressure"] => with_pressure(scene, path, index, value),
        ["heaters", name, "temperature"] => with_heater(scene, path, name, value),
        _ => {
            // A body without a name is named by its index in the world.
            let own = path.strip_prefix("bodies.body ").filter(|_| !scene.bodies.iter().any(|b| parts[1] == b.name));
            let path = own.map_or_else(|| path.to_owned(), |rest| format!("bodies.{rest}"));
            // Switches are numbers in the world and booleans in the scene.
            let switch = parts.last() == Some(&"on");
            let value = match value {
                "1" if switch => "true",
                "0" if switch => "false",
                other => other,
            };
            Ok(scene.with_override(&path, value)?)
        }
    }
}

fn number(path: &str, value: &str) -> Result<f64, InputError> {
    let read = value.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    read.ok_or_else(|| InputError::new(path, format!("\"{value}\" is not a finite number")))
}

fn with_pressure(scene: &Scene, path: &str, index: &str, value: &str) -> Result<Scene, InputError> {
    let (mut scene, pressure) = (scene.clone(), number(path, value)?);
    ParameterId::Pressure.check(path, pressure)?;
    let sheet = index.parse().ok().and_then(|i: usize| scene.sheets.get_mut(i));
    let sheet = sheet.ok_or_else(|| InputError::new(path, "there is no such sheet"))?;
    sheet.pressure = if pressure == 0.0 { Vec::new() } else { vec![PressureKey { time: 0.0, pressure }] };
    Ok(scene)
}

/// Index of the heater of that name in the scene.
pub fn heater_index(scene: &Scene, name: &str) -> Option<usize> {
    let by_name = scene.heaters.iter().position(|h| !h.name.is_empty() && h.name == name);
    by_name.or_else(|| name.parse().ok()).filter(|i| *i < scene.heaters.len())
}

fn with_heater(scene: &Scene, path: &str, name: &str, value: &str) -> Result<Scene, InputError> {
    let (mut scene, celsius) = (scene.clone(), number(path, value)?);
    ParameterId::HeaterTemperature.check(path, celsius)?;
    let index = heater_index(&scene, name).ok_or_else(|| InputError::new(path, "there is no such heater"))?;
    let heater = opened(&scene.heaters[index], &scene)?;
    let hot = heater.hot.iter().map(|face| HotFaceSpec { temperature: celsius, ..*face }).collect();
    scene.heaters[index] = HeaterSpec { hot, ..heater };
    Ok(scene)
}

/// Heater with its faces in the scene in place of its file, for edits.
///
/// # Errors
/// When its file cannot be read, or holds several heaters.
pub fn opened(heater: &HeaterSpec, scene: &Scene) -> Result<HeaterSpec, InputError> {
    if heater.file.is_none() {
        return Ok(heater.clone());
    }
    let read = heater.resolve(&scene.base)?;
    let [one] = read.as_slice() else {
        let problem = format!("holds {} heaters: their faces can be changed in the file alone", read.len());
        return Err(InputError::new("file", problem));
    };
    let hot = one.faces.iter().enumerate().filter_map(|(face, f)| {
        let temperature = f.temperature?;
        Some(HotFaceSpec { face: face as u32, temperature, emissivity: f.emissivity })
    });
    Ok(HeaterSpec { file: None, polyhedron: Some(one.polyhedron.clone()), hot: hot.collect(), ..heater.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use sheetwork::World;
    use sheetwork::scene::SheetSpec;

    #[test]
    fn every_parameter_of_a_world_is_a_field_of_its_scene() {
        let scene = Scene::parse(
            r#"(engine: "euler-richardson", dt: 0.001,
                heaters: [(size: (0.1, 0.01, 0.1), hot: [(face: 2, temperature: 300)], placement: (position: (0, 0.2, 0)))],
                oven: (on: false), heat_gun: (on: false),
                bodies: [(shape: Ball(0.01), temperature: 80, placement: (position: (1, 0, 0))),
                    (name: "iron", shape: Ball(0.01), temperature: 80, placement: (position: (2, 0, 0)))],
                sheets: [(structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis", springs: Uniform),
                    (name: "real", structure: "shell", grid: (5, 1, 5), size: (0.025, 0.025), material: "hips",
                        placement: (position: (3, 0, 0))),
                    (structure: "provot2d", grid: (5, 1, 5), size: (0.025, 0.025), material: "thesis", springs: Uniform,
                        placement: (position: (4, 0, 0)))])"#,
        );
        let scene = scene.expect("valid");
        let world = World::new(&scene).expect("valid");
        let parameters = world.parameters();
        assert!(parameters.len() > 40);
        for parameter in parameters {
            let path = numbered(world.sheets(), &parameter.path);
            let set = with_value(&scene, &path, &parameter.value);
            assert!(set.is_ok(), "{}: {set:?}", parameter.path);
        }
    }

    #[test]
    fn parameters_without_a_field_of_their_own_are_mapped_too() {
        let heater = HeaterSpec {
            size: Some(DVec3::splat(0.1)),
            hot: vec![HotFaceSpec { face: 0, temperature: 200.0, emissivity: 0.9 }],
            ..HeaterSpec::default()
        };
        let scene = Scene { heaters: vec![heater], sheets: vec![SheetSpec::thesis()], ..Scene::thesis() };
        let hotter = with_value(&scene, "heaters.0.temperature", "300").expect("there");
        assert_eq!((hotter.heaters[0].hot[0].temperature, hotter.heaters[0].hot[0].emissivity), (300.0, 0.9));
        assert!(!with_value(&scene, "heaters.0.on", "0").expect("there").heaters[0].on);
        let pressed = with_value(&scene, "sheets.0.pressure", "20").expect("there");
        assert_eq!(pressed.sheets[0].pressure, [PressureKey { time: 0.0, pressure: 20.0 }]);
        assert!(with_value(&scene, "sheets.0.pressure", "1e9").is_err());
        assert!(with_value(&scene, "heaters.7.temperature", "30").is_err());
        assert!(with_value(&scene, "heaters.0.temperature", "hot").is_err());
    }
}
