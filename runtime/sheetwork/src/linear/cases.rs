//! Test matrices, and the dense Cholesky factorisation as reference.

use crate::linear::Pattern;

/// Deterministic pseudo-random numbers in [-1, 1) (xorshift64*, Vigna 2016).
pub struct PseudoRandom(u64);

impl PseudoRandom {
    /// One sequence per seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// The next number.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A pattern and the places (u, v) of its nodes.
#[derive(Clone, Debug)]
pub struct FactorCase {
    pub name: String,
    pub pattern: Pattern,
    pub places: Vec<[f64; 2]>,
}

impl FactorCase {
    /// A case of nodes at `places` with couplings `pairs`.
    pub fn new(name: impl Into<String>, places: Vec<[f64; 2]>, pairs: impl IntoIterator<Item = (u32, u32)>) -> Self {
        Self { name: name.into(), pattern: Pattern::new(places.len(), pairs), places }
    }

    /// Values of a positive definite matrix: |G x_i + G' x_j|² for each pair, with random G, G' and
    /// a random stiffness over four decades, and `mass` on the diagonal.
    pub fn values(&self, seed: u64, mass: f64) -> Vec<f64> {
        let mut noise = PseudoRandom::new(seed);
        let mut values = vec![0.0; 9 * self.pattern.blocks()];
        for (slot, row, column) in self.pattern.iter() {
            let stiffness = 10f64.powf(2.0 + 2.0 * noise.next());
            let g: [[f64; 9]; 2] = [0, 1].map(|_| [0; 9].map(|_| noise.next()));
            let mut add = |slot: usize, a: &[f64; 9], b: &[f64; 9]| {
                for (i, j, k) in triples() {
                    values[9 * slot + 3 * i + j] += stiffness * a[3 * k + i] * b[3 * k + j];
                }
            };
            if row == column {
                for i in 0..3 {
                    values[9 * slot + 4 * i] += mass;
                }
            } else {
                add(slot, &g[0], &g[1]);
                add(self.pattern.starts[row as usize] as usize, &g[0], &g[0]);
                add(self.pattern.starts[column as usize] as usize, &g[1], &g[1]);
            }
        }
        values
    }

    /// A x.
    pub fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (slot, row, column) in self.pattern.iter() {
            let (r, c) = (3 * row as usize, 3 * column as usize);
            for (i, j) in pairs() {
                let a = values[9 * slot + 3 * i + j];
                y[r + i] += a * x[c + j];
                if row != column {
                    y[c + j] += a * x[r + i];
                }
            }
        }
        y
    }

    /// A as a dense matrix, row by row.
    pub fn dense(&self, values: &[f64]) -> Vec<f64> {
        let n = 3 * self.pattern.size();
        let mut a = vec![0.0; n * n];
        for (slot, row, column) in self.pattern.iter() {
            let (r, c) = (3 * row as usize, 3 * column as usize);
            for (i, j) in pairs() {
                a[(r + i) * n + c + j] = values[9 * slot + 3 * i + j];
                a[(c + j) * n + r + i] = values[9 * slot + 3 * i + j];
            }
        }
        a
    }

    /// A random right-hand side.
    pub fn load(&self, seed: u64) -> Vec<f64> {
        let mut noise = PseudoRandom::new(seed);
        (0..3 * self.pattern.size()).map(|_| noise.next()).collect()
    }
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..3).flat_map(|i| (0..3).map(move |j| (i, j)))
}

fn triples() -> impl Iterator<Item = (usize, usize, usize)> {
    pairs().flat_map(|(i, j)| (0..3).map(move |k| (i, j, k)))
}

/// Solves A x = b with a dense Cholesky-Banachiewicz factorisation; `None` if a pivot is not
/// positive.
pub fn dense_solve(mut a: Vec<f64>, b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let rest = a[i * n + j] - dot;
            a[i * n + j] = match i == j {
                true if rest > 0.0 => rest.sqrt(),
                true => return None,
                false => rest / a[j * n + j],
            };
        }
    }
    let mut x = b.to_vec();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| a[i * n + k] * x[k]).sum();
        x[i] = (x[i] - dot) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| a[k * n + i] * x[k]).sum();
        x[i] = (x[i] - dot) / a[i * n + i];
    }
    Some(x)
}

