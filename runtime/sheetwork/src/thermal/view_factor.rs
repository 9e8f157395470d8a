//! View factor of a plane polygon from a small patch: fraction of the patch's diffuse radiation
//! that reaches the polygon.
//!
//! Lambert's contour sum, with r_i the corners relative to the patch, n its normal, and the part
//! below its horizon clipped,
//!
//!   F = 1/2π |Σ Θ_i n·(r_i × r_{i+1})/|r_i × r_{i+1}||, Θ_i the angle between r_i and r_{i+1}.
//!
//! Exact for any plane polygon, convex or concave, above the horizon or clipped by it (J. R.
//! Howell, M. P. Mengüç, R. Siegel, *Thermal Radiation Heat Transfer*, 2010, chapter 5; catalogue
//! factors C-11 to C-15).

use std::f64::consts::TAU;

use glam::DVec3;

/// View factor, 0 to 1, of the polygon with these `corners` (m, either orientation) from a patch at
/// `point` (m) with normal `normal` (any length but 0).
pub fn view_factor(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    contour(corners, point, normal.normalize_or_zero()).abs().min(1.0)
}

/// Contour sum for a unit `normal`: positive where the corners run clockwise seen from the patch.
/// patch.
pub(crate) fn contour(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let mut sum = 0.0;
    let Some(last) = corners.last() else { return sum };
    let mut from = *last - point;
    let mut height = from.dot(normal);
    // Point at which the outline went below the horizon, until it rises again; and the point of its
    // first rise.
    // first.
    let (mut down, mut up): (Option<DVec3>, Option<DVec3>) = (None, None);
    for corner in corners {
        let to = *corner - point;
        let next = to.dot(normal);
        let crossing = || from + (to - from) * (height / (height - next));
        match (height > 0.0, next > 0.0) {
            (true, true) => sum += edge(from, to, normal),
            (true, false) => {
                let at = crossing();
                sum += edge(from, at, normal);
                down = Some(at);
            }
            (false, true) => {
                let at = crossing();
                match down.take() {
                    Some(left) => sum += edge(left, at, normal),
                    None => up = Some(at),
                }
                sum += edge(at, to, normal);
            }
            (false, false) => {}
        }
        (from, height) = (to, next);
    }
    if let (Some(left), Some(at)) = (down, up) {
        sum += edge(left, at, normal);
    }
    sum / TAU
}

