//! `sheetwork bench thesis`: every table, figure and finding of the thesis (Mahal 2010) that can be
//! run, beside what is measured here.
//!
//! A row states what the thesis reports, runs its experiment on the shipped scenes, and gives a
//! verdict computed from the measurement: agreement, disagreement with its cause, or a misprint
//! with the arithmetic that shows it. Rows are functions in the files of this folder, one file per
//! part of the thesis, and are listed in the table `rows::TABLE`. The whole is written as
//! `thesis.md`, `thesis.csv` and pictures.

mod arithmetic;
mod counts;
mod damping;
mod diagram;
mod drops;
mod dynamics;
mod engines;
mod experiment;
mod findings;
mod future;
mod heat;
mod instruments;
mod inter_layer;
mod layers;
mod measures;
mod picture;
mod remeshing;
mod report;
mod rows;
mod stiffness;
mod study;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use sheetwork::InputError;

use crate::bench::thesis::diagram::Diagram;
pub use crate::bench::thesis::drops::{REFERENCES, draw_references};
use crate::bench::thesis::picture::Strip;
use crate::output::{OutputFlags, print_json, print_line};

/// Arguments of `sheetwork bench thesis`.
#[derive(Args)]
pub struct Thesis {
    /// Run only this row, by its name in the report; may be repeated. Nothing is written then
    /// without --out.
    #[arg(long = "row", value_name = "NAME")]
    rows: Vec<String>,
    /// List the names of the rows.
    #[arg(long)]
    list: bool,
    /// Folder for thesis.md, thesis.csv and the pictures in thesis/; default docs.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Draw no pictures.
    #[arg(long)]
    no_pictures: bool,
    #[command(flatten)]
    output: OutputFlags,
}

/// An experiment of the thesis.
pub(crate) struct Row {
    /// Name on the command line.
    pub name: &'static str,
    /// Table, figure or section, and subject.
    pub title: &'static str,
    /// Report of the thesis.
    pub says: &'static str,
    /// Scene and settings, or data, that the row runs.
    pub here: &'static str,
    /// Runs the experiment.
    pub run: fn() -> Result<Finding, InputError>,
}

/// Rows whose verdict depends on times of the host, and long runs that have a test of their own.
const UNTESTED: [&str; 7] =
    ["figure-5.29", "figure-5.30", "5.3.5-cost", "6.1-speed", "figure-5.8", "figure-5.9", "7.4i-bodies"];

/// Runs the rows whose verdict does not depend on times of the host, but for long runs with a test
/// of their own, and returns name and verdict of each.
///
/// # Errors
/// A scene that cannot be loaded.
pub fn verdicts() -> Result<Vec<(&'static str, &'static str)>, InputError> {
    let rows = rows::TABLE.iter().filter(|row| !UNTESTED.contains(&row.name));
    rows.map(|row| Ok((row.name, (row.run)()?.verdict.word()))).collect()
}

/// Outcome of an experiment.
pub(crate) struct Finding {
    /// Measured values, with units.
    pub measured: String,
    /// Comparison with the thesis.
    pub verdict: Verdict,
    /// Prints of the run, as in a figure of the thesis.
    pub strip: Option<Strip>,
    /// Curves of the run.
    pub diagram: Option<Diagram>,
}

/// Comparison of a measurement with the report of the thesis.
pub(crate) enum Verdict {
    Agrees,
    /// Agrees with numbers of the scene fitted to the report.
    Fitted,
    /// Proposed by the thesis, or left out there, and working here.
    Works,
    /// Disagrees, with the cause.
    Disagrees(String),
    /// The printed value contradicts other values of the thesis; the arithmetic shows it.
    Misprint(String),
}

impl Verdict {
    /// Agreement if the conditions hold, else disagreement with the reason.
    pub fn of(holds: bool, reason: &str) -> Self {
        if holds { Self::Agrees } else { Self::Disagrees(reason.to_owned()) }
    }

    /// For a proposal of the thesis: it works if the conditions hold.
    pub fn proposal(holds: bool, reason: &str) -> Self {
        if holds { Self::Works } else { Self::Disagrees(reason.to_owned()) }
    }

    /// Word for the tables.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Fitted => "fitted",
            Self::Works => "works",
            Self::Disagrees(_) => "disagrees",
            Self::Misprint(_) => "misprint",
        }
    }

    /// Reason or arithmetic; empty for an agreement.
    pub fn reason(&self) -> &str {
        match self {
            Self::Agrees | Self::Fitted | Self::Works => "",
            Self::Disagrees(reason) | Self::Misprint(reason) => reason,
        }
    }
}

impl Finding {
    /// Finding without a picture.
    pub fn new(measured: String, verdict: Verdict) -> Self {
        Self { measured, verdict, strip: None, diagram: None }
    }

    /// The finding with a diagram.
    pub fn with_diagram(self, diagram: Diagram) -> Self {
        Self { diagram: Some(diagram), ..self }
    }

    /// The finding with prints of its run.
    pub fn with(self, strip: Strip) -> Self {
        Self { strip: Some(strip), ..self }
    }
}

impl Thesis {
    /// Runs the rows and writes the report.
    ///
    /// # Errors
    /// An unknown row, a scene that cannot be loaded, and files that cannot be written.
    pub fn execute(self) -> Result<ExitCode, InputError> {
        if self.list {
            rows::TABLE.iter().try_for_each(|row| print_line(&format!("{:<22} {}", row.name, row.title)))?;
            return Ok(ExitCode::SUCCESS);
        }
        let chosen = self.chosen()?;
        let bar = self.output.bar(chosen.len() as u64);
        let mut found = Vec::with_capacity(chosen.len());
        for row in chosen {
            bar.set_message(row.name);
            found.push((row, (row.run)()?));
            bar.inc(1);
        }
        bar.finish_and_clear();
        let out = self.out.or_else(|| self.rows.is_empty().then(|| PathBuf::from("docs")));
        if let Some(out) = out {
            report::write(&out, &found, !self.no_pictures)?;
        }
        if self.output.json {
            print_json(&report::records(&found))?;
        } else {
            found.iter().try_for_each(|(row, finding)| print_line(&report::text(row, finding)))?;
            print_line(&report::summary(&found))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn chosen(&self) -> Result<Vec<&'static Row>, InputError> {
        if self.rows.is_empty() {
            return Ok(rows::TABLE.iter().collect());
        }
        let names: Vec<&str> = rows::TABLE.iter().map(|row| row.name).collect();
        let row_of = |name: &String| {
            let row = rows::TABLE.iter().find(|row| row.name == name);
            row.ok_or_else(|| InputError::unknown_name("--row", "row", name, &names))
        };
        self.rows.iter().map(row_of).collect()
    }
}
