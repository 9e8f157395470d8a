//! Forward and backward substitution with a factor in panels.

use crate::linear::multifrontal::lanes::{Lanes, VectorKernel};
use crate::linear::multifrontal::symbolic::{Front, SymbolicFactor};

/// Right-hand side: `x` holds b, then the solution, in the order of elimination; `local` is a
/// buffer for the rows of a front.
pub(crate) struct RightHandSide<'a> {
    pub x: &'a mut [f64],
    pub local: &'a mut [f64],
}

/// Solution of L Lᵀ x = b; of Lᵀ x = y if the forward substitution is done.
pub(crate) struct Solve<'a> {
    pub symbolic: &'a SymbolicFactor,
    pub factor: &'a [f64],
    pub side: RightHandSide<'a>,
    pub half_done: bool,
}

impl<const G: usize> VectorKernel<G> for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<G>>(self, lanes: L) {
        let Self { symbolic, factor, side: RightHandSide { x, local }, half_done } = self;
        if !half_done {
            for front in &symbolic.fronts {
                forward(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
            }
        }
        for front in symbolic.fronts.iter().rev() {
            backward(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
        }
    }
}

/// Solution of L y = b in the fronts of `path`, which contain all of b and every ancestor of each
/// front.
pub(crate) struct HalfSolve<'a> {
    pub symbolic: &'a SymbolicFactor,
    pub factor: &'a [f64],
    pub side: RightHandSide<'a>,
    pub path: &'a [u32],
}

impl<const G: usize> VectorKernel<G> for HalfSolve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<G>>(self, lanes: L) {
        let Self { symbolic, factor, side: RightHandSide { x, local }, path } = self;
        for &k in path {
            let front = &symbolic.fronts[k as usize];
            forward(lanes, symbolic, front, factor[front.factor_range()].as_chunks().0, x, local);
        }
    }
}

/// Σ_k panel_k y_k.
#[inline(always)]
fn times<L: Lanes<G>, const G: usize>(lanes: L, panel: &[[f64; G]], y: &[f64]) -> L::Vector {
    let mut sums = [lanes.zero(); 4];
    // The depth is a multiple of G and so of 4.
    for (four, y) in panel.as_chunks::<4>().0.iter().zip(y.as_chunks::<4>().0) {
        for q in 0..4 {
            sums[q] = lanes.mul_add(lanes.load(&four[q]), lanes.splat(y[q]), sums[q]);
        }
    }
    lanes.add(lanes.add(sums[0], sums[1]), lanes.add(sums[2], sums[3]))
}

/// L y = b in one front: its pivots of `x` become y; their products are subtracted from the
/// boundary.
#[inline(always)]
pub(crate) fn forward<L: Lanes<G>, const G: usize>(
    lanes: L,
    symbolic: &SymbolicFactor,
    front: &Front,
    factor: &[[f64; G]],
    x: &mut [f64],
    local: &mut [f64],
) {
    let wide = front.wide;
    let pivots = &mut x[front.first..front.first + front.pivots];
    let (y, z) = local[..front.rows()].split_at_mut(wide);
    y[..front.pivots].copy_from_slice(pivots);
    y[front.pivots..].fill(0.0);
    let mut panels = factor.chunks_exact(wide);
    for first in (0..wide).step_by(G) {
        let Some(panel) = panels.next() else { break };
        let sum = lanes.array(times(lanes, &panel[..first], &y[..first]));
        let own = &panel[first..first + G];
        let y = &mut y[first..first + G];
        for q in 0..G {
            let mut v = y[q] - sum[q];
            for t in 0..q {
                v -= own[t][q] * y[t];
            }
            y[q] = v * own[q][q];
        }
    }
    pivots.copy_from_slice(&y[..front.pivots]);
    for (panel, z) in panels.zip(z.as_chunks_mut().0) {
        lanes.store(times(lanes, panel, y), z);
    }
    for (&mass, z) in symbolic.boundary(front).iter().zip(z.as_chunks::<3>().0) {
        let x = &mut x[3 * mass as usize..3 * mass as usize + 3];
        for k in 0..3 {
            x[k] -= z[k];
        }
    }
}

/// Lᵀ x = y in one front: its pivots of `x` become the solution; that of the boundary must exist.
#[inline(always)]
fn backward<L: Lanes<G>, const G: usize>(
    lanes: L,
    symbolic: &SymbolicFactor,
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
