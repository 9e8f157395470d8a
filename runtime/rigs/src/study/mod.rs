//! User study of the appearance of sheets: the table of blind answers and its statistics.
//!
//! The design is that of the thesis (chapter 6, appendices C and D). Each of three tests shows the
//! same drop with several sheets, one after the other and without their names. Eight questions
//! follow each sheet, five on accuracy and three on speed; two more follow at the end. Answers are
//! 1 (poor) to 9 (good), or none. The file is CSV with a line for each sheet seen, one line with
//! the test `overall` for the end of a subject's session, and at most one with the test
//! `background`; `assets/study/thesis.csv` has the answers of the thesis.

pub(crate) mod answers;
pub(crate) mod background;
pub(crate) mod claims;
pub(crate) mod rank_tests;
pub(crate) mod reading;
pub(crate) mod statistics;
pub(crate) mod trial;

pub use crate::study::answers::{Answers, Overall, Rating};
pub use crate::study::background::{Background, Population, Sex, Share, THESIS_POPULATION, WeeklyHours, population};
pub use crate::study::claims::{Claim, Measure, Verdict};
pub use crate::study::rank_tests::{Friedman, Wilcoxon, friedman, holm, wilcoxon};
use crate::study::reading::t_test_count;
pub use crate::study::reading::{ALL_TESTS, PairReading, SIGNIFICANCE, SheetScore, TTestCount, TestReading};
pub use crate::study::statistics::{Paired, Summary, paired, summary};
pub use crate::study::trial::{Trial, TrialSpeed, measure_speed, scene};

use serde::Serialize;

/// A question: key in the table, text, and meaning of 1 and 9.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Question {
    /// `A1` to `C2`, as numbered in the thesis.
    pub key: &'static str,
    /// Text of the question.
    pub asks: &'static str,
    /// Meaning of 1.
    pub low: &'static str,
    /// Meaning of 9.
    pub high: &'static str,
}

const fn question(key: &'static str, asks: &'static str, low: &'static str, high: &'static str) -> Question {
    Question { key, asks, low, high }
}

/// Questions after each sheet.
pub const QUESTIONS: [Question; 8] = [
    question("A1", "How it gives way when it first touches", "poor", "good"),
    question("A2", "How it stretches", "inadequate", "convincing"),
    question("A3", "How it takes on its new form", "meagre", "successful"),
    question("A4", "How it keeps its form", "poor", "good"),
    question("A5", "How it slides", "wrong", "real"),
    question("B1", "Speed while it deforms", "slow", "fast"),
    question("B2", "How the speed feels", "tedious", "satisfying"),
    question("B3", "Accuracy as a whole", "wrong", "accurate"),
];

/// Questions at the end.
pub const LAST_QUESTIONS: [Question; 2] = [
    question("C1", "The sheets as a whole beside real ones", "negative", "positive"),
    question("C2", "How the sheets are drawn", "poor", "good"),
];

/// Tests, in the order of the thesis.
pub const TESTS: [&str; 3] = ["cube", "wedge1", "wedge2"];

/// Sheets: the four of the thesis, and the shell.
pub const SHEETS: [&str; 5] = ["slamm", "trimm", "provot3d", "provot2d", "shell"];

/// Test name of the line that ends a subject's session.
pub const OVERALL: &str = "overall";

/// Test name of the line with a subject's background.
pub const BACKGROUND: &str = "background";

/// Default sheet of comparison, from the thesis.
pub const AGAINST: &str = "provot2d";

/// Results of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Number of subjects.
    pub subjects: usize,
    /// Sheet of comparison.
    pub against: String,
    /// Results of each test.
    pub tests: Vec<TestFindings>,
    /// Results of the questions at the end.
    pub overall: Vec<QuestionFindings>,
    /// Population; none where no subject gave a background.
    pub population: Option<Population>,
    /// Comments: subject and text.
    pub comments: Vec<(String, String)>,
    /// Student's t tests of single questions against the sheet of comparison, by their number.
    pub t_tests: TTestCount,
    /// Order of the sheets and its significance, in each test and in all.
    pub readings: Vec<TestReading>,
    /// Statements of the thesis, checked.
    pub claims: Vec<Claim>,
}

