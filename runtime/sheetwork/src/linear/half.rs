//! Half solutions y = L⁻¹ b, from which entries and products of the inverse follow at low cost.
//!
//! With A = L Lᵀ, for right-hand sides b and c with few entries (a contact involves few nodes)
//!
//!   bᵀ A⁻¹ c = (L⁻¹ b)·(L⁻¹ c).
//!
//! L⁻¹ b is non-zero only at the nodes of b and their ancestors in the elimination tree: the
//! computation reads a small part of L, and the product of two solutions needs their common
//! ancestors only. (J. R. Gilbert and T. Peierls, *Sparse partial pivoting in time proportional to
//! arithmetic operations*, SIAM J. Sci. Stat. Comput. 9 (1988) 862.)

use multiversion::multiversion;

/// Right-hand sides with few entries.
#[derive(Clone, Debug, Default)]
pub struct SparseLoads {
    ends: Vec<usize>,
    entries: Vec<(u32, [f64; 3])>,
}

impl SparseLoads {
    /// Removes all right-hand sides; the capacity stays.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.entries.clear();
    }

    /// Appends a right-hand side: (block row, its x, y, z) for the non-zero rows; entries of a
    /// repeated row add up.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (u32, [f64; 3])>) {
        self.entries.extend(entries);
        self.ends.push(self.entries.len());
    }

    /// Number of right-hand sides.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no right-hand sides.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The right-hand sides in order.
    pub fn iter(&self) -> impl Iterator<Item = &[(u32, [f64; 3])]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.entries[start..end])
    }
}

/// Consecutive unknowns of one solution in the order of elimination.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Index of the first unknown.
    first: usize,
    /// Range of their values.
    start: usize,
    end: usize,
}

impl Segment {
    #[inline(always)]
    fn range(&self) -> std::ops::Range<usize> {
        self.start..self.end
    }
}

/// Half solutions with one factor.
#[derive(Clone, Debug, Default)]
pub struct HalfSolutions {
    ends: Vec<usize>,
    segments: Vec<Segment>,
    values: Vec<f64>,
}

impl HalfSolutions {
    /// Number of solutions.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are no solutions.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// bᵀ A⁻¹ c for the right-hand sides with indices `b` and `c`, both below
    /// [`HalfSolutions::len`].
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

    /// The nine products of solutions 3b, 3b+1, 3b+2 with 3c, 3c+1, 3c+2. Each triple must have its
    /// loads at equal block rows.
    pub fn block(&self, b: usize, c: usize) -> [[f64; 3]; 3] {
        let three = |i: usize| [self.segments_of(3 * i), self.segments_of(3 * i + 1), self.segments_of(3 * i + 2)];
        let mut sums = [[0.0; 3]; 3];
        add_block(&self.values, three(b), three(c), &mut sums);
        sums
    }

    /// Number of stored values of all solutions.
    pub fn numbers(&self) -> usize {
        self.values.len()
    }

    fn segments_of(&self, i: usize) -> &[Segment] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.segments[start..self.ends[i]]
    }

    /// Removes all solutions; the capacity stays.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.segments.clear();
        self.values.clear();
    }

    /// Appends a segment to the current solution; segments ascend.
    pub(crate) fn add_segment(&mut self, first: usize, values: &[f64]) {
        let start = self.values.len();
        self.values.extend_from_slice(values);
        self.segments.push(Segment { first, start, end: self.values.len() });
    }

    /// Completes the current solution.
    pub(crate) fn close(&mut self) {
        self.ends.push(self.segments.len());
    }
}

/// Adds the products of three solutions with three others; the three of each side have equal
/// segments.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn add_block(values: &[f64], left: [&[Segment]; 3], right: [&[Segment]; 3], to: &mut [[f64; 3]; 3]) {
    let (mut l, mut r) = (0, 0);
    while let (Some(here), Some(there)) = (left[0].get(l), right[0].get(r)) {
        if here.first < there.first {
            l += 1;
        } else if there.first < here.first {
            r += 1;
        } else {
            let a = [&values[left[0][l].range()], &values[left[1][l].range()], &values[left[2][l].range()]];
            let b = [&values[right[0][r].range()], &values[right[1][r].range()], &values[right[2][r].range()]];
            add_products(a, b, to);
            l += 1;
            r += 1;
        }
    }
}

/// Adds a_i·b_j with eight partial sums each: four at a time for all nine products, which fit into
/// registers.
#[inline(always)]
fn add_products(a: [&[f64]; 3], b: [&[f64]; 3], to: &mut [[f64; 3]; 3]) {
    let length = a[0].len();
    let whole = length / 8 * 8;
    let (low, high) = (four_sums::<0>(a, b, whole), four_sums::<4>(a, b, whole));
    for i in 0..3 {
        for j in 0..3 {
            let mut rest = 0.0;
            for k in whole..length {
                rest += a[i][k] * b[j][k];
            }
            let sum = low[i][j].iter().sum::<f64>();
            to[i][j] += high[i][j].iter().fold(sum, |sum, s| sum + s) + rest;
        }
    }
}

/// The partial sums `FROM` to `FROM` + 3 of [`add_products`] over the first `whole` numbers.
#[inline(always)]
fn four_sums<const FROM: usize>(a: [&[f64]; 3], b: [&[f64]; 3], whole: usize) -> [[[f64; 4]; 3]; 3] {
    let [a0, a1, a2] = [a[0][..whole].as_chunks::<8>().0, a[1][..whole].as_chunks().0, a[2][..whole].as_chunks().0];
    let [b0, b1, b2] = [b[0][..whole].as_chunks::<8>().0, b[1][..whole].as_chunks().0, b[2][..whole].as_chunks().0];
    let [mut s00, mut s01, mut s02, mut s10, mut s11, mut s12, mut s20, mut s21, mut s22] = [[0.0; 4]; 9];
    // Written out: the compiler does not vectorise loops over small arrays.
    let add = |sum: &mut [f64; 4], a: &[f64; 8], b: &[f64; 8]| {
        for lane in 0..4 {
            sum[lane] += a[FROM + lane] * b[FROM + lane];
        }
    };
    for (((((a0, a1), a2), b0), b1), b2) in a0.iter().zip(a1).zip(a2).zip(b0).zip(b1).zip(b2) {
        add(&mut s00, a0, b0);
        add(&mut s01, a0, b1);
        add(&mut s02, a0, b2);
        add(&mut s10, a1, b0);
        add(&mut s11, a1, b1);
        add(&mut s12, a1, b2);
        add(&mut s20, a2, b0);
        add(&mut s21, a2, b1);
        add(&mut s22, a2, b2);
    }
    [[s00, s01, s02], [s10, s11, s12], [s20, s21, s22]]
}

/// a·b with eight partial sums: a fixed order of summation without a dependency chain.
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
