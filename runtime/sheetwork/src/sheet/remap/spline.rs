//! Smooth surface through the nodes of a grid, for interpolation at the nodes of another grid.
//!
//! Rows along u are cubic splines through their nodes, and columns are cubic splines through the
//! results. The slope at a clamped end is that of the clamp. At a free end the spline is
//! not-a-knot, because a sheet with rest curvature is bent up to its edge; so it is on both sides
//! of a crease. Values at coincident nodes are exact to the bit. The odd rows of a triangular layer
//! are shifted by half a cell; every row is extended to both ends of the sheet by curves through
//! the ends of the other rows.

use glam::DVec3;

use crate::math::Vectors;
use crate::sheet::surface::CreaseLines;

/// Distance in cells below which a point coincides with a node.
const COINCIDENCE_TOLERANCE: f64 = 1e-9;

/// Prescribed derivatives (per cell) at the two ends of a row.
type EndSlopes = [Option<DVec3>; 2];

/// Positions of `to` evenly spaced points on a row of `from` nodes, in cells.
pub(crate) fn places(from: usize, to: usize) -> Vec<f64> {
    let step = (from - 1) as f64 / (to - 1) as f64;
    (0..to).map(|i| if i + 1 == to { (from - 1) as f64 } else { i as f64 * step }).collect()
}

/// Derivatives per cell of the spline through `points`, two or more.
fn slopes(points: &[DVec3], ends: EndSlopes) -> Vec<DVec3> {
    let n = points.len();
    let rise = |i: usize| points[i + 1] - points[i];
    if n < 4 {
        return short_row_slopes(points, ends);
    }
    // m₋ + 4 m + m₊ = 3 (p₊ - p₋) inside; at an end the slope, or m₀ + 2 m₁ = (5 Δ₀ + Δ₁)/2.
    let mut upper = vec![1.0; n];
    let mut right: Vec<DVec3> = vec![DVec3::ZERO; n];
    match ends[0] {
        Some(slope) => (upper[0], right[0]) = (0.0, slope),
        None => (upper[0], right[0]) = (2.0, (rise(0) * 5.0 + rise(1)) * 0.5),
    }
    for i in 1..n - 1 {
        let pivot = 4.0 - upper[i - 1];
        right[i] = ((points[i + 1] - points[i - 1]) * 3.0 - right[i - 1]) / pivot;
        upper[i] = 1.0 / pivot;
    }
    right[n - 1] = match ends[1] {
        Some(slope) => slope,
        None => {
            let sum = (rise(n - 2) * 5.0 + rise(n - 3)) * 0.5;
            (sum - right[n - 2] * 2.0) / (1.0 - 2.0 * upper[n - 2])
        }
    };
    for i in (0..n - 1).rev() {
        let next = right[i + 1];
        right[i] -= next * upper[i];
    }
    right
}

/// Derivatives per cell for two or three points: those of a line or a parabola, except for
/// prescribed slopes.
fn short_row_slopes(points: &[DVec3], ends: EndSlopes) -> Vec<DVec3> {
    let n = points.len();
    let mut all = if n == 2 {
        vec![points[1] - points[0]; 2]
    } else {
        let (a, b) = (points[1] - points[0], points[2] - points[1]);
        vec![(a * 3.0 - b) * 0.5, (a + b) * 0.5, (b * 3.0 - a) * 0.5]
    };
    if let Some(slope) = ends[0] {
        all[0] = slope;
    }
    if let Some(slope) = ends[1] {
        all[n - 1] = slope;
    }
    all
}

/// Weights of the rise and of the slopes at both ends in a cubic piece, at its parameter `t`.
fn hermite_basis(t: f64) -> [f64; 3] {
    let (t2, t3) = (t * t, t * t * t);
    [3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2]
}

