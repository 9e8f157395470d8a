//! `sheetwork bench scenes`: random scenes over all features of a scene, each run for a while. A
//! scene must not panic or hold a non-finite number, and instabilities are counted. Seed and number
//! determine the scene; the text of failing scenes is written to a folder.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use cpu_time::ProcessTime;
use glam::DVec3;
use serde_json::json;
use sheetwork::integrators::TABLE as ENGINES;
use sheetwork::islands::event::EventKind;
use sheetwork::mesh::structure::{StructureKind, TABLE as STRUCTURES};
use sheetwork::scene::{
    Air, BodySpec, HeatGunSpec, Material, MaterialChoice, OvenSpec, PathKey, PinSpec, Placement, Region, Room, Scene,
    Shape, SheetSpec, SpringLaw, WhenUnstable,
};
use sheetwork::sheet::Status;
use sheetwork::{InputError, World, check_range};

use crate::bench::shard;
use crate::measure::random_sequence::SplitMix64;
use crate::output::{OutputFlags, print_line};
use crate::quantities::time;

#[derive(Args)]
pub struct Scenes {
    /// Number of scenes.
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// Simulated time of each scene, s.
    #[arg(long, default_value = "1", value_parser = time)]
    seconds: f64,
    /// Maximum number of nodes along a side of a sheet; fewer make scenes cheaper.
    #[arg(long, default_value_t = 11, value_name = "N")]
    side: u32,
    /// CPU time after which a scene is cut short, s.
    #[arg(long, default_value = "20", value_parser = time)]
    patience: f64,
    /// Run only every N-th draw from the I-th on, 1 to N.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Seed of the draws.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of the first draw.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Recovery policy of every sheet. The default is a random one other than `stop`.
    #[arg(long, value_name = "POLICY")]
    when_unstable: Option<WhenUnstable>,
    /// Folder for the scenes that panicked, became unstable or were cut short.
    #[arg(long, default_value = "sheetwork-out/scenes")]
    out: PathBuf,
    #[command(flatten)]
    output: OutputFlags,
}

/// Recovery policies to draw from.
const POLICIES: [WhenUnstable; 4] = [
    WhenUnstable::ReduceStep { parts: 64 },
    WhenUnstable::Implicit,
    WhenUnstable::Freeze,
    WhenUnstable::Limit { strain: 0.1 },
];

/// Outcome of a scene.
#[derive(Clone, Copy)]
enum SceneOutcome {
    Well,
    Contained,
    Frozen,
    Gained,
    Short,
    Refused,
    Unstable,
    Broken,
}

/// JSON keys of the outcomes.
const OUTCOMES: [&str; 8] =
    ["well", "contained", "frozen", "gained_energy", "cut_short", "refused", "unstable", "broken"];

