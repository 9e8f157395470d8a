//! `run`: report, overrides, and written files.

use serde_json::Value;
use sheetwork::scene::Scene;
use sheetwork::world::recording;

use super::common::{TestFolder, keys};

const WEDGE: &str = "assets/scenes/wedge.ron";

#[test]
fn the_report_has_the_keys_of_the_contract() {
    let place = TestFolder::new("keys");
    let report = place.json(&["run", WEDGE, "--seconds", "0.4", "--json"]);
    let top = ["scene", "engine", "dt_s", "simulated_s", "cpu_s", "steps", "status", "sheets", "bodies", "events"];
    assert_eq!(keys(&report), top);
    let sheet = &report["sheets"][0];
    let contract = ["name", "masses", "springs", "asleep", "energy_j", "max_penetration_m", "max_speed_m_s"];
    for key in contract.into_iter().chain(["temperature_c", "probes", "status"]) {
        assert!(!sheet[key].is_null(), "sheets[].{key}");
    }
    assert_eq!(keys(&sheet["energy_j"]), ["kinetic", "elastic", "gravity", "total"]);
    assert_eq!(keys(&sheet["temperature_c"]), ["min", "mean", "max"]);
    assert_eq!(keys(&sheet["probes"]), ["centre", "corner", "edge"]);
    assert_eq!(sheet["probes"]["edge"].as_array().map(Vec::len), Some(3));
    assert_eq!(keys(&report["events"][0]), ["time_s", "kind", "sheet", "body"]);
    assert_eq!(report["events"][0]["kind"], "first_contact");
    assert_eq!(report["events"][0]["body"], "wedge");
    assert_eq!(
        keys(&report["bodies"][0]),
        ["name", "position_m", "rotation", "velocity_m_s", "spin_rad_s", "mass_kg", "asleep"]
    );
    assert_eq!((report["scene"].as_str(), report["status"].as_str()), (Some("wedge"), Some("ok")));
    assert!(sheet["asleep"].is_boolean());
    let simulated = report["simulated_s"].as_f64().expect("a number");
    assert!((0.4..0.4 + 0.015).contains(&simulated), "{simulated}");
    let e = |key: &str| sheet["energy_j"][key].as_f64().expect("a number");
    assert!((e("kinetic") + e("elastic") + e("gravity") - e("total")).abs() < 1e-15);
}

#[test]
fn without_json_a_table_is_printed() {
    let place = TestFolder::new("table");
    let ran = place.run(&["run", WEDGE, "--seconds", "0.4"]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    for part in ["wedge", "euler-richardson", "221 masses, 881 springs", "first_contact", "energy"] {
        assert!(ran.out.contains(part), "no {part} in {}", ran.out);
    }
}

#[test]
fn flags_override_fields() {
    let place = TestFolder::new("flags");
    let flags = ["run", WEDGE, "--json", "--seconds", "0.1", "--dt", "1/200", "--engine", "rk4", "--no-sleep"];
    let report = place.json(&flags);
    assert_eq!(report["engine"], "rk4");
    assert_eq!((report["dt_s"].as_f64(), report["steps"].as_u64()), (Some(0.005), Some(20)));
    let sheet = "sheets.sheet";
    let set = |path: &str, value: &str| format!("{path}={value}");
    let (grid, pins) = (set("sheets.0.grid", "(5, 3, 4)"), set(&format!("{sheet}.pins"), "[(region: All)]"));
    let (shape, name) = (set("bodies.wedge.shape", "Ball(0.01)"), set("name", "other"));
    let structure = set(&format!("{sheet}.structure"), "samm");
    let all = ["--set", &grid, "--set", &pins, "--set", &shape, "--set", &name, "--set", &structure];
    let report = place.json(&[&["run", WEDGE, "--json", "--seconds", "0.05"], &all[..]].concat());
    assert_eq!(report["scene"], "other");
    assert_eq!(
        (report["sheets"][0]["masses"].as_u64(), report["sheets"][0]["springs"].as_u64()),
        (Some(52), Some(175))
    );
    assert_eq!(report["sheets"][0]["max_speed_m_s"].as_f64(), Some(0.0), "all masses are held");
}

#[test]
fn an_override_changes_the_result() {
    let place = TestFolder::new("override");
    let low = |young: &str| {
        let set = format!("sheets.sheet.material.young={young}");
        let report = place.json(&["run", WEDGE, "--json", "--seconds", "0.5", "--set", &set]);
        report["sheets"][0]["probes"]["edge"][1].as_f64().expect("a number")
    };
    assert!(low("100") < low("300"), "a softer sheet hangs lower");
    let report = place.json(&["run", WEDGE, "--json", "--seconds", "0.2", "--set", "gravity=(0, 0, 0)"]);
    assert!(report["sheets"][0]["energy_j"]["kinetic"].as_f64().is_some_and(|e| e < 1e-30), "nothing moves it");
}

#[test]
fn the_result_is_independent_of_threads() {
    let place = TestFolder::new("threads");
    let sheet = |i: i32| {
        format!(
            r#"(structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis", springs: Uniform,
                node_mass: 4e-4, placement: (position: ({}, 0.00{}, 0.03)))"#,
            0.4 * f64::from(i - 3),
            2 + i
        )
    };
    let sheets: Vec<String> = (1..6).map(sheet).collect();
    let scene = format!(
        r#"(engine: "euler-richardson", dt: 0.005, duration: 0.5, room: (x: (-2, 2), y: (0, 1), z: (-1, 1)),
            sheets: [{}])"#,
        sheets.join(", ")
    );
    let file = place.write("many.ron", &scene);
    let run = |threads: &str| {
        let mut report = place.json(&["run", file, "--json", "--threads", threads]);
        report["cpu_s"] = Value::Null;
        report
    };
    let alone = run("1");
    assert_eq!(alone["sheets"].as_array().map(Vec::len), Some(5));
    assert_eq!(alone, run("3"));
    place.expect_rejection(&["run", file, "--threads", "0"], &["threads", "0", "1 to 1024"]);
}

