//! Sheets in contact with a caller's Rapier world.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_rapier3d::rapier::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, Vector};
use bevy_sheetwork::prelude::*;
use common::{Game, app_with, explicit, lend, run};

#[test]
fn a_sheet_rests_on_a_body_of_the_callers_world() {
    let mut game = PhysicsWorld::new();
    game.gravity = Vector::ZERO;
    let table = game.insert_body(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.1, 0.0)));
    game.insert_collider(ColliderBuilder::cuboid(0.1, 0.01, 0.1), Some(table));

    let mut app = app_with(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() }));
    explicit(&mut app);
    lend(&mut app, game);
    let sheet = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.0, 0.13, 0.0))).id();
    run(&mut app, 3.0);
    let state = app.world().get::<SheetState>(sheet).expect("has one");
    assert!((state.centre.y - 0.1105).abs() < 1e-3 && state.contacts > 0, "{state:?}");
}

#[test]
fn a_sheet_carries_a_dynamic_body_of_the_callers_world() {
    let mut game = PhysicsWorld::new();
    game.gravity = Vector::new(0.0, -9.81, 0.0);
    let ball = game.insert_body(RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 1.2, 0.0)));
    game.insert_collider(ColliderBuilder::ball(0.03).mass(0.02), Some(ball));
    let mut app = app_with(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() }));
    lend(&mut app, game);
    let net = Sheet::new("pet").size(0.3, 0.3).pin(Region::Border);
    app.world_mut().spawn((net, Transform::from_xyz(0.0, 1.0, 0.0)));
    run(&mut app, 2.0);
    let height = app.world().resource::<Game>().0.bodies[ball].translation().y;
    assert!((1.0..1.2).contains(&height), "{height} m");
}

#[test]
fn a_pin_with_an_end_is_released_in_the_callers_world_too() {
    let mut app = app_with(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() }));
    explicit(&mut app);
    lend(&mut app, PhysicsWorld::new());
    let mut held = Sheet::thesis();
    held.spec.pins.push(PinSpec { until: Some(0.2), ..PinSpec::fixed(Region::All) });
    let sheet = app.world_mut().spawn((held, Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.15);
    let height = |app: &App| app.world().get::<SheetState>(sheet).expect("has one").centre.y;
    let held = height(&app);
    assert!((held - 1.0).abs() < 2e-3, "{held}");
    run(&mut app, 0.3);
    assert!(height(&app) < 0.9 * held, "{} m", height(&app));
}
