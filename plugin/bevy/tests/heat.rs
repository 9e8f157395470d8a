//! Heat: heaters, heat guns and hot bodies as entities; colours of temperature, without cost where
//! they are not requested.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::render::heat_colour;
use common::{app, frame, run};

fn held() -> Sheet {
    Sheet::new("hips").size(0.1, 0.1).grid(5, 5).pin(Region::All)
}

fn hottest(app: &App, sheet: Entity) -> f32 {
    app.world().get::<SheetState>(sheet).and_then(|s| s.temperature).expect("heated").1
}

fn colours(app: &App, sheet: Entity) -> Option<Vec<[f32; 4]>> {
    let mesh = app.world().get::<Mesh3d>(sheet).expect("dressed");
    let mesh = app.world().resource::<Assets<Mesh>>().get(&mesh.0).expect("there");
    match mesh.attribute(Mesh::ATTRIBUTE_COLOR) {
        Some(bevy::mesh::VertexAttributeValues::Float32x4(colours)) => Some(colours.clone()),
        _ => None,
    }
}

#[test]
fn a_heater_heats_the_faced_sheet_follows_its_transform_and_is_removed_with_its_entity() {
    let mut app = app();
    let sheet = app.world_mut().spawn(held()).id();
    let above = Transform::from_xyz(0.0, 0.05, 0.0);
    let heater = SheetHeater::cuboid(0.1, 0.01, 0.1).hot(2, 400.0, 1.0);
    let heater = app.world_mut().spawn((heater, above, Name::new("lamp"))).id();
    run(&mut app, 2.0);
    let first = hottest(&app, sheet);
    assert!(first > 30.0, "{first}");
    assert!(app.world().get::<Children>(heater).is_some_and(|c| c.len() == 2), "a cold part and a hot one are drawn");
    *app.world_mut().get_mut::<Transform>(heater).expect("has one") = Transform::from_xyz(0.0, 20.0, 0.0);
    run(&mut app, 4.0);
    assert!(hottest(&app, sheet) < first, "it is far");
    *app.world_mut().get_mut::<Transform>(heater).expect("has one") = above;
    let spec = SheetHeater::cuboid(0.1, 0.01, 0.1).hot(2, 900.0, 1.0);
    *app.world_mut().get_mut::<SheetHeater>(heater).expect("has one") = spec;
    run(&mut app, 2.0);
    assert!(hottest(&app, sheet) > first + 10.0, "hotter than before");
    app.world_mut().despawn(heater);
    let peak = hottest(&app, sheet);
    run(&mut app, 2.0);
    assert!(hottest(&app, sheet) < peak, "gone");
    app.world_mut().spawn(SheetHeater::cuboid(0.1, 0.01, 0.1).hot(9, 400.0, 1.0));
    run(&mut app, 0.1);
    assert!(app.world().resource::<SheetWorld>().scene().heaters.is_empty(), "a face that is not there is refused");
}

#[test]
fn a_heat_gun_blows_along_the_forward_direction_of_its_entity() {
    let mut app = app();
    let sheet = app.world_mut().spawn(held()).id();
    let down = Transform::from_xyz(0.0, 0.05, 0.0).looking_at(Vec3::ZERO, Vec3::Z);
    let gun = app.world_mut().spawn((SheetHeatGun { temperature: 300.0, ..default() }, down)).id();
    run(&mut app, 2.0);
    let first = hottest(&app, sheet);
    assert!(first > 35.0, "{first}");
    *app.world_mut().get_mut::<Transform>(gun).expect("has one") = down.looking_to(Vec3::Y, Vec3::Z);
    run(&mut app, 2.0);
    let aside = hottest(&app, sheet);
    assert!(aside < first, "it blows the other way: {aside} after {first}");
    app.world_mut().despawn(gun);
    assert!(app.world().resource::<SheetWorld>().scene().heat_gun.is_none());
}

#[test]
fn a_hot_body_heats_a_sheet_in_contact_and_its_temperature_changes_in_place() {
    let mut app = app();
    let sheet = app.world_mut().spawn((held(), Transform::from_xyz(0.0, 0.0003, 0.0))).id();
    let plate = SheetBody::cuboid(0.2, 0.02, 0.2).temperature(60.0);
    let plate = app.world_mut().spawn((plate, Transform::from_xyz(0.0, -0.01, 0.0))).id();
    run(&mut app, 5.0);
    let warm = hottest(&app, sheet);
    assert!((50.0..60.0).contains(&warm), "{warm}");
    app.world_mut().get_mut::<SheetBody>(plate).expect("has one").temperature = Some(90.0);
    run(&mut app, 5.0);
    assert!(hottest(&app, sheet) > 70.0, "{}", hottest(&app, sheet));
}

#[test]
fn colours_are_there_where_they_are_asked_for() {
    let mut app = app();
    let display = SheetDisplay { colour: SheetColour::TemperatureBetween { low: 20.0, high: 80.0 }, ..default() };
    let shown = app.world_mut().spawn((held(), display)).id();
    let plain = app.world_mut().spawn((held(), Transform::from_xyz(1.0, 0.0, 0.0))).id();
    frame(&mut app, 1.0 / 64.0);
    assert_eq!(colours(&app, shown), None, "nothing heats it yet");
    let material = |app: &App, e| app.world().get::<MeshMaterial3d<StandardMaterial>>(e).map(|m| m.0.id());
    let before = material(&app, shown);
    let oven = sheetwork::scene::OvenSpec { temperature: 80.0, convection: Some(1e3), ..Default::default() };
    app.world_mut().resource_mut::<SheetWorld>().set_oven(Some(oven)).expect("valid");
    run(&mut app, 0.1);
    let early = colours(&app, shown).expect("heated");
    assert_ne!(material(&app, shown), before, "a white one, or its own colour would tint them");
    assert_eq!(colours(&app, plain), None, "not asked for");
    run(&mut app, 20.0);
    let late = colours(&app, shown).expect("heated");
    assert!(late[0].iter().zip(early[0]).any(|(a, b)| (a - b).abs() > 0.1), "a sheet that stands still warms too");
    let wanted = heat_colour((hottest(&app, shown) - 20.0) / 60.0);
    assert!((late[0][0] - wanted.red).abs() < 0.01 && late[0][2] >= 0.0, "{:?} {wanted:?}", late[0]);
    app.world_mut().get_mut::<SheetDisplay>(shown).expect("has one").colour = SheetColour::Plain;
    run(&mut app, 0.1);
    assert_eq!((colours(&app, shown), material(&app, shown)), (None, before));
}
