//! Sag of a square sheet on two opposite edge lines, fixed vertically, with free rotation and
//! in-plane motion.

use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};
use sheetwork::InputError;
use sheetwork::scene::{PinSpec, Region};

pub(crate) fn run(setup: &Setup) -> RigResult {
    if setup.outlined {
        return Err(InputError::new("outlined", "is not offered for this case"));
    }
    let side = setup.side.unwrap_or(setup.length);
    let setup = &Setup { length: side, width: side, ..setup.clone() };
    let mut scene = setup.scene();
    let (nx, _, nz) = scene.sheets[0].grid;
    let at = |i: u32, j: u32| j * nx + i;
    let axes = |region, axes| PinSpec { axes, ..PinSpec::fixed(region) };
    let ends = (0..nz).flat_map(|j| [at(0, j), at(nx - 1, j)]).collect();
    scene.sheets[0].pins.extend([
        axes(Region::Masses(ends), (false, true, false)),
        // In-plane rigid motion is fixed at nodes without reaction force.
        axes(Region::Masses(vec![at(nx / 2, nz / 2)]), (true, false, true)),
    ]);
    if nx > 2 {
        let beside = Region::Masses(vec![at(nx / 2 - 1, nz / 2)]);
        scene.sheets[0].pins.push(axes(beside, (false, false, true)));
    }
    let mut runner = Runner::new(setup.world(&scene)?);
    let solves = runner.bring_to_rest(setup);
    let sheet = &runner.world.sheets()[0];
    let Some(bottom) = sheet.model.layers.first() else { return Ok(runner.outcome(json!({}))) };
    let place = |i: u32, j: u32| sheet.state.x.get(bottom.at(i, j) as usize);
    let (right, front) = (bottom.nx - 1, bottom.nz - 1);
    // Interpolated between two nodes for an even number of nodes.
    let middle = |j: u32| 0.5 * (place(right / 2, j).y + place(right.div_ceil(2), j).y);
    let level = place(0, 0).y;
    let span: f64 = (0..bottom.nz).map(|j| (place(right, j).x - place(0, j).x) / f64::from(bottom.nz)).sum();
    let keys = json!({
        "length_m": side,
        "width_m": side,
        "sag_centre_m": level - 0.5 * (middle(front / 2) + middle(front.div_ceil(2))),
        "sag_edge_m": level - 0.5 * (middle(0) + middle(front)),
        "slide_in_m": 0.5 * (side - span),
        "linear_solves": solves,
    });
    Ok(runner.outcome(keys))
}
