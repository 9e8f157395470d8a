//! Table of the forces of a run, as CSV: a row per frame and force.

use std::fs::File;
use std::path::{Path, PathBuf};

use sheetwork::{InputError, World};

/// Columns of the table.
const HEADER: [&str; 11] = [
    "time_s",
    "sheet",
    "kind",
    "partner",
    "force_x_n",
    "force_y_n",
    "force_z_n",
    "moment_x_n_m",
    "moment_y_n_m",
    "moment_z_n_m",
    "magnitude_n",
];

/// Writer of the table.
pub struct ForceTable {
    file: PathBuf,
    writer: csv::Writer<File>,
}

impl ForceTable {
    /// Create the file `file` with the header.
    ///
    /// # Errors
    /// Failure to write.
    pub fn create(file: &Path) -> Result<Self, InputError> {
        let writer = csv::Writer::from_path(file).map_err(|e| InputError::new("", e.to_string()).in_file(file))?;
        let mut table = Self { file: file.to_owned(), writer };
        table.row(HEADER)?;
        Ok(table)
    }

    /// Write the mean forces of the last step of `world`.
    ///
    /// # Errors
    /// Failure to write.
    pub fn frame(&mut self, world: &World) -> Result<(), InputError> {
        for force in world.force_reports() {
            let kind = serde_json::to_value(force.kind).ok().and_then(|v| v.as_str().map(str::to_owned));
            let numbers = force.force_n.iter().chain(&force.moment_n_m).chain([&force.magnitude_n]);
            let names = [world.time().to_string(), force.sheet.clone(), kind.unwrap_or_default()];
            let partner = force.partner.clone().unwrap_or_default();
            self.row(names.into_iter().chain([partner]).chain(numbers.map(f64::to_string)))?;
        }
        Ok(())
    }

    /// End the table.
    ///
    /// # Errors
    /// Failure to write.
    pub fn finish(mut self) -> Result<(), InputError> {
        self.writer.flush().map_err(|e| InputError::io(&self.file, &e))
    }

    fn row<T: AsRef<[u8]>>(&mut self, cells: impl IntoIterator<Item = T>) -> Result<(), InputError> {
        let failed = |e: csv::Error| InputError::new("", e.to_string()).in_file(&self.file);
        self.writer.write_record(cells).map_err(failed)
    }
}
