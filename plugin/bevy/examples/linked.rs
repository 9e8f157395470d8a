//! Game that other processes observe and command.
//!
//! Run from a checkout: `cargo run -p bevy_sheetwork --features link --example linked`, with `--
//! --no-window` without a screen. Then, in other terminals, `sheetwork watch`, `sheetwork set
//! gravity "(0, -1.6, 0)"`, `sheetwork set sheets.card.material.young 1e8`, `sheetwork tell reset`,
//! `python runtime/link/python/examples/tip_height.py`. The game prints the attached clients.

use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

fn main() {
    let mut app = App::new();
    if std::env::args().any(|word| word == "--no-window") {
        let frame = ScheduleRunnerPlugin::run_loop(Duration::from_secs_f64(1.0 / 60.0));
        app.add_plugins((
            MinimalPlugins.set(frame),
            LogPlugin::default(),
            TransformPlugin,
            SheetworkCorePlugin::default(),
        ));
    } else {
        app.add_plugins((DefaultPlugins, SheetworkPlugins));
    }
    // After the plugin that creates the world.
    app.add_plugins(SheetLinkPlugin::default()).add_systems(Startup, setup).add_systems(Update, say).run();
}

fn setup(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.1, 0.3, 0.7).looking_at(Vec3::new(0.0, 0.15, 0.0), Vec3::Y),
    ));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn(SheetBody::floor());
    for (place, material) in [(-0.15, "paper"), (0.15, "card")] {
        let sheet = Sheet::new(material).named(material).size(0.2, 0.1).clamp(Region::Left);
        commands.spawn((sheet, Transform::from_xyz(0.0, 0.25, place)));
    }
}

/// Print the attached clients, at most once a second, after a change.
fn say(link: Res<SheetLink>, time: Res<Time<Real>>, mut last: Local<(f32, String)>) {
    if time.elapsed_secs() < last.0 {
        return;
    }
    last.0 = time.elapsed_secs() + 1.0;
    let now = match link.statistics() {
        Ok(statistics) => {
            let who: Vec<String> = link.attached().iter().map(ToString::to_string).collect();
            let who = if who.is_empty() { "nobody".to_owned() } else { who.join(", ") };
            format!("link \"{}\": {who}, {} commands", link.name().unwrap_or_default(), statistics.accepted)
        }
        Err(error) => format!("no link: {error}"),
    };
    if now != last.1 {
        info!("{now}");
        last.1 = now;
    }
}
