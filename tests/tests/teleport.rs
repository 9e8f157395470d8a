//! Sheets that are moved at once.

use glam::{DQuat, DVec3};
use sheetwork::scene::Scene;
use sheetwork::{SheetId, World};

/// A spinning card, without gravity.
fn spinning(rest: &str) -> (World, SheetId) {
    let scene = format!(
        r#"(gravity: (0, 0, 0), sheets: [(name: "card", structure: "shell", grid: (9, 1, 7), size: (0.1, 0.08),
            material: "card", velocity: (0.2, 0.1, 0), spin: (3, 1, 2){rest})])"#
    );
    let world = World::new(&Scene::parse(&scene).expect("a scene")).expect("a world");
    let id = world.sheet_id("card").expect("there");
    (world, id)
}

fn positions(world: &World) -> Vec<DVec3> {
    world.sheets()[0].state.x.iter().collect()
}

#[test]
fn a_moved_sheet_goes_on_as_it_would_have_done() {
    let (turn, by) = (DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0), DVec3::new(3.0, -2.0, 5.0));
    let ((mut still, _), (mut moved, id)) = (spinning(""), spinning(""));
    still.advance(0.5);
    moved.advance(0.5);
    let energy = moved.energy().total;
    moved.move_sheet(id, by, turn).expect("free");
    assert!((moved.energy().total - energy).abs() < 1e-9 * energy);
    for (x, y) in positions(&still).iter().zip(positions(&moved)) {
        assert!(y.distance(turn * *x + by) < 1e-12);
    }
    still.advance(0.5);
    moved.advance(0.5);
    for (x, y) in positions(&still).iter().zip(positions(&moved)) {
        assert!(y.distance(turn * *x + by) < 1e-5, "{} m", y.distance(turn * *x + by));
    }
}

#[test]
fn a_sheet_moved_to_another_floor_lands_there() {
    let scene = r#"(sheets: [(name: "card", structure: "shell", grid: (9, 1, 7), size: (0.1, 0.08), material: "card",
            placement: (position: (0, 0.01, 0)))],
        bodies: [(name: "low", shape: Box((0.3, 0.02, 0.3)), placement: (position: (0, -0.01, 0))),
            (name: "high", shape: Box((0.3, 0.02, 0.3)), placement: (position: (1, 0.49, 0)))])"#;
    let mut world = World::new(&Scene::parse(scene).expect("a scene")).expect("a world");
    let id = world.sheet_id("card").expect("there");
    world.advance(2.0);
    assert!(world.is_resting());
    world.move_sheet(id, DVec3::new(1.0, 0.51, 0.0), DQuat::IDENTITY).expect("free");
    assert!(!world.is_resting());
    world.advance(2.0);
    let centre = world.sheets()[0].centre_of_mass();
    assert!(world.is_resting() && centre.distance(DVec3::new(1.0, 0.5, 0.0)) < 2e-3, "{centre}");
}

#[test]
fn a_moved_sheet_takes_its_pins_along_and_refuses_what_it_cannot_do() {
    let (mut world, id) = spinning(", pins: [(region: Left)]");
    world.advance(0.2);
    world.move_sheet(id, DVec3::Y, DQuat::from_rotation_y(0.7)).expect("pinned");
    let held = positions(&world)[0];
    world.advance(0.5);
    assert!(positions(&world)[0].distance(held) < 1e-12);
    assert!(world.move_sheet(id, DVec3::NAN, DQuat::IDENTITY).is_err());
    assert!(world.move_sheet(id, DVec3::X * 1e9, DQuat::IDENTITY).is_err());
    let (mut clamped, id) = spinning(", pins: [(region: Left, clamp: true)]");
    clamped.move_sheet(id, DVec3::X, DQuat::IDENTITY).expect("not rotated");
    // A product of a rotation and its inverse is the identity to rounding.
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.9, -0.7);
    clamped.move_sheet(id, DVec3::X, turn * turn.conjugate()).expect("not rotated");
    let refused = clamped.move_sheet(id, DVec3::ZERO, DQuat::from_rotation_x(0.1)).expect_err("rotated");
    assert!(refused.to_string().contains("clamp"), "{refused}");
}
