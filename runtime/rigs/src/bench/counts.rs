//! `sheetwork bench counts`: instructions of a step with each feature off, enabled but unused, and
//! active.
//!
//! The program runs itself under callgrind, twice for each case with different numbers of steps;
//! the difference is the count of the additional steps. Unlike times, counts are reproducible: a
//! check against a file allows 1 %.

use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::sync::Arc;

use clap::Args;
use glam::DVec3;
use serde_json::{Map, Value, json};
use sheetwork::linear::InstructionSet;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::profiler::{Phase, StepObserver};
use sheetwork::scene::{
    BodySpec, IntegratorKind, MaterialChoice, PinSpec, Region, Scene, Shape, SheetSpec, WhenUnstable,
};
use sheetwork::{InputError, World};
use sheetwork_link::Link;
use sheetwork_link::link_place::LinkPlace;

use crate::bench::hot_box::{clamped_shell, hot_box};
use crate::bench::link::BenchedGame;
use crate::measure::body;
use crate::output::{OutputFlags, print_json, print_line};

/// Steps of the shorter run, and additional steps of the longer run.
const SHORT_RUN_STEPS: u32 = 4;
const EXTRA_STEPS: u32 = 16;
/// Additional steps of a sleeping world, whose steps take so few instructions that the difference
/// in set-up between two runs (up to 5000) would matter.
const EXTRA_STEPS_ASLEEP: u32 = 1600;
/// Build profile.
const BUILD: &str = if cfg!(debug_assertions) { "dev" } else { "release" };
/// Relative tolerance of a check.
const RELATIVE_TOLERANCE: f64 = 0.01;
/// Absolute tolerance of a check, instructions, for cases in which a single call exceeds the
/// relative tolerance.
const ABSOLUTE_TOLERANCE: f64 = 100.0;

#[derive(Args)]
pub struct Counts {
    /// Cases by name; all by default.
    cases: Vec<String>,
    /// Compare the counts with those of a file written by --renew, with a tolerance of 1 %.
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
    /// Write the counts to the file of --check in place of the comparison.
    #[arg(long)]
    renew: bool,
    #[command(flatten)]
    output: OutputFlags,
    /// Take this many steps of the case only: the run under callgrind.
    #[arg(long, hide = true)]
    steps: Option<u32>,
}

/// A case: a scene, and an action on its world before each step.
struct CountCase {
    name: &'static str,
    about: &'static str,
    scene: fn() -> Scene,
    sleep: bool,
    each: fn(&mut CountRig),
}

/// State of a case.
struct CountRig {
    game: BenchedGame,
    bytes: Vec<u8>,
    link: Option<Link>,
}

/// Exchange with a link without readers; no action where the link cannot be served.
fn exchange(rig: &mut CountRig) {
    if rig.link.is_none() {
        let name = format!("counts-{}", std::process::id());
        let place = LinkPlace::new(&name).ok();
        rig.link = place.and_then(|place| Link::new(&place, &rig.game.0).ok());
    }
    if let Some(link) = &mut rig.link {
        link.exchange(&mut rig.game, 0.0);
    }
}

const fn case(name: &'static str, about: &'static str, scene: fn() -> Scene) -> CountCase {
    CountCase { name, about, scene, sleep: false, each: |_| {} }
}

/// A case of the plain scene with an action before each step.
const fn acting(name: &'static str, about: &'static str, each: fn(&mut CountRig)) -> CountCase {
    CountCase { each, ..case(name, about, plain) }
}

/// The sheet lying on a floor.
fn on_floor() -> Scene {
    let mut scene = with(|s| s.pins.clear());
    scene.sheets[0].placement.position.y = 2.6e-4;
    scene.bodies.push(BodySpec::new(Shape::HalfSpace));
    scene
}

