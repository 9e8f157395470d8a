//! Ids of sheets, bodies and heaters while objects are added and removed, and over a reset.

use glam::{DQuat, DVec3};
use sheetwork::prelude::*;
use sheetwork::scene::HeaterSpec;

fn world() -> World {
    let scene = Scene::parse(
        r#"(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), repair: true,
            sheets: [(name: "a"), (name: "b"), ()],
            bodies: [(name: "ball", shape: Ball(0.1), mass: 1), (shape: Ball(0.2))],
            heaters: [(name: "lamp", size: (0.1, 0.1, 0.1), hot: [(face: 2, temperature: 300)]),
                (size: (0.1, 0.1, 0.1), hot: [(face: 2, temperature: 200)])])"#,
    );
    World::new(&scene.expect("valid")).expect("valid")
}

#[test]
fn the_id_of_a_sheet_outlives_the_removal_of_others_and_not_its_own() {
    let mut world = world();
    let ids: Vec<SheetId> = world.sheet_ids().collect();
    assert_eq!((ids.len(), world.sheet_id("b"), world.sheet_id("none")), (3, Some(ids[1]), None));
    assert!(world.remove_sheet(ids[0]) && !world.remove_sheet(ids[0]));
    assert!(world.get_sheet(ids[0]).is_none() && world.get_sheet_mut(ids[0]).is_none());
    assert_eq!(world.get_sheet(ids[1]).expect("there").name, "b");
    let added = world.add_sheet(&SheetSpec::new("card").named("b")).expect("valid");
    assert_eq!(world.get_sheet(added).expect("there").name, "b 2");
    assert!(added != ids[0] && world.get_sheet(ids[0]).is_none(), "the slot is used again, the id is not");
    world.advance(0.01);
    world.reset().expect("valid");
    assert_eq!(world.get_sheet(ids[1]).expect("there").name, "b");
    assert_eq!(world.get_sheet(added).expect("there").name, "b 2");
    assert_eq!(world.sheet_ids().collect::<Vec<_>>(), [ids[1], ids[2], added]);
    world.get_sheet_mut(added).expect("there").parameters.friction = 0.9;
    assert_eq!(world.sheet("b 2").expect("there").parameters.friction, 0.9);
}

#[test]
fn the_id_of_a_body_keeps_its_body_over_a_reset_that_reorders_bodies() {
    let mut world = world();
    let ball = world.body_id("ball").expect("there");
    let added = world.add_body(&BodySpec::new(Shape::Ball(0.05))).expect("valid");
    let (name, floor) = (world.body_name(added).expect("there").to_owned(), world.body_id("floor").expect("there"));
    assert!(world.remove_body(ball) && !world.remove_body(ball));
    assert!(world.get_body(ball).is_none() && world.body_name(ball).is_none());
    assert!(
        !world.move_body(ball, DVec3::ZERO, DQuat::IDENTITY) && !world.place_body(ball, DVec3::ZERO, DQuat::IDENTITY)
    );
    world.reset().expect("valid");
    // The added body is now before floor and back wall.
    assert_eq!(world.body_name(added), Some(name.as_str()));
    assert_eq!(world.body_name(floor), Some("floor"));
    assert!(world.move_body(added, DVec3::Y, DQuat::IDENTITY));
    world.step();
    assert_eq!(world.get_body(added).expect("there").origin(), DVec3::Y);
}

#[test]
fn heaters_have_ids_and_those_without_a_name_have_their_number() {
    let mut world = world();
    let (lamp, second) = (world.heater_id("lamp").expect("there"), world.heater_id("1").expect("there"));
    let spec = HeaterSpec { name: "lamp".into(), ..world.get_heater(lamp).expect("there").clone() };
    let added = world.add_heater(&spec).expect("valid");
    assert_eq!(world.get_heater(added).expect("there").name, "lamp 2");
    assert!(world.remove_heater(lamp) && !world.remove_heater(lamp));
    assert!(!world.remove_heater(second), "its number would pass to another");
    assert!(world.get_heater(lamp).is_none() && world.get_heater(second).is_some());
    let there = Placement { position: DVec3::X, ..Placement::default() };
    assert!(world.move_heater(second, &there) && !world.move_heater(lamp, &there));
    assert_eq!(world.get_heater(second).expect("there").placement, there);
    assert_eq!(world.heater_ids().collect::<Vec<_>>(), [second, added]);
}

/// A room with two balls and two sheets of five by five nodes, one metre apart.
fn room() -> World {
    let text = r#"(room: (x: (-1, 1), y: (-1, 1), z: (-1, 1)),
        bodies: [(name: "k", shape: Ball(0.02), mass: 1, placement: (position: (0.5, 0, 0)))],
        sheets: [(name: "a", grid: (5, 1, 5), size: (0.1, 0.1)),
            (name: "b", grid: (5, 1, 5), size: (0.1, 0.1), placement: (position: (1, 0, 0)))])"#;
    World::new(&Scene::parse(text).expect("valid")).expect("a world")
}

