//! Interpolation of values on points in rows: nodes of a lattice layer, cells, or springs of one
//! kind.
//!
//! The odd rows of a triangular layer are shifted by half a cell, so the points form no grid. A
//! value at (u, v) is the weighted mean under a hat function along u in each row, and then under a
//! hat function along v over the rows. Hats as wide as the spacing make this linear interpolation.
//! Beyond the outermost point the value is constant.

use std::collections::BTreeMap;

/// Distance relative to the sheet below which rows are one.
const SAME_ROW_TOLERANCE: f64 = 1e-9;

/// Values with their points, 0 to 1 over the sheet: rows ascending in v, and points of each
/// ascending in u.
pub(crate) struct RowInterpolation<const K: usize> {
    rows: Vec<ValueRow<K>>,
}

struct ValueRow<const K: usize> {
    v: f64,
    u: Vec<f64>,
    values: Vec<[f64; K]>,
}

impl<const K: usize> RowInterpolation<K> {
    /// Sort values at points (u, v), given in any order.
    pub fn new(points: impl Iterator<Item = ((f64, f64), [f64; K])>) -> Self {
        let mut points: Vec<_> = points.collect();
        points.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
        let mut rows = Vec::new();
        for own in points.chunk_by_mut(|a, b| b.0.1 - a.0.1 < SAME_ROW_TOLERANCE) {
            own.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
            let (u, values) = own.iter().map(|((u, _), value)| (*u, *value)).unzip();
            rows.push(ValueRow { v: own[0].0.1, u, values });
        }
        Self { rows }
    }

    /// Value at `at` under hats of half widths `width` along u and v; `None` without any value.
    pub fn interpolate(&self, at: (f64, f64), width: (f64, f64)) -> Option<[f64; K]> {
        let v: Vec<f64> = self.rows.iter().map(|r| r.v).collect();
        let mut sum = [0.0; K];
        for (j, b) in hat(&v, at.1, width.1) {
            let row = &self.rows[j];
            for (i, a) in hat(&row.u, at.0, width.0) {
                sum.iter_mut().zip(&row.values[i]).for_each(|(s, x)| *s += a * b * x);
            }
        }
        (!self.rows.is_empty()).then_some(sum)
    }
}

/// Interpolations of values of several kinds. A kind is a group and a direction.
pub(crate) struct KindInterpolation<G, const N: usize, const K: usize> {
    kinds: BTreeMap<(G, [i32; N]), RowInterpolation<K>>,
}

impl<G: Ord + Copy, const N: usize, const K: usize> KindInterpolation<G, N, K> {
    /// Sort values by kind, and those of each by their points (u, v).
    pub fn new(points: impl Iterator<Item = ((G, [i32; N]), (f64, f64), [f64; K])>) -> Self {
        let mut kinds: BTreeMap<_, Vec<_>> = BTreeMap::new();
        points.for_each(|(kind, at, value)| kinds.entry(kind).or_default().push((at, value)));
        Self { kinds: kinds.into_iter().map(|(kind, of)| (kind, RowInterpolation::new(of.into_iter()))).collect() }
    }

    /// [`RowInterpolation::interpolate`] for a kind, or else for the one of its group with the
    /// nearest direction.
    pub fn interpolate(&self, kind: (G, [i32; N]), at: (f64, f64), width: (f64, f64)) -> Option<[f64; K]> {
        let apart =
            |k: &[i32; N]| k.iter().zip(&kind.1).map(|(a, b)| (i64::from(*a) - i64::from(*b)).pow(2)).sum::<i64>();
        let alike = || self.kinds.iter().filter(|(k, _)| k.0 == kind.0);
        let rows = self.kinds.get(&kind).or_else(|| alike().min_by_key(|(k, _)| apart(&k.1)).map(|(_, rows)| rows))?;
        rows.interpolate(at, width)
    }
}

/// Indices of ascending `places` under a hat about `at`, with weights that sum to 1; the nearest
/// one if none is under it.
fn hat(places: &[f64], at: f64, width: f64) -> Vec<(usize, f64)> {
    let first = places.partition_point(|p| *p <= at - width);
    let weight = |p: f64| (1.0 - (p - at).abs() / width).max(0.0);
    let under = places.iter().enumerate().skip(first).take_while(|(_, p)| **p < at + width);
    let mut all: Vec<(usize, f64)> = under.map(|(i, p)| (i, weight(*p))).filter(|w| w.1 > SAME_ROW_TOLERANCE).collect();
    let whole: f64 = all.iter().map(|w| w.1).sum();
    if all.is_empty() {
        let far = |i: &usize| (places[*i] - at).abs();
        all.extend((0..places.len()).min_by(|a, b| far(a).total_cmp(&far(b))).map(|i| (i, 1.0)));
    } else {
        all.iter_mut().for_each(|w| w.1 /= whole);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangular layer of spacing 0.2 and 0.25.
    fn places() -> Vec<(f64, f64)> {
        (0..25_u8).map(|k| (0.2 * f64::from(k % 5) + 0.1 * f64::from(k / 5 % 2), 0.25 * f64::from(k / 5))).collect()
    }

    #[test]
    fn linear_values_are_exact_within_shifted_rows() {
        let f = |(u, v): (f64, f64)| [2.0 * u - v, 0.3 + v];
        let rows = RowInterpolation::new(places().into_iter().rev().map(|p| (p, f(p))));
        for at in [(0.1, 0.0), (0.33, 0.4), (0.8, 1.0), (0.5, 0.77)] {
            let read = rows.interpolate(at, (0.2, 0.25)).expect("known");
            assert!((read[0] - f(at)[0]).abs() < 1e-12 && (read[1] - f(at)[1]).abs() < 1e-12, "{at:?}: {read:?}");
        }
    }

    #[test]
    fn values_stay_in_range_and_constants_are_exact() {
        let rows = RowInterpolation::new(places().into_iter().map(|p| (p, [p.0, 4.0])));
        for k in 0..100_u8 {
            let at = (f64::from(k % 10) / 9.0, f64::from(k / 10) / 9.0);
            let read = rows.interpolate(at, (0.5, 0.3)).expect("known");
            assert!((0.0..=0.9).contains(&read[0]) && (read[1] - 4.0).abs() < 1e-12, "{read:?}");
        }
        assert!(RowInterpolation::<1>::new(std::iter::empty()).interpolate((0.5, 0.5), (1.0, 1.0)).is_none());
    }
}
