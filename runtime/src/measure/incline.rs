//! A sheet laid on an incline of angle φ with friction μ: it stays while tan φ <= μ, else a = g (sin φ - μ cos φ).

use glam::DVec3;
use serde_json::json;

use super::{Case, Outcome, Runner, Setup};
use crate::contact::SKIN;
use crate::error::InputError;
use crate::scene::{BodySpec, Placement, Shape};

pub(super) const CASE: Case =
    Case { name: "incline", about: "stick or slide on an incline: --angle DEG --friction MU", run };

/// Long enough to tell a slow slide from none, s.
const DURATION: f64 = 0.12;
/// Of that, left out while the layers take up their weight, s.
const START: f64 = 0.04;

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    let tilt = Placement { position: DVec3::ZERO, rotation: DVec3::new(0.0, 0.0, -setup.angle) };
    let normal = tilt.quaternion() * DVec3::Y;
    let down = tilt.quaternion() * DVec3::X;
    scene.bodies.push(BodySpec {
        name: "incline".into(),
        shape: Shape::HalfSpace,
        placement: tilt,
        path: Vec::new(),
        friction: None,
        restitution: None,
    });
    scene.sheets[0].placement = Placement { position: normal * SKIN, ..tilt };
    let mut runner = Runner::new(setup.world(&scene)?);
    let place = |runner: &Runner| runner.world.sheets()[0].centre_of_mass().dot(down);
    let speed = |runner: &Runner| {
        let sheet = &runner.world.sheets()[0];
        sheet.momentum().dot(down) / sheet.total_mass()
    };
    runner.run(START, |_| true);
    let (t0, x0, v0) = (runner.world.time(), place(&runner), speed(&runner));
    runner.run(DURATION - START, |_| true);
    let (time, moved, gained) = (runner.world.time() - t0, place(&runner) - x0, speed(&runner) - v0);
    // Sliding is a speed that lasts and grows; creep is movement without it.
    let slid = moved.abs() > 1e-5 && speed(&runner).abs() > 1e-3;
    let keys = json!({
        "angle_deg": setup.angle,
        "friction": setup.friction,
        "slid": slid,
        "acceleration_m_s2": if slid { gained / time } else { 0.0 },
        "creep_m_s": if slid { None } else { Some(moved / time) },
        "expected_acceleration_m_s2": expected(setup),
    });
    Ok(runner.outcome(keys))
}

fn expected(setup: &Setup) -> f64 {
    let angle = setup.angle.to_radians();
    (setup.gravity * (angle.sin() - setup.friction * angle.cos())).max(0.0)
}
