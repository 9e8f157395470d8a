//! The contact problem of several contacts, solved by Gauss-Seidel sweeps.
//!
//! u = W p + b in the frames of the contacts, Coulomb's law at each (see `coulomb`). W = J H⁻¹ Jᵀ is the Delassus operator:
//! how every contact answers a force at every other. Contacts that share no sheet and no body do not couple, so W is kept
//! by columns of 3x3 blocks that are there.

use glam::{DMat3, DVec3};

use super::coulomb::{Law, solve};

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
        let mut done = Swept::default();
        while done.sweeps < most {
            done.sweeps += 1;
            done.change = 0.0;
            for i in 0..self.count {
                let old = self.force[i];
                if old == DVec3::ZERO && self.moved[i].x >= 0.0 && self.laws[i] != Law::Glue {
                    continue;
                }
                let a = self.diagonal[i];
                let new = solve(&a, self.moved[i] - a * old, self.laws[i], old);
                let step = new - old;
                if step != DVec3::ZERO {
                    self.force[i] = new;
                    self.apply(i, step);
                    let diagonal = DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z);
                    done.change = f64::max(done.change, (diagonal * step).abs().element_sum());
                }
            }
            if done.change <= tolerance {
                break;
            }
        }
        done
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
