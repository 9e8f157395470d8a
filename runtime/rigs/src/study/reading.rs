//! Reading of a study: order of the sheets in each test and in all tests, its significance, and
//! differences between any two sheets, corrected for their number.
//!
//! A subject's score is the sum of the answers, as in the thesis. Friedman's test says whether the
//! sheets of a test differ at all, Wilcoxon's which two do; the p of all pairs of all single tests
//! are corrected together by Holm's method.

use serde::Serialize;

use crate::study::answers::Answers;
use crate::study::rank_tests::{Friedman, friedman, holm, wilcoxon};
use crate::study::statistics::{Summary, summary};
use crate::study::{QUESTIONS, SHEETS, TESTS, TestFindings};

/// Significance level, a convention.
pub const SIGNIFICANCE: f64 = 0.05;

/// Name of the three tests taken together.
pub const ALL_TESTS: &str = "all";

/// Order of the sheets in one test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestReading {
    /// Test, or [`ALL_TESTS`].
    pub test: String,
    /// Sheets, the best mean first.
    pub order: Vec<SheetScore>,
    /// Friedman's test; none where it is undefined.
    pub friedman: Option<Friedman>,
    /// Comparisons of two sheets, as in `order`.
    pub pairs: Vec<PairReading>,
}

/// Score of a sheet in one test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetScore {
    /// Sheet.
    pub sheet: String,
    /// Mean, deviation and median of the scores.
    #[serde(flatten)]
    pub summary: Summary,
    /// Mean rank, the best with the largest.
    pub mean_rank: Option<f64>,
}

/// Comparison of two sheets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairReading {
    /// Sheet with the better mean.
    pub better: String,
    /// The other sheet.
    pub worse: String,
    /// Wilcoxon's two-sided p.
    pub p: f64,
    /// p corrected by Holm's method: for all pairs of all single tests, or for those of all tests
    /// together.
    pub p_holm: f64,
}

/// Student's t tests of single questions, and those that survive the correction for their number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TTestCount {
    /// Number of tests.
    pub tests: usize,
    /// Number with p below 0.05.
    pub significant: usize,
    /// Number of these that chance alone leads to expect.
    pub expected: f64,
    /// Those with p below 0.05 by Holm's method: test, question, sheet.
    pub significant_holm: Vec<String>,
}

/// Count of the t tests of `tests`, sums of answers left out.
pub(crate) fn t_test_count(tests: &[TestFindings]) -> TTestCount {
    let mut all: Vec<(String, f64)> = Vec::new();
    for test in tests {
        for question in test.questions.iter().filter(|q| question_index(&q.question).is_some()) {
            for (sheet, paired) in question.sheets.iter().filter_map(|s| Some((&s.sheet, s.against?))) {
                all.push((format!("{} {} {sheet}", test.test, question.question), paired.p));
            }
        }
    }
    let corrected = holm(&all.iter().map(|t| t.1).collect::<Vec<_>>());
    let survives = all.iter().zip(&corrected).filter(|(_, p)| **p < SIGNIFICANCE);
    TTestCount {
        tests: all.len(),
        significant: all.iter().filter(|t| t.1 < SIGNIFICANCE).count(),
        expected: SIGNIFICANCE * all.len() as f64,
        significant_holm: survives.map(|((name, _), p)| format!("{name} (p {p:.4})")).collect(),
    }
}

impl Answers {
    /// Scores of the subjects in `test` ([`ALL_TESTS`] for the sum of the tests) for `sheet`, by
    /// subject; `question` is an index of [`QUESTIONS`], or none for the sum of the answers.
    pub(crate) fn scores(&self, test: &str, sheet: &str, question: Option<usize>) -> Vec<(&str, f64)> {
        let value = |subject: &str, test: &str| {
            let rating = self.ratings.iter().find(|r| r.subject == subject && r.test == test && r.sheet == sheet)?;
            match question {
                Some(q) => rating.answers.get(q).copied().flatten().map(f64::from),
                None => Some(rating.total()),
            }
        };
        let of = |subject: &str| match test {
            ALL_TESTS => TESTS.iter().map(|test| value(subject, test)).sum::<Option<f64>>(),
            test => value(subject, test),
        };
        self.subjects().into_iter().filter_map(|subject| Some((subject, of(subject)?))).collect()
    }

    /// Pairs of scores of subjects who have both.
    pub(crate) fn score_pairs(&self, test: &str, sheets: [&str; 2], question: Option<usize>) -> Vec<(f64, f64)> {
        let [first, second] = sheets.map(|sheet| self.scores(test, sheet, question));
        let of = |(subject, value): &(&str, f64)| Some((*value, second.iter().find(|s| s.0 == *subject)?.1));
        first.iter().filter_map(of).collect()
    }

    /// Order and significance, test by test and for all tests.
    pub fn readings(&self) -> Vec<TestReading> {
        let mut all: Vec<TestReading> = TESTS.iter().filter_map(|test| self.reading(test)).collect();
        let raw: Vec<f64> = all.iter().flat_map(|t| t.pairs.iter().map(|p| p.p)).collect();
        let corrected = holm(&raw);
        all.iter_mut().flat_map(|t| &mut t.pairs).zip(corrected).for_each(|(pair, p)| pair.p_holm = p);
        if all.len() == TESTS.len()
            && let Some(mut together) = self.reading(ALL_TESTS)
        {
            let corrected = holm(&together.pairs.iter().map(|p| p.p).collect::<Vec<_>>());
            together.pairs.iter_mut().zip(corrected).for_each(|(pair, p)| pair.p_holm = p);
            all.push(together);
        }
        all
    }

    fn reading(&self, test: &str) -> Option<TestReading> {
        let scored = |sheet: &&'static str| {
            let values: Vec<f64> = self.scores(test, sheet, None).into_iter().map(|s| s.1).collect();
            Some((*sheet, summary(&values)?))
        };
        let mut sheets: Vec<(&str, Summary)> = SHEETS.iter().filter_map(scored).collect();
        sheets.sort_by(|a, b| b.1.mean.total_cmp(&a.1.mean));
        if sheets.is_empty() {
            return None;
        }
        let columns: Vec<Vec<(&str, f64)>> = sheets.iter().map(|s| self.scores(test, s.0, None)).collect();
        let row = |subject: &str| -> Option<Vec<f64>> {
            columns.iter().map(|c| c.iter().find(|s| s.0 == subject).map(|s| s.1)).collect()
        };
        let rows: Vec<Vec<f64>> = self.subjects().into_iter().filter_map(row).collect();
        let found = friedman(&rows);
        let order = sheets.iter().enumerate().map(|(i, (sheet, summary))| SheetScore {
            sheet: (*sheet).to_owned(),
            summary: *summary,
            mean_rank: found.as_ref().and_then(|f| f.mean_ranks.get(i).copied()),
        });
        let order = order.collect();
        let mut pairs = Vec::new();
        for (i, (better, _)) in sheets.iter().enumerate() {
            for (worse, _) in &sheets[i + 1..] {
                let p = wilcoxon(&self.score_pairs(test, [better, worse], None)).map_or(1.0, |w| w.p);
                pairs.push(PairReading { better: (*better).to_owned(), worse: (*worse).to_owned(), p, p_holm: p });
            }
        }
        Some(TestReading { test: test.to_owned(), order, friedman: found, pairs })
    }
}

/// Index of a question by its key.
pub(crate) fn question_index(key: &str) -> Option<usize> {
    QUESTIONS.iter().position(|q| q.key == key)
}
