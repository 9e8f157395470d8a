//! Attachment of sheets to bodies by entity.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_rapier3d::rapier::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, Vector};
use bevy_sheetwork::prelude::*;
use common::{Game, app, app_with, lend, run};

/// Position of the first node of a sheet, m.
fn corner(app: &App, sheet: Entity) -> Vec3 {
    let motion = app.world().get::<SheetMotion>(sheet).expect("built");
    motion.positions().get(0).as_vec3()
}

#[test]
fn a_sheet_follows_an_arm_spawned_after_it_and_falls_when_let_go() {
    let mut app = app();
    let sheet = app.world_mut().spawn((Sheet::new("card").size(0.2, 0.1), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.1);
    let arm = app.world_mut().spawn((SheetBody::cuboid(0.02, 0.02, 0.1), Transform::from_xyz(0.0, 0.9, 0.5))).id();
    app.world_mut().entity_mut(sheet).insert(SheetAttachments::new(Region::Left, arm));
    run(&mut app, 0.1);
    let before = corner(&app, sheet);
    for step in 1..=32 {
        app.world_mut().get_mut::<Transform>(arm).expect("there").translation.y = 0.9 + 0.01 * step as f32;
        run(&mut app, 1.0 / 64.0);
    }
    run(&mut app, 0.1);
    let moved = corner(&app, sheet) - before;
    assert!((moved - Vec3::Y * 0.32).length() < 1e-5, "{moved}");
    // Another region instead.
    *app.world_mut().get_mut::<SheetAttachments>(sheet).expect("there") = SheetAttachments::new(Region::Right, arm);
    run(&mut app, 0.5);
    assert!(corner(&app, sheet).y < 1.15, "the left edge is free: {}", corner(&app, sheet));
    app.world_mut().entity_mut(sheet).remove::<SheetAttachments>();
    run(&mut app, 0.4);
    assert!(app.world().get::<SheetState>(sheet).expect("there").centre.y < 0.8);
}

#[test]
fn a_sheet_lets_go_of_a_despawned_body() {
    let mut app = app();
    let arm = app.world_mut().spawn((SheetBody::cuboid(0.02, 0.02, 0.1), Transform::from_xyz(-0.14, 1.0, 0.0))).id();
    let sheet = (Sheet::new("card").size(0.2, 0.1), SheetAttachments::new(Region::Left, arm));
    let sheet = app.world_mut().spawn((sheet, Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.5);
    assert!((corner(&app, sheet).y - 1.0).abs() < 0.02, "{}", corner(&app, sheet));
    app.world_mut().despawn(arm);
    run(&mut app, 0.5);
    assert!(corner(&app, sheet).y < 0.5);
}

#[test]
fn a_dynamic_body_of_the_callers_world_hangs_on_a_sheet_by_its_entity() {
    let mut app = app_with(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() }));
    let weight = app.world_mut().spawn_empty().id();
    let mut game = PhysicsWorld::new();
    game.gravity = Vector::new(0.0, -9.81, 0.0);
    // As bevy_rapier3d does.
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.85, 0.0));
    let body = game.insert_body(body.user_data(weight.to_bits().into()));
    game.insert_collider(ColliderBuilder::ball(0.02).mass(0.01), Some(body));
    lend(&mut app, game);
    // A strip that hangs down from its upper edge.
    let strip = (
        Sheet::new("card").size(0.2, 0.1).pin(Region::Left),
        SheetAttachments::new(Region::Right, weight),
        Transform::from_xyz(0.0, 1.0, 0.0).with_rotation(Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2)),
    );
    app.world_mut().spawn(strip);
    run(&mut app, 2.0);
    let height = app.world().resource::<Game>().0.bodies[body].translation().y;
    assert!((height - 0.85).abs() < 0.02, "{height} m");
}
