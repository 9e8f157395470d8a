//! Droop of a square sheet clamped flat on a square patch in its middle, under its own weight.
//!
//! The patch ends on grid lines nearest to the requested size; the output gives its size as built.

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
    // Whole cells on either side of the patch, at least one.
    let outside = |n: u32| {
        let cells = f64::from(n - 1);
        let free = 0.5 * (1.0 - setup.patch / side) * cells;
        free.round().clamp(1.0, (0.5 * cells).floor()) / cells
    };
    let (u, v) = (outside(nx), outside(nz));
    let region = Region::Rect((u, 1.0 - u), (v, 1.0 - v));
    scene.sheets[0].pins.push(PinSpec::clamped(region));
    let mut runner = Runner::new(setup.world(&scene)?);
    let solves = runner.bring_to_rest(setup);
    let sheet = &runner.world.sheets()[0];
    let Some(bottom) = sheet.model.layers.first() else { return Ok(runner.outcome(json!({}))) };
    let height = |i: u32, j: u32| -sheet.state.x.get(bottom.at(i, j) as usize).y;
    let (right, front) = (bottom.nx - 1, bottom.nz - 1);
    let corner = (height(0, 0) + height(right, 0) + height(0, front) + height(right, front)) / 4.0;
    // The middle of an edge, interpolated between two nodes for an even number of nodes.
    let along_x = |j: u32| 0.5 * (height(right / 2, j) + height(right.div_ceil(2), j));
    let along_z = |i: u32| 0.5 * (height(i, front / 2) + height(i, front.div_ceil(2)));
    let edge = (along_x(0) + along_x(front) + along_z(0) + along_z(right)) / 4.0;
    let keys = json!({
        "length_m": side,
        "width_m": side,
        "corner_drop_m": corner,
        "mid_edge_drop_m": edge,
        "patch_m": [side * (1.0 - 2.0 * u), side * (1.0 - 2.0 * v)],
        "linear_solves": solves,
    });
    Ok(runner.outcome(keys))
}
