//! Sleeping: resting sheets and bodies sleep in finite time despite residual motion of contact, and
//! a snapshot taken on the way continues bit for bit.

use sheetwork::World;
use sheetwork::scene::Scene;
use sheetwork::sheet::Status;
use sheetwork_tests::world_of;

/// A sheet fixed at two edges, and two balls that roll into its dip until they touch.
fn balls_in_dip(engine: &str) -> World {
    world_of(&format!(
        r#"(engine: "{engine}", dt: 0.0166666666666667, contact: (friction: 0.3, restitution: 0.5),
            sheets: [(name: "sheet", structure: "shell", grid: (9, 1, 9), size: (0.25, 0.25), material: "pet",
                pins: [(region: Left, clamp: true), (region: Right, clamp: true)])],
            bodies: [(name: "a", shape: Ball(0.0106919), density: 200,
                placement: (position: (0.0413014, 0.03, -0.026105), rotation: (22.7695, 10.881, 21.4405))),
                (name: "b", shape: Ball(0.0149983), density: 400,
                placement: (position: (-0.0161922, 0.065, 0.0208194), rotation: (-6.46346, -9.3396, 26.1021)))])"#
    ))
}

/// Two sheets on a floor, one across the other.
fn crossed(engine: &str) -> World {
    world_of(&format!(
        r#"(engine: "{engine}", dt: 0.0166666666666667, contact: (friction: 0.6, restitution: 0.5),
            sheets: [(name: "a", structure: "shell", grid: (9, 1, 9), size: (0.214916, 0.205633), material: "hips",
                placement: (position: (0.00968298, 0.15, -0.0233903), rotation: (-18.9225, -20.8492, 9.85581))),
                (name: "b", structure: "shell", grid: (9, 1, 9), size: (0.220356, 0.196079), material: "rubber",
                placement: (position: (0.0110661, 0.21, 0.0134563), rotation: (-14.4983, 9.21319, -14.4047)))],
            bodies: [(name: "floor", shape: HalfSpace)])"#
    ))
}

fn asleep(world: &World) -> bool {
    world.sheets().iter().all(|s| s.state.status == Status::Asleep)
}

/// Time at which all sheets sleep, s.
fn time_of_rest(world: &mut World, within: f64) -> f64 {
    while !asleep(world) {
        world.step();
        assert!(world.time() < within, "awake at {} s", world.time());
    }
    world.time()
}

/// Whether body `index` sleeps.
fn body_sleeps(world: &World, index: usize) -> bool {
    world.rigid().is_some_and(|rigid| rigid.is_asleep(index))
}

#[test]
fn balls_in_the_dip_of_a_fixed_sheet_come_to_rest() {
    for engine in ["tr-bdf2", "bdf2", "backward-euler"] {
        let mut world = balls_in_dip(engine);
        let time = time_of_rest(&mut world, 20.0);
        println!("{engine}: {time:.2} s");
        assert!(body_sleeps(&world, 0) && body_sleeps(&world, 1), "{engine}");
    }
}

#[test]
fn slow_motion_gains_almost_no_energy() {
    let mut world = balls_in_dip("tr-bdf2");
    let slow = |world: &World| {
        let speed = |index: usize| world.rigid()?.state(index).map(|state| state.velocity().length());
        (0..2).filter_map(speed).all(|v| v < 0.03)
    };
    let (mut gained, mut lost) = (0.0, 0.0);
    while !asleep(&world) {
        let (before, was_slow) = (world.energy().total, slow(&world));
        world.step();
        let gain = world.energy().total - before;
        if was_slow && slow(&world) {
            *(if gain > 0.0 { &mut gained } else { &mut lost }) += gain.abs();
        }
    }
    println!("gained {gained:e} and lost {lost:e} J");
    assert!(gained < 0.2 * lost, "{gained:e} of {lost:e} J");
}

#[test]
fn sheets_across_one_another_fall_asleep() {
    for engine in ["tr-bdf2", "bdf2", "backward-euler"] {
        let time = time_of_rest(&mut crossed(engine), 10.0);
        println!("{engine}: {time:.2} s");
    }
}

#[test]
fn a_ball_that_starts_in_a_sheet_leaves_it_without_gain_of_energy() {
    let scene = Scene::parse(
        r#"(engine: "tr-bdf2", dt: 0.0166666666666667, contact: (friction: 0.5, restitution: 0),
            sheets: [(name: "sheet", structure: "shell", grid: (7, 1, 7), size: (0.1, 0.1), material: "card",
                placement: (position: (0.03, 0.012, 0), rotation: (0, 0, -12)))],
            bodies: [(name: "ball", shape: Ball(0.02), density: 1000, placement: (position: (-0.015, 0.02, 0)), spin: (0, 3, 0)),
                (name: "floor", shape: HalfSpace)])"#,
    );
    // The ball starts through the rim of the sheet.
    let mut world = World::with_start_overlaps(&scene.expect("a scene")).expect("a world");
    let start = world.energy().total;
    let time = time_of_rest(&mut world, 15.0);
    println!("{time:.2} s");
    let apart = world.penetrations();
    assert!(apart.is_empty(), "{apart:?}");
    assert!(world.energy().total < start, "{} J of {start} J", world.energy().total);
}

#[test]
fn a_swinging_sheet_does_not_sleep() {
    // Half a millimetre at the tip, with little damping: visible, and ten times the sleep
    // threshold.
    let mut world = world_of(
        r#"(engine: "tr-bdf2", dt: 0.001, gravity: (0, 0, 0),
            sheets: [(name: "strip", structure: "shell", grid: (13, 1, 3), size: (0.2, 0.03), damping_ratio: 0.001,
                material: (young: 3e9, density: 1050, thickness: 5e-4), pins: [(region: Left, clamp: true)])])"#,
    );
    let sheet = &mut world.sheets_mut()[0];
    let (low, high) = sheet.state.x.bounds().expect("masses");
    for i in 0..sheet.node_count() {
        let along = (sheet.state.x.get(i).x - low.x) / (high.x - low.x);
        sheet.state.v.set(i, 0.03 * along * along * glam::DVec3::Y);
    }
    let mut furthest = 0.0_f64;
    while world.time() < 3.0 {
        world.step();
        let sheet = &world.sheets()[0];
        furthest = furthest.max(sheet.state.x.iter().map(|p| p.y.abs()).fold(0.0, f64::max));
        assert_eq!(sheet.state.status, Status::Awake, "at {} s", world.time());
    }
    println!("{:.3} mm", 1e3 * furthest);
    assert!(furthest > 2e-4 && furthest < 2e-3, "{furthest}");
}

#[test]
fn a_snapshot_within_the_sleep_delay_continues_bit_exactly() {
    for mut world in [balls_in_dip("tr-bdf2"), crossed("bdf2")] {
        let rest = time_of_rest(&mut world, 20.0);
        world.reset().expect("its scene");
        // The sleep delay, with its start positions, is part of the state in the last half second.
        while world.time() < rest - 0.3 {
            world.step();
        }
        let (saved, light) = (world.serialise(), world.snapshot());
        assert!(!asleep(&world));
        time_of_rest(&mut world, 20.0);
        let end = world.serialise();
        world.deserialise(&saved).expect("its own");
        assert_eq!(time_of_rest(&mut world, 20.0), rest);
        assert!(world.serialise() == end, "goes on otherwise from what was saved");
        world.restore(&light).expect("its own");
        assert_eq!(time_of_rest(&mut world, 20.0), rest);
    }
}