#[test]
fn reports_and_recordings_are_written() {
    let place = TestFolder::new("files");
    let flags = ["run", WEDGE, "--json", "--seconds", "0.3", "--report", "r.json", "--record", "r.swr"];
    let printed = place.json(&flags);
    let text = std::fs::read_to_string(place.path("r.json")).expect("a report");
    assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), printed);
    let (header, frames) = recording::read(&place.path("r.swr")).expect("a recording");
    assert_eq!((header.scene.as_str(), header.masses.as_slice(), header.bodies), ("wedge", &[221][..], 3));
    assert_eq!(Scene::parse(&header.source).expect("a scene").name, "wedge");
    assert_eq!(frames.len(), 21, "the start and one a step of 15 ms");
    let last = frames.last().expect("frames");
    assert!((last.time - 0.3).abs() < 1e-9);
    let corner = printed["sheets"][0]["probes"]["corner"][1].as_f64().expect("a number");
    assert!((f64::from(last.sheets[0][0].y) - corner).abs() < 1e-7);
    place.expect_rejection(&["run", WEDGE, "--seconds", "0", "--record", "no/folder/r.swr"], &["no/folder/r.swr"]);
    place.expect_rejection(&["run", WEDGE, "--seconds", "0", "--report", "no/folder/r.json"], &["no/folder/r.json"]);
}

#[test]
fn a_run_lasts_its_whole_time_when_its_step_changes() {
    let place = TestFolder::new("step");
    let flags = ["run", "wedge", "--json", "--seconds", "0.2", "--at", "0.1:dt=0.001", "--at", "0.15:gravity=(0,1,0)"];
    let report = place.json(&flags);
    assert!((report["simulated_s"].as_f64()).is_some_and(|t| (t - 0.2).abs() < 1e-9), "{}", report["simulated_s"]);
    assert_eq!(report["steps"], 20 + 100);
    place.expect_rejection(&[&flags[..], &["--at", "0.16:gravity=99999"]].concat(), &["gravity"]);
    let flags = ["run", "tube", "--seconds", "0", "--record", "t.swr"];
    assert_eq!(place.run(&flags).status, Some(0));
    let (header, _) = recording::read(&place.path("t.swr")).expect("a recording");
    assert_eq!(header.masses, [956], "the nodes of the file");
}

