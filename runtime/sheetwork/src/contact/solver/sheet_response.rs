//! Share of a sheet in the contact problem: its contacts, their half solutions, and the response of
//! its nodes (displacement m, velocity change m/s, acceleration m/s²).

use glam::DVec3;

use crate::collision::constraint::SheetPoint;
use crate::integrators::implicit::staged::ContactJump;
use crate::linear::{HalfSolutions, SparseLoads};
use crate::math::Vectors;

/// Contact arrays of a sheet.
#[derive(Default)]
pub(crate) struct SheetResponse {
    /// Active contacts of the sheet, as ascending indices into the active list.
    pub(super) list: Vec<u32>,
    /// Jacobians of the contacts to be added.
    pub(super) loads: SparseLoads,
    /// Half solutions L⁻¹ Jᵀ of all active contacts.
    pub(super) halves: HalfSolutions,
    pub(super) touched: bool,
    /// Displacement of the position solve while the velocity solve clears `jump`, m.
    pub(super) saved_dx: Vectors,
    /// Contact force on each node, N.
    pub(super) force: Vectors,
    /// Response of the sheet to contact in this stage.
    pub jump: ContactJump,
}

impl SheetResponse {
    /// Remove all contacts and prepare the arrays for `n` nodes.
    pub(super) fn clear(&mut self, n: usize) {
        self.touched = false;
        self.list.clear();
        self.halves.clear();
        for buffer in [&mut self.force, &mut self.jump.dx, &mut self.jump.dv, &mut self.jump.acceleration] {
            if buffer.len() != n {
                *buffer = Vectors::zeros(n);
            }
        }
        self.jump.dx.clear();
    }

    /// Remove all contacts from the sheet.
    pub fn remove_contacts(&mut self) {
        self.touched = false;
        self.list.clear();
    }

    /// Whether any contact is on the sheet.
    pub fn is_touched(&self) -> bool {
        self.touched || !self.list.is_empty()
    }

    /// Prepare for contacts that are not in the list, on a sheet of `n` nodes.
    pub fn prepare_without_list(&mut self, n: usize) {
        self.clear(n);
        self.force.clear();
        self.touched = true;
    }

    /// Add `force` (N) at `point`.
    pub fn add_force(&mut self, point: &SheetPoint, force: DVec3) {
        for (mass, weight) in point.terms() {
            let there = self.force.get(mass as usize);
            self.force.set(mass as usize, there + force * weight);
        }
    }

    /// Compute the accelerations by the contact forces, with the inverse node masses `inverse`
    /// (1/kg).
    pub fn accelerate(&mut self, inverse: &[f64]) {
        for (i, w) in inverse.iter().enumerate() {
            self.jump.acceleration.set(i, self.force.get(i) * *w);
        }
    }
}
