//! Statements of sections 6.4 and 6.5 of the thesis about its answers, each checked against a
//! table of answers: whether the order is as stated, and whether it is significant.
//!
//! A statement says that every sheet of one list is above every sheet of another, in the mean or
//! the median of the scores, or below it in their deviation. Its p is the largest one-sided p of
//! Wilcoxon's test among its pairs of sheets (all must differ), corrected by Holm's method for the
//! number of statements. Medians are tested by the same test, deviations are not tested.

use serde::Serialize;

use crate::study::answers::Answers;
use crate::study::rank_tests::{holm, wilcoxon};
use crate::study::reading::{ALL_TESTS, SIGNIFICANCE, question_index};
use crate::study::statistics::{Summary, summary};

/// Statistic that a statement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Mean: more is better.
    Mean,
    /// Median: more is better.
    Median,
    /// Standard deviation: less is better.
    Deviation,
}

/// A statement of the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Statement {
    section: &'static str,
    says: &'static str,
    test: &'static str,
    /// Key of a question; none for the sum of the answers.
    question: Option<&'static str>,
    measure: Measure,
    better: &'static [&'static str],
    worse: &'static [&'static str],
}

const fn stated(
    section: &'static str,
    says: &'static str,
    (test, question): (&'static str, Option<&'static str>),
    measure: Measure,
    better: &'static [&'static str],
    worse: &'static [&'static str],
) -> Statement {
    Statement { section, says, test, question, measure, better, worse }
}

/// Statements of sections 6.4 and 6.5 that the answers can decide.
const STATEMENTS: [Statement; 17] = {
    use Measure::{Deviation, Mean, Median};
    [
        stated("6.4", "cube: TRiMM is above Provot 2D", ("cube", None), Mean, &["trimm"], &["provot2d"]),
        stated(
            "6.4",
            "wedge1: Provot 2D is the best",
            ("wedge1", None),
            Mean,
            &["provot2d"],
            &["slamm", "trimm", "provot3d"],
        ),
        stated("6.4", "wedge1: SLaMM is second", ("wedge1", None), Mean, &["slamm"], &["trimm", "provot3d"]),
        stated(
            "6.4",
            "wedge1: SLaMM leads in sliding",
            ("wedge1", Some("A5")),
            Mean,
            &["slamm"],
            &["trimm", "provot3d", "provot2d"],
        ),
        stated(
            "6.4",
            "wedge2: Provot 3D is above all others",
            ("wedge2", None),
            Mean,
            &["provot3d"],
            &["slamm", "trimm", "provot2d"],
        ),
        stated(
            "6.4",
            "wedge2, medians: Provot 3D is above all others",
            ("wedge2", None),
            Median,
            &["provot3d"],
            &["slamm", "trimm", "provot2d"],
        ),
        stated(
            "6.4",
            "cube, medians: only the Provot sheets are faster than TRiMM (B1)",
            ("cube", Some("B1")),
            Median,
            &["provot2d", "provot3d"],
            &["trimm"],
        ),
        stated(
            "6.4",
            "wedge2, medians: TRiMM and SLaMM are above Provot 2D",
            ("wedge2", None),
            Median,
            &["trimm", "slamm"],
            &["provot2d"],
        ),
        stated(
            "6.4",
            "wedge1, medians: TRiMM is behind all others",
            ("wedge1", None),
            Median,
            &["slamm", "provot3d", "provot2d"],
            &["trimm"],
        ),
        stated(
            "6.4",
            "wedge2: answers on Provot 3D diverge least",
            ("wedge2", None),
            Deviation,
            &["provot3d"],
            &["slamm", "trimm", "provot2d"],
        ),
        stated(
            "6.4",
            "wedge2: answers on Provot 2D diverge less than on TRiMM and SLaMM",
            ("wedge2", None),
            Deviation,
            &["provot2d"],
            &["trimm", "slamm"],
        ),
        stated(
            "6.5",
            "all tests: Provot 3D is above all others",
            (ALL_TESTS, None),
            Mean,
            &["provot3d"],
            &["slamm", "trimm", "provot2d"],
        ),
        stated("6.5", "all tests: TRiMM is above Provot 2D", (ALL_TESTS, None), Mean, &["trimm"], &["provot2d"]),
        stated("6.5", "all tests: TRiMM is above SLaMM", (ALL_TESTS, None), Mean, &["trimm"], &["slamm"]),
        stated("6.5", "wedge2: TRiMM is above Provot 2D", ("wedge2", None), Mean, &["trimm"], &["provot2d"]),
        stated(
            "6.5",
            "all tests: answers on SLaMM and TRiMM diverge more than on the Provot sheets",
            (ALL_TESTS, None),
            Deviation,
            &["provot3d", "provot2d"],
            &["slamm", "trimm"],
        ),
        stated(
            "6.5",
            "all tests: answers on Provot 3D diverge less than on Provot 2D",
            (ALL_TESTS, None),
            Deviation,
            &["provot3d"],
            &["provot2d"],
        ),
    ]
};

