//! Sparse symmetric positive definite systems A x = b of 3x3 blocks, one block row for each free mass, by A = L Lᵀ.
//!
//! The pattern of A stays for long and its values are new at every solve. So [`analyse`] does once what depends on the
//! pattern alone (`dissection`: an ordering that keeps L sparse; where every number goes; all memory), and a [`Factor`] then
//! factorises and solves again and again without allocating. Units are the caller's: values of A in N/m (or kg/s²) give
//! displacements in m for forces in N.
//!
//! Reference: T. A. Davis, *Direct Methods for Sparse Linear Systems* (SIAM 2006), chapters 4 and 7.

#[cfg(test)]
mod cases;
mod dissection;
mod faer;
mod multifrontal;
mod pattern;
#[cfg(test)]
mod tests;

use multifrontal::MultifrontalFactor;
pub use multifrontal::Path;
pub use pattern::Pattern;

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

    /// Name of the backend, and of what it chose on this machine.
    fn name(&self) -> &'static str;

    /// Multiply-adds of one factorisation, without padding.
    fn flops(&self) -> f64;

    /// Numbers in L, without padding.
    fn nonzeros(&self) -> usize;
}

/// Who factorises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The `faer` library, supernodal, on one thread.
    Faer,
    /// Our own, on one thread, by the best instructions the processor has.
    #[default]
    Multifrontal,
}

/// Prepares the factorisation of matrices of `pattern`. `places` are the material coordinates (u, v), m, of every block
/// row; they guide the ordering and need not be distinct, regular or even finite for a right answer, only for a quick one.
///
/// # Panics
/// When there is not one place a block row.
pub fn analyse(pattern: &Pattern, places: &[[f64; 2]], backend: Backend) -> Box<dyn Factor> {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    let tree = dissection::dissect(pattern, places);
    match backend {
        Backend::Faer => Box::new(faer::FaerFactor::new(pattern, &tree)),
        Backend::Multifrontal => match MultifrontalFactor::new(pattern, &tree, Path::best()) {
            Some(factor) => Box::new(factor),
            None => Box::new(faer::FaerFactor::new(pattern, &tree)),
        },
    }
}

/// As [`analyse`] with [`Backend::Multifrontal`], by the instructions of `path`; none where this processor lacks them.
///
/// # Panics
/// When there is not one place a block row.
pub fn analyse_for(pattern: &Pattern, places: &[[f64; 2]], path: Path) -> Option<Box<dyn Factor>> {
    assert_eq!(places.len(), pattern.size(), "one place a block row");
    let tree = dissection::dissect(pattern, places);
    Some(Box::new(MultifrontalFactor::new(pattern, &tree, path)?))
}
