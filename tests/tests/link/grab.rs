//! Grabs: the force on the hand equals statics, from this process and from another.

use glam::DVec3;
use sheetwork::World;
use sheetwork::scene::Scene;

use super::place::TestLink;

/// A free sheet of 0.2 m x 0.1 m in normal gravity; its mass is ρ t a b.
fn free() -> World {
    let scene = r#"(engine: "tr-bdf2", dt: 0.001,
        sheets: [(name: "free", structure: "shell", grid: (9, 1, 5), size: (0.2, 0.1), material: "pet", damping_ratio: 0.5)])"#;
    World::new(&Scene::parse(scene).expect("valid")).expect("valid")
}

#[test]
fn the_force_on_a_hand_equals_the_weight_of_the_sheet() {
    let mut world = free();
    let weight = world.sheets()[0].total_mass() * 9.81;
    let sheet = &mut world.sheets_mut()[0];
    // Between nodes, so that all three nodes of a triangle carry a part.
    let first = sheet.grab((0.48, 0.55), 500.0).expect("taken");
    let begin = sheet.pulls()[first].target;
    for bad in [DVec3::NAN, DVec3::splat(1e9)] {
        assert!(sheet.pull(first, bad).is_err());
    }
    assert!(sheet.grab((1.5, 0.0), 1.0).is_err() && sheet.grab((0.5, 0.5), f64::NAN).is_err());
    world.set_dt(1.0 / 240.0).expect("allowed");
    world.advance(2.0);
    // The sheet swings without damping: the mean force on the hand is the weight plus the change of
    // momentum, m g + m Δv / T.
    let momentum = |world: &World| world.sheets()[0].momentum();
    let before = momentum(&world);
    let mut borne = DVec3::ZERO;
    for _ in 0..1200 {
        let sheet = &world.sheets()[0];
        borne += 0.5 * sheet.pulls()[first].force(&sheet.state.x);
        world.step();
        let sheet = &world.sheets()[0];
        borne += 0.5 * sheet.pulls()[first].force(&sheet.state.x);
    }
    let expected = DVec3::Y * weight + (momentum(&world) - before) / 5.0;
    let mean = borne / 1200.0;
    assert!(mean.distance(expected) < 2e-3 * weight, "{mean} N, and {expected} N by momentum");
    let sheet = &world.sheets()[0];
    assert!(begin.y - sheet.pulls()[first].point(&sheet.state.x).y < 3.0 * weight / 500.0);
    // A stiff spring within one step: the point is at the hand.
    let sheet = &mut world.sheets_mut()[0];
    let second = sheet.grab((0.1, 0.1), 1e7).expect("taken");
    let place = sheet.pulls()[second].target + DVec3::new(0.0, 1e-3, 0.0);
    sheet.pull(second, place).expect("pulled");
    world.advance(1.0);
    let sheet = &mut world.sheets_mut()[0];
    assert!(world_is_sound(sheet) && sheet.pulls()[second].point(&sheet.state.x).distance(place) < 1e-6);
    assert!(sheet.release_grab(first) && sheet.release_grab(0) && !sheet.release_grab(0) && sheet.pulls().is_empty());
    let before = sheet.centre_of_mass().y;
    world.advance(0.1);
    assert!(world.sheets()[0].centre_of_mass().y < before, "it falls");
}

fn world_is_sound(sheet: &sheetwork::sheet::Sheet) -> bool {
    sheet.state.status == sheetwork::sheet::Status::Awake && sheet.state.x.max_squared().is_finite()
}

#[test]
fn another_process_grabs_and_is_released_after_its_death() {
    let place = TestLink::new("pull");
    let _game = place.start("game", &[]);
    let client = place.attach();
    assert!(client.grab("nobody", (0.5, 0.5), 10.0).is_err());
    let grab = client.grab("strip", (1.0, 0.5), 20.0).expect("taken");
    let begin = client.pull(grab, [0.1, 0.0, 0.0]).expect("felt").position;
    let mut felt = None;
    for i in 0..300 {
        let target = [begin[0], begin[1] + 0.02 * f64::from(i.min(100)) / 100.0, begin[2]];
        let now = client.pull(grab, target).expect("felt");
        for axis in 0..3 {
            assert!((now.force[axis] + 20.0 * (target[axis] - now.position[axis])).abs() < 1e-9);
        }
        felt = Some(now);
    }
    let felt = felt.expect("pulled");
    assert!(felt.position[1] > begin[1] && felt.force[1] < 0.0, "the hand is pulled down, the sheet up: {felt:?}");
    assert!(client.pull(grab, [f64::NAN, 0.0, 0.0]).is_err() && client.pull(grab + 1, [0.0; 3]).is_err());
    // Longer than the time limit of a grab.
    std::thread::sleep(std::time::Duration::from_millis(2600));
    assert!(client.pull(grab, [0.0; 3]).is_err(), "it has let go");
}
