//! `generate` and `list`.

use super::common::{TestFolder, keys};

/// Structure, grid, nodes, springs; those of the thesis first.
const COUNTS: &[(&str, &str, u64, u64)] = &[
    ("samm", "5x3x4", 52, 175),
    ("samm", "11x2x11", 221, 800),
    ("slamm", "11x2x11", 221, 981),
    ("trimm", "8x2x8", 113, 428),
    ("trimm", "11x2x11", 221, 881),
    ("trimm", "14x2x14", 365, 1496),
    ("trimm", "17x2x17", 545, 2273),
    ("double-diagonal", "11x2x11", 221, 1162),
    ("provot2d", "11x1x11", 121, 618),
    ("provot3d", "11x2x11", 221, 1520),
    ("provot-trimm", "11x2x11", 221, 1384),
];

#[test]
fn counts_are_those_of_the_thesis() {
    let place = TestFolder::new("counts");
    for (structure, grid, masses, springs) in COUNTS {
        let found = place.json(&["generate", "--structure", structure, "--grid", grid, "--json"]);
        assert_eq!(found["structure"], *structure);
        assert_eq!(
            (found["masses"].as_u64(), found["springs"].as_u64()),
            (Some(*masses), Some(*springs)),
            "{structure}"
        );
    }
}

#[test]
fn a_written_sheet_is_read_by_a_scene_with_the_same_counts() {
    let place = TestFolder::new("written");
    for (structure, grid, masses, springs) in COUNTS {
        let file = format!("{structure}-{grid}.sht");
        let ran = place.run(&["generate", "--structure", structure, "--grid", grid, "-o", &file]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        let scene = format!(
            r#"(engine: "euler-richardson", dt: 0.001, duration: 0.002,
                sheets: [(name: "leaf", file: "{file}", material: "thesis")])"#
        );
        let report = place.json(&["run", place.write("file.ron", &scene), "--json"]);
        let sheet = &report["sheets"][0];
        assert_eq!(sheet["structure"], *structure);
        assert_eq!((sheet["masses"].as_u64(), sheet["springs"].as_u64()), (Some(*masses), Some(*springs)), "{file}");
    }
}

#[test]
fn generated_card_scenes_are_valid() {
    let place = TestFolder::new("cards");
    for (deck, cards) in [("pack", 52), ("house", 15), ("house-ball", 15)] {
        let file = place.path("cards.ron");
        let ran = place.run(&["generate", "--cards", deck, "-o", "cards.ron"]);
        assert_eq!((ran.status, ran.out.trim()), (Some(0), format!("{cards} cards").as_str()), "{}", ran.err);
        let scene = sheetwork::scene::Scene::load(&file).expect("valid");
        assert_eq!(scene.sheets.len(), cards, "{deck}");
        let found = place.json(&["generate", "--cards", deck, "--json"]);
        assert_eq!(found["cards"], cards);
    }
    place.expect_rejection(&["generate", "--cards", "poker"], &["poker", "house"]);
    place.expect_rejection(&["generate", "--cards", "pack", "--structure", "samm"], &["--structure"]);
    place.expect_rejection(&["generate"], &["--structure"]);
}

#[test]
fn a_written_sheet_moves_like_the_generated_one() {
    let place = TestFolder::new("same");
    let base = ["generate", "--structure", "slamm", "--grid", "7x2x6", "--node-mass", "4e-4", "--output", "leaf.sht"];
    assert_eq!(place.run(&[&base[..], &["--inter-layer", "Planar"]].concat()).status, Some(0));
    let fields = "node_mass: 4e-4, velocities: [(region: Left, value: (0, 0.1, 0))], probes: {\"tip\": (1, 0.3)}";
    let run = |sheet: &str| {
        let scene = format!(
            r#"(engine: "euler-richardson", dt: 0.01, duration: 0.5, sheets: [({sheet}, material: "thesis", {fields})])"#
        );
        let tip = &place.json(&["run", place.write("scene.ron", &scene), "--json"])["sheets"][0]["probes"]["tip"];
        [0, 1, 2].map(|axis| tip[axis].as_f64().expect("a number"))
    };
    let made = "structure: \"slamm\", grid: (7, 2, 6), size: (0.025, 0.025), springs: Uniform";
    let (read, made) = (run("file: \"leaf.sht\""), run(made));
    assert!(read.iter().zip(made).all(|(a, b)| (a - b).abs() < 1e-12), "{read:?} {made:?}");
}

