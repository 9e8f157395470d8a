//! `sheetwork bench`: long campaigns that end in tables, files and plots.

mod canvas;
mod front;
mod judge;
mod kicks;
mod marker;
mod pareto;
mod plot;
mod point;
mod reference;
mod sweep;
mod table;

use std::process::ExitCode;

use clap::{Args, Subcommand};
use sheetwork::InputError;

#[derive(Args)]
pub struct Bench {
    #[command(subcommand)]
    campaign: Campaign,
}

#[derive(Subcommand)]
enum Campaign {
    /// Run time against error: structures, engines, grids and steps on four cases with known answers.
    Pareto(pareto::Pareto),
    /// Robustness: sheets of random material, size and pose, every mass kicked its own way.
    Kicks(kicks::Kicks),
}

impl Bench {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        match self.campaign {
            Campaign::Pareto(pareto) => pareto.execute(),
            Campaign::Kicks(kicks) => kicks.execute(),
        }
    }
}
