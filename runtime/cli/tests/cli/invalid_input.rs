//! Invalid input: exit status 2, and a message that names file, line, field, value, unit and range.

use super::common::TestFolder;

const WEDGE: &str = "assets/scenes/wedge.ron";

#[test]
fn errors_of_a_scene_file_are_located() {
    let place = TestFolder::new("scene-faults");
    let refused = |text: &str, parts: &[&str]| {
        place.write("bad.ron", text);
        place.expect_rejection(&["run", "bad.ron", "--json"], &[&["error: bad.ron:"], parts].concat());
    };
    refused("(\n  dt: 0.001,\n  speed: 3,\n)", &["bad.ron:3: ", "speed", "engine"]);
    refused("(\n  sheets: [\n    (dampin: 0.1),\n  ],\n)", &["bad.ron:3: sheets.0.dampin", "damping"]);
    refused("(\n  dt: \"soon\",\n)", &["bad.ron:2: dt", "float", "\"soon\""]);
    refused("(\n  sheets: [(\n    grid: (5, 2),\n  )],\n)", &["bad.ron:3: sheets.0.grid"]);
    refused("(\n  gravity: (0, NaN, 0),\n)", &["bad.ron:2: gravity.1: NaN m/s² is outside -1000 to 1000 m/s²"]);
    refused("(\n  dt: inf,\n)", &["bad.ron:2: dt: inf s is outside 1e-7 to 1 s"]);
    refused(
        "(\n  sheets: [(\n    node_mass: -4e-4,\n  )],\n)",
        &["bad.ron:3: sheets.0.node_mass: -4e-4 kg is outside 1e-12 to 1e6 kg"],
    );
    refused("(\n  sheets: [(\n    material: (young: -1),\n  )],\n)", &["bad.ron:3: sheets.0.material.young: -1 Pa"]);
    refused("(\n  engine: \"euler-kramer\",\n)", &["bad.ron:2: engine", "euler-kramer", "euler-cromer"]);
    refused("(sheets: [(\n  structure: \"satin\",\n)])", &["bad.ron:2: sheets.0.structure", "satin", "trimm"]);
    refused("(sheets: [(\n  material: \"cheese\",\n)])", &["bad.ron:2: sheets.0.material", "cheese", "hips"]);
    refused("(sheets: [(name: \"a\"),\n  (name: \"a\"),\n])", &["bad.ron:2: sheets.1.name", "\"a\" is used twice"]);
    refused("(bodies: [(\n  shape: Ball(-1),\n)])", &["bad.ron:2: bodies.0.shape: -1 m"]);
    refused("(bodies: [(\n  shape: Cone(1),\n)])", &["bad.ron:2: bodies.0.shape", "Cone", "Ball"]);
    refused(
        "(sheets: [(pins: [(\n  region: Point(2, 0),\n)])])",
        &["bad.ron:2: sheets.0.pins.0.region", "2 is outside 0 to 1"],
    );
    refused("(\n  dt: 0.001\n  duration: 1,\n)", &["bad.ron:3: "]);
    refused("", &["bad.ron:1: "]);
    refused("hello", &["bad.ron:1: "]);
    refused("(dt: 0.001) more", &["bad.ron:1: "]);
    refused("\u{0}\u{1}((((", &["bad.ron:1: "]);
}

#[test]
fn errors_of_the_construction_of_a_world_are_located() {
    let place = TestFolder::new("world-faults");
    let refused = |text: &str, parts: &[&str]| {
        place.write("bad.ron", text);
        place.expect_rejection(&["run", "bad.ron"], parts);
    };
    refused("(sheets: [(file: \"none.sht\")])", &["none.sht: cannot be opened"]);
    refused("(bodies: [(shape: File(\"none.pol\"))])", &["none.pol: cannot be opened"]);
    refused("(heaters: [(file: \"none.heater\")])", &["none.heater: cannot be opened"]);
    refused(
        "(bodies: [(shape: Part(\"assets/polyhedra/cube.pol\", 1))])",
        &["bodies.0.shape", "polyhedron 1", "holds 1"],
    );
    refused("(sheets: [(pins: [(region: Masses([7, 500]))])])", &["sheets.0.pins.0.region", "mass 500", "0 to 220"]);
    refused("(sheets: [(flexion_limit: 30)])", &["sheets.0.flexion_limit", "trimm"]);
    let open = "(bodies: [(shape: Polyhedron((vertices: [(0,0,0), (1,0,0), (0,1,0)], faces: [[0, 1, 2]])))])";
    refused(open, &["bodies.0.shape"]);
}

