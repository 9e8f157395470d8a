//! Time in which a sheet changes from one temperature to another in cooler or warmer surroundings,
//! by radiation on both sides and optional convection.

use serde_json::json;

use crate::measure::thermal::HeatRig;
use crate::measure::{RigResult, Setup};
use sheetwork::InputError;
use sheetwork::units::temperature::{STEFAN_BOLTZMANN, ZERO_CELSIUS};

/// Temperature change of the first step when no step is given, K.
const MAXIMUM_TEMPERATURE_CHANGE: f64 = 0.25;
/// Maximum number of steps.
const MAXIMUM_STEPS: u64 = 200_000;

/// Step (s) for a small temperature change per step, at the heat flow of a sheet at `celsius` in
/// surroundings at `other`.
pub(crate) fn gentle_step(setup: &Setup, celsius: f64, other: f64) -> f64 {
    let t = &setup.thermal;
    let m = &setup.material;
    let fourth = |c: f64| (c + ZERO_CELSIUS).powi(4);
    let flow = 2.0 * m.emissivity * STEFAN_BOLTZMANN * (fourth(celsius) - fourth(other)).abs()
        + t.convection * (celsius - other).abs();
    let capacity = m.areal_mass() * m.specific_heat;
    if flow > 0.0 { (MAXIMUM_TEMPERATURE_CHANGE * capacity / flow).min(1e3) } else { 1.0 }
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let t = &setup.thermal;
    let from = t.from.unwrap_or(120.0);
    let mut rig = HeatRig::new(setup, from)?;
    let dt = setup.dt.unwrap_or_else(|| gentle_step(setup, from, t.ambient));
    // The final temperature lies between the initial one and that of the surroundings.
    let reaches = (t.to - from) * (t.ambient - from) > 0.0 && (t.to - t.ambient) * (from - t.ambient) > 0.0;
    if !reaches && t.to != from {
        let problem = format!("{} °C is never reached from {from} °C in surroundings of {} °C", t.to, t.ambient);
        return Err(InputError::new("--to", problem));
    }
    let mut time = (t.to == from).then_some(0.0);
    let mut steps = 0;
    while reaches && time.is_none() && steps < MAXIMUM_STEPS {
        let before = rig.mean();
        rig.step(dt);
        let now = rig.mean();
        if (now - t.to) * (before - t.to) <= 0.0 {
            time = Some(rig.time - dt * (now - t.to) / (now - before));
        }
        steps += 1;
    }
    let keys = json!({ "from_c": from, "to_c": t.to, "ambient_c": t.ambient, "time_s": time });
    Ok(rig.outcome(dt, keys))
}
