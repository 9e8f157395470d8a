//! Stability limit of an integrator on a sheet: the longest stable step, measured and predicted
//! from the largest frequency.
//!
//! Springs of equal stiffness, with dashpots that are a fraction of critical, have the damping
//! matrix C = τ K. A mode of frequency ω is then an oscillator with damping ratio τω/2, and a step
//! of the integrator is a 2x2 matrix. The prediction is the longest step h at which no mode up to
//! the largest frequency grows. In a shell the quadratic bending energy also resists motion in the
//! plane, without retardation, so each mode has its own damping ratio. The effect shows when the
//! thickness is close to the node spacing.
//!
//! The measurement bisects over whole worlds: a free sheet with a random motion in the linear
//! range, or a sheet thrown at a ridge.
//!
//! The Newton method of implicit integrators tolerates motion slower than 1 mm/s
//! ([`NewtonSettings::reference_speed`]). The remaining motion is not growth of the scheme, so
//! instability requires more energy than nodes at this speed have. Runs that start faster end in a
//! slow rotation or bend of up to two hundred times that energy, which does not grow without bound:
//! `docs/stability.md`.

use glam::{DMat3, DVec3};

use sheetwork::integrators::Forces;
use sheetwork::integrators::settings::NewtonSettings;
use sheetwork::islands::event::EventKind;
use sheetwork::math::Vectors;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    BodySpec, IntegratorKind, Material, MaterialChoice, OvenSpec, Placement, Scene, Shape, SheetSpec, WhenUnstable,
};
use sheetwork::sheet::{Sheet, Status};
use sheetwork::{InputError, World};

use crate::measure::bisect;
use crate::measure::oscillator::{radius_of, step_matrix};
use crate::measure::random_sequence::RandomSequence;

/// Parameters of a stability trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityTrial {
    /// Structure. Lattices with an optional second layer have two.
    pub structure: StructureKind,
    /// Time integrator.
    pub engine: IntegratorKind,
    /// Nodes along length and width.
    pub grid: (u32, u32),
    /// Stiffness of every spring, N/m. For a shell, Young's modulus times thickness.
    pub stiffness: f64,
    /// Mass of every node, kg.
    pub mass: f64,
    /// Dashpots as a fraction of critical damping. For a shell, approximately the damping ratio of
    /// its fastest mode.
    pub damping: f64,
    /// Length over width, at constant area.
    pub aspect: f64,
    /// Thickness of a shell at constant membrane stiffness, or distance between layers, m.
    pub thickness: f64,
    /// Temperature of the room minus initial temperature of the sheet, K.
    pub jump: f64,
    /// Speed of a throw at a ridge, m/s; 0 for a free sheet with a small motion.
    pub speed: f64,
}

impl Default for StabilityTrial {
    /// The second-order setting of the thesis: TRiMM, Euler-Richardson, 0.2 N/m, 14 %, 0.4 g.
    fn default() -> Self {
        Self {
            structure: StructureKind::Trimm,
            engine: IntegratorKind::EulerRichardson,
            grid: (5, 5),
            stiffness: 0.2,
            mass: 4e-4,
            damping: 0.14,
            aspect: 1.0,
            thickness: 1e-3,
            jump: 0.0,
            speed: 0.0,
        }
    }
}

/// Parameter that a search scales towards instability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariedParameter {
    /// Longer step.
    Step,
    /// Higher spring stiffness.
    Stiffness,
    /// Smaller node mass.
    Mass,
    /// Less damping.
    Damping,
}

/// Area of every sheet (m²), from the thesis.
const AREA: f64 = 0.025 * 0.025;
/// Steps of a trial with a free sheet.
const STEPS: u32 = 1200;
/// Steps between two evaluations of the energy.
const ENERGY_CHECK_INTERVAL: u32 = 4;
/// Growth thresholds: energy over the energy at the start, and over an earlier energy of the trial.
const TOTAL_GROWTH_THRESHOLD: f64 = 1e6;
const RECENT_GROWTH_THRESHOLD: f64 = 1.5;
/// Initial speed of the nodes of a free sheet, m/s.
const INITIAL_SPEED: f64 = 1e-7;
/// Simulated time of a throw, s.
const THROW: f64 = 0.6;
/// Minimum and maximum step of the search, s.
const MINIMUM_STEP: f64 = 1e-7;
const MAXIMUM_STEP: f64 = 1.0;
/// Maximum factor on the other parameters.
const MAXIMUM_FACTOR: f64 = 1e3;
/// Ratio of unstable to stable value at which the search ends.
const SEARCH_RATIO_TOLERANCE: f64 = 1.005;