#[test]
fn errors_of_a_sheet_file_are_located() {
    let place = TestFolder::new("sht-faults");
    let good = std::fs::read_to_string(place.path("assets/sheets/slamm_5x2x5.sht")).expect("readable");
    place.write("bad.ron", "(sheets: [(file: \"bad.sht\")])");
    let line_of = |what: &str| 1 + good.lines().position(|l| l.starts_with(what)).expect("a line");
    let refused = |from: &str, replace: &dyn Fn(&str) -> String, parts: &[&str]| {
        let line = line_of(from);
        let lines = good.lines().enumerate().map(|(i, l)| if i + 1 == line { replace(l) } else { l.to_owned() });
        place.write("bad.sht", &lines.collect::<Vec<_>>().join("\n"));
        let at = format!("bad.sht:{line}: ");
        place.expect_rejection(&["run", "bad.ron"], &[&[at.as_str()], parts].concat());
    };
    let field = |index: usize, value: &'static str| {
        move |line: &str| {
            let mut words: Vec<&str> = line.split_ascii_whitespace().collect();
            words[index] = value;
            words.join(" ")
        }
    };
    refused("M ", &field(13, "-4"), &["M.mass: \"-4\" 1e-4 kg is outside 1e-8 to"]);
    refused("M ", &field(5, "nan"), &["M.py: \"nan\" is not a number", "cm"]);
    refused("S ", &field(3, "41"), &["S.b: \"41\" is not a mass, 0 to 40"]);
    refused("S ", &field(4, "-1"), &["S.stiffness: \"-1\" 1e-3 N/m is outside 0 to"]);
    refused("S ", &field(1, "w"), &["S.kind", "\"w\"", "diagonal"]);
    refused("T ", &field(1, "satin"), &["T: no structure is named \"satin\""]);
    refused("C ", &field(1, "x"), &["C.damping: \"x\" is not a number (0 to 1000 %)"]);
    refused("D ", &field(1, "6"), &["D: 6 x 2 x 5"]);
    refused("*", &|_| "Q".to_owned(), &["unknown record \"Q\""]);
}

/// A cube of 2 cm, one face per line.
const CUBE: [&str; 6] = [
    "V -1 -1 1\nV 1 -1 1\nV 1 1 1\nV -1 1 1\nF\n",
    "V 1 -1 -1\nV -1 -1 -1\nV -1 1 -1\nV 1 1 -1\nF\n",
    "V 1 -1 1\nV 1 -1 -1\nV 1 1 -1\nV 1 1 1\nF\n",
    "V -1 -1 -1\nV -1 -1 1\nV -1 1 1\nV -1 1 -1\nF\n",
    "V -1 1 1\nV 1 1 1\nV 1 1 -1\nV -1 1 -1\nF\n",
    "V -1 -1 -1\nV 1 -1 -1\nV 1 -1 1\nV -1 -1 1\nF\n",
];

#[test]
fn errors_of_a_polyhedron_file_are_located() {
    let place = TestFolder::new("pol-faults");
    place.write("bad.ron", "(duration: 0, bodies: [(shape: File(\"bad.pol\"))])");
    let good = format!("{}P\n*\n", CUBE.concat());
    place.write("bad.pol", &good);
    assert_eq!(place.run(&["run", "bad.ron"]).status, Some(0));
    let refused = |text: &str, parts: &[&str]| {
        place.write("bad.pol", text);
        place.expect_rejection(&["run", "bad.ron"], &[&["bad.pol:"], parts].concat());
    };
    refused(&format!("{}P\n*\n", CUBE[..5].concat()), &["bad.pol:5: polyhedra.0.faces.0", "edge", "open"]);
    refused(&good.replacen("V -1 -1 1\n", "V -1 -1 1.1\n", 1), &["bad.pol:5: ", "plane"]);
    refused(&good.replacen("V -1 -1 1\n", "V -1 NaN 1\n", 1), &["bad.pol:1: V.y: \"NaN\" is not a number", "cm"]);
    refused(&good.replacen("V -1 -1 1\n", "V -1 2e6 1\n", 1), &["bad.pol:1: V.y: \"2e6\" cm is outside -1000000 to"]);
    refused(&good.replacen("V -1 -1 1\n", "V -1 1\n", 1), &["bad.pol:1: V: takes 3 fields"]);
    refused(&good.replace("*\n", ""), &["end mark * is missing"]);
    refused("*\n", &["bad.pol:1: "]);
    refused("", &["bad.pol:1: "]);
}

#[test]
fn errors_of_a_heater_file_are_located() {
    let place = TestFolder::new("heater-faults");
    place.write("bad.ron", "(duration: 0, heaters: [(file: \"bad.heater\")])");
    let good = format!("{}P\n*\n", CUBE.concat()).replacen("F\n", "F HOT 250 0.9\n", 1);
    place.write("bad.heater", &good);
    assert_eq!(place.run(&["run", "bad.ron"]).status, Some(0));
    let refused = |face: &str, parts: &[&str]| {
        place.write("bad.heater", &good.replace("F HOT 250 0.9", face));
        place.expect_rejection(&["run", "bad.ron"], &[&["bad.heater:5: F"], parts].concat());
    };
    refused("F HOT 5001 0.9", &["temperature: \"5001\" °C is outside -273.15 to 5000 °C"]);
    refused("F HOT 250 1.5", &["emissivity: \"1.5\" is outside 0 to 1"]);
    refused("F HOT 250", &["takes 3 fields"]);
    refused("F WARM 250 0.9", &["\"WARM\" is not HOT"]);
    refused("F HOT nan 0.9", &["temperature: \"nan\" is not a number"]);
}

