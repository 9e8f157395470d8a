//! A sheet dropped flat from a height on a floor with restitution e: it rebounds to h e², h e⁴ and so on.

use glam::DVec3;
use serde_json::json;

use super::{Case, Outcome, Runner, Setup, plane};
use crate::World;
use crate::contact::SKIN;
use crate::error::InputError;
use crate::scene::Placement;

pub(super) const CASE: Case =
    Case { name: "bounce", about: "rebound heights of a flat drop: --height M --restitution E", contact: true, run };

/// Rebounds that are waited for.
const REBOUNDS: usize = 3;

fn run(setup: &Setup) -> Result<Outcome, InputError> {
    let mut scene = setup.scene();
    scene.bodies.push(plane("floor", Placement::default()));
    scene.sheets[0].placement.position = DVec3::new(0.0, setup.height + SKIN, 0.0);
    let mut runner = Runner::new(setup.world(&scene)?);
    let centre = runner.world.sheets()[0].centre_of_mass().y - setup.height;
    let height = |world: &World| world.sheets()[0].centre_of_mass().y - centre;
    let rise = |world: &World| world.sheets()[0].momentum().y / world.sheets()[0].total_mass();
    let mut heights = Vec::new();
    let (mut last_height, mut last_rise) = (setup.height, 0.0);
    // Fall, and twice the rise of each rebound.
    let e = setup.restitution;
    let fall = (2.0 * setup.height / setup.gravity.max(1e-9)).sqrt();
    let duration = fall * (1.05 + 2.0 * (e + e * e + e * e * e)) + 0.02;
    runner.run(duration.min(1e3), |world| {
        let now = rise(world);
        if last_rise > 0.0 && now <= 0.0 {
            // Between two steps the flight is a parabola: it tops out v²/2g above the last rising point.
            heights.push(last_height + last_rise * last_rise / (2.0 * setup.gravity));
        }
        (last_height, last_rise) = (height(world), now);
        heights.len() < REBOUNDS
    });
    let expected: Vec<f64> = (1..=REBOUNDS as i32).map(|n| setup.height * e.powi(2 * n)).collect();
    let keys = json!({
        "height_m": setup.height,
        "restitution": e,
        "heights_m": heights,
        "expected_heights_m": expected,
    });
    Ok(runner.outcome(keys))
}