/// A grid of `nx` x `nz` nodes in `layers` coincident layers; each node is coupled with the nodes
/// at the offsets `reach`.
fn grid(name: String, [nx, nz]: [usize; 2], layers: usize, cell: [f64; 2], reach: &[(i32, i32)]) -> FactorCase {
    let index = |i: i32, j: i32, layer: usize| {
        let inside = (0..nx as i32).contains(&i) && (0..nz as i32).contains(&j);
        inside.then(|| ((i as usize * nz + j as usize) * layers + layer) as u32)
    };
    let mut places = Vec::new();
    let mut joined = Vec::new();
    for (i, j) in (0..nx as i32).flat_map(|i| (0..nz as i32).map(move |j| (i, j))) {
        for layer in 0..layers {
            places.push([f64::from(i) * cell[0], f64::from(j) * cell[1]]);
            let partners = reach.iter().flat_map(|&(di, dj)| (0..layers).map(move |other| (di, dj, other)));
            let partners = partners.filter_map(|(di, dj, other)| index(i + di, j + dj, other));
            joined.extend(partners.zip(std::iter::repeat(index(i, j, layer).unwrap_or(0))));
        }
    }
    FactorCase::new(name, places, joined)
}

/// Stencil of the staggered shell: a diamond of 13 points.
pub fn shell(nx: usize, nz: usize) -> FactorCase {
    let diamond = [(0, 1), (1, 0), (1, 1), (1, -1), (2, 0), (0, 2)];
    grid(format!("shell {nx}x{nz}"), [nx, nz], 1, [0.0125, 0.0125], &diamond)
}

/// A lattice of two layers; every node is coupled with all its neighbours.
pub fn two_layers(nx: usize, nz: usize) -> FactorCase {
    grid(format!("two layers {nx}x{nz}"), [nx, nz], 2, [0.01, 0.025], &[(0, 0), (0, 1), (1, 0), (1, 1), (1, -1)])
}

/// A square of triangles with random corners and a round hole; nodes of neighbouring triangles are
/// coupled too.
pub fn triangles(n: usize, seed: u64) -> FactorCase {
    let mut noise = PseudoRandom::new(seed);
    let step = 1.0 / (n - 1) as f64;
    let mut index = vec![None; n * n];
    let mut places = Vec::new();
    for (k, slot) in index.iter_mut().enumerate() {
        let place = [k / n, k % n].map(|i| (i as f64 + 0.3 * noise.next()) * step);
        if (place[0] - 0.5).hypot(place[1] - 0.5) > 0.15 {
            *slot = Some(places.len() as u32);
            places.push(place);
        }
    }
    let mut stars: Vec<[Option<u32>; 6]> = Vec::new();
    for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
        let at = |i: usize, j: usize| if i < n && j < n { index[i * n + j] } else { None };
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        stars.push([a, b, c, d, at(i + 2, j), at(i, j + 2)]);
    }
    let pairs: Vec<_> = stars
        .iter()
        .flat_map(|s| s.iter().flatten().flat_map(move |&a| s.iter().flatten().map(move |&b| (a, b))))
        .collect();
    FactorCase::new(format!("triangles {n}"), places, pairs)
}

/// Several overlapping pieces, isolated nodes, and many coincident nodes.
pub fn scattered() -> FactorCase {
    let mut places = Vec::new();
    let mut joined = Vec::new();
    for (copy, piece) in [shell(9, 9), shell(5, 12), triangles(8, 3)].into_iter().enumerate() {
        let first = places.len() as u32;
        joined.extend(piece.pattern.iter().map(|(_, r, c)| (first + r, first + c)));
        places.extend(piece.places.iter().map(|p| [p[0] + 1e-3 * copy as f64, p[1]]));
        places.push([0.0, 0.0]);
    }
    let first = places.len() as u32;
    for i in 0..60 {
        places.push([0.5, 0.5]);
        joined.extend((1..4).filter(|d| i + d < 60).map(|d| (first + i, first + i + d)));
    }
    places.push([f64::NAN, f64::INFINITY]);
    FactorCase::new("scattered", places, joined)
}

/// `n` nodes in a row, each coupled with the next.
pub fn chain(n: usize) -> FactorCase {
    let pairs = (1..n as u32).map(|i| (i - 1, i));
    FactorCase::new(format!("chain {n}"), (0..n).map(|i| [i as f64, 0.0]).collect(), pairs)
}

/// `n` nodes at random places, some pairs of them coupled.
pub fn random(n: usize, partners: f64, seed: u64) -> FactorCase {
    let mut noise = PseudoRandom::new(seed);
    let places = (0..n).map(|_| [noise.next(), noise.next()]).collect();
    let all = (0..n as u32).flat_map(|i| (0..i).map(move |j| (i, j)));
    let chosen: Vec<_> = all.filter(|_| noise.next() < 2.0 * partners / n as f64 - 1.0).collect();
    FactorCase::new(format!("random {n}"), places, chosen)
}

/// One case of each kind, small enough for a dense factor.
pub fn all() -> Vec<FactorCase> {
    let mut cases: Vec<FactorCase> = (0..4).map(chain).collect();
    cases.extend([chain(47), shell(11, 11), shell(4, 31), shell(17, 14), two_layers(7, 9), two_layers(11, 11)]);
    cases.extend([triangles(6, 1), triangles(13, 2), scattered(), random(60, 1.0, 5), random(80, 6.0, 6)]);
    cases
}
