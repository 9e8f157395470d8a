//! `sheetwork bench detail`: adherence to a budget of the level of detail.
//!
//! Swinging sheets are stepped in three worlds, one step of each in turn, so that other load of the
//! machine affects all equally: without levels; with levels and without a budget, all near, which
//! shows the cost of levels without changes; and with levels and a real-time budget. The real-time
//! budget is converted to one of the cost model by the measured step times, as in the plugin.
//! `--calibrate` measures a linear solve and a force evaluation by number of nodes: the constants
//! of the cost model.

use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use cpu_time::ThreadTime;
use glam::DVec3;
use serde_json::json;
use sheetwork::scene::{DetailSpec, IntegratorKind, MaterialChoice, Placement, Scene, SheetSpec};
use sheetwork::{InputError, World, check_range};

use crate::bench::hot_box::{clamped_shell, polystyrene};
use crate::output::{OutputFlags, print_json, print_line};

/// Duration of a frame, s.
const FRAME: f64 = 1.0 / 60.0;
/// Steps without levels before a budget applies.
const CALIBRATION_STEPS: usize = 60;
/// Weight of a new value in the running mean of step times.
const AVERAGE_WEIGHT: f64 = 0.05;
/// Fraction of the run for reaching the budget.
const START_UP_FRACTION: f64 = 0.25;

#[derive(Args)]
pub struct Detail {
    /// Number of swinging sheets.
    #[arg(long, default_value_t = 16)]
    sheets: u32,
    /// Nodes along each side at the finest level; the others have half and a quarter of the cells.
    #[arg(long, default_value_t = 21)]
    grid: u32,
    /// Budget, as a fraction of the time of a step without levels.
    #[arg(long, default_value_t = 0.4)]
    budget: f64,
    /// Simulated time, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Measure the cost of a solve only.
    #[arg(long)]
    calibrate: bool,
    #[command(flatten)]
    output: OutputFlags,
}

/// Step times of a world, ms.
#[derive(Default)]
struct LodStepTimes(Vec<f64>);

impl LodStepTimes {
    fn step(&mut self, world: &mut World) -> f64 {
        let start = Instant::now();
        world.step();
        let taken = 1e3 * start.elapsed().as_secs_f64();
        self.0.push(taken);
        taken
    }

    /// Step times after the start-up.
    fn later(&self) -> &[f64] {
        &self.0[(START_UP_FRACTION * self.0.len() as f64) as usize..]
    }

    fn mean(&self) -> f64 {
        self.later().iter().sum::<f64>() / self.later().len().max(1) as f64
    }

    /// Quantile of the step times.
    fn percentile(&self, part: f64) -> f64 {
        let mut all = self.later().to_vec();
        all.sort_by(f64::total_cmp);
        let last = all.len().saturating_sub(1);
        all.get((part * last as f64).round() as usize).copied().unwrap_or(0.0)
    }
}

