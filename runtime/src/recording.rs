//! Recordings: what a scene looked like, frame by frame, for playing back without simulating.
//!
//! File layout, little endian: the line `sheetwork recording 1`, a line of JSON ([`Header`]), then frames. A frame is the
//! simulated time (f64, s), then for every sheet the positions of its masses (x, y, z as f32, m), then for every body its
//! position (3 x f32, m) and rotation quaternion (x, y, z, w as f32). All frames have the same length, so that a player can
//! seek. Positions are rounded to f32: this is a picture, not a snapshot to continue from.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::error::InputError;

const MAGIC: &str = "sheetwork recording 1";

/// What a recording holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Name of the scene.
    pub scene: String,
    /// The scene itself (RON), so that a player can rebuild surfaces and bodies.
    pub source: String,
    /// Frames a simulated second.
    pub frames_per_second: f64,
    /// Masses of each sheet.
    pub masses: Vec<usize>,
    /// Number of bodies.
    pub bodies: usize,
}

impl Header {
    /// Length of a frame; saturates where a damaged header asks for the impossible.
    fn frame_bytes(&self) -> usize {
        let masses = self.masses.iter().fold(0_usize, |sum, n| sum.saturating_add(*n));
        masses.saturating_mul(12).saturating_add(self.bodies.saturating_mul(28)).saturating_add(8)
    }
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Simulated time, s.
    pub time: f64,
    /// Positions of the masses of each sheet, m.
    pub sheets: Vec<Vec<Vec3>>,
    /// Position (m) and rotation of each body.
    pub bodies: Vec<(Vec3, Quat)>,
}

/// Writes a recording.
pub struct Recorder {
    file: PathBuf,
    out: BufWriter<File>,
    frames: u64,
}

impl Recorder {
    /// Creates the file and writes the header for `world`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(file: &Path, world: &World, frames_per_second: f64) -> Result<Self, InputError> {
        let header = Header {
            scene: world.scene().name.clone(),
            source: world.scene().to_text()?,
            frames_per_second,
            masses: world.sheets().iter().map(|s| s.masses()).collect(),
            bodies: world.rigid().map_or(0, |r| r.bodies().len()),
        };
        Self::begin(file, &header)
    }

    /// Creates the file for frames that come from elsewhere, as `header` describes them.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn begin(file: &Path, header: &Header) -> Result<Self, InputError> {
        let json = serde_json::to_string(header).map_err(|e| InputError::new("", e.to_string()).in_file(file))?;
        let out = BufWriter::new(File::create(file).map_err(|e| InputError::io(file, &e))?);
        let mut recorder = Self { file: file.to_path_buf(), out, frames: 0 };
        recorder.write(format!("{MAGIC}\n{json}\n").as_bytes())?;
        Ok(recorder)
    }

    /// Appends the world as it is now; its sheets and bodies must be those it was created for.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn frame(&mut self, world: &World) -> Result<(), InputError> {
        self.write(&world.time().to_le_bytes())?;
        for sheet in world.sheets() {
            for p in sheet.x.iter() {
                self.floats(&p.as_vec3().to_array())?;
            }
        }
        if let Some(rigid) = world.rigid() {
            for (position, rotation) in (0..rigid.bodies().len()).filter_map(|i| rigid.pose(i)) {
                self.floats(&position.as_vec3().to_array())?;
                self.floats(&rotation.as_quat().to_array())?;
            }
        }
        self.frames += 1;
        Ok(())
    }

    /// Appends a frame, which must have the masses and bodies that the header has.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn append(&mut self, frame: &Frame) -> Result<(), InputError> {
        self.write(&frame.time.to_le_bytes())?;
        for p in frame.sheets.iter().flatten() {
            self.floats(&p.to_array())?;
        }
        for (position, rotation) in &frame.bodies {
            self.floats(&position.to_array())?;
            self.floats(&rotation.to_array())?;
        }
        self.frames += 1;
        Ok(())
    }

    /// Finishes the file and returns how many frames it holds.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<u64, InputError> {
        self.out.flush().map_err(|e| InputError::io(&self.file, &e))?;
        Ok(self.frames)
    }

    fn floats(&mut self, values: &[f32]) -> Result<(), InputError> {
        values.iter().try_for_each(|v| self.write(&v.to_le_bytes()))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        self.out.write_all(bytes).map_err(|e| InputError::io(&self.file, &e))
    }
}

