//! Eigenvalues of small symmetric matrices by Jacobi rotations (Golub and Van Loan, *Matrix
//! Computations*, 8.5), and the pseudo-inverse from them.

/// Maximum number of Jacobi sweeps; convergence is quadratic and needs far fewer.
const MAXIMUM_JACOBI_SWEEPS: usize = 30;

/// Eigenvalues, and eigenvectors as columns.
pub fn eigen<const N: usize>(matrix: &[[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut a = *matrix;
    let mut v = [[0.0; N]; N];
    (0..N).for_each(|i| v[i][i] = 1.0);
    let scale: f64 = a.as_flattened().iter().map(|x| x * x).sum();
    for _ in 0..MAXIMUM_JACOBI_SWEEPS {
        let off: f64 = (0..N).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        if off <= 1e-34 * scale {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), v)
}

/// Rotates the plane of p and q such that a[p][q] vanishes.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], v: &mut [[f64; N]; N], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for row in a.iter_mut().chain(v.iter_mut()) {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..N {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
}

/// The pseudo-inverse; eigenvalues below `singular` times the largest count as zero.
pub fn pseudo_inverse<const N: usize>(matrix: &[[f64; N]; N], singular: f64) -> [[f64; N]; N] {
    let (values, vectors) = eigen(matrix);
    let least = singular * values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut inverse = [[0.0; N]; N];
    for k in (0..N).filter(|k| values[*k].abs() > least) {
        for i in 0..N {
            (0..N).for_each(|j| inverse[i][j] += vectors[i][k] * vectors[j][k] / values[k]);
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hilbert_like_matrices_are_inverted() {
        let a: [[f64; 6]; 6] =
            std::array::from_fn(|i| std::array::from_fn(|j| 1.0 / (i + j + 1) as f64 + if i == j { 0.1 } else { 0.0 }));
        let b = pseudo_inverse(&a, 1e-12);
        for i in 0..6 {
            for j in 0..6 {
                let product: f64 = (0..6).map(|k| a[i][k] * b[k][j]).sum();
                assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_singular_matrix_keeps_its_range() {
        let a = [[2.0, 2.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 5.0]];
        let b = pseudo_inverse(&a, 1e-9);
        let wanted = [[0.125, 0.125, 0.0], [0.125, 0.125, 0.0], [0.0, 0.0, 0.2]];
        for (b, w) in b.as_flattened().iter().zip(wanted.as_flattened()) {
            assert!((b - w).abs() < 1e-14);
        }
    }
}
