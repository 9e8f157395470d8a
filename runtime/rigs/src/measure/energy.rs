//! Energy of an undamped sheet, clamped along one edge and released flat, over ten seconds. It must
//! not rise.
//!
//! The rise is relative to the energy at the start minus the energy of the equilibrium.

use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};
use sheetwork::scene::Region;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = Setup { damping_ratio: 0.0, ..setup.clone() }.scene();
    setup.clamp(&mut scene, Region::Left);
    let mut rest = setup.world(&scene)?;
    rest.find_equilibrium(1e-9 * setup.length);
    let gravity = scene.gravity;
    let least = rest.sheets()[0].energy(gravity).total;
    let mut runner = Runner::new(setup.world(&scene)?);
    let start = runner.world.sheets()[0].energy(gravity).total;
    let (mut highest, mut last) = (start, start);
    runner.run(10.0, |world| {
        last = world.sheets()[0].energy(gravity).total;
        highest = highest.max(last);
        true
    });
    let set_free = start - least;
    let keys = json!({
        "energy_gain": (highest - start) / set_free,
        "energy_kept": (last - least) / set_free,
        "set_free_j": set_free,
        "linear_solves": runner.world.sheets()[0].state.counters.evaluations,
    });
    Ok(runner.outcome(keys))
}
