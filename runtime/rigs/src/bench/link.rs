//! `sheetwork bench link`: cost of the live link for the game, and latency of a frame for another
//! process.
//!
//! A world with the given number of nodes is stepped in real time and published. The cost is that
//! of [`Link::exchange`] alone: polling for commands (`look`), and publishing. Another process of
//! this program reads and measures the time from the writing of a frame to its arrival; it polls
//! every 50 µs, as all readers do, or continuously (`--spin`).

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};
use sheetwork::scene::{Scene, SheetSpec};
use sheetwork::{InputError, World, check_range};
use sheetwork_link::link_place::{LinkPlace, ROOT_VARIABLE};
use sheetwork_link::{Client, Host, Link, monotonic_ns};

use crate::output::{OutputFlags, print_json, print_line};
use crate::quantities::{parse_number, time};

#[derive(Args)]
pub struct LinkBench {
    /// Number of nodes of the sheet.
    #[arg(long, default_value_t = 20_000)]
    vertices: u32,
    /// Frames per second.
    #[arg(long, default_value = "240", value_parser = parse_number)]
    rate: f64,
    /// Duration of each part, s.
    #[arg(long, default_value = "5", value_parser = time)]
    seconds: f64,
    /// Let the reader poll continuously.
    #[arg(long)]
    spin: bool,
    #[command(flatten)]
    output: OutputFlags,
    /// Role of a reader process, of frames or of fields.
    #[arg(long, hide = true)]
    reader: Option<String>,
}

/// A world that only the benchmark steps.
pub(crate) struct BenchedGame(pub(crate) World);

impl Host for BenchedGame {
    fn world(&self) -> &World {
        &self.0
    }

    fn world_mut(&mut self) -> &mut World {
        &mut self.0
    }

    fn playing(&self) -> bool {
        true
    }

    fn play(&mut self, _playing: bool) -> Result<(), InputError> {
        Ok(())
    }

    fn load(&mut self, _file: &Path) -> Result<(), InputError> {
        Err(InputError::new("load", "not in a benchmark"))
    }
}

