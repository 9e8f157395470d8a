//! `sheetwork bench many`: cost of a frame with many sheets.
//!
//! A thousand small shells sleep on a floor: alone, and with one more that moves. A hundred
//! swinging clamped shells are stepped by one thread and by several, one step of each in turn, so
//! that other load of the machine affects both equally. A thousand free shells far apart show the
//! share of the broad phase, which is the time of the phase `islands` over that of the step. The
//! results are the minimum wall-clock times over all rounds.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Args;
use glam::DVec3;
use serde_json::json;
use sheetwork::profiler::{Phase, StepObserver};
use sheetwork::scene::{BodySpec, IntegratorKind, Placement, Scene, Shape, SheetSpec};
use sheetwork::{InputError, World, check_range};

use crate::bench::hot_box::{clamped_shell, polystyrene, shell};
use crate::output::{OutputFlags, print_json, print_line};

/// Duration of a frame, s.
const FRAME: f64 = 1.0 / 60.0;
/// Time limit for sheets to come to rest, s of simulated time.
const REST: f64 = 20.0;

#[derive(Args)]
pub struct Many {
    /// Number of sheets at rest.
    #[arg(long, default_value_t = 1000)]
    resting: u32,
    /// Number of sheets that move.
    #[arg(long, default_value_t = 100)]
    moving: u32,
    /// Number of free sheets far apart.
    #[arg(long, default_value_t = 1000)]
    free: u32,
    /// Number of threads to compare with one.
    #[arg(long, default_value_t = 2)]
    threads: u32,
    /// Number of rounds.
    #[arg(long, default_value_t = 200)]
    rounds: u32,
    #[command(flatten)]
    output: OutputFlags,
}

impl Many {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--resting", self.resting.into(), 1.0, 1e5, "sheets")?;
        check_range("--moving", self.moving.into(), 1.0, 1e4, "sheets")?;
        check_range("--free", self.free.into(), 1.0, 1e5, "sheets")?;
        check_range("--threads", self.threads.into(), 2.0, 256.0, "threads")?;
        check_range("--rounds", self.rounds.into(), 1.0, 1e6, "")?;
        let mut still = World::new(&resting(self.resting))?;
        settle(&mut still)?;
        let rest_ms = self.least(&mut [&mut still])[0];
        still.add_sheet(&swinging(0, DVec3::new(0.0, 5.0, 0.0)))?;
        let mut lone = World::new(&Scene { sheets: vec![swinging(0, DVec3::new(0.0, 5.0, 0.0))], ..empty() })?;
        let one = self.least(&mut [&mut still, &mut lone]);
        let scene = Scene { sheets: (0..self.moving).map(|i| swinging(i, at(i, 0.4))).collect(), ..empty() };
        let (mut single, mut several) = (World::new(&scene)?, World::new(&scene)?);
        several.set_threads(self.threads as usize)?;
        let both = self.least(&mut [&mut single, &mut several]);
        let broad = self.measure_broad_phase()?;
        self.print_report(rest_ms, (one[0], one[1]), (both[0], both[1]), broad)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Minimum wall-clock time of a frame of each world, ms.
    fn least(&self, worlds: &mut [&mut World]) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; worlds.len()];
        for _ in 0..self.rounds {
            for (world, least) in worlds.iter_mut().zip(&mut least) {
                let start = Instant::now();
                world.step();
                *least = least.min(1e3 * start.elapsed().as_secs_f64());
            }
        }
        least
    }

    /// Minimum wall-clock time of a frame of free sheets far apart, ms, and the smallest share of
    /// the broad phase.
    fn measure_broad_phase(&self) -> Result<(f64, f64), InputError> {
        let free = |i| placed(format!("sail {i}"), at(i, 1.0), shell(11, 0.25, polystyrene()));
        let mut world = World::new(&Scene { sheets: (0..self.free).map(free).collect(), ..empty() })?;
        let clock = Arc::new(IslandsClock { start: Instant::now(), nanoseconds: AtomicU64::new(0) });
        world.set_profiler(Some(clock.clone()));
        let (mut least, mut share) = (f64::INFINITY, f64::INFINITY);
        // Each round steps all sheets: a tenth of the rounds takes about as long as the others.
        for _ in 0..self.rounds.div_ceil(10) {
            let start = Instant::now();
            world.step();
            let (step, islands) = (start.elapsed(), clock.nanoseconds.swap(0, Ordering::Relaxed));
            least = least.min(1e3 * step.as_secs_f64());
            share = share.min(islands as f64 / step.as_nanos() as f64);
        }
        Ok((least, share))
    }

    fn print_report(
        &self,
        rest: f64,
        (with, without): (f64, f64),
        (one, several): (f64, f64),
        (free, broad): (f64, f64),
    ) -> Result<(), InputError> {
        if self.output.json {
            return print_json(&json!({
                "resting": self.resting, "resting_frame_ms": rest, "resting_and_one_ms": with, "one_alone_ms": without,
                "moving": self.moving, "threads": self.threads, "one_thread_ms": one, "threads_ms": several,
                "scaling": one / several, "free": self.free, "free_frame_ms": free, "broad_phase_share": broad,
            }));
        }
        print_line(&format!("{} shells of 5x5 asleep: {rest:.4} ms a frame", self.resting))?;
        print_line(&format!("with one of 11x11 that swings: {with:.4} ms; that one alone: {without:.4} ms"))?;
        print_line(&format!(
            "{} shells of 11x11 that swing: {one:.2} ms a frame on one thread, {several:.2} ms on {}: {:.2} times as fast",
            self.moving,
            self.threads,
            one / several
        ))?;
        print_line(&format!(
            "{} free shells of 11x11 far apart: {free:.2} ms a frame, of which the broad phase {:.2} %",
            self.free,
            100.0 * broad
        ))
    }
}

