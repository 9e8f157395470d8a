//! The least there is to write: a camera, a light, something to fall on, a sheet.

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

fn main() {
    App::new().add_plugins((DefaultPlugins, SheetworkPlugins)).add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands) {
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.6, 0.7, 1.0).looking_at(Vec3::Y * 0.15, Vec3::Y)));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn(SheetBody::floor());
    commands.spawn((SheetBody::ball(0.15), Transform::from_xyz(0.0, 0.15, 0.0)));
    commands.spawn((Sheet::new("rubber").size(0.5, 0.5), Transform::from_xyz(0.05, 0.5, 0.0)));
}
