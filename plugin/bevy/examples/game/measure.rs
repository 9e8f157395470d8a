//! A round without window or graphics: times of its frames, score and sound.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::asset::AssetApp;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sheetwork::prelude::*;

use crate::rules::{Round, RulesPlugin, Throw};
use crate::sound::{Mixer, SoundPlugin};

const FRAMES: usize = 1_000;
/// Frames in which a ball is thrown.
const THROWS: [usize; 3] = [120, 360, 600];

pub fn run() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default()));
    app.add_plugins((bevy::mesh::MeshPlugin, bevy::camera::visibility::VisibilityPlugin));
    app.init_asset::<StandardMaterial>().init_asset::<Image>();
    app.add_plugins((SheetworkPlugins, bevy::diagnostic::DiagnosticsPlugin, RulesPlugin, SoundPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)));
    app.world_mut().resource_mut::<SheetWorld>().set_threads(2).expect("in range");
    app.world_mut().spawn(SheetBody::floor());
    app.finish();
    app.cleanup();
    let mut times = Vec::with_capacity(FRAMES);
    for frame in 0..FRAMES {
        if THROWS.contains(&frame) {
            let height = 0.06 + 1e-4 * frame as f32;
            app.world_mut().write_message(Throw(Vec3::new(-0.85, height, 0.004), Vec3::new(3.0, 1.6, 0.0)));
        }
        let start = Instant::now();
        app.update();
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    let round = app.world().resource::<Round>();
    println!("{} cards down with {} balls", round.fallen, round.thrown);
    let late = times.iter().filter(|time| **time > 1e3 / 60.0).count();
    let sorted = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times
    };
    let sorted = sorted(times.clone());
    let at = |part: f64| sorted[((FRAMES - 1) as f64 * part) as usize];
    println!(
        "frame, ms: median {:.2}, 99 % {:.2}, worst {:.2}; {late} of {FRAMES} over 16.7",
        at(0.5),
        at(0.99),
        at(1.0)
    );
    let mixer = app.world().resource::<Mixer>();
    match mixer.write_wav(Path::new("game.wav")) {
        Ok(()) => println!("game.wav: {:.1} s of sound", mixer.samples.len() as f64 / 24_000.0),
        Err(problem) => println!("game.wav cannot be written: {problem}"),
    }
}