#[test]
fn invalid_flags_are_named() {
    let place = TestFolder::new("flag-faults");
    let refused = |flags: &[&str], parts: &[&str]| place.expect_rejection(&[&["run", WEDGE], flags].concat(), parts);
    refused(&["--set", "nonsense"], &["--set", "nonsense", "PATH=VALUE"]);
    refused(&["--set", "sheets.sheet.dampin=1"], &["sheets.sheet.dampin", "damping"]);
    refused(&["--set", "sheets.other.damping=1"], &["sheets.other.damping", "\"other\"", "1 items"]);
    refused(&["--set", "sheets.9.damping=1"], &["sheets.9.damping", "1 items"]);
    refused(&["--set", "sheets.sheet.material.yung=1"], &["yung", "young"]);
    refused(&["--set", "sheets.sheet.damping=nan"], &["sheets.sheet.damping", "nan"]);
    refused(&["--set", "sheets.sheet.damping=-1"], &["damping: -1 of critical is outside 0 to 10"]);
    refused(&["--set", "sheets.sheet.grid=7"], &["sheets.sheet.grid", "7"]);
    refused(&["--set", "sheets.sheet.structure=satin"], &["satin", "trimm"]);
    refused(&["--set", "sheets.sheet.material=cheese"], &["cheese", "hips"]);
    refused(&["--set", "=1"], &["no field \"\""]);
    refused(&["--set", "dt.x=1"], &["dt.x"]);
    refused(&["--seconds", "-1"], &["--seconds: -1 s is outside 0 to 1e6 s"]);
    refused(&["--seconds", "x"], &["--seconds", "x", "not a number"]);
    refused(&["--dt", "0"], &["--dt: 0 s is outside 1e-7 to 1 s"]);
    refused(&["--dt", "1/0"], &["--dt", "1/0", "finite"]);
    refused(&["--engine", "euler-kramer"], &["--engine", "euler-kramer", "euler-cromer"]);
    refused(&["--threads", "many"], &["--threads", "many"]);
    refused(&["--frobnicate"], &["--frobnicate"]);
    place.expect_rejection(&["run"], &["SCENE"]);
    place.expect_rejection(&["run", "none.ron"], &["none.ron: cannot be opened"]);
    place.expect_rejection(&["run", "assets"], &["assets: cannot be opened"]);
    place.expect_rejection(&["frobnicate"], &["frobnicate"]);
    place.expect_rejection(&[], &["run", "measure"]);
}

#[test]
fn a_misspelt_name_is_answered_with_the_nearest_names() {
    let place = TestFolder::new("near-names");
    let missing = "wegde: cannot be opened: No such file";
    for command in ["run", "serve"] {
        place.expect_rejection(&[command, "wegde"], &[missing, "did you mean wedge?"]);
    }
    place.expect_rejection(&["run", "assets/scenes/flga.ron"], &["did you mean assets/scenes/flag.ron"]);
    let ran = place.run(&["run", "xyzzy-qqq"]);
    assert!(ran.status == Some(2) && !ran.err.contains("did you mean"), "{}", ran.err);
    place.expect_rejection(&["measure", "cantilevr"], &["\"cantilevr\"; did you mean cantilever? There are bounce"]);
    let boundary = ["measure", "frequency", "--boundary", "clampd"];
    place.expect_rejection(&boundary, &["--boundary", "did you mean clamped?"]);
    place.expect_rejection(&["measure", "cantilever", "--material", "hisp"], &["did you mean hips?"]);
    place.expect_rejection(&["material", "hisp"], &["\"hisp\"; did you mean hips? There are thesis"]);
    place.expect_rejection(&["run", WEDGE, "--engine", "rk5"], &["did you mean rk4"]);
    place.expect_rejection(&["measure", "cantilever", "--structure", "shel"], &["did you mean shell?"]);
    place.expect_rejection(&["list", "materiels"], &["materiels", "materials"]);
    place.expect_rejection(&["meazure"], &["meazure", "measure"]);
}

#[test]
fn the_help_of_run_states_the_default_number_of_threads() {
    let ran = TestFolder::new("help-threads").run(&["run", "--help"]);
    assert_eq!(ran.status, Some(0));
    let help = ran.out.split("--threads").nth(1).expect("the flag");
    assert!(
        help.split("--").next().is_some_and(|h| h.contains("1 by default") && h.contains("[default: 1]")),
        "{help}"
    );
}
