//! A free ball, or another free sheet, that hits a free sheet off its middle, without gravity: what one gains the other loses.
//!
//! The error of momentum is the largest change of the pair's total over the run, relative to the start; that of angular momentum, about
//! the origin, is shown apart, because an implicit engine itself keeps it only to its order while the sheet turns.

use glam::DVec3;
use serde_json::{Value, json};

use super::watch::{self, Watch};
use super::{Case, Outcome, Runner, Setup, body};
use crate::World;
use crate::error::InputError;
use crate::scene::{BodySpec, Placement, Scene, Shape, SheetSpec};
use crate::sheet::Sheet;

pub(super) const CASE: Case =
    Case { name: "impact", about: "a ball or sheet hits a free sheet: --speed M_S [--on-sheet]", contact: true, run };

/// Radius of the ball, m, and its density, kg/m³: about as heavy as the sheet of the defaults.
const RADIUS: f64 = 0.02;
const DENSITY: f64 = 1000.0;
/// Distance from the sheet at the start, m.
const APART: f64 = 0.01;
/// Sides of a sheet that strikes, over those of the other, and how it is turned, degrees: it comes with a corner first.
const SMALLER: f64 = 0.7;
const TURNED: DVec3 = DVec3::new(10.0, 25.0, 40.0);

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    scene.gravity = DVec3::ZERO;
    if setup.on_sheet {
        throw_sheet(setup, &mut scene)?;
    } else {
        throw_ball(setup, &mut scene)?;
    }
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = Watch::new(&runner.world);
    let (linear, angular) = momenta(&runner.world);
    let brought = watch::energy(&runner.world);
    let (mut linear_error, mut angular_error, mut met) = (0.0_f64, 0.0_f64, false);
    runner.run((20.0 * APART / setup.speed).clamp(0.1, 10.0), |world| {
        watch.see(world);
        met |= watch::touched(world);
        let (p, l) = momenta(world);
        linear_error = linear_error.max((p - linear).length() / linear.length());
        angular_error = angular_error.max((l - angular).length() / angular.length());
        true
    });
    let sheets = runner.world.sheets().iter();
    let (masses, velocities): (Vec<f64>, Vec<DVec3>) = sheets
        .map(|s| (s.total_mass(), s.momentum() / s.total_mass()))
        .chain(runner.world.body_state("ball").map(|b| (b.mass_properties().mass, b.velocity())))
        .unzip();
    let ball = velocities.last().filter(|_| !setup.on_sheet);
    let mut keys = watch.keys(&runner.world, brought);
    if let Value::Object(own) = json!({
        "speed_m_s": setup.speed,
        "friction": setup.friction,
        "restitution": setup.restitution,
        "momentum_error": linear_error,
        "angular_momentum_error": angular_error,
        "ball_velocity_m_s": ball.map(DVec3::to_array),
        "sheet_velocity_m_s": velocities.first().map(DVec3::to_array),
        "masses_kg": masses,
        "velocities_m_s": velocities.iter().map(DVec3::to_array).collect::<Vec<_>>(),
        "met": met,
    }) {
        keys.extend(own);
    }
    Ok(runner.outcome(Value::Object(keys)))
}

/// How fast what strikes comes, m/s: slantwise, so that friction acts too.
fn velocity(setup: &Setup) -> DVec3 {
    DVec3::new(0.3, -1.0, 0.2) * setup.speed
}

fn throw_ball(setup: &Setup, scene: &mut Scene) -> Result<(), InputError> {
    let sheet = Sheet::build(scene, 0)?;
    let top = sheet.x.bounds().map_or(0.0, |(_, high)| high.y) + setup.half_thickness()?;
    let place = DVec3::new(0.2 * setup.length, top + RADIUS + APART, 0.15 * setup.width);
    let ball = body("ball", Shape::Ball(RADIUS), place);
    scene.bodies.push(BodySpec { density: Some(DENSITY), velocity: velocity(setup), ..ball });
    Ok(())
}

fn throw_sheet(setup: &Setup, scene: &mut Scene) -> Result<(), InputError> {
    let first = &scene.sheets[0];
    let (size, rotation) = ((SMALLER * first.size.0, SMALLER * first.size.1), TURNED);
    let placement = Placement { position: DVec3::ZERO, rotation };
    let velocity = velocity(setup);
    scene.sheets.push(SheetSpec { name: "striker".into(), size, placement, velocity, ..first.clone() });
    let bounds = |index: usize| Sheet::build(scene, index).map(|s| s.x.bounds().unwrap_or_default());
    let ((_, top), (bottom, _)) = (bounds(0)?, bounds(1)?);
    let height = top.y - bottom.y + 2.0 * setup.half_thickness()? + APART;
    scene.sheets[1].placement.position = DVec3::new(0.1 * setup.length, height, 0.05 * setup.width);
    Ok(())
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
