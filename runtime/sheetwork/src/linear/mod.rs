//! Sparse symmetric positive definite systems A x = b of 3x3 blocks, one block row per free node,
//! solved with A = L Lᵀ.
//!
//! The pattern of A rarely changes; its values change at every solve. [`analyse`] does the work
//! that depends on the pattern alone (`dissection`: a fill-reducing ordering; the destination of
//! every value; all memory), and a [`Factor`] then factorises and solves repeatedly without
//! allocation. Units are those of the caller: values of A in N/m give displacements in m for forces
//! in N.
//!
//! The bits of a result depend on the instruction set ([`InstructionSet`]) and on nothing else of
//! the machine.
//!
//! Source: T. A. Davis, *Direct Methods for Sparse Linear Systems* (SIAM 2006), chapters 4 and 7.

#[cfg(test)]
mod cases;
pub(crate) mod dense;
pub(crate) mod dissection;
pub(crate) mod half;
pub(crate) mod ldl;
pub(crate) mod multifrontal;
pub(crate) mod pattern;
#[cfg(test)]
mod tests;

pub use crate::linear::half::{HalfSolutions, SparseLoads};
pub use crate::linear::multifrontal::InstructionSet;
pub use crate::linear::pattern::Pattern;

use crate::linear::dissection::EliminationTree;
use crate::linear::multifrontal::{Instructions, MultifrontalFactor};

/// The matrix has no Cholesky factor: a pivot is zero, negative or not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite")]
pub struct NotPositiveDefinite;

/// The Cholesky factor of matrices with one pattern, with its memory.
pub trait Factor: Send + Sync {
    /// Factorises. `values` has 9 numbers per block of the pattern, in the order that [`Pattern`]
    /// defines; diagonal blocks need their lower triangle only.
    ///
    /// # Errors
    /// If a pivot is not positive or not finite. There is then no factor until the next success.
    ///
    /// # Panics
    /// If `values` does not have 9 numbers per block.
    fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite>;

    /// Solves A x = b in place with the last factor: `b` has 3 entries (x, y, z) per block row.
    /// Without a factor `b` becomes NaN.
    ///
    /// # Panics
    /// If `b` does not have 3 entries per block row.
    fn solve(&mut self, b: &mut [f64]);

    /// Factorises, then solves A x = b in place: equal to [`Factor::factorize`] and
    /// [`Factor::solve`], but the forward substitution uses L while it is in the cache. On failure
    /// the content of `b` is undefined.
    ///
    /// # Errors
    /// As [`Factor::factorize`].
    ///
    /// # Panics
    /// As [`Factor::factorize`] and [`Factor::solve`].
    fn factorize_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), NotPositiveDefinite> {
        self.factorize(values)?;
        self.solve(b);
        Ok(())
    }

    /// Appends the half solutions of `loads` with the last factor to `solutions`, without
    /// allocation if the capacity of `solutions` suffices. Without a factor they are NaN.
    ///
    /// # Panics
    /// If a load names a block row out of range.
    fn half_solve(&mut self, loads: &SparseLoads, solutions: &mut HalfSolutions);

    /// Enables threads of the calling thread's pool in factorisations; off by default. The bits of
    /// the result do not depend on it.
    fn set_parallel(&mut self, parallel: bool) {
        let _ = parallel;
    }

    /// Name of the method and its instruction set.
    fn name(&self) -> &'static str;

    /// Multiply-add operations of one factorisation, without padding.
    fn flops(&self) -> f64;

    /// Non-zeros of L, without padding.
    fn nonzeros(&self) -> usize;
}

/// Prepares the factorisation of matrices of `pattern`. `places` are the material coordinates (u,
/// v), m, of every block row. They guide the ordering; coincident, irregular or non-finite places
/// cost speed, not accuracy.
///
/// # Panics
/// If there is not one place per block row.
pub fn analyse(pattern: &Pattern, places: &[[f64; 2]]) -> Box<dyn Factor> {
    factor(pattern, &order(pattern, places), Instructions::best())
}

/// As [`analyse`], for several sheets in contact: `depths` (m), one per block row, separate sheets
/// with coincident `places`.
///
/// # Panics
/// If there is not one place and one depth per block row.
pub fn analyse_joined(pattern: &Pattern, places: &[[f64; 2]], depths: &[f64]) -> Box<dyn Factor> {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    assert_eq!(depths.len(), pattern.size(), "one depth a block row");
    factor(pattern, &dissection::dissect(pattern, places, depths), Instructions::best())
}

fn factor(pattern: &Pattern, tree: &EliminationTree, instructions: Instructions) -> Box<dyn Factor> {
    Box::new(MultifrontalFactor::new(pattern, tree, instructions))
}

/// As [`analyse`] with the instruction set `path` instead of the best; `None` if the processor
/// lacks it.
///
/// # Panics
/// If there is not one place per block row.
pub fn analyse_for(pattern: &Pattern, places: &[[f64; 2]], path: InstructionSet) -> Option<Box<dyn Factor>> {
    Some(factor(pattern, &order(pattern, places), path.instructions()?))
}

fn order(pattern: &Pattern, places: &[[f64; 2]]) -> EliminationTree {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    dissection::dissect(pattern, places, &[])
}
