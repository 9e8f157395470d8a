//! Forward and backward substitution with a factor in panels.

use super::lanes::{Job, Lanes};
use super::symbolic::{Front, Symbolic};

/// What is solved for: `x` holds b, then the solution, in the order of the elimination; `local` is scratch for the rows of a
/// front.
pub(super) struct RightHandSide<'a> {
    pub x: &'a mut [f64],
    pub local: &'a mut [f64],
}

/// Solves L Lᵀ x = b, or Lᵀ x = y where the first half is done.
pub(super) struct Solve<'a> {
    pub symbolic: &'a Symbolic,
    pub factor: &'a [f64],
    pub side: RightHandSide<'a>,
    pub half_done: bool,
}

impl<const G: usize> Job<G> for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<G>>(self, lanes: L) {
        let Self { symbolic, factor, side: RightHandSide { x, local }, half_done } = self;
        if !half_done {
            for front in &symbolic.fronts {
                forward::<L, G, 1>(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
            }
        }
        for front in symbolic.fronts.iter().rev() {
            backward(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
        }
    }
}

/// L y = b in the fronts of `path` alone, which hold all of b and, with a front, every front above it; of `R` right-hand sides at once, one
/// after the other in `side.x` and in `side.local`, so that L is read once for all of them. Each has the bits that it has alone.
pub(super) struct HalfSolve<'a, const R: usize> {
    pub symbolic: &'a Symbolic,
    pub factor: &'a [f64],
    pub side: RightHandSide<'a>,
    pub path: &'a [u32],
}

impl<const G: usize, const R: usize> Job<G> for HalfSolve<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<G>>(self, lanes: L) {
        let Self { symbolic, factor, side: RightHandSide { x, local }, path } = self;
        for &k in path {
            let front = &symbolic.fronts[k as usize];
            forward::<L, G, R>(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
        }
    }
}

/// Σ_k panel_k y_k for each of R vectors y.
#[inline(always)]
fn times<L: Lanes<G>, const G: usize, const R: usize>(lanes: L, panel: &[[f64; G]], y: [&[f64]; R]) -> [L::Vector; R] {
    let mut sums = [[lanes.zero(); 4]; R];
    let mut whole: [&[f64]; R] = [&[]; R];
    for r in 0..R {
        whole[r] = &y[r][..panel.len()];
    }
    // Depths are multiples of G and so of 4.
    for (k, four) in panel.as_chunks::<4>().0.iter().enumerate() {
        for q in 0..4 {
            let l = lanes.load(&four[q]);
            for r in 0..R {
                sums[r][q] = lanes.mul_add(l, lanes.splat(whole[r][4 * k + q]), sums[r][q]);
            }
        }
    }
    let mut total = [lanes.zero(); R];
    for r in 0..R {
        total[r] = lanes.add(lanes.add(sums[r][0], sums[r][1]), lanes.add(sums[r][2], sums[r][3]));
    }
    total
}

/// L y = b in one front: its pivots of `x` become y, and what they give is taken from the boundary's. There are R of `x`, one after the other.
#[inline(always)]
pub(super) fn forward<L: Lanes<G>, const G: usize, const R: usize>(
    lanes: L,
    symbolic: &Symbolic,
    front: &Front,
    factor: &[[f64; G]],
    x: &mut [f64],
    local: &mut [f64],
) {
    let (wide, rows, size) = (front.wide, front.rows(), 3 * symbolic.order.len());
    let local = &mut local[..R * rows];
    for (y, x) in local.chunks_exact_mut(rows).zip(x.chunks_exact(size)) {
        y[..front.pivots].copy_from_slice(&x[front.first..front.first + front.pivots]);
        y[front.pivots..wide].fill(0.0);
    }
    let mut panels = factor.chunks_exact(wide);
    for first in (0..wide).step_by(G) {
        let Some(panel) = panels.next() else { break };
        let sums = times::<L, G, R>(lanes, &panel[..first], each(local, rows));
        let own = &panel[first..first + G];
        for r in 0..R {
            let sum = lanes.array(sums[r]);
            let y = &mut local[r * rows + first..r * rows + first + G];
            for q in 0..G {
                let mut v = y[q] - sum[q];
                for t in 0..q {
                    v -= own[t][q] * y[t];
                }
                y[q] = v * own[q][q];
            }
        }
    }
    for (i, panel) in panels.enumerate() {
        let sums = times::<L, G, R>(lanes, panel, each(local, rows));
        for r in 0..R {
            let at = r * rows + wide + i * G;
            if let Some(z) = local[at..].first_chunk_mut::<G>() {
                lanes.store(sums[r], z);
            }
        }
    }
    for (y, x) in local.chunks_exact(rows).zip(x.chunks_exact_mut(size)) {
        x[front.first..front.first + front.pivots].copy_from_slice(&y[..front.pivots]);
        for (&mass, z) in symbolic.boundary(front).iter().zip(y[wide..].as_chunks::<3>().0) {
            let x = &mut x[3 * mass as usize..3 * mass as usize + 3];
            for k in 0..3 {
                x[k] -= z[k];
            }
        }
    }
}

/// The R vectors of `rows` numbers that are one after the other.
#[inline(always)]
fn each<const R: usize>(all: &[f64], rows: usize) -> [&[f64]; R] {
    let mut parts: [&[f64]; R] = [&[]; R];
    for r in 0..R {
        parts[r] = &all[r * rows..(r + 1) * rows];
    }
    parts
}

/// Lᵀ x = y in one front: its pivots of `x` become the solution, that of the boundary being there.
#[inline(always)]
fn backward<L: Lanes<G>, const G: usize>(
    lanes: L,
    symbolic: &Symbolic,
    front: &Front,
    factor: &[[f64; G]],
    x: &mut [f64],
    local: &mut [f64],
) {
    let wide = front.wide;
    let local = &mut local[..front.rows()];
    let boundary = symbolic.boundary(front);
    local[..front.pivots].copy_from_slice(&x[front.first..front.first + front.pivots]);
    local[front.pivots..wide].fill(0.0);
    for (&mass, z) in boundary.iter().zip(local[wide..].as_chunks_mut::<3>().0) {
        z.copy_from_slice(&x[3 * mass as usize..3 * mass as usize + 3]);
    }
    local[wide + 3 * boundary.len()..].fill(0.0);
    for p in (0..wide / G).rev() {
        let first = p * G;
        let mut sums = [lanes.zero(); G];
        for (panel, y) in factor.chunks_exact(wide).zip(local.as_chunks::<G>().0).skip(p + 1) {
            let y = lanes.load(y);
            for (sum, l) in sums.iter_mut().zip(&panel[first..first + G]) {
                *sum = lanes.mul_add(lanes.load(l), y, *sum);
            }
        }
        let own = &factor[p * wide + first..p * wide + first + G];
        let y = &mut local[first..first + G];
        for q in (0..G).rev() {
            let mut v = y[q] - lanes.array(sums[q]).iter().sum::<f64>();
            for r in q + 1..G {
                v -= own[q][r] * y[r];
            }
            y[q] = v * own[q][q];
        }
    }
    x[front.first..front.first + front.pivots].copy_from_slice(&local[..front.pivots]);
}
