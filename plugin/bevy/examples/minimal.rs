//! Minimal program: a camera, a light, a body, a sheet. With the name of a file in `assets/scenes`,
//! that scene instead: `cargo run -p bevy_sheetwork --example minimal [SCENE]`.

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

fn main() {
    let assets = AssetPlugin { file_path: "../../assets".into(), ..default() };
    App::new()
        .add_plugins((DefaultPlugins.set(assets), SheetworkPlugins))
        .add_systems(Startup, setup)
        .add_systems(Update, look)
        .run();
}

fn setup(mut commands: Commands, server: Res<AssetServer>) {
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.6, 0.7, 1.0).looking_at(Vec3::Y * 0.15, Vec3::Y)));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    if let Some(name) = std::env::args().nth(1) {
        commands.spawn(SheetSceneRoot(server.load(format!("scenes/{name}.ron"))));
        return;
    }
    commands.spawn(SheetBody::floor());
    commands.spawn((SheetBody::ball(0.15), Transform::from_xyz(0.0, 0.15, 0.0)));
    commands.spawn((Sheet::new("rubber").size(0.5, 0.5), Transform::from_xyz(0.05, 0.5, 0.0)));
}

/// Place the camera of a scene; by default above and in front, at a distance that fits its sheets.
fn look(
    mut spawned: MessageReader<SheetSceneSpawned>,
    world: Res<SheetWorld>,
    mut camera: Single<(&mut Transform, &mut Projection), With<Camera3d>>,
) {
    if spawned.read().count() == 0 {
        return;
    }
    let bounds = world.sheets().iter().filter_map(|sheet| sheet.state.x.bounds());
    let (low, high) = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
    let (middle, size) = ((0.5 * (low + high)).as_vec3(), (high - low).max_element() as f32);
    let (eye, target) = world.scene().camera.map_or_else(
        || (middle + 1.6 * size * Vec3::new(0.5, 0.6, 1.0), middle - 0.3 * size * Vec3::Y),
        |view| (view.eye.as_vec3(), view.target.as_vec3()),
    );
    *camera.0 = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    // Some scenes are centimetres large.
    if let Projection::Perspective(lens) = &mut *camera.1 {
        lens.near = (0.02 * eye.distance(target)).min(0.1);
    }
}
