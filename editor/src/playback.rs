//! Recording in the editor: its frames in place of a simulation, at any speed and time, with
//! positions, temperatures and open cells.
//!
//! Recordings are made by `sheetwork run --record`, `sheetwork record` or a run without a window.
//! Between two frames, positions are interpolated linearly.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sheetwork::scene::Scene;
use sheetwork::world::recording::{RecordedFrame, RecordedTemperature, RecordingHeader, read};
use sheetwork::{InputError, World};

use crate::scenes;

/// Playback of a recording.
#[derive(Clone, Debug)]
pub struct Playback {
    /// Shared with exports of the recording.
    frames: Arc<[RecordedFrame]>,
    /// Time from the start of the recording, s.
    at: f64,
    shown: RecordedFrame,
}

/// Whether a file has the extension of a recording.
pub fn is_recording(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("swr"))
}

/// Scene and frames of the recording `file`.
///
/// # Errors
/// When the file is not a recording, or a file of its scene is not found.
pub fn open(file: &Path) -> Result<(Scene, Playback), InputError> {
    let (header, frames) = read(file)?;
    let scene = scene_of(&header, file)?;
    let Some(first) = frames.first().cloned() else {
        return Err(InputError::new("", "is a recording without a frame").in_file(file));
    };
    // Every frame is validated here, so that display cannot fail.
    let world = World::with_start_overlaps(&scene)?;
    for (index, frame) in frames.iter().enumerate() {
        world.can_show(frame).map_err(|e| InputError::new(format!("frame {index}"), e.problem).in_file(file))?;
    }
    Ok((scene, Playback { shown: first, frames: frames.into(), at: 0.0 }))
}

/// Scene of a recording. Its files are looked for beside the recording and among the shipped
/// scenes.
fn scene_of(header: &RecordingHeader, file: &Path) -> Result<Scene, InputError> {
    let mut scene = Scene::parse(&header.source).map_err(|e| InputError::from(e).in_file(file))?;
    let beside = file.parent().map(Path::to_path_buf).unwrap_or_default();
    let mut refused = None;
    for folder in [Some(beside), Some(PathBuf::new()), scenes::folder()].into_iter().flatten() {
        scene.base = folder;
        match World::with_start_overlaps(&scene) {
            Ok(_) => return Ok(scene),
            Err(error) => refused = refused.or(Some(InputError::from(error))),
        }
    }
    Err(refused.unwrap_or_else(|| InputError::new("", "holds no scene").in_file(file)))
}

impl Playback {
    /// Duration, s.
    pub fn duration(&self) -> f64 {
        let ends = (self.frames.first(), self.frames.last());
        if let (Some(first), Some(last)) = ends { (last.time - first.time).max(0.0) } else { 0.0 }
    }

    /// Present time from the start, s.
    pub fn at(&self) -> f64 {
        self.at
    }

    /// Whether playback is at the end.
    pub fn is_over(&self) -> bool {
        self.at >= self.duration()
    }

    /// Whether the recording has temperatures or remaining stiffnesses.
    pub fn has_heat(&self) -> bool {
        self.frames.iter().flat_map(|f| &f.temperatures).any(|w| *w != RecordedTemperature::Unknown)
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there are no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Show the state at `at` s from the start, clamped to the duration, in `world`; a value that
    /// is not a number is ignored.
    pub fn seek(&mut self, at: f64, world: &mut World) {
        if at.is_nan() {
            return;
        }
        self.at = at.clamp(0.0, self.duration());
        let start = self.frames.first().map_or(0.0, |f| f.time);
        let time = start + self.at;
        // Times decrease at a recorded reset: the first pass counts.
        let next = self.frames.iter().position(|f| f.time >= time).unwrap_or(self.frames.len().saturating_sub(1));
        let (Some(a), Some(b)) = (self.frames.get(next.saturating_sub(1)), self.frames.get(next)) else { return };
        let span = b.time - a.time;
        let part = if span > 0.0 { ((time - a.time) / span).clamp(0.0, 1.0) as f32 } else { 1.0 };
        self.shown.time = time;
        for (shown, (a, b)) in self.shown.sheets.iter_mut().zip(a.sheets.iter().zip(&b.sheets)) {
            for (shown, (a, b)) in shown.iter_mut().zip(a.iter().zip(b)) {
                *shown = a.lerp(*b, part);
            }
        }
        for (shown, (a, b)) in self.shown.bodies.iter_mut().zip(a.bodies.iter().zip(&b.bodies)) {
            *shown = (a.0.lerp(b.0, part), a.1.slerp(b.1, part));
        }
        self.shown.temperatures.clear();
        let warmth =
            a.temperatures.iter().enumerate().map(|(index, from)| from.towards(b.temperatures_of(index), part));
        self.shown.temperatures.extend(warmth);
        // Cells that open between the two frames appear with the second.
        self.shown.open.clone_from(if part < 1.0 { &a.open } else { &b.open });
        // Every frame was validated when the recording was opened.
        let _ = world.show(&self.shown);
    }

    /// Advance by one frame.
    pub fn step(&mut self, world: &mut World) {
        let start = self.frames.first().map_or(0.0, |f| f.time);
        let next = self.frames.iter().map(|f| f.time - start).find(|t| *t > self.at + 1e-9);
        self.seek(next.unwrap_or_else(|| self.duration()), world);
    }
}
