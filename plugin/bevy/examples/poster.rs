//! A poster on a wall is torn off: one corner is led away, the paper tears from the nails.
//!
//! `cargo run --release -p bevy_sheetwork --example poster`

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

mod stage;

fn main() {
    let mut app = stage::app("poster", Vec3::new(0.75, 1.25, 1.25), Vec3::new(0.0, 1.05, 0.0), 1.2);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let plaster = paints.add(Color::srgb(0.86, 0.80, 0.72));
    let wall = (Mesh3d(meshes.add(Cuboid::new(3.0, 3.0, 0.1))), MeshMaterial3d(plaster));
    commands.spawn((wall, SheetBody::cuboid(3.0, 3.0, 0.1), Transform::from_xyz(0.0, 1.5, -0.06)));
    // The sheet stands upright: its length along x, its width down the wall.
    let mut poster = Sheet::new("paper").grid(25, 33).size(0.42, 0.594).tearing();
    // Strips of tape along three corners.
    for (u, v) in [((0.0, 0.1), (0.0, 0.04)), ((0.9, 1.0), (0.0, 0.04)), ((0.0, 0.1), (0.96, 1.0))] {
        poster = poster.pin(Region::Rect(u, v));
    }
    let key = |time, offset: [f64; 3]| PathKey { time, offset: offset.into(), ..default() };
    let pull = vec![key(0.0, [0.0; 3]), key(0.3, [0.0; 3]), key(1.6, [-0.25, 0.35, 0.5])];
    poster = poster.pin_along(Region::Rect((0.9, 1.0), (0.96, 1.0)), pull);
    let upright = Transform::from_xyz(0.0, 1.1, 0.0).with_rotation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    commands.spawn((poster, upright));
}
