//! A small game: knock down a house of cards with three balls.
//!
//! Hold the left mouse button to draw, release it to throw at the pointer; R builds the house
//! again. The title of the window shows the score, and the hits are heard where there is `aplay`.
//!
//! `cargo run --release -p bevy_sheetwork --example game`; with `-- --measure` it plays a round of
//! 1,000 frames without a window, prints the times of its frames and writes `game.wav`.

mod measure;
mod rules;
mod sound;
#[path = "../stage/mod.rs"]
mod stage;

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use rules::{Restart, Round, RulesPlugin, Throw};

/// Fastest throw, m/s, after this time of drawing, s.
const FASTEST: f32 = 6.0;
const FULL_DRAW: f32 = 0.8;

/// Time for which the button has been held, s.
#[derive(Resource, Default)]
struct Draw(f32);

fn main() {
    if std::env::args().any(|argument| argument == "--measure") {
        measure::run();
        return;
    }
    let mut app = stage::app("", Vec3::new(0.1, 0.26, 0.55), Vec3::new(0.03, 0.05, 0.0), 0.45);
    app.add_plugins((RulesPlugin, sound::SoundPlugin)).init_resource::<Draw>().add_systems(Update, (play, show));
    if std::env::args().any(|argument| argument == "--picture") {
        app.add_systems(Startup, |mut throws: MessageWriter<Throw>| {
            throws.write(Throw(Vec3::new(-0.85, 0.06, 0.004), Vec3::new(3.0, 1.6, 0.0)));
        });
    } else {
        app.insert_resource(sound::Mixer::playing());
    }
    app.run();
}

fn play(
    (buttons, keys, time): (Res<ButtonInput<MouseButton>>, Res<ButtonInput<KeyCode>>, Res<Time>),
    mut draw: ResMut<Draw>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut throws: MessageWriter<Throw>,
    mut restarts: MessageWriter<Restart>,
) {
    if keys.just_pressed(KeyCode::KeyR) {
        restarts.write(Restart);
    }
    if buttons.pressed(MouseButton::Left) {
        draw.0 = (draw.0 + time.delta_secs()).min(FULL_DRAW);
    }
    let (camera, eye) = *camera;
    let aim = window.cursor_position().and_then(|cursor| camera.viewport_to_world(eye, cursor).ok());
    if let (true, Some(ray)) = (buttons.just_released(MouseButton::Left), aim) {
        let speed = FASTEST * std::mem::take(&mut draw.0) / FULL_DRAW;
        // A little upwards, against the drop on the way.
        throws.write(Throw(ray.origin + 0.1 * *ray.direction, ray.direction * speed + Vec3::Y * 0.4));
    }
}

fn show(round: Res<Round>, draw: Res<Draw>, mut window: Single<&mut Window, With<PrimaryWindow>>) {
    let power = "|".repeat((10.0 * draw.0 / FULL_DRAW) as usize);
    let over = if round.is_over { " - R: again" } else { "" };
    let title = format!("{} cards down, ball {} of 3 {power}{over}", round.fallen, round.thrown);
    if window.title != title {
        window.title = title;
    }
}
