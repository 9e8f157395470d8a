//! Contact equations of a sheet after a step of its integrator, as for explicit integrators.
//!
//! The integrator has moved the nodes from (x₀, v₀) to (x₁, v₁), their free motion. A contact force
//! p (N) in a step of h (s) acts on each node separately through H = M/h²: Δx = h² p/m, Δv = h p/m.
//! A half solution (see [`HalfSolutions`]) is h p/√m at the loaded nodes.

use glam::DVec3;

use crate::integrators::implicit::staged::ContactJump;
use crate::linear::{HalfSolutions, SparseLoads};
use crate::math::Vectors;
use crate::scene::contact::{MINIMUM_CONTACT_OFFSET, NOMINAL_HALF_THICKNESS};
use crate::sheet::{Sheet, SheetState};

/// Size the work arrays of a step.
pub(crate) fn resize_workspace(sheet: &mut Sheet) {
    let n = sheet.node_count();
    if sheet.work.x_before.len() != n {
        sheet.work.x_before = Vectors::zeros(n);
        sheet.work.v_before = Vectors::zeros(n);
        sheet.state.rest_positions = Vectors::zeros(n);
        sheet.work.layer_impacts = vec![Default::default(); n];
        sheet.state.touching = vec![false; n];
    }
}

/// Material name, friction and restitution coefficient.
pub(crate) fn surface_coefficients(sheet: &Sheet) -> (&str, f64, f64) {
    (&sheet.material().name, sheet.parameters.friction, sheet.parameters.restitution)
}

/// Whether its integrator is explicit.
pub(crate) fn is_explicit(sheet: &Sheet) -> bool {
    !sheet.engine_kind.info().implicit
}

/// Whether nodes respond to contact with their mass alone: with an explicit integrator, and
/// with an implicit one in contact with an explicit sheet.
pub(crate) fn solves_node_by_node(sheet: &Sheet) -> bool {
    sheet.work.stage.node_by_node || is_explicit(sheet)
}

/// Contact offset from the nodes, m: half the thickness of a single layer with the stiffness of
/// its material, otherwise the minimum offset.
pub fn contact_offset(sheet: &Sheet) -> f64 {
    if has_thickness(sheet) { 0.5 * sheet.material().thickness } else { MINIMUM_CONTACT_OFFSET }
}

/// Length to which tolerances of contact refer, m: half the thickness, or that of a common sheet
/// for a surface without thickness.
pub(crate) fn half_thickness(sheet: &Sheet) -> f64 {
    if has_thickness(sheet) { 0.5 * sheet.material().thickness } else { NOMINAL_HALF_THICKNESS }
}

/// Whether the surface is that of a single layer with the stiffness of its material.
fn has_thickness(sheet: &Sheet) -> bool {
    sheet.model.layers.len() <= 1 && sheet.follows_material()
}

/// Corners of the bounding box of the collision surface, m.
pub(crate) fn bounding_box(sheet: &Sheet) -> (DVec3, DVec3) {
    let (low, high) = sheet.state.x.bounds().unwrap_or_default();
    let offset = contact_offset(sheet);
    (low - offset, high + offset)
}

/// Bounding box of a moving sheet, m; invalidates the box of [`resting_box`].
pub(crate) fn moving_box(sheet: &mut Sheet) -> (DVec3, DVec3) {
    sheet.work.resting = None;
    bounding_box(sheet)
}

/// Bounding box of a resting sheet, m, cached until its first or last node has moved.
pub(crate) fn resting_box(sheet: &mut Sheet) -> (DVec3, DVec3) {
    let end = |i: Option<usize>| i.filter(|i| *i < sheet.node_count()).map(|i| sheet.state.x.get(i));
    let ends = (end(Some(0)), end(sheet.node_count().checked_sub(1)));
    if let Some((known, around)) = &sheet.work.resting
        && *known == ends
    {
        return *around;
    }
    let around = moving_box(sheet);
    sheet.work.resting = Some((ends, around));
    around
}

/// Save the state at the start of a step.
pub(crate) fn save_start(sheet: &mut Sheet) {
    let (x, v) = &mut sheet.work.start;
    x.clone_from(&sheet.state.x);
    v.clone_from(&sheet.state.v);
}

