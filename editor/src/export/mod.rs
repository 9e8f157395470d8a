//! Export of a run: a picture for each moment, or one glTF file in which sheets bend and bodies move.
//!
//! A [`Job`] goes through a run from the present moment, some moments a second, and lets its caller breathe in between: the window shows how far
//! it is, the command line has it done at once.

pub mod gltf;
mod track;

use std::path::{Path, PathBuf};

use sheetwork::{InputError, check_range};

use crate::camera::Camera;
use crate::picture::{Look, Picture};
use crate::session::Session;
pub use track::Track;

/// Moments a second unless told otherwise.
pub const RATE: f64 = 30.0;

/// Most moments in a glTF file: each is a morph target with as many weights as there are moments.
pub const MOST_TARGETS: usize = 1000;

/// Most pictures of a sequence.
pub const MOST_PICTURES: usize = 100_000;

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// Pictures of this size, numbered: `name_0000.png` and so on, by the rasteriser that needs no graphics driver.
    Sequence(Look, (u32, u32)),
    /// Binary glTF.
    Gltf,
}

/// An export that is on its way.
#[derive(Clone, Debug)]
pub struct Job {
    /// What is written.
    pub kind: Kind,
    /// Its name: that of the file, or what the names of pictures begin with.
    pub file: PathBuf,
    /// Moments a simulated second.
    pub rate: f64,
    /// How long, simulated s.
    pub seconds: f64,
    done: usize,
    count: usize,
    track: Option<Track>,
    began: bool,
}

/// The file of picture `index` of a sequence whose names begin as `file` does.
pub fn picture_file(file: &Path, index: usize) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}_{index:04}.png"))
}

/// How many moments there are in `seconds` at `rate` a second, both ends included.
///
/// # Errors
/// When one is out of range, or there would be more than `most`.
pub fn moments(rate: f64, seconds: f64, most: usize) -> Result<usize, InputError> {
    check_range("rate", rate, 0.01, 1e4, "a second")?;
    check_range("seconds", seconds, 0.0, 1e6, "s")?;
    let count = (rate * seconds + 1e-9).floor() + 1.0;
    if count > most as f64 {
        let problem =
            format!("{count} moments are more than the {most} that there may be: fewer a second, or less time");
        return Err(InputError::new("rate", problem));
    }
    Ok(count as usize)
}

impl Job {
    /// One that has not begun: from the present moment on for the scene's duration.
    pub fn new(kind: Kind, file: &Path, seconds: f64) -> Self {
        let file = file.to_path_buf();
        Self { kind, file, rate: RATE, seconds, done: 0, count: 0, track: None, began: false }
    }

    /// Begins.
    ///
    /// # Errors
    /// When rate or duration are out of range.
    pub fn begin(&mut self, session: &mut Session) -> Result<(), InputError> {
        let most = if self.kind == Kind::Gltf { MOST_TARGETS } else { MOST_PICTURES };
        self.count = moments(self.rate, self.seconds, most)?;
        (self.began, self.done) = (true, 0);
        session.pause();
        Ok(())
    }

    /// Whether it has begun.
    pub fn has_begun(&self) -> bool {
        self.began
    }

    /// How much of it is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.done as f32 / self.count.max(1) as f32
    }

    /// Takes up the next moment; true when it was the last and everything is written.
    ///
    /// # Errors
    /// When something cannot be written.
    pub fn step(&mut self, session: &mut Session, camera: &Camera) -> Result<bool, InputError> {
        if self.done > 0 {
            // By whole moments from the start, so that rounding does not add up.
            session.run(1.0 / self.rate);
        }
        match &self.kind {
            Kind::Sequence(look, size) => {
                let file = picture_file(&self.file, self.done);
                let picture = Picture::draw(session.world(), camera, look, *size);
                picture.save(&file).map_err(|e| InputError::io(&file, &e))?;
            }
            Kind::Gltf => {
                let track = self.track.get_or_insert_with(|| Track::of(session.world()));
                track.take(session.world(), self.done as f64 / self.rate);
            }
        }
        self.done += 1;
        if self.done < self.count {
            return Ok(false);
        }
        if let Some(track) = self.track.take() {
            let bytes = gltf::binary(&track, &session.scene().name);
            std::fs::write(&self.file, bytes).map_err(|e| InputError::io(&self.file, &e))?;
        }
        Ok(true)
    }
}
