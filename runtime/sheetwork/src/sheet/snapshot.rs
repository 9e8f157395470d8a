//! State of a sheet for a return to an earlier time: positions, velocities, open cells, adhesive
//! bonds, sleep state; with heat, creep or plasticity also temperatures and inelastic strains.

use crate::elements::Element;
use crate::elements::spring::Springs;
use crate::math::Vectors;
use crate::scene::Material;
use crate::sheet::bonds::Stuck;
use crate::sheet::creep::Flow;
use crate::sheet::temperature::Heat;
use crate::sheet::{GuardState, Sheet, Status};
use crate::units::temperature::REFERENCE;

/// State of a sheet at one time.
#[derive(Clone, Debug)]
pub(crate) struct SheetState {
    x: Vectors,
    v: Vectors,
    status: Status,
    quiet: f64,
    /// Positions at the start of the rest period, m; `None` for a moving sheet.
    still_at: Option<Vectors>,
    /// Cells opened since the start; empty for a sheet that cannot open.
    open: Vec<bool>,
    stuck: Option<Box<Stuck>>,
    changed: Option<Changed>,
    /// State of the recovery policy.
    guard: Option<GuardState>,
}

/// Elements, springs and temperatures of a sheet with heat, creep or plasticity.
struct Changed {
    /// Elements without grab springs.
    elements: Vec<Box<dyn Element>>,
    springs: Springs,
    heat: Option<Box<Heat>>,
    flow: Option<Box<Flow>>,
    /// Material of this state.
    material: Material,
}

impl Changed {
    fn copy(
        elements: &[Box<dyn Element>],
        springs: &Springs,
        heat: Option<&Heat>,
        flow: Option<&Flow>,
        material: &Material,
    ) -> Self {
        Self {
            elements: elements.iter().map(|e| e.boxed()).collect(),
            springs: springs.clone(),
            heat: heat.map(|h| Box::new(h.kept())),
            flow: flow.map(|f| Box::new(f.clone())),
            material: material.clone(),
        }
    }
}

impl Clone for Changed {
    fn clone(&self) -> Self {
        Self::copy(&self.elements, &self.springs, self.heat.as_deref(), self.flow.as_deref(), &self.material)
    }
}

impl std::fmt::Debug for Changed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Changed").field("elements", &self.elements.len()).finish_non_exhaustive()
    }
}

impl Sheet {
    /// Copy the present state.
    pub(crate) fn state(&self) -> SheetState {
        let open = self.torn_cells();
        let (x, v, stuck) = (self.x.clone(), self.v.clone(), self.work.stuck.clone());
        let own = self.elements.len() - self.pulls.len();
        let changes = self.heat.is_some() || self.flow.is_some();
        let changed = changes.then(|| {
            let elements = &self.elements[..own];
            Changed::copy(elements, &self.springs, self.heat.as_deref(), self.flow.as_deref(), &self.material)
        });
        let guard = self.guard.as_ref().map(|g| g.state);
        let still_at = (self.quiet > 0.0).then(|| self.still_at.clone());
        SheetState { x, v, status: self.status, quiet: self.quiet, still_at, open, stuck, changed, guard }
    }

    /// Whether `state` is compatible with this sheet.
    pub(crate) fn takes(&self, state: &SheetState) -> bool {
        let own = self.open_cells().map_or(0, <[bool]>::len);
        // A change of the slits since then leaves the nodes as they are.
        let cells = state.open.len() == own || !state.open.contains(&true);
        let flows = |c: &Changed| c.flow.is_some() == self.flow.is_some() && c.springs.len() == self.springs.len();
        state.x.len() == self.masses() && cells && state.changed.as_ref().is_none_or(flows)
    }

    /// Restore a compatible `state`. The integrator restarts; the material stays as it is now.
    pub(crate) fn go_back(&mut self, state: &SheetState) {
        self.wake();
        self.x.copy_from(&state.x);
        self.v.copy_from(&state.v);
        self.set_open(&state.open);
        self.work.stuck.clone_from(&state.stuck);
        match &state.changed {
            Some(changed) => self.take_back(changed.clone()),
            // A state without temperatures is at the reference temperature.
            None if self.heat.is_some() => _ = self.set_temperatures(|_| REFERENCE),
            None => {}
        }
        self.status = state.status;
        self.quiet = state.quiet;
        state.still_at.iter().for_each(|at| self.still_at.clone_from(at));
        self.work.touching.fill(false);
        self.work.stage.astray = false;
        self.restore_guard(state.guard);
        self.engine.restart();
        self.field_before = None;
    }

    fn take_back(&mut self, changed: Changed) {
        let own = self.elements.len() - self.pulls.len();
        self.elements.splice(..own, changed.elements);
        (self.springs, self.flow) = (changed.springs, changed.flow);
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
