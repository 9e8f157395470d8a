//! Membrane strains of a grid, and the least motion of its nodes that restores given strains.
//!
//! A curve through nodes is longer than the chain of straight edges by the fraction (h κ)²/24, so
//! that interpolation of a bent sheet at another grid causes membrane strain, whose energy in a
//! thin sheet exceeds that of all its bending. Edges and cells have the strains of
//! [`crate::elements::grid_membrane`]; their targets ε* are interpolated linearly from the other
//! grid. A triangular layer has only the strains of its edges. The motion d of the nodes minimises
//! Σ (ε - ε*)² + μ Σ |d|²/h² (Gauss-Newton, with conjugate gradients on the normal equations). μ
//! damps motions that hardly change the strains. Fixed nodes do not move.

use glam::DVec3;

use crate::sheet::remap::spline::places;

/// Weight μ of the motion, between that of a stiff sheet's membrane, which relaxes within a
/// millisecond, and that of its bending, which is slower.
pub(crate) const MOTION_WEIGHT: f64 = 1e-5;
/// Maximum number of Newton iterations, maximum number of conjugate gradient steps in each, and
/// tolerance on the residual relative to the first one.
pub(crate) const MAX_NEWTON_ITERATIONS: usize = 3;
const MAX_CG_STEPS: usize = 120;
const CG_TOLERANCE: f64 = 1e-4;
/// Strain below which a correction is omitted.
pub(crate) const STRAIN_THRESHOLD: f64 = 1e-10;

/// Grid of nodes with its spacings at rest, m.
#[derive(Clone, Copy)]
pub(crate) struct StrainGrid {
    pub columns: usize,
    pub rows: usize,
    pub spacing: (f64, f64),
    /// Whether odd rows are shifted by half a cell along u. The strains are then those of the edges
    /// along u and of the two kinds of slanting edges.
    pub triangular: bool,
}

/// Strains, or their rates: of edges along u row by row, of edges along v, of cells.
#[derive(Clone, Default)]
pub(crate) struct GridStrains {
    u: Vec<f64>,
    v: Vec<f64>,
    shear: Vec<f64>,
}

impl GridStrains {
    fn parts(&self) -> [&Vec<f64>; 3] {
        [&self.u, &self.v, &self.shear]
    }

    fn parts_mut(&mut self) -> [&mut Vec<f64>; 3] {
        [&mut self.u, &mut self.v, &mut self.shear]
    }

    /// Sum of the squares.
    pub fn square(&self) -> f64 {
        self.parts().into_iter().flatten().map(|e| e * e).sum()
    }

    fn largest(&self) -> f64 {
        self.parts().into_iter().flatten().fold(0.0, |most, e| e.abs().max(most))
    }

    fn minus(mut self, other: &Self) -> Self {
        for (a, b) in self.parts_mut().into_iter().zip(other.parts()) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a -= b);
        }
        self
    }
}

impl StrainGrid {
    fn at(&self, i: usize, j: usize) -> usize {
        j * self.columns + i
    }

