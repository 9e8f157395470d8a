//! Recordings: a run frame by frame, for playback without simulation.
//!
//! File, little endian: the line `sheetwork recording 2`, a line of JSON ([`RecordingHeader`]),
//! then frames, each after its length in bytes (u32) and its checksum (u32): positions,
//! temperatures and open cells (`recording/bytes.rs`). Values are rounded; a
//! [`Snapshot`](crate::world::Snapshot) serves to continue a run. Files of version 1, with
//! positions alone, are read too.

pub(crate) mod bytes;
pub(crate) mod frame;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

pub use crate::sheet::temperature::RecordedTemperature;
pub use crate::world::recording::bytes::checksum;
pub use crate::world::recording::frame::{RecordedFrame, RecordingHeader};

use crate::World;
use crate::error::InputError;
use crate::world::part_file::{PartFile, read_parts};

/// First lines of the supported versions; the last is the version written.
const MAGIC: [&str; 2] = ["sheetwork recording 1", "sheetwork recording 2"];

/// Writer of a recording.
pub struct RecordingWriter {
    out: PartFile,
    frames: u64,
    /// Buffer of a frame.
    bytes: Vec<u8>,
    /// Open cells of the frame before.
    open: Vec<Arc<[bool]>>,
}

impl RecordingWriter {
    /// Create the file and write the header for `world`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(file: &Path, world: &World, frames_per_second: f64) -> Result<Self, InputError> {
        let header = RecordingHeader {
            scene: world.scene().name.clone(),
            source: world.scene().to_text()?,
            frames_per_second,
            masses: RecordedFrame::of(world).sheets.iter().map(Vec::len).collect(),
            bodies: world.rigid().map_or(0, |r| r.bodies().len()),
        };
        Self::begin(file, &header)
    }

    /// Create the file for frames from another source, as described by `header`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn begin(file: &Path, header: &RecordingHeader) -> Result<Self, InputError> {
        let out = PartFile::create(file, MAGIC[1], header, checksum)?;
        Ok(Self { out, frames: 0, bytes: Vec::new(), open: Vec::new() })
    }

    /// Append the present state of the world, which must have the sheets and bodies of the header.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn frame(&mut self, world: &World) -> Result<(), InputError> {
        self.append(&RecordedFrame::of(world))
    }

    /// Append a frame, which must have the nodes and bodies of the header.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn append(&mut self, frame: &RecordedFrame) -> Result<(), InputError> {
        self.bytes.clear();
        bytes::encode(frame, &mut self.open, &mut self.bytes);
        self.out.part(&self.bytes, || {
            InputError::new("frame", format!("has {} bytes; at most {} are allowed", self.bytes.len(), u32::MAX))
        })?;
        self.frames += 1;
        Ok(())
    }

    /// Finish the file and return the number of frames.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<u64, InputError> {
        self.out.finish()?;
        Ok(self.frames)
    }
}

/// Read a whole recording.
///
/// # Errors
/// When the file cannot be read, is not a recording, ends within a frame or is damaged.
pub fn read(file: &Path) -> Result<(RecordingHeader, Vec<RecordedFrame>), InputError> {
    read_from(&mut BufReader::new(File::open(file).map_err(|e| InputError::io(file, &e))?), file)
}

/// Read a recording from the bytes of a file.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(mut bytes: &[u8]) -> Result<(RecordingHeader, Vec<RecordedFrame>), InputError> {
    read_from(&mut bytes, Path::new("recording"))
}

fn read_from(input: &mut dyn BufRead, file: &Path) -> Result<(RecordingHeader, Vec<RecordedFrame>), InputError> {
    let bad = |problem: String| InputError::new("", problem).in_file(file);
    let line = |input: &mut dyn BufRead| -> Result<String, InputError> {
        let mut text = String::new();
        // The limit bounds the memory for a file without line ends.
        input.take(64 << 20).read_line(&mut text).map_err(|e| match e.kind() {
            std::io::ErrorKind::InvalidData => bad("is not a recording: its first lines are no text".into()),
            _ => InputError::io(file, &e),
        })?;
        Ok(text.trim_end_matches('\n').to_owned())
    };
    let magic = line(input)?;
    let Some(version) = MAGIC.iter().position(|m| *m == magic) else {
        let about = match magic.strip_prefix("sheetwork recording ") {
            Some(other) => format!("is a recording of version {other}; this program reads versions 1 and 2"),
            None => format!("does not begin with \"{}\": not a recording", MAGIC[1]),
        };
        return Err(bad(about));
    };
    let header: RecordingHeader = serde_json::from_str(&line(input)?).map_err(|e| bad(format!("header: {e}")))?;
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|e| InputError::io(file, &e))?;
    let frames = if version == 0 { first_version(&header, &bytes) } else { second_version(&header, &bytes) };
    Ok((header, frames.map_err(bad)?))
}

/// Frames of a file of version 1, which have equal length.
fn first_version(header: &RecordingHeader, bytes: &[u8]) -> Result<Vec<RecordedFrame>, String> {
    let size = bytes::first_version_bytes(header);
    let whole = bytes.len() / size;
    if !bytes.len().is_multiple_of(size) {
        return Err(format!("ends within frame {whole}: {} bytes of {size}", bytes.len() % size));
    }
    let read = |(i, b)| bytes::decode_first_version(header, b).ok_or_else(|| format!("frame {i} cannot be read"));
    bytes.chunks_exact(size).enumerate().map(read).collect()
}

/// Frames of a file of version 2.
fn second_version(header: &RecordingHeader, rest: &[u8]) -> Result<Vec<RecordedFrame>, String> {
    let mut open = Vec::new();
    read_parts(rest, "frame", checksum, |at, body| {
        let frame = bytes::decode(header, body, &mut open);
        frame.ok_or_else(|| format!("frame {at} is not of the sheets and bodies that the header has"))
    })
}
