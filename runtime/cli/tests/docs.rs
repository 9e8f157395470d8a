//! Agreement of `assets/README.md` with the program: it contains every field, name and file, and
//! its examples work.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sheetwork::mesh::structure;
use sheetwork::scene::{HeatMode, HeaterSpec, Scene, Shape, SheetSpec, heater_file, material, pol, sht};
use sheetwork::{InputError, World, integrators};

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

fn readme() -> String {
    std::fs::read_to_string(assets().join("README.md")).expect("assets/README.md")
}

/// Fenced blocks of the README whose first line is `fence`.
fn blocks(text: &str, fence: &str) -> Vec<String> {
    let start = format!("```{fence}\n");
    text.split(&start).skip(1).map(|rest| rest.split("\n```").next().unwrap_or_default().to_owned()).collect()
}

/// A scene with every optional field and non-empty lists, so that its tree has all field names.
fn fullest() -> Scene {
    let text = r#"(
        room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
        camera: (eye: (1, 1, 1), target: (0, 0, 0)),
        sheets: [(
            material: (
                young: 185,
                burgers: (relaxation_time: 1, retardation_time: 1, retarded: 1),
                orthotropic: (
                    young_warp: 1, young_weft: 1, shear: 1, poisson: 0, bending_warp: 1, bending_weft: 1, twist: 1,
                ),
            ),
            velocities: [(region: Left, value: (0, 0, 0))],
            forces: [(region: All, value: (0, 0, 0))],
            pins: [(region: Back, path: [(time: 0)], clamp: true)],
            pressure: [(time: 0, pressure: 1)],
            temperature: 20,
        ), (
            structure: "shell",
            grid: (11, 1, 11),
            outline: Svg(file: "leaf.svg", scale: 0.001, cuts: ["red"], creases: [("blue", 10)]),
            holes: [Disc(centre: (0, 0), radius: 0.004)],
            cuts: [[(0, 0.006), (0, 0.1)]],
            creases: [(from: (0, 0.5), to: (1, 0.5), angle: 10)],
        ), (
            structure: "shell",
            grid: (11, 1, 11),
            detail: (levels: [(grid: (11, 11), within: 1), (grid: (5, 5))]),
        ), (
            structure: "shell",
            grid: (11, 1, 11),
            outline: Disc(radius: 0.1),
            refine: (levels: 2, strain: 0.5),
        )],
        bodies: [(shape: Polyhedron((vertices: [], faces: [])), path: [(time: 0)], temperature_schedule: [(time: 0)])],
        heaters: [(file: "panel.heater"), (size: (1, 1, 1), hot: [(face: 0, temperature: 100)])],
        wind_zones: [(
            gusts: (amplitude: 1, duration: 1, period: 2),
            turbulence: (intensity: 1, length: 1),
            vortex: (circulation: 1, core: 1),
            blast: (time: 0, overpressure: 1000, radius: 1, duration: 0.01),
            fluid: (density: 1000, surface: 0),
        )],
        oven: (schedule: [(time: 0, temperature: 100)]),
        heat_gun: (path: [(time: 0)]),
    )"#;
    let scene = Scene::parse(text).expect("valid");
    // Refused in a file, as the bodies have temperatures.
    Scene { heat_mode: HeatMode::Thesis { sensitivity: 1.0, conductivity: 0.0 }, ..scene }
}

fn names(tree: &Value, found: &mut BTreeSet<String>) {
    match tree {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| {
            found.insert(name.clone());
            names(value, found);
        }),
        Value::Array(items) => items.iter().for_each(|item| names(item, found)),
        _ => {}
    }
}

#[test]
fn every_field_of_a_scene_is_documented() {
    let readme = readme();
    let mut fields = BTreeSet::new();
    names(&serde_json::to_value(fullest()).expect("a tree"), &mut fields);
    assert!(fields.len() > 60, "the scene is not full: {fields:?}");
    let missing: Vec<_> = fields.iter().filter(|f| !readme.contains(&format!("`{f}`"))).collect();
    // Enum variants are documented with their content: `Polyhedron((...))`.
    let missing: Vec<_> = missing.into_iter().filter(|f| !readme.contains(&format!("`{f}("))).collect();
    assert!(missing.is_empty(), "not in assets/README.md: {missing:?}");
}

