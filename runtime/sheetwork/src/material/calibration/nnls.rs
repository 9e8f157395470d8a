//! Least squares with non-negative unknowns.
//!
//! min |C x - d| over x ≥ 0: the active-set method of Lawson and Hanson (*Solving Least Squares
//! Problems*, 1974, chapter 23, algorithm NNLS). A spring of negative stiffness would be unstable.

use crate::material::calibration::dense::SymmetricMatrix;

/// Vector x ≥ 0 with the least |Σ x_j columns_j - wanted|. All columns are as long as `wanted`; a
/// column of zeros gets 0.
pub(crate) fn nonnegative_least_squares(columns: &[Vec<f64>], wanted: &[f64]) -> Vec<f64> {
    let norms: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    // Columns are normalised, so that one tolerance serves all.
    let scaled: Vec<Vec<f64>> = columns
        .iter()
        .zip(&norms)
        .map(|(c, norm)| c.iter().map(|v| if *norm > 0.0 { v / norm } else { 0.0 }).collect())
        .collect();
    let x = active_set(&scaled, wanted);
    x.iter().zip(&norms).map(|(x, norm)| if *norm > 0.0 { x / norm } else { 0.0 }).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn active_set(columns: &[Vec<f64>], wanted: &[f64]) -> Vec<f64> {
    let n = columns.len();
    let tolerance = 1e-12 * dot(wanted, wanted).sqrt();
    let mut x = vec![0.0; n];
    let mut passive = vec![false; n];
    // Every pass adds one column; the theory bounds the passes, and three times the bound allows
    // for rounding.
    for _ in 0..3 * n {
        let residual = residual(columns, &x, wanted);
        let gradient = |j: usize| dot(&columns[j], &residual);
        let best = (0..n).filter(|j| !passive[*j]).reduce(|a, b| if gradient(b) > gradient(a) { b } else { a });
        let Some(enter) = best.filter(|j| gradient(*j) > tolerance) else { break };
        passive[enter] = true;
        loop {
            let trial = least_squares(columns, &passive, wanted);
            let blocked = (0..n).filter(|j| passive[*j] && trial[*j] <= 0.0);
            let step = blocked.map(|j| x[j] / (x[j] - trial[j])).fold(1.0_f64, f64::min);
            if step >= 1.0 {
                x = trial;
                break;
            }
            for j in 0..n {
                x[j] += step * (trial[j] - x[j]);
                if passive[j] && x[j] <= 1e-14 {
                    (passive[j], x[j]) = (false, 0.0);
                }
            }
        }
    }
    x
}

fn residual(columns: &[Vec<f64>], x: &[f64], wanted: &[f64]) -> Vec<f64> {
    let fitted = |row: usize| columns.iter().zip(x).map(|(c, x)| c[row] * x).sum::<f64>();
    wanted.iter().enumerate().map(|(row, d)| d - fitted(row)).collect()
}

/// Ordinary least squares in the columns of the passive set; zero elsewhere.
fn least_squares(columns: &[Vec<f64>], passive: &[bool], wanted: &[f64]) -> Vec<f64> {
    let set: Vec<usize> = (0..columns.len()).filter(|j| passive[*j]).collect();
    let mut normal = SymmetricMatrix::zeros(set.len());
    for (row, i) in set.iter().enumerate() {
        for (column, j) in set.iter().enumerate() {
            normal.add(row, column, dot(&columns[*i], &columns[*j]));
        }
    }
    let mut solution = [set.iter().map(|j| dot(&columns[*j], wanted)).collect::<Vec<f64>>()];
    normal.solve(&mut solution);
    let mut x = vec![0.0; columns.len()];
    set.iter().zip(&solution[0]).for_each(|(j, value)| x[*j] = *value);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_positive_solution_is_found() {
        let columns = [vec![1.0, 0.0, 1.0], vec![0.0, 2.0, 1.0]];
        let x = nonnegative_least_squares(&columns, &[3.0, 8.0, 7.0]);
        assert!((x[0] - 3.0).abs() < 1e-12 && (x[1] - 4.0).abs() < 1e-12, "{x:?}");
    }

    #[test]
    fn negative_components_become_zero_and_the_rest_fits_best() {
        // Unconstrained: x = (2, -1). With x2 = 0 the best x1 is (2, 1, 1)·(1, 1, 0)/2 = 1.5.
        let columns = [vec![1.0, 1.0, 0.0], vec![0.0, 1.0, -1.0]];
        let x = nonnegative_least_squares(&columns, &[2.0, 1.0, 1.0]);
        assert!((x[0] - 1.5).abs() < 1e-12 && x[1] == 0.0, "{x:?}");
    }

    #[test]
    fn the_conditions_of_a_minimum_hold() {
        // Kuhn-Tucker: zero gradient where x > 0, no descent where x = 0. Numbers from a small
        // fixed generator.
        let mut seed = 12345_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        for _ in 0..200 {
            let columns: Vec<Vec<f64>> = (0..5).map(|_| (0..8).map(|_| random()).collect()).collect();
            let wanted: Vec<f64> = (0..8).map(|_| random()).collect();
            let x = nonnegative_least_squares(&columns, &wanted);
            let rest = residual(&columns, &x, &wanted);
            for (column, x) in columns.iter().zip(&x) {
                let gradient = dot(column, &rest);
                assert!(*x >= 0.0 && gradient < 1e-10 && (*x == 0.0 || gradient > -1e-10), "{x} {gradient}");
            }
        }
    }
}
