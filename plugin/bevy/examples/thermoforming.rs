//! A sheet of polystyrene in a frame softens in the heat, is pressed over a form, and keeps its
//! shape when it has cooled. Colours show the temperature.
//!
//! `cargo run --release -p bevy_sheetwork --example thermoforming`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::{OvenKey, OvenSpec, Scene};

mod stage;

fn main() {
    let eye = Vec3::new(0.17, 0.30, 0.26);
    let mut app = stage::app("thermoforming", eye, Vec3::new(0.0, 0.15, 0.0), 6.3);
    app.add_systems(Startup, setup).run();
}

fn setup(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut paints: ResMut<Assets<StandardMaterial>>,
) -> Result {
    let key = |time, temperature| OvenKey { time, temperature };
    let schedule = vec![key(0.0, Some(150.0)), key(3.2, None)];
    world.set_oven(Some(OvenSpec { convection: Some(20.0), schedule, ..default() }))?;
    // Heat runs 20 times as fast as motion: a minute of heating takes 3 s.
    let surroundings = Scene { time_lapse: 20.0, ..world.scene().clone() };
    world.set_surroundings(&surroundings)?;
    let sheet = Sheet::new("hips").size(0.2, 0.2).grid(17, 17).damping_ratio(1.0).clamp(Region::Border);
    let colours = SheetDisplay { colour: SheetColour::Temperature, ..default() };
    commands.spawn((sheet, colours, Transform::from_xyz(0.0, 0.16, 0.0)));
    let iron = MeshMaterial3d(paints.add(Color::srgb(0.2, 0.21, 0.23)));
    for (x, z, size) in [
        (0.0, 0.104, (0.224, 0.016)),
        (0.0, -0.104, (0.224, 0.016)),
        (0.104, 0.0, (0.016, 0.192)),
        (-0.104, 0.0, (0.016, 0.192)),
    ] {
        let beam = Mesh3d(meshes.add(Cuboid::new(size.0, 0.012, size.1)));
        commands.spawn((beam, iron.clone(), Transform::from_xyz(x, 0.16, z)));
    }
    let wood = MeshMaterial3d(paints.add(Color::srgb(0.5, 0.36, 0.22)));
    let key = |time, y| PathKey { time, offset: DVec3::Y * y, ..default() };
    let form =
        SheetBody::ball(0.055).friction(0.2).along([key(2.2, 0.0), key(3.2, 0.085), key(5.2, 0.085), key(6.0, 0.0)]);
    commands.spawn((form, wood, Transform::from_xyz(0.0, 0.075, 0.0)));
    Ok(())
}
