//! Snapshots as bytes: bit-exact continuation in the saved world and in a new one of the same
//! scene, and rejection of invalid snapshots.
//!
//! `sheetwork bench rollback` covers all scenes for 600 steps.

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::scene::Scene;
use sheetwork_tests::{one_of_every_structure, shipped_scene, state_hash, world};

/// Hashes after each of `steps` steps.
fn run(world: &mut World, steps: u32) -> Vec<u64> {
    let one = |_| {
        world.step();
        state_hash(world)
    };
    (0..steps).map(one).collect()
}

/// Steps, saves, and continues; then repeats the continuation from the snapshot in two ways.
/// Returns the number of steps to the first difference.
fn first_difference(scene: &Scene, first: u32, steps: u32) -> Option<(&'static str, usize)> {
    // The draws of other tests may start inside a body.
    let mut world = World::with_start_overlaps(scene).unwrap_or_else(|e| panic!("{e}"));
    run(&mut world, first);
    let saved = world.serialise();
    let wanted = run(&mut world, steps);
    let end = world.serialise();
    let mut fresh = World::with_start_overlaps(scene).unwrap_or_else(|e| panic!("{e}"));
    for (name, world) in [("the same world", &mut world), ("a new world", &mut fresh)] {
        world.deserialise(&saved).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
        assert!(world.serialise() == saved, "{}: {name} saves something else than it has loaded", scene.name);
        let found = run(world, steps);
        if let Some(at) = (0..wanted.len()).find(|i| wanted[*i] != found[*i]) {
            return Some((name, at + 1));
        }
        // Compares the complete state, beyond the hashed part.
        if world.serialise() != end {
            return Some((name, wanted.len()));
        }
    }
    None
}

fn continues(scene: &Scene, name: &str, first: u32, steps: u32) {
    let apart = first_difference(scene, first, steps);
    assert!(
        apart.is_none(),
        "{name}: {} differs after {} steps",
        apart.unwrap_or_default().0,
        apart.unwrap_or_default().1
    );
}

/// Scenes with contact, dynamic bodies, heat, creep, fracture, attachments and adhesion.
const SAMPLE: &[(&str, u32, u32)] = &[
    ("wedge", 40, 60),
    ("slide_11", 60, 60),
    ("flat_floor_e01", 30, 60),
    ("box_on_sheet", 30, 40),
    ("ball_on_sheet", 20, 30),
    ("needle", 20, 20),
    ("folded_card", 30, 20),
    ("flag", 30, 40),
    ("hot_sag", 60, 60),
    ("heat_gun", 40, 40),
    ("oven_wedge", 40, 40),
    ("heater_wedge", 30, 30),
    ("torn_strip", 60, 40),
    ("sticky_film", 40, 30),
    ("creased_sheet", 30, 40),
];

#[test]
fn shipped_scenes_continue_bit_exactly_from_a_snapshot() {
    for (name, first, steps) in SAMPLE {
        continues(&shipped_scene(name), name, *first, *steps);
    }
}

#[test]
fn every_integrator_and_structure_continues_bit_exactly_from_a_snapshot() {
    for engine in TABLE {
        let scene = one_of_every_structure(engine.kind, 0.12);
        continues(&scene, engine.name, 60, 60);
    }
}

#[test]
fn a_snapshot_restores_parameters_grabs_and_moved_bodies() {
    let scene = shipped_scene("materials_hanging");
    let mut world = world(&scene);
    let name = world.sheets()[1].name.clone();
    let warm = shipped_scene("oven_wedge");
    let meddle = |world: &mut World| {
        world.sheets_mut()[0].grab((1.0, 0.5), 30.0).expect("free");
        world.sheets_mut()[0].pull(0, DVec3::new(0.1, 0.3, 0.2)).expect("there");
        world.set(&format!("sheets.{name}.material.young"), "2e8").expect("in range");
        world.set("gravity", "(1, -3, 0)").expect("in range");
        world.set("dt", "0.01").expect("in range");
    };
    run(&mut world, 20);
    let before = world.serialise();
    let plain = run(&mut world, 10);
    world.deserialise(&before).expect("its own");
    meddle(&mut world);
    run(&mut world, 5);
    let amid = world.serialise();
    let meddled = run(&mut world, 10);
    assert_ne!(plain, meddled);
    // Restores the earlier state and continues; restores the later state in the same world and in a
    // new one.
    world.deserialise(&before).expect("its own");
    assert!(world.sheets()[0].pulls().is_empty() && world.gravity().x == 0.0);
    assert_eq!(run(&mut world, 10), plain);
    let mut fresh = self::world(&scene);
    for world in [&mut world, &mut fresh] {
        world.deserialise(&amid).expect("of this scene");
        assert_eq!((world.dt(), world.sheets()[0].pulls().len()), (0.01, 1));
        assert_eq!(run(world, 10), meddled);
    }
    // An oven whose temperature was changed, and a body whose motion was changed.
    let mut world = self::world(&warm);
    let body = world.body_ids().next().expect("its own");
    run(&mut world, 10);
    let before = world.serialise();
    let plain = run(&mut world, 10);
    world.set("oven.temperature", "60").expect("in range");
    assert!(world.move_body(body, DVec3::new(0.0, 0.01, 0.0), glam::DQuat::IDENTITY));
    run(&mut world, 10);
    let sent = world.serialise();
    let on = run(&mut world, 10);
    world.deserialise(&before).expect("its own");
    assert_eq!(run(&mut world, 10), plain);
    world.deserialise(&sent).expect("its own");
    assert_eq!(run(&mut world, 10), on);
}

