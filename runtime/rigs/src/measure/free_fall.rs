//! Free fall of a sheet for one second: the integrator's own error against ½ g t².

use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut runner = Runner::new(setup.world(&setup.scene())?);
    let start = runner.world.sheets()[0].centre_of_mass().y;
    runner.run(1.0, |_| true);
    let time = runner.world.time();
    let drop = start - runner.world.sheets()[0].centre_of_mass().y;
    let exact = 0.5 * setup.gravity * time * time;
    let keys = json!({ "drop_m": drop, "expected_drop_m": exact, "drop_error_m": drop - exact });
    Ok(runner.outcome(keys))
}
