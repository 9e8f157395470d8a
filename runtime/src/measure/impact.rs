//! A free ball that hits a free sheet off its middle, without gravity: what one gains the other loses.
//!
//! The error of momentum is the largest change of the pair's total over the run, relative to the start; that of angular momentum, about
//! the origin, is shown apart, because an implicit engine itself keeps it only to its order while the sheet turns.

use glam::DVec3;
use serde_json::{Value, json};

use super::watch::{self, Watch};
use super::{Case, Outcome, Runner, Setup, body};
use crate::World;
use crate::error::InputError;
use crate::scene::{BodySpec, Shape};
use crate::sheet::Sheet;

pub(super) const CASE: Case =
    Case { name: "impact", about: "a ball hits a free sheet without gravity: --speed M_S", contact: true, run };

/// Radius of the ball, m, and its density, kg/m³: about as heavy as the sheet of the defaults.
const RADIUS: f64 = 0.02;
const DENSITY: f64 = 1000.0;
/// Distance from the sheet at the start, m.
const APART: f64 = 0.01;

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    scene.gravity = DVec3::ZERO;
    let sheet = Sheet::build(&scene, 0)?;
    let top = sheet.x.bounds().map_or(0.0, |(_, high)| high.y) + setup.half_thickness()?;
    let place = DVec3::new(0.2 * setup.length, top + RADIUS + APART, 0.15 * setup.width);
    // Slantwise, so that friction acts too.
    let velocity = DVec3::new(0.3, -1.0, 0.2) * setup.speed;
    let ball = body("ball", Shape::Ball(RADIUS), place);
    scene.bodies.push(BodySpec { density: Some(DENSITY), velocity, ..ball });
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = Watch::new(&runner.world);
    let (linear, angular) = momenta(&runner.world);
    let brought = watch::energy(&runner.world);
    let (mut linear_error, mut angular_error) = (0.0_f64, 0.0_f64);
    runner.run((20.0 * APART / setup.speed).clamp(0.1, 10.0), |world| {
        watch.see(world);
        let (p, l) = momenta(world);
        linear_error = linear_error.max((p - linear).length() / linear.length());
        angular_error = angular_error.max((l - angular).length() / angular.length());
        true
    });
    let after = runner.world.body_state("ball").map_or(DVec3::ZERO, |b| b.velocity());
    let mut keys = watch.keys(&runner.world, brought);
    if let Value::Object(own) = json!({
        "speed_m_s": setup.speed,
        "friction": setup.friction,
        "restitution": setup.restitution,
        "momentum_error": linear_error,
        "angular_momentum_error": angular_error,
        "ball_velocity_m_s": after.to_array(),
        "sheet_velocity_m_s": runner.world.sheets().first().map(|s| (s.momentum() / s.total_mass()).to_array()),
        "met": watch::touched(&runner.world),
    }) {
        keys.extend(own);
    }
    Ok(runner.outcome(Value::Object(keys)))
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s) of all sheets and free bodies.
fn momenta(world: &World) -> (DVec3, DVec3) {
    let sheets = world.sheets().iter().map(|s| {
        let p = s.momentum();
        (p, s.angular_momentum() + s.centre_of_mass().cross(p))
    });
    let bodies = world.body_state("ball").map(|b| (b.momentum(), b.angular_momentum(DVec3::ZERO)));
    sheets.chain(bodies).fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (q, m)| (p + q, l + m))
}
