//! Delivered stiffness of a structure relative to the requested one: by homogenisation of a lattice
//! of springs, by construction for the shell (the test suite compares its energies with those of a
//! plate).

use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};
use sheetwork::material::calibration::{CalibrationRequest, calibrate};

pub(crate) fn run(setup: &Setup) -> RigResult {
    let scene = setup.scene();
    let spec = &scene.sheets[0];
    let material = &setup.material;
    let found = calibrate(&CalibrationRequest::new(
        spec.structure,
        spec.grid,
        spec.size,
        material.target(),
        material.areal_mass(),
    ))?;
    let delivered = found.delivered;
    let runner = Runner::new(setup.world(&scene)?);
    let estimate = runner.world.sheets()[0].delivered_stiffness(runner.world.dt());
    let keys = json!({
        "bending_0_45_90_135": delivered.bending,
        "twist": delivered.twist,
        "membrane": delivered.membrane,
        "poisson_ratio": delivered.poisson_ratio,
        "residual": delivered.residual,
        "shear_loss": delivered.shear_loss,
        "bends_as_pa": estimate.map(|e| e.bends_as_pa),
        "notes": delivered.notes,
    });
    Ok(runner.outcome(keys))
}
