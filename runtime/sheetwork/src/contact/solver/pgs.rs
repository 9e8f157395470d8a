//! The contact problem of several contacts, solved by Gauss-Seidel sweeps and Newton steps.
//!
//! u = W p + b in the frames of the contacts, Coulomb's law at each (see `coulomb`). W = J H⁻¹ Jᵀ is the Delassus operator:
//! how every contact answers a force at every other. Contacts that share no sheet and no body do not couple, so W is kept
//! by columns of 3x3 blocks that are there.
//!
//! Contacts that hold the same leave W nearly singular: what is stuck at two places of a sheet that cannot stretch has forces
//! that no motion tells. A few steps of the proximal point method are taken, each from the forces p₀ of the one before,
//!
//!   u = W p + b + ε diag W (p - p₀),
//!
//! which asks for nothing that rests to move, and lets a contact miss by the fraction ε of what it newly holds back.
//!
//! Sweeps settle how each contact acts but carry a force through a pile only one sheet at a time. Between them, with limits of
//! friction held, the forces are the minimum of the convex ½ pᵀ W p + bᵀ p; Newton steps for all contacts at once (see `direct`),
//! brought back to what Coulomb's law allows and shortened until they lower it, go there (Morales, Nocedal, Smelyanskiy, "An
//! algorithm for the fast solution of symmetric linear complementarity problems", Numer. Math. 111, 2008; Rockafellar,
//! "Monotone operators and the proximal point algorithm", SIAM J. Control Optim. 14, 1976).

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::{Law, solve};
use crate::contact::solver::newton::{Direct, Ways};

/// ε along the normal and across it.
const SLIGHT: DVec3 = DVec3::new(3e-3, 1e-1, 1e-1);
/// Times that p₀ is taken anew in a solve, at most.
const CENTRES: u32 = 2;
/// Sweeps before the first Newton steps, sweeps between them, and Newton steps at a time.
const FIRST: u32 = 8;
const BETWEEN: u32 = 8;
const STEPS: u32 = 3;
/// Shorter steps that are tried.
const HALVINGS: u32 = 4;

/// A problem of contacts that grows.
#[derive(Default)]
pub struct Problem {
    /// Contacts there are; the vectors below may hold memory for more.
    count: usize,
    /// Of each contact, the contacts that a force at it moves (itself too), with their 3x3 blocks.
    pub(crate) columns: Vec<Vec<(u32, DMat3)>>,
    pub(crate) diagonal: Vec<DMat3>,
    /// Blocks of W + ε diag W on the diagonal.
    own: Vec<DMat3>,
    laws: Vec<Law>,
    /// Force at each contact in its frame (normal, two tangents), N.
    pub force: Vec<DVec3>,
    moved: Vec<DVec3>,
    direct: Direct,
    limits: Vec<f64>,
    ways: Vec<Ways>,
    /// Forces and u before a direct solve.
    kept: Vec<DVec3>,
    kept_moved: Vec<DVec3>,
}

/// How a solution went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Swept {
    /// Sweeps over all contacts.
    pub sweeps: u32,
    /// Largest change of a gap in the last, m.
    pub change: f64,
}

impl Problem {
    /// Forgets all contacts, keeps the memory.
    pub fn clear(&mut self) {
        self.count = 0;
        self.diagonal.clear();
        self.laws.clear();
        self.force.clear();
    }

    /// How many contacts there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds a contact that begins with `force`; its couplings follow by [`Problem::couple`].
    pub fn push(&mut self, law: Law, force: DVec3) {
        if self.columns.len() == self.count {
            self.columns.push(Vec::new());
        }
        self.columns[self.count].clear();
        self.diagonal.push(DMat3::ZERO);
        self.laws.push(law);
        self.force.push(force);
        self.count += 1;
    }

    /// Adds `block` = ∂u_i/∂p_j to W, and its transpose at (j, i); once for a pair.
    pub fn couple(&mut self, i: usize, j: usize, block: DMat3) {
        if i == j {
            // Half solutions make it symmetric but for rounding.
            self.diagonal[i] = (block + block.transpose()) * 0.5;
        } else {
            self.columns[j].push((i as u32, block));
            self.columns[i].push((j as u32, block.transpose()));
        }
    }

