//! Dense kernels of a front, on tiles that stay in registers.
//!
//! A chunk is `G` numbers: of L, one column of a panel of `G` rows; of the columns to factorise and
//! of S, `G` rows of one column. For panel p of columns, from the first to the last, and every
//! panel i of rows below (left-looking Cholesky factorisation in panels; G. W. Stewart, *Matrix
//! Algorithms* I (SIAM 1998), 3.2):
//!
//!   L_pp L_ppᵀ = A_pp - Σ_k<p L_pk L_pkᵀ,   L_ip = (A_ip - Σ_k<p L_ik L_pkᵀ) L_pp⁻ᵀ.
//!
//! One kernel, [`product`], computes the sums; subtraction and division follow while the tile is in
//! registers. The diagonal of L stores reciprocals, because only they are used.

use std::ops::Range;

use crate::linear::multifrontal::lanes::Lanes;

/// Expands a statement for the constants 0 to `$g` - 1, `$g` at most 8, so that a tile stays in
/// registers.
macro_rules! unrolled {
    ($g:expr, $k:ident => $statement:expr) => {
        unrolled!($g, $k => $statement, 0, 1, 2, 3, 4, 5, 6, 7)
    };
    ($g:expr, $k:ident => $statement:expr, $($value:literal),*) => {
        $({
            const $k: usize = $value;
            if $k < $g {
                $statement;
            }
        })*
    };
}

/// Columns summed in one pass over S, so that a tile's rows of L stay in the first-level cache.
const DEPTH: usize = 192;

/// Σ_k rows_k columns_kᵀ of M panels of rows and one panel of columns: M by N vectors.
#[inline(always)]
fn product<L: Lanes<G>, const G: usize, const M: usize, const N: usize>(
    lanes: L,
    rows: [&[[f64; G]]; M],
    columns: &[[f64; G]],
) -> [[L::Vector; N]; M] {
    let depth = columns.len();
    let rows = rows.map(|r| &r[..depth]);
    let mut sum = [[lanes.zero(); N]; M];
    for k in 0..depth {
        let mut left = [lanes.zero(); M];
        for m in 0..M {
            left[m] = lanes.load(&rows[m][k]);
        }
        for q in 0..N {
            let right = lanes.splat(columns[k][q]);
            for m in 0..M {
                sum[m][q] = lanes.mul_add(left[m], right, sum[m][q]);
            }
        }
    }
    sum
}

/// Columns of half a panel of eight, for the last panel of pivots if that suffices.
const HALF: usize = 4;

/// A front to be factorised.
#[derive(Clone, Copy)]
pub(crate) struct DenseFront<'a, const G: usize> {
    /// Chunks of its columns, column after column.
    pub columns: &'a [[f64; G]],
    /// Chunks per column.
    pub stride: usize,
    /// Columns without padding.
    pub pivots: usize,
    /// Columns of L.
    pub wide: usize,
}

impl<const G: usize> DenseFront<'_, G> {
    /// Whether at least half of panel `p` is padding.
    #[inline(always)]
    fn is_half(&self, p: usize) -> bool {
        G > HALF && self.pivots <= p * G + HALF
    }
}

/// Factorises a front into `factor`, its L. Returns false if a pivot is not positive.
#[inline(always)]
pub(crate) fn factorise<L: Lanes<G>, const G: usize>(
    lanes: L,
    front: DenseFront<'_, G>,
    factor: &mut [[f64; G]],
) -> bool {
    let wide = front.wide;
    let panels = wide / G;
    for p in 0..panels {
        let (above, below) = factor.split_at_mut((p + 1) * wide);
        let own = &mut above[p * wide..];
        let positive = match front.is_half(p) {
            true => diagonal::<L, G, HALF>(lanes, front, p, own),
            false => diagonal::<L, G, G>(lanes, front, p, own),
        };
        if !positive {
            return false;
        }
        below_diagonal(lanes, front, p, own, &mut below[..(panels - p - 1) * wide], p + 1);
    }
    let (pivots, boundary) = factor.split_at_mut(panels * wide);
    for (i, tile) in boundary.chunks_mut(L::TALL * wide).enumerate() {
        for (p, own) in pivots.chunks(wide).enumerate() {
            below_diagonal(lanes, front, p, own, tile, panels + i * L::TALL);
        }
    }
    true
}

