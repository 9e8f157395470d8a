//! Time of impact of a moving point with a moving triangle, and of two moving edges.
//!
//! All four points move along straight lines, x(t) = x₀ + t (x₁ - x₀), 0 ≤ t ≤ 1. An impact
//! requires that they are coplanar: (x₂-x₁) × (x₃-x₁) · (x₄-x₁) = 0, a cubic in t (Provot,
//! Collision and self-collision handling in cloth model dedicated to design garments, 1997, eqs.
//! 2-3; Bridson, Fedkiw, Anderson, Robust treatment of collisions, contact and friction for cloth
//! animation, 2002, eq. 2). The impact is at the earliest root at which the features touch. Points
//! that stay coplanar throughout the motion have no impact here; distance tests cover them.

use glam::DVec3;

use crate::collision::geometry::closest_points::{point_triangle, segment_segment};
use crate::math::cubic::{Roots, roots_in_unit_interval};

/// Impact of a point with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointImpact {
    /// Time of impact, 0 to 1.
    pub time: f64,
    /// Barycentric weights on the triangle.
    pub weights: [f64; 3],
}

/// Impact of two edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeImpact {
    /// Time of impact, 0 to 1.
    pub time: f64,
    /// Parameter on the first edge, 0 to 1.
    pub s: f64,
    /// Parameter on the second edge, 0 to 1.
    pub t: f64,
}

/// Times at which four moving points are coplanar.
fn coplanar(start: [DVec3; 4], end: [DVec3; 4]) -> Roots {
    let at = |i: usize| (start[i] - start[0], (end[i] - end[0]) - (start[i] - start[0]));
    let ((a, da), (b, db), (c, dc)) = (at(1), at(2), at(3));
    let (n0, n1, n2) = (a.cross(b), a.cross(db) + da.cross(b), da.cross(db));
    roots_in_unit_interval([n0.dot(c), n1.dot(c) + n0.dot(dc), n2.dot(c) + n1.dot(dc), n2.dot(dc)])
}

/// Earliest impact of the first point with the triangle of the other three, within `tolerance` (m).
pub fn point_meets_triangle(start: [DVec3; 4], end: [DVec3; 4], tolerance: f64) -> Option<PointImpact> {
    coplanar(start, end).iter().find_map(|time| {
        let [p, a, b, c] = std::array::from_fn(|i| start[i].lerp(end[i], time));
        let weights = point_triangle(p, [a, b, c]);
        let q = a * weights[0] + b * weights[1] + c * weights[2];
        (p.distance(q) <= tolerance).then_some(PointImpact { time, weights })
    })
}

/// Earliest impact of the edge of the first two points with that of the last two, within
/// `tolerance` (m).
pub fn edges_meet(start: [DVec3; 4], end: [DVec3; 4], tolerance: f64) -> Option<EdgeImpact> {
    coplanar(start, end).iter().find_map(|time| {
        let [a, b, c, d] = std::array::from_fn(|i| start[i].lerp(end[i], time));
        let (s, t) = segment_segment([a, b], [c, d]);
        (a.lerp(b, s).distance(c.lerp(d, t)) <= tolerance).then_some(EdgeImpact { time, s, t })
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CLOSE: f64 = 1e-9;

    fn points() -> impl Strategy<Value = [DVec3; 4]> {
        prop::array::uniform12(-1.0..1.0)
            .prop_map(|v| std::array::from_fn(|i| DVec3::new(v[3 * i], v[3 * i + 1], v[3 * i + 2])))
    }

    /// Motions that pass through a given configuration at a given time.
    fn through(at: [DVec3; 4], way: [DVec3; 4], time: f64) -> ([DVec3; 4], [DVec3; 4]) {
        (std::array::from_fn(|i| at[i] - way[i] * time), std::array::from_fn(|i| at[i] + way[i] * (1.0 - time)))
    }

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(256))]

        #[test]
        fn a_point_that_meets_a_triangle_is_found(at in points(), way in points(), time in 0.0..1.0,
                                                  v in 0.0..1.0, w in 0.0..1.0) {
            let (v, w): (f64, f64) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
            let mut at = at;
            at[0] = at[1] * (1.0 - v - w) + at[2] * v + at[3] * w;
            let area = (at[2] - at[1]).cross(at[3] - at[1]);
            prop_assume!(area.length() > 1e-2);
            prop_assume!((way[0] - way[1]).dot(area).abs() > 1e-2);
            let (start, end) = through(at, way, time);
            let found = point_meets_triangle(start, end, 1e-6);
            prop_assert!(found.is_some_and(|f| f.time <= time + 1e-6), "{found:?} for {time}");
        }

        #[test]
        fn edges_that_meet_are_found(at in points(), way in points(), time in 0.0..1.0, s in 0.0..1.0, t in 0.0..1.0) {
            let mut at = at;
            let shift = at[0].lerp(at[1], s) - at[2].lerp(at[3], t);
            (at[2], at[3]) = (at[2] + shift, at[3] + shift);
            let (start, end) = through(at, way, time);
            let across = (at[1] - at[0]).cross(at[3] - at[2]);
            let approach = way[0].lerp(way[1], s) - way[2].lerp(way[3], t);
            prop_assume!(across.length() > 1e-2 && approach.dot(across).abs() > 1e-2);
            let found = edges_meet(start, end, 1e-6);
            prop_assert!(found.is_some_and(|f| f.time <= time + 1e-6), "{found:?} for {time}");
        }

        /// The distance of the features at a reported impact is within the tolerance.
        #[test]
        fn reported_impacts_touch(start in points(), end in points()) {
            if let Some(hit) = point_meets_triangle(start, end, CLOSE) {
                let x: [DVec3; 4] = std::array::from_fn(|i| start[i].lerp(end[i], hit.time));
                let q = x[1] * hit.weights[0] + x[2] * hit.weights[1] + x[3] * hit.weights[2];
                prop_assert!(q.distance(x[0]) <= CLOSE);
            }
            if let Some(hit) = edges_meet(start, end, CLOSE) {
                let x: [DVec3; 4] = std::array::from_fn(|i| start[i].lerp(end[i], hit.time));
                prop_assert!(x[0].lerp(x[1], hit.s).distance(x[2].lerp(x[3], hit.t)) <= CLOSE);
            }
        }
    }

    #[test]
    fn a_falling_point_meets_a_lying_triangle_when_it_should() {
        let triangle = [DVec3::ZERO, DVec3::Z, DVec3::X];
        let start = [DVec3::new(0.25, 3.0, 0.25), triangle[0], triangle[1], triangle[2]];
        let mut end = start;
        end[0].y = -1.0;
        let hit = point_meets_triangle(start, end, 1e-9).expect("meets");
        assert!((hit.time - 0.75).abs() < 1e-12 && (hit.weights[0] - 0.5).abs() < 1e-12);
        end[0].y = 0.5;
        assert_eq!(point_meets_triangle(start, end, 1e-9), None);
        end[0] = DVec3::new(3.0, -1.0, 0.25);
        assert_eq!(point_meets_triangle(start, end, 1e-9), None);
    }
}
