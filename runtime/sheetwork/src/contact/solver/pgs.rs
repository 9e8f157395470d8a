//! Contact problem in contact forces, solved by projected Gauss-Seidel (PGS) sweeps and Newton
//! steps.
//!
//! The problem is u = W p + b in the contact frames with Coulomb's law at each contact (see
//! `coulomb`), W = J H⁻¹ Jᵀ the Delassus operator. Contacts without a common sheet or body do not
//! couple; W is stored as columns of nonzero 3×3 blocks.
//!
//! Redundant contacts make W nearly singular: two sticking contacts of an inextensible sheet have
//! forces that no motion determines. The proximal point method adds a term to W, with p₀ the forces
//! of the iteration before:
//!
//!   u = W p + b + ε diag W (p - p₀).
//!
//! Contacts at rest are not disturbed by it; a contact misses its gap by the fraction ε of the
//! change of its force.
//!
//! Sweeps find the contact states but propagate a force through a pile one sheet at a time. With
//! constant friction bounds, the forces minimise the convex function ½ pᵀ W p + bᵀ p. Newton steps
//! for all contacts together (see `force_newton`), projected on the admissible forces and shortened
//! until they lower this function, run between the sweeps.
//!
//! Sources: Morales, Nocedal, Smelyanskiy, "An algorithm for the fast solution of symmetric linear
//! complementarity problems", Numer. Math. 111, 2008; Rockafellar, "Monotone operators and the
//! proximal point algorithm", SIAM J. Control Optim. 14, 1976.

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::{ContactLaw, solve};
use crate::contact::settings::{ContactSettings, PgsSettings};
use crate::contact::solver::force_newton::{ForceNewton, FreeDirections};

const SETTINGS: PgsSettings = ContactSettings::DEFAULT.pgs;

/// Contact problem in contact forces, to which contacts can be added.
#[derive(Default)]
pub struct DualProblem {
    /// Number of contacts; the vectors below may be longer.
    count: usize,
    /// For each contact, the other contacts that it couples to, with their 3×3 blocks of W.
    pub(crate) columns: Vec<Vec<(u32, DMat3)>>,
    /// Diagonal blocks of W, m/N.
    pub(crate) diagonal: Vec<DMat3>,
    /// Diagonal blocks of W + ε diag W.
    proximal_diagonal: Vec<DMat3>,
    laws: Vec<ContactLaw>,
    /// Force of each contact in its frame (normal, two tangents), N.
    pub force: Vec<DVec3>,
    /// u for the present forces, m.
    u: Vec<DVec3>,
    newton: ForceNewton,
    /// Friction bounds during Newton steps, N.
    friction_bounds: Vec<f64>,
    directions: Vec<FreeDirections>,
    /// Forces before a line search, N.
    saved_force: Vec<DVec3>,
    /// u before a line search, m.
    saved_u: Vec<DVec3>,
}

/// Statistics of a PGS solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct PgsStats {
    /// Sweeps over all contacts.
    pub sweeps: u32,
    /// Largest change of a gap in the last sweep, m.
    pub change: f64,
}

impl DualProblem {
    /// Remove all contacts, keeping the allocations.
    pub fn clear(&mut self) {
        self.count = 0;
        self.diagonal.clear();
        self.laws.clear();
        self.force.clear();
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether the problem has no contacts.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Add a contact with initial force `force` (N); [`DualProblem::couple`] then sets its blocks
    /// of W.
    pub fn push(&mut self, law: ContactLaw, force: DVec3) {
        if self.columns.len() == self.count {
            self.columns.push(Vec::new());
        }
        self.columns[self.count].clear();
        self.diagonal.push(DMat3::ZERO);
        self.laws.push(law);
        self.force.push(force);
        self.count += 1;
    }

    /// Add `block` = ∂u_i/∂p_j (m/N) to W, and its transpose at (j, i). Call it once per pair.
    pub fn couple(&mut self, i: usize, j: usize, block: DMat3) {
        if i == j {
            // Half solutions give a symmetric block up to rounding.
            self.diagonal[i] = (block + block.transpose()) * 0.5;
        } else {
            self.columns[j].push((i as u32, block));
            self.columns[i].push((j as u32, block.transpose()));
        }
    }

    /// Compute u = W p.
    pub fn apply_delassus(&self, p: &[DVec3], u: &mut [DVec3]) {
        for (u, (p, diagonal)) in u.iter_mut().zip(p.iter().zip(&self.diagonal)) {
            *u = *diagonal * *p;
        }
        for (p, column) in p.iter().zip(&self.columns).filter(|(p, _)| **p != DVec3::ZERO) {
            for (i, block) in column {
                u[*i as usize] += *block * *p;
            }
        }
    }

    /// Solve u = W p + b from the present forces, until no gap changes by more than `tolerance` (m)
    /// in a sweep or after `most` sweeps.
    pub fn solve(&mut self, b: &[DVec3], tolerance: f64, most: u32) -> PgsStats {
        self.proximal_diagonal.clear();
        for (a, column) in self.diagonal.iter().zip(&self.columns) {
            // An uncoupled contact needs no proximal term.
            let slight = if column.is_empty() { DVec3::ZERO } else { SETTINGS.proximal };
            let own = DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) * slight;
            self.proximal_diagonal.push(*a + DMat3::from_diagonal(own));
        }
        let mut done = PgsStats::default();
        for _ in 0..SETTINGS.maximum_proximal_iterations {
            self.set_proximal_centre(b);
            let before = done.sweeps;
            self.sweep_until_converged(&mut done, tolerance, most);
            if done.sweeps == before + 1 || done.sweeps >= most {
                break;
            }
        }
        done
    }

