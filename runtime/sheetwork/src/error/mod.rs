//! Errors of input, with the information needed to correct it.
//!
//! Every reader and every setter of the crate rejects invalid input with an [`InputError`]: file,
//! line, field, value, and accepted values with their unit. Rejected input changes nothing.

mod operation;

pub use crate::error::operation::{BuildError, ParameterError, SceneError, SnapshotError};

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

    /// The error of a value as one of the group at the path `outer`.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        self.field = if self.field.is_empty() { outer.to_owned() } else { format!("{outer}.{}", self.field) };
        self
    }

    /// The error of the object at the path `outer`, or of the file that `file` names for it.
    pub(crate) fn of_object(mut self, outer: &str, file: &str) -> Self {
        if self.file.is_none() {
            return self.within(outer);
        }
        self.problem = format!("{} (the file of {file})", self.problem);
        self
    }

    /// Set the line of the error, counted from 1.
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// Error of a name that is not among `known`, with the names most similar to it. `kind` is the
    /// kind of thing that is named.
    pub fn unknown_name(field: &str, kind: &str, name: &str, known: &[&str]) -> Self {
        let near = most_similar(known.iter().copied(), |other| similarity(name, other));
        let meant = did_you_mean(&near).map_or_else(|| "; there are".to_owned(), |m| format!("; {m} There are"));
        Self::new(field, format!("no {kind} is named \"{name}\"{meant} {}", known.join(", ")))
    }

    /// Error of a file that cannot be read or written.
    pub fn io(file: &Path, error: &std::io::Error) -> Self {
        Self::new("", format!("cannot be opened: {error}")).in_file(file)
    }
}

/// Return an [`InputError`] if a condition holds: `reject_if!(condition, field, problem...)`, where
/// `problem...` are the arguments of `format!`.
macro_rules! reject_if {
    ($condition:expr, $field:expr, $($problem:tt)+) => {
        if $condition {
            return Err(crate::error::InputError::new($field, format!($($problem)+)));
        }
    };
}

pub(crate) use reject_if;

/// Implement conversion of a type from and to `String` by `FromStr` and `Display`, for serde.
macro_rules! string_conversions {
    ($type:ty) => {
        impl TryFrom<String> for $type {
            type Error = crate::error::InputError;

            fn try_from(text: String) -> Result<Self, Self::Error> {
                text.parse()
            }
        }

        impl From<$type> for String {
            fn from(value: $type) -> Self {
                value.to_string()
            }
        }
    };
}

pub(crate) use string_conversions;

/// Implement the name of a kind that is the `name` of its row in a table: `name`, and conversion
/// from and to text. `$field` is the field of files, and the word for the kind in messages.
macro_rules! named_in_table {
    ($kind:ty, $table:expr, $field:literal) => {
        impl $kind {
            /// Name in files and on the command line.
            pub fn name(self) -> &'static str {
                self.info().name
            }
        }

        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl std::str::FromStr for $kind {
            type Err = crate::error::InputError;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                $table.iter().find(|row| row.name == name).map(|row| row.kind).ok_or_else(|| {
                    let names: Vec<&str> = $table.iter().map(|row| row.name).collect();
                    crate::error::InputError::unknown_name($field, $field, name, &names)
                })
            }
        }

        crate::error::string_conversions!($kind);
    };
}

pub(crate) use named_in_table;

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
    let number = format!("{} {unit}", format_short(value));
    Err(InputError::new(field, format!("{} is outside {}", number.trim_end(), range_text((min, max), unit))))
}

/// Text of a range of values in `unit`, which may be empty.
pub(crate) fn range_text((min, max): (f64, f64), unit: &str) -> String {
    format!("{} to {} {unit}", format_short(min), format_short(max)).trim_end().to_owned()
}

/// Maximum number of suggested names.
const MAX_SUGGESTIONS: usize = 3;
/// Similarity threshold (0 to 1) of a suggested name.
const SIMILARITY_THRESHOLD: f64 = 0.5;

/// Similarity of two names, 0 to 1, without regard to case: 1 less the Damerau-Levenshtein
/// distance over the length of the longer name. Names of very different length have 0.
pub(crate) fn similarity(a: &str, b: &str) -> f64 {
    let (a_length, b_length) = (a.chars().count(), b.chars().count());
    // The distance is at least the difference in length; its cost is the product of the lengths.
    if (a_length.min(b_length) as f64) < SIMILARITY_THRESHOLD * a_length.max(b_length) as f64 {
        return 0.0;
    }
    strsim::normalized_damerau_levenshtein(&a.to_lowercase(), &b.to_lowercase())
}

/// The `names` of the highest similarity (0 to 1), the best first.
pub(crate) fn most_similar<'a>(names: impl Iterator<Item = &'a str>, similarity: impl Fn(&str) -> f64) -> Vec<&'a str> {
    let scored = names.map(|name| (similarity(name), name)).filter(|s| s.0 >= SIMILARITY_THRESHOLD);
    let mut scored: Vec<(f64, &str)> = scored.collect();
    // The sort is stable: among equals the first in the list wins.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(MAX_SUGGESTIONS).map(|s| s.1).collect()
}

/// Question for the suggested names; `None` without any.
pub(crate) fn did_you_mean(names: &[&str]) -> Option<String> {
    match names {
        [] => None,
        [one] => Some(format!("did you mean {one}?")),
        [others @ .., last] => Some(format!("did you mean {} or {last}?", others.join(", "))),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_names_get_suggestions_where_a_name_is_similar() {
        let problem = |name| InputError::unknown_name("material", "material", name, &["hips", "pet", "card"]).problem;
        assert_eq!(problem("hisp"), "no material is named \"hisp\"; did you mean hips? There are hips, pet, card");
        assert_eq!(problem("PET"), "no material is named \"PET\"; did you mean pet? There are hips, pet, card");
        assert_eq!(problem("xyzzy"), "no material is named \"xyzzy\"; there are hips, pet, card");
        assert_eq!(did_you_mean(&["a", "b", "c"]).as_deref(), Some("did you mean a, b or c?"));
    }
}