impl Scenes {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--seconds", self.seconds, 1e-3, 1e6, "s")?;
        check_range("--side", f64::from(self.side), 3.0, 101.0, "masses")?;
        let (which, of) = self.shard.unwrap_or((1, 1));
        let mine: Vec<u64> = (self.first..self.first + self.count).skip(which - 1).step_by(of).collect();
        let bar = self.output.bar(mine.len() as u64);
        let mut counts = [0_u64; OUTCOMES.len()];
        let count = mine.len();
        std::panic::set_hook(Box::new(|_| {}));
        for index in mine {
            let mut draws = SplitMix64::new(self.seed, index);
            let mut scene = drawn(&mut draws, self.side);
            for sheet in &mut scene.sheets {
                sheet.when_unstable = self.when_unstable.unwrap_or_else(|| *draws.pick(&POLICIES));
            }
            let end = catch_unwind(AssertUnwindSafe(|| self.run(&scene)));
            let (outcome, why) = end.unwrap_or((SceneOutcome::Broken, Some("panicked".to_owned())));
            counts[outcome as usize] += 1;
            if let Some(why) = why {
                std::fs::create_dir_all(&self.out).map_err(|e| InputError::io(&self.out, &e))?;
                let file = self.out.join(format!("{}-{index}.ron", self.seed));
                std::fs::write(&file, scene.to_text()?).map_err(|e| InputError::io(&file, &e))?;
                if !self.output.json {
                    bar.suspend(|| print_line(&format!("{index}: {why}  ({})", file.display())))?;
                }
            }
            bar.inc(1);
        }
        let _ = std::panic::take_hook();
        bar.finish_and_clear();
        let mut summary = json!({ "scenes": count });
        OUTCOMES.iter().zip(counts).for_each(|(key, count)| summary[key] = count.into());
        self.output.print(|| &summary, || summary.to_string())?;
        let failed = counts[SceneOutcome::Broken as usize] + counts[SceneOutcome::Unstable as usize];
        Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn run(&self, scene: &Scene) -> (SceneOutcome, Option<String>) {
        // Round trip through text, as from a file.
        let again = scene.to_text().and_then(|text| Ok(Scene::parse(&text)?));
        let mut world = match again.and_then(|scene| Ok(World::new(&scene)?)) {
            Ok(world) => world,
            Err(e) => return (SceneOutcome::Refused, Some(e.to_string())),
        };
        let most = ENERGY_ERROR_FACTOR * available_energy(&world, self.seconds);
        let start = ProcessTime::now();
        while world.time() < self.seconds - 0.5 * world.dt() {
            world.step();
            for sheet in world.sheets() {
                let energy = sheet.energy(DVec3::ZERO);
                let own = energy.kinetic + energy.elastic;
                if own > most {
                    let why = format!("{} has {own:.3e} J at {:.4} s, of {most:.3e}", sheet.name, world.time());
                    return (SceneOutcome::Gained, Some(why));
                }
            }
            if start.elapsed().as_secs_f64() > self.patience {
                return (SceneOutcome::Short, Some(format!("cut short at {:.3} s", world.time())));
            }
        }
        let is_sound = |s: &sheetwork::sheet::Sheet| s.state.x.iter().chain(s.state.v.iter()).all(DVec3::is_finite);
        if let Some(sheet) = world.sheets().iter().find(|s| !is_sound(s)) {
            return (SceneOutcome::Broken, Some(format!("{} holds what is no number", sheet.name)));
        }
        if let Some(sheet) = world.unstable() {
            let Status::Unstable { time, speed, .. } = sheet.state.status else { return (SceneOutcome::Well, None) };
            let of = sheet.model.structure;
            let why = format!("{} ({of}) unstable at {time:.4} s, {speed:.3e} m/s", sheet.name);
            return (SceneOutcome::Unstable, Some(why));
        }
        let is_frozen = world.sheets().iter().any(|s| matches!(s.state.status, Status::Frozen { .. }));
        let outcome = match world.events().iter().any(|e| e.kind == EventKind::Contained) {
            _ if is_frozen => SceneOutcome::Frozen,
            true => SceneOutcome::Contained,
            false => SceneOutcome::Well,
        };
        (outcome, None)
    }
}

/// Kinetic plus elastic energy of a sheet that counts as an energy error, as a factor on
/// [`available_energy`]. Random scenes may start with interpenetration, whose depenetration
/// releases up to this energy.
const ENERGY_ERROR_FACTOR: f64 = 100.0;
/// Assumed speed of kinematic bodies and nodes, m/s.
const KINEMATIC_SPEED: f64 = 3.0;

/// Energy (J) available to a sheet: initial energy, a fall of `seconds`, wind, and kinematic
/// motion.
fn available_energy(world: &World, seconds: f64) -> f64 {
    let g = world.gravity().length();
    let sheets: f64 = world.sheets().iter().map(sheetwork::sheet::Sheet::total_mass).sum();
    let there: f64 = world.sheets().iter().map(|s| s.energy(DVec3::ZERO)).map(|e| e.kinetic + e.elastic).sum();
    let states = || world.rigid().into_iter().flat_map(|r| (0..r.bodies().len()).filter_map(|i| r.state(i)));
    let gives = states().filter(|b| b.mass().is_finite());
    let (bodies, moving) = gives.fold((0.0, 0.0), |(m, e), b| (m + b.mass(), e + b.kinetic_energy()));
    let fastest = states().map(|b| b.velocity().length_squared()).fold(KINEMATIC_SPEED * KINEMATIC_SPEED, f64::max);
    let fall = g * (1.0 + 0.5 * g * seconds * seconds);
    there + moving + (sheets + bodies) * fall + sheets * (fastest + world.air().wind.length_squared())
}

/// A random scene: one to three sheets of at most `side` nodes along a side, bodies, air and heat,
/// with an integrator and a step that suit its sheets.
fn drawn(draws: &mut SplitMix64, side: u32) -> Scene {
    // Explicit integrators get soft sheets; their step may be unstable.
    let implicit = !draws.once_in(4);
    let engines: Vec<_> = ENGINES.iter().filter(|e| e.implicit == implicit && !e.adaptive).collect();
    let engine = draws.pick(&engines).kind;
    let mut scene = Scene {
        engine,
        dt: if implicit { draws.scale(2e-3, 1.0 / 30.0) } else { draws.scale(5e-5, 1e-3) },
        gravity: DVec3::new(0.0, -draws.within(0.0, 15.0), 0.0),
        ..Scene::default()
    };
    for index in 0..1 + draws.below(5) / 2 {
        let mut sheet = sheet(draws, implicit, side);
        sheet.name = format!("sheet {index}");
        sheet.placement.position += DVec3::new(0.0, 0.35 * index as f64, 0.0);
        scene.sheets.push(sheet);
    }
    if !draws.once_in(3) {
        let (x, z) = ((-2.0, 2.0), (-2.0, 2.0));
        scene.room = Some(Room { x, y: (-0.1, 2.0), z, back_wall: draws.once_in(3), grid: 0.1 });
    }
    for _ in 0..draws.below(3) {
        scene.bodies.push(body(draws));
    }
    if draws.once_in(3) {
        scene.air = Air { density: draws.within(0.5, 2.0), wind: draws.place(3.0), ..Air::default() };
    }
    if draws.once_in(6) {
        scene.oven = Some(OvenSpec { temperature: draws.within(0.0, 250.0), ..OvenSpec::default() });
        scene.time_lapse = draws.scale(1.0, 100.0);
    }
    if draws.once_in(10) {
        scene.heat_gun = Some(HeatGunSpec { position: draws.place(0.2), ..HeatGunSpec::default() });
    }
    scene
}