    /// Set p₀ to the present forces, for which the proximal term in u is zero.
    fn set_proximal_centre(&mut self, b: &[DVec3]) {
        self.u.clear();
        self.u.extend_from_slice(b);
        for j in 0..self.count {
            let p = self.force[j];
            if p != DVec3::ZERO {
                self.u[j] += self.diagonal[j] * p;
                self.propagate(j, p);
            }
        }
    }

    /// Sweep, with Newton steps in between, until no gap changes by more than `tolerance` (m) or
    /// `most` sweeps are done.
    fn sweep_until_converged(&mut self, done: &mut PgsStats, tolerance: f64, most: u32) {
        let mut next = done.sweeps + SETTINGS.first_sweeps;
        loop {
            done.change = self.sweep();
            done.sweeps += 1;
            if done.change <= tolerance || done.sweeps >= most {
                return;
            }
            if self.count > 1 && done.sweeps >= next {
                self.newton_steps();
                next = done.sweeps + SETTINGS.sweeps_between;
            }
        }
    }

    /// Solve each contact once with constant forces of the others. Returns the largest change of a
    /// gap, m.
    fn sweep(&mut self) -> f64 {
        let mut change = 0.0_f64;
        for i in 0..self.count {
            let old = self.force[i];
            if old == DVec3::ZERO && self.u[i].x >= 0.0 && self.laws[i] != ContactLaw::Attachment {
                continue;
            }
            let a = self.proximal_diagonal[i];
            let new = solve(&a, self.u[i] - a * old, self.laws[i], old);
            change = change.max(self.change(i, new));
        }
        change
    }

