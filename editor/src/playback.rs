//! A recording in the editor: its frames instead of a simulation, at any speed, to any moment: places, temperatures, holes.
//!
//! Made by `sheetwork run --record`, `sheetwork record` or a run without a window. Between two frames things lie on the straight line
//! from one to the other.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sheetwork::scene::Scene;
use sheetwork::world::recording::{Frame, Header, RecordedTemperature, read};
use sheetwork::{InputError, World};

use crate::scenes;

/// A recording that is played.
#[derive(Clone, Debug)]
pub struct Playback {
    /// Shared with whatever shows it apart.
    frames: Arc<[Frame]>,
    /// From the start of the recording, s.
    at: f64,
    shown: Frame,
}

/// Whether a file's name ends as a recording's does.
pub fn is_recording(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("swr"))
}

/// The scene that the recording `file` is of, and its frames.
///
/// # Errors
/// When the file is no recording, or what its scene names is not found.
pub fn open(file: &Path) -> Result<(Scene, Playback), InputError> {
    let (header, frames) = read(file)?;
    let scene = scene_of(&header, file)?;
    let Some(first) = frames.first().cloned() else {
        return Err(InputError::new("", "is a recording without a frame").in_file(file));
    };
    // Checked once, so that a frame can be shown without asking.
    let world = World::new(&scene)?;
    for (index, frame) in frames.iter().enumerate() {
        world.can_show(frame).map_err(|e| InputError::new(format!("frame {index}"), e.problem).in_file(file))?;
    }
    Ok((scene, Playback { shown: first, frames: frames.into(), at: 0.0 }))
}

/// The scene, with the files it names looked for beside the recording, where one is, and among the editor's own scenes.
fn scene_of(header: &Header, file: &Path) -> Result<Scene, InputError> {
    let mut scene = Scene::parse(&header.source).map_err(|e| e.in_file(file))?;
    let beside = file.parent().map(Path::to_path_buf).unwrap_or_default();
    let mut refused = None;
    for folder in [Some(beside), Some(PathBuf::new()), scenes::folder()].into_iter().flatten() {
        scene.base = folder;
        match World::new(&scene) {
            Ok(_) => return Ok(scene),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    Err(refused.unwrap_or_else(|| InputError::new("", "holds no scene").in_file(file)))
}

impl Playback {
    /// How long it is, s.
    pub fn duration(&self) -> f64 {
        let ends = (self.frames.first(), self.frames.last());
        if let (Some(first), Some(last)) = ends { (last.time - first.time).max(0.0) } else { 0.0 }
    }

    /// Where it is, s from its start.
    pub fn at(&self) -> f64 {
        self.at
    }

    /// Whether it is at its end.
    pub fn is_over(&self) -> bool {
        self.at >= self.duration()
    }

    /// Whether it has temperatures, or what those have made of the stiffness, that sheets can be coloured by.
    pub fn has_heat(&self) -> bool {
        self.frames.iter().flat_map(|f| &f.warmth).any(|w| *w != RecordedTemperature::Unknown)
    }

    /// Frames there are.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Goes to `at` s from its start, or to its nearer end, and shows that in `world`; a moment that is not a number is ignored.
    pub fn seek(&mut self, at: f64, world: &mut World) {
        if at.is_nan() {
            return;
        }
        self.at = at.clamp(0.0, self.duration());
        let start = self.frames.first().map_or(0.0, |f| f.time);
        let time = start + self.at;
        // A recording that goes on through a reset runs backwards there: the first pass counts.
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
        self.shown.warmth.clear();
        let warmth = a.warmth.iter().enumerate().map(|(index, from)| from.towards(b.warmth_of(index), part));
        self.shown.warmth.extend(warmth);
        // What opened between the two is seen when the second is there.
        self.shown.open.clone_from(if part < 1.0 { &a.open } else { &b.open });
        // Every frame was found to be of this world when it was opened.
        let _ = world.show(&self.shown);
    }

    /// One frame further.
    pub fn step(&mut self, world: &mut World) {
        let start = self.frames.first().map_or(0.0, |f| f.time);
        let next = self.frames.iter().map(|f| f.time - start).find(|t| *t > self.at + 1e-9);
        self.seek(next.unwrap_or_else(|| self.duration()), world);
    }
}
