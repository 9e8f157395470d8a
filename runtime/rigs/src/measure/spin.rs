//! Conservation of angular momentum and energy of a sheet that spins about an oblique axis, without
//! gravity, air or damping.

use glam::DVec3;
use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = Setup { damping_ratio: 0.0, ..setup.clone() }.scene();
    scene.gravity = DVec3::ZERO;
    // The axis lies mostly in the plane, so that the sheet also bends.
    scene.sheets[0].spin = DVec3::new(2.0, 1.0, 2.0) * (setup.rate / 3.0);
    let mut runner = Runner::new(setup.world(&scene)?);
    let sheet = &runner.world.sheets()[0];
    let (momentum, energy) = (sheet.angular_momentum(), sheet.energy(DVec3::ZERO).total);
    let direction = momentum.normalize_or_zero();
    runner.run(1.0, |_| true);
    let sheet = &runner.world.sheets()[0];
    let keys = json!({
        "rate_rad_s": setup.rate,
        "angular_momentum_ratio": sheet.angular_momentum().dot(direction) / momentum.length(),
        "energy_ratio": sheet.energy(DVec3::ZERO).total / energy,
    });
    Ok(runner.outcome(keys))
}
