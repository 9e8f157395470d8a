//! `sheetwork bench drops`: instabilities and passages through bodies among sheets of random
//! material, size and pose thrown at random bodies.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::measure::drops::{Drop, throw};
use crate::measure::object;
use clap::Args;
use serde_json::{Value, json};
use sheetwork::InputError;
use sheetwork::scene::IntegratorKind;

use crate::bench::shard;
use crate::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
pub struct Drops {
    /// Number of sheets.
    #[arg(long, default_value = "10000")]
    count: u64,
    /// Run only every N-th draw from the I-th on, 1 to N.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Seed of the draws.
    #[arg(long, default_value = "0")]
    seed: u64,
    /// Number of the first draw.
    #[arg(long, default_value = "0")]
    first: u64,
    /// Implicit integrator.
    #[arg(long, default_value = "tr-bdf2")]
    engine: IntegratorKind,
    /// Folder for drops.csv, or drops-I-of-N.csv.
    #[arg(long, default_value = "sheetwork-out/drops")]
    out: PathBuf,
    #[command(flatten)]
    output: OutputFlags,
}

impl Drops {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let (which, of) = self.shard.unwrap_or((1, 1));
        let mine: Vec<u64> = (self.first..self.first + self.count).skip(which - 1).step_by(of).collect();
        let bar = self.output.bar(mine.len() as u64);
        let mut drops = Vec::with_capacity(mine.len());
        for index in mine {
            drops.push(throw(self.seed, index, self.engine)?);
            bar.inc(1);
        }
        bar.finish_and_clear();
        std::fs::create_dir_all(&self.out).map_err(|e| InputError::io(&self.out, &e))?;
        let name = if of == 1 { "drops.csv".to_owned() } else { format!("drops-{which}-of-{of}.csv") };
        let file = self.out.join(name);
        write_csv(&file, &drops)?;
        let failed = |d: &&Drop| d.unstable.is_some() || d.through.is_some();
        if self.output.json {
            print_json(&summary(&drops))?;
        } else {
            for drop in drops.iter().filter(failed) {
                let why = drop.unstable.iter().chain(&drop.through).cloned().collect::<Vec<_>>().join("; ");
                print_line(&format!("{}: {}: {why}", drop.index, drop.what))?;
            }
            let line = |(key, value): (&String, &Value)| print_line(&format!("{key:<24}  {value}"));
            object(summary(&drops)).iter().try_for_each(line)?;
            print_line(&file.display().to_string())?;
        }
        Ok(if drops.iter().any(|d| failed(&d)) { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }
}

fn summary(drops: &[Drop]) -> Value {
    let most = |of: fn(&Drop) -> f64| drops.iter().map(of).fold(0.0, f64::max);
    let count = |of: fn(&Drop) -> bool| drops.iter().filter(|d| of(d)).count();
    let mean = drops.iter().map(|d| d.step_ms).sum::<f64>() / drops.len().max(1) as f64;
    json!({
        "count": drops.len(),
        "unstable": count(|d| d.unstable.is_some()),
        "through": count(|d| d.through.is_some()),
        "reported_penetration": count(|d| d.penetrates.is_some()),
        "gained_energy": count(|d| d.energy_ratio > 1.001),
        "asleep_at_end": count(|d| d.asleep),
        "max_penetration_m": most(|d| d.penetration),
        "highest_energy_ratio": most(|d| d.energy_ratio),
        "cpu_ms_per_step": mean,
        "worst_mean_step_ms": most(|d| d.step_ms),
        "worst_step_ms": most(|d| d.worst_step_ms),
    })
}

fn write_csv(file: &Path, drops: &[Drop]) -> Result<(), InputError> {
    let failed = |e: csv::Error| InputError::new("out", format!("{}: {e}", file.display()));
    let mut writer = csv::Writer::from_path(file).map_err(failed)?;
    type Column = (&'static str, fn(&Drop) -> String);
    let columns: [Column; 11] = [
        ("index", |d| d.index.to_string()),
        ("what", |d| d.what.clone()),
        ("simulated_s", |d| d.simulated.to_string()),
        ("penetration_m", |d| d.penetration.to_string()),
        ("energy_ratio", |d| d.energy_ratio.to_string()),
        ("step_ms", |d| d.step_ms.to_string()),
        ("worst_step_ms", |d| d.worst_step_ms.to_string()),
        ("asleep", |d| d.asleep.to_string()),
        ("unstable", |d| d.unstable.clone().unwrap_or_default()),
        ("through", |d| d.through.clone().unwrap_or_default()),
        ("penetrates", |d| d.penetrates.clone().unwrap_or_default()),
    ];
    writer.write_record(columns.map(|c| c.0)).map_err(failed)?;
    for drop in drops {
        writer.write_record(columns.map(|c| (c.1)(drop))).map_err(failed)?;
    }
    writer.flush().map_err(|e| InputError::io(file, &e))
}
