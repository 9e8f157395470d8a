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
pub use crate::linear::multifrontal::{Factor, InstructionSet};
pub use crate::linear::pattern::Pattern;

use crate::linear::dissection::EliminationTree;
use crate::linear::multifrontal::Instructions;

/// The matrix has no Cholesky factor: a pivot is zero, negative or not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite")]
pub struct NotPositiveDefinite;

/// Prepares the factorisation of matrices of `pattern`. `places` are the material coordinates (u,
/// v), m, of every block row. They guide the ordering; coincident, irregular or non-finite places
/// cost speed, not accuracy.
///
/// # Panics
/// If there is not one place per block row.
pub fn analyse(pattern: &Pattern, places: &[[f64; 2]]) -> Factor {
    Factor::new(pattern, &order(pattern, places), Instructions::best())
}

/// As [`analyse`], for several sheets in contact: `depths` (m), one per block row, separate sheets
/// with coincident `places`.
///
/// # Panics
/// If there is not one place and one depth per block row.
pub fn analyse_joined(pattern: &Pattern, places: &[[f64; 2]], depths: &[f64]) -> Factor {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    assert_eq!(depths.len(), pattern.size(), "one depth a block row");
    Factor::new(pattern, &dissection::dissect(pattern, places, depths), Instructions::best())
}

/// As [`analyse`] with the instruction set `path` instead of the best; `None` if the processor
/// lacks it.
///
/// # Panics
/// If there is not one place per block row.
pub fn analyse_for(pattern: &Pattern, places: &[[f64; 2]], path: InstructionSet) -> Option<Factor> {
    Some(Factor::new(pattern, &order(pattern, places), path.instructions()?))
}

fn order(pattern: &Pattern, places: &[[f64; 2]]) -> EliminationTree {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    dissection::dissect(pattern, places, &[])
}
