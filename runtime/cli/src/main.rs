//! The command line. Its flags, JSON keys and exit statuses are a contract; `README.md` and
//! `--help` describe them.
//!
//! Exit status: 0 success; 1 a sheet became unstable or a limit was exceeded; 2 invalid input.

pub(crate) mod generate;
pub(crate) mod heat_flags;
pub(crate) mod link;
pub(crate) mod list;
pub(crate) mod material;
pub(crate) mod measure;
pub(crate) mod replay;
pub(crate) mod run;
pub(crate) mod study;
pub(crate) mod taken;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use sheetwork::InputError;
use sheetwork::scene::Scene;

/// Stiff thin sheets in real time: run scenes, generate sheets, measure.
#[derive(Parser)]
#[command(name = "sheetwork", version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
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
    Serve(link::Serve),
    /// Show a running game: a live view, or CSV or JSON.
    Watch(link::Watch),
    /// List the parameters of a running game, with unit and range.
    Params(link::Parameters),
    /// Show one parameter of a running game.
    Get(link::Get),
    /// Set a parameter of a running game, in effect from its next step.
    Set(link::Set),
    /// Play, pause, step, reset or load a running game, or store and restore a snapshot.
    Tell(link::Tell),
    /// Record a running game.
    Record(link::Record),
    /// Grab a running game's sheet, pull it, and report the force.
    Grab(link::Grab),
    /// Evaluate the answers of a study: mean, deviation, median, Student's t.
    Study(study::Study),
    /// List structures, integrators, materials, rigs or scenes.
    List(list::List),
}

fn main() -> ExitCode {
    let matches = Arguments::command().get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    if let (Command::Measure(measure), Some((_, given))) = (&arguments.command, matches.subcommand()) {
        taken::tell(measure.case(), given);
    }
    let result = match arguments.command {
        Command::Run(run) => run.execute(),
        Command::Replay(replay) => replay.execute(),
        Command::Generate(generate) => generate.execute(),
        Command::Measure(measure) => measure.execute(),
        Command::Bench(bench) => bench.execute(),
        Command::Material(material) => material.execute(),
        Command::Study(study) => study.execute(),
        Command::List(list) => list.execute(),
        Command::Serve(serve) => serve.execute(),
        Command::Watch(watch) => watch.execute(),
        Command::Params(params) => params.execute(),
        Command::Get(get) => get.execute(),
        Command::Set(set) => set.execute(),
        Command::Tell(tell) => tell.execute(),
        Command::Record(record) => record.execute(),
        Command::Grab(grab) => grab.execute(),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Applies every PATH=VALUE of `--set` to a scene.
fn overridden(scene: Scene, overrides: &[String]) -> Result<Scene, InputError> {
    overrides.iter().try_fold(scene, |scene, item| {
        let parts = item.split_once('=');
        let (path, value) = parts.ok_or_else(|| InputError::new("--set", format!("\"{item}\" is not PATH=VALUE")))?;
        scene.with_override(path.trim(), value)
    })
}