/// Damping ratio of a shell's slowest bending mode over the resulting ratio of its fastest mode.
const SLOWEST_MODE_DAMPING: f64 = 0.011;

impl StabilityTrial {
    /// The scene of a trial with step `dt` (s).
    fn scene(&self, dt: f64) -> Scene {
        let shell = self.structure == StructureKind::Shell;
        let (fewest, most) = self.structure.info().layers;
        let young = self.stiffness / self.thickness;
        let softening = if self.jump == 0.0 {
            Vec::new()
        } else {
            // A polymer around its glass transition; the requested stiffness applies at the initial
            // temperature.
            vec![
                (20.0 + self.jump.min(0.0), softness(self.jump.min(0.0))),
                (20.0 + self.jump.max(0.0), softness(self.jump.max(0.0))),
            ]
        };
        let material = Material {
            young,
            thickness: self.thickness,
            expansion: 0.0,
            softening,
            density: 1e3,
            ..Material::default()
        };
        let sheet = SheetSpec {
            name: "sheet".into(),
            structure: self.structure,
            grid: (self.grid.0, 2.clamp(fewest, most), self.grid.1),
            size: ((AREA * self.aspect).sqrt(), (AREA / self.aspect).sqrt()),
            gap: self.thickness,
            material: MaterialChoice::Inline(material),
            node_mass: Some(self.mass),
            damping: self.damping,
            damping_ratio: shell.then_some(SLOWEST_MODE_DAMPING * self.damping),
            velocity: DVec3::new(0.0, -self.speed, 0.0),
            temperature: (self.jump != 0.0).then_some(20.0),
            when_unstable: if self.speed > 0.0 { WhenUnstable::Freeze } else { WhenUnstable::Stop },
            ..SheetSpec::thesis()
        };
        let mut scene =
            Scene { engine: self.engine, dt, gravity: DVec3::ZERO, sheets: vec![sheet], ..Scene::default() };
        if self.jump != 0.0 {
            // A convection coefficient large enough to bring the sheet to room temperature within a
            // step.
            scene.oven = Some(OvenSpec { temperature: 20.0 + self.jump, convection: Some(1e6), ..OvenSpec::default() });
            scene.time_lapse = 1e4;
        }
        if self.speed > 0.0 {
            scene.gravity = DVec3::new(0.0, -0.981, 0.0);
            // A bar on its edge, 2 mm below the sheet.
            let side = 0.01;
            let low = -0.002 - side * std::f64::consts::FRAC_1_SQRT_2;
            let placement = Placement { position: DVec3::new(0.0, low, 0.0), rotation: DVec3::new(0.0, 0.0, 45.0) };
            scene.bodies = vec![BodySpec { placement, ..BodySpec::new(Shape::Box(DVec3::new(side, side, 0.1))) }];
        }
        scene
    }

