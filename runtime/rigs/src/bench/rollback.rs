//! `sheetwork bench rollback`: bit-exact continuation of every scene of a folder from a snapshot,
//! and the cost of snapshots.
//!
//! Each scene is stepped, saved and stepped on. Then the same world restores the snapshot, a new
//! world of the scene restores it too, and both take the same steps. A scene passes when all states
//! are byte-identical; a state holds everything that a step depends on. Costs are medians of CPU
//! time.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    BodySpec, IntegratorKind, MaterialChoice, PinSpec, Placement, Region, Scene, Shape, SheetSpec, SpringLaw,
};
use sheetwork::{InputError, World, check_range};

use crate::bench::hot_box::shell;
use crate::bench::{files_of, shard};
use crate::measure::body;
use crate::output::{OutputFlags, print_json, print_line};

/// Repetitions of a cost measurement, and of a rollback.
const COST_REPETITIONS: usize = 201;
const ROLLBACK_REPETITIONS: usize = 31;
/// Length of a rollback, s: eight frames at 60 Hz.
const ROLLBACK_TIME: f64 = 8.0 / 60.0;

#[derive(Args)]
pub struct Rollback {
    /// Scenes by name; all of the folder by default.
    scenes: Vec<String>,
    /// Folder of the scenes.
    #[arg(long, default_value = "assets/scenes")]
    folder: PathBuf,
    /// Steps before the snapshot.
    #[arg(long, default_value_t = 100)]
    first: u32,
    /// Steps after the snapshot.
    #[arg(long, default_value_t = 600)]
    steps: u32,
    /// Run only every N-th scene from the I-th on, 1 to N.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Measure the cost of snapshots only.
    #[arg(long)]
    cost: bool,
    #[command(flatten)]
    output: OutputFlags,
}

