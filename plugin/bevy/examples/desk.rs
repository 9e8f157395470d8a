//! Loose sheets of paper on a desk; a gust through the window lifts them and carries them off.
//!
//! `cargo run --release -p bevy_sheetwork --example desk`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::{GustSpec, TurbulenceSpec};

mod stage;

fn main() {
    let mut app = stage::app("desk", Vec3::new(0.45, 1.3, 1.35), Vec3::new(0.1, 0.72, 0.0), 0.8);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let wood = MeshMaterial3d(paints.add(Color::srgb(0.42, 0.27, 0.16)));
    let top = SheetBody::cuboid(1.5, 0.03, 0.75).friction(0.3);
    commands.spawn((top, wood.clone(), Transform::from_xyz(0.0, 0.7, 0.0)));
    for (x, z) in [(-0.7, -0.33), (0.7, -0.33), (-0.7, 0.33), (0.7, 0.33)] {
        let leg = Mesh3d(meshes.add(Cuboid::new(0.05, 0.69, 0.05)));
        commands.spawn((leg, wood.clone(), Transform::from_xyz(x, 0.345, z)));
    }
    let white = paints.add(StandardMaterial {
        base_color: Color::srgb(0.95, 0.94, 0.90),
        perceptual_roughness: 0.9,
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    for (x, z, turn) in
        [(-0.5, -0.17, 0.1), (-0.5, 0.17, -0.2), (-0.12, -0.2, 0.3), (-0.1, 0.15, -0.1), (0.3, 0.0, 0.2)]
    {
        let paper = Sheet::new("paper").size(0.297, 0.21).grid(11, 8).friction(0.3);
        let place = Transform::from_xyz(x, 0.7155, z).with_rotation(Quat::from_rotation_y(turn));
        commands.spawn((paper, MeshMaterial3d(white.clone()), place));
    }
    let iron = MeshMaterial3d(paints.add(Color::srgb(0.15, 0.17, 0.2)));
    commands.spawn((SheetBody::ball(0.035).mass(0.4), iron, Transform::from_xyz(-0.45, 0.751, 0.17)));
    let gust = WindZone {
        volume: ZoneVolume::Box(DVec3::new(3.0, 1.2, 1.5)),
        falloff: 0.3,
        velocity: DVec3::new(1.2, 0.2, 0.2),
        gusts: Some(GustSpec { amplitude: 2.0, duration: 1.5, period: 3.0 }),
        turbulence: Some(TurbulenceSpec { intensity: 0.8, length: 0.5, seed: 2 }),
        ..default()
    };
    commands.spawn((SheetWind { zone: gust }, Transform::from_xyz(0.0, 0.9, 0.0)));
}
