//! Rollback: the inputs of a second player arrive eight ticks late; the game restores the world of
//! that tick and repeats the ticks since.
//!
//! Two players blow at a sheet that hangs by its upper edge: one by the arrow keys, at once, the
//! other simulated and late. Every tick the world is saved (some tens of kilobytes). When a late
//! input arrives, the world of its tick is restored and the later ticks are stepped again with all
//! known inputs. The result equals, bit for bit, that of inputs in time. The title shows the cost
//! beside the duration of a frame.
//!
//! `cargo run -p bevy_sheetwork --example late_inputs`

use std::process::ExitCode;
use std::time::Instant;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

#[path = "late_inputs/history.rs"]
mod history;

use history::{History, LATE, blow};

/// Duration of the last rollback, ms.
#[derive(Resource, Default)]
struct Cost(f64);

fn main() -> ExitCode {
    // Bevy is built with X11 windows here.
    if cfg!(target_os = "linux") && std::env::var_os("DISPLAY").is_none_or(|display| display.is_empty()) {
        eprintln!("there is no display (DISPLAY is not set): the example wants a window");
        return ExitCode::from(2);
    }
    App::new()
        .add_plugins((DefaultPlugins, SheetworkPlugins))
        .insert_resource(ClearColor(Color::srgb(0.80, 0.83, 0.87)))
        .init_resource::<History>()
        .init_resource::<Cost>()
        .add_systems(Startup, setup)
        .add_systems(FixedUpdate, play.before(SheetworkSet::Step))
        .add_systems(Update, say)
        .run();
    ExitCode::SUCCESS
}

fn setup(mut commands: Commands) {
    let view = Transform::from_xyz(0.3, 0.2, 0.8).looking_at(Vec3::Y * 0.1, Vec3::Y);
    commands.spawn((Camera3d::default(), view));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn(SheetBody::floor());
    let hangs = Transform::from_xyz(0.0, 0.2, 0.0).with_rotation(Quat::from_rotation_x(1.2));
    commands.spawn((Sheet::new("pet").size(0.25, 0.25).clamp(Region::Back), hangs));
}

/// Before a tick: apply late inputs, then the input of this tick.
fn play(
    keys: Res<ButtonInput<KeyCode>>,
    mut world: ResMut<SheetWorld>,
    mut history: ResMut<History>,
    mut cost: ResMut<Cost>,
) {
    if world.sheets().is_empty() {
        return;
    }
    let (left, right) = (keys.pressed(KeyCode::ArrowLeft), keys.pressed(KeyCode::ArrowRight));
    history.begin(&world, [f64::from(i8::from(right) - i8::from(left)), 0.0]);
    let tick = history.tick();
    // The other player's input of eight ticks ago arrives; it changes every half second.
    if let Some(then) = tick.checked_sub(LATE) {
        let start = Instant::now();
        let theirs = if (then / 32) % 2 == 0 { 1.0 } else { -1.0 };
        if history.arrives(then, theirs) {
            history.replay(&mut world, then);
            cost.0 = 1e3 * start.elapsed().as_secs_f64();
        }
    }
    blow(&mut world, history.inputs(tick));
}

fn say(cost: Res<Cost>, fixed: Res<Time<Fixed>>, history: Res<History>, mut window: Single<&mut Window>) {
    let frame = 1e3 * fixed.timestep().as_secs_f64();
    window.title = format!(
        "{LATE} ticks back and again: {:.2} ms of {frame:.1}; a snapshot has {} bytes",
        cost.0,
        history.bytes()
    );
}
