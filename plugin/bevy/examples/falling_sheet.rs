//! Scene from a file: the thesis's sheet falls on a wedge.
//!
//! Keys: S springs, M nodes, L displayed layer, space pause, right arrow one step, R reset, up and
//! down speed. Run from a checkout: `cargo run -p bevy_sheetwork --example falling_sheet [SCENE]`,
//! where SCENE is the name of a file in `assets/scenes`, `wedge` by default.

use std::time::Duration;

use bevy::light::CascadeShadowConfigBuilder;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

fn main() {
    let assets = AssetPlugin { file_path: "../../assets".into(), ..default() };
    App::new()
        .add_plugins((DefaultPlugins.set(assets), SheetworkPlugins, SheetworkDebugPlugin))
        .insert_resource(ClearColor(Color::srgb(0.80, 0.83, 0.87)))
        .insert_resource(SheetDebug { springs: false, masses: false, full_strain: 0.3, ..default() })
        .add_systems(Startup, setup)
        .add_systems(Update, (keys, look, say))
        .run();
}

fn setup(mut commands: Commands, server: Res<AssetServer>) {
    let name = std::env::args().nth(1).unwrap_or_else(|| "wedge".into());
    commands.spawn(SheetSceneRoot(server.load(format!("scenes/{name}.ron"))));
    // The thesis's scenes are centimetres large and need finer shadows and a closer near plane.
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 2,
        minimum_distance: 0.01,
        first_cascade_far_bound: 0.12,
        maximum_distance: 0.4,
        ..default()
    };
    commands.spawn((
        DirectionalLight {
            illuminance: 6_500.0,
            shadow_maps_enabled: true,
            shadow_depth_bias: 0.0004,
            shadow_normal_bias: 1.2,
            ..default()
        },
        shadows.build(),
        Transform::from_xyz(0.5, 1.0, 0.25).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let near = Projection::Perspective(PerspectiveProjection { near: 0.002, ..default() });
    let ambient = AmbientLight { brightness: 320.0, ..default() };
    commands.spawn((
        Camera3d::default(),
        near,
        ambient,
        Transform::from_xyz(0.05, 0.03, 0.09).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Place the camera of the scene, and make a tick a whole number of time steps.
fn look(
    mut spawned: MessageReader<SheetSceneSpawned>,
    world: Res<SheetWorld>,
    mut fixed: ResMut<Time<Fixed>>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    if spawned.read().count() == 0 {
        return;
    }
    if let Some(view) = world.scene().camera {
        **camera = Transform::from_translation(view.eye.as_vec3()).looking_at(view.target.as_vec3(), Vec3::Y);
    }
    let whole_steps = (1.0 / 60.0 / world.dt()).round().max(1.0);
    fixed.set_timestep(Duration::from_secs_f64(whole_steps * world.dt()));
}

fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut debug: ResMut<SheetDebug>,
    mut clock: ResMut<SheetClock>,
    mut displays: Query<&mut SheetDisplay>,
    roots: Query<(Entity, &SheetSceneRoot)>,
    mut commands: Commands,
) {
    debug.springs ^= keys.just_pressed(KeyCode::KeyS);
    debug.masses ^= keys.just_pressed(KeyCode::KeyM);
    clock.paused ^= keys.just_pressed(KeyCode::Space);
    if keys.just_pressed(KeyCode::ArrowUp) {
        clock.speed *= 2.0;
    }
    if keys.just_pressed(KeyCode::ArrowDown) {
        clock.speed *= 0.5;
    }
    if keys.just_pressed(KeyCode::ArrowRight) {
        clock.step_once();
    }
    if keys.just_pressed(KeyCode::KeyL) {
        for mut display in &mut displays {
            let bottom = display.layer == SheetLayer::Bottom;
            display.layer = if bottom { SheetLayer::Top } else { SheetLayer::Bottom };
        }
    }
    if keys.just_pressed(KeyCode::KeyR) {
        for (entity, root) in &roots {
            commands.entity(entity).insert(root.clone());
        }
    }
}

/// Print events.
fn say(mut events: MessageReader<SheetEvent>) {
    for event in events.read() {
        let body = event.body.as_deref().unwrap_or("-");
        info!("{:8.3} s: {} {:?} {body}", event.time, event.sheet, event.kind);
    }
}
