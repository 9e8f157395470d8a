//! Validation of input: invalid files, overrides and parameters are rejected with a located error,
//! without a panic and without a non-finite number in a world. An unstable sheet is detected, named
//! and isolated.

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sheetwork::integrators::TABLE;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{Air, MaterialChoice, Scene, heater_file, pol, sht};
use sheetwork::sheet::Status;
use sheetwork::{InputError, World};
use sheetwork_tests::{scene_without_gravity, scenes_folder, shipped_scene, small_sheet, world};

/// Valid and invalid field paths of a scene.
const PATHS: &[&str] = &[
    "dt",
    "gravity",
    "gravity.1",
    "engine",
    "tolerance",
    "duration",
    "room.y.0",
    "room",
    "contact.friction",
    "air.factor",
    "air.per",
    "sheets",
    "sheets.0",
    "sheets.sheet.damping",
    "sheets.0.grid",
    "sheets.0.grid.1",
    "sheets.0.size.0",
    "sheets.0.material",
    "sheets.0.material.young",
    "sheets.0.material.poisson",
    "sheets.0.node_mass",
    "sheets.0.structure",
    "sheets.0.placement.position.2",
    "sheets.0.velocity",
    "sheets.0.probes.corner",
    "sheets.0.probes.new",
    "sheets.0.pins",
    "sheets.0.flexion_limit",
    "sheets.9.dt",
    "bodies.0.shape",
    "bodies.wedge.placement",
    "bodies.wedge.path",
    "camera.eye",
    "",
    ".",
    "..",
    "sheets..",
    "no.such.field",
    "name",
    "sheets.0.name",
    "base",
    "sheets.0.file",
    "heaters",
];

/// Valid and invalid values.
const VALUES: &[&str] = &[
    "0",
    "-1",
    "1e-3",
    "1e309",
    "-1e400",
    "NaN",
    "inf",
    "-inf",
    "none",
    "true",
    "\"\"",
    "()",
    "[]",
    "{}",
    "(1, 2, 3)",
    "(NaN, 0, 0)",
    "[1, 2",
    "(1, 2, 3, 4)",
    "trimm",
    "rk4",
    "4294967296",
    "0.1.2",
    "(5, 2, 5)",
    "Box((0.1, 0.1, 0.1))",
    "Ball(-1)",
    "HalfSpace",
    "File(\"nowhere.pol\")",
    "(young: 2e9)",
    "(yung: 2)",
    "[(region: All)]",
    "\u{0}",
    "é",
    "🙂",
    "((((((",
    "Some(1)",
    "(NaN, NaN)",
];

fn wedge_text() -> String {
    std::fs::read_to_string(scenes_folder().join("wedge.ron")).expect("a shipped scene")
}

/// Whether an error has a text of reasonable length.
fn is_useful(error: &InputError) -> bool {
    !error.problem.is_empty() && error.to_string().len() < 5000
}

/// 1,000 cases, equal in each run unless the seed `PROPTEST_RNG_SEED` is set.
fn drawn_cases() -> ProptestConfig {
    let config = ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() };
    let rng_seed = if config.rng_seed == RngSeed::Random { RngSeed::Fixed(1) } else { config.rng_seed };
    ProptestConfig { rng_seed, ..config }
}

