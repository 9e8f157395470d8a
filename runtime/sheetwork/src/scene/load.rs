//! Reading and writing of scene files, and overriding of any field by path.

use std::path::{Path, PathBuf};

use ron::extensions::Extensions;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::error::{InputError, SceneError, range_text, reject_if};
use crate::scene::{MaterialChoice, Scene, library, literal, locate, nesting, validate};
use crate::units::parameters::ParameterId;
use crate::units::quantity;

fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

/// Read a RON text and check its values; errors have line, field and the text found.
pub(crate) fn read_ron<T: DeserializeOwned>(
    text: &str,
    check: impl Fn(&T) -> Result<(), InputError>,
) -> Result<T, SceneError> {
    nesting::check(text).map_err(SceneError::Syntax)?;
    let mut reader = ron::Deserializer::from_str_with_options(text, &options())
        .map_err(|e| SceneError::Syntax(InputError::new("", e.code.to_string()).at_line(e.span.start.line)))?;
    let value: T = serde_path_to_error::deserialize(&mut reader).map_err(|e| {
        let field = e.path().to_string().replace('[', ".").replace(']', "");
        let field = if field == "." { String::new() } else { field };
        let at = reader.span_error(e.into_inner());
        let (line, bad) = (at.span.start.line, locate::first_bad_number(text));
        let bad = bad.filter(|(field, _)| locate::line_of(text, field) == line).map(not_plain);
        let found = locate::value_of(text, &field).map_or_else(String::new, |v| format!(", found {v}"));
        SceneError::Syntax(bad.unwrap_or_else(|| InputError::new(field, format!("{}{found}", at.code))).at_line(line))
    })?;
    reader.end().map_err(|e| {
        let at = reader.span_error(e);
        SceneError::Syntax(InputError::new("", at.code.to_string()).at_line(at.span.start.line))
    })?;
    check(&value).map_err(|e| {
        let line = locate::line_of(text, &e.field);
        SceneError::Value(e.at_line(line))
    })?;
    Ok(value)
}

/// Error of `number`, which has a unit or is not finite, with the range of its field.
fn not_plain((field, number): (String, String)) -> InputError {
    let row = ParameterId::from_path(&field).map(ParameterId::row);
    let range = row.and_then(|row| Some(format!(" ({})", range_text(row.range?, row.unit)))).unwrap_or_default();
    InputError::new(field, format!("\"{number}\" is not a plain number{range}"))
}

impl Scene {
    /// Read and check a scene file.
    ///
    /// # Errors
    /// When it cannot be opened, is not RON, has an unknown or ill-typed field, or a value out of
    /// range: with file, line and field.
    pub fn load(file: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(file).map_err(|e| SceneError::File(library::unreadable(file, &e)))?;
        let mut scene = Self::parse(&text).map_err(|e| e.map(|e| of_another_kind(file, e).in_file(file)))?;
        scene.base = file.parent().map(Path::to_path_buf).unwrap_or_default();
        scene.file = Some(file.to_path_buf());
        Ok(scene)
    }

    /// Read and check a scene from text. File names in it are relative to the working directory.
    ///
    /// # Errors
    /// As [`Scene::load`], without the file.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        read_ron(text, validate::scene)
    }

    /// Text of the scene as a file. Reading it gives the same scene.
    ///
    /// # Errors
    /// The error of the serialiser, which does not occur for a scene that was read or checked.
    pub fn to_text(&self) -> Result<String, InputError> {
        options()
            .to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(6))
            .map_err(|e| InputError::new("", e.to_string()))
    }

    /// The scene with the field at `path` set to `value`, a RON or JSON scalar, tuple or list.
    ///
    /// `sheets` and `bodies` may be addressed by index or by name: `sheets.0.material.young`,
    /// `sheets.strip.damping`.
    ///
    /// # Errors
    /// When there is no such field, or the value has the wrong type or is out of range.
    pub fn with_override(&self, path: &str, value: &str) -> Result<Self, SceneError> {
        self.with_overrides(&[(path, value)])
    }

    /// The scene with several fields set: pairs of path and value as for
    /// [`Scene::with_override`], in any order. A field is set before the fields inside it; of two
    /// values of one field the later one stands.
    ///
    /// # Errors
    /// As [`Scene::with_override`]; values that depend on one another are checked together.
    pub fn with_overrides(&self, overrides: &[(&str, &str)]) -> Result<Self, SceneError> {
        let mut outer_first = overrides.to_vec();
        outer_first.sort_by_key(|(path, _)| path.matches('.').count());
        let mut scene = self.clone();
        for (path, value) in outer_first {
            scene = scene.with_unchecked(path, value)?;
        }
        validate::scene(&scene).map_err(SceneError::Value)?;
        Ok(scene)
    }

    /// The scene with a value of the right type, not validated.
    fn with_unchecked(&self, path: &str, value: &str) -> Result<Self, SceneError> {
        if value.trim().trim_start_matches(['+', '-']).parse::<f64>().is_ok_and(|v| !v.is_finite()) {
            return Err(SceneError::Value(InputError::new(path, format!("{value} is not a finite number"))));
        }
        let with_unit = quantity::in_si(path, value.trim()).map_err(SceneError::Value)?;
        let parsed = typed(with_unit.as_deref().unwrap_or(value.trim()));
        let mut tree =
            serde_json::to_value(self).map_err(|e| SceneError::Value(InputError::new(path, e.to_string())))?;
        *slot(&mut tree, path, &self.base).map_err(SceneError::UnknownField)? = parsed;
        let mut scene: Self = serde_path_to_error::deserialize(tree).map_err(|e| {
            let bad = locate::first_bad_number(value).filter(|(place, _)| !place.is_empty());
            let bad = bad.map(|(place, number)| not_plain((format!("{path}.{place}"), number)));
            let other = || InputError::new(path, format!("{value} cannot be used: {}", e.into_inner()));
            SceneError::Value(bad.unwrap_or_else(other))
        })?;
        scene.base.clone_from(&self.base);
        scene.file.clone_from(&self.file);
        Ok(scene)
    }

    /// Error of building the scene, with the line of its field in the scene's file. An error of
    /// another file keeps its place.
    pub(crate) fn located(&self, error: InputError) -> InputError {
        let Some(file) = self.file.as_ref().filter(|_| error.file.is_none() && !error.field.is_empty()) else {
            return error;
        };
        // The file is read again only in case of an error; scenes are small.
        let line = std::fs::read_to_string(file).ok().map(|text| locate::line_of(&text, &error.field));
        InputError { file: Some(file.clone()), line, ..error }
    }

    /// Path of the file `name` of the scene.
    pub fn resolve(&self, name: &Path) -> PathBuf {
        self.base.join(name)
    }
}

