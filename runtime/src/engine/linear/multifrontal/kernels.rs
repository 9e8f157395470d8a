//! The dense work of a front, on tiles that stay in registers.
//!
//! Chunks are `G` numbers: of L, one column of a panel of `G` rows; of the columns to factorise and of S, `G` rows of one
//! column. For panel p of columns, from the first to the last, and every panel i of rows below (Cholesky, left-looking, in
//! panels; G. W. Stewart, *Matrix Algorithms* I (SIAM 1998), 3.2):
//!
//!   L_pp L_ppᵀ = A_pp - Σ_k<p L_pk L_pkᵀ,   L_ip = (A_ip - Σ_k<p L_ik L_pkᵀ) L_pp⁻ᵀ,
//!
//! the sums by one kernel, [`product`], and subtraction and division while the tile is still in registers. On the diagonal
//! of L stand the reciprocals, which is all that is ever asked for.

use super::lanes::Lanes;

/// Columns summed in one pass over S, so that a tile's rows of L stay in the first-level cache.
const DEPTH: usize = 192;

/// Σ_k rows_k columns_kᵀ of M panels of rows and one panel of columns: M by G vectors.
#[inline(always)]
fn product<L: Lanes<G>, const G: usize, const M: usize>(
    lanes: L,
    rows: [&[[f64; G]]; M],
    columns: &[[f64; G]],
) -> [[L::Vector; G]; M] {
    let depth = columns.len();
    let rows = rows.map(|r| &r[..depth]);
    let mut sum = [[lanes.zero(); G]; M];
    for k in 0..depth {
        let mut left = [lanes.zero(); M];
        for m in 0..M {
            left[m] = lanes.load(&rows[m][k]);
        }
        for q in 0..G {
            let right = lanes.splat(columns[k][q]);
            for m in 0..M {
                sum[m][q] = lanes.mul_add(left[m], right, sum[m][q]);
            }
        }
    }
    sum
}

/// The columns of a front to be factorised.
#[derive(Clone, Copy)]
pub(super) struct Columns<'a, const G: usize> {
    /// Chunks, column after column.
    pub chunks: &'a [[f64; G]],
    /// Chunks in a column.
    pub stride: usize,
}

/// Factorises a front: `columns` are its npp columns, `factor` is its L. False when a pivot is not positive.
#[inline(always)]
pub(super) fn factorise<L: Lanes<G>, const G: usize>(
    lanes: L,
    columns: Columns<'_, G>,
    wide: usize,
    factor: &mut [[f64; G]],
) -> bool {
    let panels = wide / G;
    let rows = columns.stride;
    for p in 0..panels {
        let (above, below) = factor.split_at_mut((p + 1) * wide);
        let own = &mut above[p * wide..];
        if !diagonal(lanes, columns, p, own) {
            return false;
        }
        below_diagonal(lanes, columns, p..p + 1, wide, own, &mut below[..(panels - p - 1) * wide], p + 1);
    }
    let (pivots, boundary) = factor.split_at_mut(panels * wide);
    let mut i = panels;
    for tile in boundary.chunks_mut(L::TALL * wide) {
        for p in 0..panels {
            below_diagonal(lanes, columns, p..p + 1, wide, &pivots[p * wide..(p + 1) * wide], tile, i);
        }
        i += L::TALL;
    }
    debug_assert!(i >= rows);
    true
}

/// The panel of L on the diagonal.
#[inline(always)]
fn diagonal<L: Lanes<G>, const G: usize>(lanes: L, columns: Columns<'_, G>, p: usize, panel: &mut [[f64; G]]) -> bool {
    let first = p * G;
    let [sum] = product(lanes, [&panel[..first]], &panel[..first]);
    let mut x = [lanes.zero(); G];
    for q in 0..G {
        x[q] = lanes.sub(lanes.load(&columns.chunks[(first + q) * columns.stride + p]), sum[q]);
    }
    for j in 0..G {
        let pivot = lanes.array(x[j])[j];
        if !(pivot > 0.0 && pivot < f64::INFINITY) {
            return false;
        }
        let reciprocal = 1.0 / pivot.sqrt();
        let scaled = lanes.mul(x[j], lanes.splat(reciprocal));
        let column = &mut panel[first + j];
        lanes.store(scaled, column);
        for t in j + 1..G {
            x[t] = lanes.sub_mul(scaled, lanes.splat(column[t]), x[t]);
        }
        column[..j].fill(0.0);
        column[j] = reciprocal;
    }
    true
}