    fn edges_u(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.rows).flat_map(move |j| (0..self.columns - 1).map(move |i| [self.at(i, j), self.at(i + 1, j)]))
    }

    fn edges_v(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.rows - 1).flat_map(move |j| (0..self.columns).map(move |i| [self.at(i, j), self.at(i, j + 1)]))
    }

    /// Slanting edges of a triangular layer, from each row to the next.
    fn slanting_edges(&self, forward: bool) -> impl Iterator<Item = [usize; 2]> + '_ {
        let column = move |i: usize, j: usize| (i + j % 2 + usize::from(forward)).checked_sub(1);
        let there =
            move |i, j| column(i, j).filter(|to| *to < self.columns).map(|to| [self.at(i, j), self.at(to, j + 1)]);
        (0..self.rows - 1).flat_map(move |j| (0..self.columns).filter_map(move |i| there(i, j)))
    }

    /// Length of a slanting edge at rest, m.
    fn slant(&self) -> f64 {
        (0.5 * self.spacing.0).hypot(self.spacing.1)
    }

    fn cells(&self) -> impl Iterator<Item = [usize; 4]> + '_ {
        let corners = move |i, j| [self.at(i, j), self.at(i + 1, j), self.at(i, j + 1), self.at(i + 1, j + 1)];
        (0..self.rows - 1).flat_map(move |j| (0..self.columns - 1).map(move |i| corners(i, j)))
    }

    /// Derivatives of `of` along u and v in the middle of a cell.
    fn middle(&self, of: &[DVec3], [a, b, c, d]: [usize; 4]) -> (DVec3, DVec3) {
        let u = (of[b] - of[a] + of[d] - of[c]) * (0.5 / self.spacing.0);
        let v = (of[c] - of[a] + of[d] - of[b]) * (0.5 / self.spacing.1);
        (u, v)
    }

    /// Strains from those `along` edges of a length (m) and of the `shear` of cells.
    fn measure(&self, along: impl Fn([usize; 2], f64) -> f64, shear: impl Fn([usize; 4]) -> f64) -> GridStrains {
        let u = self.edges_u().map(|e| along(e, self.spacing.0)).collect();
        if self.triangular {
            let slants = |forward| self.slanting_edges(forward).map(|e| along(e, self.slant())).collect();
            return GridStrains { u, v: slants(true), shear: slants(false) };
        }
        let v = self.edges_v().map(|e| along(e, self.spacing.1)).collect();
        GridStrains { u, v, shear: self.cells().map(shear).collect() }
    }

    /// Strains at the positions `x` (m).
    pub fn strains(&self, x: &[DVec3]) -> GridStrains {
        let along = |[a, b]: [usize; 2], h: f64| 0.5 * ((x[b] - x[a]).length_squared() / (h * h) - 1.0);
        let shear = |cell| {
            let (a, b) = self.middle(x, cell);
            a.dot(b)
        };
        self.measure(along, shear)
    }

    /// First-order change of the strains at `x` (m) by the displacement `d` (m); rates of strain
    /// for velocities.
    pub fn rates(&self, x: &[DVec3], d: &[DVec3]) -> GridStrains {
        let along = |[a, b]: [usize; 2], h: f64| (x[b] - x[a]).dot(d[b] - d[a]) / (h * h);
        let shear = |cell| {
            let ((a, b), (p, q)) = (self.middle(x, cell), self.middle(d, cell));
            a.dot(q) + p.dot(b)
        };
        self.measure(along, shear)
    }

    /// Apply the transpose of [`StrainGrid::rates`] to `of`.
    fn apply_transposed_rates(&self, x: &[DVec3], of: &GridStrains, to: &mut [DVec3]) {
        to.fill(DVec3::ZERO);
        let (hu, hv) = self.spacing;
        let mut along = |[a, b]: [usize; 2], e: f64, h: f64| {
            let pull = (x[b] - x[a]) * (e / (h * h));
            to[a] -= pull;
            to[b] += pull;
        };
        self.edges_u().zip(&of.u).for_each(|(edge, e)| along(edge, *e, hu));
        if self.triangular {
            let slant = self.slant();
            for (forward, of) in [(true, &of.v), (false, &of.shear)] {
                self.slanting_edges(forward).zip(of).for_each(|(edge, e)| along(edge, *e, slant));
            }
            return;
        }
        self.edges_v().zip(&of.v).for_each(|(edge, e)| along(edge, *e, hv));
        for (cell, e) in self.cells().zip(&of.shear) {
            let (p, q) = self.middle(x, cell);
            let (by_u, by_v) = (q * (0.5 * e / hu), p * (0.5 * e / hv));
            let [a, b, c, d] = cell;
            to[a] -= by_u + by_v;
            to[b] += by_u - by_v;
            to[c] += by_v - by_u;
            to[d] += by_u + by_v;
        }
    }

    /// Strains from the tensor `field` (uu, vv, uv), evaluated at the mean position of the nodes of
    /// an edge or cell.
    pub fn strains_of_field(&self, field: impl Fn(&[usize]) -> [f64; 3]) -> GridStrains {
        let u = self.edges_u().map(|e| field(&e)[0]).collect();
        if self.triangular {
            let slants = |forward: bool| {
                let along = if forward { 0.5 } else { -0.5 } * self.spacing.0;
                let (s, t) = (along / self.slant(), self.spacing.1 / self.slant());
                let strain = move |[uu, vv, uv]: [f64; 3]| s * s * uu + t * t * vv + 2.0 * s * t * uv;
                self.slanting_edges(forward).map(|e| strain(field(&e))).collect()
            };
            return GridStrains { u, v: slants(true), shear: slants(false) };
        }
        GridStrains {
            u,
            v: self.edges_v().map(|e| field(&e)[1]).collect(),
            shear: self.cells().map(|c| 2.0 * field(&c)[2]).collect(),
        }
    }

    /// Interpolate strains `of` this grid at the edges and cells of `other`, linearly, and constant
    /// beyond the outermost ones.
    pub fn interpolate(&self, of: &GridStrains, other: &Self) -> GridStrains {
        let axis = |from: usize, to: usize, middles: bool| -> Vec<(usize, usize, f64)> {
            let cells = places(from, to);
            let count = if middles { from - 1 } else { from };
            let at = |k: usize| if middles { 0.5 * (cells[k] + cells[k + 1]) - 0.5 } else { cells[k] };
            let each = (0..if middles { to - 1 } else { to }).map(|k| {
                let place = at(k).clamp(0.0, (count - 1) as f64);
                let low = (place.floor() as usize).min(count - 1);
                (low, (low + 1).min(count - 1), place - low as f64)
            });
            each.collect()
        };
        let read = |values: &[f64], (mid_u, mid_v): (bool, bool)| -> Vec<f64> {
            let (u, v) = (axis(self.columns, other.columns, mid_u), axis(self.rows, other.rows, mid_v));
            let count = if mid_u { self.columns - 1 } else { self.columns };
            let row = |j: usize, (a, b, s): (usize, usize, f64)| {
                (1.0 - s) * values[j * count + a] + s * values[j * count + b]
            };
            v.iter().flat_map(|(a, b, s)| u.iter().map(move |u| (1.0 - s) * row(*a, *u) + s * row(*b, *u))).collect()
        };
        GridStrains {
            u: read(&of.u, (true, false)),
            v: read(&of.v, (false, true)),
            shear: read(&of.shear, (true, true)),
        }
    }

    /// Least motion that changes the strains at `x` by `change`; `held` nodes do not move.
    pub fn least_motion(&self, x: &[DVec3], change: &GridStrains, held: &[bool]) -> Vec<DVec3> {
        self.least_projected_motion(x, change, |i, d| if held[i] { DVec3::ZERO } else { d })
    }

    /// Least motion as in [`StrainGrid::least_motion`], with the motion of each node projected by
    /// `allowed`.
    pub fn least_projected_motion(
        &self,
        x: &[DVec3],
        change: &GridStrains,
        allowed: impl Fn(usize, DVec3) -> DVec3,
    ) -> Vec<DVec3> {
        let scale = MOTION_WEIGHT / (self.spacing.0 * self.spacing.1);
        let free = |d: &mut [DVec3]| d.iter_mut().enumerate().for_each(|(i, d)| *d = allowed(i, *d));
        let mut first = vec![DVec3::ZERO; x.len()];
        self.apply_transposed_rates(x, change, &mut first);
        let normal = |way: &[DVec3], image: &mut [DVec3]| {
            self.apply_transposed_rates(x, &self.rates(x, way), image);
            image.iter_mut().zip(way).for_each(|(i, w)| *i += *w * scale);
        };
        solve_conjugate_gradients(first, normal, free)
    }

    /// Move nodes from `x` (m) towards the strains `wanted`.
    pub fn restore_strains(&self, x: &mut [DVec3], wanted: &GridStrains, held: &[bool]) {
        for _ in 0..MAX_NEWTON_ITERATIONS {
            let change = wanted.clone().minus(&self.strains(x));
            if change.largest() < STRAIN_THRESHOLD {
                return;
            }
            let d = self.least_motion(x, &change, held);
            x.iter_mut().zip(&d).for_each(|(x, d)| *x += *d);
        }
    }

    /// Change the velocities `v` (m/s) towards the rates of strain `wanted` (1/s).
    pub fn restore_strain_rates(&self, x: &[DVec3], v: &mut [DVec3], wanted: &GridStrains, held: &[bool]) {
        let change = wanted.clone().minus(&self.rates(x, v));
        if change.largest() > 0.0 {
            let d = self.least_motion(x, &change, held);
            v.iter_mut().zip(&d).for_each(|(v, d)| *v += *d);
        }
    }
}

