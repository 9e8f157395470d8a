//! Unknowns of a contact problem: displacements (primal) or contact forces (dual).
//!
//! A Newton step solves (H + Jᵀ D J) s = f and Δu = J s. The primal form is a sparse matrix,
//! factorised again for each D, whose cost hardly grows with the number of contacts. The dual form
//! needs only the factor of H. With s = H⁻¹ Jᵀ q, f = Jᵀ r, W = J H⁻¹ Jᵀ and D = E Λ Eᵀ,
//!
//!   (Eᵀ W E + Λ⁻¹) z = Eᵀ W r,  q = r - E z,  Δu = W q.
//!
//! This matrix is dense in the contacts of a sheet, which is less work for few contacts. Primal
//! vectors hold three numbers per block row (m, N), dual vectors three per contact (N).

use glam::{DMat3, DVec3};

use crate::contact::coulomb::principal;
use crate::contact::solver::augmented_lagrangian::{SolverConstraint, TangentMatrix};
use crate::contact::solver::delassus::DelassusOperator;
use crate::contact::solver::force_newton::{ForceNewton, FreeDirections};

/// Unknowns in which a contact problem is solved.
pub(crate) trait UnknownSpace {
    /// Length of the vectors.
    fn size(&self, rows: &[SolverConstraint]) -> usize;

    /// Whether a factorisation is cheap, so that many iterations are affordable.
    fn has_cheap_factorisation(&self) -> bool;

    /// Add the force `p` (N, contact frame) of contact `i` to `forces`.
    fn add_force(&self, i: usize, row: &SolverConstraint, p: DVec3, forces: &mut [f64]);

    /// Factorise with D = `weights` (N/m). Returns false if the matrix has no factor.
    fn factorize(&mut self, rows: &[SolverConstraint], weights: &[DMat3]) -> bool;

    /// Solve with the last factor, which must be for the same `weights`. `step.0` holds the
    /// right-hand side (N) and then the step s; `step.1` receives H s, and `du` the change of u at
    /// each contact, m.
    fn solve(
        &mut self,
        rows: &[SolverConstraint],
        weights: &[DMat3],
        step: (&mut Vec<f64>, &mut Vec<f64>),
        du: &mut [DVec3],
    );

    /// Work (J) of `forces` along a step that changes u by `du`.
    fn work(&self, step: &[f64], du: &[DVec3], forces: &[f64]) -> f64;
}

/// Displacements as unknowns; `slots` holds the matrix slots of the constraints.
pub(crate) struct PrimalSpace<'a> {
    pub tangent: &'a mut dyn TangentMatrix,
    pub slots: &'a [u32],
}

impl UnknownSpace for PrimalSpace<'_> {
    fn size(&self, _rows: &[SolverConstraint]) -> usize {
        3 * self.tangent.pattern().size()
    }

    fn has_cheap_factorisation(&self) -> bool {
        false
    }

    fn add_force(&self, _i: usize, row: &SolverConstraint, p: DVec3, forces: &mut [f64]) {
        row.add_force(p, forces);
    }

    fn factorize(&mut self, rows: &[SolverConstraint], weights: &[DMat3]) -> bool {
        self.tangent.factorize_with(&mut |values| {
            for (row, weight) in rows.iter().zip(weights).filter(|(_, weight)| **weight != DMat3::ZERO) {
                row.add_stiffness(weight, self.slots, values);
            }
        })
    }

    fn solve(
        &mut self,
        rows: &[SolverConstraint],
        weights: &[DMat3],
        (step, pull): (&mut Vec<f64>, &mut Vec<f64>),
        du: &mut [DVec3],
    ) {
        pull.clone_from(step);
        self.tangent.solve(step);
        for ((row, weight), du) in rows.iter().zip(weights).zip(du) {
            *du = row.displacement(step);
            if *weight != DMat3::ZERO {
                row.add_force(-(*weight * *du), pull);
            }
        }
    }

    fn work(&self, step: &[f64], _du: &[DVec3], forces: &[f64]) -> f64 {
        step.iter().zip(forces).map(|(s, f)| s * f).sum()
    }
}

/// Contact forces as unknowns.
#[derive(Default)]
pub(crate) struct DualSpace {
    pub delassus: DelassusOperator,
    direct: ForceNewton,
    ways: Vec<FreeDirections>,
    force: Vec<DVec3>,
    moved: Vec<DVec3>,
}

impl UnknownSpace for DualSpace {
    fn size(&self, rows: &[SolverConstraint]) -> usize {
        3 * rows.len()
    }

    fn has_cheap_factorisation(&self) -> bool {
        true
    }

    fn add_force(&self, i: usize, _row: &SolverConstraint, p: DVec3, forces: &mut [f64]) {
        for (to, p) in forces[3 * i..3 * i + 3].iter_mut().zip(p.to_array()) {
            *to += p;
        }
    }

    fn factorize(&mut self, _rows: &[SolverConstraint], weights: &[DMat3]) -> bool {
        self.ways.clear();
        self.ways.extend(weights.iter().map(free_directions_of));
        let w = &self.delassus.problem;
        self.direct.factorize(&w.columns, &w.diagonal, &self.ways)
    }

    fn solve(
        &mut self,
        _rows: &[SolverConstraint],
        _weights: &[DMat3],
        (step, pull): (&mut Vec<f64>, &mut Vec<f64>),
        du: &mut [DVec3],
    ) {
        let w = &self.delassus.problem;
        self.force.clear();
        self.force.extend(step.chunks_exact(3).map(DVec3::from_slice));
        self.moved.clear();
        self.moved.resize(self.force.len(), DVec3::ZERO);
        w.apply_delassus(&self.force, &mut self.moved);
        self.direct.solve_with(&self.ways, &self.moved);
        for (i, (p, ways)) in self.force.iter_mut().zip(&self.ways).enumerate() {
            // The factor solves for the right-hand side of opposite sign.
            *p += self.direct.step(i, ways);
        }
        w.apply_delassus(&self.force, du);
        for (to, p) in step.chunks_exact_mut(3).zip(&self.force) {
            to.copy_from_slice(&p.to_array());
        }
        pull.clone_from(step);
    }

    fn work(&self, _step: &[f64], du: &[DVec3], forces: &[f64]) -> f64 {
        du.iter().zip(forces.chunks_exact(3)).map(|(du, f)| du.dot(DVec3::from_slice(f))).sum()
    }
}

/// Principal directions and compliances of D, which does not couple normal and tangents.
fn free_directions_of(d: &DMat3) -> FreeDirections {
    let mut ways = FreeDirections::NONE;
    let mut add = |direction: DVec3, stiffness: f64| {
        if stiffness > 0.0 {
            let at = ways.count as usize;
            *ways.basis.col_mut(at) = direction;
            ways.compliance[at] = 1.0 / stiffness;
            ways.count += 1;
        }
    };
    add(DVec3::X, d.x_axis.x);
    let (turned, stiffness) = principal(d.y_axis.y, d.y_axis.z, d.z_axis.z);
    for (direction, value) in [(turned.x_axis, stiffness.x), (turned.y_axis, stiffness.y)] {
        if value > 1e-12 * stiffness.x {
            add(DVec3::new(0.0, direction.x, direction.y), value);
        }
    }
    ways
}
