//! L D Lᵀ factorisation of indefinite matrices, row by row of L, without pivoting.
//!
//! Row k of L solves L_{<k} D_{<k} l_k = a_k over the non-zeros that the elimination tree predicts,
//! and d_k = a_kk - Σ l_ki² d_i (T. A. Davis, *Algorithm 849: a concise sparse Cholesky
//! factorization package*, ACM Trans. Math. Softw. 31 (2005) 587). It serves where Newton's method
//! meets an unstable equilibrium, seldom and outside the step; [`Factor`](crate::linear::Factor) is
//! for positive definite matrices and faster by its dense blocks.

use crate::linear::{NotPositiveDefinite, Pattern, order};

/// No parent: a root of the elimination tree.
const ROOT: u32 = u32::MAX;

/// The factor of matrices with one pattern, with its memory.
pub(crate) struct IndefiniteFactor {
    /// Position of each scalar unknown in the elimination.
    place: Vec<u32>,
    /// Upper triangle of the permuted matrix by columns: start of each column, and row and index in
    /// the caller's values of each entry.
    starts: Vec<usize>,
    entries: Vec<(u32, u32)>,
    /// Elimination tree.
    parent: Vec<u32>,
    /// Columns of L: start and number of the computed entries of each, and the entries' row and
    /// value.
    columns: Vec<(usize, usize)>,
    lower: Vec<(u32, f64)>,
    diagonal: Vec<f64>,
    /// Dense row, its pattern in topological order, and the last row that visited each column.
    row: Vec<f64>,
    path: Vec<u32>,
    visited: Vec<u32>,
}

impl IndefiniteFactor {
    /// Prepare factorisations of matrices of `pattern`; `places` (m) guide the ordering.
    pub fn new(pattern: &Pattern, places: &[[f64; 2]]) -> Self {
        let block = order(pattern, places).places();
        let n = 3 * pattern.size();
        let mut upper = Vec::with_capacity(9 * pattern.blocks());
        for (slot, row, column) in pattern.iter() {
            for (i, j) in (0..9).map(|k| (k / 3, k % 3)).filter(|(i, j)| row != column || i >= j) {
                let (r, c) = (3 * block[row as usize] + i, 3 * block[column as usize] + j);
                upper.push((r.max(c), r.min(c), 9 * slot as u32 + 3 * i + j));
            }
        }
        upper.sort_unstable();
        let starts = (0..=n).map(|k| upper.partition_point(|e| (e.0 as usize) < k)).collect();
        let mut factor = Self {
            place: block.iter().flat_map(|b| [3 * b, 3 * b + 1, 3 * b + 2]).collect(),
            starts,
            entries: upper.into_iter().map(|(_, row, source)| (row, source)).collect(),
            parent: vec![ROOT; n],
            columns: vec![(0, 0); n],
            lower: Vec::new(),
            diagonal: vec![0.0; n],
            row: vec![0.0; n],
            path: Vec::with_capacity(n),
            visited: vec![ROOT; n],
        };
        factor.count_columns();
        factor
    }

    /// Build the elimination tree and reserve the columns of L.
    fn count_columns(&mut self) {
        let mut counts = vec![0; self.parent.len()];
        for k in 0..self.parent.len() as u32 {
            self.visited[k as usize] = k;
            for &(row, _) in &self.entries[self.starts[k as usize]..self.starts[k as usize + 1]] {
                let mut i = row;
                while self.visited[i as usize] != k {
                    if self.parent[i as usize] == ROOT {
                        self.parent[i as usize] = k;
                    }
                    counts[i as usize] += 1;
                    self.visited[i as usize] = k;
                    i = self.parent[i as usize];
                }
            }
        }
        let mut start = 0;
        for (column, count) in self.columns.iter_mut().zip(counts) {
            *column = (start, 0);
            start += count;
        }
        self.lower = vec![(0, 0.0); start];
    }

    /// Collect row `k` of the matrix in `row`, and in `path` the columns where row `k` of L is
    /// non-zero, children before parents.
    fn gather(&mut self, k: u32, values: &[f64]) {
        self.path.clear();
        self.visited[k as usize] = k;
        for &(row, source) in &self.entries[self.starts[k as usize]..self.starts[k as usize + 1]] {
            self.row[row as usize] += values[source as usize];
            let mut i = row;
            while self.visited[i as usize] != k {
                self.visited[i as usize] = k;
                self.path.push(i);
                i = self.parent[i as usize];
            }
        }
        // A parent has a higher index than its children.
        self.path.sort_unstable();
    }

    fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite> {
        self.visited.fill(ROOT);
        self.row.fill(0.0);
        self.columns.iter_mut().for_each(|c| c.1 = 0);
        for k in 0..self.diagonal.len() {
            self.gather(k as u32, values);
            let mut d = std::mem::take(&mut self.row[k]);
            for &i in &self.path {
                let (start, count) = &mut self.columns[i as usize];
                let y = std::mem::take(&mut self.row[i as usize]);
                for &(r, l) in &self.lower[*start..*start + *count] {
                    self.row[r as usize] -= l * y;
                }
                let l = y / self.diagonal[i as usize];
                d -= l * y;
                self.lower[*start + *count] = (k as u32, l);
                *count += 1;
            }
            if d == 0.0 || !d.is_finite() {
                return Err(NotPositiveDefinite);
            }
            self.diagonal[k] = d;
        }
        Ok(())
    }

    /// Factorise, then solve A x = b in place.
    ///
    /// # Errors
    /// If a leading minor is zero or a value is not finite.
    pub fn factorize_and_solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), NotPositiveDefinite> {
        self.factorize(values)?;
        let x = &mut self.row;
        self.place.iter().zip(&*b).for_each(|(at, b)| x[*at as usize] = *b);
        let column = |k: usize| &self.lower[self.columns[k].0..][..self.columns[k].1];
        for k in 0..x.len() {
            let y = x[k];
            column(k).iter().for_each(|(r, l)| x[*r as usize] -= l * y);
        }
        for k in (0..x.len()).rev() {
            x[k] = column(k).iter().fold(x[k] / self.diagonal[k], |sum, (r, l)| sum - l * x[*r as usize]);
        }
        self.place.iter().zip(b).for_each(|(at, b)| *b = x[*at as usize]);
        Ok(())
    }
}
