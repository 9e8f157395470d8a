//! Files of a first line, a line of JSON, and parts, each after its length in bytes (u32) and its
//! checksum (u32), little endian.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::InputError;

/// Checksum of the bytes of a part.
pub(super) type PartChecksum = fn(&[u8]) -> u32;

/// Writer of such a file.
pub(super) struct PartFile {
    file: PathBuf,
    out: BufWriter<File>,
    checksum: PartChecksum,
}

impl PartFile {
    /// Create the file with its first two lines.
    pub fn create(
        file: &Path,
        magic: &str,
        header: &impl Serialize,
        checksum: PartChecksum,
    ) -> Result<Self, InputError> {
        let json = serde_json::to_string(header).map_err(|e| InputError::new("", e.to_string()).in_file(file))?;
        let out = BufWriter::new(File::create(file).map_err(|e| InputError::io(file, &e))?);
        let mut writer = Self { file: file.to_path_buf(), out, checksum };
        writer.write(format!("{magic}\n{json}\n").as_bytes())?;
        Ok(writer)
    }

    /// Append a part; `too_long` is the error for 4 GiB or more.
    pub fn part(&mut self, bytes: &[u8], too_long: impl FnOnce() -> InputError) -> Result<(), InputError> {
        let length = u32::try_from(bytes.len()).map_err(|_| too_long())?;
        self.write(&length.to_le_bytes())?;
        self.write(&(self.checksum)(bytes).to_le_bytes())?;
        self.write(bytes)
    }

    /// Finish the file.
    pub fn finish(mut self) -> Result<(), InputError> {
        self.out.flush().map_err(|e| InputError::io(&self.file, &e))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        self.out.write_all(bytes).map_err(|e| InputError::io(&self.file, &e))
    }
}

/// Read the parts of a file from the bytes after its first two lines: `read` makes a value of each
/// and its number, and `word` names a part in messages.
pub(super) fn read_parts<T>(
    mut rest: &[u8],
    word: &str,
    checksum: PartChecksum,
    mut read: impl FnMut(usize, &[u8]) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let mut parts = Vec::new();
    while !rest.is_empty() {
        let at = parts.len();
        let Some((&[a, b, c, d, e, f, g, h], after)) = rest.split_first_chunk() else {
            return Err(format!("ends within {word} {at}: {} bytes of its first 8", rest.len()));
        };
        let (length, sum) = (u32::from_le_bytes([a, b, c, d]) as usize, u32::from_le_bytes([e, f, g, h]));
        let Some((body, next)) = after.split_at_checked(length) else {
            return Err(format!("ends within {word} {at}: {} bytes of {length}", after.len()));
        };
        if checksum(body) != sum {
            return Err(format!("{word} {at} is damaged: its checksum does not fit"));
        }
        parts.push(read(at, body)?);
        rest = next;
    }
    Ok(parts)
}
