//! Table of parameters: every number of a scene with its path, unit and range, and every parameter
//! that can change while a world runs.
//!
//! Scene files, command-line overrides, [`World::set`](crate::World::set), the live link, the
//! inspector and the editor read this table. The accessors of the parameters of a running world are
//! in `world/parameters.rs`; defaults are read from the specifications by path.

mod table;

pub use crate::units::parameters::table::ParameterId;

use crate::error::{InputError, check_range};
use crate::units::Quantity;
use crate::units::parameters::table::TABLE;

/// Kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterKind {
    /// A number.
    Number,
    /// A number, or `none`.
    Optional,
    /// Two numbers with one unit.
    Pair,
    /// Three numbers with one unit.
    Vector,
    /// Three numbers with one unit, or `none`.
    OptionalVector,
    /// `true` or `false`.
    Boolean,
    /// One of several names.
    Name,
}

impl ParameterKind {
    /// Name of the kind in listings: "number", "vector", "boolean" or "name".
    pub fn name(self) -> &'static str {
        match self {
            Self::Number | Self::Optional => "number",
            Self::Pair | Self::Vector | Self::OptionalVector => "vector",
            Self::Boolean => "boolean",
            Self::Name => "name",
        }
    }
}

/// Time at which a parameter can be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterScope {
    /// In a scene only.
    Scene,
    /// In a scene, and in a running world, which lists it among its parameters.
    Live,
    /// In a running world, which does not list it: its value is state.
    State,
}

/// Source of a parameter's default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DefaultSource {
    /// Field of a scene in which every other field has its default.
    Field,
    /// Another field of that scene.
    SameAs(&'static str),
    /// This value.
    Text(&'static str),
    /// The field has no default.
    Required,
}

/// Usual values of a number, as the range of a slider. Other values within the range of the
/// parameter are valid too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UsualRange {
    /// Least usual value.
    pub min: f64,
    /// Largest usual value.
    pub max: f64,
    /// Whether a slider is logarithmic.
    pub logarithmic: bool,
}

/// Row of the table of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParameterRow {
    /// Identifier.
    pub id: ParameterId,
    /// Path: `*` stands for a name or a number, `**` at the start for any path.
    pub path: &'static str,
    /// Unit of the number, as in messages; empty for a name or a dimensionless number.
    pub unit: &'static str,
    /// Smallest and largest value of a number, or of each component.
    pub range: Option<(f64, f64)>,
    /// Kind of the value.
    pub kind: ParameterKind,
    /// Time at which it can be set.
    pub scope: ParameterScope,
    /// Usual values.
    pub usual: Option<UsualRange>,
    pub(crate) default: DefaultSource,
}

impl ParameterRow {
    /// All rows, in the order of [`ParameterId`].
    pub fn all() -> &'static [Self] {
        TABLE
    }

    /// Physical quantity of the number; `None` for a unit that is not converted.
    pub fn quantity(&self) -> Option<Quantity> {
        Quantity::from_unit(self.unit)
    }

    /// Path of the parameter of the object called `name`.
    pub(crate) fn path_of(&self, name: &str) -> String {
        self.path.replacen('*', name, 1)
    }

    /// Whether `path` is a path of this row.
    fn has_path(&self, path: &str) -> bool {
        let (mut wanted, mut given) = (self.path.rsplit('.'), path.rsplit('.'));
        loop {
            match (wanted.next(), given.next()) {
                (Some("**"), _) | (None, None) => return true,
                (Some(pattern), Some(part)) if pattern == "*" || pattern == part => {}
                _ => return false,
            }
        }
    }
}

impl ParameterId {
    /// Row of the parameter.
    pub fn row(self) -> &'static ParameterRow {
        &TABLE[self as usize]
    }

    /// Smallest and largest value; unbounded for a value that is no number.
    pub(crate) fn range(self) -> (f64, f64) {
        self.row().range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Parameter at `path`; a component of a vector or pair has the parameter of the whole.
    pub fn from_path(path: &str) -> Option<Self> {
        let whole = || path.rsplit_once('.').filter(|(_, part)| part.parse::<usize>().is_ok());
        Self::from_whole_path(path).or_else(|| Self::from_whole_path(whole()?.0))
    }

    /// Parameter at `path`; `None` for a component of a vector or pair.
    pub(crate) fn from_whole_path(path: &str) -> Option<Self> {
        TABLE.iter().find(|row| row.has_path(path)).map(|row| row.id)
    }

    /// Check that `value` is finite and within the range of the parameter. The error names `field`,
    /// value, unit and range.
    ///
    /// # Errors
    /// When it is not.
    pub fn check(self, field: &str, value: f64) -> Result<(), InputError> {
        let (min, max) = self.range();
        check_range(field, value, min, max, self.row().unit)
    }

    /// Check every component of a vector or pair; the error names `field` and the component.
    ///
    /// # Errors
    /// When one is not finite or is out of range.
    pub(crate) fn check_each(self, field: &str, values: impl IntoIterator<Item = f64>) -> Result<(), InputError> {
        values.into_iter().enumerate().try_for_each(|(axis, value)| self.check(&format!("{field}.{axis}"), value))
    }

    /// Check a value that may be absent.
    ///
    /// # Errors
    /// When it is present and not finite or out of range.
    pub(crate) fn check_option(self, field: &str, value: Option<f64>) -> Result<(), InputError> {
        value.map_or(Ok(()), |value| self.check(field, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_in_the_order_of_the_identifiers_and_their_paths_lead_back_to_them() {
        for (index, row) in TABLE.iter().enumerate() {
            assert_eq!(row.id as usize, index, "{row:?}");
            let path = row.path.replace("**", "bodies.0").replace('*', "3");
            assert_eq!(ParameterId::from_path(&path), Some(row.id), "{path}");
            assert!(row.range.is_none_or(|(min, max)| min < max), "{row:?}");
            let within = |usual: UsualRange| row.range.is_some_and(|(min, max)| min <= usual.min && usual.max <= max);
            assert!(row.usual.is_none_or(within), "{row:?}");
        }
        assert_eq!(ParameterId::from_path("gravity.1"), Some(ParameterId::Gravity));
        assert_eq!(ParameterId::from_path("sheets.strip.pins.0.path.2.offset.1"), Some(ParameterId::PathOffset));
        assert_eq!(ParameterId::from_path("sheets.strip.nothing"), None);
    }

    #[test]
    fn values_out_of_range_are_rejected_with_unit_and_range() {
        for row in TABLE {
            let Some((min, max)) = row.range else { continue };
            for good in [min, max, 0.5 * (min + max)] {
                row.id.check(row.path, good).unwrap_or_else(|e| panic!("{e}"));
            }
            for bad in [f64::NAN, f64::INFINITY, min - 1e-6 - 0.1 * min.abs(), max + 1e-6 + 0.1 * max.abs()] {
                let error = row.id.check(row.path, bad).expect_err(row.path);
                assert_eq!(error.field, row.path);
                assert!(error.problem.contains("is outside") && error.problem.ends_with(row.unit), "{error}");
            }
        }
    }
}