#[test]
fn every_field_is_in_the_table_of_its_struct() {
    let readme = readme();
    let section = |title: &str| -> String {
        let start = readme.find(&format!("\n{title}\n")).unwrap_or_else(|| panic!("no section {title}"));
        let rest = &readme[start + title.len() + 2..];
        rest.split("\n#").next().unwrap_or_default().to_owned()
    };
    let tree = serde_json::to_value(fullest()).expect("a tree");
    let check = |title: &str, value: &Value| {
        let text = section(title);
        for field in value.as_object().expect("a struct").keys() {
            assert!(text.contains(&format!("`{field}`")), "{field} is not in \"{title}\"");
        }
    };
    check("### Scene", &tree);
    check("#### Air", &tree["air"]);
    check("#### Wind zone", &tree["wind_zones"][0]);
    for part in ["gusts", "turbulence", "vortex", "blast", "fluid"] {
        check("#### Wind zone", &tree["wind_zones"][0][part]);
    }
    check("#### Room", &tree["room"]);
    check("### Sheet", &tree["sheets"][0]);
    check("#### Pin", &tree["sheets"][0]["pins"][0]);
    check("### Material", &tree["sheets"][0]["material"]);
    check("#### Creases, curl, yield and creep", &tree["sheets"][1]["creases"][0]);
    check("#### Levels of detail", &tree["sheets"][2]["detail"]);
    check("#### Levels of detail", &tree["sheets"][2]["detail"]["levels"][0]);
    check("#### Local refinement", &tree["sheets"][3]["refine"]);
    check("### Body", &tree["bodies"][0]);
    check("### Heater", &tree["heaters"][1]);
    check("#### Oven", &tree["oven"]);
    check("#### Heat gun", &tree["heat_gun"]);
    check("#### Path", &tree["bodies"][0]["path"][0]);
}

#[test]
fn every_choice_is_documented() {
    let readme = readme();
    let mut wanted: Vec<String> = Vec::new();
    wanted.extend(structure::TABLE.iter().map(|s| format!("| `{}` |", s.name)));
    wanted.extend(integrators::TABLE.iter().map(|e| format!("| `{}` |", e.name)));
    wanted.extend(material::LIBRARY.iter().map(|(name, _, _)| format!("| `{name}` |")));
    for part in [
        "All",
        "Left",
        "Right",
        "Back",
        "Front",
        "Border",
        "Uniform",
        "Length",
        "Calibrated",
        "HalfSpace",
        "Physical",
        "Everywhere",
        "Plate",
    ] {
        wanted.push(format!("`{part}`"));
    }
    for part in ["Disc", "RoundedRectangle", "Path", "Svg"] {
        wanted.push(format!("`{part}("));
    }
    for part in ["Point", "Rect", "Masses", "File", "Part", "Polyhedron", "Box", "Ball"] {
        wanted.push(format!("`{part}("));
    }
    for kind in [
        "first_contact",
        "slid_off",
        "flat",
        "at_rest",
        "woke",
        "unstable",
        "contained",
        "recovered",
        "given_up",
        "torn",
    ] {
        wanted.push(format!("| `{kind}` |"));
    }
    let missing: Vec<_> = wanted.iter().filter(|w| !readme.contains(w.as_str())).collect();
    assert!(missing.is_empty(), "not in assets/README.md: {missing:?}");
}

#[test]
fn the_table_of_materials_equals_the_library() {
    let readme = readme();
    for (name, _, m) in material::LIBRARY {
        let row = readme.lines().find(|l| l.starts_with(&format!("| `{name}` |"))).expect("a row");
        let cells = row.split('|').filter_map(|c| c.trim().parse::<f64>().ok()).collect::<Vec<_>>();
        let mut constants = vec![m.young, m.poisson, m.density, m.thickness];
        constants.extend([m.specific_heat, m.conductivity, m.emissivity, m.expansion, m.damping_ratio]);
        constants.extend(m.yield_stress.iter().chain(&m.glass_transition));
        assert_eq!(cells, constants, "{name}");
    }
}

#[test]
fn the_table_of_defaults_equals_the_defaults() {
    let readme = readme();
    let tree = serde_json::to_value(Scene { sheets: vec![SheetSpec::default()], ..Scene::default() }).expect("a tree");
    for (fields, value) in [
        (["dt", "tolerance", "duration", "ambient_temperature", "contact_conductance", "time_lapse"].as_slice(), &tree),
        (["gap", "damping", "flexion_stiffness"].as_slice(), &tree["sheets"][0]),
    ] {
        for field in fields {
            assert_eq!(number(&tabled_default(&readme, field)), value[*field].as_f64(), "{field}");
        }
    }
    let of_sheets = readme.split("\n### Sheet\n").nth(1).expect("a section");
    let (spec, sheet) = (SheetSpec::default(), &tree["sheets"][0]);
    for (text, field, wanted) in [
        (&*readme, "engine", format!("`{}`", tree["engine"])),
        (of_sheets, "structure", format!("`{}`", sheet["structure"])),
        (of_sheets, "material", format!("`{}`", sheet["material"])),
        (of_sheets, "springs", format!("`{:?}`", spec.springs)),
        (of_sheets, "grid", format!("{:?}", spec.grid)),
        (of_sheets, "size", format!("{:?}", spec.size)),
    ] {
        assert_eq!(tabled_default(text, field), wanted, "{field}");
    }
}