/// Reads a whole recording.
///
/// # Errors
/// When the file cannot be read, is not a recording, or ends within a frame.
pub fn read(file: &Path) -> Result<(Header, Vec<Frame>), InputError> {
    let bad = |problem: String| InputError::new("", problem).in_file(file);
    let mut input = BufReader::new(File::open(file).map_err(|e| InputError::io(file, &e))?);
    let line = |input: &mut BufReader<File>| -> Result<String, InputError> {
        let mut text = String::new();
        // The scene may be long, but not endless: a file without line ends is no recording.
        input.by_ref().take(64 << 20).read_line(&mut text).map_err(|e| InputError::io(file, &e))?;
        Ok(text.trim_end_matches('\n').to_owned())
    };
    let magic = line(&mut input)?;
    if magic != MAGIC {
        return Err(bad(format!("does not begin with \"{MAGIC}\": not a recording, or of another version")));
    }
    let header: Header = serde_json::from_str(&line(&mut input)?).map_err(|e| bad(format!("header: {e}")))?;
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|e| InputError::io(file, &e))?;
    let size = header.frame_bytes();
    if bytes.len() % size != 0 {
        let whole = bytes.len() / size;
        return Err(bad(format!("ends within frame {whole}: {} bytes of {size}", bytes.len() % size)));
    }
    let frames = bytes.chunks_exact(size).map(|b| decode(&header, b)).collect();
    Ok((header, frames))
}

fn decode(header: &Header, bytes: &[u8]) -> Frame {
    let (time, rest) = bytes.split_at(8);
    let mut floats = rest.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let mut next = || floats.next().unwrap_or_default();
    let mut frame = Frame { time: time.try_into().map_or(0.0, f64::from_le_bytes), ..Frame::default() };
    for masses in &header.masses {
        frame.sheets.push((0..*masses).map(|_| Vec3::new(next(), next(), next())).collect());
    }
    for _ in 0..header.bodies {
        let position = Vec3::new(next(), next(), next());
        frame.bodies.push((position, Quat::from_xyzw(next(), next(), next(), next())));
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn what_is_recorded_is_read_and_a_cut_file_is_refused() {
        let scene = Scene::parse(
            r#"(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [(placement: (position: (0, 0.1, 0)))])"#,
        )
        .expect("valid");
        let mut world = World::new(&scene).expect("valid");
        let file = std::env::temp_dir().join(format!("sheetwork-recording-{}.swr", std::process::id()));
        let mut recorder = Recorder::create(&file, &world, 60.0).expect("writable");
        for _ in 0..3 {
            recorder.frame(&world).expect("writable");
            world.advance(1.0 / 60.0);
        }
        assert_eq!(recorder.finish().expect("writable"), 3);
        let (header, frames) = read(&file).expect("a recording");
        assert_eq!((frames.len(), header.masses.as_slice(), header.bodies), (3, &[221][..], 2));
        assert!((frames[2].time - 2.0 / 60.0).abs() < 1e-12);
        assert!(frames[2].sheets[0][0].y < frames[0].sheets[0][0].y);
        let bytes = std::fs::read(&file).expect("readable");
        std::fs::write(&file, &bytes[..bytes.len() - 5]).expect("writable");
        assert!(read(&file).expect_err("cut off").problem.contains("frame 2"));
        std::fs::write(&file, b"something else\n").expect("writable");
        assert!(read(&file).expect_err("not a recording").problem.contains("not a recording"));
        std::fs::remove_file(&file).expect("removable");
    }
}
