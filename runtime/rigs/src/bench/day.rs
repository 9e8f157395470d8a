//! `sheetwork bench day`: one sheet for a day of simulated time, kicked, heated and cooled.
//!
//! A strip that hangs from its clamped end gets a random velocity of every node each ten seconds.
//! An oven is on for the first five minutes of every ten. Limits:
//!
//! - Between kicks the energy rises by thermal expansion only.
//! - The total energy stays below that of the first part. A strip that stiffens during its swing
//!   keeps some stress, which is bounded.
//! - The tip hangs at its initial position.
//! - Memory stays at its value after the first part.
//!
//! Progress is printed for each hour.

use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use glam::DVec3;
use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::json;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    IntegratorKind, MaterialChoice, OvenSpec, PinSpec, Placement, Region, Scene, SheetSpec, SpringLaw,
};
use sheetwork::{InputError, World, check_range};

use crate::bench::memory;
use crate::measure::random_sequence::SplitMix64;
use crate::output::{OutputFlags, print_json, print_line};
use crate::quantities::parse_number;

/// Time between kicks (s) and largest velocity component of a kick (m/s).
const KICK_EVERY: u64 = 10;
const KICK: f64 = 1.0;
/// Period of the oven (s) and its temperature (°C).
const CYCLE: u64 = 600;
const WARM: f64 = 90.0;
/// Limits relative to the first part. `BOUND`: factor on its largest energy. `RISE`: energy rise
/// between kicks as a fraction of the energy of a kick; a clamped strip that expands stores some
/// energy, and without heat the rise is rounding. `DRIFT`: displacement of the tip as a fraction of
/// the strip's length.
const BOUND: f64 = 1.1;
const RISE: f64 = 0.05;
const DRIFT: f64 = 0.01;
const LENGTH: f64 = 0.1;

#[derive(Args)]
pub struct Day {
    /// Simulated time, h; 0.2 to 1e4.
    #[arg(long, default_value = "24", value_parser = parse_number)]
    hours: f64,
    /// Time integrator.
    #[arg(long, default_value = "tr-bdf2")]
    engine: IntegratorKind,
    /// Nodes along the strip, 3 to 1000; half as many across it.
    #[arg(long, default_value_t = 9)]
    masses: u32,
    #[command(flatten)]
    output: OutputFlags,
}

/// Statistics over a part of the time.
#[derive(Clone, Copy, Serialize)]
struct DayStatistics {
    /// Largest mechanical energy above that of the first equilibrium, J.
    most_j: f64,
    /// Energy of the largest kick, J, and largest energy rise between two kicks, J.
    kick_j: f64,
    rise_j: f64,
    /// Lowest and highest position of the tip before a heating phase, m.
    tip_m: (f64, f64),
    /// Largest node temperature, °C.
    warmest_c: f64,
    /// Memory at the end of the part, bytes.
    memory_bytes: u64,
}

impl DayStatistics {
    const NOTHING: Self = Self {
        most_j: 0.0,
        kick_j: 0.0,
        rise_j: 0.0,
        tip_m: (f64::INFINITY, f64::NEG_INFINITY),
        warmest_c: -273.15,
        memory_bytes: 0,
    };
}

