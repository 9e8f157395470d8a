//! Distances between points, segments and triangles, m (Ericson, Real-Time Collision Detection,
//! 2005, 5.1.5 and 5.1.9).

use glam::DVec3;

/// Distance from `p` to a triangle, m.
pub fn point_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let squared = normal.length_squared();
    if squared > 0.0 {
        // Barycentric coordinates of the foot of the perpendicular.
        let v = ap.cross(ac).dot(normal) / squared;
        let w = ab.cross(ap).dot(normal) / squared;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return ap.dot(normal).abs() / squared.sqrt();
        }
    }
    point_segment(p, a, b).min(point_segment(p, b, c)).min(point_segment(p, c, a))
}

fn point_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let length = d.length_squared();
    let s = if length > 0.0 { ((p - a).dot(d) / length).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + d * s)
}

/// Distance between two segments, m.
pub fn segments([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let ends = point_segment(a, c, d).min(point_segment(b, c, d));
    let ends = ends.min(point_segment(c, a, b)).min(point_segment(d, a, b));
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let parallel = uu * vv - uv * uv;
    if parallel <= 1e-12 * uu * vv {
        return ends;
    }
    let s = (uv * vw - vv * uw) / parallel;
    let t = (uu * vw - uv * uw) / parallel;
    if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) { (w + u * s - v * t).length() } else { ends }
}

/// Distance between two triangles, m; 0 if they intersect.
pub fn triangles(p: &[DVec3; 3], q: &[DVec3; 3]) -> f64 {
    let edges = |t: &[DVec3; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    if edges(p).into_iter().any(|e| pierces(e, q)) || edges(q).into_iter().any(|e| pierces(e, p)) {
        return 0.0;
    }
    let points = p.iter().map(|v| point_triangle(*v, *q)).chain(q.iter().map(|v| point_triangle(*v, *p)));
    let pairs = edges(p).into_iter().flat_map(|e| edges(q).map(|f| segments(e, f)));
    points.chain(pairs).fold(f64::INFINITY, f64::min)
}

/// Whether a segment pierces a triangle.
pub fn pierces([a, b]: [DVec3; 2], [p, q, r]: &[DVec3; 3]) -> bool {
    let normal = (*q - *p).cross(*r - *p);
    let (before, after) = ((a - *p).dot(normal), (b - *p).dot(normal));
    if before * after >= 0.0 {
        return false;
    }
    let at = a + (b - a) * (before / (before - after));
    let inside = |u: DVec3, v: DVec3| (v - u).cross(at - u).dot(normal) >= 0.0;
    inside(*p, *q) && inside(*q, *r) && inside(*r, *p)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Z];

    #[test]
    fn distances_agree_with_hand_calculation() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        near(point_triangle(DVec3::new(0.2, 0.5, 0.3), TRIANGLE), 0.5);
        near(point_triangle(DVec3::new(-0.3, 0.4, 0.5), TRIANGLE), 0.5);
        near(point_triangle(DVec3::new(1.0, 0.0, 1.0), TRIANGLE), 0.5_f64.sqrt());
        near(segments([DVec3::ZERO, DVec3::X], [DVec3::new(0.5, 0.2, -1.0), DVec3::new(0.5, 0.2, 1.0)]), 0.2);
        near(segments([DVec3::ZERO, DVec3::X], [DVec3::new(2.0, 0.0, 0.0), DVec3::new(3.0, 0.0, 0.0)]), 1.0);
        let above = TRIANGLE.map(|p| p + DVec3::new(0.1, 0.25, 0.1));
        near(triangles(&TRIANGLE, &above), 0.25);
        let across = [DVec3::new(0.2, -1.0, 0.2), DVec3::new(0.3, 1.0, 0.2), DVec3::new(0.2, 1.0, 0.3)];
        near(triangles(&TRIANGLE, &across), 0.0);
    }
}
