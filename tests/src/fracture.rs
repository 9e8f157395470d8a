//! Random fractures, and the angle at which an adhesive sheet slips.

use glam::DVec3;
use sheetwork::scene::Scene;

use crate::{excite_randomly, world};

/// Steps of a random fracture.
const STEPS: u32 = 40;

/// Throw the nodes of the first sheet of `scene` about with `speed` (m/s), stretch it by the strain
/// `stretch` and step it. Opening of cells must not add energy, and a torn sheet may gain at most
/// the part `most` of its kinetic and elastic energy in a step. Returns the largest gain of the
/// torn sheet; `None` for a sheet that stays whole.
///
/// # Panics
/// When energy is added, or the sheet is unstable.
pub fn fracture_at_random(
    scene: &Scene,
    (speed, stretch): (f64, f64),
    seed: u64,
    most: f64,
    what: &str,
) -> Option<f64> {
    let mut world = world(scene);
    let sheet = &mut world.sheets_mut()[0];
    excite_randomly(sheet, speed, seed);
    for i in (0..sheet.node_count()).filter(|i| !sheet.is_held(*i)).collect::<Vec<_>>() {
        let p = sheet.state.x.get(i);
        sheet.state.x.set(i, p + DVec3::new(p.x + 0.1, 0.0, p.z) * stretch);
    }
    let first = world.energy();
    let (mut last, mut scale, mut freed, mut worst) = (first.total, first.kinetic, 0.0, 0.0_f64);
    for _ in 0..STEPS {
        world.step();
        let energy = world.energy();
        // Relative to kinetic plus elastic energy, because gravity adds to the initial push.
        scale = scale.max(energy.kinetic + energy.elastic);
        let rise = (energy.total - last) / scale;
        let released = world.sheets()[0].energy_released();
        assert!(released >= freed, "{what}: opening adds {} J of {scale}", freed - released);
        freed = released;
        if world.sheets()[0].open_count() > 0 {
            worst = worst.max(rise);
            assert!(rise < most, "{what}: rises by {rise}");
        }
        last = energy.total;
    }
    assert!(world.unstable().is_none(), "{what}");
    (world.sheets()[0].open_count() > 0).then_some(worst)
}

/// Angle (rad) at which a sheet with adhesion begins to slip on an incline:
/// sin θ = `friction` (cos θ + `share`), with the strength `share` times ρ t g; by bisection.
pub fn slip_angle(friction: f64, share: f64) -> f64 {
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if middle.sin() < friction * (middle.cos() + share) { low = middle } else { high = middle }
    }
    low
}
