//! Off-centre impact of a free ball, or a free sheet, on a free sheet without gravity: conservation
//! of momentum.
//!
//! The momentum error is the largest change of the pair's total over the run, relative to the
//! start. The error of angular momentum about the origin is separate, because an implicit
//! integrator conserves it only to its order while the sheet rotates.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigResult, Runner, Setup, body};
use sheetwork::scene::{BodySpec, Placement, Scene, Shape, SheetSpec};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

/// Radius (m) and density (kg/m³) of the ball, about as heavy as the default sheet.
const RADIUS: f64 = 0.02;
const DENSITY: f64 = 1000.0;
/// Distance from the sheet at the start, m.
const APART: f64 = 0.01;
/// Size ratio of a striking sheet to the other, and its rotation, degrees, which puts a corner
/// first.
const STRIKER_SIZE_RATIO: f64 = 0.7;
const STRIKER_ROTATION: DVec3 = DVec3::new(10.0, 25.0, 40.0);

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    scene.gravity = DVec3::ZERO;
    if setup.on_sheet {
        throw_sheet(setup, &mut scene)?;
    } else {
        throw_ball(setup, &mut scene)?;
    }
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    let (linear, angular) = momenta(&runner.world);
    let brought = contact_observer::energy(&runner.world);
    let (mut linear_error, mut angular_error, mut met) = (0.0_f64, 0.0_f64, false);
    runner.run((20.0 * APART / setup.speed).clamp(0.1, 10.0), |world| {
        watch.observe_step(world);
        met |= contact_observer::has_touched(world);
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
    let scale = brought;
    let own = json!({
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
    });
    Ok(runner.contact_outcome(&watch, scale, own))
}

/// Velocity of the striking body, m/s; oblique, so that friction acts too.
fn velocity(setup: &Setup) -> DVec3 {
    DVec3::new(0.3, -1.0, 0.2) * setup.speed
}

fn throw_ball(setup: &Setup, scene: &mut Scene) -> Result<(), InputError> {
    let sheet = Sheet::build(scene, 0)?;
    let top = sheet.state.x.bounds().map_or(0.0, |(_, high)| high.y) + setup.contact_offset()?;
    let place = DVec3::new(0.2 * setup.length, top + RADIUS + APART, 0.15 * setup.width);
    let ball = body("ball", Shape::Ball(RADIUS), place);
    scene.bodies.push(BodySpec { density: Some(DENSITY), velocity: velocity(setup), ..ball });
    Ok(())
}

fn throw_sheet(setup: &Setup, scene: &mut Scene) -> Result<(), InputError> {
    let first = &scene.sheets[0];
    let (size, rotation) = ((STRIKER_SIZE_RATIO * first.size.0, STRIKER_SIZE_RATIO * first.size.1), STRIKER_ROTATION);
    let placement = Placement { position: DVec3::ZERO, rotation };
    let velocity = velocity(setup);
    scene.sheets.push(SheetSpec { name: "striker".into(), size, placement, velocity, ..first.clone() });
    let bounds = |index: usize| Sheet::build(scene, index).map(|s| s.state.x.bounds().unwrap_or_default());
    let ((_, top), (bottom, _)) = (bounds(0)?, bounds(1)?);
    let height = top.y - bottom.y + 2.0 * setup.contact_offset()? + APART;
    scene.sheets[1].placement.position = DVec3::new(0.1 * setup.length, height, 0.05 * setup.width);
    Ok(())
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s) of all sheets and dynamic
/// bodies.
fn momenta(world: &World) -> (DVec3, DVec3) {
    let sheets = world.sheets().iter().map(|s| {
        let p = s.momentum();
        (p, s.angular_momentum() + s.centre_of_mass().cross(p))
    });
    let bodies = world.body_state("ball").map(|b| (b.momentum(), b.angular_momentum(DVec3::ZERO)));
    sheets.chain(bodies).fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (q, m)| (p + q, l + m))
}
