//! The command line. Its flags, JSON keys and exit statuses are a contract; `README.md` and `--help` describe it.
//!
//! Exit status: 0 done; 1 a sheet went unstable or a limit was missed; 2 bad input.

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
    /// Run a scene without a screen and report what happened.
    Run(run::Run),
    /// Run a journal again, and say where it first comes out otherwise.
    Replay(replay::Replay),
    /// Generate a sheet: count its masses and springs, write it as a .SHT file.
    Generate(generate::Generate),
    /// Put a sheet on a virtual test rig.
    Measure(Box<measure::Measure>),
    /// Long campaigns that end in tables, files and plots.
    Bench(sheetwork_rigs::bench::Bench),
    /// Report on a material in a sheet: its stiffness, and what a structure delivers of it.
    Material(material::MaterialCommand),
    /// Run a scene in real time, for others to watch and to command.
    Serve(link::Serve),
    /// Watch a running game: a live view, or CSV or JSON.
    Watch(link::Watch),
    /// List the parameters of a running game, with unit and range.
    Params(link::Parameters),
    /// One parameter of a running game.
    Get(link::Get),
    /// Set a parameter of a running game, from its next step on.
    Set(link::Set),
    /// Play, pause, step, reset and load a running game, take a snapshot and go back to it.
    Tell(link::Tell),
    /// Record a running game.
    Record(link::Record),
    /// Take hold of a running game's sheet, pull, and feel the force.
    Grab(link::Grab),
    /// Work out what the answers of a study come to: mean, deviation, median, Student's t.
    Study(study::Study),
    /// List structures, engines, materials, cases or scenes.
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

/// A scene with every PATH=VALUE of `--set` in place of its own.
fn overridden(scene: Scene, overrides: &[String]) -> Result<Scene, InputError> {
    overrides.iter().try_fold(scene, |scene, item| {
        let parts = item.split_once('=');
        let (path, value) = parts.ok_or_else(|| InputError::new("--set", format!("\"{item}\" is not PATH=VALUE")))?;
        scene.with_override(path.trim(), value)
    })
}