proptest! {
    #![proptest_config(drawn_cases())]

    #[test]
    fn random_text_never_panics(text in ".{0,200}") {
        for error in [Scene::parse(&text).err().map(InputError::from), sht::read_sht(&text).err(), pol::read_pol(&text).err(),
            heater_file::read_heaters(&text).err()].into_iter().flatten() {
            prop_assert!(is_useful(&error), "{error:?}");
        }
    }

    #[test]
    fn scene_like_text_never_panics(text in "[()\\[\\]{}:,\"a-z0-9_.eE+\\- \n/*#NaNinfSome]{0,300}") {
        if let Err(error) = Scene::parse(&text) {
            prop_assert!(is_useful(&error), "{error:?}");
        }
    }

    #[test]
    fn a_scene_with_changed_bytes_is_accepted_or_rejected_at_a_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(
            b"()[]{}:,\"'.-+e0123456789NaIif \n/*x".to_vec())), 1..6),
        cut in any::<prop::sample::Index>(), cuts in any::<bool>(),
    ) {
        let mut bytes = wedge_text().into_bytes();
        for (at, byte) in &changes {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        if cuts {
            bytes.truncate(cut.index(bytes.len()));
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        match Scene::parse(&text) {
            // An accepted scene survives a round trip through text.
            Ok(scene) => {
                let again = Scene::parse(&scene.to_text().expect("serialisable")).expect("its own text");
                prop_assert_eq!(again, scene);
            }
            Err(error) => {
                prop_assert!(is_useful(&error), "{error:?}");
                let line = error.line.unwrap_or(0);
                prop_assert!(line >= 1 && line <= text.lines().count() + 1, "{error:?}");
            }
        }
    }

    #[test]
    fn random_overrides_are_accepted_or_rejected_by_name(
        path in prop_oneof![prop::sample::select(PATHS).prop_map(str::to_owned), "[a-z0-9._]{0,20}"],
        value in prop_oneof![prop::sample::select(VALUES).prop_map(str::to_owned), ".{0,20}",
            any::<f64>().prop_map(|v| v.to_string())],
    ) {
        let scene = shipped_scene("wedge");
        match scene.with_override(&path, &value) {
            Ok(changed) => {
                // An accepted value is in range, so the scene passes as a file.
                let text = changed.to_text().expect("serialisable");
                prop_assert!(Scene::parse(&text).is_ok(), "{path}={value}");
            }
            Err(error) => {
                prop_assert!(is_useful(&error), "{error:?}");
                prop_assert!(!error.field.is_empty() || path.is_empty(), "{path}={value}: {error:?}");
            }
        }
    }

    #[test]
    fn no_parameter_accepts_a_non_finite_number(
        which in any::<prop::sample::Index>(),
        value in prop_oneof![prop::sample::select(VALUES).prop_map(str::to_owned), any::<f64>().prop_map(|v| v.to_string()),
            (any::<f64>(), any::<f64>(), any::<f64>()).prop_map(|(x, y, z)| format!("({x}, {y}, {z})"))],
    ) {
        let mut world = world(&scene_without_gravity(small_sheet(sheetwork::mesh::structure::StructureKind::Provot2d, 0.1), IntegratorKind::Verlet));
        let before = world.parameters();
        let path = before[which.index(before.len())].path.clone();
        match world.set(&path, &value) {
            Ok(old) => {
                let now = world.parameters();
                let of = |all: &[sheetwork::Parameter]| all.iter().find(|p| p.path == path).map(|p| p.value.clone());
                prop_assert_eq!(Some(old), of(&before));
                let set = of(&now).unwrap_or_default();
                prop_assert!(!set.contains("NaN") && !set.contains("inf"), "{path} is {set}");
                // The world accepts its own text of a parameter.
                prop_assert!(world.set(&path, &set).is_ok(), "{path} = {set}");
            }
            Err(error) => {
                prop_assert_eq!(&error.field, &path);
                prop_assert_eq!(world.parameters(), before, "a refused value changed something");
            }
        }
    }
}

#[test]
fn setters_of_a_world_reject_non_finite_numbers() {
    let mut world = world(&shipped_scene("wedge"));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(world.set_dt(bad).expect_err("bad").field, "dt");
        assert_eq!(world.set_tolerance(bad).expect_err("bad").field, "tolerance");
        assert_eq!(world.set_gravity(DVec3::new(0.0, bad, 0.0)).expect_err("bad").field, "gravity.1");
        assert_eq!(
            world.set_air(Air { factor: bad, per: 1.0, ..Air::default() }).expect_err("bad").field,
            "air.factor"
        );
        assert_eq!(world.set_air(Air { factor: 0.5, per: bad, ..Air::default() }).expect_err("bad").field, "air.per");
        let sheet = &mut world.sheets_mut()[0];
        assert_eq!(sheet.set_damping(bad).expect_err("bad").field, "damping");
        let mut material = sheet.material().clone();
        material.young = bad;
        assert_eq!(sheet.set_material(material).expect_err("bad").field, "material.young");
    }
    world.step();
    assert!(world.sheets()[0].state.x.iter().all(DVec3::is_finite));
}