#[test]
fn a_floor_that_was_removed_is_back_after_a_reset_with_an_id_of_its_own() {
    let mut world = room();
    let ball = |name: &str| BodySpec { name: name.into(), ..BodySpec::new(Shape::Ball(0.01)) };
    let (x, y) = (world.add_body(&ball("x")).expect("a body"), world.add_body(&ball("y")).expect("a body"));
    let [floor, wall] = ["floor", "back wall"].map(|name| world.body_id(name).expect("of the room"));
    assert!(world.remove_body(floor));
    for _ in 0..3 {
        world.advance(0.05);
        world.reset().expect("resets");
        let names = [x, y, wall].map(|id| world.body_name(id).expect("still there").to_owned());
        assert_eq!(names, ["x", "y", "back wall"]);
        let back = world.body_id("floor").expect("there again");
        assert!(back != floor && world.body_name(floor).is_none());
        assert_eq!(world.body_ids().len(), 5);
    }
}

#[test]
fn a_world_reads_its_snapshot_after_a_sheet_was_removed() {
    let mut world = room();
    world.step();
    let first = world.sheet_id("a").expect("there");
    assert!(world.remove_sheet(first));
    let bytes = world.serialise();
    world.deserialise(&bytes).expect("its own snapshot");
    world.advance(0.1);
    let end = world.serialise();
    world.deserialise(&bytes).expect("its own snapshot");
    world.advance(0.1);
    assert!(world.serialise() == end, "it continues bit for bit");
}

#[test]
fn names_that_two_objects_would_share_are_refused() {
    let refused = |text: &str| Scene::parse(text).expect_err("a name twice").field.clone();
    assert_eq!(refused(r#"(sheets: [(), (name: "sheet 0")])"#), "sheets.1.name");
    let text = r#"(room: (x: (-1, 1), y: (-1, 1), z: (-1, 1)), bodies: [(name: "floor", shape: Ball(0.1))])"#;
    assert_eq!(refused(text), "bodies.0.name");
}

#[test]
fn durations_poses_and_thread_counts_out_of_range_change_nothing() {
    let mut world = room();
    world.advance(0.05);
    let before = world.serialise();
    for duration in [0.0, -5.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(world.advance(duration), 0, "{duration}");
    }
    let ball = world.body_id("k").expect("a ball");
    for position in [DVec3::NAN, DVec3::splat(1e300)] {
        assert!(
            !world.move_body(ball, position, DQuat::IDENTITY) && !world.place_body(ball, position, DQuat::IDENTITY)
        );
    }
    assert!(!world.place_body(ball, DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)));
    assert!(world.set_threads(0).is_err() && world.set_threads(usize::MAX).is_err());
    assert!(world.serialise() == before);
}

#[test]
fn a_sheet_that_becomes_unstable_stops_the_step() {
    let mut world = room();
    world.sheets_mut()[0].apply_impulse(0, DVec3::splat(1e300)).expect("finite");
    let outcomes: Vec<StepOutcome> = (0..3).map(|_| world.step().outcome()).collect();
    assert!(world.unstable().is_some() && outcomes.contains(&StepOutcome::Stopped), "{outcomes:?}");
}

#[test]
fn the_removal_of_a_far_sheet_leaves_a_pile_and_its_attachment_as_they_were() {
    let card = |name: &str, height: f64| {
        let spec = SheetSpec::new("card").named(name);
        let placement = Placement { position: DVec3::new(0.0, height, 0.0), ..Placement::default() };
        SheetSpec { grid: (7, 1, 7), size: (0.1, 0.1), placement, ..spec }
    };
    let far = card("far", 50.0);
    let ball = BodySpec { name: "ball".into(), mass: Some(0.01), ..BodySpec::new(Shape::Ball(0.01)) };
    let ball =
        BodySpec { placement: Placement { position: DVec3::new(0.0, 0.03, 0.0), ..Placement::default() }, ..ball };
    let room = "(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)))";
    let scene = Scene {
        sheets: vec![far, card("a", 1e-3), card("b", 3e-3), card("c", 6e-3)],
        ..Scene::parse(room).expect("valid")
    };
    let run = |removed: bool| {
        let mut world = World::new(&Scene { bodies: vec![ball.clone()], ..scene.clone() }).expect("valid");
        for tick in 0..60 {
            if removed && tick == 20 {
                let far = world.sheet_id("far").expect("there");
                assert!(world.remove_sheet(far));
            }
            world.step();
        }
        ["a", "b", "c"].map(|name| world.sheet(name).expect("there").state.x.clone())
    };
    assert!(run(false) == run(true));
}

#[test]
fn events_are_counted_and_given_since_a_count_although_they_are_drained() {
    let mut world = room();
    let (mut seen, mut sent) = (0, 0);
    for _ in 0..60 {
        world.step();
        sent += world.events_since(seen).len() as u64;
        seen = world.event_count();
        world.drain_events();
        assert!(world.events_since(seen).is_empty());
    }
    assert!(sent > 0 && sent == world.event_count(), "{sent} of {}", world.event_count());
}
