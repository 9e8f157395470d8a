//! The command line. Its flags, JSON keys and exit statuses are a contract; `README.md` and `--help` describe it.
//!
//! Exit status: 0 done; 1 a sheet went unstable or a limit was missed; 2 bad input.

mod bench;
mod generate;
mod heat_flags;
#[cfg(feature = "link")]
mod link;
mod list;
mod material;
mod measure;
mod quantities;
mod replay;
mod run;
mod study;
mod taken;

use std::path::Path;
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
    Bench(bench::Bench),
    /// Report on a material in a sheet: its stiffness, and what a structure delivers of it.
    Material(material::MaterialCommand),
    /// Run a scene in real time, for others to watch and to command.
    #[cfg(feature = "link")]
    Serve(link::Serve),
    /// Watch a running game: a live view, or CSV or JSON.
    #[cfg(feature = "link")]
    Watch(link::Watch),
    /// List the parameters of a running game, with unit and range.
    #[cfg(feature = "link")]
    Params(link::Parameters),
    /// One parameter of a running game.
    #[cfg(feature = "link")]
    Get(link::Get),
    /// Set a parameter of a running game, from its next step on.
    #[cfg(feature = "link")]
    Set(link::Set),
    /// Play, pause, step, reset and load a running game, take a snapshot and go back to it.
    #[cfg(feature = "link")]
    Tell(link::Tell),
    /// Record a running game.
    #[cfg(feature = "link")]
    Record(link::Record),
    /// Take hold of a running game's sheet, pull, and feel the force.
    #[cfg(feature = "link")]
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
        #[cfg(feature = "link")]
        Command::Serve(serve) => serve.execute(),
        #[cfg(feature = "link")]
        Command::Watch(watch) => watch.execute(),
        #[cfg(feature = "link")]
        Command::Params(params) => params.execute(),
        #[cfg(feature = "link")]
        Command::Get(get) => get.execute(),
        #[cfg(feature = "link")]
        Command::Set(set) => set.execute(),
        #[cfg(feature = "link")]
        Command::Tell(tell) => tell.execute(),
        #[cfg(feature = "link")]
        Command::Record(record) => record.execute(),
        #[cfg(feature = "link")]
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

/// Prints a JSON value as the only thing on standard output.
fn print_json(value: &impl serde::Serialize) -> Result<(), InputError> {
    let text = serde_json::to_string_pretty(value).map_err(|e| InputError::new("", e.to_string()))?;
    print_line(&text)
}

/// Prints a line; a reader that went away (`| head`) is no error of ours.
fn print_line(text: &str) -> Result<(), InputError> {
    use std::io::Write;
    match writeln!(std::io::stdout(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(InputError::new("standard output", e.to_string())),
        _ => Ok(()),
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

/// Whether `file` can be written: its folder is there, and it is no folder itself.
fn writable(file: &Path) -> Result<(), InputError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        _ if file.is_dir() => Err(InputError::new("", "is a folder").in_file(file)),
        Some(folder) if !folder.is_dir() => Err(InputError::new("", "its folder does not exist").in_file(file)),
        _ => Ok(()),
    }
}

/// Counts separated by `x`, as `11x2x11`.
fn counts<const N: usize>(text: &str) -> Result<[u32; N], String> {
    let parts: Result<Vec<u32>, _> = text.split(['x', 'X']).map(|p| p.trim().parse::<u32>()).collect();
    parts
        .ok()
        .and_then(|p| <[u32; N]>::try_from(p).ok())
        .ok_or_else(|| format!("\"{text}\" is not {N} whole numbers joined by x"))
}
