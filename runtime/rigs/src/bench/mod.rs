//! `sheetwork bench`: long campaigns with tables, files and plots as results.

pub(crate) mod canvas;
pub(crate) mod counts;
pub(crate) mod day;
pub(crate) mod detail;
pub(crate) mod drops;
pub(crate) mod front;
pub(crate) mod fuzz;
pub(crate) mod hashes;
pub(crate) mod heat;
pub(crate) mod hot_box;
pub(crate) mod kicks;
pub(crate) mod link;
pub(crate) mod many;
pub(crate) mod marker;
pub(crate) mod memory;
pub(crate) mod pareto;
pub(crate) mod plot;
pub(crate) mod point;
pub(crate) mod reference;
pub(crate) mod rollback;
pub(crate) mod scenes;
pub(crate) mod soak;
pub(crate) mod stability;
pub(crate) mod sweep;
pub(crate) mod table;
pub mod thesis;
pub(crate) mod tick;
pub(crate) mod verdict;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use sheetwork::InputError;

/// Arguments of `sheetwork bench`.
#[derive(Args)]
pub struct Bench {
    #[command(subcommand)]
    campaign: Campaign,
}

#[derive(Subcommand)]
enum Campaign {
    /// Run time against error: structures, integrators, grids and steps on four rigs with known
    /// answers.
    Pareto(pareto::Pareto),
    /// Robustness: sheets of random material, size and pose with a random velocity of every node.
    Kicks(kicks::Kicks),
    /// Robustness of contact: sheets of random material, size and pose thrown at random bodies.
    Drops(drops::Drops),
    /// Many sheets: the cost of a frame with a thousand at rest, and the speed-up of a second
    /// thread with a hundred that move.
    Many(many::Many),
    /// Processor times of the steps of a scene: median, 99 %, worst and mean.
    Tick(tick::Tick),
    /// Level of detail: adherence to a budget, and the cost of levels without changes.
    Detail(detail::Detail),
    /// Stability limits of integrators: the longest stable step over stiffness, mass, damping,
    /// structure and more, beside the predicted one.
    Stability(stability::Stability),
    /// Bit-exact continuation of every scene from a snapshot, and the cost of snapshots.
    Rollback(rollback::Rollback),
    /// Instructions of a step, with each feature off, enabled but unused, and active.
    Counts(counts::Counts),
    /// Hashes of the final state of every scene, to compare builds, threads and machines.
    Hashes(hashes::Hashes),
    /// Damaged input of every kind: accepted or rejected, without a panic.
    Fuzz(fuzz::Fuzz),
    /// A day of one sheet that is kicked, heated and cooled: energy, position and memory by the
    /// hour.
    Day(day::Day),
    /// Random scenes of a second each: panics, and instabilities counted.
    Scenes(scenes::Scenes),
    /// Cost of heat in a step: a room that is not at 20 °C, and a heater of six faces.
    Heat(heat::HeatBench),
    /// The live link: cost of publishing for the game, and latency for another process.
    Link(link::LinkBench),
    /// Endurance of the live link: the frames of an hour at speed, with processes that attach,
    /// detach and are killed.
    Soak(soak::Soak),
    /// The thesis, row by row: every table, figure and finding beside what is measured.
    Thesis(thesis::Thesis),
}

impl Bench {
    /// Runs the campaign; exit status 1 when a limit is exceeded.
    ///
    /// # Errors
    /// Invalid flags, and files that cannot be written.
    pub fn execute(self) -> Result<ExitCode, InputError> {
        crate::execute!(
            self.campaign, Campaign:
            Pareto, Kicks, Drops, Many, Detail, Stability, Rollback, Fuzz, Hashes, Counts, Day, Scenes, Heat,
            Link, Soak, Thesis, Tick
        )
    }
}

/// Files of a folder with this extension, by name.
///
/// # Errors
/// An unreadable folder.
pub fn files_of(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, InputError> {
    let entries = std::fs::read_dir(folder).map_err(|e| InputError::io(folder, &e))?;
    let paths = entries.map(|entry| entry.map(|e| e.path())).collect::<Result<Vec<_>, _>>();
    let mut paths = paths.map_err(|e| InputError::io(folder, &e))?;
    paths.retain(|p| p.extension().is_some_and(|e| e == ending));
    paths.sort();
    Ok(paths)
}

/// Contents of files, by name.
fn read_files(mut files: Vec<PathBuf>) -> Result<Vec<Vec<u8>>, InputError> {
    files.sort();
    files.iter().map(|f| std::fs::read(f).map_err(|e| InputError::io(f, &e))).collect()
}

/// Writes rows as CSV with a header line.
///
/// # Errors
/// Failure to write.
fn write_csv(path: &Path, rows: &[impl Serialize]) -> Result<(), InputError> {
    let failed = |e: csv::Error| InputError::new("", e.to_string()).in_file(path);
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(failed)?;
    writer.flush().map_err(|e| InputError::io(path, &e))
}

/// Runs the trials of a campaign that belong to a shard, with a progress bar.
fn run_shard<T, P>(
    shard: Option<(usize, usize)>,
    trials: impl Iterator<Item = T>,
    name: impl Fn(&T) -> String,
    mut run: impl FnMut(T) -> Result<P, InputError>,
) -> Result<Vec<P>, InputError> {
    let (which, of) = shard.unwrap_or((1, 1));
    let mine: Vec<T> = trials.skip(which - 1).step_by(of).collect();
    let bar = ProgressBar::new(mine.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed} {msg}") {
        bar.set_style(style);
    }
    let mut points = Vec::with_capacity(mine.len());
    for trial in mine {
        bar.set_message(name(&trial));
        points.push(run(trial)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(points)
}

/// Parses `I/N`, counted from 1.
fn shard(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parts.filter(|&(i, n)| 1 <= i && i <= n).ok_or_else(|| format!("\"{text}\" is not I/N with 1 <= I <= N"))
}
