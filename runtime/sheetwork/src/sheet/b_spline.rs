//! Clamped B-spline weights of a row of control points (Piegl and Tiller, *The NURBS Book*, 1997,
//! algorithm A2.2).
//!
//! The thesis draws a NURBS surface whose control points are the nodes, with weights of 1, which is
//! a B-spline surface (its 2.3). Such a surface does not pass through the nodes: where control
//! points have a second difference δ along a row, a uniform cubic lies δ/6 from them, towards the
//! inside of the bend. It lies in the convex hull of its nodes.
//!
//! Knots are uniform between the ends, and as many at both ends as make the curve end at the first
//! and the last node.

use crate::sheet::smooth_surface::NodeWeights;

/// Weights at `place`, 0 at the first and 1 at the last of the control points `first` to `last`, of
/// a curve of `degree` (reduced for fewer points than it needs).
pub(crate) fn clamped_b_spline(place: f64, first: u32, last: u32, degree: u32) -> NodeWeights {
    let points = (last - first + 1) as usize;
    let degree = (degree as usize).min(points - 1);
    let spans = points - degree;
    let u = place.clamp(0.0, 1.0) * spans as f64;
    let span = (u.floor() as usize).min(spans - 1);
    // Knot i is the i-th of degree + 1 zeros, the whole numbers, and degree + 1 ends.
    let knot = |i: usize| i.saturating_sub(degree).min(spans) as f64;
    let mut basis = vec![0.0; degree + 1];
    basis[0] = 1.0;
    for j in 1..=degree {
        let mut saved = 0.0;
        for r in 0..j {
            let (right, left) = (knot(span + degree + r + 1) - u, u - knot(span + degree + r + 1 - j));
            let part = basis[r] / (right + left);
            basis[r] = saved + right * part;
            saved = left * part;
        }
        basis[j] = saved;
    }
    basis.into_iter().enumerate().map(|(i, weight)| (first + (span + i) as u32, weight)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value at node coordinate `u` of `n` control points with heights `f`.
    fn value(u: f64, n: u32, degree: u32, f: impl Fn(f64) -> f64) -> f64 {
        let weights = clamped_b_spline(u / f64::from(n - 1), 0, n - 1, degree);
        assert!(weights.iter().all(|w| w.1 >= -1e-15), "inside the hull");
        weights.iter().map(|(i, w)| w * f(f64::from(*i))).sum()
    }

    #[test]
    fn weights_sum_to_one_and_the_curve_ends_at_its_end_points() {
        for n in 2..12 {
            for degree in [3, 23] {
                for k in 0..=20 {
                    let u = f64::from(n - 1) * f64::from(k) / 20.0;
                    assert!((value(u, n, degree, |_| 1.0) - 1.0).abs() < 1e-12);
                }
                assert!(value(0.0, n, degree, |x| x).abs() < 1e-12);
                assert!((value(f64::from(n - 1), n, degree, |x| x) - f64::from(n - 1)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_bezier_curve_of_four_points_is_that_of_bernstein() {
        let t: f64 = 0.3;
        let wanted = [0.343, 0.441, 0.189, 0.027];
        for (found, wanted) in clamped_b_spline(t, 5, 8, 3).iter().zip(wanted) {
            assert!((found.1 - wanted).abs() < 1e-12);
        }
        assert_eq!(clamped_b_spline(t, 5, 8, 3)[0].0, 5);
    }
}
