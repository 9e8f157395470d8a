//! Specification of the recovery policy for an unstable sheet.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::{InputError, check_range, string_conversions};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};

/// Default maximum number of substeps, and its range.
const DEFAULT_SUBSTEPS: u32 = 64;
const SUBSTEPS_RANGE: (f64, f64) = (2.0, 4096.0);
/// Default strain limit (Provot's tenth), and its range.
const DEFAULT_STRAIN_LIMIT: f64 = 0.1;
const STRAIN_LIMIT_RANGE: (f64, f64) = (1e-4, 1.0);

/// Recovery policy for a sheet with a detected energy error. Text in files, parameters and on the
/// command line: `"stop"`, `"reduce-step"` or `"reduce-step 64"`, `"implicit"`, `"freeze"`,
/// `"limit"` or `"limit 0.1"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum WhenUnstable {
    /// Stop the sheet when its size or speed diverges. The energy is not monitored, at no cost.
    #[default]
    Stop,
    /// Repeat the step of the integrator in 2, 4, 8... substeps, at most `parts`; then freeze the
    /// sheet.
    ReduceStep {
        /// Maximum number of substeps, 2 to 4096.
        parts: u32,
    },
    /// Continue with the implicit integrator `tr-bdf2`.
    Implicit,
    /// Freeze the sheet until one of its parameters changes.
    Freeze,
    /// Limit the strain of springs, or between neighbours of a shell (the thesis's spring
    /// retention), and the energy to its value before.
    Limit {
        /// Strain limit, 0.0001 to 1.
        strain: f64,
    },
}

/// Words of the policies, in the order of their index.
const WORDS: [&str; 5] = ["stop", "reduce-step", "implicit", "freeze", "limit"];

impl WhenUnstable {
    /// Serialise the policy for a snapshot.
    pub(crate) fn serialise(self, to: &mut StateWriter) {
        to.byte(self.index() as u8);
        match self {
            Self::ReduceStep { parts } => to.count(parts.into()),
            Self::Limit { strain } => to.number(strain),
            Self::Stop | Self::Implicit | Self::Freeze => {}
        }
    }

    /// Deserialise the policy.
    pub(crate) fn deserialise(from: &mut StateReader) -> ReadResult<Self> {
        let policy = match from.byte()? {
            0 => Self::Stop,
            1 => Self::ReduceStep { parts: from.count_u32()? },
            2 => Self::Implicit,
            3 => Self::Freeze,
            4 => Self::Limit { strain: from.number()? },
            _ => return Err(CorruptState),
        };
        policy.check().map_err(|_| CorruptState)?;
        Ok(policy)
    }

    /// Word of the policy, without its number.
    pub fn word(self) -> &'static str {
        WORDS[self.index()]
    }

    fn index(self) -> usize {
        match self {
            Self::Stop => 0,
            Self::ReduceStep { .. } => 1,
            Self::Implicit => 2,
            Self::Freeze => 3,
            Self::Limit { .. } => 4,
        }
    }

    /// Check the number of the policy.
    ///
    /// # Errors
    /// When it is out of range.
    pub fn check(self) -> Result<(), InputError> {
        match self {
            Self::ReduceStep { parts } => {
                check_range("when_unstable", parts.into(), SUBSTEPS_RANGE.0, SUBSTEPS_RANGE.1, "parts of a step")
            }
            Self::Limit { strain } => {
                check_range("when_unstable", strain, STRAIN_LIMIT_RANGE.0, STRAIN_LIMIT_RANGE.1, "of a spring's length")
            }
            Self::Stop | Self::Implicit | Self::Freeze => Ok(()),
        }
    }
}

impl Display for WhenUnstable {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ReduceStep { parts } => write!(f, "{} {parts}", self.word()),
            Self::Limit { strain } => write!(f, "{} {strain}", self.word()),
            Self::Stop | Self::Implicit | Self::Freeze => f.write_str(self.word()),
        }
    }
}

impl FromStr for WhenUnstable {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let refused = |problem: String| InputError::new("when_unstable", problem);
        let mut words = text.split_whitespace();
        let (word, number, rest) = (words.next().unwrap_or_default(), words.next(), words.next());
        let unknown = || refused(format!("\"{text}\" is none of {}", WORDS.join(", ")));
        let policy = match (word, number) {
            _ if rest.is_some() => return Err(unknown()),
            ("stop", None) => Self::Stop,
            ("implicit", None) => Self::Implicit,
            ("freeze", None) => Self::Freeze,
            ("stop" | "implicit" | "freeze", Some(_)) => return Err(refused(format!("{word} takes no number"))),
            ("reduce-step", None) => Self::ReduceStep { parts: DEFAULT_SUBSTEPS },
            ("reduce-step", Some(n)) => {
                let whole = |_| refused(format!("\"{n}\" parts are no whole number from 2 to 4096"));
                Self::ReduceStep { parts: n.parse().map_err(whole)? }
            }
            ("limit", None) => Self::Limit { strain: DEFAULT_STRAIN_LIMIT },
            ("limit", Some(n)) => {
                let number = |_| refused(format!("\"{n}\" is not a number"));
                Self::Limit { strain: n.parse().map_err(number)? }
            }
            _ => return Err(unknown()),
        };
        policy.check()?;
        Ok(policy)
    }
}

string_conversions!(WhenUnstable);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn a_policy_is_its_text() {
        let text = ["stop", "reduce-step 8", "implicit", "freeze", "limit 0.05"];
        for text in text {
            assert_eq!(text.parse::<WhenUnstable>().expect("valid").to_string(), text);
        }
        assert_eq!("reduce-step".parse(), Ok(WhenUnstable::ReduceStep { parts: 64 }));
        assert_eq!("limit".parse(), Ok(WhenUnstable::Limit { strain: 0.1 }));
        let scene = Scene::parse(r#"(sheets: [(when_unstable: "limit 0.05")])"#).expect("valid");
        assert_eq!(scene.sheets[0].when_unstable, WhenUnstable::Limit { strain: 0.05 });
        assert_eq!(Scene::parse(&scene.to_text().expect("text")).expect("valid"), scene);
        let set = scene.with_override("sheets.0.when_unstable", "reduce-step 16").expect("valid");
        assert_eq!(set.sheets[0].when_unstable, WhenUnstable::ReduceStep { parts: 16 });
    }

    #[test]
    fn a_bad_policy_is_refused_by_name_and_range() {
        for (text, says) in [
            ("pray", "stop, reduce-step, implicit, freeze, limit"),
            ("stop 3", "takes no number"),
            ("reduce-step 1", "2 to 4096 parts of a step"),
            ("reduce-step 2.5", "no whole number"),
            ("limit 2", "of a spring's length"),
            ("limit NaN", "NaN"),
            ("limit 0.1 0.2", "none of"),
        ] {
            let error = text.parse::<WhenUnstable>().expect_err(text);
            assert!(error.problem.contains(says), "{text}: {error}");
        }
        let error = Scene::parse("(\n  sheets: [\n    (when_unstable: \"pray\"),\n  ],\n)").expect_err("bad");
        assert_eq!((error.line, error.field.as_str()), (Some(3), "sheets.0.when_unstable"));
    }
}