/// Θ n·(a × b)/|a × b|.
#[inline]
fn edge(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let across = a.cross(b);
    let length = across.length();
    // The edge is seen as a point: towards an end of it, or along it.
    if length <= 1e-300 {
        return 0.0;
    }
    length.atan2(a.dot(b)) * across.dot(normal) / length
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: f64, at: f64) -> Vec<DVec3> {
        let h = 0.5 * side;
        [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, z)| DVec3::new(x, at, z)).to_vec()
    }

    /// View factor by summation: integral of cos cos/π r² over small squares, above the horizon.
    fn summed(corner: DVec3, u: DVec3, v: DVec3, point: DVec3, normal: DVec3, parts: usize) -> f64 {
        let area = u.cross(v) / (parts * parts) as f64;
        let mut sum = 0.0;
        for i in 0..parts {
            for j in 0..parts {
                let at = |k: usize| (k as f64 + 0.5) / parts as f64;
                let r = corner + u * at(i) + v * at(j) - point;
                let (d2, height) = (r.length_squared(), r.dot(normal));
                if height > 0.0 {
                    sum += height * area.dot(r).abs() / (std::f64::consts::PI * d2 * d2);
                }
            }
        }
        sum
    }

    #[test]
    fn a_square_overhead_is_as_tabled() {
        for (distance, wanted) in [(1.0, 0.239_456), (0.1, 0.968_340), (5.0, 0.012_565)] {
            let found = view_factor(&square(1.0, distance), DVec3::ZERO, DVec3::Y * 3.0);
            assert!((found - wanted).abs() < 1e-6, "{found} at {distance}");
        }
    }

    #[test]
    fn a_rectangle_at_its_corner_has_the_closed_forms() {
        // Howell's C-11: patch parallel to a rectangle a x b at distance c, under a corner.
        let (a, b, c) = (0.7_f64, 1.9_f64, 0.4_f64);
        let (x, y) = (a / c, b / c);
        let root = |s: f64| (1.0 + s * s).sqrt();
        let wanted = (x / root(x) * (y / root(x)).atan() + y / root(y) * (x / root(y)).atan()) / TAU;
        let corners = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)].map(|(p, q)| DVec3::new(p, c, q));
        assert!((view_factor(&corners, DVec3::ZERO, DVec3::Y) - wanted).abs() < 1e-14);
        // C-12: patch square to the rectangle's plane, at its corner.
        let (x, y) = (a / b, c / b);
        let wanted = ((1.0 / y).atan() - y / (x * x + y * y).sqrt() * (1.0 / (x * x + y * y).sqrt()).atan()) / TAU;
        let corners = [(0.0, 0.0), (b, 0.0), (b, a), (0.0, a)].map(|(p, q)| DVec3::new(p, q, c));
        assert!((view_factor(&corners, DVec3::ZERO, DVec3::Y) - wanted).abs() < 1e-14);
    }

    #[test]
    fn the_part_below_the_horizon_has_no_view_factor() {
        let normals = [DVec3::Y, DVec3::new(1.0, 0.2, 0.3), DVec3::new(-0.4, 0.1, 1.0), DVec3::new(0.3, -0.9, 0.2)];
        for normal in normals.map(DVec3::normalize) {
            for height in [0.3, 1.0] {
                let point = DVec3::new(0.2, 0.0, -0.1);
                let found = view_factor(&square(1.0, height), point, normal);
                let wanted = summed(DVec3::new(-0.5, height, -0.5), DVec3::X, DVec3::Z, point, normal, 2000);
                assert!((found - wanted).abs() < 3e-6, "{found}, not {wanted}: {normal}");
            }
        }
        assert_eq!(view_factor(&square(1.0, 1.0), DVec3::ZERO, DVec3::NEG_Y), 0.0);
        // A square seen edge-on has the view factor of its upper half.
        let whole = view_factor(
            &[(0.5, -1.0), (0.5, 1.0), (-0.5, 1.0), (-0.5, -1.0)].map(|(x, y)| DVec3::new(x, y, 1.0)),
            DVec3::ZERO,
            DVec3::Y,
        );
        let half = view_factor(
            &[(0.5, 0.0), (0.5, 1.0), (-0.5, 1.0), (-0.5, 0.0)].map(|(x, y)| DVec3::new(x, y, 1.0)),
            DVec3::ZERO,
            DVec3::Y,
        );
        assert!((whole - half).abs() < 1e-15);
    }

    #[test]
    fn parts_add_up_and_a_hollow_polygon_is_the_sum_of_its_parts() {
        let normal = DVec3::new(0.5, 0.6, 0.1).normalize();
        let at = |list: &[(f64, f64)]| {
            let corners: Vec<DVec3> = list.iter().map(|(x, z)| DVec3::new(*x, 0.4, *z)).collect();
            view_factor(&corners, DVec3::ZERO, normal)
        };
        // An L, clipped by the horizon, and its two rectangles.
        let l = at(&[(-2.0, -1.0), (1.0, -1.0), (1.0, 0.0), (-1.5, 0.0), (-1.5, 2.0), (-2.0, 2.0)]);
        let parts = at(&[(-2.0, -1.0), (1.0, -1.0), (1.0, 0.0), (-2.0, 0.0)])
            + at(&[(-2.0, 0.0), (-1.5, 0.0), (-1.5, 2.0), (-2.0, 2.0)]);
        assert!((l - parts).abs() < 1e-15, "{l}, not {parts}");
        // The view factors of a closed box add up to 1.
        let mut sum = 0.0;
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let turn = |x: f64, y: f64| {
                    let mut p = [0.0; 3];
                    p[axis] = 1.5 * side;
                    p[(axis + 1) % 3] = x * 1.5;
                    p[(axis + 2) % 3] = y * 1.5;
                    DVec3::from_array(p)
                };
                let face = [turn(-1.0, -1.0), turn(1.0, -1.0), turn(1.0, 1.0), turn(-1.0, 1.0)];
                sum += view_factor(&face, DVec3::new(0.3, -0.7, 1.1), normal);
            }
        }
        assert!((sum - 1.0).abs() < 1e-14, "{sum}");
    }
}