#[test]
fn a_snapshot_restores_a_state_before_heat_and_fracture() {
    for (name, first) in [("torn_strip", 400), ("melting_hole", 100)] {
        let mut world = world(&shipped_scene(name));
        let before = world.serialise();
        let wanted = run(&mut world, 5);
        run(&mut world, first);
        world.deserialise(&before).expect("its own");
        assert_eq!(run(&mut world, 5), wanted, "{name}");
    }
    // Temperatures set by a program on a sheet without temperatures.
    let mut world = world(&shipped_scene("materials_hanging"));
    run(&mut world, 3);
    let before = world.serialise();
    let wanted = run(&mut world, 5);
    world.sheets_mut()[0].set_temperatures(|i| 20.0 + 0.1 * i as f64).expect("in range");
    let warm = run(&mut world, 5);
    assert_ne!(warm, wanted);
    world.deserialise(&before).expect("its own");
    assert!(world.sheets()[0].heat().is_none());
    assert_eq!(run(&mut world, 5), wanted);
}

#[test]
fn a_light_snapshot_continues_bit_exactly_with_unchanged_parameters() {
    let mut world = world(&shipped_scene("hot_sag"));
    run(&mut world, 40);
    let snapshot = world.snapshot();
    let wanted = run(&mut world, 30);
    world.restore(&snapshot).expect("its own");
    assert_eq!(run(&mut world, 30), wanted);
    // A changed parameter keeps its value.
    let damping = format!("sheets.{}.damping_ratio", world.sheets()[0].name);
    world.set(&damping, "0.9").expect("in range");
    world.restore(&snapshot).expect("its own");
    assert_eq!(world.sheets()[0].damping_ratio(), 0.9);
    assert_ne!(run(&mut world, 30), wanted);
}

#[test]
fn an_invalid_snapshot_is_rejected_without_effect() {
    let scene = shipped_scene("box_on_sheet");
    let mut world = world(&scene);
    run(&mut world, 5);
    let saved = world.serialise();
    let state = state_hash(&world);
    let mut says = |bytes: &[u8], what: &str| {
        let error = world.deserialise(bytes).expect_err(what);
        assert!(error.problem.contains(what), "{error}");
        assert_eq!(state_hash(&world), state);
    };
    says(b"", "not a snapshot");
    says(b"SHEETWRK", "cut off");
    says(&saved[..20], "cut off");
    says(&saved[..saved.len() - 1], "cut off");
    says(&[&saved[..], &[0]].concat(), "goes on after its end");
    let changed = |at: usize, by: u8| {
        let mut bytes = saved.clone();
        bytes[at] ^= by;
        bytes
    };
    // The version follows the eight bytes of the name.
    says(&[&saved[..8], &1u32.to_le_bytes(), &saved[12..]].concat(), "version 1");
    says(&changed(saved.len() / 2, 1), "damaged");
    says(&self::world(&shipped_scene("wedge")).serialise(), "other sheets or bodies");
    assert!(world.serialise() == saved);
    // An additional sheet makes it another world.
    world.add_sheet(&scene.sheets[0]).expect("valid");
    assert!(world.deserialise(&saved).expect_err("other").problem.contains("other sheets"));
}

#[test]
fn a_snapshot_has_at_most_200_bytes_per_node_and_500_with_a_loss_factor() {
    for (damping, most) in [(0.2, 200), (0.015, 500)] {
        let scene = Scene::parse(&format!(
            r#"(engine: "tr-bdf2", dt: 0.0166, sheets: [(structure: "shell", grid: (21, 1, 21), size: (0.25, 0.25),
                material: "hips", damping_ratio: {damping}, pins: [(region: Left, clamp: true)])])"#
        ));
        let mut world = world(&scene.expect("valid"));
        run(&mut world, 30);
        let bytes = world.serialise().len();
        assert!(bytes < most * 441, "{} a mass", bytes / 441);
    }
}
