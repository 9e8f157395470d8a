//! A sheet laid on an incline of angle φ with friction μ: it stays while tan φ <= μ, else a = g (sin φ - μ cos φ).

use glam::DVec3;
use serde_json::json;

use super::{Case, Outcome, Runner, Setup, plane};
use crate::World;
use crate::contact::SKIN;
use crate::error::InputError;
use crate::lattice::Layer;
use crate::scene::Placement;
use crate::sheet::Sheet;

pub(super) const CASE: Case =
    Case { name: "incline", about: "stick or slide on an incline: --angle DEG --friction MU", contact: true, run };

/// A layer that moved further than this has slid, m.
const MOVED: f64 = 2e-5;
/// Long enough to tell a slow slide from none: this long, s, and this many steps. In the first half single masses may still
/// slip until all carry their share; the second half tells.
const DURATION: f64 = 0.12;
const STEPS: f64 = 1000.0;
/// Before that the sheet is held by friction while its layers take up their weight: this long, s, and this many steps,
/// which is what a soft sheet needs.
const SETTLING: f64 = 0.08;
const SETTLING_STEPS: f64 = 3000.0;
/// Friction that holds on any incline: the pair's is the mean of this and the incline's.
const HOLDING: f64 = 200.0;

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    let tilt = Placement { position: DVec3::ZERO, rotation: DVec3::new(0.0, 0.0, -setup.angle) };
    let normal = tilt.quaternion() * DVec3::Y;
    let down = tilt.quaternion() * DVec3::X;
    scene.bodies.push(plane("incline", tilt));
    scene.sheets[0].placement = Placement { position: normal * SKIN, ..tilt };
    let mut runner = Runner::new(setup.world(&scene)?);
    let settling = SETTLING.max(SETTLING_STEPS * runner.world.dt()).min(10.0);
    runner.world.sheets_mut()[0].friction = HOLDING;
    runner.run(settling, |_| true);
    runner.world.sheets_mut()[0].friction = setup.friction;
    let place = |world: &World| lower_place(&world.sheets()[0], down);
    let half = 0.5 * DURATION.max(STEPS * runner.world.dt()).min(10.0);
    runner.run(half, |_| true);
    let (t0, x0) = (runner.world.time(), place(&runner.world));
    let mut line = Line::default();
    runner.run(half, |world| {
        let sheet = &world.sheets()[0];
        line.add(world.time() - t0, sheet.momentum().dot(down) / sheet.total_mass());
        true
    });
    let (time, moved) = (runner.world.time() - t0, place(&runner.world) - x0);
    // By the layer that lies on the incline: the one above may still sway.
    let slid = moved.abs() > MOVED;
    let keys = json!({
        "angle_deg": setup.angle,
        "friction": setup.friction,
        "slid": slid,
        "acceleration_m_s2": if slid { line.slope() } else { 0.0 },
        "creep_m_s": if slid { None } else { Some(moved / time) },
        "expected_acceleration_m_s2": expected(setup),
    });
    Ok(runner.outcome(keys))
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