/// Panel `p` of columns of the panels of rows in `rows`, the first of which is panel `first_row` of the front; `own` is the
/// panel of L on the diagonal.
#[inline(always)]
fn below_diagonal<L: Lanes<G>, const G: usize>(
    lanes: L,
    columns: Columns<'_, G>,
    p: std::ops::Range<usize>,
    wide: usize,
    own: &[[f64; G]],
    rows: &mut [[f64; G]],
    first_row: usize,
) {
    let p = p.start;
    let mut i = first_row;
    for tile in rows.chunks_mut(L::TALL * wide) {
        match tile.len() / wide {
            3 => solve_tile::<L, G, 3>(lanes, columns, p, wide, own, tile, i),
            2 => solve_tile::<L, G, 2>(lanes, columns, p, wide, own, tile, i),
            _ => solve_tile::<L, G, 1>(lanes, columns, p, wide, own, tile, i),
        }
        i += L::TALL;
    }
}

/// M panels of rows of [`below_diagonal`].
#[inline(always)]
fn solve_tile<L: Lanes<G>, const G: usize, const M: usize>(
    lanes: L,
    columns: Columns<'_, G>,
    p: usize,
    wide: usize,
    own: &[[f64; G]],
    tile: &mut [[f64; G]],
    first_row: usize,
) {
    let first = p * G;
    let mut left: [&[[f64; G]]; M] = [&[]; M];
    for m in 0..M {
        left[m] = &tile[m * wide..m * wide + first];
    }
    let mut x = product(lanes, left, &own[..first]);
    for q in 0..G {
        let at = (first + q) * columns.stride + first_row;
        let column = &columns.chunks[at..at + M];
        for m in 0..M {
            x[m][q] = lanes.sub(lanes.load(&column[m]), x[m][q]);
        }
    }
    let own = &own[first..first + G];
    for q in 0..G {
        for t in 0..q {
            let l = lanes.splat(own[t][q]);
            for m in 0..M {
                x[m][q] = lanes.sub_mul(x[m][t], l, x[m][q]);
            }
        }
        let reciprocal = lanes.splat(own[q][q]);
        for m in 0..M {
            x[m][q] = lanes.mul(x[m][q], reciprocal);
        }
    }
    for m in 0..M {
        let to = &mut tile[m * wide + first..m * wide + first + G];
        for q in 0..G {
            lanes.store(x[m][q], &mut to[q]);
        }
    }
}

/// S = -L21 L21ᵀ, by columns, in its lower triangle and the squares on the diagonal.
#[inline(always)]
pub(super) fn schur<L: Lanes<G>, const G: usize>(lanes: L, wide: usize, below: &[[f64; G]], s: &mut [[f64; G]]) {
    let panels = below.len() / wide.max(1);
    let passes = wide.div_ceil(DEPTH).max(1);
    let depth = wide.div_ceil(passes);
    let mut i = 0;
    while i < panels {
        let end = (i + L::TALL).min(panels);
        for start in (0..wide).step_by(depth.max(1)) {
            let k = start..(start + depth).min(wide);
            for c in 0..end {
                let r = c.max(i);
                match end - r {
                    3 => schur_tile::<L, G, 3>(lanes, wide, below, k.clone(), [r, c], panels, s),
                    2 => schur_tile::<L, G, 2>(lanes, wide, below, k.clone(), [r, c], panels, s),
                    _ => schur_tile::<L, G, 1>(lanes, wide, below, k.clone(), [r, c], panels, s),
                }
            }
        }
        i = end;
    }
}

/// The tile of M panels of rows from `r` and panel `c` of columns, of the columns `k` of L.
#[inline(always)]
fn schur_tile<L: Lanes<G>, const G: usize, const M: usize>(
    lanes: L,
    wide: usize,
    below: &[[f64; G]],
    k: std::ops::Range<usize>,
    [r, c]: [usize; 2],
    panels: usize,
    s: &mut [[f64; G]],
) {
    let mut left: [&[[f64; G]]; M] = [&[]; M];
    for m in 0..M {
        left[m] = &below[(r + m) * wide + k.start..(r + m) * wide + k.end];
    }
    let sum = product(lanes, left, &below[c * wide + k.start..c * wide + k.end]);
    for q in 0..G {
        let at = (c * G + q) * panels + r;
        let column = &mut s[at..at + M];
        for m in 0..M {
            let before = if k.start == 0 { lanes.zero() } else { lanes.load(&column[m]) };
            lanes.store(lanes.sub(before, sum[m][q]), &mut column[m]);
        }
    }
}