    /// Largest angular frequency (rad/s) and retardation time τ (s) of the sheet at rest, at its
    /// final temperature.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn frequency(&self) -> Result<(f64, f64), InputError> {
        let plain = Self { jump: 0.0, speed: 0.0, ..*self };
        let warmed = Self { stiffness: self.stiffness * softness(self.jump), ..plain };
        let world = World::new(&warmed.scene(1e-3))?;
        let sheet = &world.sheets()[0];
        let springs = sheet.springs();
        let tau = match (springs.damping.first(), springs.stiffness.first()) {
            (Some(c), Some(k)) => c / k,
            // The retardation time is independent of temperature.
            _ => World::new(&plain.scene(1e-3))?.sheets()[0].law().retardation,
        };
        Ok((sheet.largest_frequency(3000), tau))
    }

    /// Longest step (s) at which no mode grows, predicted from the frequencies. Infinite for
    /// implicit integrators; 0 where every step lets some mode grow.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn predict_longest_step(&self) -> Result<f64, InputError> {
        if self.engine.info().implicit {
            return Ok(f64::INFINITY);
        }
        let (omega, tau) = self.frequency()?;
        let of_largest = longest_step(self.engine, omega, tau);
        if self.structure != StructureKind::Shell {
            return Ok(of_largest);
        }
        let still = Self { jump: 0.0, speed: 0.0, stiffness: self.stiffness * softness(self.jump), ..*self };
        let at_rest = World::new(&still.scene(1e-3))?;
        let sheet = &at_rest.sheets()[0];
        // The retardation time is that of the cold sheet; a sheet built with the warm stiffness has
        // another.
        let slower = tau / sheet.law().retardation.max(f64::MIN_POSITIVE);
        let slower = if self.jump == 0.0 { 1.0 } else { slower };
        Ok(longest_of_sheet(self.engine, sheet, slower).unwrap_or(of_largest))
    }

    /// Longest stable step (s), measured by bisection from `guess`. `None` when the maximum step is
    /// stable. For a throw the search ends at a sixteenth of the guess, which is also the result
    /// when that step is unstable.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn find_longest_step(&self, guess: f64) -> Result<Option<f64>, InputError> {
        let guess = if guess.is_finite() && guess > 0.0 { guess } else { 1e-2 };
        // The cost of a throw is inversely proportional to its step.
        let shortest = if self.speed > 0.0 { MINIMUM_STEP.max(guess / 16.0) } else { MINIMUM_STEP };
        search(guess, (shortest, MAXIMUM_STEP), |dt| self.is_unstable_at(dt))
    }

    /// The trial with one parameter scaled by `by` towards instability: longer step `dt` (s),
    /// higher stiffness, smaller mass or less damping. Returns the trial and its step.
    pub fn scaled(self, what: VariedParameter, dt: f64, by: f64) -> (Self, f64) {
        match what {
            VariedParameter::Step => (self, dt * by),
            VariedParameter::Stiffness => (Self { stiffness: self.stiffness * by, ..self }, dt),
            VariedParameter::Mass => (Self { mass: self.mass / by, ..self }, dt),
            VariedParameter::Damping => (Self { damping: self.damping / by, ..self }, dt),
        }
    }

    /// Largest stable factor on `what` at a step of `dt` s. `None` when the maximum factor is
    /// stable.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn margin(&self, what: VariedParameter, dt: f64) -> Result<Option<f64>, InputError> {
        let longest = if what == VariedParameter::Step { MAXIMUM_STEP / dt } else { MAXIMUM_FACTOR };
        search(1.5, (1e-3, longest), |by| {
            let (setting, dt) = self.scaled(what, dt, by);
            setting.is_unstable_at(dt)
        })
    }

    /// Whether the trial is unstable with a step of `dt` s.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn is_unstable_at(&self, dt: f64) -> Result<bool, InputError> {
        let mut world = World::new(&self.scene(dt))?;
        world.set_sleep(false);
        if self.speed > 0.0 {
            return Ok(throw_is_unstable(&mut world, dt));
        }
        let still = if self.engine.info().implicit { NewtonSettings::DEFAULT.reference_speed } else { 0.0 };
        Ok(small_motion_grows(&mut world, still))
    }
}

/// Bisects for the value in `range` above which `breaks` holds, from `guess` outwards. `None` when
/// the upper bound is stable; the lower bound when it is unstable.
fn search(
    guess: f64,
    range: (f64, f64),
    breaks: impl Fn(f64) -> Result<bool, InputError>,
) -> Result<Option<f64>, InputError> {
    let mut high = (1.02 * guess).clamp(range.0, range.1);
    let mut low = 0.96 * high;
    while !breaks(high)? {
        if high >= range.1 {
            return Ok(None);
        }
        (low, high) = (high, (1.3 * high).min(range.1));
    }
    while breaks(low)? {
        if low <= range.0 {
            return Ok(Some(range.0));
        }
        (low, high) = ((0.7 * low).max(range.0), low);
    }
    while high / low > SEARCH_RATIO_TOLERANCE {
        let middle = (low * high).sqrt();
        if breaks(middle)? { high = middle } else { low = middle }
    }
    Ok(Some((low * high).sqrt()))
}

/// Whether a thrown sheet becomes unstable or has an energy error.
fn throw_is_unstable(world: &mut World, dt: f64) -> bool {
    let steps = ((THROW / dt).ceil() as u32).max(100);
    for _ in 0..steps {
        world.step();
        if world.sheets()[0].state.status != Status::Awake {
            return true;
        }
    }
    world.events().iter().any(|e| e.kind == EventKind::Contained)
}

