//! Newton step on the forces of all contacts.
//!
//! With fixed contact states (open: p = 0; slip: |p_t| given; stick: u = 0), the problem u = W p +
//! b is linear in the step Δp:
//!
//!   (Bᵀ W B + D) Δ = -Bᵀ u,  Δp = B Δ.
//!
//! B holds the directions in which each force may change, D the compliance from the rotation of
//! friction against the slip. The matrix is symmetric. It is factorised within its envelope (George
//! and Liu, "Computer solution of large sparse positive definite systems", 1981, chapter 4), in
//! reverse Cuthill-McKee order of the contacts, which makes the matrix of a pile of sheets banded.

use multiversion::multiversion;

use glam::{DMat3, DVec3};

/// Position of a contact without unknowns.
const NONE: u32 = u32::MAX;
/// Number of rows that are eliminated together.
const ROWS_PER_GROUP: usize = 4;

/// Directions in which the force of a contact may change in a Newton step.
#[derive(Clone, Copy)]
pub(crate) struct FreeDirections {
    /// Unit directions in the contact frame; the first `count` columns are used.
    pub basis: DMat3,
    /// Number of directions, 0 to 3.
    pub count: u8,
    /// Compliance along each direction in addition to W, m/N.
    pub compliance: [f64; 3],
}

impl FreeDirections {
    /// No direction: an open contact.
    pub const NONE: Self = Self { basis: DMat3::IDENTITY, count: 0, compliance: [0.0; 3] };
}

/// Matrix, factor and solution of a Newton step.
#[derive(Default)]
pub(crate) struct ForceNewton {
    /// Contacts in order of elimination; for each contact, its first unknown and its number of
    /// unknowns.
    order: Vec<u32>,
    place: Vec<u32>,
    size: Vec<u8>,
    /// For each row of the factor, its first column and its offset in `values`.
    first: Vec<u32>,
    offset: Vec<usize>,
    values: Vec<f64>,
    /// Right-hand side, then solution.
    x: Vec<f64>,
}

impl ForceNewton {
    /// Solve for the step of the forces along `ways`, given the off-diagonal and diagonal blocks of
    /// W and the residual u. Returns false if rounding prevents a factorisation.
    pub fn solve(
        &mut self,
        columns: &[Vec<(u32, DMat3)>],
        diagonal: &[DMat3],
        ways: &[FreeDirections],
        u: &[DVec3],
    ) -> bool {
        let done = self.factorize(columns, diagonal, ways);
        if done {
            self.solve_with(ways, u);
        }
        done
    }

    /// Factorise the matrix for `ways`. Returns false if rounding prevents it.
    pub fn factorize(&mut self, columns: &[Vec<(u32, DMat3)>], diagonal: &[DMat3], ways: &[FreeDirections]) -> bool {
        self.size.clear();
        self.size.extend(ways.iter().map(|w| w.count));
        self.order_contacts(columns);
        self.compute_envelope(columns);
        self.assemble(columns, diagonal, ways);
        self.eliminate()
    }

    /// Solve with the last factor, which must be for the same `ways`.
    pub fn solve_with(&mut self, ways: &[FreeDirections], u: &[DVec3]) {
        self.x.clear();
        for i in &self.order {
            let (ways, u) = (&ways[*i as usize], u[*i as usize]);
            self.x.extend((0..ways.count as usize).map(|k| -ways.basis.col(k).dot(u)));
        }
        self.substitute();
    }

    /// Step of contact `i`, N.
    pub fn step(&self, i: usize, ways: &FreeDirections) -> DVec3 {
        let at = self.place[i] as usize;
        (0..ways.count as usize).map(|k| ways.basis.col(k) * self.x[at + k]).sum()
    }

    /// Order the contacts that have unknowns.
    fn order_contacts(&mut self, columns: &[Vec<(u32, DMat3)>]) {
        let count = self.size.len();
        self.order.clear();
        self.place.clear();
        self.place.resize(count, NONE);
        for start in 0..count {
            if self.size[start] == 0 || self.place[start] != NONE {
                continue;
            }
            // The last contact of a breadth-first search is a good start of the ordering.
            let from = self.order.len();
            self.append_breadth_first(columns, start);
            let end = self.order.last().map_or(start, |i| *i as usize);
            for i in self.order.drain(from..) {
                self.place[i as usize] = NONE;
            }
            self.append_breadth_first(columns, end);
        }
        self.order.reverse();
        let mut next = 0;
        for i in &self.order {
            self.place[*i as usize] = next;
            next += u32::from(self.size[*i as usize]);
        }
    }

