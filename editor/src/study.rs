//! Study after the thesis's evaluation: several sheets fall in random order and without names, a
//! questionnaire follows each, and the answers are written as a table.
//!
//! Tests are shown in random order, and within a test its sheets in random order, so that a subject
//! compares sheets that fall on the same body. The seed determines the order. Answers are written
//! after every sheet. [`sheetwork_rigs::study`] holds the scenes, the questions and the evaluation.

use std::path::{Path, PathBuf};

use sheetwork::InputError;
use sheetwork::scene::Scene;
use sheetwork_rigs::measure::SplitMix64;
use sheetwork_rigs::study::{Answers, Background, LAST_QUESTIONS, Overall, QUESTIONS, Rating, SHEETS, TESTS, scene};

pub use sheetwork_rigs::study::Trial;

/// Stage of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Introduction, and choice of the subject.
    #[default]
    Welcome,
    /// A sheet falls.
    Watching,
    /// Questions about the sheet.
    Asking,
    /// Final questions.
    Last,
    /// All answers are in the file.
    Over,
}

/// Session of a study with one subject.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// Identifier of the subject; a letter or number suffices.
    pub subject: String,
    /// Answers about the subject's background; all may be left out.
    pub background: Background,
    /// Comment at the end; may be empty.
    pub comment: String,
    /// File of the answers.
    pub file: String,
    /// Seed of the order.
    pub seed: u64,
    stage: Stage,
    plan: Vec<Trial>,
    at: usize,
    /// Answers to the present questions; the outer `None` is no choice, the inner one N/A.
    pub chosen: Vec<Option<Option<u8>>>,
    answers: Answers,
    /// Earlier contents of the file.
    before: Answers,
}

/// Trials in the order of `seed`.
pub fn plan(seed: u64) -> Vec<Trial> {
    let mut draw = SplitMix64::from_state(seed);
    let mut tests = TESTS;
    shuffle(&mut tests, &mut draw);
    let mut of = |test: &'static str| {
        let mut sheets = SHEETS;
        shuffle(&mut sheets, &mut draw);
        sheets.map(|sheet| Trial { test, sheet })
    };
    tests.into_iter().flat_map(&mut of).collect()
}

/// Fisher-Yates shuffle, equal on every machine.
fn shuffle<T>(all: &mut [T], draw: &mut SplitMix64) {
    (1..all.len()).rev().for_each(|i| all.swap(i, draw.below(i + 1)));
}

impl Study {
    /// Session before its start, in the order of `seed`.
    pub fn new(seed: u64) -> Self {
        Self { file: "study.csv".to_owned(), seed, plan: plan(seed), ..Self::default() }
    }

    /// First trial of `seed` with its questions, for a picture; nothing is written.
    pub fn for_picture(seed: u64) -> Self {
        let mut study = Self { stage: Stage::Watching, ..Self::new(seed) };
        study.ask();
        study
    }

    /// Present stage.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Present trial, for the record.
    pub fn trial(&self) -> Option<Trial> {
        self.plan.get(self.at).copied()
    }

    /// Number of the present trial, and number of trials.
    pub fn progress(&self) -> (usize, usize) {
        (self.at + 1, self.plan.len())
    }

    /// Scene of the present trial.
    ///
    /// # Errors
    /// When there is none.
    pub fn scene(&self) -> Result<Scene, InputError> {
        let trial = self.trial().ok_or_else(|| InputError::new("study", "is over"))?;
        scene(trial, &format!("Sheet {} of {}", self.at + 1, self.plan.len()))
    }

