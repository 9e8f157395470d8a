//! Sparse symmetric positive definite systems A x = b of 3x3 blocks, one block row for each free mass, by A = L Lᵀ.
//!
//! The pattern of A stays for long and its values are new at every solve. So [`analyse`] does once what depends on the
//! pattern alone (`dissection`: an ordering that keeps L sparse; where every number goes; all memory), and a [`Factor`] then
//! factorises and solves again and again without allocating. Units are the caller's: values of A in N/m (or kg/s²) give
//! displacements in m for forces in N.
//!
//! The bits of a result depend on the backend and on the instructions it runs with ([`Path`]; faer chooses its own), and on
//! nothing else of the machine.
//!
//! Reference: T. A. Davis, *Direct Methods for Sparse Linear Systems* (SIAM 2006), chapters 4 and 7.

#[cfg(test)]
mod cases;
pub(crate) mod dissection;
pub(crate) mod faer;
pub(crate) mod half;
pub(crate) mod multifrontal;
pub(crate) mod pattern;
#[cfg(test)]
mod tests;

pub use crate::linear::half::{HalfSolutions, Loads};
pub use crate::linear::multifrontal::Path;
pub use crate::linear::pattern::Pattern;

use crate::linear::dissection::Tree;
use crate::linear::faer::FaerFactor;
use crate::linear::multifrontal::{Instructions, MultifrontalFactor};

/// A matrix that has no Cholesky factor: a pivot was zero, negative or not a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite")]
pub struct NotPositive;

/// The Cholesky factor of one pattern, with the memory to compute it in.
pub trait Factor: Send + Sync {
    /// Factorises. `values` are 9 for each block of the pattern, as [`Pattern`] says; of a diagonal block the lower
    /// triangle counts.
    ///
    /// # Errors
    /// When a pivot is not positive (or not a number). There is no factor then until the next success.
    ///
    /// # Panics
    /// When there are not 9 values a block.
    fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositive>;

    /// Solves A x = b with the last factor, in place: `b` has 3 entries a block row, x, y, z. Without a factor `b` is
    /// filled with NaN.
    ///
    /// # Panics
    /// When `b` has not 3 entries a block row.
    fn solve(&mut self, b: &mut [f64]);

    /// Factorises, then solves A x = b in place: what [`Factor::factorize`] and [`Factor::solve`] do, but L need not be read
    /// again for the first half of the solution. `b` is spoilt when it fails.
    ///
    /// # Errors
    /// As [`Factor::factorize`].
    ///
    /// # Panics
    /// As both.
    fn factorize_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), NotPositive> {
        self.factorize(values)?;
        self.solve(b);
        Ok(())
    }

    /// Adds the half solutions of `loads` with the last factor to `solutions`; nothing is allocated once `solutions` has held
    /// as much. Without a factor they are NaN.
    ///
    /// # Panics
    /// When a load names a block row there is not.
    fn half_solve(&mut self, loads: &Loads, solutions: &mut HalfSolutions);

    /// Whether threads of the pool that a factorisation is called in may help with it; the bits do not depend on that. Not to begin with.
    fn use_threads(&mut self, parallel: bool) {
        let _ = parallel;
    }

    /// Name of the backend, and of what it chose on this machine.
    fn name(&self) -> &'static str;

    /// Multiply-adds of one factorisation, without padding.
    fn flops(&self) -> f64;

    /// Numbers in L, without padding.
    fn nonzeros(&self) -> usize;
}

/// Who factorises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The `faer` library, supernodal, on one thread.
    Faer,
    /// `faer`'s L D Lᵀ without pivoting, for matrices that may be indefinite; it has no half solutions.
    Indefinite,
    /// Our own, by the best instructions the processor has.
    Multifrontal,
}

impl Default for Backend {
    /// The faster one, as `benches/factor.rs` measures them: ours where the processor has AVX2 and fused multiply-add.
    fn default() -> Self {
        match Path::best() {
            Path::Portable => Self::Faer,
            Path::Avx2 | Path::Avx512 => Self::Multifrontal,
        }
    }
}

/// Prepares the factorisation of matrices of `pattern`. `places` are the material coordinates (u, v), m, of every block
/// row; they guide the ordering and need not be distinct, regular or even finite for a right answer, only for a quick one.
///
/// # Panics
/// When there is not one place a block row.
pub fn analyse(pattern: &Pattern, places: &[[f64; 2]], backend: Backend) -> Box<dyn Factor> {
    with_tree(pattern, &order(pattern, places), backend)
}

/// As [`analyse`] for several sheets that touch: `depths` (m), one a block row, tell them apart where their `places` do not.
///
/// # Panics
/// When there is not one place and one depth a block row.
pub fn analyse_joined(pattern: &Pattern, places: &[[f64; 2]], depths: &[f64], backend: Backend) -> Box<dyn Factor> {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    assert_eq!(depths.len(), pattern.size(), "one depth a block row");
    with_tree(pattern, &dissection::dissect(pattern, places, depths), backend)
}

fn with_tree(pattern: &Pattern, tree: &Tree, backend: Backend) -> Box<dyn Factor> {
    match backend {
        Backend::Faer => Box::new(FaerFactor::new(pattern, tree, false)),
        Backend::Indefinite => Box::new(FaerFactor::new(pattern, tree, true)),
        Backend::Multifrontal => Box::new(MultifrontalFactor::new(pattern, tree, Instructions::best())),
    }
}

/// As [`analyse`] with [`Backend::Multifrontal`], by the instructions of `path`; none where this processor lacks them.
///
/// # Panics
/// When there is not one place a block row.
pub fn analyse_for(pattern: &Pattern, places: &[[f64; 2]], path: Path) -> Option<Box<dyn Factor>> {
    let instructions = path.instructions()?;
    Some(Box::new(MultifrontalFactor::new(pattern, &order(pattern, places), instructions)))
}

fn order(pattern: &Pattern, places: &[[f64; 2]]) -> Tree {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    dissection::dissect(pattern, places, &[])
}