    /// Set the force of contact `i` to `new`. Returns the change of its own gap and slip, m.
    fn change(&mut self, i: usize, new: DVec3) -> f64 {
        let (step, a) = (new - self.force[i], self.proximal_diagonal[i]);
        if step == DVec3::ZERO {
            return 0.0;
        }
        self.force[i] = new;
        self.apply(i, step);
        (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) * step).abs().element_sum()
    }

    /// Take Newton steps for all contacts with the present friction bounds.
    fn newton_steps(&mut self) {
        self.friction_bounds.clear();
        for (law, p) in self.laws.iter().zip(&self.force) {
            self.friction_bounds.push(match law {
                ContactLaw::Attachment => f64::INFINITY,
                ContactLaw::Coulomb(friction) => friction * p.x,
            });
        }
        let mut direct = std::mem::take(&mut self.newton);
        for _ in 0..SETTINGS.newton_steps {
            self.directions.clear();
            for i in 0..self.count {
                let ways = self.ways_of(i);
                self.directions.push(ways);
            }
            if !direct.solve(&self.columns, &self.proximal_diagonal, &self.directions, &self.u)
                || !self.line_search(&direct)
            {
                break;
            }
        }
        self.newton = direct;
    }

    /// Directions in which the force of contact `i` may change.
    fn ways_of(&self, i: usize) -> FreeDirections {
        let (p, u, a, limit) = (self.force[i], self.u[i], &self.proximal_diagonal[i], self.friction_bounds[i]);
        if self.laws[i] == ContactLaw::Attachment {
            return FreeDirections { count: 3, ..FreeDirections::NONE };
        }
        if p.x * a.x_axis.x - u.x <= 0.0 {
            return FreeDirections::NONE;
        }
        if limit <= 0.0 {
            return FreeDirections { count: 1, ..FreeDirections::NONE };
        }
        let (force, slip) = (DVec2::new(p.y, p.z), DVec2::new(u.y, u.z));
        let along = force.normalize_or_zero();
        if force.length() < limit * (1.0 - 1e-9) || along.dot(slip) >= 0.0 {
            return FreeDirections { count: 3, ..FreeDirections::NONE };
        }
        // In slip the tangential force can only rotate, and rotates against the slip.
        let basis = DMat3::from_cols(DVec3::X, DVec3::new(0.0, -along.y, along.x), DVec3::new(0.0, along.x, along.y));
        FreeDirections { basis, count: 2, compliance: [0.0, slip.length() / limit, 0.0] }
    }

    /// Line search on ½ pᵀ W p + bᵀ p along the Newton step, with each force projected on its
    /// admissible set. Returns false if no step length lowers the function.
    fn line_search(&mut self, direct: &ForceNewton) -> bool {
        self.saved_force.clone_from(&self.force);
        self.saved_u.clone_from(&self.u);
        let mut part = 1.0;
        for _ in 0..SETTINGS.maximum_step_lengths {
            let mut gain = 0.0;
            for i in 0..self.count {
                if self.directions[i].count > 0 {
                    let next = self.saved_force[i] + direct.step(i, &self.directions[i]) * part;
                    self.change(i, self.project_force(i, next));
                }
            }
            for i in (0..self.count).filter(|i| self.directions[*i].count > 0) {
                gain -= 0.5 * (self.force[i] - self.saved_force[i]).dot(self.u[i] + self.saved_u[i]);
            }
            if gain > 0.0 {
                return true;
            }
            self.force.clone_from(&self.saved_force);
            self.u.clone_from(&self.saved_u);
            part *= 0.25;
        }
        false
    }

    /// Projection of `p` on the admissible forces of contact `i`.
    fn project_force(&self, i: usize, p: DVec3) -> DVec3 {
        if self.laws[i] == ContactLaw::Attachment {
            return p;
        }
        let tangential = DVec2::new(p.y, p.z).clamp_length_max(self.friction_bounds[i]);
        DVec3::new(p.x.max(0.0), tangential.x, tangential.y)
    }

    /// Add the effect of force `p` at contact `j` to u of all contacts.
    fn apply(&mut self, j: usize, p: DVec3) {
        self.u[j] += self.proximal_diagonal[j] * p;
        self.propagate(j, p);
    }

    /// Add the effect of force `p` at contact `j` to u of the other contacts.
    fn propagate(&mut self, j: usize, p: DVec3) {
        for (i, block) in &self.columns[j] {
            self.u[*i as usize] += *block * p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pile of `count` equal bodies on a floor. The weight of each is 1 in units of its own
    /// compliance.
    fn pile(count: usize, law: ContactLaw) -> (DualProblem, Vec<DVec3>) {
        let mut problem = DualProblem::default();
        for i in 0..count {
            problem.push(law, DVec3::ZERO);
            problem.couple(i, i, DMat3::IDENTITY * if i == 0 { 1.0 } else { 2.0 });
            if i > 0 {
                problem.couple(i, i - 1, -DMat3::IDENTITY);
            }
        }
        let mut b = vec![DVec3::ZERO; count];
        b[0] = DVec3::new(-1.0, 0.0, 0.0);
        (problem, b)
    }

    #[test]
    fn contact_in_a_pile_carries_the_weight_above() {
        let count = 40;
        let (mut problem, b) = pile(count, ContactLaw::Coulomb(0.3));
        // Repeated solves, each from the forces of the previous one, as in steps at rest.
        let mut sweeps = 0;
        for _ in 0..200 {
            sweeps = problem.solve(&b, 1e-12, 200).sweeps;
        }
        for (i, p) in problem.force.iter().enumerate() {
            let above = (count - i) as f64;
            assert!((p.x - above).abs() < 1e-6 * above, "contact {i} carries {} of {above}", p.x);
            assert!(p.y.abs().max(p.z.abs()) < 1e-9);
        }
        assert_eq!(sweeps, 1, "what rests is looked at once");
    }

    #[test]
    fn redundant_contacts_share_the_load_and_rest() {
        // One body with two identical contacts, pulled sideways by less than the friction bound.
        let mut problem = DualProblem::default();
        for i in 0..2 {
            problem.push(ContactLaw::Coulomb(0.5), DVec3::ZERO);
            problem.couple(i, i, DMat3::IDENTITY);
        }
        problem.couple(1, 0, DMat3::IDENTITY);
        let b = [DVec3::new(-1.0, 0.3, 0.0); 2];
        for _ in 0..100 {
            problem.solve(&b, 1e-12, 200);
        }
        let sum: DVec3 = problem.force.iter().sum();
        assert!((sum - DVec3::new(1.0, -0.3, 0.0)).length() < 1e-9, "{sum}");
    }

    #[test]
    fn slip_friction_equals_bound() {
        let (mut problem, mut b) = pile(1, ContactLaw::Coulomb(0.25));
        b[0].y = 2.0;
        problem.solve(&b, 1e-12, 200);
        let p = problem.force[0];
        assert!((p - DVec3::new(1.0, -0.25, 0.0)).length() < 1e-9, "{p}");
    }
}
