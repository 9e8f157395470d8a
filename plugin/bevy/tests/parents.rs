//! Sheets whose parents move: pinned nodes are led, the free ones follow.
#![cfg(feature = "render")]

mod common;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, frame, run};

const TICK: f32 = 1.0 / 64.0;

/// A card pinned along its left edge, child of a parent, and the parent.
fn on_an_arm(app: &mut App, card: Sheet) -> (Entity, Entity) {
    let place = Transform::from_xyz(0.2, 1.0, 0.0).with_rotation(Quat::from_rotation_y(0.4));
    let parent = app.world_mut().spawn((place, Visibility::default())).id();
    let card = card.size(0.2, 0.1).grid(11, 6);
    let card = app.world_mut().spawn((card, Transform::from_xyz(0.1, 0.0, 0.0), ChildOf(parent))).id();
    run(app, 0.5);
    (parent, card)
}

fn positions(app: &App) -> Vec<DVec3> {
    app.world().resource::<SheetWorld>().sheets()[0].state.x.iter().collect()
}

fn place(app: &App, entity: Entity) -> Transform {
    *app.world().get::<Transform>(entity).expect("there")
}

fn pinned(app: &App) -> Vec<usize> {
    let sheet = &app.world().resource::<SheetWorld>().sheets()[0];
    (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).collect()
}

#[test]
fn a_pinned_edge_follows_its_parent_and_the_free_part_by_its_forces() {
    let mut app = app();
    let (parent, card) = on_an_arm(&mut app, Sheet::new("paper").pin(Region::Left));
    let (start, rest, nodes) = (place(&app, parent), positions(&app), pinned(&app));
    assert_eq!(nodes.len(), 6);
    let free = rest.len() - 1;
    for tick in 1..=32 {
        let turn = Quat::from_rotation_z(0.01 * tick as f32);
        let now = Transform { rotation: turn * start.rotation, ..start };
        let by = Vec3::new(0.4 * tick as f32 * TICK, 0.1 * tick as f32 * TICK, 0.0);
        *app.world_mut().get_mut::<Transform>(parent).expect("there") =
            Transform { translation: now.translation + by, ..now };
        frame(&mut app, TICK.into());
        let moved = place(&app, parent).compute_affine() * start.compute_affine().inverse();
        let x = positions(&app);
        for node in &nodes {
            let wanted = moved.transform_point3(rest[*node].as_vec3());
            assert!(wanted.distance(x[*node].as_vec3()) < 1e-5, "{wanted} {}", x[*node]);
        }
        if tick == 1 {
            let speed = app.world().resource::<SheetWorld>().sheets()[0].state.v.get(nodes[0]).length();
            assert!((0.2..0.8).contains(&speed), "constant velocity in the tick: {speed} m/s");
            let led = moved.transform_point3(rest[free].as_vec3());
            assert!(led.distance(x[free].as_vec3()) > 1e-4, "the free edge is not moved rigidly");
        }
    }
    assert!((positions(&app)[free] - rest[free]).x > 0.1, "it came along");
    let sheet = app.world().get::<SheetState>(card).expect("there");
    assert!(!sheet.unstable, "{sheet:?}");
    let there = app.world().get::<GlobalTransform>(card).expect("there").translation();
    assert!(there.distance(sheet.centre) < 0.12, "its transform follows the sheet: {there} {}", sheet.centre);
}

#[test]
fn several_steps_of_a_tick_share_the_motion() {
    let mut app = app();
    let (parent, _) = on_an_arm(&mut app, Sheet::new("paper").clamp(Region::Left));
    app.world_mut().resource_mut::<SheetWorld>().set_dt(f64::from(TICK) / 4.0).expect("in range");
    let node = pinned(&app)[0];
    let before = positions(&app)[node];
    app.world_mut().get_mut::<Transform>(parent).expect("there").translation.x += 0.01;
    frame(&mut app, TICK.into());
    let world = app.world().resource::<SheetWorld>();
    let speed = world.sheets()[0].state.v.get(node).length();
    assert!((speed - 0.01 / f64::from(TICK)).abs() < 1e-3, "{speed} m/s in the last step");
    assert!((positions(&app)[node].x - before.x - 0.01).abs() < 1e-6);
}

#[test]
fn a_sheet_without_pins_stays_and_a_pause_takes_a_pinned_one_along() {
    let mut app = app();
    app.world_mut().resource_mut::<SheetWorld>().set_gravity(DVec3::ZERO).expect("in range");
    let (parent, card) = on_an_arm(&mut app, Sheet::new("card"));
    let before = app.world().get::<SheetState>(card).expect("there").centre;
    app.world_mut().get_mut::<Transform>(parent).expect("there").translation.y += 1.0;
    run(&mut app, 0.1);
    assert!(app.world().get::<SheetState>(card).expect("there").centre.distance(before) < 1e-4);
    app.world_mut().get_mut::<Sheet>(card).expect("there").spec.pins.push(PinSpec::fixed(Region::Left));
    run(&mut app, 0.1);
    let before = positions(&app);
    app.world_mut().resource_mut::<SheetClock>().paused = true;
    app.world_mut().get_mut::<Transform>(parent).expect("there").translation.y += 1.0;
    run(&mut app, 0.1);
    for (was, is) in before.iter().zip(positions(&app)) {
        assert!(is.distance(*was + DVec3::Y) < 1e-5);
    }
}

#[test]
fn a_sheet_that_changes_its_parent_is_not_led_there() {
    let mut app = app();
    let (_, card) = on_an_arm(&mut app, Sheet::new("paper").pin(Region::Left));
    let node = pinned(&app)[0];
    let before = positions(&app)[node];
    let other = app.world_mut().spawn((Transform::from_xyz(3.0, 0.0, 0.0), Visibility::default())).id();
    frame(&mut app, 0.0);
    app.world_mut().entity_mut(card).set_parent_in_place(other);
    run(&mut app, 0.1);
    assert!(positions(&app)[node].distance(before) < 1e-3, "{} {before}", positions(&app)[node]);
    app.world_mut().get_mut::<Transform>(other).expect("there").translation.x += 0.05;
    run(&mut app, 0.1);
    assert!((positions(&app)[node].x - before.x - 0.05).abs() < 1e-3);
}