/// Evaluate the spline through `points` at `at` (cells); it ends on both sides of each of `folds`.
fn evaluate_spline(points: &[DVec3], ends: EndSlopes, folds: &[u32], at: &[f64], out: &mut Vec<DVec3>) {
    let last = points.len() - 1;
    let mut begin = 0;
    // Slopes at both ends of every piece.
    let mut pieces: Vec<[DVec3; 2]> = Vec::with_capacity(last);
    let within = folds.iter().map(|f| *f as usize).filter(|f| (1..last).contains(f));
    for end in within.chain([last]) {
        let own = [ends[0].filter(|_| begin == 0), ends[1].filter(|_| end == last)];
        let slopes = slopes(&points[begin..=end], own);
        pieces.extend(slopes.windows(2).map(|pair| [pair[0], pair[1]]));
        begin = end;
    }
    for place in at {
        let near = place.round();
        if (place - near).abs() < COINCIDENCE_TOLERANCE {
            out.push(points[near as usize]);
            continue;
        }
        let i = (place.floor() as usize).min(last - 1);
        let t = place - i as f64;
        let [h01, h10, h11] = hermite_basis(t);
        out.push(points[i].lerp(points[i + 1], h01) + pieces[i][0] * h10 + pieces[i][1] * h11);
    }
}

/// Evaluate the not-a-knot spline through `points` at ascending `knots` at the parameters `at`.
fn evaluate_uneven_spline(knots: &[f64], points: &[DVec3], at: &[f64], out: &mut Vec<DVec3>) {
    let n = points.len();
    let wide = |i: usize| knots[i + 1] - knots[i];
    let rise = |i: usize| (points[i + 1] - points[i]) / wide(i);
    if n < 4 {
        // Lagrange polynomial through the points.
        let weight = |t: f64, i: usize| -> f64 {
            (0..n).filter(|j| *j != i).map(|j| (t - knots[j]) / (knots[i] - knots[j])).product()
        };
        out.extend(at.iter().map(|t| (0..n).map(|i| points[i] * weight(*t, i)).sum::<DVec3>()));
        return;
    }
    let end = |first: usize, second: usize| {
        let (h, g) = (wide(first), wide(second));
        (rise(first) * ((3.0 * h + 2.0 * g) * g) + rise(second) * (h * h)) / (h + g)
    };
    let mut upper = vec![0.0; n];
    let mut slopes = vec![DVec3::ZERO; n];
    upper[0] = (wide(0) + wide(1)) / wide(1);
    slopes[0] = end(0, 1) / wide(1);
    for i in 1..n - 1 {
        let (h, g) = (wide(i - 1), wide(i));
        let pivot = 2.0 * (h + g) - g * upper[i - 1];
        slopes[i] = ((rise(i - 1) * g + rise(i) * h) * 3.0 - slopes[i - 1] * g) / pivot;
        upper[i] = h / pivot;
    }
    let (h, g) = (wide(n - 2), wide(n - 3));
    slopes[n - 1] = (end(n - 2, n - 3) - slopes[n - 2] * (h + g)) / (g - (h + g) * upper[n - 2]);
    for i in (0..n - 1).rev() {
        let next = slopes[i + 1];
        slopes[i] -= next * upper[i];
    }
    for place in at {
        let i = knots.partition_point(|k| k <= place).clamp(1, n - 1) - 1;
        let t = (place - knots[i]) / wide(i);
        let [h01, h10, h11] = hermite_basis(t);
        out.push(points[i].lerp(points[i + 1], h01) + (slopes[i] * h10 + slopes[i + 1] * h11) * wide(i));
    }
}

/// Surface through a grid of nodes, and the grid of its evaluation.
pub(crate) struct SplineSurface<'a> {
    /// Numbers of nodes along u and v, of the old grid and of the new one.
    pub from: (usize, usize),
    pub to: (usize, usize),
    /// Whether each node is clamped.
    pub clamped: &'a [bool],
    /// Whether odd rows are shifted by half a cell along u.
    pub staggered: bool,
    /// Columns and rows along creases.
    pub folds: &'a CreaseLines,
}

