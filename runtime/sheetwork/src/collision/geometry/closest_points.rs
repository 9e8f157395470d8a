//! Closest points of points, segments and triangles.
//!
//! Point and triangle: the Voronoi regions of corners, sides and interior are tested in turn.
//! Segment and segment: the minimum of |p₀ + s u - q₀ - t v|² over the unit square, in its interior
//! or on a side (Ericson, Real-Time Collision Detection, 2005, 5.1.5 and 5.1.9). Lengths in m;
//! weights and parameters are dimensionless.

use glam::DVec3;

/// Parameter, 0 to 1, of the point of the segment from `a` to `b` closest to `p`.
#[inline]
pub fn point_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let length = d.length_squared();
    if length > 0.0 { ((p - a).dot(d) / length).clamp(0.0, 1.0) } else { 0.0 }
}

/// Barycentric weights of the point of a triangle closest to `p`. A weight is exactly zero if the
/// point lies on the opposite side, so that the weights identify the closest feature. A degenerate
/// triangle is treated as its three sides.
pub fn point_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0 {
        let w = e / (e + f);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    // A triangle without area has no interior; the closest point of its sides is exact.
    if sum.is_nan() || sum <= 0.0 { closest_of_sides(p, [a, b, c]) } else { [va / sum, vb / sum, vc / sum] }
}

fn closest_of_sides(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (u, v, w) = (point_segment(p, a, b), point_segment(p, b, c), point_segment(p, c, a));
    let sides = [
        (p.distance_squared(a.lerp(b, u)), [1.0 - u, u, 0.0]),
        (p.distance_squared(b.lerp(c, v)), [0.0, 1.0 - v, v]),
        (p.distance_squared(c.lerp(a, w)), [w, 0.0, 1.0 - w]),
    ];
    sides.into_iter().min_by(|x, y| x.0.total_cmp(&y.0)).map_or([1.0, 0.0, 0.0], |x| x.1)
}

/// Parameters (s, t), each 0 to 1, of the closest points of the segments p and q; one of the
/// solutions for parallel segments.
pub fn segment_segment(p: [DVec3; 2], q: [DVec3; 2]) -> (f64, f64) {
    let (u, v, r) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, e, f) = (u.length_squared(), v.length_squared(), v.dot(r));
    if a <= 0.0 {
        return (0.0, point_segment(p[0], q[0], q[1]));
    }
    let c = u.dot(r);
    if e <= 0.0 {
        return ((-c / a).clamp(0.0, 1.0), 0.0);
    }
    let b = u.dot(v);
    let area = a * e - b * b;
    // Below this bound the quotient is rounding noise; any s is valid, since t is fitted to it.
    let s = if area > 1e-14 * a * e { ((b * f - c * e) / area).clamp(0.0, 1.0) } else { 0.0 };
    let t = (b * s + f) / e;
    if t < 0.0 {
        ((-c / a).clamp(0.0, 1.0), 0.0)
    } else if t > 1.0 {
        (((b - c) / a).clamp(0.0, 1.0), 1.0)
    } else {
        (s, t)
    }
}

/// Barycentric weights, of any sign, of the intersection of the line through `p` along `n` with the
/// plane of the triangle; `None` for a line nearly parallel to the plane.
pub fn barycentric_along(p: DVec3, n: DVec3, [a, b, c]: [DVec3; 3]) -> Option<[f64; 3]> {
    let area = (b - a).cross(c - a);
    let whole = area.dot(n);
    // A triangle seen nearly edge-on has no useful weights.
    if whole.is_nan() || whole.abs() < 0.1 * area.length() || whole == 0.0 {
        return None;
    }
    let v = (p - a).cross(c - a).dot(n) / whole;
    let w = (b - a).cross(p - a).dot(n) / whole;
    Some([1.0 - v - w, v, w])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(256))]

        /// The distance is convex in the weights: a point without nearer neighbours is the closest
        /// one.
        #[test]
        fn no_point_of_the_triangle_is_nearer(p in point(), a in point(), b in point(), c in point(),
                                              v in 0.0..1.0, w in 0.0..1.0) {
            let [x, y, z] = point_triangle(p, [a, b, c]);
            prop_assert!(x >= 0.0 && y >= 0.0 && z >= 0.0 && (x + y + z - 1.0).abs() < 1e-12);
            let least = p.distance(a * x + b * y + c * z);
            let (v, w): (f64, f64) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
            prop_assert!(least <= p.distance(a * (1.0 - v - w) + b * v + c * w) + 1e-9);
        }

        #[test]
        fn no_points_of_the_segments_are_nearer(a in point(), b in point(), c in point(), d in point(),
                                                s in 0.0..1.0, t in 0.0..1.0) {
            let (x, y) = segment_segment([a, b], [c, d]);
            prop_assert!((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y));
            prop_assert!(a.lerp(b, x).distance(c.lerp(d, y)) <= a.lerp(b, s).distance(c.lerp(d, t)) + 1e-9);
        }

        #[test]
        fn a_point_seen_along_a_line_lies_on_it(p in point(), n in point(), a in point(), b in point(), c in point()) {
            let n = n.normalize_or(DVec3::Y);
            if let Some([x, y, z]) = barycentric_along(p, n, [a, b, c]) {
                let q = a * x + b * y + c * z;
                prop_assert!((x + y + z - 1.0).abs() < 1e-9);
                prop_assert!((q - p).cross(n).length() < 1e-6 * (1.0 + q.length() + p.length()));
            }
        }
    }

    #[test]
    fn degenerate_shapes_have_closest_points_too() {
        let (o, x) = (DVec3::ZERO, DVec3::X);
        assert_eq!(point_triangle(DVec3::Y, [o, o, o]).iter().sum::<f64>(), 1.0);
        let [_, b, c] = point_triangle(DVec3::new(0.75, 1.0, 0.0), [o, x * 0.5, x]);
        assert!((0.5 * b + c - 0.75).abs() < 1e-12);
        assert_eq!(segment_segment([o, o], [x, x]), (0.0, 0.0));
        // Parallel segments, one above the other.
        let (s, t) = segment_segment([o, x], [DVec3::Y, DVec3::Y + x]);
        assert!((s - t).abs() < 1e-15);
    }
}