/// Swap the state with that at the start of the integrator step.
pub(crate) fn swap_with_step_start(sheet: &mut Sheet) {
    std::mem::swap(&mut sheet.state.x, &mut sheet.work.x_before);
    std::mem::swap(&mut sheet.state.v, &mut sheet.work.v_before);
}

/// Make the result of a step of `dt` (s) the free motion of a contact stage, and return to the
/// start of the step.
pub(crate) fn begin_contact_stage(sheet: &mut Sheet, dt: f64) {
    let Sheet { work, state: SheetState { x, v, .. }, .. } = sheet;
    let stage = &mut work.stage;
    (stage.length, stage.h, stage.is_finished, stage.has_failed, stage.node_by_node) = (dt, dt, false, false, true);
    stage.free_positions.clone_from(x);
    stage.velocity.clone_from(v);
    restore_start(sheet);
}

/// Restore the state at the start of the step.
pub(crate) fn restore_start(sheet: &mut Sheet) {
    let Sheet { work, state: SheetState { x, v, .. }, .. } = sheet;
    x.clone_from(&work.start.0);
    v.clone_from(&work.start.1);
}

/// Copy the start of the step to the start of the integrator step.
pub(crate) fn set_integrator_start(sheet: &mut Sheet) {
    let Sheet { work, .. } = sheet;
    work.x_before.clone_from(&work.start.0);
    work.v_before.clone_from(&work.start.1);
}

/// Positions at the start of the step, m.
pub(crate) fn start_positions(sheet: &Sheet) -> &Vectors {
    &sheet.work.start.0
}

/// Set the free motion plus the displacement and velocity change by contact.
pub(crate) fn apply_contact(sheet: &mut Sheet, jump: Option<&ContactJump>) {
    let Sheet { work, state: SheetState { x, v, .. }, .. } = sheet;
    x.clone_from(&work.stage.free_positions);
    v.clone_from(&work.stage.velocity);
    if let Some(jump) = jump {
        x.add_scaled(1.0, &jump.dx);
        v.add_scaled(1.0, &jump.dv);
    }
}

/// Largest displacement of a node in the stage, m.
pub(crate) fn largest_travel(sheet: &Sheet) -> f64 {
    let pairs = sheet.state.x.iter().zip(sheet.work.stage.free_positions.iter());
    pairs.map(|(p, q)| p.distance_squared(q)).fold(0.0, f64::max).sqrt()
}

/// Node `i` as a block row, and its free (1) and fixed (0) directions; `None` for a fixed node.
pub(crate) fn free_node(sheet: &Sheet, i: u32) -> Option<(u32, DVec3)> {
    let is_free = sheet.inverse_mass.get(i as usize).is_some_and(|w| *w > 0.0);
    is_free.then(|| (i, sheet.pins.free_axes(i)))
}

/// Add the half solutions of `loads`, given by node.
pub(crate) fn half_solve_nodes(sheet: &Sheet, loads: &SparseLoads, solutions: &mut HalfSolutions) {
    for load in loads.iter() {
        let mut last = None;
        let after = |last: Option<u32>| load.iter().map(|e| e.0).filter(|m| last.is_none_or(|l| *m > l)).min();
        while let Some(mass) = after(last) {
            let here = load.iter().filter(|e| e.0 == mass);
            let sum: DVec3 = here.map(|e| DVec3::from_array(e.1)).sum();
            let scale = sheet.work.stage.h * sheet.inverse_mass[mass as usize].sqrt();
            solutions.add_segment(3 * mass as usize, &(sum * scale).to_array());
            last = Some(mass);
        }
        solutions.close();
    }
}

/// Compute the displacement (m) of the nodes by `force` (N).
pub(crate) fn node_displacements(sheet: &Sheet, force: &Vectors, dx: &mut Vectors) {
    let square = sheet.work.stage.h * sheet.work.stage.h;
    for (i, w) in sheet.inverse_mass.iter().enumerate() {
        dx.set(i, force.get(i) * (square * w));
    }
    for (mass, _) in sheet.pins.fixed_axes() {
        let i = mass as usize;
        dx.set(i, dx.get(i) * sheet.pins.free_axes(mass));
    }
}
