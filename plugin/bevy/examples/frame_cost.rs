//! Cost of a frame without window or graphics: with visible, hidden, sleeping, and without sheets.
//!
//! A hundred sheets of 21 x 21 nodes fall, with the thesis's springs, whose steps are cheap.
//! Visible sheets are stepped and written into their meshes, hidden ones are stepped, sleeping ones
//! are neither. The four games take turns frame by frame, so that other load on the machine affects
//! all alike.
//!
//! `cargo run --release -p bevy_sheetwork --example frame_cost`

use std::time::{Duration, Instant};

use bevy::asset::AssetApp;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::{Air, Scene};

/// Sheets in a row.
const ROW: u32 = 10;
/// Frames before the measurement, long enough for resting sheets to fall asleep, and measured
/// frames.
const BEFORE: u32 = 300;
const FRAMES: u32 = 600;

#[derive(Clone, Copy, PartialEq)]
enum Sheets {
    None,
    Asleep,
    Hidden,
    Seen,
}

fn main() {
    let kinds = [Sheets::None, Sheets::Asleep, Sheets::Hidden, Sheets::Seen];
    let mut games: Vec<(App, Vec<f64>)> = kinds.map(|kind| (game(kind), Vec::new())).into();
    for frame in 0..BEFORE + FRAMES {
        for (app, times) in &mut games {
            let start = Instant::now();
            app.update();
            if frame >= BEFORE {
                times.push(1e3 * start.elapsed().as_secs_f64());
            }
        }
    }
    let medians: Vec<f64> = games.iter_mut().map(|(_, times)| median(times)).collect();
    let rows = ["no sheet", "all asleep, seen", "all moving, hidden", "all moving, seen"];
    println!("{} sheets of 21x21 masses, a frame of 1/60 s", ROW * ROW);
    for (row, time) in rows.iter().zip(&medians) {
        println!("{row:<20} {time:>8.3} ms {:>6.1} % of what moves and is seen", 100.0 * time / medians[3]);
    }
    let asleep = games[1].0.world_mut().query::<&SheetState>().iter(games[1].0.world()).filter(|s| s.asleep).count();
    println!("{asleep} of the sheets that should sleep do");
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn game(kind: Sheets) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()));
    app.add_plugins((bevy::mesh::MeshPlugin, bevy::camera::visibility::VisibilityPlugin));
    app.init_asset::<StandardMaterial>().init_asset::<Image>();
    app.add_plugins((SheetworkPlugins, bevy::diagnostic::DiagnosticsPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)));
    let settings = Scene { air: Air { density: 1.2, ..default() }, ..Scene::thesis() };
    app.world_mut().resource_mut::<SheetWorld>().restart(&settings).expect("in range");
    if kind == Sheets::Asleep {
        app.world_mut().spawn(SheetBody::floor());
    }
    for k in (0..ROW * ROW).filter(|_| kind != Sheets::None) {
        let [column, row] = [k % ROW, k / ROW].map(|n| 0.5 * n as f32);
        let sheet = Sheet::thesis().grid(21, 21).size(0.25, 0.25);
        let height = if kind == Sheets::Asleep { 2.6e-4 } else { 1.0 };
        let seen = if kind == Sheets::Hidden { Visibility::Hidden } else { Visibility::Inherited };
        app.world_mut().spawn((sheet, Transform::from_xyz(column, height, row), seen));
    }
    app.finish();
    app.cleanup();
    app
}