#[test]
fn invalid_fields_are_named_with_line_value_and_range() {
    let text = wedge_text();
    let line_of = |what: &str| text.lines().position(|l| l.contains(what)).expect("there") + 1;
    for (from, to, field, says) in [
        ("dt: 0.005", "dt: -0.005", "dt", "-0.005 s is outside"),
        ("damping: 0.115", "damping: NaN", "sheets.0.damping", "NaN"),
        ("node_mass: 4e-5", "node_mass: -4e-5", "sheets.0.node_mass", "-4e-5 kg"),
        ("gap: 0.001", "gap: 0", "sheets.0.gap", "outside"),
        ("engine: \"euler-richardson\"", "engine: \"newton\"", "engine", "newton"),
        ("structure: \"trimm\"", "structure: \"tram\"", "sheets.0.structure", "trimm"),
        ("grid: (11, 2, 11)", "grid: (11, 2)", "sheets.0.grid", ""),
        ("grid: (11, 2, 11)", "grid: (1, 2, 11)", "sheets.0.grid.0", "2 to 2000"),
        ("material: \"thesis\"", "material: \"wood\"", "sheets.0.material", "hips"),
        ("restitution: 0.1", "restitution: 1.5", "contact.restitution", "0 to 1"),
        ("\"corner\": (0, 0)", "\"corner\": (0, 2)", "sheets.0.probes.corner.1", "0 to 1"),
    ] {
        let bad = text.replacen(from, to, 1);
        assert_ne!(bad, text, "{from} is not in the scene");
        let error = Scene::parse(&bad).expect_err(to);
        assert!(error.field.starts_with(field), "{to}: {error:?}");
        assert!(error.problem.contains(says), "{to}: {error}");
        assert_eq!(error.line, Some(line_of(from)), "{to}: {error}");
    }
}

#[test]
fn numbers_in_lists_that_are_not_plain_are_named_with_index_and_range() {
    let sheet = "(sheets: [(structure: \"shell\", FIELD)])";
    let body = "(bodies: [(shape: Polyhedron((vertices: [(0, 0, 0),\n(1, NUMBER, 0)], faces: [])))])";
    for (text, field, range) in [
        (sheet.replace("FIELD", "outline: Polygon([(0, 0),\n(NUMBER, 1)])"), "sheets.0.outline.1.0", "-1000 to 1000 m"),
        (sheet.replace("FIELD", "cuts: [[(0, 0),\n(0, NUMBER)]]"), "sheets.0.cuts.0.1.1", "-1000 to 1000 m"),
        (
            sheet.replace("FIELD", "material: (softening: [(20, 1),\n(NUMBER, 0.5)])"),
            "sheets.0.material.softening.1.0",
            "-273.15 to 5000 °C",
        ),
        (body.to_owned(), "bodies.0.shape.vertices.1.1", "-10000 to 10000 m"),
    ] {
        for number in ["nan", "3 kg", "3kg"] {
            let error = InputError::from(Scene::parse(&text.replace("NUMBER", number)).expect_err(number));
            let problem = format!("\"{number}\" is not a plain number ({range})");
            assert_eq!((error.line, error.field.as_str(), error.problem), (Some(2), field, problem));
        }
    }
    let set = |path: &str, value: &str| shipped_scene("flag").with_override(path, value).expect_err(value).to_string();
    assert_eq!(
        set("sheets.0.cuts", "[[(0, 0), (3 kg, 1)]]"),
        "sheets.0.cuts.0.1.0: \"3 kg\" is not a plain number (-1000 to 1000 m)"
    );
    assert_eq!(set("sheets.0.size", "(nan, 1)"), "sheets.0.size.0: \"nan\" is not a plain number (1e-6 to 1000 m)");
    assert!(set("sheets.0.size", "(1, 3 kg)").starts_with("sheets.0.size.1: kg is a unit of mass"));
}

#[test]
fn a_temperature_slope_needs_a_temperature() {
    let scene =
        |fields: &str| Scene::parse(&format!("(bodies: [(shape: Ball(0.1), temperature_slope: (0, 9, 0){fields})])"));
    let error = InputError::from(scene("").expect_err("cold"));
    assert_eq!(error.field, "bodies.0.temperature_slope");
    assert!(error.problem.contains("needs a `temperature`"), "{error}");
    for fields in [", temperature: 60", ", temperature_schedule: [(time: 0, temperature: 60)]"] {
        scene(fields).expect("a hot body");
    }
}

#[test]
fn a_slit_outside_the_outline_is_refused_with_its_place() {
    let build = |slit: &str| {
        let slits = format!("slits: [((0.5, 0.2), (0.5, 0.8)), {slit}]");
        let sheet = format!("structure: \"shell\", grid: (21, 1, 21), outline: Disc(radius: 0.1), {slits}");
        World::new(&Scene::parse(&format!("(sheets: [({sheet})])")).expect("values in range")).map(drop)
    };
    let error = InputError::from(build("((0, 0), (0, 0.02))").expect_err("in the corner"));
    assert_eq!(error.field, "sheets.0.slits.1");
    let place = "from (-0.1, -0.1) to (-0.1, -0.096) m crosses no cell of the sheet";
    assert!(error.problem.contains(place) && error.problem.ends_with("from (-0.1, -0.1) to (0.1, 0.1) m"), "{error}");
    build("((0, 0.5), (0.1, 0.5))").expect("from the border");
}

