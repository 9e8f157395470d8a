//! A smooth surface through the masses of a grid, to be read at the masses of another.
//!
//! Rows along u are cubic splines through their masses, and so are columns through what those give: of all smooth curves through the
//! masses the one that bends least. At a clamped end the slope is the clamp's; at a free one the curve goes on as the two pieces next to the
//! end do (not-a-knot), since a sheet that is made bent is bent up to its edge; so they do on both sides of a crease. What lies at a mass is that mass to the bit. Rows of a triangular
//! layer are shifted by half a cell in turn: each goes on to the end of the sheet, where curves through the ends of the others have it.

use glam::DVec3;

use crate::math::Vectors;
use crate::sheet::surface::Folds;

/// Nearer to a mass than this, in cells, is at it.
const AT: f64 = 1e-9;

/// Derivatives (per cell) that are prescribed at the two ends of a row.
type Ends = [Option<DVec3>; 2];

/// Places of `to` evenly spaced points on a row of `from`, in cells.
pub(crate) fn places(from: usize, to: usize) -> Vec<f64> {
    let step = (from - 1) as f64 / (to - 1) as f64;
    (0..to).map(|i| if i + 1 == to { (from - 1) as f64 } else { i as f64 * step }).collect()
}

/// Derivatives per cell of the spline through `points`, two or more.
fn slopes(points: &[DVec3], ends: Ends) -> Vec<DVec3> {
    let n = points.len();
    let rise = |i: usize| points[i + 1] - points[i];
    if n < 4 {
        return short(points, ends);
    }
    // m₋ + 4 m + m₊ = 3 (p₊ - p₋) within; at an end the slope, or m₀ + 2 m₁ = (5 Δ₀ + Δ₁)/2.
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

/// The same of two or three points: a line or a parabola, but for slopes that are prescribed.
fn short(points: &[DVec3], ends: Ends) -> Vec<DVec3> {
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

/// The spline through `points` at `at`, in cells; it is folded at each of `folds`, where two splines end.
fn row(points: &[DVec3], ends: Ends, folds: &[u32], at: &[f64], out: &mut Vec<DVec3>) {
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
        if (place - near).abs() < AT {
            out.push(points[near as usize]);
            continue;
        }
        let i = (place.floor() as usize).min(last - 1);
        let t = place - i as f64;
        let (t2, t3) = (t * t, t * t * t);
        let (h01, h10, h11) = (3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2);
        out.push(points[i].lerp(points[i + 1], h01) + pieces[i][0] * h10 + pieces[i][1] * h11);
    }
}

/// The spline through `points` at ascending `knots`, read at `at`; its first two pieces are one cubic, and its last two.
fn uneven_row(knots: &[f64], points: &[DVec3], at: &[f64], out: &mut Vec<DVec3>) {
    let n = points.len();
    let wide = |i: usize| knots[i + 1] - knots[i];
    let rise = |i: usize| (points[i + 1] - points[i]) / wide(i);
    if n < 4 {
        // By Lagrange's polynomial.
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
        let (t2, t3) = (t * t, t * t * t);
        let (h01, h10, h11) = (3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2);
        out.push(points[i].lerp(points[i + 1], h01) + (slopes[i] * h10 + slopes[i + 1] * h11) * wide(i));
    }
}

/// A grid of masses to be read at another.
pub(crate) struct Surface<'a> {
    /// Masses along u and v there were, and there are to be.
    pub from: (usize, usize),
    pub to: (usize, usize),
    /// Which masses are clamped.
    pub clamped: &'a [bool],
    /// Whether odd rows are shifted by half a cell along u.
    pub staggered: bool,
    /// Columns and rows along which it is creased.
    pub folds: &'a Folds,
}

