//! Damaged files: accepted or rejected by library and program, without a panic.

use std::path::Path;

use sheetwork::World;
use sheetwork::scene::{Scene, heater_file, pol, sht};

use super::common::TestFolder;

/// A small pseudo-random generator (xorshift) with a fixed seed.
struct RandomNumbers(u64);

impl RandomNumbers {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit.max(1) as u64) as usize
    }
}

/// Fragments that break or change a scene, a sheet or a polyhedron.
const PIECES: &[&str] = &[
    "NaN",
    "-1",
    "1e400",
    "inf",
    "0",
    "99999999999999999999",
    "(",
    ")",
    "[",
    "]",
    "\"",
    ",",
    ":",
    "//",
    "/*",
    "None",
    "Some(",
    "sheets",
    "HalfSpace",
    "Ball(0)",
    "é",
    "\u{0}",
    "\n",
    "V",
    "F",
    "P",
    "*",
    "M",
    "S",
    "K",
    "HOT",
    "#",
];

fn damaged(text: &str, dice: &mut RandomNumbers) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=dice.below(3) {
        let at = dice.below(bytes.len());
        match dice.below(6) {
            0 if !bytes.is_empty() => bytes[at] = dice.below(256) as u8,
            1 if !bytes.is_empty() => drop(bytes.remove(at)),
            2 => bytes.truncate(at),
            3 => drop(bytes.splice(at..at, PIECES[dice.below(PIECES.len())].bytes())),
            4 => drop(bytes.drain(at..(at + dice.below(30)).min(bytes.len()))),
            _ => digit(&mut bytes, dice),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Replaces a digit by one of the fragments.
fn digit(bytes: &mut Vec<u8>, dice: &mut RandomNumbers) {
    let digits: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).collect();
    if let Some(at) = digits.get(dice.below(digits.len())) {
        bytes.splice(*at..=*at, PIECES[dice.below(6)].bytes());
    }
}

/// Excludes huge grids from a damaged digit, which take long to build.
fn is_small(scene: &Scene) -> bool {
    scene.sheets.iter().all(|s| u64::from(s.grid.0) * u64::from(s.grid.1) * u64::from(s.grid.2) < 100_000)
}

const SCENE: &str = r#"(
    gravity: (0, -0.981, 0), // a comment
    engine: "rk4", dt: 0.005, duration: 0.02,
    room: (x: (-0.065, 0.065), y: (-0.0281, 0.03), z: (-0.0299, 0.0333), back_wall: true),
    air: (factor: 0.97, per: 0.015),
    sheets: [(
        name: "leaf", structure: "provot3d", grid: (5, 2, 4), material: (young: 185, poisson: 0.3), node_mass: 4e-4,
        flexion_limit: 40, placement: (position: (0, 0.0025, 0), rotation: (0, 10, 5)),
        pins: [(region: Point(0.5, 0.5), path: [(time: 0), (time: 1, offset: (0, 0.01, 0))])],
        forces: [(region: Rect((0, 0.1), (0, 1)), value: (0, 1e-4, 0))], probes: {"tip": (1, 0.5)},
    )],
    bodies: [
        (name: "wedge", shape: File("assets/polyhedra/wedge.pol")),
        (shape: Box((0.01, 0.02, 0.03)), placement: (position: (0.1, 0, 0)), path: [(time: 0.1, rotation: (0, 0, 9))]),
    ],
    heaters: [(file: "assets/heaters/panel.heater")],
)"#;

#[test]
fn damaged_scenes_are_accepted_or_rejected() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut dice = RandomNumbers(0x5eed_5eed_5eed);
    let (mut good, mut bad) = (0, 0);
    for _ in 0..3000 {
        let text = damaged(SCENE, &mut dice);
        match Scene::parse(&text) {
            Ok(mut scene) => {
                good += 1;
                scene.base.clone_from(&assets);
                let world = (good % 10 == 0 && is_small(&scene)).then(|| World::new(&scene));
                if let Some(Ok(mut world)) = world {
                    (0..3).for_each(|_| _ = world.step());
                }
            }
            Err(error) => {
                bad += 1;
                assert!(error.line.is_some(), "no line: {error} in\n{text}");
            }
        }
    }
    assert!(good > 100 && bad > 1000, "{good} read, {bad} refused");
}

