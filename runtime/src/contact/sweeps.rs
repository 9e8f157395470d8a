//! The contact problem of several contacts, solved by Gauss-Seidel sweeps and direct solves of what pushes.
//!
//! u = W p + b in the frames of the contacts, Coulomb's law at each (see `coulomb`). W = J H⁻¹ Jᵀ is the Delassus operator:
//! how every contact answers a force at every other. Contacts that share no sheet and no body do not couple, so W is kept
//! by columns of 3x3 blocks that are there.
//!
//! Sweeps settle how each contact acts but carry a force through a pile only one sheet at a time, and among contacts of a stiff sheet
//! they creep. Between them the contacts that push are solved for at once (see `direct`).

use glam::{DMat3, DVec3};

use super::coulomb::{Law, solve};
use super::direct::Direct;

/// Sweeps before the first direct solve, and direct solves at a time.
const FIRST: u32 = 3;
const CORRECTIONS: u32 = 4;

/// A problem of contacts that grows.
#[derive(Default)]
pub struct Problem {
    /// Contacts there are; the vectors below may hold memory for more.
    count: usize,
    /// Of each contact, the contacts that a force at it moves (itself too), with their 3x3 blocks.
    columns: Vec<Vec<(u32, DMat3)>>,
    diagonal: Vec<DMat3>,
    laws: Vec<Law>,
    /// Force at each contact in its frame (normal, two tangents), N.
    pub force: Vec<DVec3>,
    moved: Vec<DVec3>,
    direct: Direct,
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

    /// Solves u = W p + b from the forces there are, until no gap changes by more than `tolerance` in a sweep.
    pub fn solve(&mut self, b: &[DVec3], tolerance: f64, most: u32) -> Swept {
        self.moved.clear();
        self.moved.extend_from_slice(b);
        for j in 0..self.count {
            let p = self.force[j];
            if p != DVec3::ZERO {
                self.apply(j, p);
            }
        }
        let mut done = Swept { sweeps: 1, change: self.sweep() };
        let (mut wait, mut next) = (1, FIRST);
        while done.sweeps < most && done.change > tolerance {
            if self.count > 1 && done.sweeps >= next {
                let better = self.step_at_once(&mut done);
                // Where a direct solve did harm, sweeps must first find better states.
                wait = if better { 1 } else { 2 * wait };
                next = done.sweeps + wait;
            } else {
                done.change = self.sweep();
                done.sweeps += 1;
            }
        }
        done
    }

    /// Solves each contact once, the others held; returns the largest change of a gap, m.
    fn sweep(&mut self) -> f64 {
        let mut change = 0.0_f64;
        for i in 0..self.count {
            let old = self.force[i];
            if old == DVec3::ZERO && self.moved[i].x >= 0.0 && self.laws[i] != Law::Glue {
                continue;
            }
            let a = self.diagonal[i];
            let new = solve(&a, self.moved[i] - a * old, self.laws[i], old);
            change = change.max(self.change(i, new));
        }
        change
    }

    /// Gives contact `i` the force `new`; returns by how much that changes its own gap and slip, m.
    fn change(&mut self, i: usize, new: DVec3) -> f64 {
        let (step, a) = (new - self.force[i], self.diagonal[i]);
        if step == DVec3::ZERO {
            return 0.0;
        }
        self.force[i] = new;
        self.apply(i, step);
        (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) * step).abs().element_sum()
    }

    /// Solves for all that pushes at once and sweeps; takes that back, and returns false, if it made the change of a sweep greater.
    fn step_at_once(&mut self, done: &mut Swept) -> bool {
        self.kept.clear();
        self.kept.extend_from_slice(&self.force);
        self.kept_moved.clear();
        self.kept_moved.extend_from_slice(&self.moved);
        let mut direct = std::mem::take(&mut self.direct);
        let mut solved = false;
        for _ in 0..CORRECTIONS {
            if !direct.solve(&self.columns, &self.diagonal, |i| self.unknowns(i), &self.moved) {
                break;
            }
            solved = true;
            if !self.take(&direct) {
                break;
            }
        }
        self.direct = direct;
        if !solved {
            return false;
        }
        let change = self.sweep();
        done.sweeps += 1;
        if change < done.change {
            done.change = change;
            return true;
        }
        std::mem::swap(&mut self.force, &mut self.kept);
        std::mem::swap(&mut self.moved, &mut self.kept_moved);
        false
    }

    /// How many forces of contact `i` a direct solve is for: none where it is open, the normal one where it slides.
    fn unknowns(&self, i: usize) -> u8 {
        match self.laws[i] {
            Law::Glue => 3,
            Law::Coulomb(friction) => {
                let p = self.force[i];
                let limit = friction * p.x * (1.0 - 1e-9);
                match p.x > 0.0 {
                    false => 0,
                    true if p.y * p.y + p.z * p.z < limit * limit => 3,
                    true => 1,
                }
            }
        }
    }

    /// Takes the step of a direct solve, each contact within what Coulomb's law allows; true when some of them had to give.
    fn take(&mut self, direct: &Direct) -> bool {
        let mut gave = false;
        for i in 0..self.count {
            let unknowns = self.unknowns(i);
            if unknowns == 0 {
                continue;
            }
            let mut next = self.force[i] + direct.step(i);
            if let Law::Coulomb(friction) = self.laws[i] {
                let (length, limit) = (next.y.hypot(next.z), friction * next.x);
                if next.x <= 0.0 {
                    next = DVec3::ZERO;
                    gave = true;
                } else if unknowns == 1 || length > limit {
                    gave |= unknowns == 3;
                    let scale = if length > 0.0 { limit / length } else { 0.0 };
                    next = DVec3::new(next.x, next.y * scale, next.z * scale);
                }
            }
            self.change(i, next);
        }
        gave
    }

    /// u after the last solve, m.
    pub fn moved(&self) -> &[DVec3] {
        &self.moved
    }

    fn apply(&mut self, j: usize, p: DVec3) {
        self.moved[j] += self.diagonal[j] * p;
        for (i, block) in &self.columns[j] {
            self.moved[*i as usize] += *block * p;
        }
    }
}
