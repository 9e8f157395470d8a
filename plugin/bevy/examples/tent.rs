//! A sheet of nylon over a ridge pole, pegged down at its corners, in gusts: a tent.
//!
//! `cargo run --release -p bevy_sheetwork --example tent`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::{GustSpec, TurbulenceSpec};

mod stage;

/// Height of the ridge, m.
const RIDGE: f64 = 0.9;

fn main() {
    let mut app = stage::app("tent", Vec3::new(2.0, 1.3, 2.1), Vec3::new(0.0, 0.38, 0.0), 2.0);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let wood = MeshMaterial3d(paints.add(Color::srgb(0.45, 0.32, 0.2)));
    let pole = SheetBody::cuboid(2.3, 0.03, 0.03);
    commands.spawn((pole, wood.clone(), Transform::from_xyz(0.0, RIDGE as f32 - 0.02, 0.0)));
    for x in [-1.1, 1.1] {
        let post = Mesh3d(meshes.add(Cylinder::new(0.018, RIDGE as f32)));
        commands.spawn((post, wood.clone(), Transform::from_xyz(x, 0.5 * RIDGE as f32 - 0.02, 0.0)));
    }
    let cloth = paints.add(StandardMaterial {
        base_color: Color::srgb(0.90, 0.45, 0.10),
        perceptual_roughness: 0.8,
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    // Coated nylon: stiff in its plane, limp in bending.
    let nylon = SheetMaterial { young: 3e8, poisson: 0.3, density: 800.0, thickness: 1.5e-4, ..default() };
    let mut tent = Sheet::default().material(nylon).size(2.2, 2.4).grid(23, 25).damping_ratio(0.05).friction(0.4);
    tent = tent.pin(Region::Point(0.0, 0.5)).pin(Region::Point(1.0, 0.5));
    // Cords pull the corners and the middles of the eaves to the ground.
    for (u, v, x) in [(0.0, 0.0, 0.03), (0.5, 0.0, 0.0), (1.0, 0.0, -0.03)] {
        for (v, side) in [(v, 1.0), (1.0 - v, -1.0)] {
            let down = DVec3::new(x, 0.04 - RIDGE, side * (1.2 - 0.82));
            let key = |time, part: f64| PathKey { time, offset: part * down, ..default() };
            tent = tent.pin_along(Region::Point(u, v), [key(0.0, 0.0), key(1.2, 1.0)]);
        }
    }
    commands.spawn((tent, MeshMaterial3d(cloth), Transform::from_xyz(0.0, RIDGE as f32, 0.0)));
    let wind = WindZone {
        velocity: DVec3::new(1.0, 0.0, -4.0),
        gusts: Some(GustSpec { amplitude: 0.8, duration: 1.0, period: 2.0 }),
        turbulence: Some(TurbulenceSpec { intensity: 1.0, length: 0.8, seed: 1 }),
        ..default()
    };
    commands.spawn(SheetWind { zone: wind });
}
