//! `sheetwork record`: what a running game shows, to a recording.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use glam::{Quat, Vec3};
use serde_json::json;
use sheetwork::link::layout::FrameView;
use sheetwork::recording::{Frame, Header, Recorder};
use sheetwork::{InputError, check_range};

use super::Target;
use crate::{number, print_json, print_line};

/// How long to wait for a first frame.
const PATIENCE: Duration = Duration::from_secs(5);

/// Records a running game.
#[derive(Args)]
pub struct Record {
    #[command(flatten)]
    target: Target,
    /// The file to write.
    file: PathBuf,
    /// How long, s of real time.
    #[arg(long, default_value = "10", value_parser = number)]
    seconds: f64,
    /// Frames a simulated second; what comes faster is left out.
    #[arg(long, default_value = "60", value_parser = number)]
    rate: f64,
    /// Print JSON and nothing else.
    #[arg(long)]
    json: bool,
}

impl Record {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--seconds", self.seconds, 0.0, 1e6, "s")?;
        check_range("--rate", self.rate, 1e-3, 1e5, "1/s")?;
        let client = self.target.attach()?;
        let (scene, source) = (client.status()?.scene, client.scene()?);
        let mut frames = client.frames(false)?;
        let mut frame = frames.wait(PATIENCE)?;
        let epoch = frame.header().epoch;
        let shape = |view: &FrameView| -> Vec<usize> { view.sheets().map(|s| s.positions().len()).collect() };
        let first = frame.view()?;
        let bodies = first.bodies().len();
        let header = Header { scene, source, frames_per_second: self.rate, masses: shape(&first), bodies };
        let mut recorder = Recorder::begin(&self.file, &header)?;
        let (start, mut due) = (Instant::now(), f64::NEG_INFINITY);
        let mut ended = "time is up";
        while start.elapsed().as_secs_f64() < self.seconds {
            let view = frame.view()?;
            let time = view.header().time;
            if view.header().epoch != epoch || shape(&view) != header.masses || view.bodies().len() != bodies {
                ended = "the game has another scene now";
                break;
            }
            // Time that runs backwards is a reset: the recording goes on with it.
            if time >= due || time < due - 2.0 / self.rate {
                recorder.append(&copied(&view))?;
                due = (time + 1e-9).max(due.max(time - 0.5 / self.rate)) + 1.0 / self.rate - 1e-6;
            }
            match frames.wait(PATIENCE) {
                Ok(next) => frame = next,
                Err(_) => {
                    ended = "the game has gone quiet";
                    break;
                }
            }
        }
        let (written, missed) = (recorder.finish()?, frames.missed());
        if self.json {
            print_json(&json!({ "file": self.file, "frames": written, "missed": missed, "ended": ended }))?;
        } else {
            print_line(&format!("{}: {written} frames, {missed} missed; {ended}", self.file.display()))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn copied(view: &FrameView) -> Frame {
    Frame {
        time: view.header().time,
        sheets: view.sheets().map(|s| s.positions().iter().map(|p| Vec3::from(*p)).collect()).collect(),
        bodies: view
            .bodies()
            .iter()
            .map(|[x, y, z, a, b, c, d]| (Vec3::new(*x, *y, *z), Quat::from_xyzw(*a, *b, *c, *d)))
            .collect(),
    }
}
