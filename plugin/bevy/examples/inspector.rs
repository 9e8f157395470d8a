//! Inspector over a game, added by one line. F10 hides it.
//!
//! `cargo run -p bevy_sheetwork --features inspector --example inspector`

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, SheetworkPlugins, SheetInspectorPlugin))
        .insert_resource(ClearColor(Color::srgb(0.80, 0.83, 0.87)))
        .add_systems(Startup, setup)
        .run();
}

fn setup(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.1, 0.75, 1.15).looking_at(Vec3::new(-0.05, 0.26, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn(SheetBody::floor());
    // A hanging strip: a change of Young's modulus or thickness raises or lowers it.
    let strip = Sheet::new("hips").named("strip").size(0.35, 0.12).clamp(Region::Left);
    commands.spawn((strip, Transform::from_xyz(0.0, 0.45, 0.0)));
    commands.spawn((SheetBody::ball(0.12), Transform::from_xyz(0.35, 0.12, 0.0)));
    commands.spawn((Sheet::new("rubber").named("drape").size(0.35, 0.35), Transform::from_xyz(0.38, 0.4, 0.0)));
}
