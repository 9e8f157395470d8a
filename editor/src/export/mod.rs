//! Export of a run: a sequence of pictures, or one glTF file with deforming sheets and moving
//! bodies.
//!
//! A [`Job`] steps through a run from the present state, some moments per second. The window does
//! part of the work in each frame; the command line does all at once. The run is a [`Film`] with a
//! world of its own, so that the export equals playback and the session is unchanged.

mod film;
pub mod gltf;
mod track;

use std::path::{Path, PathBuf};

use sheetwork::{InputError, World, check_range};

use crate::camera::Camera;
use crate::picture::{Look, Picture};
use crate::session::Session;
pub use film::Film;
pub use track::Track;

/// Default moments per second.
pub const RATE: f64 = 30.0;

/// Maximum number of moments in a glTF file: each is a morph target with as many weights as there
/// are moments.
pub const MAX_TARGETS: usize = 1000;

/// Maximum number of pictures of a sequence.
pub const MAX_PICTURES: usize = 100_000;

/// Kind of export.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// Pictures of this size, numbered `name_0000.png` and so on, by the software rasteriser.
    Sequence(Look, (u32, u32)),
    /// Binary glTF.
    Gltf,
}

/// Export in preparation or in progress.
pub struct Job {
    /// Kind of export.
    pub kind: Kind,
    /// Path of the file, or prefix of the pictures.
    pub file: PathBuf,
    /// Moments per simulated second.
    pub rate: f64,
    /// Duration, simulated s.
    pub seconds: f64,
    course: Option<Course>,
}

/// Progress of an export.
struct Course {
    film: Film,
    camera: Camera,
    track: Track,
    done: usize,
    count: usize,
}

/// File of picture `index` of a sequence with the prefix `file`.
pub fn picture_file(file: &Path, index: usize) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}_{index:04}.png"))
}

/// Number of moments in `seconds` at `rate` per second, both ends included.
///
/// # Errors
/// When a value is out of range, or there are more than `most` moments.
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
    /// Export in preparation: from the present state for the scene's duration.
    pub fn new(kind: Kind, file: &Path, seconds: f64) -> Self {
        Self { kind, file: file.to_path_buf(), rate: RATE, seconds, course: None }
    }

    /// Start from the present state of `session`, seen by `camera`; the session is not needed
    /// afterwards.
    ///
    /// # Errors
    /// When rate or duration is out of range, or the scene cannot be built.
    pub fn begin(&mut self, session: &Session, camera: &Camera) -> Result<(), InputError> {
        let most = if self.kind == Kind::Gltf { MAX_TARGETS } else { MAX_PICTURES };
        let count = moments(self.rate, self.seconds, most)?;
        let film = Film::from_session(session)?;
        let track = if self.kind == Kind::Gltf { Track::from_world(film.world()) } else { Track::default() };
        self.course = Some(Course { film, camera: *camera, track, done: 0, count });
        Ok(())
    }

    /// Whether the export has started.
    pub fn has_begun(&self) -> bool {
        self.course.is_some()
    }

    /// Completed fraction, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.course.as_ref().map_or(0.0, |course| course.done as f32 / course.count.max(1) as f32)
    }

    /// World of the run, after the start.
    pub fn world(&self) -> Option<&World> {
        self.course.as_ref().map(|course| course.film.world())
    }

    /// Export the next moment. Returns true when everything is written, or when the export has not
    /// started.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn step(&mut self) -> Result<bool, InputError> {
        let Some(Course { film, camera, track, done, count }) = &mut self.course else { return Ok(true) };
        // Multiples of the interval, so that rounding does not accumulate.
        let after = *done as f64 / self.rate;
        let world = film.at(after)?;
        match &self.kind {
            Kind::Sequence(look, size) => {
                let file = picture_file(&self.file, *done);
                let picture = Picture::draw(world, camera, look, *size);
                picture.save(&file).map_err(|e| InputError::io(&file, &e))?;
            }
            Kind::Gltf => track.record(world, after),
        }
        *done += 1;
        if *done < *count {
            return Ok(false);
        }
        if self.kind == Kind::Gltf {
            let bytes = gltf::binary(track, &world.scene().name);
            std::fs::write(&self.file, bytes).map_err(|e| InputError::io(&self.file, &e))?;
        }
        Ok(true)
    }
}