const CASES: &[CountCase] = &[
    case("plain", "a clamped shell of 21x21 masses falls: no feature", plain),
    case("plastic_unused", "it may yield, and does not", || with(|s| s.plastic = true)),
    case("tearing_unused", "it may tear, and does not", || with(|s| s.tearing = true)),
    case("bodies_far", "two bodies stand far away", || Scene {
        bodies: [5.0, 9.0].map(|x| body("", Shape::Ball(0.1), DVec3::X * x)).to_vec(),
        ..plain()
    }),
    case("no_self_contact", "sheets are told not to meet: a flat one does not look anyway", || {
        let mut scene = plain();
        scene.contact.sheets = false;
        scene
    }),
    case("room_20", "an oven that is off: nothing is warm", || {
        let oven = sheetwork::scene::OvenSpec { on: false, ..Default::default() };
        Scene { oven: Some(oven), ..plain() }
    }),
    case("room_60", "the whole room at 60 °C", || Scene { ambient_temperature: 60.0, ..plain() }),
    case("heater", "a heater of six faces above it", || Scene { heaters: vec![hot_box()], ..plain() }),
    case("creep", "it creeps", || with(|s| s.creep = true)),
    case("on_floor", "it lies on a floor", on_floor),
    CountCase { sleep: true, ..case("asleep", "it has been put to sleep on a floor", on_floor) },
    case("contained", "what is about to go unstable would be frozen", || {
        with(|s| s.when_unstable = WhenUnstable::Freeze)
    }),
    case("springs", "not a shell but trimm of 21x21x2 masses, and rk4: no feature", springs),
    case("springs_contained", "its step would be reduced", || {
        let mut scene = springs();
        scene.sheets[0].when_unstable = WhenUnstable::ReduceStep { parts: 64 };
        scene
    }),
    acting("snapshots", "a snapshot every step", |rig| rig.game.0.serialise_into(&mut rig.bytes)),
    acting("link_unread", "a link that nobody reads", exchange),
    acting("watched", "buckling is looked for", |rig| rig.game.0.set_buckling_detection(true)),
    acting("phases", "somebody is told which part of a step is under way", |rig| {
        rig.game.0.set_profiler(Some(Arc::new(NullObserver)));
    }),
];

/// A step observer without effect.
struct NullObserver;

impl StepObserver for NullObserver {
    fn begin(&self, _: Phase) {}

    fn end(&self, _: Phase) {}
}

fn springs() -> Scene {
    let sheet = SheetSpec {
        structure: StructureKind::Trimm,
        grid: (21, 2, 21),
        size: (0.25, 0.25),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::thesis()
    };
    Scene { engine: IntegratorKind::Rk4, dt: 1e-3, sheets: vec![sheet], ..Scene::default() }
}

fn plain() -> Scene {
    let sheets = vec![clamped_shell(21, MaterialChoice::Named("hips".into()))];
    Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, sheets, ..Scene::default() }
}

fn with(change: impl FnOnce(&mut SheetSpec)) -> Scene {
    let mut scene = plain();
    change(&mut scene.sheets[0]);
    scene
}

