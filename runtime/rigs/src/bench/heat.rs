//! `sheetwork bench heat`: cost of heat in a step.
//!
//! The sheet of the benchmarks (0.25 m, 0.5 mm, 3 GPa, clamped along one edge, falling from flat)
//! is stepped without and with a heater of six hot faces. Ten steps of each alternate, so that
//! other load of the machine affects both equally. The results are medians of CPU time over the
//! rounds. The first round is excluded, because a heater then computes all shadows.

use std::process::ExitCode;

use clap::Args;
use cpu_time::ProcessTime;
use serde_json::json;
use sheetwork::scene::{IntegratorKind, Scene, SheetSpec};
use sheetwork::{InputError, World, check_range};

use crate::bench::hot_box::{clamped_shell, hot_box, polystyrene};
use crate::output::{OutputFlags, print_json, print_line};

/// Steps of a round.
const STEPS: u32 = 10;
/// Rounds between resets to flat.
const FALL: u32 = 12;

#[derive(Args)]
pub struct HeatBench {
    /// Nodes along length and width.
    #[arg(long, default_value_t = 21)]
    masses: u32,
    /// Rounds of ten steps of each world.
    #[arg(long, default_value_t = 240)]
    rounds: u32,
    #[command(flatten)]
    output: OutputFlags,
}

impl HeatBench {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--masses", f64::from(self.masses), 3.0, 201.0, "")?;
        check_range("--rounds", f64::from(self.rounds), 2.0, 1e6, "")?;
        let mut all = json!({ "masses": self.masses, "rounds": self.rounds });
        let ways: [(&str, fn(&mut Scene)); 3] = [
            ("room", |scene| scene.ambient_temperature = 60.0),
            ("heater", |scene| scene.heaters = vec![hot_box()]),
            ("heater_gradient", |scene| {
                scene.heaters = vec![hot_box()];
                scene.sheets[0].temperature_gradient = true;
            }),
        ];
        for (name, change) in ways {
            let (off, on) = self.step_time(change)?;
            all[name] = json!({ "off_us": off, "on_us": on, "added": on / off - 1.0 });
        }
        if self.output.json {
            print_json(&all)?;
            return Ok(ExitCode::SUCCESS);
        }
        print_line(&format!("shell {0}x{0}, tr-bdf2 at 60 Hz; CPU time of a step, medians", self.masses))?;
        for (name, _) in ways {
            let part = |key: &str| all[name][key].as_f64().unwrap_or(f64::NAN);
            let percent = 100.0 * part("added");
            print_line(&format!(
                "{name:<16} {:>8.1} µs without, {:>8.1} µs with: {percent:+.1} %",
                part("off_us"),
                part("on_us")
            ))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// CPU time of a step without and with the effect of `change` on the scene, µs.
    fn step_time(&self, change: impl Fn(&mut Scene)) -> Result<(f64, f64), InputError> {
        let cold = self.scene();
        let mut warm = cold.clone();
        change(&mut warm);
        let mut worlds = [World::new(&cold)?, World::new(&warm)?];
        worlds.iter_mut().for_each(|w| w.set_sleep(false));
        let mut times = [Vec::new(), Vec::new()];
        for round in 0..self.rounds {
            for (world, times) in worlds.iter_mut().zip(&mut times) {
                if round % FALL == 0 {
                    world.reset()?;
                }
                let start = ProcessTime::now();
                (0..STEPS).for_each(|_| _ = world.step());
                if round % FALL != 0 {
                    times.push(1e6 * start.elapsed().as_secs_f64() / f64::from(STEPS));
                }
            }
        }
        let [off, on] = times.map(median);
        Ok((off, on))
    }

    fn scene(&self) -> Scene {
        let sheet = SheetSpec { damping_ratio: Some(0.05), ..clamped_shell(self.masses, polystyrene()) };
        Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, sheets: vec![sheet], ..Scene::default() }
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}
