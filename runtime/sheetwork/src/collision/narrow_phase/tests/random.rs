//! Random motions, compared with sampling in time and on the surface.

use glam::{DQuat, DVec3, EulerRot};
use proptest::prelude::*;
use rapier3d::prelude::SharedShape;

use crate::collision::geometry::point_triangle;
use crate::collision::narrow_phase::tests::*;
use crate::collision::overlap::OverlapSolid;
use crate::scene::Shape;

/// Half sides of the body, m.
const SIZE: DVec3 = DVec3::new(0.03, 0.02, 0.025);

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(move |(x, y, z)| reach * DVec3::new(x, y, z))
}

fn turn(v: DVec3) -> DQuat {
    DQuat::from_euler(EulerRot::XYZ, v.x, v.y, v.z)
}

/// A bent sheet with the given rotation and position.
fn posed(flat: &Vectors, angles: DVec3, bend: f64, place: DVec3) -> Vectors {
    mapped(flat, |p| turn(angles) * (p + DVec3::Y * bend * (p.x * p.x - p.x * p.z)) + place)
}

/// Distance of a point from the box, m; negative inside.
fn distance(p: DVec3) -> f64 {
    let d = p.abs() - SIZE;
    d.max(DVec3::ZERO).length() + d.max_element().min(0.0)
}

/// Signed distance of a sheet from the box by sampling its triangles, m.
fn clearance(skin: &CollisionSurface, x: &Vectors) -> f64 {
    let mut least = f64::INFINITY;
    for t in skin.triangles() {
        let [a, b, c] = t.nodes.map(|i| x.get(i as usize));
        for i in 0..=8_u32 {
            for j in 0..=8 - i {
                let (v, w) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                least = least.min(distance(a * (1.0 - v - w) + b * v + c * w));
            }
        }
    }
    least
}

fn between(x: &Vectors, y: &Vectors, t: f64) -> Vectors {
    let mut z = Vectors::default();
    x.iter().zip(y.iter()).for_each(|(p, q)| z.push(p.lerp(q, t)));
    z
}

proptest! {
    #![proptest_config(crate::math::drawn::drawn_cases(400))]

    /// A sheet moves from outside a box. Each node that has been inside the box has a violated
    /// constraint, a sheet that ends in the box has at least one, and a sheet that stays away has
    /// none.
    #[test]
    fn constraints_with_a_box_agree_with_sampling(angles in vector(1.6), bend in -6.0..6.0, place in vector(0.1),
                                         way in vector(0.2), twist in vector(0.3), unbend in -3.0..3.0) {
        let flat = square(5, 0.08);
        let own = ensure_collision_surface(5, &flat);
        let start = posed(&flat, angles, bend, place);
        prop_assume!(clearance(&own, &start) > 2e-3);
        let end = posed(&flat, angles + twist, bend + unbend, place + way);
        let features = ColliderFeatures::from_shape(SharedShape::cuboid(0.03, 0.02, 0.025).0.as_ref());
        let found = rows(&[moved(0, &own, &start, &end)], &[still(0, &features)]);
        let here = [RigidFrame::IDENTITY];
        let least = (0..=40).map(|k| clearance(&own, &between(&start, &end, f64::from(k) / 40.0)));
        let least = least.fold(f64::INFINITY, f64::min);
        for row in &found {
            // A feature that slides over an edge and turns may begin behind the contact plane, but
            // it comes near the box.
            prop_assert!(gap(row, &[&start], &here) > -2e-4 || least < 3e-3, "was never apart: {row:?}");
        }
        let times = 200;
        for i in 0..flat.len() {
            let (p, q) = (start.get(i), end.get(i));
            let deepest = (0..=times).map(|k| distance(p.lerp(q, f64::from(k) / f64::from(times))));
            if deepest.fold(f64::INFINITY, f64::min) < -2e-3 {
                let held = found.iter().any(|r| match r.a {
                    ContactSide::Sheet { point, .. } => {
                        point.terms().any(|(m, _)| m as usize == i) && gap(r, &[&end], &here) < 0.0
                    }
                    ContactSide::Body { .. } => false,
                });
                prop_assert!(held, "mass {i} came through");
            }
        }
        let solid = OverlapSolid::from_shape(&Shape::Box(2.0 * DVec3::new(0.03, 0.02, 0.025))).expect("a solid");
        let corners = own.triangles().iter().map(|t| t.nodes.map(|m| end.get(m as usize)));
        let depth = corners.map(|t| solid.overlap(&t, 0.0)).fold(f64::NEG_INFINITY, f64::max);
        prop_assert!(depth < 1e-4 || found.iter().any(|r| gap(r, &[&end], &here) < 0.0), "{depth} and no row");
        if least > 0.02 {
            prop_assert!(found.is_empty());
        }
    }

    /// Each node of one sheet that crosses a triangle of another has a constraint.
    #[test]
    fn every_node_that_crosses_a_sheet_has_a_constraint(angles in vector(0.7), bend in -4.0..4.0, place in vector(0.02), way in vector(0.01),
                              fall in 0.05..0.3, shake in vector(0.2)) {
        let flat = square(4, 0.06);
        let own = ensure_collision_surface(4, &flat);
        let lying = posed(&flat, shake, 0.3 * bend, DVec3::ZERO);
        let start = posed(&flat, angles, bend, place + DVec3::Y * 0.12);
        let end = posed(&flat, angles + shake, bend, place + way + DVec3::Y * (0.12 - fall));
        let found = rows(&[moved(0, &own, &lying, &lying), moved(1, &own, &start, &end)], &[]);
        for row in &found {
            // A node that slides along the plane of a triangle may begin nearer to this plane than
            // the contact offset, far from the triangle.
            prop_assert!(gap(row, &[&lying, &start], &[]) > -row.offset, "{row:?}");
        }
        for i in 0..flat.len() {
            let crossed = own.triangles().iter().any(|t| {
                let [a, b, c] = t.nodes.map(|m| lying.get(m as usize));
                let n = (b - a).cross(c - a);
                let (p, q) = (start.get(i), end.get(i));
                let (before, after) = (n.dot(p - a), n.dot(q - a));
                let x = p.lerp(q, before / (before - after));
                before > 0.0 && after < 0.0 && point_triangle(x, [a, b, c]).iter().all(|w| *w > 0.01)
            });
            // For two coincident nodes one constraint remains (`prune`), which may belong to the
            // other node.
            let own = |side: &ContactSide| matches!(side, ContactSide::Sheet { sheet: 1, point } if *point == SheetPoint::node(i as u32));
            let there = |side: &ContactSide| match side {
                ContactSide::Sheet { sheet: 1, point } => point.terms().any(|(m, w)| m as usize == i && w > 0.98),
                _ => false,
            };
            let of_mass = |side: &ContactSide| matches!(side, ContactSide::Sheet { sheet: 0, point } if point.weights[0] == 1.0);
            let held = found.iter().any(|r| own(&r.a) || of_mass(&r.a) && there(&r.b));
            prop_assert!(!crossed || held, "mass {i} came through");
        }
    }
}
