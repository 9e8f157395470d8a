//! Export of a run: a picture for each moment, or one glTF file in which sheets bend and bodies move.
//!
//! A [`Job`] goes through a run from the present moment, some moments a second, and lets its caller breathe in between: the window shows how far
//! it is, the command line has it done at once. The run is a [`Film`], a world of its own: what is exported is what plays, whatever the moments, and the
//! session stays where it is.

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

/// An export that is set up, or on its way.
pub struct Job {
    /// What is written.
    pub kind: Kind,
    /// Its name: that of the file, or what the names of pictures begin with.
    pub file: PathBuf,
    /// Moments a simulated second.
    pub rate: f64,
    /// How long, simulated s.
    pub seconds: f64,
    course: Option<Course>,
}

/// One that is on its way.
struct Course {
    film: Film,
    camera: Camera,
    track: Track,
    done: usize,
    count: usize,
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
        Self { kind, file: file.to_path_buf(), rate: RATE, seconds, course: None }
    }

    /// Begins with `session` as it is now, seen by `camera`; it is not needed any more.
    ///
    /// # Errors
    /// When rate or duration are out of range, or the scene cannot be built any more.
    pub fn begin(&mut self, session: &Session, camera: &Camera) -> Result<(), InputError> {
        let most = if self.kind == Kind::Gltf { MOST_TARGETS } else { MOST_PICTURES };
        let count = moments(self.rate, self.seconds, most)?;
        let film = Film::of(session)?;
        let track = if self.kind == Kind::Gltf { Track::of(film.world()) } else { Track::default() };
        self.course = Some(Course { film, camera: *camera, track, done: 0, count });
        Ok(())
    }

    /// Whether it has begun.
    pub fn has_begun(&self) -> bool {
        self.course.is_some()
    }

    /// How much of it is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.course.as_ref().map_or(0.0, |course| course.done as f32 / course.count.max(1) as f32)
    }

    /// The world as far as the run has come, once it has begun.
    pub fn world(&self) -> Option<&World> {
        self.course.as_ref().map(|course| course.film.world())
    }

    /// Takes up the next moment; true when it was the last and everything is written, or when it has not begun.
    ///
    /// # Errors
    /// When something cannot be written.
    pub fn step(&mut self) -> Result<bool, InputError> {
        let Some(Course { film, camera, track, done, count }) = &mut self.course else { return Ok(true) };
        // From the start each, so that rounding does not add up.
        let after = *done as f64 / self.rate;
        let world = film.at(after)?;
        match &self.kind {
            Kind::Sequence(look, size) => {
                let file = picture_file(&self.file, *done);
                let picture = Picture::draw(world, camera, look, *size);
                picture.save(&file).map_err(|e| InputError::io(&file, &e))?;
            }
            Kind::Gltf => track.take(world, after),
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