    /// Start, with the earlier contents of the file.
    ///
    /// # Errors
    /// When there is no subject, the file is not a table of answers, or it has answers of this
    /// subject.
    pub fn begin(&mut self) -> Result<(), InputError> {
        let subject = self.subject.trim().to_owned();
        if subject.is_empty() || subject.chars().any(char::is_control) {
            return Err(InputError::new(
                "subject",
                "is a letter, number or name, to tell the answers of several apart",
            ));
        }
        let file = Path::new(self.file.trim());
        if file.as_os_str().is_empty() {
            return Err(InputError::new("file", "is where the answers go, and is empty"));
        }
        self.before = if file.exists() { Answers::read(file)? } else { Answers::default() };
        if self.before.subjects().contains(&subject.as_str()) {
            return Err(InputError::new("subject", format!("{subject} has answered before")).in_file(file));
        }
        self.background.subject.clone_from(&subject);
        self.answers.background = if self.background.is_empty() { Vec::new() } else { vec![self.background.clone()] };
        (self.subject, self.plan, self.at) = (subject, plan(self.seed), 0);
        self.stage = Stage::Watching;
        Ok(())
    }

    /// Go on to the questions about the sheet.
    pub fn ask(&mut self) {
        if self.stage == Stage::Watching {
            (self.stage, self.chosen) = (Stage::Asking, vec![None; QUESTIONS.len()]);
        }
    }

    /// Whether every question was answered, N/A included.
    pub fn is_answered(&self) -> bool {
        !self.chosen.is_empty() && self.chosen.iter().all(Option::is_some)
    }

    /// Store the answers and go on. Returns whether another sheet follows.
    ///
    /// # Errors
    /// When a question is unanswered or the file cannot be written; the stage is unchanged then.
    pub fn answer(&mut self) -> Result<bool, InputError> {
        if !self.is_answered() {
            return Err(InputError::new("answers", "are not all given: N/A is one, too"));
        }
        let given = |i: usize| self.chosen.get(i).copied().flatten().flatten();
        let kept = self.answers.clone();
        match (self.stage, self.trial()) {
            (Stage::Asking, Some(trial)) => self.answers.ratings.push(Rating {
                subject: self.subject.clone(),
                order: Some(self.at as u32 + 1),
                test: trial.test.to_owned(),
                sheet: trial.sheet.to_owned(),
                answers: std::array::from_fn::<_, { QUESTIONS.len() }, _>(given),
            }),
            (Stage::Last, _) => self.answers.overall.push(Overall {
                subject: self.subject.clone(),
                answers: std::array::from_fn::<_, { LAST_QUESTIONS.len() }, _>(given),
                comment: self.comment.trim().to_owned(),
            }),
            _ => return Ok(false),
        }
        if let Err(error) = self.write() {
            self.answers = kept;
            return Err(error);
        }
        self.chosen.clear();
        if self.stage == Stage::Last {
            self.stage = Stage::Over;
            return Ok(false);
        }
        self.at += 1;
        if self.at < self.plan.len() {
            self.stage = Stage::Watching;
            return Ok(true);
        }
        (self.stage, self.chosen) = (Stage::Last, vec![None; LAST_QUESTIONS.len()]);
        Ok(false)
    }

    /// Write earlier and new answers to a temporary file that replaces the old one, so that a full
    /// disk keeps the old file.
    fn write(&self) -> Result<(), InputError> {
        let mut all = self.before.clone();
        all.merge(self.answers.clone())?;
        let file = PathBuf::from(self.file.trim());
        let beside = file.with_extension("csv.part");
        let opened = std::fs::File::create(&beside).map_err(|e| InputError::io(&file, &e))?;
        all.write(opened).map_err(|e| e.in_file(&file))?;
        std::fs::rename(&beside, &file).map_err(|e| InputError::io(&file, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_has_every_trial_once_and_follows_from_its_seed() {
        for seed in 0..20 {
            let all = plan(seed);
            assert_eq!(all.len(), 15);
            for test in TESTS {
                let sheets: Vec<&str> = all.iter().filter(|s| s.test == test).map(|s| s.sheet).collect();
                assert!(SHEETS.iter().all(|s| sheets.iter().filter(|t| *t == s).count() == 1), "{seed} {test}");
            }
            assert!(all.chunks(5).all(|block| block.iter().all(|s| s.test == block[0].test)), "tests stay together");
            assert_eq!(plan(seed), all);
        }
        let orders: std::collections::BTreeSet<String> = (0..20).map(|s| format!("{:?}", plan(s))).collect();
        assert!(orders.len() > 18, "another seed, another order");
    }
}