/// Error of a scene's text, with the kind of file that its extension suggests.
fn of_another_kind(file: &Path, error: InputError) -> InputError {
    let ending = file.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let kind = match ending.as_str() {
        "sht" => "a sheet; a scene has it as `sheets: [(file: \"...\")]`",
        "pol" => "polyhedra; a scene has them as `bodies: [(shape: File(\"...\"))]`",
        "heater" => "a heater; a scene has it as `heaters: [(file: \"...\")]`",
        "swr" => "a recording",
        _ => return error,
    };
    InputError::new("", format!("is no scene but, by its name, {kind}"))
}

/// Value as typed on a command line: RON, or else bare words as a string; `none` for an absent
/// field.
fn typed(value: &str) -> Value {
    literal::value_of(value).unwrap_or_else(|| Value::String(value.trim_matches('"').to_owned()))
}

/// Place in `tree` at `path`.
fn slot<'a>(tree: &'a mut Value, path: &str, base: &Path) -> Result<&'a mut Value, InputError> {
    let mut at = tree;
    let mut walked = String::new();
    for name in path.split('.') {
        if walked.ends_with("material") && at.is_string() {
            // A material given by name or file is expanded when one of its constants is set.
            let named = MaterialChoice::from(at.as_str().unwrap_or_default()).resolve(base)?;
            *at = serde_json::to_value(named).map_err(|e| InputError::new(path, e.to_string()))?;
        }
        let free_keys = walked.ends_with("probes");
        at = match at {
            Value::Array(items) => {
                let count = items.len();
                let index = name.parse().ok().or_else(|| items.iter().position(|i| i["name"] == name));
                index.and_then(|i: usize| items.get_mut(i)).ok_or_else(|| {
                    let problem =
                        format!("{walked} has no \"{name}\": it has {count} items, by number from 0 or by name");
                    InputError::new(path, problem)
                })?
            }
            Value::Object(fields) => {
                let names = fields.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                let is_unknown = !fields.contains_key(name) && !free_keys;
                reject_if!(is_unknown, path, "there is no field \"{name}\"; there are {names}");
                fields.entry(name).or_insert(Value::Null)
            }
            _ => return Err(InputError::new(path, format!("{walked} has no fields"))),
        };
        walked = if walked.is_empty() { name.to_owned() } else { format!("{walked}.{name}") };
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let text = r#"(engine: "euler-richardson", dt: 0.001,
            sheets: [(name: "strip", structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "hips", springs: Uniform,
                probes: {"tip": (1.0, 0.5)})])"#;
        Scene::parse(text).expect("valid")
    }

    #[test]
    fn a_scene_written_and_read_again_is_the_same() {
        let mut scene = scene();
        scene.sheets[0].flexion_limit = None;
        scene.bodies = vec![];
        let text = scene.to_text().expect("serialisable");
        assert_eq!(Scene::parse(&text).expect("valid"), scene);
    }

    #[test]
    fn errors_name_line_field_value_and_range() {
        let error = Scene::parse("(\n  dt: 0.001,\n  sheets: [\n    (damping: -3.0),\n  ],\n)").expect_err("negative");
        assert_eq!(error.line, Some(4));
        assert_eq!(error.field, "sheets.0.damping");
        assert!(error.problem.contains("-3") && error.problem.contains("0 to 10"), "{error}");
        let error = Scene::parse("(\n  sheets: [\n    (dampin: 0.1),\n  ],\n)").expect_err("unknown field");
        assert_eq!(error.line, Some(3));
        assert!(error.to_string().contains("dampin"), "{error}");
        let error = Scene::parse("(\n  dt: \"soon\",\n)").expect_err("wrong type");
        assert_eq!((error.line, error.field.as_str()), (Some(2), "dt"));
        assert_eq!(error.problem, "Expected float, found \"soon\"");
        let error = Scene::parse("(\n  gravity: (0, NaN, 0),\n)").expect_err("NaN");
        assert_eq!((error.line, error.field.as_str()), (Some(2), "gravity.1"));
        let error = Scene::parse("(engine: \"euler-kramer\")").expect_err("no such engine");
        assert!(error.problem.contains("euler-cromer"), "{error}");
        assert!(Scene::parse("(dt: 0.001) trailing").is_err());
    }

    #[test]
    fn any_field_can_be_overridden_by_index_or_name() {
        let scene = scene();
        let set = |path: &str, value: &str| scene.with_override(path, value).expect("valid");
        let young = |s: &Scene| s.sheets[0].material.resolve(Path::new("")).expect("material").young;
        assert_eq!(young(&set("sheets.0.material.young", "2e9")), 2e9);
        assert_eq!(young(&set("sheets.strip.material.young", "3000")), 3000.0);
        assert_eq!(set("gravity", "(0, -1.62, 0)").gravity.y, -1.62);
        assert_eq!(set("gravity.1", "-1").gravity.y, -1.0);
        assert_eq!(set("engine", "rk4").engine.name(), "rk4");
        assert_eq!(set("sheets.0.grid", "(5, 3, 4)").sheets[0].grid, (5, 3, 4));
        assert_eq!(set("sheets.0.structure", "samm").sheets[0].structure.name(), "samm");
        assert_eq!(set("sheets.0.node_mass", "4e-4").sheets[0].node_mass, Some(4e-4));
        let pinned = set("sheets.0.pins", "[(region: Left), (region: Point(1, 0.5), path: [(time: 1)])]");
        assert_eq!(pinned.sheets[0].pins.len(), 2);
        let scene = set("bodies", "[(name: \"ball\", shape: Ball(0.01)), (shape: HalfSpace)]");
        assert_eq!(scene.bodies[0].shape, crate::scene::Shape::Ball(0.01));
        let scene = scene.with_override("bodies.ball.shape", "Box((0.1, 0.2, 0.3))").expect("valid");
        assert_eq!(scene.bodies[0].shape, crate::scene::Shape::Box(glam::DVec3::new(0.1, 0.2, 0.3)));
        assert_eq!(set("sheets.0.probes.mid", "(0.5, 0.5)").sheets[0].probes["mid"], (0.5, 0.5));
    }

    #[test]
    fn the_order_of_overrides_does_not_matter() {
        let (layers, grid) = (("sheets.0.structure", "provot2d"), ("sheets.0.grid", "(5, 1, 5)"));
        let (whole, part) = (("sheets.0.material", "card"), ("sheets.0.material.young", "1e9"));
        let scene = scene();
        let one = scene.with_overrides(&[layers, part, grid, whole]).expect("valid");
        assert_eq!(one, scene.with_overrides(&[whole, grid, part, layers]).expect("valid"));
        assert_eq!(one.sheets[0].grid, (5, 1, 5));
        assert_eq!(one.sheets[0].material.resolve(Path::new("")).expect("material").young, 1e9);
        assert_eq!(scene.with_overrides(&[("dt", "0.1"), ("dt", "0.002")]).expect("valid").dt, 0.002);
        assert!(scene.with_overrides(&[layers]).is_err(), "two layers");
    }

    #[test]
    fn a_bad_override_is_refused_by_name() {
        let scene = scene();
        let refuse = |path: &str, value: &str| scene.with_override(path, value).expect_err("bad");
        assert!(refuse("sheets.0.material.yung", "2e9").problem.contains("young"));
        assert!(refuse("sheets.7.damping", "0.1").problem.contains("1 items"));
        assert_eq!(refuse("sheets.0.damping", "-1").field, "sheets.0.damping");
        assert!(matches!(refuse("sheets.7.damping", "0.1"), SceneError::UnknownField(_)));
        assert!(matches!(refuse("sheets.0.damping", "-1"), SceneError::Value(_)));
        assert!(matches!(Scene::parse("(dt: soon)"), Err(SceneError::Syntax(_))));
        assert!(matches!(Scene::load(Path::new("no such.ron")), Err(SceneError::File(_))));
        assert!(refuse("dt", "NaN").problem.contains("finite"));
        assert!(refuse("dt", "inf").problem.contains("finite"));
        assert!(refuse("sheets.0.grid", "7").problem.contains('7'));
    }
}
