//! Virtual test rigs: a sheet in a situation with a known answer, and what it did.
//!
//! Each case is one file with one row in [`TABLE`]. `sheetwork measure CASE` runs them; tests hold their numbers. CPU time is
//! that of the stepping alone, set-up apart.

mod bounce;
mod free_fall;
mod incline;
pub mod oscillator;
mod slide;
mod spin;

use cpu_time::ProcessTime;
use glam::DVec3;
use serde_json::{Map, Value, json};

use crate::World;
use crate::engine::EngineKind;
use crate::error::{InputError, check_range};
use crate::lattice::StructureKind;
use crate::scene::{
    Air, BodySpec, ContactDefaults, Material, MaterialChoice, Placement, Scene, Shape, SheetSpec, SpringLaw,
};

/// A case: what is measured, and how.
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// One line on what it does.
    pub about: &'static str,
    pub(crate) run: fn(&Setup) -> Result<Outcome, InputError>,
}

/// Every case, in the order they are listed.
pub const TABLE: &[Case] = &[bounce::CASE, free_fall::CASE, incline::CASE, oscillator::CASE, slide::CASE, spin::CASE];

/// The sheet and the situation; every case takes what it needs of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Structure of the sheet.
    pub structure: StructureKind,
    /// Masses along length and width of the bottom layer, 2 to 2000 each.
    pub grid: (u32, u32),
    /// Layers, where the structure can have them.
    pub layers: u32,
    /// Engine.
    pub engine: EngineKind,
    /// Step, s, 1e-7 to 1; `None` for one that is stable for the engine on this sheet.
    pub dt: Option<f64>,
    /// Material: modulus, density, thickness.
    pub material: Material,
    /// Length of the sheet, m, 1e-4 to 100.
    pub length: f64,
    /// Width of the sheet, m, 1e-4 to 100.
    pub width: f64,
    /// Gravity downwards, m/s², 0 to 1000.
    pub gravity: f64,
    /// Dashpots of the springs, fraction of critical, 0 to 10.
    pub damping_ratio: f64,
    /// Angle of an incline, degrees, 0 to 89.
    pub angle: f64,
    /// Friction coefficient, 0 to 10.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1.
    pub restitution: f64,
    /// Height of a drop, m, 1e-3 to 1000.
    pub height: f64,
    /// Speed of a slide, m/s, 1e-3 to 100.
    pub speed: f64,
    /// Rate of a spin, rad/s, 1e-3 to 1000.
    pub rate: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            structure: StructureKind::Trimm,
            grid: (21, 21),
            layers: 2,
            engine: EngineKind::Verlet,
            dt: None,
            material: Material { young: 3e9, poisson: 0.35, density: 1050.0, thickness: 5e-4, ..Material::default() },
            length: 0.25,
            width: 0.25,
            gravity: 9.81,
            damping_ratio: 0.05,
            angle: 20.0,
            friction: 0.3,
            restitution: 0.5,
            height: 0.2,
            speed: 1.0,
            rate: 10.0,
        }
    }
}

impl Setup {
    /// Checks every value.
    ///
    /// # Errors
    /// The first that is out of range, named as its flag.
    pub fn check(&self) -> Result<(), InputError> {
        check_range("grid", self.grid.0.into(), 2.0, 2000.0, "masses")?;
        check_range("grid", self.grid.1.into(), 2.0, 2000.0, "masses")?;
        let (fewest, most) = self.structure.info().layers;
        check_range("layers", self.layers.into(), fewest.into(), most.into(), "layers")?;
        if let Some(dt) = self.dt {
            check_range("dt", dt, 1e-7, 1.0, "s")?;
        }
        crate::scene::validate::material("material", &self.material)?;
        check_range("length", self.length, 1e-4, 100.0, "m")?;
        check_range("width", self.width, 1e-4, 100.0, "m")?;
        check_range("gravity", self.gravity, 0.0, 1e3, "m/s²")?;
        check_range("damping-ratio", self.damping_ratio, 0.0, 10.0, "of critical")?;
        check_range("angle", self.angle, 0.0, 89.0, "degrees")?;
        check_range("friction", self.friction, 0.0, 10.0, "")?;
        check_range("restitution", self.restitution, 0.0, 1.0, "")?;
        check_range("height", self.height, 1e-3, 1e3, "m")?;
        check_range("speed", self.speed, 1e-3, 100.0, "m/s")?;
        check_range("rate", self.rate, 1e-3, 1e3, "rad/s")
    }

    /// Grid and width as built: TRiMM is isotropic only with equilateral triangles, rows along the length, so the width
    /// yields to the nearest whole row.
    pub fn as_built(&self) -> ((u32, u32), f64) {
        if !self.structure.info().triangular {
            return (self.grid, self.width);
        }
        let spacing = self.length / (f64::from(self.grid.0) - 0.5);
        let row = spacing * 3.0_f64.sqrt() / 2.0;
        let rows = (self.width / row).round().clamp(1.0, 1999.0);
        ((self.grid.0, rows as u32 + 1), rows * row)
    }

