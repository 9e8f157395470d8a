//! Lateral buckling of a strip on its edge, clamped at one end, with gravity in its plane: the load
//! at the onset.
//!
//! Γ = 12 ρ g L³/(E t²) increases until the tangent stiffness of the in-plane equilibrium is no
//! longer positive definite. For a strip much longer than wide the onset is 12.8538 √(2/(1+ν))
//! (Timoshenko and Gere, *Theory of Elastic Stability*, lateral buckling of a cantilever under its
//! own weight).

use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};
use sheetwork::scene::{PinSpec, Region};
use sheetwork::{InputError, World};

/// Relative tolerance of the bisection.
const PGS_TOLERANCE: f64 = 1e-6;
/// Maximum Γ.
const MAXIMUM_LOAD: f64 = 1e6;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = Setup { damping_ratio: 0.0, ..setup.clone() }.scene();
    scene.sheets[0].pins.push(PinSpec::clamped(Region::Left));
    let mut free = setup.world(&scene)?;
    // A copy of the strip constrained to its plane, for the equilibrium before buckling.
    let mut flat = scene.clone();
    flat.sheets[0].pins.push(PinSpec { axes: (false, true, false), ..PinSpec::fixed(Region::All) });
    let mut flat = setup.world(&flat)?;
    let material = &setup.material;
    let per_gravity = 12.0 * material.density * setup.length.powi(3) / (material.young * material.thickness.powi(2));
    let mut solves = 0;
    let mut stands = |gamma: f64| -> Result<bool, InputError> {
        stands_at(&mut flat, &mut free, gamma / per_gravity, setup, &mut solves)
    };
    let (mut low, mut high) = (0.0, 10.0);
    while stands(high)? && high < MAXIMUM_LOAD {
        (low, high) = (high, 2.0 * high);
    }
    let found = high < MAXIMUM_LOAD;
    while found && high - low > PGS_TOLERANCE * high {
        let middle = 0.5 * (low + high);
        if stands(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    let keys = json!({
        "onset_gamma": found.then_some(0.5 * (low + high)),
        "slender_gamma": 12.8538 * (2.0 / (1.0 + material.poisson)).sqrt(),
        "linear_solves": solves,
    });
    Ok(Runner::new(free).outcome(keys))
}

/// Whether the in-plane equilibrium under gravity `g` (m/s², across the length, in the plane) is
/// stable.
fn stands_at(flat: &mut World, free: &mut World, g: f64, setup: &Setup, solves: &mut u32) -> Result<bool, InputError> {
    flat.set_gravity_unbounded(glam::DVec3::new(0.0, 0.0, -g));
    *solves += flat.find_equilibrium(1e-12 * setup.length).iter().map(|e| e.solves).sum::<u32>();
    let x = flat.sheets()[0].state.x.clone();
    let sheet = &mut free.sheets_mut()[0];
    sheet.state.x.copy_from(&x);
    *solves += 1;
    Ok(sheet.is_stable())
}
