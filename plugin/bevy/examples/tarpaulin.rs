//! A tarpaulin falls over three crates.
//!
//! `cargo run --release -p bevy_sheetwork --example tarpaulin`

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

mod stage;

fn main() {
    let mut app = stage::app("tarpaulin", Vec3::new(1.4, 1.5, 2.4), Vec3::new(0.0, 0.22, 0.0), 2.5);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let wood = paints.add(Color::srgb(0.55, 0.38, 0.22));
    for (place, size) in [((-0.3, 0.21, 0.08), 0.42), ((0.3, 0.17, -0.12), 0.34), ((-0.2, 0.56, 0.03), 0.28)] {
        let mesh = (Mesh3d(meshes.add(Cuboid::from_length(size))), MeshMaterial3d(wood.clone()));
        let crate_body = SheetBody::cuboid(size, size, size).friction(0.5);
        commands.spawn((mesh, crate_body, Transform::from_xyz(place.0, place.1, place.2)));
    }
    let blue = paints.add(StandardMaterial {
        base_color: Color::srgb(0.12, 0.30, 0.62),
        double_sided: true,
        cull_mode: None,
        perceptual_roughness: 0.6,
        ..default()
    });
    // PVC of 0.4 mm.
    let mut tarpaulin = Sheet::new("pvc-plasticised").grid(33, 33).size(2.2, 2.2);
    tarpaulin.spec.friction = Some(0.5);
    commands.spawn((tarpaulin, MeshMaterial3d(blue), Transform::from_xyz(0.0, 0.8, 0.0)));
}
