//! Lowest frequencies of a linear plate: skyline Cholesky factorisation and subspace iteration with
//! Rayleigh-Ritz quotients.

use crate::elements::bending::condensed;
use crate::elements::curvature::CurvatureGroup;
use crate::elements::triangle_bending::symmetric::eigen;

/// Vectors of the subspace iteration: more than any test needs, for fast convergence of the lowest
/// ones.
const BLOCK: usize = 10;

/// A symmetric matrix by rows, each from its first entry to the diagonal.
pub struct Skyline {
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

impl Skyline {
    fn new(pattern: &[Vec<usize>], n: usize) -> Self {
        let mut first: Vec<usize> = (0..n).collect();
        for stencil in pattern {
            let low = stencil.iter().copied().min().unwrap_or(0);
            stencil.iter().for_each(|i| first[*i] = first[*i].min(low));
        }
        let rows = (0..n).map(|i| vec![0.0; i - first[i] + 1]).collect();
        Self { first, rows }
    }

    fn add(&mut self, i: usize, j: usize, value: f64) {
        if j <= i {
            self.rows[i][j - self.first[i]] += value;
        }
    }

    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (i, row) in self.rows.iter().enumerate() {
            for (j, a) in (self.first[i]..).zip(row) {
                y[i] += a * x[j];
                if j != i {
                    y[j] += a * x[i];
                }
            }
        }
        y
    }

    fn factor(mut self) -> Self {
        for i in 0..self.rows.len() {
            for j in self.first[i]..=i {
                let low = self.first[i].max(self.first[j]);
                let (mut sum, fi, fj) = (self.rows[i][j - self.first[i]], self.first[i], self.first[j]);
                for k in low..j {
                    sum -= self.rows[i][k - fi] * self.rows[j][k - fj];
                }
                self.rows[i][j - fi] = if i == j { sum.sqrt() } else { sum / self.rows[j][j - fj] };
            }
        }
        self
    }

    fn solve(&self, b: &mut [f64]) {
        for i in 0..b.len() {
            for j in self.first[i]..i {
                b[i] -= self.rows[i][j - self.first[i]] * b[j];
            }
            b[i] /= self.rows[i][i - self.first[i]];
        }
        for i in (0..b.len()).rev() {
            b[i] /= self.rows[i][i - self.first[i]];
            for j in self.first[i]..i {
                b[j] -= self.rows[i][j - self.first[i]] * b[i];
            }
        }
    }
}

/// A plate: stiffness and mass of its free deflections.
pub struct PlateModel {
    pub number: Vec<Option<usize>>,
    pub mass: Vec<f64>,
    pattern: Vec<Vec<usize>>,
    blocks: Vec<Vec<f64>>,
}

impl PlateModel {
    /// From curvatures, bending stiffness and nodal areas (unit mass per area); `held` deflections
    /// are zero.
    pub fn new(groups: &[CurvatureGroup], d: &[[f64; 3]; 3], areas: &[f64], held: impl Fn(usize) -> bool) -> Self {
        let mut mass = Vec::new();
        let number: Vec<Option<usize>> = areas
            .iter()
            .enumerate()
            .map(|(i, a)| {
                (!held(i)).then(|| {
                    mass.push(*a);
                    mass.len() - 1
                })
            })
            .collect();
        let (mut pattern, mut blocks) = (Vec::new(), Vec::new());
        for group in groups {
            let c = condensed(*d, &group.relaxed);
            let mut rows: std::collections::BTreeMap<usize, [f64; 3]> = Default::default();
            for (k, row) in group.rows.iter().enumerate() {
                for (v, w) in row {
                    if let Some(i) = number[*v as usize] {
                        rows.entry(i).or_default()[k] += w;
                    }
                }
            }
            let all: Vec<[f64; 3]> = rows.values().copied().collect();
            let energy = |a: &[f64; 3], b: &[f64; 3]| -> f64 {
                (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| group.area * c[i][j] * a[i] * b[j]).sum()
            };
            blocks.push(all.iter().flat_map(|a| all.iter().map(move |b| energy(a, b))).collect());
            pattern.push(rows.keys().copied().collect());
        }
        Self { number, mass, pattern, blocks }
    }

    fn stiffness(&self, shift: f64) -> Skyline {
        let mut k = Skyline::new(&self.pattern, self.mass.len());
        for (stencil, block) in self.pattern.iter().zip(&self.blocks) {
            let pairs = stencil.iter().flat_map(|i| stencil.iter().map(move |j| (*i, *j)));
            pairs.zip(block).for_each(|((i, j), value)| k.add(i, j, *value));
        }
        self.mass.iter().enumerate().for_each(|(i, m)| k.add(i, i, shift * m));
        k
    }

    /// Deflection of every node under unit pressure.
    pub fn deflection(&self) -> Vec<f64> {
        let mut w = self.mass.clone();
        self.stiffness(0.0).factor().solve(&mut w);
        self.number.iter().map(|i| i.map_or(0.0, |i| w[i])).collect()
    }

    /// The lowest ω², rigid motions first; `shift` (ω²) is of the order of the lowest wanted value.
    pub fn squares(&self, shift: f64) -> [f64; BLOCK] {
        let n = self.mass.len();
        let stiffness = self.stiffness(0.0);
        let factor = self.stiffness(shift).factor();
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let mut x: Vec<Vec<f64>> = (0..BLOCK).map(|_| (0..n).map(|_| random()).collect()).collect();
        let mut last = [0.0; BLOCK];
        for _ in 0..60 {
            for v in &mut x {
                v.iter_mut().zip(&self.mass).for_each(|(v, m)| *v *= m);
                factor.solve(v);
            }
            self.orthonormalise(&mut x);
            let kx: Vec<Vec<f64>> = x.iter().map(|v| stiffness.times(v)).collect();
            let small: [[f64; BLOCK]; BLOCK] = std::array::from_fn(|i| std::array::from_fn(|j| inner(&x[i], &kx[j])));
            let (values, vectors) = eigen(&small);
            let mut order: Vec<usize> = (0..BLOCK).collect();
            order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
            let mixed = |k: usize| (0..n).map(|r| (0..BLOCK).map(|i| vectors[i][k] * x[i][r]).sum()).collect();
            x = order.iter().map(|k| mixed(*k)).collect();
            let now: [f64; BLOCK] = std::array::from_fn(|i| values[order[i]]);
            let still = now.iter().zip(last).take(BLOCK - 3).all(|(a, b)| (a - b).abs() < 1e-7 * (a.abs() + shift));
            last = now;
            if still {
                break;
            }
        }
        last
    }

    fn orthonormalise(&self, x: &mut [Vec<f64>]) {
        let weighted =
            |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).zip(&self.mass).map(|((a, b), m)| a * b * m).sum() };
        for i in 0..x.len() {
            for _ in 0..2 {
                let (done, rest) = x.split_at_mut(i);
                for d in done.iter() {
                    let share = weighted(d, &rest[0]);
                    rest[0].iter_mut().zip(d).for_each(|(r, d)| *r -= share * d);
                }
            }
            let size = weighted(&x[i], &x[i]).sqrt();
            x[i].iter_mut().for_each(|v| *v /= size);
        }
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