impl Rollback {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--steps", f64::from(self.steps), 1.0, 1e9, "")?;
        if self.cost {
            return self.costs();
        }
        let names = if self.scenes.is_empty() { scenes_of(&self.folder)? } else { self.scenes.clone() };
        let (which, of) = self.shard.unwrap_or((1, 1));
        let names: Vec<&String> = names.iter().skip(which - 1).step_by(of).collect();
        let bar = self.output.bar(names.len() as u64);
        let (mut rows, mut passed) = (Vec::new(), 0);
        for name in names {
            let row = self.scene(name)?;
            passed += usize::from(row["equal"] == true);
            if !self.output.json {
                bar.suspend(|| {
                    print_line(&format!(
                        "{name:<20} {:>8} masses  {:>9} bytes  {}",
                        row["masses"].to_string(),
                        row["bytes"].to_string(),
                        if row["equal"] == true { "equal".into() } else { row["differs"].to_string() }
                    ))
                })?;
            }
            rows.push(row);
            bar.inc(1);
        }
        bar.finish_and_clear();
        let all = rows.len();
        let found = || json!({ "steps": self.steps, "scenes": rows, "equal": passed, "of": all });
        let text = || format!("{passed} of {all} scenes go on from a snapshot to the bit for {} steps", self.steps);
        self.output.print(found, text)?;
        Ok(if passed == all { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn scene(&self, name: &str) -> Result<Value, InputError> {
        let scene = Scene::load(&self.folder.join(format!("{name}.ron")))?;
        let mut world = World::new(&scene)?;
        (0..self.first).for_each(|_| _ = world.step());
        let saved = world.serialise();
        let masses: usize = world.sheets().iter().map(|s| s.node_count()).sum();
        let ends = self.run(&mut world);
        let mut fresh = World::new(&scene)?;
        let mut differs = None;
        for (what, world) in [("the same world", &mut world), ("a new world", &mut fresh)] {
            world.deserialise(&saved)?;
            let again = self.run(world);
            if differs.is_none() && again != ends {
                let at = ends.iter().zip(&again).position(|(a, b)| a != b).unwrap_or(0);
                differs = Some(format!("{what} differs within {} steps", (at + 1) * self.stride()));
            }
        }
        Ok(json!({
            "scene": name, "masses": masses, "bytes": saved.len(), "equal": differs.is_none(), "differs": differs,
        }))
    }

    fn stride(&self) -> usize {
        (self.steps as usize).div_ceil(20).max(1)
    }

    /// Steps a world and saves it at intervals.
    fn run(&self, world: &mut World) -> Vec<Vec<u8>> {
        let mut states = Vec::new();
        for step in 1..=self.steps as usize {
            world.step();
            if step.is_multiple_of(self.stride()) || step == self.steps as usize {
                states.push(world.serialise());
            }
        }
        states
    }

    fn costs(&self) -> Result<ExitCode, InputError> {
        let mut rows = Vec::new();
        for (name, scene, steps) in costly() {
            let mut world = World::new(&scene)?;
            world.set_sleep(false);
            (0..steps).for_each(|_| _ = world.step());
            let masses: usize = world.sheets().iter().map(|s| s.node_count()).sum();
            let mut bytes = Vec::new();
            let save = median(|| world.serialise_into(&mut bytes));
            let mut result = Ok(());
            let load = median(|| {
                if let Err(e) = world.deserialise(&bytes) {
                    result = Err(e);
                }
            });
            result?;
            let step = median(|| _ = world.step());
            let ticks = (ROLLBACK_TIME / scene.dt).round() as u32;
            let mut room = Vec::new();
            let again = median_of(ROLLBACK_REPETITIONS, || {
                // A snapshot at each step, as in a game that may have to roll back again.
                let _ = world.deserialise(&bytes);
                for _ in 0..ticks {
                    world.serialise_into(&mut room);
                    world.step();
                }
            });
            rows.push(json!({
                "case": name, "masses": masses, "bytes": bytes.len(), "bytes_per_mass": bytes.len() as f64 / masses as f64,
                "save_us": save, "load_us": load, "step_us": step, "again_ms": 1e-3 * again,
            }));
        }
        if self.output.json {
            print_json(&rows)?;
            return Ok(ExitCode::SUCCESS);
        }
        let head = ["case", "masses", "bytes", "a mass", "save µs", "load µs", "step µs", "8 frames again ms"];
        print_line(&format!(
            "{:<38} {:>7} {:>8} {:>7} {:>9} {:>9} {:>9} {:>18}",
            head[0], head[1], head[2], head[3], head[4], head[5], head[6], head[7]
        ))?;
        for row in rows {
            let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
            print_line(&format!(
                "{:<38} {:>7} {:>8} {:>7.1} {:>9.1} {:>9.1} {:>9.1} {:>18.2}",
                row["case"].as_str().unwrap_or_default(),
                row["masses"].to_string(),
                row["bytes"].to_string(),
                number("bytes_per_mass"),
                number("save_us"),
                number("load_us"),
                number("step_us"),
                number("again_ms")
            ))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Names of the scenes of a folder.
pub fn scenes_of(folder: &Path) -> Result<Vec<String>, InputError> {
    let files = files_of(folder, "ron")?;
    let mut names: Vec<String> = files.iter().filter_map(|p| Some(p.file_stem()?.to_str()?.to_owned())).collect();
    // Names without their extension have another order: `a-b` and `a`.
    names.sort();
    Ok(names)
}

/// Scenes of the cost measurement, with their steps.
fn costly() -> Vec<(&'static str, Scene, u32)> {
    let raised = |pins: Vec<PinSpec>| SheetSpec {
        pins,
        placement: Placement { position: glam::DVec3::new(0.0, 0.05, 0.0), ..Placement::default() },
        ..shell(21, 0.25, MaterialChoice::Named("hips".into()))
    };
    let of = |sheet: SheetSpec| Scene {
        engine: IntegratorKind::TrBdf2,
        dt: 1.0 / 60.0,
        sheets: vec![sheet],
        ..Scene::default()
    };
    let clamped = || raised(vec![PinSpec::clamped(Region::Left)]);
    let floor = || BodySpec::new(Shape::HalfSpace);
    let ball = || BodySpec { mass: Some(0.02), ..body("", Shape::Ball(0.02), glam::DVec3::Y * 0.12) };
    let lattice = SheetSpec { structure: StructureKind::Trimm, grid: (21, 2, 21), ..raised(Vec::new()) };
    let soft = SheetSpec {
        springs: SpringLaw::Uniform,
        material: MaterialChoice::Named("thesis".into()),
        damping: 0.1,
        ..lattice.clone()
    };
    vec![
        ("shell 21x21, clamped", of(clamped()), 40),
        ("shell 21x21, lying on a floor", Scene { bodies: vec![floor()], ..of(raised(Vec::new())) }, 60),
        ("shell 21x21, a ball falls on it", Scene { bodies: vec![floor(), ball()], ..of(clamped()) }, 40),
        ("shell 21x21, in a warm room", Scene { ambient_temperature: 60.0, ..of(clamped()) }, 40),
        ("shell 21x21, creeping", of(SheetSpec { creep: true, ..clamped() }), 40),
        ("TRiMM 21x2x21, implicit", of(lattice.clone()), 40),
        (
            "TRiMM 21x2x21 of the thesis, explicit",
            Scene { engine: IntegratorKind::EulerRichardson, dt: 2e-3, bodies: vec![floor()], ..of(soft) },
            100,
        ),
    ]
}

/// Median CPU time of `work`, µs.
fn median(work: impl FnMut()) -> f64 {
    median_of(COST_REPETITIONS, work)
}

/// Median CPU time of `work` over `count` repetitions, µs.
fn median_of(count: usize, mut work: impl FnMut()) -> f64 {
    let mut times = Vec::with_capacity(count);
    for _ in 0..count {
        let start = ProcessTime::now();
        work();
        times.push(1e6 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[count / 2]
}