#[test]
fn an_unstable_sheet_is_detected_named_and_isolated() {
    // Two sheets, one with springs a million times too stiff for the step.
    for engine in TABLE.iter().filter(|e| !e.adaptive && !e.implicit) {
        let mut scene =
            scene_without_gravity(small_sheet(sheetwork::mesh::structure::StructureKind::Trimm, 0.1), engine.kind);
        scene.dt = 2e-3;
        let mut mad = scene.sheets[0].clone();
        mad.name = "mad".into();
        mad.placement.position = DVec3::new(1.0, 0.0, 0.0);
        let MaterialChoice::Inline(material) = &mut mad.material else { panic!("in line") };
        material.young = 1e10;
        let alone = scene.clone();
        scene.sheets.insert(0, mad);
        let run = |scene: &Scene| {
            let mut world = world(scene);
            for sheet in world.sheets_mut() {
                sheetwork_tests::excite_randomly(sheet, 0.01, 1);
            }
            (0..200).for_each(|_| _ = world.step());
            world
        };
        let both = run(&scene);
        let mad = both.unstable().expect("caught");
        assert_eq!(mad.name, "mad", "{}", engine.name);
        assert!(matches!(mad.state.status, Status::Unstable { time, place, .. } if time < 0.4 && place.is_finite()));
        assert!(mad.state.x.iter().chain(mad.state.v.iter()).all(|p| p.is_finite()), "{}", engine.name);
        let events: Vec<_> = both.events().iter().filter(|e| e.kind == EventKind::Unstable).collect();
        assert!(events.len() == 1 && events[0].sheet == "mad");
        let report = both.report(0.0, &[]);
        assert!(report.status.contains("unstable: mad"), "{}", report.status);
        // The other sheet continues as if it were alone.
        assert_eq!(both.sheets()[1].state.x, run(&alone).sheets()[0].state.x, "{}", engine.name);
    }
}

#[test]
fn an_implicit_integrator_is_stable_for_very_stiff_sheets() {
    for engine in TABLE.iter().filter(|e| e.implicit) {
        let mut scene =
            scene_without_gravity(small_sheet(sheetwork::mesh::structure::StructureKind::Trimm, 0.1), engine.kind);
        scene.dt = 2e-3;
        let MaterialChoice::Inline(material) = &mut scene.sheets[0].material else { panic!("in line") };
        material.young = 1e10;
        let mut world = world(&scene);
        sheetwork_tests::excite_randomly(&mut world.sheets_mut()[0], 0.01, 1);
        let before = world.sheets()[0].energy(DVec3::ZERO).total;
        (0..200).for_each(|_| _ = world.step());
        assert!(world.unstable().is_none(), "{}", engine.name);
        let after = world.sheets()[0].energy(DVec3::ZERO).total;
        assert!(after < 1.001 * before, "{}: {after} of {before} J", engine.name);
    }
}

#[test]
fn a_non_finite_number_set_by_a_program_is_detected() {
    for engine in TABLE {
        let scene =
            scene_without_gravity(small_sheet(sheetwork::mesh::structure::StructureKind::Samm, 0.1), engine.kind);
        let mut world = World::new(&scene).expect("valid");
        world.sheets_mut()[0].state.v.set(3, DVec3::new(0.0, f64::NAN, 0.0));
        world.step();
        assert!(world.unstable().is_some(), "{}", engine.name);
        assert!(world.sheets()[0].state.x.iter().all(DVec3::is_finite), "{}", engine.name);
    }
}

/// Scenes of random draws that have exposed a defect, unchanged.
#[test]
fn scenes_of_the_corpus_run_without_a_panic() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/corpus/scene");
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("corpus").map(|f| f.expect("a file").path()).collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let text = std::fs::read_to_string(&file).expect("text");
        let scene = Scene { repair: true, ..Scene::parse(&text).expect("a scene") };
        let mut world = match World::new(&scene) {
            Ok(world) => world,
            Err(error) => {
                assert!(error.to_string().contains("starts inside"), "{}: {error}", file.display());
                continue;
            }
        };
        while world.time() < 0.5 {
            world.step();
        }
        let mut places = world.sheets().iter().flat_map(|s| s.state.x.iter().chain(s.state.v.iter()));
        assert!(places.all(DVec3::is_finite), "{}", file.display());
        assert!(world.unstable().is_none(), "{}", file.display());
    }
}
