//! Where the unknowns of a contact problem are: with the masses or with the forces.
//!
//! A Newton step asks for s with (H + Jᵀ D J) s = f, and for what it does to every contact, Δu = J s. On the masses that is a
//! sparse matrix, factorised anew for every D, of a cost that hardly grows with the number of contacts. On the forces the
//! factor of H alone is enough: s = H⁻¹ Jᵀ q and f = Jᵀ r give, with W = J H⁻¹ Jᵀ and D = E Λ Eᵀ,
//!
//!   (Eᵀ W E + Λ⁻¹) z = Eᵀ W r,  q = r - E z,  Δu = W q,
//!
//! which is dense in the contacts of a sheet: less work where they are few. Vectors hold three numbers for each block row of masses
//! there (m, N), and three for each contact here (N).

use glam::{DMat3, DVec3};

use crate::contact::coulomb::principal;
use crate::contact::solver::augmented_lagrangian::{Row, Tangent};
use crate::contact::solver::delassus::Delassus;
use crate::contact::solver::newton::{Direct, Ways};

/// Where a contact problem is solved.
pub(crate) trait Space {
    /// Numbers in its vectors.
    fn size(&self, rows: &[Row]) -> usize;

    /// Whether factors cost little, so that many steps may be taken.
    fn is_cheap(&self) -> bool;

    /// Adds the force `p` (N, in its frame) of contact number `i` to `forces`.
    fn push(&self, i: usize, row: &Row, p: DVec3, forces: &mut [f64]);

    /// Factorises with D = `weights` (N/m) at the contacts; false when that has no factor.
    fn factorize(&mut self, rows: &[Row], weights: &[DMat3]) -> bool;

    /// Solves with the last factor, which was of these `weights`: `step.0` holds the forces and then the step, `step.1` what
    /// H times the step is, and `du` what it does to each contact, m.
    fn solve(&mut self, rows: &[Row], weights: &[DMat3], step: (&mut Vec<f64>, &mut Vec<f64>), du: &mut [DVec3]);

    /// Work of `forces` along a step, which moves the contacts by `du`, J.
    fn work(&self, step: &[f64], du: &[DVec3], forces: &[f64]) -> f64;
}

/// On the masses, of which `slots` says where the pairs of every row are.
pub(crate) struct OnMasses<'a> {
    pub tangent: &'a mut dyn Tangent,
    pub slots: &'a [u32],
}

impl Space for OnMasses<'_> {
    fn size(&self, _rows: &[Row]) -> usize {
        3 * self.tangent.pattern().size()
    }

    fn is_cheap(&self) -> bool {
        false
    }

    fn push(&self, _i: usize, row: &Row, p: DVec3, forces: &mut [f64]) {
        row.push(p, forces);
    }

    fn factorize(&mut self, rows: &[Row], weights: &[DMat3]) -> bool {
        self.tangent.factorize_with(&mut |values| {
            for (row, weight) in rows.iter().zip(weights).filter(|(_, weight)| **weight != DMat3::ZERO) {
                row.stiffen(weight, self.slots, values);
            }
        })
    }

    fn solve(
        &mut self,
        rows: &[Row],
        weights: &[DMat3],
        (step, pull): (&mut Vec<f64>, &mut Vec<f64>),
        du: &mut [DVec3],
    ) {
        pull.clone_from(step);
        self.tangent.solve(step);
        for ((row, weight), du) in rows.iter().zip(weights).zip(du) {
            *du = row.moved(step);
            if *weight != DMat3::ZERO {
                row.push(-(*weight * *du), pull);
            }
        }
    }

    fn work(&self, step: &[f64], _du: &[DVec3], forces: &[f64]) -> f64 {
        step.iter().zip(forces).map(|(s, f)| s * f).sum()
    }
}

/// On the forces.
#[derive(Default)]
pub(crate) struct OnForces {
    pub delassus: Delassus,
    direct: Direct,
    ways: Vec<Ways>,
    force: Vec<DVec3>,
    moved: Vec<DVec3>,
}

impl Space for OnForces {
    fn size(&self, rows: &[Row]) -> usize {
        3 * rows.len()
    }

    fn is_cheap(&self) -> bool {
        true
    }

    fn push(&self, i: usize, _row: &Row, p: DVec3, forces: &mut [f64]) {
        for (to, p) in forces[3 * i..3 * i + 3].iter_mut().zip(p.to_array()) {
            *to += p;
        }
    }

    fn factorize(&mut self, _rows: &[Row], weights: &[DMat3]) -> bool {
        self.ways.clear();
        self.ways.extend(weights.iter().map(ways_of));
        let w = &self.delassus.problem;
        self.direct.factorize(&w.columns, &w.diagonal, &self.ways)
    }

    fn solve(
        &mut self,
        _rows: &[Row],
        _weights: &[DMat3],
        (step, pull): (&mut Vec<f64>, &mut Vec<f64>),
        du: &mut [DVec3],
    ) {
        let w = &self.delassus.problem;
        self.force.clear();
        self.force.extend(step.chunks_exact(3).map(DVec3::from_slice));
        self.moved.clear();
        self.moved.resize(self.force.len(), DVec3::ZERO);
        w.answer(&self.force, &mut self.moved);
        self.direct.solve_with(&self.ways, &self.moved);
        for (i, (p, ways)) in self.force.iter_mut().zip(&self.ways).enumerate() {
            // The factor's right side has the other sign.
            *p += self.direct.step(i, ways);
        }
        w.answer(&self.force, du);
        for (to, p) in step.chunks_exact_mut(3).zip(&self.force) {
            to.copy_from_slice(&p.to_array());
        }
        pull.clone_from(step);
    }

    fn work(&self, _step: &[f64], du: &[DVec3], forces: &[f64]) -> f64 {
        du.iter().zip(forces.chunks_exact(3)).map(|(du, f)| du.dot(DVec3::from_slice(f))).sum()
    }
}

/// Directions and compliances of a D that has no entries between the normal and the tangents.
fn ways_of(d: &DMat3) -> Ways {
    let mut ways = Ways::NONE;
    let mut add = |direction: DVec3, stiffness: f64| {
        if stiffness > 0.0 {
            let at = ways.count as usize;
            *ways.basis.col_mut(at) = direction;
            ways.turning[at] = 1.0 / stiffness;
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