#[test]
fn damaged_overrides_are_accepted_or_rejected() {
    let scene = Scene::parse(SCENE).expect("valid");
    let mut dice = RandomNumbers(0xca5e);
    let values =
        ["(0, -1, 0)", "2e9", "[(region: Rect((0, 0.5), (0, 1)))]", "Box((0.1, 0.1, 0.1))", "{\"tip\": (1, 0)}"];
    let paths = ["gravity", "sheets.leaf.material.young", "sheets.0.pins", "bodies.wedge.shape", "sheets.0.probes"];
    for round in 0..3000 {
        let (path, value) = (paths[round % 5], values[dice.below(5)]);
        let (path, value) =
            (if round % 3 == 0 { damaged(path, &mut dice) } else { path.into() }, damaged(value, &mut dice));
        if let Err(error) = scene.with_override(&path, &value) {
            assert!(!error.problem.is_empty(), "{path}={value}");
        }
    }
    for (path, value) in paths.iter().zip(values) {
        scene.with_override(path, value).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn damaged_files_are_accepted_or_rejected() {
    let read = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name);
        std::fs::read_to_string(path).expect("readable")
    };
    let mut dice = RandomNumbers(0xf11e);
    let (sheet, walls, panel) =
        (read("sheets/slamm_5x2x5.sht"), read("polyhedra/two_walls.pol"), read("heaters/panel.heater"));
    for _ in 0..500 {
        if let Ok(file) = sht::read_sht(&damaged(&sheet, &mut dice)) {
            let _ = sheetwork::sheet::from_file(&file);
        }
        if let Ok(polyhedra) = pol::read_pol(&damaged(&walls, &mut dice)) {
            assert!(polyhedra.iter().all(|p| p.check_closed().is_ok()));
        }
        let _ = heater_file::read_heaters(&damaged(&panel, &mut dice));
    }
}

#[test]
fn the_program_survives_damaged_files() {
    let place = TestFolder::new("mutants");
    let wedge = std::fs::read_to_string(place.path("assets/polyhedra/wedge.pol")).expect("readable");
    let panel = std::fs::read_to_string(place.path("assets/heaters/panel.heater")).expect("readable");
    let sheet = std::fs::read_to_string(place.path("assets/sheets/slamm_5x2x5.sht")).expect("readable");
    place.write("sheet.ron", "(duration: 0.01, sheets: [(file: \"x.sht\")])");
    let mut dice = RandomNumbers(0xb1a5);
    for round in 0..60 {
        let (mut scene, mut text) = ("scene.ron", SCENE.to_owned());
        place.write("assets/polyhedra/wedge.pol", &wedge);
        place.write("assets/heaters/panel.heater", &panel);
        match round % 4 {
            0 => text = damaged(SCENE, &mut dice),
            1 => drop(place.write("assets/polyhedra/wedge.pol", &damaged(&wedge, &mut dice))),
            2 => drop(place.write("assets/heaters/panel.heater", &damaged(&panel, &mut dice))),
            _ => {
                place.write("x.sht", &damaged(&sheet, &mut dice));
                scene = "sheet.ron";
            }
        }
        place.write("scene.ron", &text);
        let small = Scene::parse(&text).map_or(true, |s| is_small(&s));
        if !small {
            continue;
        }
        let ran = place.run(&["run", scene, "--json", "--seconds", "0.01", "--dt", "0.005"]);
        match ran.status {
            Some(0 | 1) => drop(ran.json()),
            Some(2) => assert!(ran.err.starts_with("error: ") && ran.out.is_empty(), "{}", ran.err),
            other => panic!("status {other:?}: {}\n{text}", ran.err),
        }
    }
}
