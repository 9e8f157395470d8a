//! An app without window or graphics, with a clock driven by the test.

#![allow(dead_code)]

use std::time::Duration;

use bevy::app::{App, PluginGroup};
use bevy::asset::AssetApp;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_rapier3d::rapier::prelude::PhysicsWorld;
use bevy_sheetwork::sheetwork::rigid::RigidView;
use bevy_sheetwork::sheetwork::scene::{Air, Scene};
use bevy_sheetwork::{SheetClock, SheetWorld, SheetworkPlugins, SheetworkSet};

/// All plugins of the group over a minimal Bevy app, with the assets of rendering.
pub fn app() -> App {
    app_with(SheetworkPlugins.build())
}

/// The given plugins over a minimal Bevy app.
pub fn app_with(plugins: impl PluginGroup) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin { file_path: "../../assets".into(), ..default() }));
    app.add_plugins((bevy::mesh::MeshPlugin, bevy::camera::visibility::VisibilityPlugin));
    app.init_asset::<StandardMaterial>().init_asset::<Image>();
    app.add_plugins(plugins);
    app.add_plugins(bevy::diagnostic::DiagnosticsPlugin);
    app.finish();
    app.cleanup();
    app
}

/// The caller's rigid world.
#[derive(Resource)]
pub struct Game(pub PhysicsWorld);

/// Let the sheets of `app` meet the bodies of `game`, and push them.
pub fn lend(app: &mut App, game: PhysicsWorld) {
    app.insert_resource(Game(game)).add_systems(FixedUpdate, step.in_set(SheetworkSet::Step));
}

fn step(mut game: ResMut<Game>, mut sheets: ResMut<SheetWorld>, clock: Res<SheetClock>) {
    game.0.integration_parameters.dt = clock.due() as f32;
    game.0.step();
    let rigid = &game.0;
    let view = RigidView::new(&rigid.broad_phase, &rigid.narrow_phase, &rigid.bodies, &rigid.colliders);
    sheets.advance_with(&view.pushing(), clock.due());
    sheets.write_lent_bodies(&mut game.0.bodies);
}

/// As [`app`], with the explicit integrator and the step for the soft lattice of the thesis.
pub fn thesis_app() -> App {
    let mut app = app();
    explicit(&mut app);
    app
}

/// Sets the explicit integrator and the step of the thesis.
pub fn explicit(app: &mut App) {
    let air = Air { density: 1.2, ..Air::default() };
    let settings = Scene { air, ..Scene::thesis() };
    app.world_mut().resource_mut::<SheetWorld>().restart(&settings).expect("in range");
}

/// One frame of `seconds`.
pub fn frame(app: &mut App, seconds: f64) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(seconds)));
    app.update();
}

/// Frames of one tick each, for `seconds` in all.
pub fn run(app: &mut App, seconds: f64) {
    let tick = app.world().resource::<Time<Fixed>>().timestep().as_secs_f64();
    for _ in 0..(seconds / tick).round() as u32 {
        frame(app, tick);
    }
}

/// Frames until `done`, at most `most`; returns whether it became true. Sleeps between frames while
/// files are read.
pub fn run_until(app: &mut App, most: u32, done: impl Fn(&mut App) -> bool) -> bool {
    for _ in 0..most {
        frame(app, 1.0 / 64.0);
        if done(app) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    false
}