impl SplineSurface<'_> {
    /// Interpolate `values` at the nodes of the new grid; `clamp` are the derivatives per cell
    /// along u and v at clamped nodes.
    pub fn interpolate(&self, values: &Vectors, clamp: [DVec3; 2]) -> Vec<DVec3> {
        let (nu, mu) = (self.from.0, self.to.0);
        if !self.staggered {
            let along_u = places(nu, mu);
            return self.columns(&self.rows(values, clamp, &along_u), clamp, &along_u);
        }
        // Shifted and unshifted new rows lie at different places of the old rows: each kind is
        // evaluated on its own, and its rows are selected.
        let step = (nu as f64 - 0.5) / (mu as f64 - 0.5);
        let kinds = [0.0, 0.5].map(|shift| {
            let along_u: Vec<f64> = (0..mu).map(|i| (i as f64 + shift) * step).collect();
            self.columns(&self.shifted_rows(values, &along_u), clamp, &along_u)
        });
        (0..mu * self.to.1).map(|k| kinds[k / mu % 2][k]).collect()
    }

    /// Old rows of a layer with shifted odd rows, evaluated at `along_u`, in cells from the end of
    /// the sheet.
    fn shifted_rows(&self, values: &Vectors, along_u: &[f64]) -> Vec<DVec3> {
        let (nu, nv) = self.from;
        // Only every other row has a node at an end of the sheet; the others get a point on the
        // curve through these nodes.
        let end = |odd: usize, column: usize| {
            let points: Vec<DVec3> = (odd..nv).step_by(2).map(|j| values.get(j * nu + column)).collect();
            let at: Vec<f64> = (0..nv).map(|j| 0.5 * (j as f64 - odd as f64)).collect();
            let mut curve = Vec::with_capacity(nv);
            if points.len() > 1 {
                evaluate_spline(&points, [None; 2], &[], &at, &mut curve);
            }
            curve
        };
        let (first, last) = (end(0, 0), end(1, nu - 1));
        let mut rows = Vec::with_capacity(along_u.len() * nv);
        for j in 0..nv {
            let shift = if j % 2 == 1 { 0.5 } else { 0.0 };
            let mut knots: Vec<f64> = (0..nu).map(|i| i as f64 + shift).collect();
            let mut points: Vec<DVec3> = (0..nu).map(|i| values.get(j * nu + i)).collect();
            match (j % 2, first.get(j), last.get(j)) {
                (1, Some(end), _) => {
                    knots.insert(0, 0.0);
                    points.insert(0, *end);
                }
                (0, _, Some(end)) => {
                    knots.push(nu as f64 - 0.5);
                    points.push(*end);
                }
                _ => {}
            }
            evaluate_uneven_spline(&knots, &points, along_u, &mut rows);
        }
        rows
    }

    fn is_clamped(&self, i: usize, j: usize) -> bool {
        self.clamped[j * self.from.0 + i]
    }

    /// Old rows of a grid, evaluated at `along_u` (cells).
    fn rows(&self, values: &Vectors, clamp: [DVec3; 2], along_u: &[f64]) -> Vec<DVec3> {
        let (nu, nv) = self.from;
        let mut rows = Vec::with_capacity(along_u.len() * nv);
        for j in 0..nv {
            let points: Vec<DVec3> = (0..nu).map(|i| values.get(j * nu + i)).collect();
            evaluate_spline(
                &points,
                [self.is_clamped(0, j).then_some(clamp[0]), self.is_clamped(nu - 1, j).then_some(clamp[0])],
                &self.folds.columns,
                along_u,
                &mut rows,
            );
        }
        rows
    }

    /// Columns through `rows`, evaluated at the new rows.
    fn columns(&self, rows: &[DVec3], clamp: [DVec3; 2], along_u: &[f64]) -> Vec<DVec3> {
        let ((nu, nv), (mu, mv)) = (self.from, self.to);
        let along_v = places(nv, mv);
        let mut all = vec![DVec3::ZERO; mu * mv];
        let mut column = Vec::with_capacity(mv);
        for (i, place) in along_u.iter().enumerate() {
            let points: Vec<DVec3> = (0..nv).map(|j| rows[j * mu + i]).collect();
            // A column is clamped where the nodes on both sides are.
            let beside = [place.floor() as usize, place.ceil() as usize].map(|i| i.min(nu - 1));
            let at = |j: usize| beside.iter().all(|i| self.is_clamped(*i, j));
            column.clear();
            let ends = [at(0).then_some(clamp[1]), at(nv - 1).then_some(clamp[1])];
            evaluate_spline(&points, ends, &self.folds.rows, &along_v, &mut column);
            column.iter().enumerate().for_each(|(j, p)| all[j * mu + i] = *p);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(nu: usize, nv: usize, f: impl Fn(f64, f64) -> DVec3) -> Vectors {
        let mut all = Vectors::default();
        for j in 0..nv {
            for i in 0..nu {
                all.push(f(i as f64 / (nu - 1) as f64, j as f64 / (nv - 1) as f64));
            }
        }
        all
    }

    #[test]
    fn a_cubic_surface_is_exact_and_nodes_are_exact_to_the_bit() {
        let f = |u: f64, v: f64| DVec3::new(u, u * u * u - v * u * 0.3, v + 0.2 * v * v * v);
        let (from, to) = ((6, 5), (11, 9));
        let clamped = [false; 30];
        let surface = SplineSurface { from, to, clamped: &clamped, staggered: false, folds: &CreaseLines::default() };
        let read = surface.interpolate(&grid(6, 5, f), [DVec3::ZERO; 2]);
        let wanted = grid(11, 9, f);
        for (i, p) in read.iter().enumerate() {
            assert!(p.distance(wanted.get(i)) < 1e-14, "{i}: {p}, not {}", wanted.get(i));
        }
        let own = grid(6, 5, |u, v| f(u, v) + DVec3::splat(0.1));
        let there = SplineSurface { from, to, clamped: &clamped, staggered: false, folds: &CreaseLines::default() }
            .interpolate(&own, [DVec3::ZERO; 2]);
        for j in 0..5 {
            for i in 0..6 {
                assert_eq!(there[2 * j * 11 + 2 * i], own.get(j * 6 + i));
            }
        }
    }

    #[test]
    fn shifted_rows_reproduce_a_cubic() {
        let layer = |nu: usize, nv: usize| -> Vec<(f64, f64)> {
            let place = |k: usize| {
                let shift = if k / nu % 2 == 1 { 0.5 } else { 0.0 };
                (((k % nu) as f64 + shift) / (nu as f64 - 0.5), (k / nu) as f64 / (nv - 1) as f64)
            };
            (0..nu * nv).map(place).collect()
        };
        let f = |(u, v): (f64, f64)| DVec3::new(u, u * u * u - v * u * 0.3, v + 0.2 * v * v * v);
        let mut own = Vectors::default();
        layer(7, 8).into_iter().for_each(|p| own.push(f(p)));
        let read = SplineSurface {
            from: (7, 8),
            to: (12, 9),
            clamped: &[false; 56],
            staggered: true,
            folds: &CreaseLines::default(),
        };
        for (p, place) in read.interpolate(&own, [DVec3::ZERO; 2]).iter().zip(layer(12, 9)) {
            assert!(p.distance(f(place)) < 1e-13, "{place:?}: {p}");
        }
    }

    #[test]
    fn a_clamped_row_has_the_slope_of_the_clamp() {
        // w = u² from a flat clamp, on four nodes: the first half cell shows an error of the slope.
        let own = grid(4, 2, |u, v| DVec3::new(u, u * u, v));
        let clamped: Vec<bool> = (0..8).map(|i| i % 4 == 0).collect();
        let read = SplineSurface {
            from: (4, 2),
            to: (7, 2),
            clamped: &clamped,
            staggered: false,
            folds: &CreaseLines::default(),
        };
        let read = read.interpolate(&own, [DVec3::X / 3.0, DVec3::ZERO]);
        assert!((read[1].y - 1.0 / 36.0).abs() < 1e-14, "{}", read[1].y);
    }

    #[test]
    fn few_nodes_are_joined_by_lines_and_parabolas() {
        let own = grid(3, 2, |u, v| DVec3::new(u, u * u, v));
        let read = SplineSurface {
            from: (3, 2),
            to: (5, 3),
            clamped: &[false; 6],
            staggered: false,
            folds: &CreaseLines::default(),
        }
        .interpolate(&own, [DVec3::ZERO; 2]);
        assert!(
            (read[1].y - 1.0 / 16.0).abs() < 1e-15 && (read[6] - DVec3::new(0.25, 1.0 / 16.0, 0.5)).length() < 1e-15
        );
    }

    #[test]
    fn a_crease_stays_sharp() {
        // A roof of two parabolas with a crease along its third column.
        let roof = |u: f64, v: f64| DVec3::new(u, (u - 0.4).abs() + (u - 0.4) * (u - 0.4), v);
        let folds = CreaseLines { columns: vec![2], rows: vec![] };
        let read = SplineSurface { from: (6, 2), to: (11, 2), clamped: &[false; 12], staggered: false, folds: &folds };
        let read = read.interpolate(&grid(6, 2, roof), [DVec3::ZERO; 2]);
        for (i, p) in read.iter().take(11).enumerate() {
            assert!(p.distance(roof(i as f64 / 10.0, 0.0)) < 1e-14, "{i}: {p}");
        }
    }
}