#[test]
fn the_default_sheet_lands_and_rests_in_the_scene_of_the_thesis() {
    let place = TestFolder::new("default-sheet");
    for structure in ["samm", "slamm", "trimm"] {
        let made = place.run(&["generate", "--structure", structure, "--grid", "11x2x11", "-o", "leaf.sht"]);
        assert_eq!(made.status, Some(0), "{}", made.err);
        let file = format!("sheets.0.file={:?}", place.path("leaf.sht"));
        let report = place.json(&["run", "flat_floor_e0", "--set", &file, "--json"]);
        let sheet = &report["sheets"][0];
        assert_eq!((report["status"].as_str(), sheet["asleep"].as_bool()), (Some("ok"), Some(true)), "{structure}");
        let distance = sheet["layer_distance_m"].as_f64().expect("two layers");
        assert!((0.85e-3..1e-3).contains(&distance), "{structure}: {distance}");
    }
    // The mass of the material's density is a thirteenth of the thesis's, and so is its stable step
    // squared: the note says which step would do.
    let light = ["generate", "--structure", "trimm", "--grid", "11x2x11", "--material", "thesis", "-o", "light.sht"];
    assert_eq!(place.run(&light).status, Some(0));
    let ran = place.run(&["run", "flat_floor_e0", "--set", &format!("sheets.0.file={:?}", place.path("light.sht"))]);
    assert!(ran.status == Some(1) && ran.err.contains("rad of its fastest mode"), "{}", ran.err);
}

#[test]
fn all_flags_are_written_and_read_back() {
    use glam::DVec3;
    use sheetwork::mesh::spring_class::SpringClass;
    let place = TestFolder::new("all-flags");
    let flags = "generate --structure trimm --grid 6x5x7 --width 0.03 --depth 0.02 --gap 0.002 --node-mass 3e-5 \
        --planar-stiffness 0.205 --inter-layer-stiffness 0.7 --damping 0.2 --position 0.01,0.02,-0.03 \
        --velocity 0.1,-0.2,0.3 --force 1e-5,2e-5,-3e-5 --acceleration 0.5,-9.81,0 -o all.sht";
    let made = place.run(&flags.split_whitespace().collect::<Vec<_>>());
    assert_eq!(made.status, Some(0), "{}", made.err);
    let file = sheetwork::scene::sht::read_sht_file(&place.path("all.sht")).expect("ours");
    assert_eq!((file.dimensions, file.damping, file.structure.as_str()), ([6, 5, 7], 0.2, "trimm"));
    for mass in &file.masses {
        assert_eq!((mass.mass, mass.velocity), (3e-5, DVec3::new(0.1, -0.2, 0.3)));
        assert_eq!((mass.force, mass.acceleration), (DVec3::new(1e-5, 2e-5, -3e-5), DVec3::new(0.5, -9.81, 0.0)));
    }
    assert_eq!(file.masses[0].position.y, 0.02);
    assert!(file.masses.last().is_some_and(|m| (m.position.y - 0.028).abs() < 1e-15 && m.layer == 4));
    for spring in &file.springs {
        let wanted = if spring.kind == SpringClass::Inter { 0.7 } else { 0.205 };
        assert_eq!(spring.stiffness, wanted, "{spring:?}");
    }
    let scene = r#"(engine: "rk4", dt: 0.0001, duration: 0.0001, gravity: (0, 0, 0), sheets: [(name: "leaf", file: "all.sht")])"#;
    let scene = sheetwork::scene::Scene::load(&place.path(place.write("all.ron", scene))).expect("valid");
    let world = sheetwork::World::new(&scene).expect("valid");
    assert_eq!(sheetwork::sheet::to_file(&world.sheets()[0]).springs, file.springs);
    assert!(
        (world.sheets()[0].momentum() - DVec3::new(0.1, -0.2, 0.3) * world.sheets()[0].total_mass()).length() < 1e-12
    );
    for layers in ["1", "64"] {
        let grid = format!("3x{layers}x3");
        assert_eq!(place.run(&["generate", "--structure", "samm", "--grid", &grid]).status, Some(0), "{grid}");
    }
}

#[test]
fn sizes_are_taken_from_the_flags() {
    let place = TestFolder::new("sizes");
    let base = ["generate", "--structure", "samm", "--grid", "5x2x4", "--width", "0.2", "--depth", "0.1", "--json"];
    let found = place.json(&[&base[..], &["--material", "thesis"]].concat());
    assert!((found["mass_kg"].as_f64().expect("a number") - 1045.0 * 1e-3 * 0.02).abs() < 1e-9);
    let found = place.json(&[&base[..], &["--node-mass", "1e-4"]].concat());
    assert!((found["mass_kg"].as_f64().expect("a number") - 1e-4 * 32.0).abs() < 1e-12);
    let crossed = place.json(&["generate", "--structure", "slamm", "--grid", "5x2x4", "--cross-over", "--json"]);
    let plain = place.json(&["generate", "--structure", "slamm", "--grid", "5x2x4", "--json"]);
    assert!(crossed["springs"].as_u64() > plain["springs"].as_u64());
}