impl LinkBench {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--vertices", f64::from(self.vertices), 4.0, 1e6, "")?;
        check_range("--rate", self.rate, 1.0, 1e5, "1/s")?;
        check_range("--seconds", self.seconds, 0.1, 1e4, "s")?;
        if let Some(what) = &self.reader {
            return self.read(what == "fields");
        }
        let root = std::env::temp_dir().join(format!("sheetwork-bench-link-{}", std::process::id()));
        let result = self.measure(&root);
        let _ = std::fs::remove_dir_all(&root);
        let result = result?;
        if self.output.json {
            print_json(&result)?;
            return Ok(ExitCode::SUCCESS);
        }
        print_line(&format!(
            "{} masses, {} Hz; µs: a tenth below, median, 99 % below, most",
            result["vertices"], self.rate
        ))?;
        let line = |key: &str, what: &str| {
            let part = |p: &str| format!("{:>10.2}", result[key][what][p].as_f64().unwrap_or(f64::NAN));
            let all = ["p10_us", "median_us", "p99_us", "max_us"].map(part).concat();
            print_line(&format!("{key:<8} {what:<8}{all}"))
        };
        line("nobody", "look")?;
        line("nobody", "publish")?;
        line("nobody", "both")?;
        print_line(&format!("nobody, again    {:>11.2}", result["nobody"]["again_us"].as_f64().unwrap_or(f64::NAN)))?;
        for key in ["frames", "fields"] {
            line(key, "look")?;
            line(key, "publish")?;
            line(key, "both")?;
            line(key, "latency")?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn measure(&self, root: &Path) -> Result<Value, InputError> {
        let across = (f64::from(self.vertices) / 2.0).sqrt().round().max(2.0) as u32;
        let grid = ((self.vertices / across).max(2), 1, across);
        let sheet = SheetSpec { name: "sheet".into(), grid, size: (2.0, 1.0), ..SheetSpec::thesis() };
        let scene = Scene { sheets: vec![sheet], dt: 1.0 / self.rate, ..Scene::thesis() };
        let mut game = BenchedGame(World::new(&scene)?);
        let place = LinkPlace::within(root, "bench")?;
        let mut link = Link::new(&place, &game.0)?;
        let nobody = self.measure_part(&mut game, &mut link);
        let calls = 20_000;
        let start = Instant::now();
        (0..calls).for_each(|_| link.exchange(&mut game, 0.0));
        let again_us = 1e6 * start.elapsed().as_secs_f64() / f64::from(calls);
        let mut result = json!({ "vertices": game.0.sheets()[0].node_count(), "rate_hz": self.rate, "nobody": nobody });
        result["nobody"]["again_us"] = again_us.into();
        for what in ["frames", "fields"] {
            let reader = self.start(root, what)?;
            let start = Instant::now();
            while link.statistics().readers.iter().all(|n| *n == 0) && start.elapsed() < Duration::from_secs(10) {
                link.exchange(&mut game, 0.0);
                std::thread::sleep(Duration::from_millis(1));
            }
            let took = self.measure_part(&mut game, &mut link);
            let out = reader.wait_with_output().map_err(|e| InputError::new("reader", e.to_string()))?;
            let latency: Value = serde_json::from_slice(&out.stdout).unwrap_or_default();
            result[what] = took;
            result[what]["latency"] = latency;
        }
        Ok(result)
    }

    /// Steps in real time and measures the exchanges.
    fn measure_part(&self, game: &mut BenchedGame, link: &mut Link) -> Value {
        let (start, mut due) = (Instant::now(), Duration::ZERO);
        let mut took = [Vec::new(), Vec::new(), Vec::new()];
        while start.elapsed().as_secs_f64() < self.seconds {
            game.0.step();
            // The sequence of `Link::exchange`.
            let now = Instant::now();
            link.answer(game);
            let between = Instant::now();
            link.publish(&game.0, 0.0, true);
            let end = Instant::now();
            for (list, (from, to)) in took.iter_mut().zip([(now, between), (between, end), (now, end)]) {
                list.push((to - from).as_secs_f64());
            }
            due += Duration::from_secs_f64(1.0 / self.rate);
            std::thread::sleep(due.saturating_sub(start.elapsed()));
        }
        let [look, publish, both] = took.map(summary);
        json!({ "look": look, "publish": publish, "both": both })
    }

    fn start(&self, root: &Path, what: &str) -> Result<Child, InputError> {
        let program = std::env::current_exe().map_err(|e| InputError::new("reader", e.to_string()))?;
        let mut command = Command::new(program);
        // The reader ends before the game.
        let seconds = (0.8 * self.seconds).to_string();
        command.args(["bench", "link", "--reader", what, "--seconds", &seconds]).env(ROOT_VARIABLE, root);
        if self.spin {
            command.arg("--spin");
        }
        command.stdout(Stdio::piped()).spawn().map_err(|e| InputError::new("reader", e.to_string()))
    }

    /// Runs the reader.
    fn read(&self, complete: bool) -> Result<ExitCode, InputError> {
        let client = Client::attach(&LinkPlace::new("bench")?)?;
        let mut frames = client.frames(complete)?;
        let (start, mut late) = (Instant::now(), Vec::new());
        while start.elapsed().as_secs_f64() < self.seconds {
            match frames.next()? {
                Some(frame) => late.push(1e-9 * monotonic_ns().saturating_sub(frame.header().written_at) as f64),
                None if self.spin => std::hint::spin_loop(),
                None => std::thread::sleep(Duration::from_micros(50)),
            }
        }
        let mut result = summary(late);
        result["missed"] = frames.missed().into();
        let _ = write!(std::io::stdout(), "{result}");
        Ok(ExitCode::SUCCESS)
    }
}

/// Tenth percentile, median, 99th percentile and maximum of times in s, as µs.
fn summary(mut times: Vec<f64>) -> Value {
    times.sort_by(f64::total_cmp);
    let at = |part: f64| {
        times.get(((times.len() as f64 * part) as usize).min(times.len().saturating_sub(1))).map(|t| 1e6 * t)
    };
    json!({ "count": times.len(), "p10_us": at(0.1), "median_us": at(0.5), "p99_us": at(0.99), "max_us": at(1.0) })
}