    /// u = W p.
    pub fn answer(&self, p: &[DVec3], u: &mut [DVec3]) {
        for (u, (p, diagonal)) in u.iter_mut().zip(p.iter().zip(&self.diagonal)) {
            *u = *diagonal * *p;
        }
        for (p, column) in p.iter().zip(&self.columns).filter(|(p, _)| **p != DVec3::ZERO) {
            for (i, block) in column {
                u[*i as usize] += *block * *p;
            }
        }
    }

    /// Solves u = W p + b from the forces there are, until no gap changes by more than `tolerance` in a sweep.
    pub fn solve(&mut self, b: &[DVec3], tolerance: f64, most: u32) -> Swept {
        self.own.clear();
        for (a, column) in self.diagonal.iter().zip(&self.columns) {
            // What answers to nothing else is solved for exactly as it is.
            let slight = if column.is_empty() { DVec3::ZERO } else { SLIGHT };
            let own = DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) * slight;
            self.own.push(*a + DMat3::from_diagonal(own));
        }
        let mut done = Swept::default();
        for _ in 0..CENTRES {
            self.centre(b);
            let before = done.sweeps;
            self.settle(&mut done, tolerance, most);
            if done.sweeps == before + 1 || done.sweeps >= most {
                break;
            }
        }
        done
    }

    /// Begins from the forces there are as p₀: u is then as without ε.
    fn centre(&mut self, b: &[DVec3]) {
        self.moved.clear();
        self.moved.extend_from_slice(b);
        for j in 0..self.count {
            let p = self.force[j];
            if p != DVec3::ZERO {
                self.moved[j] += self.diagonal[j] * p;
                self.carry(j, p);
            }
        }
    }

    /// Sweeps and steps until nothing changes by more than `tolerance`, or `most` sweeps are done.
    fn settle(&mut self, done: &mut Swept, tolerance: f64, most: u32) {
        let mut next = done.sweeps + FIRST;
        loop {
            done.change = self.sweep();
            done.sweeps += 1;
            if done.change <= tolerance || done.sweeps >= most {
                return;
            }
            if self.count > 1 && done.sweeps >= next {
                self.step_at_once();
                next = done.sweeps + BETWEEN;
            }
        }
    }

    /// Solves each contact once, the others held; returns the largest change of a gap, m.
    fn sweep(&mut self) -> f64 {
        let mut change = 0.0_f64;
        for i in 0..self.count {
            let old = self.force[i];
            if old == DVec3::ZERO && self.moved[i].x >= 0.0 && self.laws[i] != Law::Glue {
                continue;
            }
            let a = self.own[i];
            let new = solve(&a, self.moved[i] - a * old, self.laws[i], old);
            change = change.max(self.change(i, new));
        }
        change
    }

    /// Gives contact `i` the force `new`; returns by how much that changes its own gap and slip, m.
    fn change(&mut self, i: usize, new: DVec3) -> f64 {
        let (step, a) = (new - self.force[i], self.own[i]);
        if step == DVec3::ZERO {
            return 0.0;
        }
        self.force[i] = new;
        self.apply(i, step);
        (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) * step).abs().element_sum()
    }

    /// Takes Newton steps for all contacts at once, with limits of friction as they are.
    fn step_at_once(&mut self) {
        self.limits.clear();
        for (law, p) in self.laws.iter().zip(&self.force) {
            self.limits.push(match law {
                Law::Glue => f64::INFINITY,
                Law::Coulomb(friction) => friction * p.x,
            });
        }
        let mut direct = std::mem::take(&mut self.direct);
        for _ in 0..STEPS {
            self.ways.clear();
            for i in 0..self.count {
                let ways = self.ways_of(i);
                self.ways.push(ways);
            }
            if !direct.solve(&self.columns, &self.own, &self.ways, &self.moved) || !self.search(&direct) {
                break;
            }
        }
        self.direct = direct;
    }

    /// In which ways the force of contact `i` may change.
    fn ways_of(&self, i: usize) -> Ways {
        let (p, u, a, limit) = (self.force[i], self.moved[i], &self.own[i], self.limits[i]);
        if self.laws[i] == Law::Glue {
            return Ways { count: 3, ..Ways::NONE };
        }
        if p.x * a.x_axis.x - u.x <= 0.0 {
            return Ways::NONE;
        }
        if limit <= 0.0 {
            return Ways { count: 1, ..Ways::NONE };
        }
        let (force, slip) = (DVec2::new(p.y, p.z), DVec2::new(u.y, u.z));
        let along = force.normalize_or_zero();
        if force.length() < limit * (1.0 - 1e-9) || along.dot(slip) >= 0.0 {
            return Ways { count: 3, ..Ways::NONE };
        }
        // Where it slides the force can only turn, and turns against the slip.
        let basis = DMat3::from_cols(DVec3::X, DVec3::new(0.0, -along.y, along.x), DVec3::new(0.0, along.x, along.y));
        Ways { basis, count: 2, turning: [0.0, slip.length() / limit, 0.0] }
    }

    /// Goes along the step of a direct solve as far as that lowers ½ pᵀ W p + bᵀ p, each force within its limits; false where
    /// there is nothing to gain.
    fn search(&mut self, direct: &Direct) -> bool {
        self.kept.clone_from(&self.force);
        self.kept_moved.clone_from(&self.moved);
        let mut part = 1.0;
        for _ in 0..HALVINGS {
            let mut gain = 0.0;
            for i in 0..self.count {
                if self.ways[i].count > 0 {
                    let next = self.kept[i] + direct.step(i, &self.ways[i]) * part;
                    self.change(i, self.within(i, next));
                }
            }
            for i in (0..self.count).filter(|i| self.ways[*i].count > 0) {
                gain -= 0.5 * (self.force[i] - self.kept[i]).dot(self.moved[i] + self.kept_moved[i]);
            }
            if gain > 0.0 {
                return true;
            }
            self.force.clone_from(&self.kept);
            self.moved.clone_from(&self.kept_moved);
            part *= 0.25;
        }
        false
    }

    /// The force nearest to `p` that contact `i` may have.
    fn within(&self, i: usize, p: DVec3) -> DVec3 {
        if self.laws[i] == Law::Glue {
            return p;
        }
        let tangential = DVec2::new(p.y, p.z).clamp_length_max(self.limits[i]);
        DVec3::new(p.x.max(0.0), tangential.x, tangential.y)
    }

    /// u after the last solve, m.
    pub fn moved(&self) -> &[DVec3] {
        &self.moved
    }

    fn apply(&mut self, j: usize, p: DVec3) {
        self.moved[j] += self.own[j] * p;
        self.carry(j, p);
    }

    /// Moves the other contacts as force `p` at contact `j` does.
    fn carry(&mut self, j: usize, p: DVec3) {
        for (i, block) in &self.columns[j] {
            self.moved[*i as usize] += *block * p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pile of `count` equal masses on a floor, each pushed down by 1 in units of its own compliance.
    fn pile(count: usize, law: Law) -> (Problem, Vec<DVec3>) {
        let mut problem = Problem::default();
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
    fn a_contact_of_a_pile_carries_what_lies_above_it() {
        let count = 40;
        let (mut problem, b) = pile(count, Law::Coulomb(0.3));
        // A solve from the forces of the one before is what steps at rest are.
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
    fn contacts_that_hold_the_same_share_it_and_rest() {
        // One mass held twice at one place, pulled sideways by less than friction holds.
        let mut problem = Problem::default();
        for i in 0..2 {
            problem.push(Law::Coulomb(0.5), DVec3::ZERO);
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
    fn what_slides_is_rubbed_by_as_much_as_it_pushes() {
        let (mut problem, mut b) = pile(1, Law::Coulomb(0.25));
        b[0].y = 2.0;
        problem.solve(&b, 1e-12, 200);
        let p = problem.force[0];
        assert!((p - DVec3::new(1.0, -0.25, 0.0)).length() < 1e-9, "{p}");
    }
}
