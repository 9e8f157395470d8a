//! Small dense linear algebra for calibration: symmetric positive semidefinite systems of a few
//! hundred unknowns at most.
//!
//! A lattice cell has mechanisms (rigid motion, unsupported layers), so its stiffness matrix is
//! singular. Cholesky with diagonal pivoting (Higham, *Accuracy and Stability of Numerical
//! Algorithms*, 2002, section 10.3) finds the rank and a solution wherever the load does no work on
//! a mechanism; energies are the same for all solutions.

/// Symmetric n by n matrix, row by row; both triangles are stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SymmetricMatrix {
    n: usize,
    data: Vec<f64>,
}

/// Rank tolerance: smaller pivots, as a fraction of the largest diagonal entry, belong to
/// mechanisms.
const RANK_TOLERANCE: f64 = 1e-11;

impl SymmetricMatrix {
    /// Zero matrix.
    pub fn zeros(n: usize) -> Self {
        Self { n, data: vec![0.0; n * n] }
    }

    /// Entry in row `i`, column `j`.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.data[i * self.n + j]
    }

    /// Add to one entry; the caller keeps the matrix symmetric.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.data[i * self.n + j] += value;
    }

    /// Add `k` times the outer product of a sparse vector with itself.
    pub fn add_outer(&mut self, k: f64, entries: &[(usize, f64)]) {
        for (i, p) in entries {
            for (j, q) in entries {
                self.data[i * self.n + j] += k * p * q;
            }
        }
    }

    /// Solve A x = b for each column b of `loads`, in place. Unknowns of mechanisms are zero.
    pub fn solve(mut self, loads: &mut [Vec<f64>]) {
        let n = self.n;
        let order = self.factor();
        let rank = order.len();
        let l = |i: usize, j: usize| self.data[i * n + j];
        for load in loads.iter_mut() {
            let mut y: Vec<f64> = order.iter().map(|i| load[*i]).collect();
            for i in 0..rank {
                let known: f64 = (0..i).map(|j| l(order[i], j) * y[j]).sum();
                y[i] = (y[i] - known) / l(order[i], i);
            }
            for i in (0..rank).rev() {
                let known: f64 = (i + 1..rank).map(|j| l(order[j], i) * y[j]).sum();
                y[i] = (y[i] - known) / l(order[i], i);
            }
            load.fill(0.0);
            for (i, value) in order.iter().zip(y) {
                load[*i] = value;
            }
        }
    }

    /// Replace row i of the matrix by row i of L (its first `rank` entries). Returns the pivots in
    /// order.
    fn factor(&mut self) -> Vec<usize> {
        let n = self.n;
        let mut diagonal: Vec<f64> = (0..n).map(|i| self.at(i, i)).collect();
        let tolerance = RANK_TOLERANCE * diagonal.iter().copied().fold(0.0, f64::max);
        let mut order: Vec<usize> = Vec::with_capacity(n);
        let mut rest: Vec<usize> = (0..n).collect();
        let mut lower = vec![0.0; n * n];
        // Among equals the first is taken, so that the order depends on the matrix alone.
        while let Some(place) = (0..rest.len()).reduce(|a, b| if diagonal[rest[b]] > diagonal[rest[a]] { b } else { a })
        {
            let pivot = rest[place];
            if diagonal[pivot] <= tolerance {
                break;
            }
            rest.remove(place);
            let step = order.len();
            let root = diagonal[pivot].sqrt();
            lower[pivot * n + step] = root;
            for i in &rest {
                let known: f64 = (0..step).map(|j| lower[i * n + j] * lower[pivot * n + j]).sum();
                let value = (self.at(*i, pivot) - known) / root;
                lower[i * n + step] = value;
                diagonal[*i] -= value * value;
            }
            order.push(pivot);
        }
        self.data = lower;
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_springs_that_floats_is_solved_up_to_its_rigid_motion() {
        // Springs 1, 2 and 4 between four nodes, pulled apart with force 8: they extend by 8, 4 and
        // 2.
        let mut k = SymmetricMatrix::zeros(4);
        for (i, stiffness) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            k.add_outer(stiffness, &[(i, -1.0), (i + 1, 1.0)]);
        }
        let mut loads = [vec![-8.0, 0.0, 0.0, 8.0]];
        k.solve(&mut loads);
        let u = &loads[0];
        for (i, stretch) in [8.0, 4.0, 2.0].into_iter().enumerate() {
            assert!((u[i + 1] - u[i] - stretch).abs() < 1e-12, "{u:?}");
        }
    }

    #[test]
    fn a_matrix_of_zeros_moves_nothing() {
        let mut loads = [vec![0.0; 3]];
        SymmetricMatrix::zeros(3).solve(&mut loads);
        assert_eq!(loads[0], [0.0; 3]);
    }
}