/// Whether a small random motion of a free sheet grows beyond the kinetic energy at `still` m/s.
fn small_motion_grows(world: &mut World, still: f64) -> bool {
    let mut draw = RandomSequence::new(0, 7);
    for sheet in world.sheets_mut() {
        for i in 0..sheet.node_count() {
            let v = DVec3::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-1.0, 1.0));
            sheet.state.v.set(i, v * INITIAL_SPEED);
        }
        remove_rigid_motion(sheet);
    }
    let energy = |world: &World| world.sheets()[0].energy(DVec3::ZERO).total;
    let begin = energy(world);
    let floor = 0.5 * still * still * world.sheets()[0].total_mass();
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for step in 0..STEPS {
        world.step();
        if world.sheets()[0].state.status != Status::Awake {
            return true;
        }
        if step % ENERGY_CHECK_INTERVAL != 0 {
            continue;
        }
        let now = energy(world);
        if now.is_nan() || now >= (TOTAL_GROWTH_THRESHOLD * begin).max(floor) {
            return true;
        }
        match 4 * step / STEPS {
            1 => early = early.max(now),
            3 => late = late.max(now),
            _ => {}
        }
    }
    late > (RECENT_GROWTH_THRESHOLD * early).max(floor)
}

/// Removes rigid translation and rotation from the velocities of nodes of equal mass. Rigid motion
/// neither grows nor decays and would hide slow growth.
fn remove_rigid_motion(sheet: &mut Sheet) {
    let n = sheet.node_count() as f64;
    let (middle, speed) = (sheet.state.x.iter().sum::<DVec3>() / n, sheet.state.v.iter().sum::<DVec3>() / n);
    let (mut inertia, mut momentum) = (DMat3::ZERO, DVec3::ZERO);
    for (x, v) in sheet.state.x.iter().zip(sheet.state.v.iter()) {
        let r = x - middle;
        inertia += DMat3::from_diagonal(DVec3::splat(r.length_squared())) - DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        momentum += r.cross(v - speed);
    }
    let spin = inertia.inverse() * momentum;
    for i in 0..sheet.node_count() {
        let r = sheet.state.x.get(i) - middle;
        sheet.state.v.set(i, sheet.state.v.get(i) - speed - spin.cross(r));
    }
}

/// Stiffness after a jump of `jump` K over the stiffness before it: a tenth at 100 K.
fn softness(jump: f64) -> f64 {
    10.0_f64.powf(-jump / 100.0)
}

/// x'' = -x - 2 ζ x'.
struct Damped(f64);

impl Forces for Damped {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        a.clear();
        a.add_scaled(-1.0, x);
        a.add_scaled(-2.0 * self.0, v);
    }
}

/// Spectral radius of a step of `a` radians of an oscillator with damping ratio `zeta`, from the
/// images of the two unit states.
pub fn radius(engine: IntegratorKind, a: f64, zeta: f64) -> f64 {
    radius_of(step_matrix(engine, &mut Damped(zeta), a))
}

/// Growth per step that a trial detects: half of the energy in half of the trial.
const GROWTH_THRESHOLD: f64 = 0.405 / STEPS as f64;
/// Number of further frequencies below the largest, and the lowest as a fraction of the largest.
const FREQUENCY_SAMPLES: u32 = 24;
const LOWEST_FREQUENCY_RATIO: f64 = 0.02;

/// Longest step (s) of `engine` at which no oscillator of up to `omega` rad/s with C = `tau` K
/// grows.
pub fn longest_step(engine: IntegratorKind, omega: f64, tau: f64) -> f64 {
    let of = |k: u32| omega * LOWEST_FREQUENCY_RATIO.powf(f64::from(k) / f64::from(FREQUENCY_SAMPLES));
    (0..=FREQUENCY_SAMPLES).map(|k| longest_of(engine, of(k), tau)).fold(f64::INFINITY, f64::min)
}

/// Longest step (s) of `engine` at which no mode of `sheet` about its present shape grows, with
/// `slower` times its damping. `None` for a sheet without modes or with too many.
fn longest_of_sheet(engine: IntegratorKind, sheet: &Sheet, slower: f64) -> Option<f64> {
    let modes = sheet.damped_modes();
    let fastest = modes.last()?.squared;
    let fast = modes.iter().filter(|mode| mode.squared > fastest * LOWEST_FREQUENCY_RATIO * LOWEST_FREQUENCY_RATIO);
    fast.map(|mode| {
        let omega = mode.squared.sqrt();
        longest_of(engine, omega, slower * mode.rate / mode.squared)
    })
    .reduce(f64::min)
}

fn longest_of(engine: IntegratorKind, omega: f64, tau: f64) -> f64 {
    let grows = |a: f64| radius(engine, a, 0.5 * tau * omega) > 1.0 + GROWTH_THRESHOLD;
    let mut high = 0.002;
    while !grows(high) && high < 20.0 {
        high *= 1.05;
    }
    let low = high / 1.05;
    if grows(low) {
        return 0.0;
    }
    bisect((low, high), 40, |a| !grows(a)).0 / omega
}
