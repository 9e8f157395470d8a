//! `generate` and `list`.

use super::common::{Place, keys};

/// Structure, grid, masses, springs; the thesis's own first.
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
];

#[test]
fn counts_are_those_of_the_thesis() {
    let place = Place::new("counts");
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
    let place = Place::new("written");
    for (structure, grid, masses, springs) in COUNTS {
        let file = format!("{structure}-{grid}.sht");
        let ran = place.run(&["generate", "--structure", structure, "--grid", grid, "-o", &file]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        let scene = format!("(duration: 0.002, sheets: [(name: \"leaf\", file: \"{file}\")])");
        let report = place.json(&["run", place.write("file.ron", &scene), "--json"]);
        let sheet = &report["sheets"][0];
        assert_eq!(sheet["structure"], *structure);
        assert_eq!((sheet["masses"].as_u64(), sheet["springs"].as_u64()), (Some(*masses), Some(*springs)), "{file}");
    }
}

#[test]
fn a_written_sheet_moves_as_the_generated_one() {
    let place = Place::new("same");
    let flags = ["generate", "--structure", "slamm", "--grid", "7x2x6", "--node-mass", "4e-4", "--output", "leaf.sht"];
    assert_eq!(place.run(&flags).status, Some(0));
    let fields = "node_mass: 4e-4, velocities: [(region: Left, value: (0, 0.1, 0))], probes: {\"tip\": (1, 0.3)}";
    let run = |sheet: &str| {
        let scene = format!("(dt: 0.01, duration: 0.5, sheets: [({sheet}, {fields})])");
        let tip = &place.json(&["run", place.write("scene.ron", &scene), "--json"])["sheets"][0]["probes"]["tip"];
        [0, 1, 2].map(|axis| tip[axis].as_f64().expect("a number"))
    };
    let (read, made) = (run("file: \"leaf.sht\""), run("structure: \"slamm\", grid: (7, 2, 6)"));
    assert!(read.iter().zip(made).all(|(a, b)| (a - b).abs() < 1e-12), "{read:?} {made:?}");
}

#[test]
fn sizes_are_taken_from_the_flags() {
    let place = Place::new("sizes");
    let base = ["generate", "--structure", "samm", "--grid", "5x2x4", "--width", "0.2", "--depth", "0.1", "--json"];
    let found = place.json(&base);
    assert!((found["mass_kg"].as_f64().expect("a number") - 1045.0 * 1e-3 * 0.02).abs() < 1e-9);
    let found = place.json(&[&base[..], &["--node-mass", "1e-4"]].concat());
    assert!((found["mass_kg"].as_f64().expect("a number") - 1e-4 * 32.0).abs() < 1e-12);
    let crossed = place.json(&["generate", "--structure", "slamm", "--grid", "5x2x4", "--cross-over", "--json"]);
    let plain = place.json(&["generate", "--structure", "slamm", "--grid", "5x2x4", "--json"]);
    assert!(crossed["springs"].as_u64() > plain["springs"].as_u64());
}

#[test]
fn flags_of_generate_are_checked() {
    let place = Place::new("generate-flags");
    let refused = |flags: &[&str], parts: &[&str]| {
        let all = [&["generate", "--structure", "samm", "--grid", "5x2x4"], flags].concat();
        place.refused(&all, parts);
    };
    refused(&["--width", "-1"], &["width", "-1 m", "1e-6 to 1000 m"]);
    refused(&["--depth", "0"], &["depth", "0 m"]);
    refused(&["--gap", "nan"], &["--gap", "nan", "finite"]);
    refused(&["--node-mass", "-1"], &["node_mass", "-1 kg", "1e-12 to 1e6 kg"]);
    refused(&["--material", "cheese"], &["material", "cheese", "hips"]);
    refused(&["--cross-over"], &["samm has no cross-over"]);
    refused(&["-o", "no/such/folder/x.sht"], &["no/such/folder/x.sht"]);
    let of = |structure: &str, grid: &str, parts: &[&str]| {
        place.refused(&["generate", "--structure", structure, "--grid", grid], parts);
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
    let place = Place::new("lists");
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
    let fields = ["name", "about", "order", "stability_limit", "evaluations", "adaptive"];
    assert_eq!(keys(engine), fields);
    place.refused(&["list", "cheeses"], &["cheeses", "structures"]);
    place.refused(&["list", "scenes", "--folder", "nowhere"], &["nowhere"]);
    place.write("assets/scenes/zz.ron", "(dt: 0)");
    assert!(place.run(&["list", "scenes"]).out.contains("not valid"));
}
