//! What goes wrong with input, said so that its author can mend it.
//!
//! Every reader and every setter of the crate refuses bad input with an [`InputError`]: which file and line, which
//! field, what value, and what would have been accepted, with its unit. Nothing is changed by a refused input.

use std::fmt;
use std::path::{Path, PathBuf};

/// Input that was refused, and why.
///
/// Displays as `file:line: field: problem`; parts that do not apply (a value set by program has no file) are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputError {
    /// File the input came from, if it came from one.
    pub file: Option<PathBuf>,
    /// Line in that file, counted from 1.
    pub line: Option<usize>,
    /// Dotted path of the field, for example `sheets.0.material.young`; empty when no field is to blame.
    pub field: String,
    /// What is wrong: the value found and what is accepted, with unit and range.
    pub problem: String,
}

impl InputError {
    /// An error about `field` (may be empty) without a place in a file yet.
    pub fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { file: None, line: None, field: field.into(), problem: problem.into() }
    }

    /// The same error, placed in `file`.
    pub fn in_file(mut self, file: &Path) -> Self {
        self.file = Some(file.to_path_buf());
        self
    }

    /// The same error, placed at `line` (from 1).
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// The error of a file that cannot be read or written.
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

/// The value is finite and inside `min..=max`, or an error that names the field, value, unit and range.
///
/// # Errors
/// When `value` is not finite or outside the range.
pub fn check_range(field: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<(), InputError> {
    if value.is_finite() && value >= min && value <= max {
        return Ok(());
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let (value, min, max) = (short(value), short(min), short(max));
    Err(InputError::new(field, format!("{value}{unit} is outside {min} to {max}{unit}")))
}

/// A number as people write it: with an exponent where the plain digits would be mostly zeros.
fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && size.is_finite() && !(1e-3..1e6).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
