//! Eigenvalues of small dense symmetric matrices.

use nalgebra::{DMatrix, DVector};

/// Iterations of the QR algorithm for each eigenvalue before it counts as failed.
const MAX_ITERATIONS: usize = 100;

/// Eigenvalues, ascending, and the orthonormal eigenvectors as columns in the same order; `None` if
/// the matrix is not finite or the iteration does not converge.
pub(crate) fn symmetric_eigen(matrix: DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let n = matrix.nrows();
    if n == 0 || matrix.iter().any(|a| !a.is_finite()) {
        return (n == 0).then(|| (DVector::zeros(0), matrix));
    }
    let eigen = matrix.try_symmetric_eigen(f64::EPSILON, MAX_ITERATIONS * n)?;
    let mut ascending: Vec<usize> = (0..n).collect();
    ascending.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let values = DVector::from_fn(n, |k, _| eigen.eigenvalues[ascending[k]]);
    Some((values, eigen.eigenvectors.select_columns(&ascending)))
}
