//! Numerical factorisation of all fronts: assembly, elimination, and the Schur complements.

use std::ops::Range;

use crate::linear::multifrontal::kernels::{self, DenseFront};
use crate::linear::multifrontal::lanes::{Lanes, VectorKernel};
use crate::linear::multifrontal::solve::{self, RightHandSide};
use crate::linear::multifrontal::symbolic::{Front, RowRun, SymbolicFactor};

/// Factorisation of `fronts`, whose children are among them or finished. `values` are those of the
/// matrix; `columns` and `schur` are buffers; `factor` is the result. With `forward`, the
/// right-hand side passes through each front right after its factorisation, while it is in the
/// cache.
pub(crate) struct Factorise<'a> {
    pub symbolic: &'a SymbolicFactor,
    pub fronts: Range<usize>,
    pub values: &'a [f64],
    pub columns: &'a mut [f64],
    pub schur: ArenaSlice<'a>,
    pub factor: ArenaSlice<'a>,
    pub forward: Option<RightHandSide<'a>>,
}

/// A slice of a memory that begins at index `from` of it.
pub(crate) struct ArenaSlice<'a> {
    pub from: usize,
    pub memory: &'a mut [f64],
}

impl ArenaSlice<'_> {
    fn of(&self, range: Range<usize>) -> Range<usize> {
        range.start - self.from..range.end - self.from
    }
}

impl<const G: usize> VectorKernel<G> for Factorise<'_> {
    /// Whether all pivots are positive.
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes<G>>(mut self, lanes: L) -> bool {
        let symbolic = self.symbolic;
        for front in &symbolic.fronts[self.fronts.clone()] {
            let columns = &mut self.columns[..front.rows() * front.wide];
            clear(front, columns);
            add_blocks(symbolic, front, self.values, columns);
            for child in children(symbolic, front) {
                let s = &self.schur.memory[self.schur.of(child.schur_range())];
                add_to_columns(lanes, &symbolic.runs[child.runs.clone()], s, child.tall, front, columns);
            }
            let range = self.factor.of(front.factor_range());
            let factor = chunks_mut(&mut self.factor.memory[range]);
            let dense = DenseFront {
                columns: chunks(columns),
                stride: front.rows() / G,
                pivots: front.pivots,
                wide: front.wide,
            };
            if !kernels::factorise(lanes, dense, factor) {
                return false;
            }
            if let Some(RightHandSide { x, local }) = &mut self.forward {
                solve::forward(lanes, symbolic, front, factor, x, local);
            }
            let below = &factor[front.wide * front.wide / G..];
            let own = self.schur.of(front.schur_range());
            let s = chunks_mut(&mut self.schur.memory[own.clone()]);
            kernels::schur(lanes, [front.pivots, front.wide], below, s);
            for child in children(symbolic, front) {
                let range = self.schur.of(child.schur_range());
                let (from, to) = two(self.schur.memory, range, own.clone());
                add_to_schur(lanes, &symbolic.runs[child.runs.clone()], from, child.tall, front, to);
            }
        }
        true
    }
}

fn children<'a>(symbolic: &'a SymbolicFactor, front: &Front) -> impl Iterator<Item = &'a Front> {
    symbolic.children[front.children.clone()].iter().map(|&c| &symbolic.fronts[c as usize])
}

#[inline(always)]
fn chunks<const G: usize>(numbers: &[f64]) -> &[[f64; G]] {
    numbers.as_chunks().0
}

#[inline(always)]
fn chunks_mut<const G: usize>(numbers: &mut [f64]) -> &mut [[f64; G]] {
    numbers.as_chunks_mut().0
}

/// Two disjoint ranges of a memory, one to read and one to write.
#[inline(always)]
fn two(memory: &mut [f64], read: Range<usize>, write: Range<usize>) -> (&[f64], &mut [f64]) {
    if read.start < write.start {
        let (low, high) = memory.split_at_mut(write.start);
        (&low[read], &mut high[..write.len()])
    } else {
        let (low, high) = memory.split_at_mut(read.start);
        (&high[..read.len()], &mut low[write])
    }
}

/// Zeros, and ones on the diagonal of the padding.
#[inline(always)]
fn clear(front: &Front, columns: &mut [f64]) {
    columns.fill(0.0);
    for j in front.pivots..front.wide {
        columns[j * front.rows() + j] = 1.0;
    }
}

/// Adds the front's blocks of the matrix.
#[inline(always)]
fn add_blocks(symbolic: &SymbolicFactor, front: &Front, values: &[f64], columns: &mut [f64]) {
    let rows = front.rows();
    for block in &symbolic.blocks[front.straight.clone()] {
        let v = &values[block.source as usize..block.source as usize + 9];
        let to = &mut columns[block.target as usize..block.target as usize + 2 * rows + 3];
        for j in 0..3 {
            for i in 0..3 {
                to[j * rows + i] = v[3 * i + j];
            }
        }
    }
    for block in &symbolic.blocks[front.mirrored.clone()] {
        let v = &values[block.source as usize..block.source as usize + 9];
        let to = &mut columns[block.target as usize..block.target as usize + 2 * rows + 3];
        for j in 0..3 {
            for i in 0..3 {
                to[j * rows + i] = v[3 * j + i];
            }
        }
    }
}

/// Adds the columns of a child's S that are pivots of the front.
#[inline(always)]
fn add_to_columns<L: Lanes<G>, const G: usize>(
    lanes: L,
    runs: &[RowRun],
    s: &[f64],
    tall: usize,
    front: &Front,
    columns: &mut [f64],
) {
    let rows = front.rows();
    for (i, run) in runs.iter().enumerate().take_while(|(_, run)| run.to < front.wide) {
        for t in 0..run.len {
            let from = &s[(run.from + t) * tall..(run.from + t + 1) * tall];
            let to = &mut columns[(run.to + t) * rows..(run.to + t + 1) * rows];
            lanes.add_to(&mut to[run.to + t..run.to + run.len], &from[run.from + t..run.from + run.len]);
            for other in &runs[i + 1..] {
                lanes.add_to(&mut to[other.to..other.to + other.len], &from[other.from..other.from + other.len]);
            }
        }
    }
}

/// Adds the columns of a child's S that are in the boundary of the front.
#[inline(always)]
fn add_to_schur<L: Lanes<G>, const G: usize>(
    lanes: L,
    runs: &[RowRun],
    s: &[f64],
    tall: usize,
    front: &Front,
    into: &mut [f64],
) {
    let rows = front.tall;
    let first = runs.partition_point(|run| run.to < front.wide);
    for (i, run) in runs.iter().enumerate().skip(first) {
        let run_to = run.to - front.wide;
        for t in 0..run.len {
            let from = &s[(run.from + t) * tall..(run.from + t + 1) * tall];
            let to = &mut into[(run_to + t) * rows..(run_to + t + 1) * rows];
            lanes.add_to(&mut to[run_to + t..run_to + run.len], &from[run.from + t..run.from + run.len]);
            for other in &runs[i + 1..] {
                let other_to = other.to - front.wide;
                lanes.add_to(&mut to[other_to..other_to + other.len], &from[other.from..other.from + other.len]);
            }
        }
    }
}