#[test]
fn flags_of_generate_are_checked() {
    let place = TestFolder::new("generate-flags");
    let refused = |flags: &[&str], parts: &[&str]| {
        let all = [&["generate", "--structure", "samm", "--grid", "5x2x4"], flags].concat();
        place.expect_rejection(&all, parts);
    };
    refused(&["--width", "-1"], &["width", "-1 m", "1e-6 to 1000 m"]);
    refused(&["--depth", "0"], &["depth", "0 m"]);
    refused(&["--gap", "nan"], &["--gap", "nan", "finite"]);
    refused(&["--node-mass", "-1"], &["node_mass", "-1 kg", "1e-12 to 1e6 kg"]);
    refused(&["--material", "cheese"], &["material", "cheese", "hips"]);
    refused(&["--inter-layer", "Soft"], &["Soft", "SumModulus(Pa)"]);
    refused(&["--inter-layer-stiffness", "0"], &["inter_layer_stiffness", "1e-9 to 1e12 N/m"]);
    refused(&["--planar-stiffness=-3"], &["planar_stiffness: -3 N/m over a thickness of 0.001 m is a modulus out of"]);
    refused(&["--inter-layer", "SumModulus(185 Pa)"], &["SumModulus(185 Pa)", "with a plain number"]);
    refused(&["--acceleration", "0,1e300,0"], &["acceleration.1: 1e300 m/s² is outside -1000 to 1000 m/s²"]);
    for file in ["leaf.ron", "leaf.txt", "leaf"] {
        refused(&["-o", file], &[&format!("output: {file} does not end in .sht")]);
    }
    place.expect_rejection(&["generate", "--cards", "pack", "-o", "cards.sht"], &["cards.sht does not end in .ron"]);
    let shell = ["generate", "--structure", "shell", "--grid", "5x1x5", "--inter-layer", "SumModulus(185)"];
    place.expect_rejection(&shell, &["inter_layer: needs a lattice of two layers", "shell"]);
    let capital = ["generate", "--structure", "samm", "--grid", "5x2x4", "-o", "LEAF.SHT"];
    assert_eq!(place.run(&capital).status, Some(0));
    refused(&["--damping", "11"], &["damping", "0 to 10"]);
    refused(&["--position", "1,2"], &["1,2", "x,y,z"]);
    refused(&["--force", "1e9,0,0"], &["forces.0.value.0", "1e6"]);
    refused(&["--cross-over"], &["samm has no cross-over"]);
    refused(&["-o", "no/such/folder/x.sht"], &["no/such/folder/x.sht"]);
    let of = |structure: &str, grid: &str, parts: &[&str]| {
        place.expect_rejection(&["generate", "--structure", structure, "--grid", grid], parts);
    };
    of("satin", "5x2x4", &["satin", "samm", "provot3d"]);
    of("samm", "5x4", &["--grid", "5x4", "3 whole numbers"]);
    of("samm", "1x2x4", &["grid.0", "2 to 2000"]);
    of("samm", "5x65x4", &["grid.1", "1 to 64"]);
    of("provot2d", "5x2x4", &["grid.1", "1 to 1", "provot2d"]);
    of("samm", "2000x64x2000", &["grid", "10000000"]);
}

#[test]
fn lists_have_a_row_for_everything() {
    let place = TestFolder::new("lists");
    let names = |what: &str| -> Vec<String> {
        let rows = place.json(&["list", what, "--json"]);
        let rows = rows.as_array().expect("an array");
        assert!(rows.iter().all(|r| r["about"].as_str().is_some_and(|a| !a.is_empty())), "{what}");
        let text = place.run(&["list", what]).out;
        let names = rows.iter().map(|r| r["name"].as_str().expect("a name").to_owned());
        names.inspect(|n| assert!(text.contains(n.as_str()))).collect()
    };
    for name in ["samm", "slamm", "double-diagonal", "trimm", "provot2d", "provot3d"] {
        assert!(names("structures").iter().any(|n| n == name), "{name}");
    }
    for name in ["analytical", "euler", "euler-cromer", "euler-richardson", "verlet", "rk4", "rk45"] {
        assert!(names("engines").iter().any(|n| n == name), "{name}");
    }
    assert!(names("materials").iter().any(|n| n == "hips"));
    assert!(names("cases").iter().any(|n| n == "oscillator"));
    assert!(names("scenes").iter().any(|n| n.ends_with("wedge.ron")));
    let engine = &place.json(&["list", "engines", "--json"])[0];
    let fields = ["name", "about", "order", "stability_limit", "evaluations", "adaptive", "implicit"];
    assert_eq!(keys(engine), fields);
    place.expect_rejection(&["list", "cheeses"], &["cheeses", "structures"]);
    place.expect_rejection(&["list", "scenes", "--folder", "nowhere"], &["nowhere"]);
    place.write("assets/scenes/zz.ron", "(dt: 0)");
    assert!(place.run(&["list", "scenes"]).out.contains("not valid"));
}