fn sheet(draws: &mut SplitMix64, implicit: bool, most: u32) -> SheetSpec {
    let row = if draws.once_in(2) { StructureKind::Shell } else { draws.pick(STRUCTURES).kind };
    let shell = row == StructureKind::Shell;
    let layers = if shell || row == StructureKind::Provot2d { 1 } else { 2 };
    let side = |draws: &mut SplitMix64| 3 + draws.below(most as usize - 2) as u32;
    let names = ["hips", "pet", "paper", "card", "pvc"];
    let material = if implicit {
        match draws.below(3) {
            0 => MaterialChoice::Named((*draws.pick(&names)).to_owned()),
            _ => MaterialChoice::Inline(Material {
                young: draws.scale(1e5, 1e11),
                poisson: draws.within(0.0, 0.45),
                density: draws.scale(100.0, 8000.0),
                thickness: draws.scale(5e-5, 2e-3),
                tears_at: Some(draws.scale(1e-3, 0.1)),
                ..Material::default()
            }),
        }
    } else {
        MaterialChoice::Inline(Material { young: draws.scale(50.0, 2e5), ..Material::default() })
    };
    let springs = if shell || draws.once_in(2) { SpringLaw::Calibrated } else { SpringLaw::Uniform };
    let pins = match draws.below(5) {
        0 => vec![PinSpec::clamped(Region::Left)],
        1 => vec![PinSpec::fixed(Region::Point(0.0, 0.0)), PinSpec::fixed(Region::Point(1.0, 0.0))],
        2 => vec![PinSpec {
            path: vec![PathKey::default(), PathKey { time: 1.0, offset: draws.place(0.2), ..PathKey::default() }],
            ..PinSpec::fixed(Region::Right)
        }],
        _ => Vec::new(),
    };
    let named = matches!(material, MaterialChoice::Named(_));
    let made = material.resolve(std::path::Path::new("")).ok();
    let flows = made.as_ref().is_some_and(|m| m.burgers.is_some());
    let tears = made.as_ref().is_some_and(|m| m.tears_at.is_some() || m.melts_at.is_some());
    SheetSpec {
        structure: row,
        springs: if implicit { springs } else { SpringLaw::Uniform },
        grid: (side(draws), layers, side(draws)),
        size: (draws.scale(0.03, 0.5), draws.scale(0.03, 0.5)),
        material,
        damping: draws.within(0.0, 0.3),
        placement: Placement { position: DVec3::new(0.0, draws.within(0.0, 0.3), 0.0), rotation: draws.place(180.0) },
        velocity: draws.place(2.0),
        spin: draws.place(5.0),
        creep: draws.once_in(3) && flows,
        plastic: draws.once_in(4) && shell && named,
        tearing: draws.once_in(4) && tears && !row.info().triangular,
        temperature: draws.once_in(6).then(|| draws.within(-20.0, 200.0)),
        pins,
        ..SheetSpec::default()
    }
}

fn body(draws: &mut SplitMix64) -> BodySpec {
    let shape = match draws.below(2) {
        0 => Shape::Ball(draws.scale(0.01, 0.2)),
        _ => Shape::Box(DVec3::new(draws.scale(0.01, 0.3), draws.scale(0.01, 0.3), draws.scale(0.01, 0.3))),
    };
    let mut body = BodySpec::new(shape);
    body.placement = Placement { position: draws.place(0.4), rotation: draws.place(180.0) };
    match draws.below(3) {
        0 => body.density = Some(draws.scale(50.0, 8000.0)),
        1 => {
            body.path =
                vec![PathKey::default(), PathKey { time: 1.0, offset: draws.place(0.5), rotation: draws.place(90.0) }]
        }
        _ => {}
    }
    if draws.once_in(6) {
        body.temperature = Some(draws.within(-20.0, 250.0));
    }
    body
}
