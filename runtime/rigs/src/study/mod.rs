//! A study of how sheets look: what people answer who watch them blind, as a table in a file, and what it comes to.
//!
//! It is that of the thesis (its chapter 6 and appendices C and D): three tests, in each the same drop with several sheets, one after the
//! other and without their names; eight questions after each, five of accuracy and three of speed, and two at the end of all. Answers are 1
//! (poor) to 9 (good), or none. The file is CSV with a line for each sheet that was seen and one with the test `overall` for the end of a
//! subject's session; `assets/study/thesis.csv` has the thesis's own answers.

pub(crate) mod answers;
pub(crate) mod statistics;

pub use crate::study::answers::{Answers, Overall, Rating};
pub use crate::study::statistics::{Paired, Summary, paired, summary};

use serde::Serialize;

/// A question: its key in the table, what is asked, and what 1 and 9 stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Question {
    /// `A1` to `C2`, as the thesis counts them.
    pub key: &'static str,
    /// What is asked.
    pub asks: &'static str,
    /// What 1 is.
    pub low: &'static str,
    /// What 9 is.
    pub high: &'static str,
}

const fn question(key: &'static str, asks: &'static str, low: &'static str, high: &'static str) -> Question {
    Question { key, asks, low, high }
}

/// What is asked after each sheet.
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

/// What is asked at the end.
pub const LAST_QUESTIONS: [Question; 2] = [
    question("C1", "The sheets as a whole beside real ones", "negative", "positive"),
    question("C2", "How the sheets are drawn", "poor", "good"),
];

/// The tests, in the thesis's order.
pub const TESTS: [&str; 3] = ["cube", "wedge1", "wedge2"];

/// The sheets: the thesis's four, and the shell.
pub const SHEETS: [&str; 5] = ["slamm", "trimm", "provot3d", "provot2d", "shell"];

/// The test of the line that ends a subject's session.
pub const OVERALL: &str = "overall";

/// The sheet that others are compared with unless told otherwise: the thesis's.
pub const AGAINST: &str = "provot2d";

/// What a study comes to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// How many people answered.
    pub subjects: usize,
    /// The sheet that others are compared with.
    pub against: String,
    /// Test by test.
    pub tests: Vec<TestFindings>,
    /// The questions at the end.
    pub overall: Vec<QuestionFindings>,
}

/// What one test comes to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestFindings {
    /// Which.
    pub test: String,
    /// Question by question; `Total` is the sum of what a subject answered.
    pub questions: Vec<QuestionFindings>,
}

/// What the answers to one question come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuestionFindings {
    /// Its key, or `Total`.
    pub question: String,
    /// Sheet by sheet; one without a name for a question at the end.
    pub sheets: Vec<SheetFindings>,
}

/// What the answers of one question for one sheet come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetFindings {
    /// Which sheet.
    pub sheet: String,
    /// Mean, deviation, median; none where nobody answered.
    #[serde(flatten)]
    pub summary: Option<Summary>,
    /// Against the sheet that it is compared with, over those who answered for both; none for that one itself, and where it says nothing.
    pub against: Option<Paired>,
}

impl Answers {
    /// What they come to, sheets compared with `against`.
    pub fn findings(&self, against: &str) -> Findings {
        let tests = TESTS.iter().filter(|t| self.ratings.iter().any(|r| r.test == **t));
        let overall = LAST_QUESTIONS.iter().enumerate().map(|(q, question)| {
            let values: Vec<f64> = self.overall.iter().filter_map(|o| o.answers[q]).map(f64::from).collect();
            let found = SheetFindings { sheet: String::new(), summary: summary(&values), against: None };
            QuestionFindings { question: question.key.to_owned(), sheets: vec![found] }
        });
        Findings {
            subjects: self.subjects().len(),
            against: against.to_owned(),
            tests: tests.map(|test| self.of_test(test, against)).collect(),
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