    /// Append all contacts connected to `start`, in breadth-first order.
    fn append_breadth_first(&mut self, columns: &[Vec<(u32, DMat3)>], start: usize) {
        let mut head = self.order.len();
        self.order.push(start as u32);
        self.place[start] = 0;
        while let Some(i) = self.order.get(head).copied() {
            head += 1;
            for (j, _) in &columns[i as usize] {
                let j = *j as usize;
                if self.size[j] > 0 && self.place[j] == NONE {
                    self.place[j] = 0;
                    self.order.push(j as u32);
                }
            }
        }
    }

    /// Compute the envelope. Rows that are eliminated together start at the same column.
    fn compute_envelope(&mut self, columns: &[Vec<(u32, DMat3)>]) {
        self.first.clear();
        self.offset.clear();
        for i in self.order.iter().map(|i| *i as usize) {
            let others = columns[i].iter().map(|(j, _)| *j as usize).filter(|j| self.size[*j] > 0);
            let first = others.map(|j| self.place[j]).fold(self.place[i], u32::min);
            self.first.extend((0..self.size[i]).map(|_| first));
        }
        let mut end = 0;
        for (k, rows) in self.first.chunks_mut(ROWS_PER_GROUP).enumerate() {
            let first = rows.iter().fold(u32::MAX, |a, b| a.min(*b));
            rows.fill(first);
            for row in ROWS_PER_GROUP * k..ROWS_PER_GROUP * k + rows.len() {
                self.offset.push(end);
                end += row + 1 - first as usize;
            }
        }
        self.offset.push(end);
        self.values.clear();
        self.values.resize(end, 0.0);
    }

    /// Assemble the matrix within its envelope.
    fn assemble(&mut self, columns: &[Vec<(u32, DMat3)>], diagonal: &[DMat3], ways: &[FreeDirections]) {
        for i in self.order.iter().map(|i| *i as usize) {
            let (own, start) = (&ways[i], self.place[i] as usize);
            let rows = start..start + own.count as usize;
            for (r, row) in rows.clone().enumerate() {
                let at = self.offset[row] + start - self.first[row] as usize;
                let column = diagonal[i] * own.basis.col(r);
                for c in 0..=r {
                    self.values[at + c] = own.basis.col(c).dot(column);
                }
                self.values[at + r] += own.compliance[r];
            }
            for (j, block) in &columns[i] {
                let j = *j as usize;
                if self.size[j] == 0 || self.place[j] > self.place[i] {
                    continue;
                }
                for (r, row) in rows.clone().enumerate() {
                    let at = self.offset[row] + (self.place[j] - self.first[row]) as usize;
                    // The list holds ∂u_j/∂p_i, the transpose of the block that belongs here.
                    let column = *block * own.basis.col(r);
                    for c in 0..self.size[j] as usize {
                        self.values[at + c] += ways[j].basis.col(c).dot(column);
                    }
                }
            }
        }
    }

    fn eliminate(&mut self) -> bool {
        eliminate(&self.first, &self.offset, &mut self.values)
    }

    /// Solve with the factor by forward and backward substitution, in place.
    fn substitute(&mut self) {
        let count = self.first.len();
        for i in 0..count {
            let row = &self.values[self.offset[i]..self.offset[i + 1]];
            let (first, last) = (self.first[i] as usize, row.len() - 1);
            self.x[i] = (self.x[i] - dot(&row[..last], &self.x[first..i])) / row[last];
        }
        for i in (0..count).rev() {
            let row = &self.values[self.offset[i]..self.offset[i + 1]];
            let (first, last) = (self.first[i] as usize, row.len() - 1);
            let value = self.x[i] / row[last];
            self.x[i] = value;
            for (x, l) in self.x[first..i].iter_mut().zip(row) {
                *x -= l * value;
            }
        }
    }
}

/// Factorise in place, a few rows at a time because all of them read the same earlier rows. Returns
/// false if rounding prevents it.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn eliminate(first: &[u32], offset: &[usize], values: &mut [f64]) -> bool {
    for start in (0..first.len()).step_by(ROWS_PER_GROUP) {
        let end = (start + ROWS_PER_GROUP).min(first.len());
        let begin = first[start] as usize;
        let (before, rest) = values.split_at_mut(offset[start]);
        for j in begin..start {
            let other = &before[offset[j]..offset[j + 1]];
            let from = begin.max(first[j] as usize);
            let known = &other[from - first[j] as usize..other.len() - 1];
            let pivot = other[other.len() - 1];
            let at = [0, 1, 2, 3].map(|k| offset[(start + k).min(end - 1)] - offset[start]);
            let sums = dot_four(at.map(|at| &rest[at + from - begin..at + j - begin]), known);
            for (at, sum) in at.into_iter().zip(sums).take(end - start) {
                rest[at + j - begin] = (rest[at + j - begin] - sum) / pivot;
            }
        }
        for i in start..end {
            let (above, row) = rest.split_at_mut(offset[i] - offset[start]);
            let row = &mut row[..=i - begin];
            let mut pivot = row[i - begin];
            let least = pivot * 1e-13;
            for j in start..i {
                let other = &above[offset[j] - offset[start]..offset[j + 1] - offset[start]];
                let known: f64 = row[..j - begin].iter().zip(other).map(|(a, b)| a * b).sum();
                row[j - begin] = (row[j - begin] - known) / other[j - begin];
            }
            pivot -= dot_four([&row[..i - begin]; 4], &row[..i - begin])[0];
            if pivot.is_nan() || pivot <= least {
                return false;
            }
            row[i - begin] = pivot.sqrt();
        }
    }
    true
}

