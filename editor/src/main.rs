//! `sheetwork-editor`: the window onto the simulation.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    sheetwork_editor::cli::Arguments::parse().run()
}
