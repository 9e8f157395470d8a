//! State of a sheet that a sheet of another world takes over: of the same nodes, in a scene that was
//! edited.
//!
//! It is the serialised state (`serialization`) without what belongs to the integrator and to the
//! surroundings: the integrator restarts, the parameters keep their present values.

use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::serialization::{deserialise_material, serialise_material};
use crate::sheet::{RecoveryState, Sheet};
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

impl Sheet {
    /// Copy the present state.
    pub(crate) fn to_state(&self) -> SavedSheetState {
        let mut to = StateWriter::default();
        self.state.serialise_motion(&mut to);
        self.state.heat.iter().for_each(|heat| heat.serialise(&mut to));
        if self.is_changed() {
            serialise_material(&self.parameters.material, &mut to);
            self.serialise_changes(&mut to);
        }
        to.flag(self.recovery.is_some());
        self.recovery.iter().for_each(|guard| guard.state.serialise(&mut to));
        to.flag(self.state.adhesion.is_some());
        self.state.adhesion.iter().for_each(|bonds| bonds.serialise(&mut to));
        SavedSheetState {
            nodes: self.node_count(),
            springs: self.springs.len(),
            elements: self.elements.len() - self.grabs.len(),
            temperatures_per_node: self.state.heat.as_ref().map_or(0, |heat| heat.points()),
            is_inelastic: self.state.inelastic.is_some(),
            is_changed: self.is_changed(),
            open: self.torn_cells(),
            bytes: to.bytes,
        }
    }

    /// Whether `state` is compatible with this sheet.
    pub(crate) fn accepts_state(&self, state: &SavedSheetState) -> bool {
        let cells = self.open_cells().map_or(0, <[bool]>::len);
        // A later change of the slits leaves the nodes as they are.
        let same_cells = state.open.len() == cells || !state.open.contains(&true);
        let points = if self.model.described_temperature.has_gradient { 2 } else { 1 };
        let same_elements = state.elements == self.elements.len() - self.grabs.len()
            && state.springs == self.springs.len()
            && state.is_inelastic == self.state.inelastic.is_some();
        state.nodes == self.node_count()
            && same_cells
            && (state.temperatures_per_node == 0 || state.temperatures_per_node == points)
            && (!state.is_changed || same_elements)
    }

    /// Restore a compatible `state`. The integrator restarts; the material stays as it is.
    pub(crate) fn restore(&mut self, state: &SavedSheetState) -> ReadResult {
        let mut from = StateReader::new(&state.bytes);
        self.wake();
        let rest = self.state.deserialise_motion(&mut from)?;
        self.set_open(&state.open);
        if state.temperatures_per_node > 0 {
            self.deserialise_temperatures(&mut from)?;
            self.state.heat.iter_mut().for_each(|heat| heat.discard_network());
        } else if self.state.heat.is_some() {
            // A state without temperatures is at the reference temperature.
            let _ = self.set_temperatures(|_| REFERENCE);
        }
        if state.is_changed {
            // The changes refer to the material of their time. Both materials are valid, and a
            // creeping sheet keeps its creep constants, so that setting them succeeds.
            let (then, now) = (deserialise_material(&mut from)?, self.parameters.material.clone());
            let _ = self.set_material(then);
            self.deserialise_changes(&mut from)?;
            let _ = self.set_material(now);
        }
        let recovery = if from.flag()? { Some(RecoveryState::deserialise(&mut from)?) } else { None };
        self.deserialise_adhesion(&mut from)?;
        self.state.touching.fill(false);
        self.work.stage.has_diverged = false;
        self.restore_recovery_state(recovery);
        self.engine.restart();
        self.last_field = None;
        self.system = None;
        self.state.set_rest(rest);
        Ok(())
    }
}