/// Verdict on a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The order is as stated and significant.
    Supported,
    /// The order is as stated; chance is not excluded.
    OrderOnly,
    /// The order is another.
    Contradicted,
}

/// A statement and what the answers say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Section of the thesis.
    pub section: &'static str,
    /// Statement, in short.
    pub says: &'static str,
    /// Statistic.
    pub measure: Measure,
    /// The statistic of each sheet, those that should be better first.
    pub values: Vec<(&'static str, f64)>,
    /// Largest one-sided p of its pairs; none for a deviation.
    pub p: Option<f64>,
    /// p corrected for the number of statements.
    pub p_holm: Option<f64>,
    /// Verdict.
    pub verdict: Verdict,
}

impl Answers {
    /// Statements of the thesis, checked; none that needs a sheet or test which has no answers.
    pub fn claims(&self) -> Vec<Claim> {
        let mut all: Vec<Claim> = STATEMENTS.iter().filter_map(|s| self.claim(s)).collect();
        let tested: Vec<usize> = (0..all.len()).filter(|i| all[*i].p.is_some()).collect();
        let corrected = holm(&tested.iter().filter_map(|i| all[*i].p).collect::<Vec<_>>());
        for (i, p) in tested.into_iter().zip(corrected) {
            all[i].p_holm = Some(p);
            if all[i].verdict != Verdict::Contradicted && p < SIGNIFICANCE {
                all[i].verdict = Verdict::Supported;
            }
        }
        all
    }

    fn claim(&self, s: &Statement) -> Option<Claim> {
        let question = match s.question {
            Some(key) => Some(question_index(key)?),
            None => None,
        };
        let value = |sheet: &&'static str| {
            let scores: Vec<f64> = self.scores(s.test, sheet, question).into_iter().map(|s| s.1).collect();
            Some((*sheet, s.measure.of(&summary(&scores)?)))
        };
        let values = s.better.iter().chain(s.worse).map(value).collect::<Option<Vec<_>>>()?;
        let (better, worse) = values.split_at(s.better.len());
        let holds = better.iter().all(|b| worse.iter().all(|w| s.measure.is_better(b.1, w.1)));
        let pairs = s.better.iter().flat_map(|b| s.worse.iter().map(move |w| [*b, *w]));
        let p = |pair: [&str; 2]| wilcoxon(&self.score_pairs(s.test, pair, question)).map_or(1.0, |w| w.p_greater);
        let p = if s.measure == Measure::Deviation { None } else { pairs.map(p).reduce(f64::max) };
        let verdict = if holds { Verdict::OrderOnly } else { Verdict::Contradicted };
        Some(Claim { section: s.section, says: s.says, measure: s.measure, values, p, p_holm: p, verdict })
    }
}

impl Measure {
    fn of(self, summary: &Summary) -> f64 {
        match self {
            Self::Mean => summary.mean,
            Self::Median => summary.median,
            Self::Deviation => summary.deviation,
        }
    }

    fn is_better(self, a: f64, b: f64) -> bool {
        if self == Self::Deviation { a < b } else { a > b }
    }
}
