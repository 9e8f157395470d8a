//! `sheetwork bench fuzz`: damaged input of every kind.
//!
//! Inputs are mutations of valid ones: the shipped files, a small world's snapshot, recording,
//! journal and frames, and the corpus. Mutations know numbers, fragments of the formats and, for
//! formats with checksums, the repair of checksums. The seed determines the inputs. An input that
//! panics, or takes longer than ten seconds of CPU time, is written to the folder `--out`.

pub(crate) mod mutate;
pub(crate) mod readers;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;

use clap::Args;
use cpu_time::ProcessTime;
use serde_json::json;
use sheetwork::{InputError, check_range};

use crate::bench::fuzz::mutate::mutate;
use crate::bench::fuzz::readers::{FuzzedReader, READERS};
use crate::bench::{read_files, shard};
use crate::measure::random_sequence::SplitMix64;
use crate::output::{OutputFlags, print_json, print_line};

/// CPU time above which an input counts as a fault, s.
const CPU_TIME_LIMIT: f64 = 10.0;

#[derive(Args)]
pub struct Fuzz {
    /// Reader, by name; all by default: scene, sht, pol, heater, material, snapshot, recording,
    /// journal, link.
    #[arg(long)]
    reader: Option<String>,
    /// Number of inputs for each reader.
    #[arg(long, default_value_t = 10_000)]
    count: u64,
    /// Run only every N-th input from the I-th on, 1 to N.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Seed of the mutations.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder with a subfolder of inputs for each reader. The default is tests/corpus, if it
    /// exists.
    #[arg(long)]
    corpus: Option<PathBuf>,
    /// Folder of the shipped files.
    #[arg(long, default_value = "assets")]
    assets: PathBuf,
    /// Folder for inputs that panic or exceed the CPU time limit.
    #[arg(long, default_value = "sheetwork-out/fuzz")]
    out: PathBuf,
    #[command(flatten)]
    output: OutputFlags,
}

/// Message and location of the last panic.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

impl Fuzz {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let chosen: Vec<&FuzzedReader> =
            READERS.iter().filter(|r| self.reader.as_ref().is_none_or(|name| name == r.name)).collect();
        if chosen.is_empty() {
            let names: Vec<&str> = READERS.iter().map(|r| r.name).collect();
            let wanted = self.reader.unwrap_or_default();
            let problem = format!("no reader \"{wanted}\"; there are {}", names.join(", "));
            return Err(InputError::new("--reader", problem));
        }
        check_range("--count", self.count as f64, 1.0, 1e12, "")?;
        if let Some(folder) = self.corpus.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(InputError::new("--corpus", format!("there is no folder {}", folder.display())));
        }
        std::panic::set_hook(Box::new(|info| {
            if let Ok(mut said) = LAST_PANIC.lock() {
                *said = info.to_string().replace('\n', ": ");
            }
        }));
        let (mut rows, mut faults) = (Vec::new(), 0);
        for reader in chosen {
            let row = self.fuzz_reader(reader)?;
            faults += row["faults"].as_array().map_or(0, Vec::len);
            if !self.output.json {
                print_line(&format!(
                    "{:<10} {:>9} inputs, {:>9} read, {:>9} refused, slowest {:.3} s",
                    reader.name,
                    row["inputs"].to_string(),
                    row["read"].to_string(),
                    row["refused"].to_string(),
                    row["slowest_s"].as_f64().unwrap_or(0.0)
                ))?;
                for fault in row["faults"].as_array().into_iter().flatten() {
                    print_line(&format!("    {}", fault.as_str().unwrap_or_default()))?;
                }
            }
            rows.push(row);
        }
        let _ = std::panic::take_hook();
        if self.output.json {
            print_json(&rows)?;
        }
        Ok(if faults == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn fuzz_reader(&self, reader: &FuzzedReader) -> Result<serde_json::Value, InputError> {
        let mut seeds = (reader.seeds)(&self.assets)?;
        let kept = self.corpus.as_deref().unwrap_or(Path::new("tests/corpus"));
        seeds.extend(corpus(&kept.join(reader.name))?);
        let mut tried = (reader.make)()?;
        let (which, of) = self.shard.unwrap_or((1, 1));
        let bar = self.output.bar(self.count);
        let (mut read, mut refused, mut slowest, mut faults) = (0_u64, 0_u64, 0.0_f64, Vec::new());
        // Inputs of the corpus come first, unchanged.
        for number in 0..self.count {
            if number as usize % of != which - 1 {
                continue;
            }
            let input = match seeds.get(number as usize) {
                Some(seed) => seed.clone(),
                None => mutate(&seeds, reader, &mut SplitMix64::new(self.seed, number)),
            };
            let start = ProcessTime::now();
            let done = catch_unwind(AssertUnwindSafe(|| tried(&input)));
            let taken = start.elapsed().as_secs_f64();
            slowest = slowest.max(taken);
            match done {
                Ok(true) => read += 1,
                Ok(false) => refused += 1,
                Err(_) => {
                    // A panic may leave the reader's state invalid.
                    tried = (reader.make)()?;
                }
            }
            if done.is_err() || taken > CPU_TIME_LIMIT {
                let file = self.write_input(reader.name, number, &input)?;
                let said = LAST_PANIC.lock().map(|said| said.clone()).unwrap_or_default();
                let what = if done.is_err() { said } else { format!("took {taken:.2} s") };
                faults.push(format!("{}: {what}", file.display()));
            }
            if number % 256 == 0 {
                bar.set_position(number);
            }
        }
        bar.finish_and_clear();
        Ok(json!({
            "reader": reader.name, "inputs": read + refused + faults.len() as u64, "read": read, "refused": refused,
            "slowest_s": slowest, "faults": faults,
        }))
    }

    fn write_input(&self, reader: &str, number: u64, input: &[u8]) -> Result<PathBuf, InputError> {
        let folder = self.out.join(reader);
        std::fs::create_dir_all(&folder).map_err(|e| InputError::io(&folder, &e))?;
        let file = folder.join(format!("{}-{number}", self.seed));
        std::fs::write(&file, input).map_err(|e| InputError::io(&file, &e))?;
        Ok(file)
    }
}

/// Files of a folder, by name; empty without such a folder.
fn corpus(folder: &Path) -> Result<Vec<Vec<u8>>, InputError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(Vec::new()) };
    read_files(entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_file()).collect())
}