/// Default of the first row of a field in the tables.
fn tabled_default(readme: &str, field: &str) -> String {
    let row = readme.lines().find(|l| l.starts_with(&format!("| `{field}` |"))).expect("a row");
    row.split('|').nth(4).expect("a column").trim().to_owned()
}

/// Number of a cell, which may be a fraction.
fn number(cell: &str) -> Option<f64> {
    match cell.split_once('/') {
        Some((a, b)) => Some(a.parse::<f64>().ok()? / b.parse::<f64>().ok()?),
        None => cell.parse().ok(),
    }
}

#[test]
fn every_file_is_mentioned_and_valid() {
    let readme = readme();
    let mut seen = 0;
    for folder in ["scenes", "sheets", "polyhedra", "heaters", "materials"] {
        for entry in std::fs::read_dir(assets().join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = format!("{folder}/{}", path.file_name().and_then(|n| n.to_str()).expect("a name"));
            assert!(readme.contains(&format!("`{name}`")), "{name} is not in assets/README.md");
            let valid = match folder {
                "scenes" => Scene::load(&path).map_err(InputError::from).and_then(|scene| {
                    let _: () = drop(World::new(&scene)?);
                    Ok(())
                }),
                "sheets" => sht::read_sht_file(&path).and_then(|f| sheetwork::sheet::from_file(&f)).map(drop),
                "materials" => material::read_material_file(&path).map(drop),
                "polyhedra" => pol::read_pol_file(&path).map(drop),
                _ => heater_file::read_heaters_file(&path).map(drop),
            };
            valid.unwrap_or_else(|e| panic!("{e}"));
            seen += 1;
        }
    }
    assert!(seen >= 20, "{seen} files");
}

#[test]
fn mentioned_files_exist() {
    for word in readme().split('`') {
        let folders = ["scenes/", "sheets/", "polyhedra/", "heaters/", "materials/"];
        if folders.iter().any(|f| word.starts_with(f)) {
            assert!(assets().join(word).exists(), "{word} does not exist");
        }
    }
}

#[test]
fn example_scenes_run() {
    let readme = readme();
    let scenes = blocks(&readme, "ron scene");
    assert!(scenes.len() >= 3);
    for text in scenes {
        let scene = Scene::parse(&text).unwrap_or_else(|e| panic!("{e} in\n{text}"));
        let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e} in\n{text}"));
        world.advance(scene.duration.min(0.5));
        assert!(world.unstable().is_none(), "unstable:\n{text}");
        assert_eq!(Scene::parse(&scene.to_text().expect("text")).expect("valid"), scene);
    }
}

#[test]
fn links_point_to_headings() {
    let readme = readme();
    let anchor = |heading: &str| {
        let kept = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
        kept.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect::<String>()
    };
    let anchors: BTreeSet<String> = readme.lines().filter(|l| l.starts_with('#')).map(anchor).collect();
    for link in readme.split("](#").skip(1) {
        let link = link.split(')').next().unwrap_or_default();
        assert!(anchors.contains(link), "no heading for #{link}");
    }
}

#[test]
fn heaters_of_a_scene_are_read() {
    let scene = Scene {
        heaters: vec![HeaterSpec {
            name: String::new(),
            file: Some("heaters/panel.heater".into()),
            polyhedron: None,
            size: None,
            hot: Vec::new(),
            on: true,
            placement: Default::default(),
        }],
        base: assets(),
        ..Scene::default()
    };
    assert!(World::new(&scene).is_ok());
    let body = Shape::Part("polyhedra/two_bodies.pol".into(), 2);
    let text = format!("bodies.0.shape: polyhedron 2 of {}, which holds 2", "polyhedra/two_bodies.pol");
    let spec = Scene::parse("(bodies: [(shape: HalfSpace)])").expect("valid");
    let mut scene = Scene { base: assets(), ..spec };
    scene.bodies[0].shape = body;
    assert_eq!(World::new(&scene).err().map(|e| e.to_string()), Some(text));
}