impl Surface<'_> {
    /// `values` at the masses of the other grid; `clamp` is what they change by from cell to cell along u and v where a clamp holds them.
    pub fn read(&self, values: &Vectors, clamp: [DVec3; 2]) -> Vec<DVec3> {
        let (nu, mu) = (self.from.0, self.to.0);
        if !self.staggered {
            let along_u = places(nu, mu);
            return self.columns(&self.rows(values, clamp, &along_u), clamp, &along_u);
        }
        // New rows that are shifted lie between others on all old ones: each kind is read by itself, and its own rows taken.
        let step = (nu as f64 - 0.5) / (mu as f64 - 0.5);
        let kinds = [0.0, 0.5].map(|shift| {
            let along_u: Vec<f64> = (0..mu).map(|i| (i as f64 + shift) * step).collect();
            self.columns(&self.shifted_rows(values, &along_u), clamp, &along_u)
        });
        (0..mu * self.to.1).map(|k| kinds[k / mu % 2][k]).collect()
    }

    /// All old rows at places `along_u`, in cells from the end of the sheet, of a layer whose odd rows are shifted.
    fn shifted_rows(&self, values: &Vectors, along_u: &[f64]) -> Vec<DVec3> {
        let (nu, nv) = self.from;
        // Every row is brought to both ends of the sheet, where only every other one has a mass: by the curve through those.
        let end = |odd: usize, column: usize| {
            let points: Vec<DVec3> = (odd..nv).step_by(2).map(|j| values.get(j * nu + column)).collect();
            let at: Vec<f64> = (0..nv).map(|j| 0.5 * (j as f64 - odd as f64)).collect();
            let mut curve = Vec::with_capacity(nv);
            if points.len() > 1 {
                row(&points, [None; 2], &[], &at, &mut curve);
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
            uneven_row(&knots, &points, along_u, &mut rows);
        }
        rows
    }

    fn is_clamped(&self, i: usize, j: usize) -> bool {
        self.clamped[j * self.from.0 + i]
    }

    /// The old rows of a grid, at places `along_u` in cells.
    fn rows(&self, values: &Vectors, clamp: [DVec3; 2], along_u: &[f64]) -> Vec<DVec3> {
        let (nu, nv) = self.from;
        let mut rows = Vec::with_capacity(along_u.len() * nv);
        for j in 0..nv {
            let points: Vec<DVec3> = (0..nu).map(|i| values.get(j * nu + i)).collect();
            row(
                &points,
                [self.is_clamped(0, j).then_some(clamp[0]), self.is_clamped(nu - 1, j).then_some(clamp[0])],
                &self.folds.columns,
                along_u,
                &mut rows,
            );
        }
        rows
    }

    /// The columns through `rows`, at the new rows.
    fn columns(&self, rows: &[DVec3], clamp: [DVec3; 2], along_u: &[f64]) -> Vec<DVec3> {
        let ((nu, nv), (mu, mv)) = (self.from, self.to);
        let along_v = places(nv, mv);
        let mut all = vec![DVec3::ZERO; mu * mv];
        let mut column = Vec::with_capacity(mv);
        for (i, place) in along_u.iter().enumerate() {
            let points: Vec<DVec3> = (0..nv).map(|j| rows[j * mu + i]).collect();
            // Clamped where the masses on both sides are.
            let beside = [place.floor() as usize, place.ceil() as usize].map(|i| i.min(nu - 1));
            let at = |j: usize| beside.iter().all(|i| self.is_clamped(*i, j));
            column.clear();
            let ends = [at(0).then_some(clamp[1]), at(nv - 1).then_some(clamp[1])];
            row(&points, ends, &self.folds.rows, &along_v, &mut column);
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
    fn a_cubic_surface_is_read_as_it_is_and_masses_to_the_bit() {
        let f = |u: f64, v: f64| DVec3::new(u, u * u * u - v * u * 0.3, v + 0.2 * v * v * v);
        let (from, to) = ((6, 5), (11, 9));
        let clamped = [false; 30];
        let surface = Surface { from, to, clamped: &clamped, staggered: false, folds: &Folds::default() };
        let read = surface.read(&grid(6, 5, f), [DVec3::ZERO; 2]);
        let wanted = grid(11, 9, f);
        for (i, p) in read.iter().enumerate() {
            assert!(p.distance(wanted.get(i)) < 1e-14, "{i}: {p}, not {}", wanted.get(i));
        }
        let own = grid(6, 5, |u, v| f(u, v) + DVec3::splat(0.1));
        let there = Surface { from, to, clamped: &clamped, staggered: false, folds: &Folds::default() }
            .read(&own, [DVec3::ZERO; 2]);
        for j in 0..5 {
            for i in 0..6 {
                assert_eq!(there[2 * j * 11 + 2 * i], own.get(j * 6 + i));
            }
        }
    }

    #[test]
    fn shifted_rows_are_read_as_a_cubic_is_within_them() {
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
        let read =
            Surface { from: (7, 8), to: (12, 9), clamped: &[false; 56], staggered: true, folds: &Folds::default() };
        for (p, place) in read.read(&own, [DVec3::ZERO; 2]).iter().zip(layer(12, 9)) {
            assert!(p.distance(f(place)) < 1e-13, "{place:?}: {p}");
        }
    }

    #[test]
    fn the_slope_of_a_clamp_is_kept() {
        // w = u² from a clamp that lies flat, on four masses: the error of the first half cell is that of a slope.
        let own = grid(4, 2, |u, v| DVec3::new(u, u * u, v));
        let clamped: Vec<bool> = (0..8).map(|i| i % 4 == 0).collect();
        let read = Surface { from: (4, 2), to: (7, 2), clamped: &clamped, staggered: false, folds: &Folds::default() };
        let read = read.read(&own, [DVec3::X / 3.0, DVec3::ZERO]);
        assert!((read[1].y - 1.0 / 36.0).abs() < 1e-14, "{}", read[1].y);
    }

    #[test]
    fn few_masses_are_joined_by_lines_and_parabolas() {
        let own = grid(3, 2, |u, v| DVec3::new(u, u * u, v));
        let read =
            Surface { from: (3, 2), to: (5, 3), clamped: &[false; 6], staggered: false, folds: &Folds::default() }
                .read(&own, [DVec3::ZERO; 2]);
        assert!(
            (read[1].y - 1.0 / 16.0).abs() < 1e-15 && (read[6] - DVec3::new(0.25, 1.0 / 16.0, 0.5)).length() < 1e-15
        );
    }

    #[test]
    fn a_fold_stays_sharp() {
        // A roof of two parabolas, creased along its third column.
        let roof = |u: f64, v: f64| DVec3::new(u, (u - 0.4).abs() + (u - 0.4) * (u - 0.4), v);
        let folds = Folds { columns: vec![2], rows: vec![] };
        let read = Surface { from: (6, 2), to: (11, 2), clamped: &[false; 12], staggered: false, folds: &folds };
        let read = read.read(&grid(6, 2, roof), [DVec3::ZERO; 2]);
        for (i, p) in read.iter().take(11).enumerate() {
            assert!(p.distance(roof(i as f64 / 10.0, 0.0)) < 1e-14, "{i}: {p}");
        }
    }
}
