//! Wind zones as entities.
#![cfg(feature = "render")]

mod common;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::ForceTarget;
use bevy_sheetwork::sheetwork::scene::{WindZone, ZoneVolume};
use common::{app, run};

/// Mean velocity of the only sheet, m/s.
fn velocity(app: &App) -> DVec3 {
    let sheet = &app.world().resource::<SheetWorld>().sheets()[0];
    sheet.momentum() / sheet.total_mass()
}

fn zones(app: &App) -> usize {
    app.world().resource::<SheetWorld>().wind_zones().len()
}

#[test]
fn a_wind_zone_follows_its_entity_and_ends_with_it() {
    let mut app = app();
    app.world_mut().resource_mut::<SheetWorld>().set_gravity(DVec3::ZERO).expect("in range");
    app.world_mut().spawn(Sheet::new("paper").size(0.1, 0.1).grid(5, 5));
    run(&mut app, 0.1);
    assert!(velocity(&app).length() < 1e-12 && zones(&app) == 0, "{}", velocity(&app));
    let zone = WindZone { volume: ZoneVolume::Ball(1.0), velocity: DVec3::NEG_Z * 3.0, ..WindZone::default() };
    let away = Transform::from_xyz(50.0, 0.0, 0.0).looking_to(Vec3::Y, Vec3::Z);
    let fan = app.world_mut().spawn((SheetWind { zone }, away, Name::new("fan"))).id();
    run(&mut app, 0.2);
    assert!(velocity(&app).length() < 1e-12 && zones(&app) == 1, "{}", velocity(&app));
    assert_eq!(app.world().resource::<SheetWorld>().wind_zones()[0].name, "fan");
    app.world_mut().get_mut::<Transform>(fan).expect("has one").translation = Vec3::ZERO;
    run(&mut app, 0.2);
    let blown = velocity(&app);
    // It blows along the forward direction of the entity, which is up.
    assert!(blown.y > 1.0 && blown.x.abs() < 0.1 && blown.z.abs() < 0.1, "{blown}");
    app.world_mut().get_mut::<SheetWind>(fan).expect("has one").zone.velocity.x = f64::NAN;
    run(&mut app, 0.1);
    app.world_mut().despawn(fan);
    run(&mut app, 0.1);
    assert_eq!(zones(&app), 0);
}

#[test]
fn forces_reach_the_sheet_through_the_world() {
    let mut app = app();
    app.world_mut().resource_mut::<SheetWorld>().set_gravity(DVec3::ZERO).expect("in range");
    app.world_mut().spawn(Sheet::new("card").size(0.1, 0.1).grid(5, 5).named("leaf"));
    run(&mut app, 0.1);
    let mut world = app.world_mut().resource_mut::<SheetWorld>();
    let id = world.sheet_id("leaf").expect("there");
    let mass = world.sheets()[0].total_mass();
    let target = ForceTarget::Point(0.5, 0.5);
    world.apply_impulse(id, &target, DVec3::Y * mass).expect("valid");
    run(&mut app, 1.0 / 64.0);
    assert!(velocity(&app).y > 0.5, "{}", velocity(&app));
}
