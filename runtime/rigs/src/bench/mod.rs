//! `sheetwork bench`: long campaigns that end in tables, files and plots.

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
pub(crate) mod judge;
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

use std::process::ExitCode;

use clap::{Args, Subcommand};
use sheetwork::InputError;

/// Arguments of `sheetwork bench`.
#[derive(Args)]
pub struct Bench {
    #[command(subcommand)]
    campaign: Campaign,
}

#[derive(Subcommand)]
enum Campaign {
    /// Run time against error: structures, engines, grids and steps on four cases with known answers.
    Pareto(pareto::Pareto),
    /// Robustness: sheets of random material, size and pose, every mass kicked its own way.
    Kicks(kicks::Kicks),
    /// Robustness of contact: sheets of random material, size and pose thrown at random bodies.
    Drops(drops::Drops),
    /// Many sheets: a frame of a thousand at rest, and what a second thread is worth to a hundred that move.
    Many(many::Many),
    /// Level of detail: whether a budget is kept, and what levels cost where nothing changes.
    Detail(detail::Detail),
    /// Where engines break: the longest step that sheets bear, over stiffness, mass, damping, structure and more, beside what is predicted.
    Stability(stability::Stability),
    /// Whether every scene goes on from a snapshot to the bit, and what snapshots cost.
    Rollback(rollback::Rollback),
    /// Instructions of a step, with each feature off, on and unused, and at work.
    Counts(counts::Counts),
    /// What every scene comes to, bit for bit: to compare builds, threads and machines.
    Hashes(hashes::Hashes),
    /// Damaged input of every kind: read or refused, and never a panic.
    Fuzz(fuzz::Fuzz),
    /// A day of one sheet that is kicked, heated and cooled: energy, place and memory hour by hour.
    Day(day::Day),
    /// Random scenes, a second each: none panics, and which go unstable.
    Scenes(scenes::Scenes),
    /// What heat adds to a step: a room that is not at 20 °C, and a heater of six faces.
    Heat(heat::HeatBench),
    /// The live link: what publishing costs the game, and how soon another process sees it.
    Link(link::LinkBench),
    /// The live link for long: an hour's frames at speed, with processes that come, go and are killed.
    Soak(soak::Soak),
}

impl Bench {
    /// Runs the campaign; exit status 1 where a limit was missed.
    ///
    /// # Errors
    /// Bad flags, and files that cannot be written.
    pub fn execute(self) -> Result<ExitCode, InputError> {
        match self.campaign {
            Campaign::Pareto(pareto) => pareto.execute(),
            Campaign::Kicks(kicks) => kicks.execute(),
            Campaign::Drops(drops) => drops.execute(),
            Campaign::Many(many) => many.execute(),
            Campaign::Detail(detail) => detail.execute(),
            Campaign::Stability(stability) => stability.execute(),
            Campaign::Rollback(rollback) => rollback.execute(),
            Campaign::Fuzz(fuzz) => fuzz.execute(),
            Campaign::Hashes(hashes) => hashes.execute(),
            Campaign::Counts(counts) => counts.execute(),
            Campaign::Day(day) => day.execute(),
            Campaign::Scenes(scenes) => scenes.execute(),
            Campaign::Heat(heat) => heat.execute(),
            Campaign::Link(link) => link.execute(),
            Campaign::Soak(soak) => soak.execute(),
        }
    }
}

/// `I/N`, counted from 1.
fn shard(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parts.filter(|&(i, n)| 1 <= i && i <= n).ok_or_else(|| format!("\"{text}\" is not I/N with 1 <= I <= N"))
}
