//! What is kept of a sheet to go back to: positions, velocities, what is open, what it sticks to, whether it sleeps; and where heat, creep
//! or yield change it, its temperatures and what has stayed of them.

use crate::contact::adhesion::Stuck;
use crate::elements::Element;
use crate::elements::spring::Springs;
use crate::math::Vectors;
use crate::scene::Material;
use crate::sheet::creep::Flow;
use crate::sheet::{GuardState, Sheet, Status};
use crate::thermal::{Heat, REFERENCE};

/// A sheet at one time.
#[derive(Clone, Debug)]
pub(crate) struct SheetState {
    x: Vectors,
    v: Vectors,
    status: Status,
    quiet: f64,
    /// Where it was when it was found still, if it is.
    still_at: Option<Vectors>,
    /// Which cells have opened since the start, of a sheet that can.
    open: Vec<bool>,
    stuck: Option<Box<Stuck>>,
    changed: Option<Changed>,
    /// What was done against going unstable.
    guard: Option<GuardState>,
}

/// What steps change of a sheet besides where it is.
struct Changed {
    /// Without the hands that pull at it.
    elements: Vec<Box<dyn Element>>,
    springs: Springs,
    heat: Option<Box<Heat>>,
    flow: Option<Box<Flow>>,
    /// The material that all this is of.
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
    /// The sheet as it is now.
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

    /// Whether `state` is one of this sheet.
    pub(crate) fn takes(&self, state: &SheetState) -> bool {
        let own = self.open_cells().map_or(0, <[bool]>::len);
        // One that has been given slits, or lost them, since then has the same masses.
        let cells = state.open.len() == own || !state.open.contains(&true);
        let flows = |c: &Changed| c.flow.is_some() == self.flow.is_some() && c.springs.len() == self.springs.len();
        state.x.len() == self.masses() && cells && state.changed.as_ref().is_none_or(flows)
    }

    /// Goes back to `state`, which it must take. Its engine begins anew from there, as after a change of engine; its material stays as it
    /// is set now.
    pub(crate) fn go_back(&mut self, state: &SheetState) {
        self.wake();
        self.x.copy_from(&state.x);
        self.v.copy_from(&state.v);
        self.set_open(&state.open);
        self.work.stuck.clone_from(&state.stuck);
        match &state.changed {
            Some(changed) => self.take_back(changed.clone()),
            // It had no temperatures: it was as warm as the room.
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
        // What elements know of the system's blocks is of then.
        self.system = None;
        let now = std::mem::replace(&mut self.material, changed.material);
        if now != self.material {
            // Both were allowed when they were set, and what creeps is not changed while it does.
            let _ = self.set_material(now);
        }
    }
}
