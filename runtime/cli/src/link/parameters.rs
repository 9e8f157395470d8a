//! `sheetwork params`, `get`, `set` and `tell`: parameters and commands of a running game.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};
use serde_json::json;
use sheetwork::InputError;
use sheetwork_link::{Command, RemoteParameter};

use crate::link::{GameSelection, print_unstable_sheets};
use sheetwork_rigs::output::{OutputFlags, print_json, print_line};

/// Lists all parameters of a running game.
#[derive(Args)]
pub struct Parameters {
    #[command(flatten)]
    target: GameSelection,
    /// Show only parameters whose path contains this text.
    filter: Option<String>,
    #[command(flatten)]
    output: OutputFlags,
}

impl Parameters {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let filter = self.filter.as_deref().unwrap_or_default();
        let mut all = self.target.attach()?.parameters()?;
        let count = all.len();
        all.retain(|p| p.path.contains(filter));
        if all.is_empty() && !filter.is_empty() {
            let problem = format!("no parameter has \"{filter}\" in its path; `sheetwork params` lists all {count}");
            return Err(InputError::new("params", problem));
        }
        if self.output.json {
            print_json(&all.iter().map(row).collect::<Vec<_>>())?;
            return Ok(ExitCode::SUCCESS);
        }
        let width = |text: fn(&RemoteParameter) -> &str| all.iter().map(|p| text(p).chars().count()).max().unwrap_or(0);
        let (paths, values, units) = (width(|p| &p.path), width(|p| &p.value), width(|p| &p.unit));
        for p in &all {
            let range = match (p.min, p.max) {
                (Some(min), Some(max)) => format!("{} to {}", short(min), short(max)),
                _ if p.kind == "boolean" => "true or false".to_owned(),
                _ => String::new(),
            };
            let line = format!("{:<paths$}  {:>values$} {:<units$}  {range}", p.path, p.value, p.unit);
            print_line(line.trim_end())?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn row(p: &RemoteParameter) -> serde_json::Value {
    let value = p.boolean().map_or_else(|| json!(p.value), |b| json!(b));
    json!({ "path": p.path, "value": value, "unit": p.unit, "kind": p.kind, "min": p.min, "max": p.max })
}

fn short(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e6).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

/// Shows one parameter of a running game.
#[derive(Args)]
pub struct Get {
    #[command(flatten)]
    target: GameSelection,
    /// Path of the parameter, as listed by `sheetwork params`.
    path: String,
    #[command(flatten)]
    output: OutputFlags,
}

impl Get {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let found = self.target.attach()?.get(&self.path)?;
        let text = || format!("{} {}", found.value, found.unit).trim_end().to_owned();
        self.output.print(|| row(&found), text)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Sets a parameter of a running game, in effect from its next step.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Set {
    #[command(flatten)]
    target: GameSelection,
    /// Path of the parameter, as listed by `sheetwork params`.
    path: String,
    /// Value, as in a scene file.
    value: String,
    #[command(flatten)]
    output: OutputFlags,
}

impl Set {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let command = Command::Set { path: self.path.clone(), value: self.value.clone() };
        let answer = self.target.attach()?.send(&command)?;
        let old = answer.get("old").and_then(|old| old.as_str()).unwrap_or_default();
        let found = || json!({ "path": self.path, "old": old, "value": self.value });
        self.output.print(found, || format!("{}: {old} -> {}", self.path, self.value))?;
        print_unstable_sheets(&answer);
        Ok(ExitCode::SUCCESS)
    }
}

/// Sends a command to a running game.
#[derive(Args)]
pub struct GameCommand {
    #[command(flatten)]
    target: GameSelection,
    #[command(subcommand)]
    what: GameAction,
}

#[derive(Subcommand)]
enum GameAction {
    /// Print the game's status as JSON.
    Status,
    /// Continue the simulation.
    Play,
    /// Pause the simulation.
    Pause,
    /// Take steps, then pause.
    Step {
        /// Number of steps.
        #[arg(default_value_t = 1)]
        steps: u32,
    },
    /// Reset the world to its scene.
    Reset,
    /// Open a scene file.
    Load {
        /// Path of the file.
        file: PathBuf,
    },
    /// Store a snapshot in the game's memory.
    Snapshot {
        /// Name of the snapshot.
        #[arg(default_value = "")]
        name: String,
    },
    /// Restore a stored snapshot.
    Restore {
        /// Name of the snapshot.
        #[arg(default_value = "")]
        name: String,
    },
}

impl GameCommand {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let command = match self.what {
            GameAction::Status => Command::Status,
            GameAction::Play => Command::Play,
            GameAction::Pause => Command::Pause,
            GameAction::Step { steps } => Command::Step { steps },
            GameAction::Reset => Command::Reset,
            GameAction::Load { file } => {
                // The game's working folder may differ from that of this process.
                let whole = std::path::absolute(&file).map_err(|e| InputError::io(&file, &e))?;
                Command::Load { file: whole.display().to_string() }
            }
            GameAction::Snapshot { name } => Command::Snapshot { name },
            GameAction::Restore { name } => Command::Restore { name },
        };
        let answer = self.target.attach()?.send(&command)?;
        print_json(&answer)?;
        print_unstable_sheets(&answer);
        Ok(ExitCode::SUCCESS)
    }
}
