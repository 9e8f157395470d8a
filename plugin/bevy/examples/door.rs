//! A sheet-metal door is hit by a heavy ball and stays bent.
//!
//! `cargo run --release -p bevy_sheetwork --example door`

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::material;

mod stage;

fn main() {
    let mut app = stage::app("door", Vec3::new(1.3, 1.0, 1.3), Vec3::new(0.0, 0.75, 0.0), 0.32);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let steel = paints.add(StandardMaterial {
        base_color: Color::srgb(0.60, 0.63, 0.66),
        metallic: 0.3,
        perceptual_roughness: 0.35,
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    // Soft steel of 0.6 mm, held at its hinges; beyond the yield stress the bend stays.
    let metal =
        SheetMaterial { thickness: 6e-4, yield_stress: Some(1.6e8), ..material::by_name("steel-foil").unwrap() };
    let mut door = Sheet::default().material(metal).size(0.7, 1.4).grid(15, 29).clamp(Region::Left);
    door.spec.plastic = true;
    let upright = Transform::from_xyz(0.0, 0.72, 0.0).with_rotation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    commands.spawn((door, MeshMaterial3d(steel), upright));
    let iron = paints.add(Color::srgb(0.16, 0.16, 0.18));
    let ball = SheetBody::ball(0.07).density(7_800.0).velocity(Vec3::new(0.0, 1.0, -8.0).as_dvec3());
    let mesh = (Mesh3d(meshes.add(Sphere::new(0.07))), MeshMaterial3d(iron));
    commands.spawn((ball, mesh, Transform::from_xyz(0.08, 0.8, 0.9)));
}