/// Clock of the phase [`Phase::Islands`].
struct IslandsClock {
    start: Instant,
    /// Time spent in the phase, ns. Between `begin` and `end` it is short by the time of `begin`.
    nanoseconds: AtomicU64,
}

impl IslandsClock {
    fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }
}

impl StepObserver for IslandsClock {
    fn begin(&self, phase: Phase) {
        if phase == Phase::Islands {
            self.nanoseconds.fetch_sub(self.now(), Ordering::Relaxed);
        }
    }

    fn end(&self, phase: Phase) {
        if phase == Phase::Islands {
            self.nanoseconds.fetch_add(self.now(), Ordering::Relaxed);
        }
    }
}

fn empty() -> Scene {
    Scene { engine: IntegratorKind::TrBdf2, dt: FRAME, ..Scene::default() }
}

/// Position number `i` in a square array with spacing `apart` (m).
fn at(i: u32, apart: f64) -> DVec3 {
    DVec3::new(f64::from(i % 32), 0.0, f64::from(i / 32)) * apart
}

fn placed(name: String, position: DVec3, sheet: SheetSpec) -> SheetSpec {
    SheetSpec { name, placement: Placement { position, ..Placement::default() }, ..sheet }
}

/// Small shells on a floor.
fn resting(count: u32) -> Scene {
    let above = DVec3::new(0.0, 3e-4, 0.0);
    let lying = |i| placed(format!("leaf {i}"), at(i, 0.1) + above, shell(5, 0.05, polystyrene()));
    let floor = BodySpec { name: "floor".into(), ..BodySpec::new(Shape::HalfSpace) };
    Scene { sheets: (0..count).map(lying).collect(), bodies: vec![floor], ..empty() }
}

/// A shell clamped at one edge.
fn swinging(i: u32, position: DVec3) -> SheetSpec {
    let spec = placed(format!("sail {i}"), position, clamped_shell(11, polystyrene()));
    SheetSpec { damping_ratio: Some(0.005), ..spec }
}

/// Steps until all sheets sleep.
///
/// # Errors
/// Sheets that do not come to rest.
fn settle(world: &mut World) -> Result<(), InputError> {
    while !world.is_resting() {
        if world.time() > REST {
            return Err(InputError::new("resting", format!("not all sheets come to rest in {REST} s")));
        }
        world.step();
    }
    Ok(())
}