/// Solve N d = `residual` by conjugate gradients in the subspace of the projection `free`; `normal`
/// is the product with N.
pub(crate) fn solve_conjugate_gradients(
    mut residual: Vec<DVec3>,
    normal: impl Fn(&[DVec3], &mut [DVec3]),
    free: impl Fn(&mut [DVec3]),
) -> Vec<DVec3> {
    let n = residual.len();
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let (mut d, mut image) = (vec![DVec3::ZERO; n], vec![DVec3::ZERO; n]);
    free(&mut residual);
    let mut way = residual.clone();
    let first = dot(&residual, &residual);
    let mut size = first;
    for _ in 0..MAX_CG_STEPS {
        if size <= CG_TOLERANCE * CG_TOLERANCE * first || size == 0.0 {
            break;
        }
        normal(&way, &mut image);
        free(&mut image);
        let step = size / dot(&way, &image);
        d.iter_mut().zip(&way).for_each(|(d, w)| *d += *w * step);
        residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= *i * step);
        let next = dot(&residual, &residual);
        way.iter_mut().zip(&residual).for_each(|(w, r)| *w = *r + *w * (next / size));
        size = next;
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cylinder of curvature 4 1/m, on chords as long as the edges of the flat sheet.
    fn bent(columns: usize, rows: usize) -> (StrainGrid, Vec<DVec3>) {
        let mesh = StrainGrid {
            columns,
            rows,
            spacing: (0.25 / (columns - 1) as f64, 0.2 / (rows - 1) as f64),
            triangular: false,
        };
        let turn = 2.0 * (0.5 * 4.0 * mesh.spacing.0).asin();
        let place = |k: usize| {
            let angle = turn * (k % columns) as f64;
            DVec3::new(angle.sin(), 1.0 - angle.cos(), 0.0) * 0.25 + DVec3::Z * ((k / columns) as f64 * mesh.spacing.1)
        };
        (mesh, (0..columns * rows).map(place).collect())
    }

    #[test]
    fn nodes_move_to_the_wanted_strains() {
        let (mesh, wanted) = bent(21, 9);
        let own = mesh.strains(&wanted);
        assert!(own.largest() < 1e-12);
        // Stretched like a curve through half as many nodes.
        let mut x: Vec<DVec3> = wanted.iter().map(|p| *p * 1.0004 + DVec3::Y * (1e-5 * (40.0 * p.x).sin())).collect();
        assert!(mesh.strains(&x).largest() > 3e-4);
        let before = x.clone();
        mesh.restore_strains(&mut x, &own, &[false; 189]);
        let left = mesh.strains(&x).largest();
        assert!(left < 3e-6, "{left}");
        let moved = x.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(moved < 2e-4, "{moved} m");
    }

    #[test]
    fn edge_strains_of_a_triangular_layer_follow_its_tensor() {
        let mesh = StrainGrid { columns: 6, rows: 5, spacing: (0.05, 0.04), triangular: true };
        let rest = |k: usize| {
            let (i, j) = ((k % 6) as f64, (k / 6) as f64);
            DVec3::new((i + 0.5 * (j % 2.0)) * 0.05, 0.0, j * 0.04)
        };
        let x: Vec<DVec3> = (0..30).map(rest).collect();
        assert!(mesh.strains(&x).largest() < 1e-12);
        let (uu, vv, uv) = (0.3, -0.2, 0.15);
        let d: Vec<DVec3> = x.iter().map(|p| DVec3::new(uu * p.x + uv * p.z, 1.0, uv * p.x + vv * p.z)).collect();
        let wanted = mesh.strains_of_field(|_| [uu, vv, uv]);
        assert!(mesh.rates(&x, &d).minus(&wanted).largest() < 1e-12);
        // The transpose of the rates.
        let mut back = vec![DVec3::ZERO; 30];
        mesh.apply_transposed_rates(&x, &wanted, &mut back);
        let by_masses: f64 = back.iter().zip(&d).map(|(b, d)| b.dot(*d)).sum();
        let by_edges: f64 = wanted.parts().into_iter().flatten().map(|e| e * e).sum();
        assert!((by_masses / by_edges - 1.0).abs() < 1e-12);
    }

    #[test]
    fn strains_interpolate_between_grids() {
        let (coarse, _) = bent(6, 4);
        let (fine, _) = bent(11, 7);
        let stretched = |m: &StrainGrid| -> Vec<DVec3> {
            let place = |k: usize| {
                let (u, v) = ((k % m.columns) as f64 * m.spacing.0, (k / m.columns) as f64 * m.spacing.1);
                DVec3::new(1.01 * u + 0.003 * v, 0.0, 0.98 * v)
            };
            (0..m.columns * m.rows).map(place).collect()
        };
        let read = coarse.interpolate(&coarse.strains(&stretched(&coarse)), &fine);
        let own = fine.strains(&stretched(&fine));
        assert!(read.minus(&own).largest() < 1e-12);
    }
}
