//! `sheetwork bench kicks`: instabilities among sheets of random material, size and pose with a
//! random velocity of every node.

use std::process::ExitCode;

use crate::measure::kicks::kick;
use clap::Args;
use serde_json::json;
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;

use crate::output::{OutputFlags, print_json, print_line};
use crate::quantities::time;

#[derive(Args)]
pub struct Kicks {
    /// Number of sheets.
    #[arg(long, default_value = "1000")]
    runs: u64,
    /// Number of the first draw.
    #[arg(long, default_value = "0")]
    first: u64,
    /// Structures to draw from, comma-separated.
    #[arg(long, default_value = "shell", value_delimiter = ',')]
    structures: Vec<StructureKind>,
    /// Simulated time of each sheet, s.
    #[arg(long, default_value = "2", value_parser = time)]
    seconds: f64,
    #[command(flatten)]
    output: OutputFlags,
}

impl Kicks {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let mut unstable = Vec::new();
        let (mut gained, mut highest, mut solves, mut stages, mut guarded) = (0_u64, 1.0_f64, 0, 0, 0);
        for index in self.first..self.first + self.runs {
            let found = kick(index, &self.structures, self.seconds)?;
            gained += u64::from(found.energy_ratio > 1.001);
            highest = highest.max(found.energy_ratio);
            solves += found.solves;
            guarded += found.guarded.0;
            stages += found.guarded.1;
            if let Some(why) = &found.unstable {
                unstable.push(format!("{index}: {}: {why}", found.what));
            }
        }
        let per_stage = solves as f64 / stages.max(1) as f64;
        if self.output.json {
            print_json(&json!({
                "runs": self.runs,
                "unstable": unstable,
                "gained_energy": gained,
                "highest_energy_ratio": highest,
                "solves_per_stage": per_stage,
                "guarded_stages": guarded,
                "stages": stages,
            }))?;
        } else {
            unstable.iter().try_for_each(|line| print_line(line))?;
            print_line(&format!(
                "{} sheets: {} unstable; {gained} gained more than 0.1 % of energy, the most {highest:.3} times the start's; \
                 {per_stage:.2} solves a stage, {guarded} of {stages} stages guarded",
                self.runs,
                unstable.len()
            ))?;
        }
        Ok(if unstable.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}
