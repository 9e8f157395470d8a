//! `sheetwork-editor`: the graphical editor.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    sheetwork_editor::cli::Arguments::parse().run()
}
