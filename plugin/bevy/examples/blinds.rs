//! A tennis ball is thrown at a venetian blind: the slats of aluminium bend and spring back.
//!
//! `cargo run --release -p bevy_sheetwork --example blinds`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::material;

mod stage;

fn main() {
    let mut app = stage::app("blinds", Vec3::new(0.30, 0.45, 0.60), Vec3::new(0.0, 0.27, 0.0), 0.18);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let frame = MeshMaterial3d(paints.add(Color::srgb(0.35, 0.26, 0.20)));
    for (x, y, size) in
        [(-0.31, 0.25, (0.02, 0.5, 0.05)), (0.31, 0.25, (0.02, 0.5, 0.05)), (0.0, 0.49, (0.6, 0.02, 0.05))]
    {
        let beam = Mesh3d(meshes.add(Cuboid::new(size.0, size.1, size.2)));
        commands.spawn((beam, frame.clone(), Transform::from_xyz(x, y, 0.0)));
    }
    let paint = paints.add(StandardMaterial {
        base_color: Color::srgb(0.82, 0.84, 0.80),
        metallic: 0.2,
        perceptual_roughness: 0.4,
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    // Aluminium of 0.2 mm, curved across.
    let metal = SheetMaterial { thickness: 2e-4, ..material::by_name("aluminium-foil").unwrap() };
    for slat in 0..14 {
        let mut sheet = Sheet::default().material(metal.clone()).size(0.58, 0.03).grid(25, 3).damping_ratio(0.05);
        sheet.spec.curl = (0.0, -8.0);
        // The right end slides in its guide.
        sheet = sheet.pin(Region::Left);
        sheet.spec.pins.push(PinSpec { axes: (false, true, true), ..PinSpec::fixed(Region::Right) });
        let place = Transform::from_xyz(0.0, 0.10 + 0.027 * slat as f32, 0.0);
        commands.spawn((sheet, MeshMaterial3d(paint.clone()), place.with_rotation(Quat::from_rotation_x(0.6))));
    }
    let felt = MeshMaterial3d(paints.add(Color::srgb(0.75, 0.85, 0.15)));
    let ball = SheetBody::ball(0.033).mass(0.057).velocity(DVec3::new(0.0, 0.4, -2.2));
    commands.spawn((ball, felt, Transform::from_xyz(0.03, 0.27, 0.3)));
}
