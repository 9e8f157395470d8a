//! `sheetwork grab`: grabs a point of a sheet, moves it, and reports the force on the hand.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::json;
use sheetwork::{InputError, check_range};
use sheetwork_link::{Command, GrabForce};

use crate::link::{GameSelection, MaterialPoint};
use sheetwork_rigs::output::{print_json, print_line};
use sheetwork_rigs::quantities::{parse_number, parse_vector, stiffness, time};

/// Grabs a material point of a running game's sheet and moves it.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct GrabArguments {
    #[command(flatten)]
    target: GameSelection,
    #[command(flatten)]
    point: MaterialPoint,
    /// Displacement of the hand, m: x,y,z.
    #[arg(long, default_value = "0,0.05,0", value_parser = parse_vector)]
    by: [f64; 3],
    /// Duration of the displacement, s; the hand then stays in place.
    #[arg(long, default_value = "1", value_parser = time)]
    over: f64,
    /// Total duration of the grab, s.
    #[arg(long, default_value = "2", value_parser = time)]
    seconds: f64,
    /// Stiffness of the spring between hand and sheet, N/m.
    #[arg(long, default_value = "100", value_parser = stiffness)]
    stiffness: f64,
    /// Updates of the hand per second, up to 1000.
    #[arg(long, default_value = "500", value_parser = parse_number)]
    rate: f64,
    /// Print every force: time_s, force (N), position (m).
    #[arg(long)]
    csv: bool,
    /// Print JSON and nothing else.
    #[arg(long, conflicts_with = "csv")]
    json: bool,
}

impl GrabArguments {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--rate", self.rate, 0.1, 1000.0, "1/s")?;
        check_range("--over", self.over, 0.0, 1e6, "s")?;
        check_range("--seconds", self.seconds, 0.0, 1e6, "s")?;
        let client = self.target.attach()?;
        let (grab, begin) = self.point.grab(&client, self.stiffness)?;
        let start = Instant::now();
        let mut last = None;
        let (mut largest, mut count) = (0.0_f64, 0_u32);
        while start.elapsed().as_secs_f64() < self.seconds {
            let done = (start.elapsed().as_secs_f64() / self.over.max(1e-9)).min(1.0);
            let target = [0, 1, 2].map(|axis| begin[axis] + done * self.by[axis]);
            let felt = client.pull(grab, target)?;
            if self.csv {
                print_line(&row(&felt))?;
            }
            largest = largest.max(size(felt.force));
            (last, count) = (Some(felt), count + 1);
            let next = Duration::from_secs_f64(f64::from(count) / self.rate);
            std::thread::sleep(next.saturating_sub(start.elapsed()));
        }
        let rate = f64::from(count) / start.elapsed().as_secs_f64().max(1e-9);
        client.send(&Command::Release { grab })?;
        let Some(last) = last else { return Ok(ExitCode::SUCCESS) };
        if self.json {
            print_json(&json!({
                "force_n": last.force, "position_m": last.position, "largest_force_n": largest, "rate_hz": rate,
            }))?;
        } else if !self.csv {
            let [x, y, z] = last.force;
            print_line(&format!(
                "at the end ({x:.4}, {y:.4}, {z:.4}) N; at most {largest:.4} N; {rate:.0} times a second"
            ))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn row(felt: &GrabForce) -> String {
    let [fx, fy, fz] = felt.force;
    let [x, y, z] = felt.position;
    format!("{:.6},{fx:.6},{fy:.6},{fz:.6},{x:.6},{y:.6},{z:.6}", felt.time)
}
