//! Half solutions: y = L⁻¹ b, from which rows and products of the inverse come cheaply.
//!
//! With A = L Lᵀ, for right-hand sides b and c of few entries (a contact touches few masses)
//!
//!   bᵀ A⁻¹ c = (L⁻¹ b)·(L⁻¹ c),
//!
//! and L⁻¹ b is zero but for the masses above those of b in the tree of elimination: a small part of L is read, and
//! what two solutions have in common is the part of the tree above both. (J. R. Gilbert and T. Peierls, *Sparse partial
//! pivoting in time proportional to arithmetic operations*, SIAM J. Sci. Stat. Comput. 9 (1988) 862, on which entries.)

use multiversion::multiversion;

/// Right-hand sides with few entries.
#[derive(Clone, Debug, Default)]
pub struct Loads {
    ends: Vec<usize>,
    entries: Vec<(u32, [f64; 3])>,
}

impl Loads {
    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.entries.clear();
    }

    /// Adds a right-hand side: (block row, its x, y, z) for the rows that are not zero; a row given twice counts twice.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (u32, [f64; 3])>) {
        self.entries.extend(entries);
        self.ends.push(self.entries.len());
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The right-hand sides in turn.
    pub fn iter(&self) -> impl Iterator<Item = &[(u32, [f64; 3])]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.entries[start..end])
    }
}

/// Unknowns of one solution that follow one another in the elimination.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// The first of them.
    first: usize,
    /// Where their values are.
    start: usize,
    end: usize,
}

/// Half solutions of the same factor.
#[derive(Clone, Debug, Default)]
pub struct HalfSolutions {
    ends: Vec<usize>,
    segments: Vec<Segment>,
    values: Vec<f64>,
}

impl HalfSolutions {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// bᵀ A⁻¹ c for the right-hand sides `b` and `c`, both below [`HalfSolutions::len`].
    pub fn product(&self, b: usize, c: usize) -> f64 {
        let [mut left, mut right] = [b, c].map(|i| self.segments_of(i).iter().peekable());
        let mut sum = 0.0;
        while let (Some(l), Some(r)) = (left.peek(), right.peek()) {
            if l.first < r.first {
                left.next();
            } else if r.first < l.first {
                right.next();
            } else {
                let [l_values, r_values] = [l, r].map(|s| &self.values[s.start..s.end]);
                sum += dot(l_values, r_values);
                left.next();
                right.next();
            }
        }
        sum
    }

    /// The nine products of solutions 3b, 3b+1, 3b+2 with 3c, 3c+1, 3c+2. The three of each must have loads at the same
    /// block rows.
    pub fn block(&self, b: usize, c: usize) -> [[f64; 3]; 3] {
        let [left, right] = [b, c].map(|i| [0, 1, 2].map(|k| self.segments_of(3 * i + k)));
        let mut sums = [[0.0; 3]; 3];
        let (mut l, mut r) = (0, 0);
        while let (Some(here), Some(there)) = (left[0].get(l), right[0].get(r)) {
            if here.first < there.first {
                l += 1;
            } else if there.first < here.first {
                r += 1;
            } else {
                let values = |side: [&[Segment]; 3], at: usize| side.map(|s| &self.values[s[at].start..s[at].end]);
                add_products(values(left, l), values(right, r), &mut sums);
                l += 1;
                r += 1;
            }
        }
        sums
    }

    /// How many numbers the solutions have.
    pub fn numbers(&self) -> usize {
        self.values.len()
    }

    fn segments_of(&self, i: usize) -> &[Segment] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.segments[start..self.ends[i]]
    }

    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.segments.clear();
        self.values.clear();
    }

    /// Adds a segment to the solution that is being made; segments ascend.
    pub(crate) fn add_segment(&mut self, first: usize, values: &[f64]) {
        let start = self.values.len();
        self.values.extend_from_slice(values);
        self.segments.push(Segment { first, start, end: self.values.len() });
    }

    /// Closes the solution that is being made.
    pub(crate) fn close(&mut self) {
        self.ends.push(self.segments.len());
    }
}

/// Adds a_i·b_j, by eight running sums each.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn add_products(a: [&[f64]; 3], b: [&[f64]; 3], to: &mut [[f64; 3]; 3]) {
    let length = a[0].len();
    let [a, b] = [a, b].map(|side| side.map(|s| s[..length].as_chunks::<8>()));
    let mut sums = [[[0.0; 8]; 3]; 3];
    for k in 0..a[0].0.len() {
        for i in 0..3 {
            for j in 0..3 {
                for lane in 0..8 {
                    sums[i][j][lane] += a[i].0[k][lane] * b[j].0[k][lane];
                }
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            let rest: f64 = a[i].1.iter().zip(b[j].1).map(|(a, b)| a * b).sum();
            to[i][j] += sums[i][j].iter().sum::<f64>() + rest;
        }
    }
}

/// a·b by eight running sums, so that the order of summation is fixed and the sums do not wait for one another.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