#[test]
fn a_material_report_has_the_delivered_stiffness() {
    let place = TestFolder::new("material");
    let found = place.json(&["material", "hips", "--structure", "double-diagonal", "--grid", "21x21", "--json"]);
    let value = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    // D = E t³/(12 (1-ν²)) for 2 GPa, 0.5 mm, ν 0.38.
    assert!((value("plate_stiffness_n_m") - 0.0243494).abs() < 1e-6);
    assert!((value("areal_mass_kg_m2") - 0.5225).abs() < 1e-9);
    assert!((value("gravito_bending_length_m") - 0.168).abs() < 5e-4);
    for ratio in found["bending_0_45_90_135"].as_array().expect("four") {
        assert!((ratio.as_f64().expect("a number") - 1.0).abs() < 0.005);
    }
    assert!(value("membrane") < 0.1 && (value("poisson_ratio") - 1.0 / 3.0).abs() < 1e-3);
    assert!(found["notes"].as_array().is_some_and(|n| n.len() >= 2));
    let readme = std::fs::read_to_string(place.path("assets/README.md")).expect("there");
    keys(&found).iter().for_each(|key| assert!(readme.contains(&format!("`{key}`")), "{key}"));
    let thick =
        place.json(&["material", "hips", "--thickness", "1e-3", "--length", "0.1", "--width", "0.05", "--json"]);
    assert!((thick["plate_stiffness_n_m"].as_f64().expect("D") / value("plate_stiffness_n_m") - 8.0).abs() < 1e-9);
    assert!(
        place.run(&["material", "assets/materials/cotton.ron", "--structure", "trimm"]).out.contains("gravito-bending")
    );
    assert!(place.run(&["material", "card", "--structure", "samm"]).out.contains("no twist stiffness"));
    place.expect_rejection(&["material", "cheese"], &["material", "cheese", "hips"]);
    place.expect_rejection(&["material", "gone.ron"], &["gone.ron", "cannot be opened"]);
    place.expect_rejection(&["material", "hips", "--thickness", "-1"], &["thickness", "1e-7 to 1 m"]);
    place.expect_rejection(&["material", "hips", "--gap", "0", "--structure", "samm"], &["gap", "0 m"]);
    place.expect_rejection(&["material", "hips", "--structure", "provot2d", "--layers", "2"], &["layers", "1 to 1"]);
}

#[test]
fn a_scene_reads_its_material_from_a_file() {
    let place = TestFolder::new("material-file");
    place.write("soft.ron", "(\n  young: 200,\n  density: 2090,\n)");
    let scene = r#"(engine: "euler-richardson", dt: 0.001, duration: 0.002,
        sheets: [(name: "leaf", structure: "samm", grid: (11, 2, 11), size: (0.025, 0.025), material: "soft.ron",
            springs: Uniform)])"#;
    let report = place.json(&["run", place.write("scene.ron", scene), "--json"]);
    assert_eq!(report["status"], "ok");
    place.write("soft.ron", "(\n  young: 200,\n  density: -1,\n)");
    place.expect_rejection(&["run", "scene.ron"], &["soft.ron:3: density: -1 kg/m³", "0.001 to 1e6"]);
    place.write("soft.ron", "(\n  yung: 200,\n)");
    place.expect_rejection(&["run", "scene.ron"], &["soft.ron:2:", "yung"]);
    let opened = place.run(&["run", "scene.ron", "--set", "sheets.leaf.material.young=300"]);
    assert_eq!(opened.status, Some(2));
    place.write("soft.ron", "(young: 200)");
    assert_eq!(place.run(&["run", "scene.ron", "--set", "sheets.leaf.material.young=300"]).status, Some(0));
    let listed = place.json(&["list", "materials", "--json"]);
    assert!(listed.as_array().is_some_and(|rows| rows.iter().all(|r| r["damping_ratio"].as_f64().is_some())));
}

#[test]
fn a_shell_is_not_written_without_springs() {
    let place = TestFolder::new("shell");
    let ran = place.run(&["generate", "--structure", "shell", "--grid", "5x1x5", "-o", "shell.sht"]);
    assert_ne!(ran.status, Some(0));
    assert!(ran.err.contains("no springs") && ran.err.contains("structure"), "{}", ran.err);
}