/// Computes N columns of the diagonal panel of L; the rest is padding.
#[inline(always)]
fn diagonal<L: Lanes<G>, const G: usize, const N: usize>(
    lanes: L,
    front: DenseFront<'_, G>,
    p: usize,
    panel: &mut [[f64; G]],
) -> bool {
    let first = p * G;
    let [mut x] = product::<L, G, 1, N>(lanes, [&panel[..first]], &panel[..first]);
    for q in 0..N {
        x[q] = lanes.sub(lanes.load(&front.columns[(first + q) * front.stride + p]), x[q]);
    }
    let Some((own, _)) = panel[first..].split_first_chunk_mut::<G>() else { return false };
    let mut positive = true;
    unrolled!(N, J => positive &= diagonal_column::<L, G, N, J>(lanes, &mut x, own));
    for q in N..G {
        own[q] = [0.0; G];
        own[q][q] = 1.0;
    }
    positive
}

/// Computes column `J` of the diagonal square and subtracts its products from the later columns.
#[inline(always)]
fn diagonal_column<L: Lanes<G>, const G: usize, const N: usize, const J: usize>(
    lanes: L,
    x: &mut [L::Vector; N],
    own: &mut [[f64; G]; G],
) -> bool {
    let column = &mut own[J];
    lanes.store(x[J], column);
    let pivot = column[J];
    let reciprocal = 1.0 / pivot.sqrt();
    let scaled = lanes.mul(x[J], lanes.splat(reciprocal));
    lanes.store(scaled, column);
    for t in J + 1..N {
        x[t] = lanes.sub_mul(scaled, lanes.splat(column[t]), x[t]);
    }
    column[..J].fill(0.0);
    column[J] = reciprocal;
    pivot > 0.0 && pivot < f64::INFINITY
}

/// Computes panel `p` of columns for the panels of rows in `rows`, the first of which is panel
/// `first_row` of the front; `own` is the diagonal panel of L.
#[inline(always)]
fn below_diagonal<L: Lanes<G>, const G: usize>(
    lanes: L,
    front: DenseFront<'_, G>,
    p: usize,
    own: &[[f64; G]],
    rows: &mut [[f64; G]],
    first_row: usize,
) {
    for (i, tile) in rows.chunks_mut(L::TALL * front.wide).enumerate() {
        let at = [first_row + i * L::TALL, p];
        match (tile.len() / front.wide, front.is_half(p)) {
            (3, false) => solve_tile::<L, G, 3, G>(lanes, front, own, tile, at),
            (2, false) => solve_tile::<L, G, 2, G>(lanes, front, own, tile, at),
            (_, false) => solve_tile::<L, G, 1, G>(lanes, front, own, tile, at),
            (3, true) => solve_tile::<L, G, 3, HALF>(lanes, front, own, tile, at),
            (2, true) => solve_tile::<L, G, 2, HALF>(lanes, front, own, tile, at),
            (_, true) => solve_tile::<L, G, 1, HALF>(lanes, front, own, tile, at),
        }
    }
}