    /// A scene with the sheet, flat, its bottom layer in the plane y = 0.
    pub(crate) fn scene(&self) -> Scene {
        let ((nx, nz), width) = self.as_built();
        let spacing = self.length / f64::from(nx - 1);
        let sheet = SheetSpec {
            name: "sheet".into(),
            structure: self.structure,
            grid: (nx, self.layers, nz),
            size: (self.length, width),
            gap: 0.5 * spacing,
            material: MaterialChoice::Inline(self.material.clone()),
            springs: SpringLaw::Length,
            damping: self.damping_ratio,
            ..SheetSpec::default()
        };
        Scene {
            name: "measure".into(),
            gravity: DVec3::new(0.0, -self.gravity, 0.0),
            engine: self.engine,
            dt: self.dt.unwrap_or(1e-3),
            contact: ContactDefaults { friction: self.friction, restitution: self.restitution },
            air: Air::default(),
            sheets: vec![sheet],
            ..Scene::default()
        }
    }

    /// A world of `scene` with sleeping off and a step that is stable where none was given.
    pub(crate) fn world(&self, scene: &Scene) -> Result<World, InputError> {
        let mut world = World::new(scene)?;
        world.set_sleep(false);
        if self.dt.is_none() {
            let omega = world.sheets()[0].largest_frequency(100);
            let radians = self.stable_radians();
            if omega > 0.0 {
                world.set_dt((radians / omega).clamp(1e-7, 1.0))?;
            }
        }
        Ok(world)
    }

    /// A step that is stable for the engine on a lattice with these dashpots, in radians of its highest frequency.
    fn stable_radians(&self) -> f64 {
        let info = self.engine.info();
        // Each spring's dashpot is a fraction of its own critical; where a dozen springs meet they damp the highest mode
        // two to three times as much.
        let damping = 2.5 * self.damping_ratio;
        let undamped = match info.order {
            // Of first order: a tenth of a radian keeps flight and impact to a fraction of a percent.
            1 => 0.1,
            _ if info.stability_limit > 0.0 => 0.7 * info.stability_limit,
            // Without damping its growth of a⁴/4 a step must stay small over the run; with it, half its limit 2 ζ^(1/3).
            _ => damping.cbrt().clamp(0.05, 0.7),
        };
        undamped * ((1.0 + damping * damping).sqrt() - damping)
    }
}

/// A body with nothing of its own but its place: everything below its plane, with the scene's contact coefficients.
pub(crate) fn plane(name: &str, placement: Placement) -> BodySpec {
    BodySpec {
        name: name.into(),
        shape: Shape::HalfSpace,
        placement,
        path: Vec::new(),
        friction: None,
        restitution: None,
    }
}

/// What a case found.
pub struct Outcome {
    /// Keys of the case's own.
    pub(crate) keys: Map<String, Value>,
    /// Step of the engine, s.
    pub(crate) dt: f64,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Simulated time, s.
    pub(crate) simulated: f64,
    /// CPU time of the stepping, s.
    pub(crate) cpu: f64,
    /// Whether the sheet was at rest at the end; `None` where the case does not wait for it.
    pub(crate) settled: Option<bool>,
    /// "ok" or "unstable ...".
    pub(crate) status: String,
}

/// Steps a world and counts the CPU time of doing so.
pub(crate) struct Runner {
    pub world: World,
    cpu: f64,
}

impl Runner {
    pub fn new(world: World) -> Self {
        Self { world, cpu: 0.0 }
    }

    /// Steps for `duration` s, calling `watch` after every step; stops early when `watch` says so or the sheet fails.
    pub fn run(&mut self, duration: f64, mut watch: impl FnMut(&World) -> bool) {
        let end = self.world.time() + duration;
        let start = ProcessTime::now();
        while self.world.time() < end - 0.5 * self.world.dt() && self.world.unstable().is_none() {
            self.world.step();
            if !watch(&self.world) {
                break;
            }
        }
        self.cpu += start.elapsed().as_secs_f64();
    }

    pub fn outcome(self, keys: Value) -> Outcome {
        let status = self.world.report(0.0, &[]).status;
        let keys = if let Value::Object(map) = keys { map } else { Map::new() };
        Outcome {
            keys,
            dt: self.world.dt(),
            steps: self.world.steps(),
            simulated: self.world.time(),
            cpu: self.cpu,
            settled: None,
            status,
        }
    }
}

/// Runs the case of that name and returns its JSON object.
///
/// # Errors
/// When there is no such case, or a value of `setup` is out of range.
pub fn measure(case: &str, setup: &Setup) -> Result<Value, InputError> {
    let row = TABLE.iter().find(|c| c.name == case).ok_or_else(|| {
        let names: Vec<&str> = TABLE.iter().map(|c| c.name).collect();
        InputError::new("case", format!("no case is named \"{case}\"; there are {}", names.join(", ")))
    })?;
    setup.check()?;
    let start = ProcessTime::now();
    let found = (row.run)(setup)?;
    let set_up = (start.elapsed().as_secs_f64() - found.cpu).max(0.0);
    let ((nx, nz), width) = setup.as_built();
    let per_second = if found.simulated > 0.0 { 1e3 * found.cpu / found.simulated } else { 0.0 };
    let mut all = json!({
        "case": case,
        "structure": setup.structure.name(),
        "grid": format!("{nx}x{nz}"),
        "layers": setup.layers,
        "length_m": setup.length,
        "width_m": width,
        "engine": setup.engine.name(),
        "dt_s": found.dt,
        "steps": found.steps,
        "simulated_s": found.simulated,
        "cpu_s": found.cpu,
        "cpu_ms_per_simulated_s": per_second,
        "setup_cpu_s": set_up,
        "settled": found.settled,
        "status": found.status,
    });
    if let Value::Object(map) = &mut all {
        map.extend(found.keys);
    }
    Ok(all)
}
