//! `sheetwork study`: statistics of the answers of a study.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use sheetwork::InputError;
use sheetwork_rigs::study::{AGAINST, Answers, Findings, LAST_QUESTIONS, QUESTIONS, QuestionFindings, SHEETS};

use sheetwork_rigs::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
pub struct StudyArguments {
    /// Tables of answers, as written by the editor's study mode; those of the thesis by default.
    #[arg(default_value = "assets/study/thesis.csv")]
    files: Vec<PathBuf>,
    /// Sheet of comparison.
    #[arg(long, value_name = "SHEET", default_value = AGAINST, value_parser = PossibleValuesParser::new(SHEETS))]
    against: String,
    #[command(flatten)]
    output: OutputFlags,
}

impl StudyArguments {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let mut all = Answers::default();
        for file in &self.files {
            all.merge(Answers::read(file)?).map_err(|e| e.in_file(file))?;
        }
        if all.ratings.is_empty() && all.overall.is_empty() {
            return Err(InputError::new("", "has no answers").in_file(&self.files[0]));
        }
        let findings = all.findings(&self.against);
        if self.output.json {
            print_json(&findings)?;
        } else {
            tables(&findings)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Width of the column with the questions.
const ASKED: usize = 44;

fn tables(findings: &Findings) -> Result<(), InputError> {
    print_line(&format!(
        "{} subjects; mean ± deviation (median), and under it p of the difference from",
        findings.subjects
    ))?;
    print_line(&format!("{}: Student's t of pairs, one-sided.", findings.against))?;
    for test in &findings.tests {
        let names = test.questions.first().map(|q| q.sheets.iter().map(|s| s.sheet.as_str())).into_iter().flatten();
        let heads: String = names.map(|name| format!("{name:>22}")).collect();
        print_line(&format!("\n{:<ASKED$}{heads}", test.test))?;
        for question in &test.questions {
            row(question)?;
        }
    }
    if findings.overall.iter().any(|q| q.sheets.iter().any(|s| s.summary.is_some())) {
        print_line("\nat the end")?;
        findings.overall.iter().try_for_each(row)?;
    }
    Ok(())
}

fn row(found: &QuestionFindings) -> Result<(), InputError> {
    let asks = QUESTIONS.iter().chain(&LAST_QUESTIONS).find(|q| q.key == found.question).map_or("", |q| q.asks);
    let values = found.sheets.iter().map(|sheet| match sheet.summary {
        Some(s) => format!("{:>22}", format!("{:.2} ± {:.2} ({})", s.mean, s.deviation, s.median)),
        None => format!("{:>22}", "-"),
    });
    print_line(&format!("{:<6}{asks:<38}{}", found.question, values.collect::<String>()))?;
    if found.sheets.iter().any(|s| s.against.is_some()) {
        let chances = found.sheets.iter().map(|sheet| match sheet.against {
            Some(paired) => format!("{:>22}", format!("p {:.5}", paired.p)),
            None => format!("{:>22}", ""),
        });
        print_line(format!("{:<ASKED$}{}", "", chances.collect::<String>()).trim_end())?;
    }
    Ok(())
}
