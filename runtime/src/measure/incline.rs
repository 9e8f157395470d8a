//! A sheet laid on an incline of angle φ with friction μ: it stays while tan φ <= μ, else a = g (sin φ - μ cos φ).
//!
//! It is laid at the distance at which it touches, at rest, on a plane or on a sheet that is held. The acceleration is the slope of a least-squares line through the
//! velocity of the centre of mass, itself taken from where the centre went; creep is the speed of the bottom layer over the last half
//! of the time, and again once it sleeps.

use glam::DVec3;
use serde_json::{Value, json};

use super::watch::{self, Watch};
use super::{Case, Outcome, Runner, Setup, ground};
use crate::World;
use crate::error::InputError;
use crate::lattice::Layer;
use crate::scene::Placement;
use crate::sheet::{Sheet, Status};

pub(super) const CASE: Case =
    Case { name: "incline", about: "stick or slide on an incline: --angle DEG --friction MU", contact: true, run };

/// A layer that moved further than this has slid, m.
const MOVED: f64 = 2e-5;
/// Friction that holds on any incline: the pair's is the mean of this and the incline's.
const HOLDING: f64 = 200.0;
/// Time given to a sheet to fall asleep in, and watched when it does, s.
const DOZING: f64 = 2.0;
const DREAMING: f64 = 0.5;

/// How long each part takes, s.
struct Times {
    /// Held by [`HOLDING`] while layers take up their weight.
    settling: f64,
    /// Let go but not measured: single masses may still slip until all carry their share.
    before: f64,
    /// Measured.
    measured: f64,
}

impl Times {
    /// A shell lies at rest from the start, and implicit engines take few steps: they are given a second. Layers must first carry one
    /// another, in 3000 explicit steps at least, and a slow slide is told from none in 500.
    fn of(setup: &Setup, dt: f64) -> Self {
        let implicit = setup.engine.info().implicit;
        let half = if implicit { 0.5 } else { 0.5 * 0.12_f64.max(1000.0 * dt).min(10.0) };
        let explicit = if implicit { 0.3 } else { 0.08_f64.max(3000.0 * dt).min(10.0) };
        let layered = setup.structure.info().layers.1 > 1 || !implicit;
        Self { settling: if layered { explicit } else { 0.0 }, before: half, measured: half }
    }

    /// How far a sheet slides in them, m.
    fn way(&self, setup: &Setup) -> f64 {
        0.5 * expected(setup) * (self.before + self.measured).powi(2)
    }
}

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    let tilt = Placement { position: DVec3::ZERO, rotation: DVec3::new(0.0, 0.0, -setup.angle) };
    let down = tilt.quaternion() * DVec3::X;
    let times = Times::of(setup, setup.world(&scene)?.dt());
    ground::lay(setup, &mut scene, tilt, times.way(setup))?;
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = Watch::new(&runner.world);
    let mut see = |world: &World| {
        watch.see(world);
        true
    };
    runner.world.sheets_mut()[0].friction = HOLDING;
    runner.run(times.settling, &mut see);
    runner.world.sheets_mut()[0].friction = setup.friction;
    let place = |world: &World| lower_place(&world.sheets()[0], down);
    let along = |world: &World| world.sheets()[0].centre_of_mass().dot(down);
    runner.run(times.before, &mut see);
    let (t0, x0) = (runner.world.time(), place(&runner.world));
    let mut line = Line::default();
    let mut before = along(&runner.world);
    runner.run(times.measured, |world| {
        let now = along(world);
        line.add(world.time() - t0, (now - before) / world.dt());
        before = now;
        see(world)
    });
    let (time, moved) = (runner.world.time() - t0, place(&runner.world) - x0);
    // By the layer that lies on the incline: the one above may still sway.
    let slid = moved.abs() > MOVED;
    let asleep = if slid { None } else { creep_asleep(&mut runner, &place) };
    let scale = watch::fall(&runner.world, setup.length);
    let mut keys = watch.keys(&runner.world, scale);
    if let Value::Object(own) = json!({
        "angle_deg": setup.angle,
        "friction": setup.friction,
        "slid": slid,
        "acceleration_m_s2": if slid { line.slope() } else { 0.0 },
        "creep_m_s": if slid { None } else { Some(moved.abs() / time) },
        "creep_asleep_m_s": asleep,
        "expected_acceleration_m_s2": expected(setup),
    }) {
        keys.extend(own);
    }
    Ok(runner.outcome(Value::Object(keys)))
}

/// Speed of a sheet that was let fall asleep, m/s; `None` if it did not.
fn creep_asleep(runner: &mut Runner, place: &dyn Fn(&World) -> f64) -> Option<f64> {
    let asleep = |world: &World| world.sheets().iter().all(|s| s.status == Status::Asleep);
    runner.world.set_sleep(true);
    runner.run(DOZING, |world| !asleep(world));
    if !asleep(&runner.world) {
        return None;
    }
    let x = place(&runner.world);
    runner.run(DREAMING, |_| true);
    Some((place(&runner.world) - x).abs() / DREAMING)
}

/// Mean place of the bottom layer along `down`, m.
fn lower_place(sheet: &Sheet, down: DVec3) -> f64 {
    let masses = sheet.layers.first().map_or(0..0, Layer::range);
    let count = masses.len().max(1) as f64;
    masses.map(|i| sheet.x.get(i).dot(down)).sum::<f64>() / count
}

/// Least-squares line through points, which averages out what sways about it.
#[derive(Default)]
struct Line {
    n: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
}

impl Line {
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
