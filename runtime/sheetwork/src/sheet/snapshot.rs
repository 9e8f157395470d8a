//! State of a sheet for a return to an earlier time: positions, velocities, open cells, adhesive
//! bonds, sleep state; with heat, creep or plasticity also temperatures and inelastic strains.

use crate::elements::Element;
use crate::elements::spring::Springs;
use crate::math::Vectors;
use crate::scene::Material;
use crate::sheet::bonds::AdhesionState;
use crate::sheet::creep::InelasticState;
use crate::sheet::temperature::SheetTemperature;
use crate::sheet::{RecoveryState, Sheet, Status};
use crate::units::temperature::REFERENCE;

/// State of a sheet at one time.
#[derive(Clone, Debug)]
pub(crate) struct SavedSheetState {
    x: Vectors,
    v: Vectors,
    status: Status,
    rest_time: f64,
    /// Positions at the start of the rest period, m; `None` for a moving sheet.
    rest_positions: Option<Vectors>,
    /// Cells opened since the start; empty for a sheet that cannot open.
    open: Vec<bool>,
    adhesion: Option<Box<AdhesionState>>,
    changed: Option<ElementState>,
    /// State of the recovery policy.
    recovery: Option<RecoveryState>,
}

/// Elements, springs and temperatures of a sheet with heat, creep or plasticity.
struct ElementState {
    /// Elements without grab springs.
    elements: Vec<Box<dyn Element>>,
    springs: Springs,
    heat: Option<Box<SheetTemperature>>,
    inelastic: Option<Box<InelasticState>>,
    /// Material of this state.
    material: Material,
}

impl ElementState {
    fn copy(
        elements: &[Box<dyn Element>],
        springs: &Springs,
        heat: Option<&SheetTemperature>,
        flow: Option<&InelasticState>,
        material: &Material,
    ) -> Self {
        Self {
            elements: elements.iter().map(|e| e.clone_box()).collect(),
            springs: springs.clone(),
            heat: heat.map(|h| Box::new(h.copy_state())),
            inelastic: flow.map(|f| Box::new(f.clone())),
            material: material.clone(),
        }
    }
}

impl Clone for ElementState {
    fn clone(&self) -> Self {
        Self::copy(&self.elements, &self.springs, self.heat.as_deref(), self.inelastic.as_deref(), &self.material)
    }
}

impl std::fmt::Debug for ElementState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Changed").field("elements", &self.elements.len()).finish_non_exhaustive()
    }
}

impl Sheet {
    /// Copy the present state.
    pub(crate) fn to_state(&self) -> SavedSheetState {
        let open = self.torn_cells();
        let (x, v, stuck) = (self.x.clone(), self.v.clone(), self.work.adhesion.clone());
        let own = self.elements.len() - self.grabs.len();
        let changes = self.heat.is_some() || self.inelastic.is_some();
        let changed = changes.then(|| {
            let elements = &self.elements[..own];
            ElementState::copy(elements, &self.springs, self.heat.as_deref(), self.inelastic.as_deref(), &self.material)
        });
        let guard = self.recovery.as_ref().map(|g| g.state);
        let still_at = (self.rest_time > 0.0).then(|| self.rest_positions.clone());
        SavedSheetState {
            x,
            v,
            status: self.status,
            rest_time: self.rest_time,
            rest_positions: still_at,
            open,
            adhesion: stuck,
            changed,
            recovery: guard,
        }
    }

    /// Whether `state` is compatible with this sheet.
    pub(crate) fn accepts_state(&self, state: &SavedSheetState) -> bool {
        let own = self.open_cells().map_or(0, <[bool]>::len);
        // A later change of the slits leaves the nodes as they are.
        let cells = state.open.len() == own || !state.open.contains(&true);
        let flows = |c: &ElementState| {
            c.inelastic.is_some() == self.inelastic.is_some() && c.springs.len() == self.springs.len()
        };
        state.x.len() == self.node_count() && cells && state.changed.as_ref().is_none_or(flows)
    }

    /// Restore a compatible `state`. The integrator restarts; the material stays as it is.
    pub(crate) fn restore(&mut self, state: &SavedSheetState) {
        self.wake();
        self.x.copy_from(&state.x);
        self.v.copy_from(&state.v);
        self.set_open(&state.open);
        self.work.adhesion.clone_from(&state.adhesion);
        match &state.changed {
            Some(changed) => self.restore_elements(changed.clone()),
            // A state without temperatures is at the reference temperature.
            None if self.heat.is_some() => _ = self.set_temperatures(|_| REFERENCE),
            None => {}
        }
        self.status = state.status;
        self.rest_time = state.rest_time;
        state.rest_positions.iter().for_each(|at| self.rest_positions.clone_from(at));
        self.work.touching.fill(false);
        self.work.stage.has_diverged = false;
        self.restore_recovery_state(state.recovery);
        self.engine.restart();
        self.last_field = None;
    }

    fn restore_elements(&mut self, changed: ElementState) {
        let own = self.elements.len() - self.grabs.len();
        self.elements.splice(..own, changed.elements);
        (self.springs, self.inelastic) = (changed.springs, changed.inelastic);
        if changed.heat.is_some() {
            self.heat = changed.heat;
        }
        // The restored elements are bound to the blocks of another linear system.
        self.system = None;
        let now = std::mem::replace(&mut self.material, changed.material);
        if now != self.material {
            // Both materials are valid, and a creeping sheet keeps its creep constants, so this
            // succeeds.
            let _ = self.set_material(now);
        }
    }
}