impl Detail {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--sheets", self.sheets.into(), 1.0, 1e4, "sheets")?;
        check_range("--grid", self.grid.into(), 9.0, 201.0, "masses")?;
        check_range("--budget", self.budget, 1e-3, 10.0, "of a step without levels")?;
        check_range("--seconds", self.seconds, 0.1, 1e4, "s")?;
        if self.calibrate {
            return self.calibrate();
        }
        let (mut plain, mut whole, mut kept) =
            (World::new(&self.scene(false))?, World::new(&self.scene(true))?, World::new(&self.scene(true))?);
        let (mut without, mut idle, mut with) =
            (LodStepTimes::default(), LodStepTimes::default(), LodStepTimes::default());
        let (mut mean, mut ratio) = (None, None);
        let (mut changes, mut budget) = (0_u32, 0.0);
        for _ in 0..(self.seconds / FRAME).round() as u32 {
            let taken = without.step(&mut plain);
            idle.step(&mut whole);
            let before = mean.unwrap_or(taken);
            mean = Some(before + AVERAGE_WEIGHT * (taken - before));
            if budget == 0.0 && without.0.len() == CALIBRATION_STEPS {
                budget = self.budget * without.percentile(0.5);
            }
            let grids = |world: &World| world.sheets().iter().map(|s| s.model.grid).collect::<Vec<_>>();
            let there = grids(&kept);
            let real = with.step(&mut kept);
            let now = grids(&kept);
            changes += there.iter().zip(&now).map(|(a, b)| u32::from(a != b)).sum::<u32>();
            if let (Some(model), true) = (kept.detail_cost().filter(|c| *c > 0.0), there == now) {
                let before = ratio.unwrap_or(real / model);
                let now: f64 = before + AVERAGE_WEIGHT * (real / model - before);
                ratio = Some(now);
                let wanted = budget / now;
                let far = kept.detail_budget().is_none_or(|b| (wanted / b - 1.0).abs() > 0.15);
                if budget > 0.0 && far {
                    kept.set_detail_budget(Some(wanted))?;
                }
            }
        }
        self.print_report(&without, &idle, &with, (budget, ratio.unwrap_or(1.0), changes), &kept)?;
        Ok(ExitCode::SUCCESS)
    }

    fn print_report(
        &self,
        without: &LodStepTimes,
        idle: &LodStepTimes,
        with: &LodStepTimes,
        (budget, ratio, changes): (f64, f64, u32),
        kept: &World,
    ) -> Result<(), InputError> {
        let within = with.later().iter().filter(|t| **t <= budget).count() as f64 / with.later().len().max(1) as f64;
        let mut grids = std::collections::BTreeMap::new();
        for sheet in kept.sheets() {
            *grids.entry(sheet.model.grid.0).or_insert(0_u32) += 1;
        }
        if self.output.json {
            return print_json(&json!({
                "sheets": self.sheets, "grid": self.grid, "budget_ms": budget,
                "without_ms": without.mean(), "without_p99_ms": without.percentile(0.99),
                "idle_over_without": idle.percentile(0.5) / without.percentile(0.5),
                "with_ms": with.mean(), "with_p50_ms": with.percentile(0.5), "with_p99_ms": with.percentile(0.99),
                "worst_ms": with.percentile(1.0), "within": within, "mean_over_budget": with.mean() / budget,
                "real_over_model": ratio, "changes": changes, "grids": grids,
            }));
        }
        print_line(&format!(
            "{} sheets of {}x{} that swing: {:.2} ms a step, 99 of 100 within {:.2} ms",
            self.sheets,
            self.grid,
            self.grid,
            without.mean(),
            without.percentile(0.99)
        ))?;
        print_line(&format!(
            "with levels and nothing to do: {:.3} times that",
            idle.percentile(0.5) / without.percentile(0.5)
        ))?;
        print_line(&format!(
            "with a budget of {budget:.2} ms: {:.2} ms, {:.2} of the budget; 99 of 100 within {:.2} ms, the worst {:.2} ms; {:.1} % of steps \
             within the budget",
            with.mean(),
            with.mean() / budget,
            with.percentile(0.99),
            with.percentile(1.0),
            100.0 * within
        ))?;
        print_line(&format!(
            "{changes} changes of grid; at the end {grids:?} (masses along a side: sheets); real time {ratio:.2} of the model's"
        ))
    }

    /// Measures the cost of a solve by number of nodes, beside the cost model.
    fn calibrate(&self) -> Result<ExitCode, InputError> {
        let mut rows = Vec::new();
        for (engine, dt) in [(IntegratorKind::TrBdf2, FRAME), (IntegratorKind::Verlet, 1e-7)] {
            for n in [6, 11, 16, 21, 31, 41] {
                let mut sail = self.sail(0, n, false);
                if let (MaterialChoice::Inline(material), false) = (&mut sail.material, engine.info().implicit) {
                    // Young's modulus low enough for a stable step on every grid.
                    material.young = 3e4;
                }
                let scene = Scene { engine, dt, sheets: vec![sail], ..Scene::default() };
                let mut world = World::new(&scene)?;
                (0..20).for_each(|_| _ = world.step());
                let mut least = f64::INFINITY;
                for _ in 0..20 {
                    let before = world.sheets()[0].state.counters.evaluations;
                    let start = ThreadTime::now();
                    (0..10).for_each(|_| _ = world.step());
                    let taken = 1e9 * start.elapsed().as_secs_f64();
                    let solves = world.sheets()[0].state.counters.evaluations - before;
                    least = least.min(taken / solves.max(1) as f64);
                }
                let model = sheetwork::world::lod_cost::cost_of(n as usize * n as usize, engine.info().implicit);
                if !self.output.json {
                    print_line(&format!("{engine} {n}x{n}: {least:.0} ns a solve; the model {model:.0} ns"))?;
                }
                rows.push(json!({ "engine": engine.name(), "grid": n, "ns": least, "model_ns": model }));
            }
        }
        if self.output.json {
            print_json(&json!({ "solves": rows }))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn scene(&self, levels: bool) -> Scene {
        let sheets = (0..self.sheets).map(|i| self.sail(i, self.grid, levels)).collect();
        Scene { engine: IntegratorKind::TrBdf2, dt: FRAME, sheets, ..Scene::default() }
    }

    /// A shell clamped at one edge.
    fn sail(&self, i: u32, grid: u32, levels: bool) -> SheetSpec {
        let position = DVec3::new(f64::from(i % 8), 0.0, f64::from(i / 8)) * 0.5;
        let part = |by: u32| ((grid - 1) / by + 1, (grid - 1) / by + 1);
        let detail = DetailSpec::new([(part(1), Some(1e3)), (part(2), Some(1e4)), (part(4), None)]);
        SheetSpec {
            name: format!("sail {i}"),
            placement: Placement { position, ..Placement::default() },
            damping_ratio: Some(0.002),
            detail: levels.then_some(detail),
            ..clamped_shell(grid, polystyrene())
        }
    }
}
