//! Sound of the contacts: every hit is a short burst of noise, as loud as its impulse.
//!
//! The samples go to the system's player `aplay`, if there is one, and to a file. A game with
//! Bevy's audio plays a sample of its own at `SheetContact::contact.pair.point` instead.

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

const RATE: f32 = 24_000.0;
/// Decay time of a burst, s, and the impulse that gives full loudness, N s.
const DECAY: f32 = 0.012;
const FULL: f64 = 2e-3;

/// Mixer of the bursts.
#[derive(Resource, Default)]
pub struct Mixer {
    bursts: Vec<Burst>,
    noise: u32,
    /// Samples so far.
    pub samples: Vec<i16>,
    player: Option<Child>,
}

struct Burst {
    loudness: f32,
    pitch: f32,
    age: f32,
}

pub struct SoundPlugin;

impl Plugin for SoundPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Mixer>().add_systems(Update, (hear, mix).chain());
    }
}

impl Mixer {
    /// Play through the system's player as well.
    pub fn playing() -> Self {
        let arguments = ["-q", "-t", "raw", "-f", "S16_LE", "-r", "24000"];
        let player = Command::new("aplay").args(arguments).stdin(Stdio::piped()).stderr(Stdio::null()).spawn().ok();
        Self { player, ..default() }
    }

    fn next(&mut self) -> i16 {
        // A linear congruential generator is noise enough.
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (self.noise >> 8) as f32 / 8_388_608.0 - 1.0;
        let each = self.bursts.iter_mut().map(|burst| {
            burst.age += 1.0 / RATE;
            let tone = (burst.age * burst.pitch * std::f32::consts::TAU).sin();
            burst.loudness * (-burst.age / DECAY).exp() * (0.6 * noise + 0.4 * tone)
        });
        (each.sum::<f32>().clamp(-1.0, 1.0) * 32_000.0) as i16
    }

    /// Write the samples so far as a WAV file.
    pub fn write_wav(&self, path: &Path) -> std::io::Result<()> {
        let bytes: Vec<u8> = self.samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
        let (rate, length) = (RATE as u32, bytes.len() as u32);
        let mut file = std::fs::File::create(path)?;
        file.write_all(b"RIFF")?;
        file.write_all(&(36 + length).to_le_bytes())?;
        file.write_all(b"WAVEfmt \x10\0\0\0\x01\0\x01\0")?;
        file.write_all(&rate.to_le_bytes())?;
        file.write_all(&(2 * rate).to_le_bytes())?;
        file.write_all(b"\x02\0\x10\0data")?;
        file.write_all(&length.to_le_bytes())?;
        file.write_all(&bytes)
    }
}

fn hear(mut contacts: MessageReader<SheetContact>, mut mixer: ResMut<Mixer>) {
    for hit in contacts.read().filter(|contact| contact.kind != ContactEventKind::Ended) {
        let pair = &hit.contact.pair;
        let loudness = (pair.impulse.length() / FULL).min(1.0).sqrt() as f32;
        let pitch = 900.0 + 250.0 * pair.approach_speed.min(4.0) as f32;
        mixer.bursts.push(Burst { loudness, pitch, age: 0.0 });
    }
}

fn mix(mut mixer: ResMut<Mixer>, time: Res<Time>) {
    let count = (time.delta_secs() * RATE).min(RATE) as usize;
    let new: Vec<i16> = (0..count).map(|_| mixer.next()).collect();
    mixer.bursts.retain(|burst| burst.age < 8.0 * DECAY);
    let bytes: Vec<u8> = new.iter().flat_map(|sample| sample.to_le_bytes()).collect();
    let pipe = mixer.player.as_mut().and_then(|player| player.stdin.as_mut());
    if pipe.is_some_and(|pipe| pipe.write_all(&bytes).is_err()) {
        mixer.player = None;
    }
    mixer.samples.extend(new);
}