impl Counts {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let unknown = self.cases.iter().find(|n| CASES.iter().all(|c| c.name != n.as_str()));
        if let Some(name) = unknown {
            let names: Vec<&str> = CASES.iter().map(|c| c.name).collect();
            return Err(InputError::new("cases", format!("{name} is none of {}", names.join(", "))));
        }
        let chosen: Vec<&CountCase> =
            CASES.iter().filter(|c| self.cases.is_empty() || self.cases.iter().any(|n| n == c.name)).collect();
        if let Some(steps) = self.steps {
            return chosen.into_iter().try_for_each(|c| run(c, steps)).map(|()| ExitCode::SUCCESS);
        }
        if Command::new("valgrind").arg("--version").output().is_err() {
            print_line("skipped: valgrind, which counts instructions, is not installed")?;
            return Ok(ExitCode::SUCCESS);
        }
        let mut found = Map::new();
        let mut kernels = String::new();
        let bar = self.output.bar(chosen.len() as u64);
        for case in &chosen {
            let (less, with) = count_instructions(case.name, SHORT_RUN_STEPS)?;
            let more = if case.sleep { EXTRA_STEPS_ASLEEP } else { EXTRA_STEPS };
            let count = (count_instructions(case.name, SHORT_RUN_STEPS + more)?.0 - less) / f64::from(more);
            kernels = with;
            found.insert(case.name.to_owned(), json!(count));
            if !self.output.json {
                let plain = found.get("plain").and_then(Value::as_f64).unwrap_or(count);
                let line = format!(
                    "{:<16} {count:>12.0} {:>+8.2} %  {}",
                    case.name,
                    100.0 * (count / plain - 1.0),
                    case.about
                );
                bar.suspend(|| print_line(&line))?;
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        let missed = self.check_counts(&found, &kernels)?;
        if self.output.json {
            print_json(
                &json!({ "build": BUILD, "kernels": kernels, "instructions_per_step": found, "missed": missed }),
            )?;
        } else {
            missed.iter().try_for_each(|line| print_line(line))?;
        }
        Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// Deviations from the reference file. Counts depend on compiler, profile and vector
    /// instructions.
    fn check_counts(&self, found: &Map<String, Value>, kernels: &str) -> Result<Vec<String>, InputError> {
        let Some(file) = &self.check else { return Ok(Vec::new()) };
        let compiler = compiler();
        if self.renew {
            let all =
                json!({ "build": BUILD, "kernels": kernels, "compiler": compiler, "instructions_per_step": found });
            let text = serde_json::to_string_pretty(&all).map_err(|e| InputError::new("check", e.to_string()))?;
            std::fs::write(file, text + "\n").map_err(|e| InputError::io(file, &e))?;
            return Ok(Vec::new());
        }
        let text = std::fs::read_to_string(file).map_err(|e| InputError::io(file, &e))?;
        let wanted: Value =
            serde_json::from_str(&text).map_err(|e| InputError::new("check", e.to_string()).in_file(file))?;
        let own = [BUILD, kernels, &compiler];
        if ["build", "kernels", "compiler"].map(|key| wanted[key].as_str().unwrap_or_default()) != own {
            print_line(&format!(
                "not held to {}, which is not of a {BUILD} build with {kernels} by {compiler}",
                file.display()
            ))?;
            return Ok(Vec::new());
        }
        let off = found.iter().filter_map(|(name, count)| {
            let (count, wanted) = (count.as_f64()?, wanted["instructions_per_step"][name].as_f64()?);
            let change = count / wanted - 1.0;
            (change.abs() > RELATIVE_TOLERANCE && (count - wanted).abs() > ABSOLUTE_TOLERANCE)
                .then(|| format!("{name}: {count:.0}, {:+.2} % off {wanted:.0}", 100.0 * change))
        });
        Ok(off.collect())
    }
}

/// Version of the installed compiler, assumed to be that of the build.
fn compiler() -> String {
    let output = Command::new("rustc").arg("--version").output();
    output.map_or_else(|_| "no compiler".to_owned(), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
}

fn run(case: &CountCase, steps: u32) -> Result<(), InputError> {
    print_line(&format!("{:?}", InstructionSet::best()).to_lowercase())?;
    let mut world = World::new(&(case.scene)())?;
    world.set_sleep(case.sleep);
    if case.sleep {
        // Equal in both runs; counting starts after these steps.
        (0..60).for_each(|_| _ = world.step());
    }
    let mut rig = CountRig { game: BenchedGame(world), bytes: Vec::new(), link: None };
    for _ in 0..steps {
        (case.each)(&mut rig);
        rig.game.0.step();
    }
    Ok(())
}

/// Instructions of a run of `steps` steps, and its vector instruction set. Only the stepping thread
/// counts: the housekeeping thread of a link follows the clock, and under callgrind a step takes
/// long.
fn count_instructions(name: &str, steps: u32) -> Result<(f64, String), InputError> {
    let own = std::env::current_exe().map_err(|e| InputError::new("counts", e.to_string()))?;
    let folder = std::env::temp_dir().join(format!("sheetwork-counts-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|e| InputError::io(&folder, &e))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--separate-threads=yes"])
        .arg(format!("--callgrind-out-file={}", folder.join("thread").display()))
        .arg(own)
        .args(["bench", "counts", name, "--steps", &steps.to_string()])
        .output();
    // One file per thread, numbered from 01.
    let first = std::fs::read_to_string(folder.join("thread-01")).unwrap_or_default();
    let _ = std::fs::remove_dir_all(&folder);
    let output = output.map_err(|e| InputError::new("valgrind", e.to_string()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let count = first.lines().find_map(|l| l.strip_prefix("totals:")?.trim().parse::<f64>().ok());
    let kernels = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    count.map(|count| (count, kernels)).ok_or_else(|| {
        InputError::new("valgrind", format!("did not count: {}", said.lines().last().unwrap_or_default()))
    })
}
