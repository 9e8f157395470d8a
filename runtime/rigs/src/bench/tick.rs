//! `sheetwork bench tick`: processor times of the steps of a scene, and of the same scene without
//! wind zones where it has some. The worlds are stepped in turn by one thread, so that other load
//! of the machine affects both equally. The viewpoint is the camera of the scene.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use cpu_time::ThreadTime;
use serde_json::{Value, json};
use sheetwork::scene::{Scene, library};
use sheetwork::{InputError, World, check_range};

use crate::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
pub struct Tick {
    /// Scene, by file or by name.
    scene: PathBuf,
    /// Number of steps.
    #[arg(long, default_value_t = 600)]
    steps: u32,
    #[command(flatten)]
    output: OutputFlags,
}

/// Processor times of the steps of a world, ms.
struct TickTimes {
    what: &'static str,
    world: World,
    times: Vec<f64>,
}

impl TickTimes {
    fn new(what: &'static str, scene: &Scene, steps: u32) -> Result<Self, InputError> {
        let mut world = World::new(scene)?;
        world.set_viewpoint(scene.camera.map(|camera| camera.eye))?;
        Ok(Self { what, world, times: Vec::with_capacity(steps as usize) })
    }

    fn step(&mut self) {
        let start = ThreadTime::now();
        self.world.step();
        self.times.push(1e3 * start.elapsed().as_secs_f64());
    }

    /// Median, 99 %, worst and mean, ms.
    fn row(mut self) -> Value {
        self.times.sort_by(f64::total_cmp);
        let count = self.times.len();
        let at = |part: f64| self.times.get(((count - 1) as f64 * part) as usize).copied().unwrap_or(0.0);
        json!({
            "scene": self.what,
            "sheets": self.world.sheets().len(),
            "steps": count,
            "median_ms": at(0.5),
            "p99_ms": at(0.99),
            "worst_ms": at(1.0),
            "mean_ms": self.times.iter().sum::<f64>() / count as f64,
        })
    }
}

impl Tick {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--steps", self.steps.into(), 1.0, 1e6, "steps")?;
        let scene = Scene::load(&library::find(Path::new(&self.scene)))?;
        let mut worlds = vec![TickTimes::new("as it is", &scene, self.steps)?];
        if !scene.wind_zones.is_empty() {
            let still = Scene { wind_zones: Vec::new(), ..scene };
            worlds.push(TickTimes::new("without wind zones", &still, self.steps)?);
        }
        for _ in 0..self.steps {
            worlds.iter_mut().for_each(TickTimes::step);
        }
        let rows: Vec<Value> = worlds.into_iter().map(TickTimes::row).collect();
        if self.output.json {
            print_json(&rows)?;
            return Ok(ExitCode::SUCCESS);
        }
        print_line("processor time of a step, ms                median     99 %    worst     mean")?;
        for row in &rows {
            let number = |key: &str| row[key].as_f64().unwrap_or(0.0);
            let [median, p99, worst, mean] = ["median_ms", "p99_ms", "worst_ms", "mean_ms"].map(number);
            let what = row["scene"].as_str().unwrap_or_default();
            print_line(&format!("{what:<40} {median:>9.2}{p99:>9.2}{worst:>9.2}{mean:>9.2}"))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