impl Day {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--hours", self.hours, 0.2, 1e4, "h")?;
        check_range("--masses", f64::from(self.masses), 3.0, 1e3, "")?;
        let start = Instant::now();
        let mut world = World::new(&self.scene())?;
        world.set_sleep(false);
        world.find_equilibrium(1e-9);
        let rest = world.energy().total;
        let parts = if self.hours < 10.0 { (self.hours * 3600.0 / CYCLE as f64) as u64 } else { self.hours as u64 };
        let cycles = (self.hours * 3600.0 / CYCLE as f64).round() as u64;
        let bar = self.output.bar(cycles);
        let mut all: Vec<DayStatistics> = Vec::with_capacity(parts as usize + 1);
        let mut draw = SplitMix64::new(0, 0);
        let mut seen = DayStatistics::NOTHING;
        for cycle in 0..cycles {
            if let Some(sheet) = cycle_of(&mut world, rest, &mut draw, &mut seen)? {
                print_line(&format!("unstable at {:.2} s: {sheet}", world.time()))?;
                return Ok(ExitCode::from(1));
            }
            bar.inc(1);
            if (cycle + 1) * parts / cycles > cycle * parts / cycles {
                seen.memory_bytes = memory::process_memory();
                all.push(std::mem::replace(&mut seen, DayStatistics::NOTHING));
                self.print_progress(&bar, all.len(), &all)?;
            }
        }
        bar.finish_and_clear();
        self.judge(&world, &all, start.elapsed().as_secs_f64())
    }

    fn print_progress(&self, bar: &ProgressBar, count: usize, all: &[DayStatistics]) -> Result<(), InputError> {
        let (Some(last), false) = (all.last(), self.output.json) else { return Ok(()) };
        bar.suspend(|| {
            print_line(&format!(
                "{count:>4}  {:.4} mJ at most, a kick {:.4} mJ, {:.1e} mJ risen between kicks, tip {:.7} to {:.7} m, {:.1} °C, {} kB",
                1e3 * last.most_j,
                1e3 * last.kick_j,
                1e3 * last.rise_j,
                last.tip_m.0,
                last.tip_m.1,
                last.warmest_c,
                last.memory_bytes >> 10
            ))
        })
    }

    /// Result of the day. The first part is the reference of the others.
    fn judge(&self, world: &World, all: &[DayStatistics], seconds: f64) -> Result<ExitCode, InputError> {
        let Some((first, later)) = all.split_first() else { return Ok(ExitCode::SUCCESS) };
        let energy = later.iter().map(|s| s.most_j / first.most_j).fold(1.0, f64::max);
        let rise = all.iter().map(|s| s.rise_j / s.kick_j).fold(0.0, f64::max);
        let drift = later.iter().map(|s| (s.tip_m.0 - first.tip_m.0).abs().max((s.tip_m.1 - first.tip_m.1).abs()));
        let drift = drift.fold(0.0, f64::max);
        let grown = all.last().map_or(0, |s| s.memory_bytes.saturating_sub(first.memory_bytes));
        let well =
            energy <= BOUND && rise <= RISE && drift <= DRIFT * LENGTH && grown <= memory::MEMORY_GROWTH_TOLERANCE;
        let simulated = world.time();
        if self.output.json {
            print_json(&json!({
                "simulated_s": simulated, "steps": world.steps(), "seconds": seconds, "energy_over_first": energy,
                "rise_over_kick": rise, "tip_drift_m": drift, "memory_grown_bytes": grown, "well": well,
                "parts": all,
            }))?;
        } else {
            print_line(&format!(
                "{simulated:.0} s in {} steps and {seconds:.0} s: energy at most {energy:.4} times that of the first part, risen between \
                 kicks by at most {rise:.1e} of one; tip within {drift:.1e} m of where it hung; memory {} kB more",
                world.steps(),
                grown >> 10
            ))?;
        }
        Ok(if well { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn scene(&self) -> Scene {
        let sheet = SheetSpec {
            name: "strip".into(),
            structure: StructureKind::Shell,
            springs: SpringLaw::Calibrated,
            grid: (self.masses, 1, self.masses.div_ceil(2)),
            size: (LENGTH, 0.5 * LENGTH),
            material: MaterialChoice::Named("hips".into()),
            pins: vec![PinSpec::clamped(Region::Left)],
            // Hanging: material that stiffens keeps its stress, and a horizontal strip would sag
            // further in every heating phase.
            placement: Placement { rotation: DVec3::new(0.0, 0.0, -90.0), ..Placement::default() },
            damping_ratio: Some(0.02),
            ..SheetSpec::default()
        };
        let oven = OvenSpec { temperature: WARM, on: false, ..OvenSpec::default() };
        Scene {
            name: "day".into(),
            engine: self.engine,
            dt: 1.0 / 60.0,
            sheets: vec![sheet],
            oven: Some(oven),
            ..Scene::default()
        }
    }
}

/// One period of the oven, energies above `rest` (J). Returns the name of a sheet that became
/// unstable.
fn cycle_of(
    world: &mut World,
    rest: f64,
    draw: &mut SplitMix64,
    seen: &mut DayStatistics,
) -> Result<Option<String>, InputError> {
    let mut before = world.energy().total;
    for second in 0..CYCLE {
        if second == 0 || second == CYCLE / 2 {
            if second == 0 {
                let tip = world.sheets()[0].state.x.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
                seen.tip_m = (seen.tip_m.0.min(tip), seen.tip_m.1.max(tip));
            }
            world.set_oven(Some(OvenSpec { temperature: WARM, on: second == 0, ..OvenSpec::default() }))?;
        }
        // No kicks in the last minute before a heating phase, so that the strip hangs at rest.
        if second % KICK_EVERY == 0 && second + 6 * KICK_EVERY < CYCLE {
            kick(world, draw);
            let after = world.energy().total;
            seen.kick_j = seen.kick_j.max(after - before);
            seen.most_j = seen.most_j.max(after - rest);
            before = after;
        }
        for _ in 0..20 {
            (0..3).for_each(|_| _ = world.step());
            let now = world.energy().total;
            seen.rise_j = seen.rise_j.max(now - before);
            seen.most_j = seen.most_j.max(now - rest);
            before = now;
        }
        if let Some(sheet) = world.unstable() {
            return Ok(Some(sheet.name.clone()));
        }
        let celsius = world.sheets()[0].temperatures().unwrap_or_default();
        seen.warmest_c = celsius.iter().copied().fold(seen.warmest_c, f64::max);
    }
    Ok(None)
}

/// Adds a random velocity to every dynamic node.
fn kick(world: &mut World, draw: &mut SplitMix64) {
    let sheet = &mut world.sheets_mut()[0];
    for i in 0..sheet.node_count() {
        let way = draw.place(KICK);
        if !sheet.is_held(i) {
            sheet.state.v.set(i, sheet.state.v.get(i) + way);
        }
    }
}
