//! Droop of a sheet clamped horizontally along one edge, under its own weight.
//!
//! The clamp fixes position and slope of the edge nodes; the length starts there. At a Poisson's
//! ratio of zero the sheet bends like a strip, and the reference is the heavy elastica. For an
//! orthotropic material it is that of a narrow strip at the angle to the warp (thesis equation
//! 1.15).

use serde_json::json;

use crate::measure::{FreeEdge, RigResult, Runner, Setup};
use sheetwork::scene::Region;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    setup.clamp(&mut scene, Region::Left);
    let mut runner = Runner::new(setup.world(&scene)?);
    let solves = runner.bring_to_rest(setup);
    let sheet = &runner.world.sheets()[0];
    let edge = FreeEdge::new(sheet, &sheet.state.x);
    let (root, size) = (scene.sheets[0].placement.position, scene.sheets[0].size.0);
    let drop = root.y - edge.middle.y;
    let strip = match &setup.material.orthotropic {
        Some(measured) => Some(measured.bending_at(measured.direction)),
        None => (setup.material.poisson == 0.0).then(|| setup.material.plate_stiffness()),
    };
    let reference = strip.map(|stiffness| {
        let weight = setup.material.density * setup.material.thickness * setup.gravity;
        size * sheetwork::material::elastica::elastica(weight * size.powi(3) / stiffness).0
    });
    let keys = json!({
        "drop_m": drop,
        "reach_m": edge.middle.x - (root.x - 0.5 * size),
        "corner_drop_m": root.y - edge.corners.y,
        "reference_drop_m": reference,
        "linear_solves": solves,
    });
    Ok(runner.outcome(keys))
}
