//! A flat drop on the middle of a static box. The sheet must not penetrate, gain energy or
//! oscillate for ever, and must lie on the box bent by the weight of its overhang.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigOutcome, RigResult, Runner, Setup, body};
use sheetwork::World;
use sheetwork::scene::Shape;

/// Time limit to come to rest after the fall, s.
const REST_TIMEOUT: f64 = 4.0;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    let side = setup.box_side;
    scene.bodies.push(body("box", Shape::Box(DVec3::splat(side)), DVec3::new(0.0, -0.5 * side, 0.0)));
    scene.sheets[0].placement.position = DVec3::new(0.0, setup.height + setup.contact_offset()?, 0.0);
    let places = [("0", (0.0, 0.0)), ("1", (1.0, 0.0)), ("2", (0.0, 1.0)), ("3", (1.0, 1.0)), ("centre", (0.5, 0.5))];
    scene.sheets[0].probes.extend(places.map(|(name, uv)| (name.to_owned(), uv)));
    let mut runner = Runner::new(setup.world_with_sleep(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    let fall = setup.fall_time(setup.height)?;
    watch.run_to_sleep(&mut runner, (fall + REST_TIMEOUT).min(1e3));
    let (corners, centre) = heights(&runner.world);
    let scale = contact_observer::fall_energy(&runner.world, setup.height);
    let own = json!({
        "height_m": setup.height,
        "box_m": side,
        "friction": setup.friction,
        "restitution": setup.restitution,
        "corner_below_centre_m": centre - corners,
        "centre_m": centre,
    });
    let settled = Some(watch.still_since().is_some());
    Ok(RigOutcome { settled, ..runner.contact_outcome(&watch, scale, own) })
}

/// Mean height of the corners and height of the centre, m.
fn heights(world: &World) -> (f64, f64) {
    let (mut corners, mut centre) = (0.0, 0.0);
    for sheet in world.sheets() {
        for probe in &sheet.probes {
            let y = probe.at(&sheet.state.x).y;
            if probe.name == "centre" { centre = y } else { corners += 0.25 * y }
        }
    }
    (corners, centre)
}
