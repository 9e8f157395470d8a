//! A sheet on an incline of angle φ with friction μ: it sticks for tan φ <= μ and otherwise slips
//! with a = g (sin φ - μ cos φ).
//!
//! The sheet starts at rest in contact with a plane or a fixed sheet. The acceleration is the slope
//! of a least-squares line through the velocity of the centre of mass, from differences of its
//! position. Creep is the speed of the bottom layer over the last half of the time, and again while
//! it sleeps.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigResult, Runner, Setup, ground};
use sheetwork::World;
use sheetwork::mesh::structure::LatticeLayer;
use sheetwork::scene::Placement;
use sheetwork::sheet::{Sheet, Status};

/// Displacement of the bottom layer that counts as slip, m.
const SLIP_THRESHOLD: f64 = 2e-5;
/// Friction coefficient that sticks on any incline; the pair's coefficient is the mean of this and
/// the incline's.
const STICKING_FRICTION: f64 = 200.0;
/// Time limit for a sheet to fall asleep, and observation time after that, s.
const SLEEP_TIMEOUT: f64 = 2.0;
const SLEEP_OBSERVATION_TIME: f64 = 0.5;

/// Duration of each phase, s.
struct PhaseDurations {
    /// Friction of [`STICKING_FRICTION`] while the layers take up their weight.
    settling: f64,
    /// Friction of the rig without measurement: single nodes can still slip until all carry their
    /// share.
    before: f64,
    /// Measurement.
    measured: f64,
}

impl PhaseDurations {
    /// Durations by integrator and structure. A shell starts at rest, and implicit integrators take
    /// few steps: they get 1 s. Layers first load one another, in at least 3000 explicit steps; a
    /// slow slip is distinguished from stick in 500.
    fn new(setup: &Setup, dt: f64) -> Self {
        let implicit = setup.engine.info().implicit;
        let half = if implicit { 0.5 } else { 0.5 * 0.12_f64.max(1000.0 * dt).min(10.0) };
        let explicit = if implicit { 0.3 } else { 0.08_f64.max(3000.0 * dt).min(10.0) };
        let layered = setup.structure.info().layers.1 > 1 || !implicit;
        Self { settling: if layered { explicit } else { 0.0 }, before: half, measured: half }
    }

    /// Distance that a slipping sheet moves, m.
    fn way(&self, setup: &Setup) -> f64 {
        0.5 * expected(setup) * (self.before + self.measured).powi(2)
    }
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    let tilt = Placement { position: DVec3::ZERO, rotation: DVec3::new(0.0, 0.0, -setup.angle) };
    let down = tilt.quaternion() * DVec3::X;
    let times = PhaseDurations::new(setup, setup.world(&scene)?.dt());
    ground::place_on_ground(setup, &mut scene, tilt, times.way(setup))?;
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    let mut see = |world: &World| {
        watch.observe_step(world);
        true
    };
    runner.world.sheets_mut()[0].parameters.friction = STICKING_FRICTION;
    runner.run(times.settling, &mut see);
    runner.world.sheets_mut()[0].parameters.friction = setup.friction;
    let place = |world: &World| lower_place(&world.sheets()[0], down);
    let along = |world: &World| world.sheets()[0].centre_of_mass().dot(down);
    runner.run(times.before, &mut see);
    let (t0, x0) = (runner.world.time(), place(&runner.world));
    let mut line = LeastSquaresLine::default();
    let mut before = along(&runner.world);
    runner.run(times.measured, |world| {
        let now = along(world);
        line.add(world.time() - t0, (now - before) / world.dt());
        before = now;
        see(world)
    });
    let (time, moved) = (runner.world.time() - t0, place(&runner.world) - x0);
    // By the layer on the incline; the layer above can still oscillate.
    let slid = moved.abs() > SLIP_THRESHOLD;
    let asleep = if slid { None } else { creep_asleep(&mut runner, &place) };
    let scale = contact_observer::fall_energy(&runner.world, setup.length);
    let own = json!({
        "angle_deg": setup.angle,
        "friction": setup.friction,
        "slid": slid,
        "acceleration_m_s2": if slid { line.slope() } else { 0.0 },
        "creep_m_s": if slid { None } else { Some(moved.abs() / time) },
        "creep_asleep_m_s": asleep,
        "expected_acceleration_m_s2": expected(setup),
    });
    Ok(runner.contact_outcome(&watch, scale, own))
}

/// Speed of a sleeping sheet, m/s; `None` if it does not fall asleep.
fn creep_asleep(runner: &mut Runner, place: &dyn Fn(&World) -> f64) -> Option<f64> {
    let asleep = |world: &World| world.sheets().iter().all(|s| s.state.status == Status::Asleep);
    runner.world.set_sleep(true);
    runner.run(SLEEP_TIMEOUT, |world| !asleep(world));
    if !asleep(&runner.world) {
        return None;
    }
    let x = place(&runner.world);
    runner.run(SLEEP_OBSERVATION_TIME, |_| true);
    Some((place(&runner.world) - x).abs() / SLEEP_OBSERVATION_TIME)
}

/// Mean position of the bottom layer along `down`, m.
fn lower_place(sheet: &Sheet, down: DVec3) -> f64 {
    let masses = sheet.model.layers.first().map_or(0..0, LatticeLayer::range);
    let count = masses.len().max(1) as f64;
    masses.map(|i| sheet.state.x.get(i).dot(down)).sum::<f64>() / count
}

/// Least-squares line through points, which averages oscillations.
#[derive(Default)]
struct LeastSquaresLine {
    n: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
}

impl LeastSquaresLine {
    fn add(&mut self, t: f64, y: f64) {
        self.n += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
    }

    fn slope(&self) -> f64 {
        (self.n * self.ty - self.t * self.y) / (self.n * self.tt - self.t * self.t)
    }
}

fn expected(setup: &Setup) -> f64 {
    let angle = setup.angle.to_radians();
    (setup.gravity * (angle.sin() - setup.friction * angle.cos())).max(0.0)
}
