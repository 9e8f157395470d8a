//! Intersection test of two triangles: an edge of one pierces the other.

use glam::DVec3;

/// Whether two triangles intersect. Triangles that touch at a corner or along an edge, or that are
/// coplanar, do not count.
pub fn triangles_intersect(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let over_q = heights(q, p);
    if is_one_sided(over_q) {
        return false;
    }
    let over_p = heights(p, q);
    !is_one_sided(over_p) && (pierces(p, over_q, q) || pierces(q, over_p, p))
}

/// Heights of points above the plane of a triangle, times twice its area, m³.
fn heights([a, b, c]: [DVec3; 3], points: [DVec3; 3]) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    points.map(|x| normal.dot(x - a))
}

fn is_one_sided(heights: [f64; 3]) -> bool {
    heights.iter().all(|h| *h >= 0.0) || heights.iter().all(|h| *h <= 0.0)
}

/// Whether an edge of `p` pierces `q`; `heights` are those of the corners of `p` above `q`.
fn pierces(p: [DVec3; 3], heights: [f64; 3], q: [DVec3; 3]) -> bool {
    let normal = (q[1] - q[0]).cross(q[2] - q[0]);
    (0..3).any(|k| {
        let (from, to) = (heights[k], heights[(k + 1) % 3]);
        from * to < 0.0 && {
            let x = p[k].lerp(p[(k + 1) % 3], from / (from - to));
            (0..3).all(|e| normal.dot((q[(e + 1) % 3] - q[e]).cross(x - q[e])) > 0.0)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT_FRACTION: [DVec3; 3] = [DVec3::ZERO, DVec3::Z, DVec3::X];

    #[test]
    fn a_triangle_that_stands_in_another_cuts_it_and_one_that_stands_on_it_does_not() {
        let standing = |y: f64| [DVec3::new(0.2, y, 0.2), DVec3::new(0.3, y + 1.0, 0.2), DVec3::new(0.2, y + 1.0, 0.3)];
        for (y, cuts) in [(-0.1, true), (0.0, false), (0.1, false), (-1.1, false)] {
            assert_eq!(triangles_intersect(standing(y), FLAT_FRACTION), cuts, "{y}");
            assert_eq!(triangles_intersect(FLAT_FRACTION, standing(y)), cuts, "{y}");
        }
    }

    #[test]
    fn a_triangle_beside_another_or_in_its_plane_does_not_cut_it() {
        let beside = [DVec3::new(0.8, -0.1, 0.8), DVec3::new(0.8, 0.1, 0.8), DVec3::new(0.9, 0.1, 0.9)];
        assert!(!triangles_intersect(beside, FLAT_FRACTION) && !triangles_intersect(FLAT_FRACTION, beside));
        assert!(!triangles_intersect(FLAT_FRACTION, FLAT_FRACTION.map(|x| x + DVec3::new(0.1, 0.0, 0.1))));
    }

    /// One edge of the upper triangle passes inside the lower one and the other outside, so that
    /// the border of the lower triangle pierces the upper one.
    #[test]
    fn a_corner_that_goes_in_over_the_border_is_seen_from_both() {
        let over = [DVec3::new(-0.2, -0.2, 0.3), DVec3::new(0.8, 0.3, 0.3), DVec3::new(-0.2, 0.5, 0.4)];
        assert!(triangles_intersect(over, FLAT_FRACTION) && triangles_intersect(FLAT_FRACTION, over));
    }
}
