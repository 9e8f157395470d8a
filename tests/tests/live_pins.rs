//! Pins given to a running sheet, and taken from it.

use glam::DVec3;
use sheetwork::scene::{PathKey, PinSpec, Region, Scene};
use sheetwork::{SheetId, World};
use sheetwork_tests::state_hash;

fn hanging() -> (World, SheetId) {
    let scene = r#"(sheets: [(name: "card", structure: "shell", grid: (11, 1, 6), size: (0.2, 0.1), material: "paper",
        placement: (position: (0, 1, 0)), pins: [(region: Left)])])"#;
    let world = World::new(&Scene::parse(scene).expect("a scene")).expect("a world");
    let id = world.sheet_id("card").expect("there");
    (world, id)
}

fn positions(world: &World) -> Vec<DVec3> {
    world.sheets()[0].state.x.iter().collect()
}

fn largest_move(from: &[DVec3], to: &[DVec3]) -> f64 {
    from.iter().zip(to).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn a_sheet_falls_as_it_hangs_and_is_caught_where_it_is() {
    let (mut world, id) = hanging();
    world.advance(2.0);
    let (hung, fast) = (positions(&world), world.sheets()[0].max_speed());
    assert_eq!(world.unpin(id, &Region::Left), Ok(6));
    assert_eq!(positions(&world), hung);
    world.step();
    let dt = world.dt();
    assert!(largest_move(&hung, &positions(&world)) < (fast + 9.81 * dt) * dt * 2.0, "it jumps");
    world.advance(0.2);
    let fallen = hung[0].y - positions(&world)[0].y;
    assert!((0.1..0.3).contains(&fallen), "{fallen} m");
    // Caught at the other edge, which then is led up.
    let key = |time, offset| PathKey { time, offset, ..PathKey::default() };
    let path = vec![key(0.0, DVec3::ZERO), key(1.0, DVec3::Y * 0.5)];
    let before = positions(&world);
    assert_eq!(world.pin(id, &PinSpec { path, ..PinSpec::fixed(Region::Right) }), Ok(6));
    world.advance(1.5);
    let now = positions(&world);
    for row in 0..6 {
        let node = 11 * row + 10;
        assert!(now[node].distance(before[node] + DVec3::Y * 0.5) < 1e-9, "{} {}", now[node], before[node]);
    }
    assert!(world.unstable().is_none());
}

#[test]
fn a_pin_with_an_end_counts_from_now() {
    let (mut world, id) = hanging();
    world.advance(1.0);
    assert_eq!(world.pin(id, &PinSpec { until: Some(0.5), ..PinSpec::fixed(Region::Border) }), Ok(30));
    let held = positions(&world);
    world.advance(0.45);
    assert!(largest_move(&held[..11], &positions(&world)[..11]) < 1e-12);
    world.advance(0.3);
    assert!(positions(&world)[0].y < held[0].y - 0.05);
}

#[test]
fn snapshots_hold_the_pins_of_their_time() {
    let (mut world, id) = hanging();
    world.advance(0.3);
    let hung = world.serialise();
    world.unpin(id, &Region::Left).expect("pinned");
    world.advance(0.1);
    let falling = world.serialise();
    world.advance(0.2);
    let end = state_hash(&world);
    world.deserialise(&hung).expect("its own");
    let place = positions(&world)[0];
    world.advance(0.5);
    assert_eq!(positions(&world)[0], place);
    for world in [&mut world, &mut hanging().0] {
        world.deserialise(&falling).expect("its own");
        world.advance(0.2);
        assert_eq!(state_hash(world), end);
    }
}

#[test]
fn what_a_running_sheet_cannot_be_given_is_refused() {
    let (mut world, id) = hanging();
    let refused = |world: &mut World, pin: PinSpec| world.pin(id, &pin).expect_err("refused").to_string();
    assert!(refused(&mut world, PinSpec::clamped(Region::Right)).contains("clamp"));
    assert!(refused(&mut world, PinSpec::attached(Region::Right, "arm")).contains("body"));
    assert!(refused(&mut world, PinSpec { until: Some(f64::NAN), ..PinSpec::fixed(Region::Right) }).contains("until"));
    let empty = Region::Rect((0.41, 0.42), (0.41, 0.42));
    assert!(world.pin(id, &PinSpec::fixed(empty.clone())).is_err() && world.unpin(id, &empty).is_err());
    assert_eq!(world.unpin(id, &Region::Right), Ok(0));
    // The sheet keeps its grid.
    assert!(world.remap("card", (21, 11)).expect_err("refused").to_string().contains("pinned"));
}
