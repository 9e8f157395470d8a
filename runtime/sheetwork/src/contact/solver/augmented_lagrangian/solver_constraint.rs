//! Constraint of a contact in the unknowns of the solver: u = b + Σ J_k δ_k over its block rows k,
//! in the contact frame F (normal, two tangents).
//!
//! A node with weight w has J = w Fᵀ without its fixed directions. A dynamic body has J = Fᵀ for
//! the displacement of its centre and J = -Fᵀ [r]× for its rotation, with r the arm from the
//! centre. Side b has the opposite sign.

use glam::{DMat3, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::linear::Pattern;

/// Maximum number of block rows of a contact: three nodes on each side.
const BLOCK_ROW_CAPACITY: usize = 6;

/// Constraint of a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolverConstraint {
    /// Block rows; the first `count` are used.
    rows: [u32; BLOCK_ROW_CAPACITY],
    /// Jacobian block J_k of each block row, in the contact frame.
    parts: [DMat3; BLOCK_ROW_CAPACITY],
    count: u8,
    /// Contact frame; columns are the normal and two tangents.
    pub frame: DMat3,
    pub law: ContactLaw,
    /// Whether the contact has no known force; it then starts as closed if its gap is less than
    /// `closing_gap`.
    pub is_new: bool,
    /// Gap (m) below which a new contact starts as closed.
    pub closing_gap: f64,
    /// Whether the contact is disabled.
    pub is_disabled: bool,
    /// Whether the contact slipped when it had its initial force.
    pub slipped: bool,
    /// u for δ = 0, in the contact frame, m.
    pub b: DVec3,
    /// Stiffness of the unknowns along the axes of the frame, N/m; equal for both tangents.
    pub stiffness: DVec3,
    /// Position of its block pairs in the list of slots.
    first_slot: u32,
}

impl SolverConstraint {
    /// A constraint without block rows.
    pub fn new(frame: DMat3, law: ContactLaw) -> Self {
        Self {
            rows: [0; BLOCK_ROW_CAPACITY],
            parts: [DMat3::ZERO; BLOCK_ROW_CAPACITY],
            count: 0,
            frame,
            law,
            is_new: true,
            closing_gap: 0.0,
            is_disabled: false,
            slipped: false,
            b: DVec3::ZERO,
            stiffness: DVec3::ZERO,
            first_slot: 0,
        }
    }

    /// Add the contribution `by` δ (in world axes) of block row `row`.
    pub fn add(&mut self, row: u32, by: DMat3) {
        let part = self.frame.transpose() * by;
        let count = self.count as usize;
        if let Some(k) = self.rows[..count].iter().position(|r| *r == row) {
            self.parts[k] += part;
        } else if count < BLOCK_ROW_CAPACITY {
            (self.rows[count], self.parts[count]) = (row, part);
            self.count += 1;
        }
    }

    fn terms(&self) -> impl Iterator<Item = (u32, &DMat3)> {
        self.rows.iter().copied().zip(&self.parts).take(self.count as usize)
    }

    /// Pairs of block rows that the constraint couples, as (larger, smaller) index.
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> + Clone + '_ {
        let rows = &self.rows[..self.count as usize];
        rows.iter().enumerate().flat_map(move |(k, a)| rows[..=k].iter().map(move |b| (*a.max(b), *a.min(b))))
    }

    /// Look up the slots of the block pairs in `pattern`.
    pub fn look_up_slots(&mut self, pattern: &Pattern, slots: &mut Vec<u32>) {
        self.first_slot = slots.len() as u32;
        slots.extend(self.pairs().map(|(row, column)| pattern.slot(row, column).unwrap_or(u32::MAX)));
    }

    /// Compute the stiffness from the diagonal blocks of the matrix (N/m).
    pub fn compute_stiffness(&mut self, diagonal: impl Fn(u32) -> DMat3) {
        let mut compliance = DVec3::ZERO;
        for (row, part) in self.terms() {
            let (stiffness, across) = (diagonal(row), part.transpose());
            for k in 0..3 {
                // Compliance of this block row alone along the force.
                let along = across.col(k);
                let square = along.length_squared();
                if square > 0.0 {
                    compliance[k] += square * square / along.dot(stiffness * along);
                }
            }
        }
        // A contact whose nodes are all fixed along the normal cannot be opened by a force.
        self.is_disabled |= compliance.x <= 0.0;
        let c = compliance.max(DVec3::splat(f64::MIN_POSITIVE)).recip();
        self.stiffness = DVec3::splat(c.min_element());
    }

    /// J δ, m.
    pub fn displacement(&self, delta: &[f64]) -> DVec3 {
        self.terms().map(|(row, part)| *part * DVec3::from_slice(&delta[3 * row as usize..])).sum()
    }

    /// Add Jᵀ p to `force`, N.
    pub fn add_force(&self, p: DVec3, force: &mut [f64]) {
        for (row, part) in self.terms() {
            let f = part.transpose() * p;
            let at = 3 * row as usize;
            for (to, f) in force[at..at + 3].iter_mut().zip(f.to_array()) {
                *to += f;
            }
        }
    }

    /// Add Jᵀ D J to the matrix `values`, at the slots of the block pairs.
    pub fn add_stiffness(&self, d: &DMat3, slots: &[u32], values: &mut [f64]) {
        let mut slots = slots[self.first_slot as usize..].iter();
        for (k, (a, left)) in self.terms().enumerate() {
            let pulled = *d * *left;
            for (b, right) in self.terms().take(k + 1) {
                let Some(slot) = slots.next().filter(|s| **s != u32::MAX) else { continue };
                // The block of rows a and columns b, or its transpose if b has the larger index.
                let block = if a >= b { pulled.transpose() * *right } else { right.transpose() * pulled };
                let at = 9 * *slot as usize;
                for (to, value) in values[at..at + 9].iter_mut().zip(block.transpose().to_cols_array()) {
                    *to += value;
                }
            }
        }
    }
}
