//! Landing of a sheet with its edge or corner on a floor, or with its surface on the ridge or tip
//! of a body. Contact of stiff sheets is hardest here. The rebound has no closed form; it is
//! reported as a function of the step.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigResult, Runner, Setup, body, plane};
use sheetwork::scene::polyhedron::pyramid::pyramid;
use sheetwork::scene::{Placement, Polyhedron, Scene, Shape};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

/// Height of the wedge or needle, m.
const OBSTACLE: f64 = 0.08;
/// Duration of observation after the fall, s.
const WATCHED: f64 = 2.0;

/// Result of a landing.
struct Landing {
    runner: Runner,
    watch: ContactObserver,
    /// Largest upward speed of the centre of mass after the first contact, m/s; `None` without
    /// contact.
    rebound_speed: Option<f64>,
    /// Largest distance of the lowest node from the floor after the first contact, m.
    rebound: Option<f64>,
    scale: f64,
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let landing = land(setup)?;
    let dt = landing.runner.world.dt();
    let mut by_step = vec![json!({ "dt_s": dt, "rebound_speed_m_s": landing.rebound_speed })];
    for halving in 1..=setup.refine {
        let dt = dt * 0.5_f64.powi(halving as i32);
        let finer = land(&Setup { dt: Some(dt), ..setup.clone() })?;
        by_step.push(json!({ "dt_s": dt, "rebound_speed_m_s": finer.rebound_speed }));
    }
    let Landing { runner, watch, rebound_speed, rebound, scale } = landing;
    let own = json!({
        "angle_deg": setup.angle,
        "height_m": setup.height,
        "corner": setup.corner,
        "edge_of_body": setup.edge_of_body,
        "friction": setup.friction,
        "restitution": setup.restitution,
        "max_body_edge_penetration_m": setup.edge_of_body.then_some(watch.surface),
        "rebound_m": rebound,
        "rebound_speed_m_s": rebound_speed,
        "rebound_speed_by_step": by_step,
    });
    Ok(runner.contact_outcome(&watch, scale, own))
}

/// The scene, and the height (m) of the lowest node above its resting height on the floor.
///
/// Above the floor the sheet is tilted by the angle with an edge or corner lowest. Above a body it
/// is level, turned in its own plane by the angle so that no grid line lies along a ridge, and
/// offset by a fifth of its length so that it tips off.
fn situation(setup: &Setup) -> Result<(Scene, f64), InputError> {
    let mut scene = setup.scene();
    scene.bodies.push(plane("floor", Placement::default()));
    let mut height = setup.height;
    if setup.edge_of_body {
        let depth = 4.0 * setup.length.max(setup.width);
        let shape =
            if setup.corner { pyramid(0.2 * OBSTACLE, OBSTACLE) } else { Polyhedron::wedge(OBSTACLE, OBSTACLE, depth) };
        scene.bodies.push(body("obstacle", Shape::Polyhedron(shape), DVec3::ZERO));
        scene.sheets[0].placement.rotation = DVec3::new(0.0, setup.angle, 0.0);
        scene.sheets[0].placement.position.x = 0.2 * setup.length;
        height += OBSTACLE;
    } else {
        let yaw = if setup.corner { 45.0 } else { 0.0 };
        scene.sheets[0].placement.rotation = DVec3::new(0.0, yaw, setup.angle);
    }
    let sheet = Sheet::build(&scene, 0)?;
    let lowest = sheet.state.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    scene.sheets[0].placement.position.y = height + setup.contact_offset()? - lowest;
    Ok((scene, height))
}

fn land(setup: &Setup) -> Result<Landing, InputError> {
    let (scene, height) = situation(setup)?;
    let mut runner = Runner::new(setup.world_with_sleep(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    // The centre of mass falls to its height in a flat sheet on the floor.
    let half = setup.contact_offset()?;
    let scale = runner
        .world
        .sheets()
        .first()
        .map_or(0.0, |s| contact_observer::fall_energy(&runner.world, s.centre_of_mass().y - half));
    let fall = setup.fall_time(height)?;
    let (mut met, mut rebound, mut speed) = (false, 0.0_f64, 0.0_f64);
    runner.run((fall + WATCHED).min(1e3), |world| {
        watch.observe_step(world);
        if met {
            rebound = rebound.max(contact_observer::lowest(world, DVec3::ZERO, DVec3::Y) - half);
            speed = speed.max(rise(world));
        }
        met |= contact_observer::has_touched(world);
        !watch.asleep()
    });
    Ok(Landing { runner, watch, rebound_speed: met.then_some(speed), rebound: met.then_some(rebound), scale })
}

/// Upward speed of the centre of mass, m/s.
fn rise(world: &World) -> f64 {
    world.sheets().first().map_or(0.0, |s| s.momentum().y / s.total_mass())
}
