//! A sheet that lands on its edge or corner on a floor, or with its surface on the ridge or the tip of a body: where contact of
//! stiff sheets fails first. How far it rebounds has no closed form; it is given with its dependence on the step.

use glam::DVec3;
use serde_json::{Value, json};

use super::bodies::pyramid;
use super::watch::{self, Watch};
use super::{Case, Outcome, Runner, Setup, body, plane};
use crate::World;
use crate::error::InputError;
use crate::scene::{Placement, Polyhedron, Scene, Shape};
use crate::sheet::Sheet;

pub(super) const CASE: Case = Case {
    name: "edge-landing",
    about: "a landing on an edge: --angle DEG --height M [--corner] [--edge-of-body] [--refine N]",
    contact: true,
    run,
};

/// Height of the wedge and the needle that the surface lands on, m.
const OBSTACLE: f64 = 0.08;
/// How long the landing is watched, s.
const WATCHED: f64 = 2.0;

/// What became of a landing.
struct Landing {
    runner: Runner,
    watch: Watch,
    /// Largest upward speed of the centre of mass after the first contact, m/s; none where there was no contact.
    rebound_speed: Option<f64>,
    /// Largest distance of the lowest mass from the floor after the first contact, m.
    rebound: Option<f64>,
    scale: f64,
}

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let landing = land(setup)?;
    let dt = landing.runner.world.dt();
    let mut by_step = vec![json!({ "dt_s": dt, "rebound_speed_m_s": landing.rebound_speed })];
    for halving in 1..=setup.refine {
        let dt = dt * 0.5_f64.powi(halving as i32);
        let finer = land(&Setup { dt: Some(dt), ..setup.clone() })?;
        by_step.push(json!({ "dt_s": dt, "rebound_speed_m_s": finer.rebound_speed }));
    }
    let Landing { runner, watch, rebound_speed, rebound, scale } = landing;
    let mut keys = watch.keys(&runner.world, scale);
    if let Value::Object(own) = json!({
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
    }) {
        keys.extend(own);
    }
    Ok(runner.outcome(Value::Object(keys)))
}

/// The sheet over what it lands on, and the height of its lowest mass over where it would lie on the floor, m.
///
/// On the floor it is tilted by the angle, an edge or a corner lowest. Over a body it is level and turned by the angle in its own
/// plane, so that no line of its grid lies along a ridge, and a fifth of its length off the middle, so that it tips off.
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
    let lowest = sheet.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    scene.sheets[0].placement.position.y = height + setup.half_thickness()? - lowest;
    Ok((scene, height))
}

fn land(setup: &Setup) -> Result<Landing, InputError> {
    let (scene, height) = situation(setup)?;
    let mut runner = Runner::new(setup.sleepy_world(&scene)?);
    let mut watch = Watch::new(&runner.world);
    // The centre falls from where it is to where it lies flat.
    let half = setup.half_thickness()?;
    let scale = runner.world.sheets().first().map_or(0.0, |s| watch::fall(&runner.world, s.centre_of_mass().y - half));
    let fall = setup.fall(height)?;
    let (mut met, mut rebound, mut speed) = (false, 0.0_f64, 0.0_f64);
    runner.run((fall + WATCHED).min(1e3), |world| {
        watch.see(world);
        if met {
            rebound = rebound.max(watch::lowest(world, DVec3::ZERO, DVec3::Y) - half);
            speed = speed.max(rise(world));
        }
        met |= watch::touched(world);
        !watch.asleep()
    });
    Ok(Landing { runner, watch, rebound_speed: met.then_some(speed), rebound: met.then_some(rebound), scale })
}

/// Upward speed of the centre of mass, m/s.
fn rise(world: &World) -> f64 {
    world.sheets().first().map_or(0.0, |s| s.momentum().y / s.total_mass())
}
