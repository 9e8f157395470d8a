//! A contact as the unknowns see it: u = b + Σ J_k δ_k over the block rows k that it is of, in the contact's frame.
//!
//! A mass with weight w has J = w Fᵀ with F the frame (normal, two tangents) and its held directions left out; a body that gives
//! way has J = Fᵀ for the displacement of its centre and J = -Fᵀ [r]× for its turn, r the arm from there. The side that the
//! normal comes from has the other sign.

use glam::{DMat3, DVec3};

use crate::contact::coulomb::Law;
use crate::linear::Pattern;

/// Block rows of a contact, at most: three masses on each side.
const MOST: usize = 6;

/// A contact as the unknowns see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Block rows and J, the first `count` of them.
    rows: [u32; MOST],
    parts: [DMat3; MOST],
    count: u8,
    /// Columns: normal and two tangents.
    pub frame: DMat3,
    pub law: Law,
    /// Whether nothing is known of it: it then pushes, for a beginning, if its gap is less than `eager` (m).
    pub new: bool,
    pub eager: f64,
    /// Whether it never acts.
    pub idle: bool,
    /// Whether it slid when it had the force it begins with.
    pub slid: bool,
    /// u where δ is zero, in the frame, m.
    pub b: DVec3,
    /// Stiffness of the unknowns against it along the frame's axes, N/m; one for both tangents.
    pub stiffness: DVec3,
    /// Where its pairs begin in the list of slots.
    first_slot: u32,
}

impl Row {
    /// A contact of nothing yet.
    pub fn new(frame: DMat3, law: Law) -> Self {
        Self {
            rows: [0; MOST],
            parts: [DMat3::ZERO; MOST],
            count: 0,
            frame,
            law,
            new: true,
            eager: 0.0,
            idle: false,
            slid: false,
            b: DVec3::ZERO,
            stiffness: DVec3::ZERO,
            first_slot: 0,
        }
    }

    /// Adds a displacement `by` δ (in the world) of block row `row`.
    pub fn add(&mut self, row: u32, by: DMat3) {
        let part = self.frame.transpose() * by;
        let count = self.count as usize;
        if let Some(k) = self.rows[..count].iter().position(|r| *r == row) {
            self.parts[k] += part;
        } else if count < MOST {
            (self.rows[count], self.parts[count]) = (row, part);
            self.count += 1;
        }
    }

    fn terms(&self) -> impl Iterator<Item = (u32, &DMat3)> {
        self.rows.iter().copied().zip(&self.parts).take(self.count as usize)
    }

    /// Pairs of block rows that it joins, each as (the later, the earlier).
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let rows = &self.rows[..self.count as usize];
        rows.iter().enumerate().flat_map(move |(k, a)| rows[..=k].iter().map(move |b| (*a.max(b), *a.min(b))))
    }

    /// Looks up where its pairs are in `pattern`.
    pub fn bind(&mut self, pattern: &Pattern, slots: &mut Vec<u32>) {
        self.first_slot = slots.len() as u32;
        slots.extend(self.pairs().map(|(row, column)| pattern.slot(row, column).unwrap_or(u32::MAX)));
    }

    /// Works out how stiff the unknowns are against it, by the diagonal blocks of their matrix (N/m).
    pub fn weigh(&mut self, diagonal: impl Fn(u32) -> DMat3) {
        let mut compliance = DVec3::ZERO;
        for (row, part) in self.terms() {
            let (stiffness, across) = (diagonal(row), part.transpose());
            for k in 0..3 {
                // The displacement of this block row alone, along the force.
                let along = across.col(k);
                let square = along.length_squared();
                if square > 0.0 {
                    compliance[k] += square * square / along.dot(stiffness * along);
                }
            }
        }
        // What is held along the normal does not give way to any force.
        self.idle |= compliance.x <= 0.0;
        let c = compliance.max(DVec3::splat(f64::MIN_POSITIVE)).recip();
        self.stiffness = DVec3::splat(c.min_element());
    }

    /// J δ, m.
    pub fn moved(&self, delta: &[f64]) -> DVec3 {
        self.terms().map(|(row, part)| *part * DVec3::from_slice(&delta[3 * row as usize..])).sum()
    }

    /// Adds Jᵀ p.
    pub fn push(&self, p: DVec3, force: &mut [f64]) {
        for (row, part) in self.terms() {
            let f = part.transpose() * p;
            let at = 3 * row as usize;
            for (to, f) in force[at..at + 3].iter_mut().zip(f.to_array()) {
                *to += f;
            }
        }
    }

    /// Adds Jᵀ D J, given where its pairs are.
    pub fn stiffen(&self, d: &DMat3, slots: &[u32], values: &mut [f64]) {
        let mut slots = slots[self.first_slot as usize..].iter();
        for (k, (a, left)) in self.terms().enumerate() {
            let pulled = *d * *left;
            for (b, right) in self.terms().take(k + 1) {
                let Some(slot) = slots.next().filter(|s| **s != u32::MAX) else { continue };
                // Of rows a and columns b, or the transpose where b is the later.
                let block = if a >= b { pulled.transpose() * *right } else { right.transpose() * pulled };
                let at = 9 * *slot as usize;
                for (to, value) in values[at..at + 9].iter_mut().zip(block.transpose().to_cols_array()) {
                    *to += value;
                }
            }
        }
    }
}
