//! Heat conduction along an insulated sheet after a temperature jump at one edge.
//!
//! The profile is (T - T₀)/(T₁ - T₀) along the middle row at a Fourier number κ τ/L². `heat_lost`
//! is the relative change of heat content over further steps in which all edges are insulated.

use serde_json::json;

use crate::measure::thermal::outcome;
use crate::measure::{RigResult, Setup};
use sheetwork::InputError;
use sheetwork::sheet::Sheet;
use sheetwork::sheet::temperature::conduction::{ConductionStepper, Exchange};

/// Number of steps when no step is given.
const STEPS: f64 = 500.0;
/// Number of steps with all edges insulated.
const INSULATED_STEPS: usize = 200;
/// Convection coefficient of the warm edge, over conductivity times thickness. Large enough to
/// prescribe its temperature.
const EDGE_CONVECTION_FACTOR: f64 = 1e9;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let sheet = Sheet::build(&setup.scene(), 0)?;
    let material = sheet.material();
    let diffusivity = material.conductivity / (material.density * material.specific_heat);
    if diffusivity <= 0.0 {
        return Err(InputError::new("material.conductivity", "0 W/(m K) conducts nothing"));
    }
    let time = setup.thermal.fourier * setup.length * setup.length / diffusivity;
    let steps = setup.dt.map_or(STEPS, |dt| (time / dt).ceil());
    let dt = time / steps;
    let mut stepper = ConductionStepper::new(&sheet, 1);
    let mut exchange = Exchange::default();
    exchange.clear(sheet.node_count());
    let mut celsius = vec![0.0; sheet.node_count()];
    for i in (0..sheet.node_count()).filter(|i| sheet.model.uv[*i].0 <= 1e-9) {
        exchange.convection[i] = EDGE_CONVECTION_FACTOR * material.conductivity * material.thickness;
        exchange.supply[i] = exchange.convection[i];
        celsius[i] = 1.0;
    }
    let start = cpu_time::ProcessTime::now();
    (0..steps as u64).for_each(|_| stepper.advance(&mut celsius, &exchange, dt));
    let cpu = start.elapsed().as_secs_f64();
    let row: Vec<usize> = match sheet.model.layers.first().filter(|_| sheet.model.triangles.is_none()) {
        Some(layer) => (0..layer.nx).map(|i| layer.at(i, layer.nz / 2) as usize).collect(),
        None => return Err(InputError::new("outlined", "the profile is along a row of a grid")),
    };
    let profile: Vec<f64> = row.iter().map(|i| celsius[*i]).collect();
    let places: Vec<f64> = row.iter().map(|i| sheet.model.uv[*i].0).collect();
    let before = stepper.heat(&celsius);
    exchange.clear(sheet.node_count());
    (0..INSULATED_STEPS).for_each(|_| stepper.advance(&mut celsius, &exchange, dt));
    let keys = json!({
        "fo": setup.thermal.fourier,
        "time_s": time,
        "x_over_l": places,
        "profile": profile,
        "heat_lost": stepper.heat(&celsius) / before - 1.0,
    });
    Ok(outcome(dt, (steps as u64, time, cpu), keys))
}
