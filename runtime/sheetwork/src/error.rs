//! Errors of input, with the information needed to correct it.
//!
//! Every reader and every setter of the crate rejects invalid input with an [`InputError`]: file,
//! line, field, value, and accepted values with their unit. Rejected input changes nothing.

use std::fmt;
use std::path::{Path, PathBuf};

/// Rejected input and the reason.
///
/// Displays as `file:line: field: problem`; parts that do not apply (a value set by a program has
/// no file) are omitted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputError {
    /// File of the input; `None` for a value set by a program.
    pub file: Option<PathBuf>,
    /// Line in that file, counted from 1.
    pub line: Option<usize>,
    /// Dotted path of the field, for example `sheets.0.material.young`; empty for an error of no
    /// field.
    pub field: String,
    /// Reason: the value found and the accepted values, with unit and range.
    pub problem: String,
}

impl InputError {
    /// Error of `field` (may be empty), without file and line.
    pub fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { file: None, line: None, field: field.into(), problem: problem.into() }
    }

    /// Set the file of the error.
    pub fn in_file(mut self, file: &Path) -> Self {
        self.file = Some(file.to_path_buf());
        self
    }

    /// Set the line of the error, counted from 1.
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// Error of a file that cannot be read or written.
    pub fn io(file: &Path, error: &std::io::Error) -> Self {
        Self::new("", format!("cannot be opened: {error}")).in_file(file)
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        } else if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        if !self.field.is_empty() {
            write!(f, "{}: ", self.field)?;
        }
        f.write_str(&self.problem)
    }
}

impl std::error::Error for InputError {}

/// Check that a value is finite and within `min..=max`. The error names field, value, unit and
/// range.
///
/// # Errors
/// If `value` is not finite or is outside the range.
pub fn check_range(field: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<(), InputError> {
    if value.is_finite() && value >= min && value <= max {
        return Ok(());
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let (value, min, max) = (format_short(value), format_short(min), format_short(max));
    Err(InputError::new(field, format!("{value}{unit} is outside {min} to {max}{unit}")))
}

/// Text of a number, with an exponent if plain digits would be mostly zeros.
fn format_short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && size.is_finite() && !(1e-3..1e6).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