/// Computes N columns of panel `p` for M panels of rows from `row` of [`below_diagonal`].
#[inline(always)]
fn solve_tile<L: Lanes<G>, const G: usize, const M: usize, const N: usize>(
    lanes: L,
    front: DenseFront<'_, G>,
    own: &[[f64; G]],
    tile: &mut [[f64; G]],
    [row, p]: [usize; 2],
) {
    let wide = front.wide;
    let first = p * G;
    let mut left: [&[[f64; G]]; M] = [&[]; M];
    for m in 0..M {
        left[m] = &tile[m * wide..m * wide + first];
    }
    let mut x = product::<L, G, M, N>(lanes, left, &own[..first]);
    for q in 0..N {
        let at = (first + q) * front.stride + row;
        let column = &front.columns[at..at + M];
        for m in 0..M {
            x[m][q] = lanes.sub(lanes.load(&column[m]), x[m][q]);
        }
    }
    let Some(own) = own[first..].first_chunk::<G>() else { return };
    unrolled!(N, Q => solve_column::<L, G, M, N, Q>(lanes, &mut x, own));
    for m in 0..M {
        let to = &mut tile[m * wide + first..m * wide + first + N];
        for q in 0..N {
            lanes.store(x[m][q], &mut to[q]);
        }
    }
}

/// Divides column `Q` of a tile by the diagonal and subtracts its products from the later columns.
#[inline(always)]
fn solve_column<L: Lanes<G>, const G: usize, const M: usize, const N: usize, const Q: usize>(
    lanes: L,
    x: &mut [[L::Vector; N]; M],
    own: &[[f64; G]; G],
) {
    let reciprocal = lanes.splat(own[Q][Q]);
    for m in 0..M {
        x[m][Q] = lanes.mul(x[m][Q], reciprocal);
    }
    for t in Q + 1..N {
        let l = lanes.splat(own[Q][t]);
        for m in 0..M {
            x[m][t] = lanes.sub_mul(x[m][Q], l, x[m][t]);
        }
    }
}

/// S = -L21 L21ᵀ by columns: lower triangle and diagonal squares. L has `wide` columns, `pivots` of
/// them without padding; `below` is L21.
#[inline(always)]
pub(crate) fn schur<L: Lanes<G>, const G: usize>(
    lanes: L,
    [pivots, wide]: [usize; 2],
    below: &[[f64; G]],
    s: &mut [[f64; G]],
) {
    let panels = below.len() / wide;
    let passes = pivots.div_ceil(DEPTH);
    let depth = pivots.div_ceil(passes);
    for i in (0..panels).step_by(L::TALL) {
        let end = (i + L::TALL).min(panels);
        for start in (0..pivots).step_by(depth) {
            let k = start..(start + depth).min(pivots);
            let l = BelowDiagonal { chunks: below, wide, k };
            for c in 0..end {
                let r = c.max(i);
                match end - r {
                    3 => schur_tile::<L, G, 3>(lanes, &l, [r, c], panels, s),
                    2 => schur_tile::<L, G, 2>(lanes, &l, [r, c], panels, s),
                    _ => schur_tile::<L, G, 1>(lanes, &l, [r, c], panels, s),
                }
            }
        }
    }
}

/// The columns `k` of L21.
struct BelowDiagonal<'a, const G: usize> {
    chunks: &'a [[f64; G]],
    wide: usize,
    k: Range<usize>,
}

impl<'a, const G: usize> BelowDiagonal<'a, G> {
    #[inline(always)]
    fn panel(&self, i: usize) -> &'a [[f64; G]] {
        &self.chunks[i * self.wide..(i + 1) * self.wide][self.k.clone()]
    }
}

/// Computes the tile of M panels of rows from `r` and panel `c` of columns.
#[inline(always)]
fn schur_tile<L: Lanes<G>, const G: usize, const M: usize>(
    lanes: L,
    l: &BelowDiagonal<'_, G>,
    [r, c]: [usize; 2],
    panels: usize,
    s: &mut [[f64; G]],
) {
    let mut left: [&[[f64; G]]; M] = [&[]; M];
    for m in 0..M {
        left[m] = l.panel(r + m);
    }
    let sum = product::<L, G, M, G>(lanes, left, l.panel(c));
    for q in 0..G {
        let at = (c * G + q) * panels + r;
        let column = &mut s[at..at + M];
        for m in 0..M {
            let before = if l.k.start == 0 { lanes.zero() } else { lanes.load(&column[m]) };
            lanes.store(lanes.sub(before, sum[m][q]), &mut column[m]);
        }
    }
}
