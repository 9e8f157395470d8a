//! Temperature of a sheet before a heater. One side sees a black heater with a view factor; the
//! rest of that side and the other side see the surroundings. Heat flows by radiation and optional
//! convection.

use serde_json::json;

use crate::measure::cooling::gentle_step;
use crate::measure::thermal::HeatRig;
use crate::measure::{RigResult, Setup};
use sheetwork::thermal::source::{HeatSource, HeatedSheet, SourceInputs, fourth_power};

/// A black heater with one view factor for the whole upper side.
struct BlackHeater {
    celsius: f64,
    view: f64,
}

impl HeatSource for BlackHeater {
    fn add_exchange(&mut self, _index: usize, moment: &SourceInputs, target: &mut HeatedSheet) {
        let above = fourth_power(self.celsius) - fourth_power(moment.room.celsius);
        for i in 0..target.faces.patches.len() {
            let patch = target.faces.patches[i];
            if patch.up {
                target.irradiate(patch, self.view, above);
            }
        }
    }
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let t = &setup.thermal;
    let seconds = t.seconds.unwrap_or(60.0);
    let from = t.from.unwrap_or(t.ambient);
    let mut rig = HeatRig::new(setup, from)?;
    rig.add(Box::new(BlackHeater { celsius: t.heater, view: t.view }));
    let gentle = gentle_step(setup, t.heater, from).min(gentle_step(setup, from, t.ambient));
    let steps = (seconds / setup.dt.unwrap_or(gentle)).ceil().clamp(1.0, 200_000.0);
    let dt = seconds / steps;
    (0..steps as u64).for_each(|_| rig.step(dt));
    let mean = rig.mean();
    Ok(rig.outcome(dt, json!({ "temperature_c": mean })))
}
