//! Contact equations of a sheet after a step of its integrator, as for explicit integrators.
//!
//! The integrator has moved the nodes from (x₀, v₀) to (x₁, v₁), their free motion. A contact force
//! p (N) in a step of h (s) acts on each node separately through H = M/h²: Δx = h² p/m, Δv = h p/m.
//! A half solution (see [`HalfSolutions`]) is h p/√m at the loaded nodes.

use glam::DVec3;

use crate::integrators::implicit::staged::ContactJump;
use crate::linear::{HalfSolutions, SparseLoads};
use crate::math::Vectors;
use crate::sheet::{Sheet, SheetState};

impl Sheet {
    /// Size the work arrays of a step.
    pub(crate) fn resize_workspace(&mut self) {
        let n = self.node_count();
        if self.work.x_before.len() != n {
            self.work.x_before = Vectors::zeros(n);
            self.work.v_before = Vectors::zeros(n);
            self.state.rest_positions = Vectors::zeros(n);
            self.work.layer_impacts = vec![Default::default(); n];
            self.state.touching = vec![false; n];
        }
    }

    /// Material name, friction and restitution coefficient.
    pub(crate) fn surface_coefficients(&self) -> (&str, f64, f64) {
        (&self.material().name, self.parameters.friction, self.parameters.restitution)
    }

    /// Whether its integrator is explicit.
    pub(crate) fn is_explicit(&self) -> bool {
        !self.engine_kind.info().implicit
    }

    /// Whether nodes respond to contact with their mass alone: with an explicit integrator, and
    /// with an implicit one in contact with an explicit sheet.
    pub(crate) fn solves_node_by_node(&self) -> bool {
        self.work.stage.node_by_node || self.is_explicit()
    }

    /// Contact offset from the nodes, m: half the thickness of a single layer with the stiffness of
    /// its material, otherwise the minimum offset.
    pub fn contact_offset(&self) -> f64 {
        let has_thickness = self.model.layers.len() <= 1 && self.follows_material();
        if has_thickness { 0.5 * self.material().thickness } else { crate::scene::contact::MINIMUM_CONTACT_OFFSET }
    }

    /// Corners of the bounding box of the collision surface, m.
    pub(crate) fn bounding_box(&self) -> (DVec3, DVec3) {
        let (low, high) = self.state.x.bounds().unwrap_or_default();
        let offset = self.contact_offset();
        (low - offset, high + offset)
    }

    /// Bounding box of a moving sheet, m; invalidates the box of [`Sheet::resting_box`].
    pub(crate) fn moving_box(&mut self) -> (DVec3, DVec3) {
        self.work.resting = None;
        self.bounding_box()
    }

    /// Bounding box of a resting sheet, m, cached until its first or last node has moved.
    pub(crate) fn resting_box(&mut self) -> (DVec3, DVec3) {
        let end = |i: Option<usize>| i.filter(|i| *i < self.node_count()).map(|i| self.state.x.get(i));
        let ends = (end(Some(0)), end(self.node_count().checked_sub(1)));
        if let Some((known, around)) = &self.work.resting
            && *known == ends
        {
            return *around;
        }
        let around = self.moving_box();
        self.work.resting = Some((ends, around));
        around
    }

    /// Save the state at the start of a step.
    pub(crate) fn save_start(&mut self) {
        let (x, v) = &mut self.work.start;
        x.clone_from(&self.state.x);
        v.clone_from(&self.state.v);
    }

    /// Swap the state with that at the start of the integrator step.
    pub(crate) fn swap_with_step_start(&mut self) {
        std::mem::swap(&mut self.state.x, &mut self.work.x_before);
        std::mem::swap(&mut self.state.v, &mut self.work.v_before);
    }

    /// Make the result of a step of `dt` (s) the free motion of a contact stage, and return to the
    /// start of the step.
    pub(crate) fn begin_contact_stage(&mut self, dt: f64) {
        let Self { work, state: SheetState { x, v, .. }, .. } = self;
        let stage = &mut work.stage;
        (stage.length, stage.h, stage.is_finished, stage.has_failed, stage.node_by_node) = (dt, dt, false, false, true);
        stage.free_positions.clone_from(x);
        stage.velocity.clone_from(v);
        self.restore_start();
    }

    /// Restore the state at the start of the step.
    pub(crate) fn restore_start(&mut self) {
        let Self { work, state: SheetState { x, v, .. }, .. } = self;
        x.clone_from(&work.start.0);
        v.clone_from(&work.start.1);
    }

    /// Copy the start of the step to the start of the integrator step.
    pub(crate) fn set_integrator_start(&mut self) {
        let Self { work, .. } = self;
        work.x_before.clone_from(&work.start.0);
        work.v_before.clone_from(&work.start.1);
    }

    /// Positions at the start of the step, m.
    pub(crate) fn start_positions(&self) -> &Vectors {
        &self.work.start.0
    }

    /// Set the free motion plus the displacement and velocity change by contact.
    pub(crate) fn apply_contact(&mut self, jump: Option<&ContactJump>) {
        let Self { work, state: SheetState { x, v, .. }, .. } = self;
        x.clone_from(&work.stage.free_positions);
        v.clone_from(&work.stage.velocity);
        if let Some(jump) = jump {
            x.add_scaled(1.0, &jump.dx);
            v.add_scaled(1.0, &jump.dv);
        }
    }

    /// Largest displacement of a node in the stage, m.
    pub(crate) fn largest_travel(&self) -> f64 {
        let pairs = self.state.x.iter().zip(self.work.stage.free_positions.iter());
        pairs.map(|(p, q)| p.distance_squared(q)).fold(0.0, f64::max).sqrt()
    }

    /// Node `i` as a block row, and its free (1) and fixed (0) directions; `None` for a fixed node.
    pub(crate) fn free_node(&self, i: u32) -> Option<(u32, DVec3)> {
        let is_free = self.inverse_mass.get(i as usize).is_some_and(|w| *w > 0.0);
        is_free.then(|| (i, self.pins.free_axes(i)))
    }

    /// Add the half solutions of `loads`, given by node.
    pub(crate) fn half_solve_nodes(&self, loads: &SparseLoads, solutions: &mut HalfSolutions) {
        for load in loads.iter() {
            let mut last = None;
            let after = |last: Option<u32>| load.iter().map(|e| e.0).filter(|m| last.is_none_or(|l| *m > l)).min();
            while let Some(mass) = after(last) {
                let here = load.iter().filter(|e| e.0 == mass);
                let sum: DVec3 = here.map(|e| DVec3::from_array(e.1)).sum();
                let scale = self.work.stage.h * self.inverse_mass[mass as usize].sqrt();
                solutions.add_segment(3 * mass as usize, &(sum * scale).to_array());
                last = Some(mass);
            }
            solutions.close();
        }
    }

    /// Compute the displacement (m) of the nodes by `force` (N).
    pub(crate) fn node_displacements(&self, force: &Vectors, dx: &mut Vectors) {
        let square = self.work.stage.h * self.work.stage.h;
        for (i, w) in self.inverse_mass.iter().enumerate() {
            dx.set(i, force.get(i) * (square * w));
        }
        for (mass, _) in self.pins.fixed_axes() {
            let i = mass as usize;
            dx.set(i, dx.get(i) * self.pins.free_axes(mass));
        }
    }
}
