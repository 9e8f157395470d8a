//! Run of a scene without a window: progress bar, report, picture and recording.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cpu_time::ProcessTime;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sheetwork::scene::Scene;
use sheetwork::world::recording::RecordingWriter;
use sheetwork::{InputError, Report, World};

use crate::camera::Camera;
use crate::picture::{Look, Picture};

/// Frames of the recording per simulated second.
pub const FRAMES_PER_SECOND: f64 = 60.0;

/// Folder of the results, below the current one.
pub const FOLDER: &str = "sheetwork-out";

/// Default size of the picture, pixels.
const PICTURE_SIZE: (u32, u32) = (1280, 800);

/// Results of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Report of the run.
    pub report: Report,
    /// Picture of the final state.
    pub picture: PathBuf,
    /// Recording.
    pub recording: PathBuf,
    /// Number of frames of the recording.
    pub frames: u64,
}

/// Run `scene` for `seconds` (its own duration if `None`) with results in [`FOLDER`], and print
/// them. The exit code is 1 when a sheet became unstable.
///
/// # Errors
/// When the scene is not valid or the results cannot be written.
pub fn run(scene: &Scene, seconds: Option<f64>, size: Option<(u32, u32)>) -> Result<ExitCode, InputError> {
    let outcome = simulate(scene, seconds, size.unwrap_or(PICTURE_SIZE), Path::new(FOLDER))?;
    let json = serde_json::to_string_pretty(&outcome.report).map_err(|e| InputError::new("", e.to_string()))?;
    println!("{json}");
    eprintln!("picture    {}", outcome.picture.display());
    eprintln!("recording  {} ({} frames)", outcome.recording.display(), outcome.frames);
    Ok(if outcome.report.status == "ok" { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// Run `scene` for `seconds` (its own duration if `None`); write the picture and the recording to
/// `folder`.
///
/// # Errors
/// When the scene is not valid or a file cannot be written.
pub fn simulate(scene: &Scene, seconds: Option<f64>, size: (u32, u32), folder: &Path) -> Result<Outcome, InputError> {
    let duration = seconds.unwrap_or(scene.duration);
    let mut world = World::new(scene)?;
    std::fs::create_dir_all(folder).map_err(|e| InputError::io(folder, &e))?;
    let stem = file_stem(&scene.name);
    let recording = folder.join(format!("{stem}.swr"));
    let mut recorder = RecordingWriter::create(&recording, &world, FRAMES_PER_SECOND)?;
    recorder.frame(&world)?;
    let camera = Camera::from_world(&world);
    let mut penetration = Vec::new();
    // CPU time of the steps, s.
    let mut spent = 0.0;
    let bar = progress(duration);
    let frames = (duration * FRAMES_PER_SECOND - 1e-9).ceil().max(0.0) as u64;
    for frame in 1..=frames {
        let until = (frame as f64 / FRAMES_PER_SECOND).min(duration);
        let start = ProcessTime::now();
        world.advance(until - world.time());
        spent += start.elapsed().as_secs_f64();
        world.update_max_penetration(&mut penetration);
        recorder.frame(&world)?;
        bar.set_position((1000.0 * world.time()) as u64);
    }
    bar.finish_and_clear();
    let frames = recorder.finish()?;
    let picture = folder.join(format!("{stem}.png"));
    let drawn = Picture::draw(&world, &camera, &Look::default(), size);
    drawn.save(&picture).map_err(|e| InputError::io(&picture, &e))?;
    Ok(Outcome { report: world.report(spent, &penetration), picture, recording, frames })
}

/// Progress bar in simulated milliseconds; hidden without a terminal.
fn progress(duration: f64) -> ProgressBar {
    let bar = ProgressBar::new((1000.0 * duration) as u64);
    if !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    // An invalid template leaves the plain bar.
    if let Ok(style) = ProgressStyle::with_template("simulating {bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// Name of a scene as a file name: letters, digits, `-` and `_`; other characters become `_`.
fn file_stem(name: &str) -> String {
    let clean: String = name.chars().take(80).map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect();
    if clean.is_empty() { "scene".to_owned() } else { clean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_leaves_a_report_a_picture_and_a_recording() {
        let scene = Scene::parse(include_str!("../tests/scenes/wedge.ron")).expect("valid");
        let folder = std::env::temp_dir().join(format!("sheetwork-headless-{}", std::process::id()));
        let start = ProcessTime::now();
        let outcome = simulate(&scene, Some(0.1), (64, 48), &folder).expect("ran");
        let cpu = start.elapsed().as_secs_f64();
        assert!((1e-9..=cpu).contains(&outcome.report.cpu_s), "{} of {cpu} s", outcome.report.cpu_s);
        assert_eq!(outcome.report.status, "ok");
        assert!((outcome.report.simulated_s - 0.1).abs() < 1e-9);
        assert_eq!(outcome.frames, 7, "the start and six frames");
        assert!(outcome.picture.is_file());
        let (header, frames) = sheetwork::world::recording::read(&outcome.recording).expect("readable");
        assert_eq!((header.scene.as_str(), frames.len()), ("wedge", 7));
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn names_become_file_names() {
        assert_eq!(file_stem("two walls / slope"), "two_walls___slope");
        assert_eq!(file_stem(""), "scene");
    }
}
