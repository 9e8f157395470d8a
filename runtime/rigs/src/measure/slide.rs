//! Stopping distance of a sheet that slides on a floor or on a fixed sheet: d = v²/(2 μ g) from
//! speed v with friction μ.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigOutcome, RigResult, Runner, Setup, ground};
use sheetwork::scene::Placement;

/// Speed at which the sheet has stopped, as a fraction of the initial speed. Its layers can still
/// oscillate.
const STOPPED: f64 = 1e-4;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    let deceleration = setup.friction * setup.gravity;
    let expected = (deceleration > 0.0).then(|| setup.speed * setup.speed / (2.0 * deceleration));
    ground::place_on_ground(setup, &mut scene, Placement::default(), expected.unwrap_or(setup.speed))?;
    scene.sheets[0].velocity = DVec3::new(setup.speed, 0.0, 0.0);
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    let start = runner.world.sheets()[0].centre_of_mass().x;
    let time = if deceleration > 0.0 { setup.speed / deceleration } else { 1.0 };
    let mut stopped = false;
    runner.run((1.2 * time + 2.0 * runner.world.dt()).min(100.0), |world| {
        watch.observe_step(world);
        let sheet = &world.sheets()[0];
        stopped = sheet.momentum().x / sheet.total_mass() < STOPPED * setup.speed;
        !stopped
    });
    let distance = runner.world.sheets()[0].centre_of_mass().x - start;
    let scale = contact_observer::energy_of_speed(&runner.world, setup.speed);
    let own = json!({
        "speed_m_s": setup.speed,
        "friction": setup.friction,
        "distance_m": stopped.then_some(distance),
        "stopped_s": stopped.then_some(runner.world.time()),
        "expected_distance_m": expected,
    });
    Ok(RigOutcome { settled: Some(stopped), ..runner.contact_outcome(&watch, scale, own) })
}