#[test]
fn flag_values_accept_units() {
    let place = TestFolder::new("units");
    let run = |flags: &[&str]| {
        let mut report = place.json(&[&["run", "wedge", "--json"], flags].concat());
        report["cpu_s"] = Value::Null;
        report
    };
    let plain = run(&["--seconds", "0.1", "--dt", "0.001", "--set", "gravity=(0, -1.962, 0)", "--at", "0.05:dt=0.002"]);
    let units = run(&["--seconds", "100ms", "--dt", "1 ms", "--set", "gravity=(0, -0.2 g, 0)", "--at", "50ms:dt=2 ms"]);
    assert_eq!(plain["dt_s"], 0.002);
    assert!((plain["sheets"][0]["max_speed_m_s"].as_f64()).is_some_and(|v| v > 0.1), "it falls");
    let speed = |r: &Value| r["sheets"][0]["max_speed_m_s"].as_f64().expect("a number");
    assert!((speed(&units) / speed(&plain) - 1.0).abs() < 1e-3, "{} {}", speed(&units), speed(&plain));
    place.expect_rejection(&["run", "wedge", "--dt", "3 mm"], &["--dt", "mm is a unit of length", "ms"]);
    let thick = "sheets.0.material.thickness=2 MPa";
    place.expect_rejection(&["run", "wedge", "--set", thick], &["thickness", "MPa is a unit of pressure", "mm"]);
    place.expect_rejection(&["run", "wedge", "--seconds", "1", "--at", "2:dt=1e-3"], &["--at", "2 s", "0 to 1 s"]);
    place.expect_rejection(
        &["run", "assets/sheets/slamm_5x2x5.sht"],
        &["slamm_5x2x5.sht", "no scene", "sheets: [(file"],
    );
    let young = place.json(&["material", "hips", "--length", "30 cm", "--young", "2.1 GPa", "--json"]);
    assert_eq!(young, place.json(&["material", "hips", "--length", "0.3", "--young", "2.1e9", "--json"]));
}

#[test]
fn an_unstable_sheet_is_reported_with_status_1() {
    let place = TestFolder::new("unstable");
    let flags =
        ["run", WEDGE, "--json", "--seconds", "1", "--set", "sheets.sheet.material.young=2e9", "--record", "u.swr"];
    let ran = place.run(&flags);
    assert_eq!(ran.status, Some(1), "{}", ran.err);
    let report = ran.json();
    let status = report["status"].as_str().expect("text");
    assert!(status.starts_with("unstable: sheet at ") && status.contains("mass "), "{status}");
    let last = report["events"].as_array().and_then(|e| e.last()).expect("events");
    assert_eq!(last["kind"], "unstable");
    let (_, frames) = recording::read(&place.path("u.swr")).expect("a recording");
    assert!(frames.iter().flat_map(|f| &f.sheets[0]).all(|p| p.is_finite()));
}

#[test]
fn every_command_of_the_assets_readme_runs() {
    let place = TestFolder::new("readme");
    let readme = std::fs::read_to_string(place.path("assets/README.md")).expect("readable");
    let blocks = readme.split("```sh\n").skip(1).filter_map(|b| b.split("```").next());
    let mut count = 0;
    for line in blocks.flat_map(str::lines).filter(|l| !l.is_empty()) {
        let words = words(line);
        assert_eq!(words[0], "sheetwork", "{line}");
        let arguments: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        let ran = place.run(&arguments);
        assert_eq!(ran.status, Some(0), "{line}: {}", ran.err);
        count += 1;
    }
    assert!(count >= 6);
    assert!(place.path("leaf.sht").exists() && place.path("dome.swr").exists());
}

/// Splits a command line as a shell does, with double quotes only.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            _ => words.last_mut().expect("a word").push(c),
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

#[test]
fn the_b_spline_surface_of_the_thesis_sinks_deeper_into_the_wedge_and_has_the_smoother_edge() {
    // Thesis 5.3.4 and figure 5.14. Depths before the correction that the display makes.
    let place = TestFolder::new("run-surfaces");
    let found = place.json(&["run", "assets/scenes/wedge.ron", "--surfaces", "--json"]);
    let all = found["drawn_surfaces"].as_array().expect("a list");
    let of = |smoothing: &str, key: &str| {
        let one = all.iter().find(|s| s["layer"] == 0 && s["smoothing"] == smoothing).expect("measured");
        one[key].as_f64().unwrap_or(0.0)
    };
    let kinds = ["interpolating", "b-spline", "bezier"];
    let depth = kinds.map(|kind| of(kind, "depth_m"));
    assert!(depth[1] > 1.2 * depth[0] && depth[2] > 1.5 * depth[1], "{depth:?}");
    assert!(depth[1] > 5e-4 && depth[1] < 2e-3, "a millimetre below the faces of the wedge: {depth:?}");
    let kink = ["flat", "interpolating", "b-spline"].map(|kind| of(kind, "edge_kink_deg"));
    assert!(kink[0] > 2.0 * kink[1] && kink[1] > 1.5 * kink[2], "{kink:?}");
}
