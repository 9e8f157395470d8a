//! State of a sheet that a sheet of another world takes over: of the same nodes, in a scene that
//! was edited.
//!
//! It is the serialised state (`serialization`) without what belongs to the integrator and to the
//! surroundings: the integrator restarts, the parameters keep their present values.

use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::serialization::{self, deserialise_material, serialise_material};
use crate::sheet::{RecoveryState, Sheet, fracture, instability};
use crate::units::temperature::REFERENCE;

/// Serialised state of a sheet at one time, and what a sheet must agree in to take it over.
#[derive(Clone, Debug)]
pub(crate) struct SavedSheetState {
    nodes: usize,
    springs: usize,
    elements: usize,
    /// Whether each node of a heated sheet has one or two temperatures; 0 without heat.
    temperatures_per_node: usize,
    is_inelastic: bool,
    /// Whether steps have changed the law of the elements or the open cells.
    is_changed: bool,
    /// Cells opened since the start; empty for a sheet that cannot open.
    open: Vec<bool>,
    bytes: Vec<u8>,
}

/// Copy the present state.
pub(crate) fn to_state(sheet: &Sheet) -> SavedSheetState {
    let mut to = StateWriter::default();
    sheet.state.serialise_motion(&mut to);
    sheet.state.heat.iter().for_each(|heat| heat.serialise(&mut to));
    if serialization::is_changed(sheet) {
        serialise_material(&sheet.parameters.material, &mut to);
        serialization::serialise_changes(sheet, &mut to);
    }
    to.option(sheet.recovery.as_ref(), |guard, to| guard.state.serialise(to));
    to.option(sheet.state.adhesion.as_ref(), |bonds, to| bonds.serialise(to));
    serialization::serialise_arms(sheet, &mut to);
    SavedSheetState {
        nodes: sheet.node_count(),
        springs: sheet.springs.len(),
        elements: sheet.elements.len() - sheet.grabs.len(),
        temperatures_per_node: sheet.state.heat.as_ref().map_or(0, |heat| heat.points()),
        is_inelastic: sheet.state.inelastic.is_some(),
        is_changed: serialization::is_changed(sheet),
        open: fracture::torn_cells(sheet),
        bytes: to.bytes,
    }
}

/// Whether `state` is compatible with this sheet.
pub(crate) fn accepts_state(sheet: &Sheet, state: &SavedSheetState) -> bool {
    let cells = sheet.open_cells().map_or_else(|| state.open.len(), <[bool]>::len);
    // A later change of the slits leaves the nodes as they are.
    let same_cells = state.open.len() == cells || !state.open.contains(&true);
    let points = if sheet.model.described_temperature.has_gradient { 2 } else { 1 };
    let same_elements = state.elements == sheet.elements.len() - sheet.grabs.len()
        && state.springs == sheet.springs.len()
        && state.is_inelastic == sheet.state.inelastic.is_some();
    state.nodes == sheet.node_count()
        && same_cells
        && (state.temperatures_per_node == 0 || state.temperatures_per_node == points)
        && (!state.is_changed || same_elements)
}

/// Restore a compatible `state`. The integrator restarts; the material stays as it is.
pub(crate) fn restore(sheet: &mut Sheet, state: &SavedSheetState) -> ReadResult {
    let mut from = StateReader::new(&state.bytes);
    sheet.wake();
    let rest = sheet.state.deserialise_motion(&mut from)?;
    if state.open.contains(&true) {
        fracture::prepare_cut(sheet);
    }
    fracture::set_open(sheet, &state.open);
    if state.temperatures_per_node > 0 {
        serialization::deserialise_temperatures(sheet, &mut from)?;
        sheet.state.heat.iter_mut().for_each(|heat| heat.discard_network());
    } else if sheet.state.heat.is_some() {
        // A state without temperatures is at the reference temperature.
        let _ = sheet.set_temperatures(|_| REFERENCE);
    }
    if state.is_changed {
        // The changes refer to the material of their time. Both materials are valid, and a
        // creeping sheet keeps its creep constants, so that setting them succeeds.
        let (then, now) = (deserialise_material(&mut from)?, sheet.parameters.material.clone());
        let _ = sheet.set_material(then);
        serialization::deserialise_changes(sheet, &mut from)?;
        let _ = sheet.set_material(now);
    }
    let recovery = if from.flag()? { Some(RecoveryState::deserialise(&mut from)?) } else { None };
    serialization::deserialise_adhesion(sheet, &mut from)?;
    if serialization::deserialise_arms(sheet, &mut from).is_err() {
        // The damping has changed since.
        sheet.elements.iter_mut().filter_map(|e| e.arms_mut()).for_each(|arms| arms.relax());
    }
    sheet.state.touching.fill(false);
    sheet.state.flexion_impulses.clear();
    sheet.work.stage.has_diverged = false;
    instability::restore_recovery_state(sheet, recovery);
    sheet.engine.restart();
    sheet.last_field = None;
    sheet.system = None;
    sheet.state.set_rest(rest);
    Ok(())
}