/// Results of one test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestFindings {
    /// Test.
    pub test: String,
    /// Results of each question; `Total` is the sum of a subject's answers.
    pub questions: Vec<QuestionFindings>,
}

/// Results of one question.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuestionFindings {
    /// Key of the question, or `Total`.
    pub question: String,
    /// Results of each sheet; a single unnamed one for a question at the end.
    pub sheets: Vec<SheetFindings>,
}

/// Results of one question for one sheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetFindings {
    /// Sheet.
    pub sheet: String,
    /// Mean, deviation and median; none without answers.
    #[serde(flatten)]
    pub summary: Option<Summary>,
    /// Comparison with the reference sheet over subjects who answered for both. None for the
    /// reference sheet itself and where the test is undefined.
    pub against: Option<Paired>,
}

impl Answers {
    /// Computes the results, with `against` as the sheet of comparison.
    pub fn findings(&self, against: &str) -> Findings {
        let tests = TESTS.iter().filter(|t| self.ratings.iter().any(|r| r.test == **t));
        let overall = LAST_QUESTIONS.iter().enumerate().map(|(q, question)| {
            let values: Vec<f64> = self.overall.iter().filter_map(|o| o.answers[q]).map(f64::from).collect();
            let found = SheetFindings { sheet: String::new(), summary: summary(&values), against: None };
            QuestionFindings { question: question.key.to_owned(), sheets: vec![found] }
        });
        let tests: Vec<TestFindings> = tests.map(|test| self.of_test(test, against)).collect();
        let comments = self.overall.iter().filter(|o| !o.comment.is_empty());
        Findings {
            population: population(&self.background),
            comments: comments.map(|o| (o.subject.clone(), o.comment.clone())).collect(),
            readings: self.readings(),
            claims: self.claims(),
            subjects: self.subjects().len(),
            against: against.to_owned(),
            t_tests: t_test_count(&tests),
            tests,
            overall: overall.collect(),
        }
    }

    fn of_test(&self, test: &str, against: &str) -> TestFindings {
        let value = |rating: &Rating, q: usize| match q {
            8 => Some(rating.total()),
            q => rating.answers[q].map(f64::from),
        };
        let of = |sheet: &str, q: usize| -> Vec<(&str, Option<f64>)> {
            let seen = self.ratings.iter().filter(|r| r.test == test && r.sheet == sheet);
            seen.map(|r| (r.subject.as_str(), value(r, q))).collect()
        };
        let shown = SHEETS.iter().filter(|s| self.ratings.iter().any(|r| r.test == test && r.sheet == **s));
        let shown: Vec<&str> = shown.copied().collect();
        let keys = QUESTIONS.iter().map(|q| q.key).chain(["Total"]);
        let questions = keys.enumerate().map(|(q, key)| {
            let base = of(against, q);
            let sheets = shown.iter().map(|sheet| {
                let own = of(sheet, q);
                let values: Vec<f64> = own.iter().filter_map(|o| o.1).collect();
                let pairs: Vec<(f64, f64)> = own
                    .iter()
                    .filter_map(|(subject, value)| {
                        let other = base.iter().find(|b| b.0 == *subject)?;
                        Some(((*value)?, other.1?))
                    })
                    .collect();
                let against = if *sheet == against { None } else { paired(&pairs) };
                SheetFindings { sheet: (*sheet).to_owned(), summary: summary(&values), against }
            });
            QuestionFindings { question: key.to_owned(), sheets: sheets.collect() }
        });
        TestFindings { test: test.to_owned(), questions: questions.collect() }
    }
}
