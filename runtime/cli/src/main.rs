//! The command line. Its flags, JSON keys and exit statuses are a contract; `README.md` and
//! `--help` describe them.
//!
//! Exit status: 0 success; 1 a sheet became unstable or a limit was exceeded; 2 invalid input.

pub(crate) mod force_table;
mod generate;
pub(crate) mod link;
pub(crate) mod list;
pub(crate) mod material;
pub(crate) mod measure;
pub(crate) mod replay;
pub(crate) mod run;
pub(crate) mod study;
pub(crate) mod unused_flags;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use sheetwork::InputError;
use sheetwork::scene::Scene;

/// Stiff thin sheets in real time: run scenes, generate sheets, measure.
#[derive(Parser)]
#[command(name = "sheetwork", version, about)]
struct ProgramArguments {
    #[command(subcommand)]
    command: ProgramCommand,
}

#[derive(Subcommand)]
enum ProgramCommand {
    /// Run a scene without a screen and report the result.
    Run(run::Run),
    /// Repeat the run of a journal and report the first deviation.
    Replay(replay::Replay),
    /// Generate a sheet: count its nodes and springs, write it as a .SHT file.
    Generate(generate::Generate),
    /// Put a sheet on a virtual test rig.
    Measure(Box<measure::Measure>),
    /// Long campaigns with tables, files and plots as results.
    Bench(sheetwork_rigs::bench::Bench),
    /// Report on a material in a sheet: its stiffness, and the delivered stiffness of a structure.
    Material(material::MaterialCommand),
    /// Run a scene in real time, for clients to observe and control.
    Serve(link::serve::Serve),
    /// Show a running game: a live view, or CSV or JSON.
    Watch(link::watch::Watch),
    /// List the parameters of a running game, with unit and range.
    Params(link::parameters::Parameters),
    /// Show one parameter of a running game.
    Get(link::parameters::Get),
    /// Set a parameter of a running game, in effect from its next step.
    Set(link::parameters::Set),
    /// Play, pause, step, reset or load a running game, or store and restore a snapshot.
    Tell(link::parameters::GameCommand),
    /// Record a running game.
    Record(link::record::Record),
    /// Grab a running game's sheet, pull it, and report the force.
    Grab(link::grab::GrabArguments),
    /// Hold a running game's sheet with a joystick, a mouse or another device, in a force loop of
    /// 1 kHz.
    Haptic(link::haptic::HapticArguments),
    /// Evaluate the answers of a study: mean, deviation, median, Student's t.
    Study(study::StudyArguments),
    /// List structures, integrators, materials, rigs or scenes.
    List(list::List),
}

fn main() -> ExitCode {
    let matches = ProgramArguments::command().get_matches();
    let arguments = ProgramArguments::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    if let (ProgramCommand::Measure(measure), Some((_, given))) = (&arguments.command, matches.subcommand()) {
        unused_flags::report_unused_flags(measure.case(), given);
    }
    let result = sheetwork_rigs::execute!(
        arguments.command, ProgramCommand:
        Run, Replay, Generate, Measure, Bench, Material, Study, List, Serve, Watch, Params, Get, Set, Tell,
        Record, Grab, Haptic
    );
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Applies every PATH=VALUE of `--set` to a scene, in any order.
fn apply_overrides(scene: Scene, overrides: &[String]) -> Result<Scene, InputError> {
    let parts = |item: &'_ String| match item.split_once('=') {
        Some((path, value)) => Ok((path.trim().to_owned(), value.to_owned())),
        None => Err(InputError::new("--set", format!("\"{item}\" is not PATH=VALUE"))),
    };
    let pairs = overrides.iter().map(parts).collect::<Result<Vec<_>, _>>()?;
    let pairs: Vec<(&str, &str)> = pairs.iter().map(|(path, value)| (path.as_str(), value.as_str())).collect();
    if pairs.is_empty() { Ok(scene) } else { Ok(scene.with_overrides(&pairs)?) }
}