/// Dot products of four rows with `other`, each in eight independent partial sums.
#[inline(always)]
fn dot_four(rows: [&[f64]; ROWS_PER_GROUP], other: &[f64]) -> [f64; ROWS_PER_GROUP] {
    let (whole, part) = other.as_chunks::<8>();
    let rows = rows.map(|row| row[..other.len()].as_chunks::<8>());
    let mut sums = [[0.0; 8]; ROWS_PER_GROUP];
    for (k, b) in whole.iter().enumerate() {
        for (sum, (row, _)) in sums.iter_mut().zip(&rows) {
            for lane in 0..8 {
                sum[lane] += row[k][lane] * b[lane];
            }
        }
    }
    let mut total = [0.0; ROWS_PER_GROUP];
    for ((total, sum), (_, row)) in total.iter_mut().zip(&sums).zip(&rows) {
        let rest: f64 = row.iter().zip(part).map(|(a, b)| a * b).sum();
        *total = sum.iter().sum::<f64>() + rest;
    }
    total
}

/// Dot product in eight independent partial sums.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (pa, pb) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = pa.remainder().iter().zip(pb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in pa.zip(pb) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All three directions of a contact.
    const STICK: FreeDirections = FreeDirections { count: 3, ..FreeDirections::NONE };

    /// W of two contacts: a on both diagonals and c between them, in every direction.
    fn coupled(a: f64, c: f64) -> (Vec<Vec<(u32, DMat3)>>, [DMat3; 2]) {
        let between = DMat3::IDENTITY * c;
        (vec![vec![(1, between)], vec![(0, between)]], [DMat3::IDENTITY * a; 2])
    }

    #[test]
    fn step_of_two_coupled_contacts_is_that_of_cramers_rule() {
        let (a, c) = (3.0, 1.2);
        let (columns, diagonal) = coupled(a, c);
        let u = [DVec3::new(-1.0, 0.5, 0.2), DVec3::new(-2.0, 0.0, -0.4)];
        let mut newton = ForceNewton::default();
        assert!(newton.solve(&columns, &diagonal, &[STICK; 2], &u));
        // [a c; c a] Δ = -u.
        let determinant = a * a - c * c;
        let expected = [(u[1] * c - u[0] * a) / determinant, (u[0] * c - u[1] * a) / determinant];
        for (i, expected) in expected.into_iter().enumerate() {
            assert!(newton.step(i, &STICK).distance(expected) < 1e-15, "{i}: {}", newton.step(i, &STICK));
        }
    }

    #[test]
    fn open_contact_keeps_its_force_and_does_not_couple() {
        let (columns, diagonal) = coupled(3.0, 1.2);
        let ways = [FreeDirections::NONE, STICK];
        let u = [DVec3::ONE, DVec3::new(-2.0, 0.0, -0.4)];
        let mut newton = ForceNewton::default();
        assert!(newton.solve(&columns, &diagonal, &ways, &u));
        assert_eq!(newton.step(0, &ways[0]), DVec3::ZERO);
        assert!(newton.step(1, &STICK).distance(u[1] / -3.0) < 1e-15);
    }

    #[test]
    fn slip_adds_its_compliance_along_its_directions() {
        // Normal and one tangent are free; the tangent is more compliant by D.
        let ways = FreeDirections { count: 2, compliance: [0.0, 0.5, 0.0], ..FreeDirections::NONE };
        let u = DVec3::new(-1.0, 0.7, 9.0);
        let mut newton = ForceNewton::default();
        assert!(newton.solve(&[vec![]], &[DMat3::IDENTITY * 2.0], &[ways], &[u]));
        assert!(newton.step(0, &ways).distance(DVec3::new(1.0 / 2.0, -0.7 / 2.5, 0.0)) < 1e-15);
    }

    #[test]
    fn redundant_contacts_have_no_factor() {
        let (columns, diagonal) = coupled(1.0, 1.0);
        assert!(!ForceNewton::default().solve(&columns, &diagonal, &[STICK; 2], &[DVec3::NEG_X; 2]));
    }
}
