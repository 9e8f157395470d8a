//! `sheetwork replay`: repeats the run of a journal and reports the first deviation.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use serde_json::json;
use sheetwork::world::journal::Journal;
use sheetwork::{InputError, check_range};

use sheetwork_rigs::output::{OutputFlags, print_json};

#[derive(Args)]
pub struct Replay {
    /// Journal written by `sheetwork run SCENE --journal FILE`.
    file: PathBuf,
    /// Go to the state after this step and report it, without a replay of the whole journal.
    #[arg(long, value_name = "STEP")]
    seek: Option<u64>,
    /// Folder of the files that the scene names, if different from the original one.
    #[arg(long)]
    base: Option<PathBuf>,
    /// Number of threads that step sheets, 1 by default; the result is independent of it.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    #[command(flatten)]
    output: OutputFlags,
}

impl Replay {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let journal = Journal::read(&self.file)?;
        let mut world = journal.world(self.base.as_deref())?;
        world.set_threads(self.threads)?;
        if let Some(step) = self.seek {
            check_range("--seek", step as f64, 0.0, journal.len() as f64, "")?;
            journal.seek(&mut world, step)?;
            print_json(&world.report(0.0, &[]))?;
            return Ok(ExitCode::SUCCESS);
        }
        let found = journal.check(&mut world)?;
        let (scene, steps) = (&journal.header.scene, journal.len());
        let result = || json!({ "scene": scene, "steps": steps, "same": found.is_none(), "first_difference": found });
        self.output.print(result, || match &found {
            None => format!("{scene}: {steps} steps, each the same to the bit"),
            Some(d) => format!("{scene}: {} differs after step {}, at {} s", d.what, d.step, d.time_s),
        })?;
        Ok(if found.is_none() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}
