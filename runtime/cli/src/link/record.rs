//! `sheetwork record`: writes positions, temperatures and fracture of a running game to a
//! recording.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use glam::{Quat, Vec3};
use serde_json::json;
use sheetwork::scene::{HeatMode, Scene};
use sheetwork::world::recording::{RecordedFrame, RecordedTemperature, RecordingHeader, RecordingWriter};
use sheetwork::{InputError, check_range};
use sheetwork_link::Topology;
use sheetwork_link::layout::FrameView;

use crate::link::GameSelection;
use sheetwork_rigs::output::OutputFlags;
use sheetwork_rigs::quantities::{parse_number, time};

/// Time limit of the wait for a frame.
const FIRST_FRAME_TIMEOUT: Duration = Duration::from_secs(5);

/// Records a running game.
#[derive(Args)]
pub struct Record {
    #[command(flatten)]
    target: GameSelection,
    /// File to write.
    file: PathBuf,
    /// Duration, s of real time.
    #[arg(long, default_value = "10", value_parser = time)]
    seconds: f64,
    /// Frames per simulated second; additional frames are skipped.
    #[arg(long, default_value = "60", value_parser = parse_number)]
    rate: f64,
    #[command(flatten)]
    output: OutputFlags,
}

impl Record {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--seconds", self.seconds, 0.0, 1e6, "s")?;
        check_range("--rate", self.rate, 1e-3, 1e5, "1/s")?;
        let client = self.target.attach()?;
        let (scene, source) = (client.status()?.scene, client.scene()?);
        // In the thesis's heat model sheet temperatures have no meaning.
        let by_thesis = |scene: Scene| matches!(scene.heat_mode, HeatMode::Thesis { .. });
        let warm = !Scene::parse(&source).is_ok_and(by_thesis);
        let mut frames = client.frames(false)?;
        let mut topology = client.topology()?;
        let mut frame = frames.wait(FIRST_FRAME_TIMEOUT)?;
        let epoch = frame.header().epoch;
        let shape = |view: &FrameView| -> Vec<usize> { view.sheets().map(|s| s.positions().len()).collect() };
        let first = frame.view()?;
        let bodies = first.bodies().len();
        let header = RecordingHeader { scene, source, frames_per_second: self.rate, masses: shape(&first), bodies };
        let mut recorder = RecordingWriter::begin(&self.file, &header)?;
        let (start, mut due) = (Instant::now(), f64::NEG_INFINITY);
        let mut ended = "time is up";
        while start.elapsed().as_secs_f64() < self.seconds {
            let view = frame.view()?;
            let time = view.header().time;
            if view.header().epoch != epoch || shape(&view) != header.masses || view.bodies().len() != bodies {
                ended = "the game has another scene now";
                break;
            }
            // A backward jump of time is a reset; the recording continues.
            if time >= due || time < due - 2.0 / self.rate {
                topology.wait(view.header(), FIRST_FRAME_TIMEOUT)?;
                recorder.append(&copied(&view, &topology, warm))?;
                due = (time + 1e-9).max(due.max(time - 0.5 / self.rate)) + 1.0 / self.rate - 1e-6;
            }
            match frames.wait(FIRST_FRAME_TIMEOUT) {
                Ok(next) => frame = next,
                Err(_) => {
                    ended = "the game sends no frames";
                    break;
                }
            }
        }
        let (written, missed) = (recorder.finish()?, frames.missed());
        let found = || json!({ "file": self.file, "frames": written, "missed": missed, "ended": ended });
        let text = || format!("{}: {written} frames, {missed} missed; {ended}", self.file.display());
        self.output.print(found, text)?;
        Ok(ExitCode::SUCCESS)
    }
}

fn copied(view: &FrameView, topology: &Topology, warm: bool) -> RecordedFrame {
    let warmth = |celsius: &[f32]| match celsius {
        [_, ..] if warm => RecordedTemperature::Mean(celsius.to_vec()),
        _ => RecordedTemperature::Unknown,
    };
    let whole = |open: &[bool]| !open.contains(&true);
    let meshes = topology.sheets().iter();
    RecordedFrame {
        time: view.header().time,
        sheets: view.sheets().map(|s| s.positions().iter().map(|p| Vec3::from(*p)).collect()).collect(),
        bodies: view
            .bodies()
            .iter()
            .map(|[x, y, z, a, b, c, d]| (Vec3::new(*x, *y, *z), Quat::from_xyzw(*a, *b, *c, *d)))
            .collect(),
        temperatures: view.sheets().map(|s| warmth(s.temperature())).collect(),
        open: meshes.map(|m| if whole(&m.open) { [].into() } else { m.open.as_slice().into() }).collect(),
    }
}
