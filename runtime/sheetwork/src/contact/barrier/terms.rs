//! Linear system of a Newton step: terms of the barrier and of friction, and the right side.
//!
//! A term acts on the difference u = Σ w_i x_i of two points with the gradient p (N) and the
//! stiffness A (N/m): Jᵀ A J is added to the tangent, and -Jᵀ (p + A Δ) to the right side,
//! with Δ (m) the prescribed motion of u.

use glam::{DMat3, DVec3};

use crate::contact::IslandView;
use crate::contact::barrier::BarrierSolver;
use crate::contact::barrier::displacement;
use crate::contact::barrier::surfaces::Owner;
use crate::contact::coulomb::ContactLaw;
use crate::contact::solver::augmented_lagrangian::SolverConstraint;
use crate::sheet::stage;

/// A term of the linear system.
pub(super) struct Term {
    pub constraint: SolverConstraint,
    /// Gradient, N.
    pub gradient: DVec3,
    /// Stiffness, N/m.
    pub stiffness: DMat3,
    /// Prescribed motion, m.
    pub prescribed: DVec3,
}

/// a bᵀ.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The matrix of r × ·.
fn cross_matrix(r: DVec3) -> DMat3 {
    DMat3::from_cols(r.cross(DVec3::X), r.cross(DVec3::Y), r.cross(DVec3::Z))
}

impl BarrierSolver {
    /// Collect the terms of the active stencils and of friction.
    pub(super) fn collect_terms(&mut self, island: &IslandView) {
        let mut terms = std::mem::take(&mut self.terms);
        terms.clear();
        for stencil in &self.active {
            let closest = stencil.closest(self.corners(stencil));
            let [_, first, second] = stencil.barrier(closest.distance, self.stiffness(stencil).unwrap_or(0.0));
            if second > 0.0 && first.is_finite() {
                let n = closest.normal;
                terms.push(self.term(island, (stencil.vertices, closest.weights), n * first, outer(n, n) * second));
            }
        }
        for pair in &self.surfaces.attached {
            let apart = self.surfaces.x[pair[0] as usize] - self.surfaces.x[pair[1] as usize];
            let stiffness = self.attachment_stiffness(*pair);
            let vertices = [pair[0], pair[1], pair[0], pair[0]];
            let weights = [1.0, -1.0, 0.0, 0.0];
            terms.push(self.term(island, (vertices, weights), apart * stiffness, DMat3::IDENTITY * stiffness));
        }
        for friction in &self.friction {
            let (gradient, stiffness) = friction.derivatives(self.slip(friction));
            terms.push(self.term(island, (friction.vertices, friction.weights), gradient, stiffness));
        }
        self.terms = terms;
    }

    fn term(
        &self,
        island: &IslandView,
        (vertices, weights): ([u32; 4], [f64; 4]),
        gradient: DVec3,
        stiffness: DMat3,
    ) -> Term {
        let mut constraint = SolverConstraint::new(DMat3::IDENTITY, ContactLaw::Attachment);
        let mut prescribed = DVec3::ZERO;
        for (vertex, weight) in vertices.iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
            prescribed += self.prescribed[*vertex as usize] * weight;
            match self.surfaces.owners[*vertex as usize] {
                Owner::Node { sheet, node } => {
                    if let Some((row, free)) = stage::free_row(island.sheet(sheet), node) {
                        constraint.add(self.tangent.sheet(sheet) + row, DMat3::from_diagonal(free * weight));
                    }
                }
                Owner::Body { body, .. } => {
                    if let Some(first) = self.tangent.body(island.sheets.len(), body) {
                        let arm = self.surfaces.x[*vertex as usize] - self.bodies[body as usize].centre();
                        constraint.add(first, DMat3::IDENTITY * weight);
                        constraint.add(first + 1, cross_matrix(arm) * -weight);
                    }
                }
            }
        }
        Term { constraint, gradient, stiffness, prescribed }
    }

    /// Fill the right side: the negative gradient of the potential, with the prescribed motion.
    pub(super) fn fill_right(&mut self, island: &IslandView, h: f64) {
        let mut right = std::mem::take(&mut self.right);
        right.clear();
        right.resize(3 * self.tangent.size(), 0.0);
        let mut add = |row: u32, force: DVec3| {
            let at = 3 * row as usize;
            right[at..at + 3].iter_mut().zip(force.to_array()).for_each(|(to, f)| *to += f);
        };
        for local in 0..island.sheets.len() as u32 {
            let first = self.tangent.sheet(local);
            stage::for_each_gradient_row(island.sheet(local), |row, g| add(first + row, -g));
        }
        for (body, (solver_body, now)) in island.solver_bodies.iter().zip(&self.bodies).enumerate() {
            if let Some(first) = self.tangent.body(island.sheets.len(), body as u32) {
                let (shift, turn) = displacement(&solver_body.free, now);
                add(first, shift * (-1.0 / (h * h * solver_body.free.inverse_mass())));
                add(first + 1, solver_body.free.inertia() * turn * (-1.0 / (h * h)));
            }
        }
        for term in &self.terms {
            term.constraint.add_force(-(term.gradient + term.stiffness * term.prescribed), &mut right);
        }
        self.right = right;
    }
}
