//! Penetration depth of surfaces, a measure to verify contact with; contact does not use it.
//!
//! The depth of a point x in a convex solid is its distance from the nearest face, min over faces k
//! of (c_k - n_k·x). The part of a triangle for which face k is the nearest is a convex polygon,
//! bounded by the planes of equal distance. The depth is linear in it and greatest at a corner, so
//! that the depth of the whole surface is exact without sampling, including body edges and corners
//! that reach through between nodes. The depth in a ball is greatest at the triangle's point
//! nearest to the centre, that in a half space at a node. Solids that are not convex are sampled.
//! Lengths in m.

use glam::DVec3;

use crate::collision::collision_surface::CollisionSurface;
use crate::collision::features::{ColliderFeatures, ColliderMesh, ColliderPart};
use crate::collision::geometry::{point_triangle, segment_segment};
use crate::collision::overlap::sheets::bounds;
use crate::math::{RigidFrame, Vectors};

/// Subdivisions of a triangle side where penetration depths are sampled.
const SUBDIVISIONS: u32 = 16;

/// Greatest depth (m) of the surface of a sheet (nodes at `x`) in a body; 0 if it is outside. With
/// `thickness` the surface of the material is meant, one contact offset from the triangles;
/// otherwise the triangles themselves.
pub fn into_body(
    skin: &CollisionSurface,
    x: &Vectors,
    features: &ColliderFeatures,
    frame: &RigidFrame,
    thickness: bool,
) -> f64 {
    let offset = if thickness { skin.contact_offset() } else { 0.0 };
    let local: Vec<DVec3> = x.iter().map(|p| frame.local_point(p)).collect();
    let depth_in = |solid: &ColliderPart| -> f64 {
        let triangles = skin.triangles().iter().map(|t| t.nodes.map(|i| local[i as usize]));
        match solid {
            ColliderPart::HalfSpace { normal } => local.iter().map(|p| offset - normal.dot(*p)).fold(0.0, f64::max),
            ColliderPart::Ball { centre, radius } => {
                let depth = |t: [DVec3; 3]| radius + offset - combined(t, point_triangle(*centre, t)).distance(*centre);
                triangles.map(depth).fold(0.0, f64::max)
            }
            ColliderPart::Mesh(mesh) if mesh.min_width().is_finite() => {
                triangles.map(|t| depth_in_convex(mesh, t, offset)).fold(0.0, f64::max)
            }
            ColliderPart::Mesh(mesh) => triangles.map(|t| sampled_depth(mesh, t, offset)).fold(0.0, f64::max),
        }
    };
    features.solids().iter().map(|(_, solid)| depth_in(solid)).fold(0.0, f64::max)
}

fn combined([a, b, c]: [DVec3; 3], w: [f64; 3]) -> DVec3 {
    a * w[0] + b * w[1] + c * w[2]
}

/// Greatest depth of a triangle in a convex solid, m.
fn depth_in_convex(mesh: &ColliderMesh, triangle: [DVec3; 3], offset: f64) -> f64 {
    let faces = mesh.faces();
    // A triangle entirely in front of one face is outside.
    if faces.iter().any(|f| triangle.iter().all(|p| f.height(*p) >= offset)) {
        return 0.0;
    }
    let (mut polygon, mut room) = (Vec::with_capacity(16), Vec::with_capacity(16));
    let mut deepest = 0.0_f64;
    for face in faces {
        polygon.clear();
        polygon.extend(triangle);
        clip(&mut polygon, &mut room, |p| offset - face.height(p));
        for other in faces.iter().filter(|f| !std::ptr::eq(*f, face)) {
            clip(&mut polygon, &mut room, |p| face.height(p) - other.height(p));
            if polygon.is_empty() {
                break;
            }
        }
        deepest = polygon.iter().map(|p| offset - face.height(*p)).fold(deepest, f64::max);
    }
    deepest
}

/// Clip a convex polygon to the half space where the linear function `inside` is at least 0
/// (Sutherland and Hodgman, Reentrant polygon clipping, 1974). `room` is a buffer.
fn clip(polygon: &mut Vec<DVec3>, room: &mut Vec<DVec3>, inside: impl Fn(DVec3) -> f64) {
    room.clear();
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (here, there) = (inside(*p), inside(q));
        if here >= 0.0 {
            room.push(*p);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            room.push(p.lerp(q, here / (here - there)));
        }
    }
    std::mem::swap(polygon, room);
}

/// Greatest depth of sampled points of a triangle in any solid, m.
fn sampled_depth(mesh: &ColliderMesh, triangle: [DVec3; 3], offset: f64) -> f64 {
    let (low, high) = mesh.bounds();
    let room = DVec3::splat(offset);
    let above = triangle[0].max(triangle[1]).max(triangle[2]);
    let below = triangle[0].min(triangle[1]).min(triangle[2]);
    if above.cmplt(low - room).any() || below.cmpgt(high + room).any() {
        return 0.0;
    }
    let mut deepest = 0.0_f64;
    let parts = SUBDIVISIONS;
    for i in 0..=parts {
        for j in 0..=parts - i {
            let (v, w) = (f64::from(i) / f64::from(parts), f64::from(j) / f64::from(parts));
            let p = combined(triangle, [1.0 - v - w, v, w]);
            let Some(near) = mesh.nearest(p, low.distance(high)) else { continue };
            let distance = p.distance(near.point);
            deepest = deepest.max(offset + if near.inside { distance } else { -distance });
        }
    }
    deepest
}

/// Overlap of two sheets (m): the sum of their contact offsets minus the distance of their
/// surfaces; 0 if they are apart, the whole sum if they intersect. Between parts of one sheet
/// (`same`), features that are neighbours at rest are excluded.
pub fn between_sheets((a, x): (&CollisionSurface, &Vectors), (b, y): (&CollisionSurface, &Vectors), same: bool) -> f64 {
    let touching = a.contact_offset() + b.contact_offset();
    let mut nearest = touching;
    for (i, p) in a.triangles().iter().enumerate() {
        let first = p.nodes.map(|m| x.get(m as usize));
        let (low, high) = bounds(first);
        for q in b.triangles().iter().skip(if same { i + 1 } else { 0 }) {
            let second = q.nodes.map(|m| y.get(m as usize));
            let (under, over) = bounds(second);
            let room = DVec3::splat(nearest);
            let apart = under.cmpgt(high + room).any() || over.cmplt(low - room).any();
            let reach = touching + p.size.max(q.size);
            if apart || (same && neighbours(a, p.nodes, q.nodes, reach)) {
                continue;
            }
            nearest = nearest.min(distance(first, second));
        }
    }
    touching - nearest
}

fn neighbours(skin: &CollisionSurface, p: [u32; 3], q: [u32; 3], reach: f64) -> bool {
    p.iter().any(|i| q.iter().any(|j| skin.rest_distance(*i, *j) < reach))
}

/// Distance of two triangles, m; 0 if they intersect.
fn distance(p: [DVec3; 3], q: [DVec3; 3]) -> f64 {
    let mut nearest = f64::INFINITY;
    for i in 0..3 {
        nearest = nearest.min(p[i].distance(combined(q, point_triangle(p[i], q))));
        nearest = nearest.min(q[i].distance(combined(p, point_triangle(q[i], p))));
        for j in 0..3 {
            let (a, b, c, d) = (p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3]);
            let (s, t) = segment_segment([a, b], [c, d]);
            nearest = nearest.min(a.lerp(b, s).distance(c.lerp(d, t)));
        }
        if pierces(p[i], p[(i + 1) % 3], q) || pierces(q[i], q[(i + 1) % 3], p) {
            return 0.0;
        }
    }
    nearest
}

/// Whether the segment from `a` to `b` pierces a triangle.
fn pierces(a: DVec3, b: DVec3, [p, q, r]: [DVec3; 3]) -> bool {
    let n = (q - p).cross(r - p);
    let (before, after) = ((a - p).dot(n), (b - p).dot(n));
    if (before < 0.0) == (after < 0.0) {
        return false;
    }
    let x = a.lerp(b, before / (before - after));
    [(p, q), (q, r), (r, p)].into_iter().all(|(u, v)| (v - u).cross(x - u).dot(n) >= 0.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rapier3d::prelude::SharedShape;

    use super::*;

    const HERE: RigidFrame = RigidFrame::IDENTITY;

    fn one(points: [DVec3; 3], offset: f64) -> (CollisionSurface, Vectors) {
        let mut x = Vectors::default();
        points.iter().for_each(|p| x.push(*p));
        (CollisionSurface::new(&[[0, 1, 2]], &x, offset, false), x)
    }

    fn point() -> impl Strategy<Value = DVec3> {
        (-2.0..2.0, -2.0..2.0, -2.0..2.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        /// Comparison with sampling: no sampled point is deeper, and some sampled point is nearly
        /// as deep.
        #[test]
        fn the_depth_in_a_box_is_that_of_the_deepest_point(a in point(), b in point(), c in point()) {
            let features = ColliderFeatures::from_shape(SharedShape::cuboid(1.0, 0.5, 0.75).0.as_ref());
            let (skin, x) = one([a, b, c], 0.0);
            let depth = into_body(&skin, &x, &features, &HERE, false);
            let mut sampled = 0.0_f64;
            let n = 60;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (v, w) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    let p = combined([a, b, c], [1.0 - v - w, v, w]);
                    sampled = sampled.max((DVec3::new(1.0, 0.5, 0.75) - p.abs()).min_element());
                }
            }
            prop_assert!(depth >= sampled - 1e-6);
            let step = a.distance(b).max(b.distance(c)).max(c.distance(a)) / f64::from(n);
            prop_assert!(depth <= sampled + step);
        }
    }

    #[test]
    fn a_rim_between_nodes_counts_in_the_depth() {
        let features = ColliderFeatures::from_shape(SharedShape::cuboid(1.0, 1.0, 1.0).0.as_ref());
        // A triangle that cuts across a rim: nodes outside, the middle of a side 0.1 inside along
        // both faces.
        let (skin, x) = one([DVec3::new(0.8, 1.0, 0.0), DVec3::new(1.0, 0.8, 0.0), DVec3::new(2.0, 2.0, 0.0)], 0.01);
        assert!((into_body(&skin, &x, &features, &HERE, false) - 0.1).abs() < 1e-7);
        assert!((into_body(&skin, &x, &features, &HERE, true) - 0.11).abs() < 1e-7);
        let moved = RigidFrame { origin: DVec3::NEG_Y * 3.0, ..HERE };
        assert_eq!(into_body(&skin, &x, &features, &moved, true), 0.0);
    }

    #[test]
    fn balls_and_floors_are_exact() {
        let (skin, x) = one([DVec3::new(-1.0, 0.9, -1.0), DVec3::new(1.0, 0.9, -1.0), DVec3::new(0.0, 0.9, 2.0)], 0.05);
        let ball = ColliderFeatures::from_shape(SharedShape::ball(1.0).0.as_ref());
        assert!((into_body(&skin, &x, &ball, &HERE, false) - 0.1).abs() < 1e-12);
        let floor = ColliderFeatures::from_shape(SharedShape::halfspace(glam::Vec3::Y).0.as_ref());
        let raised = RigidFrame { origin: DVec3::Y, ..HERE };
        assert!((into_body(&skin, &x, &floor, &raised, true) - 0.15).abs() < 1e-12);
        assert_eq!(into_body(&skin, &x, &floor, &HERE, true), 0.0);
    }

    #[test]
    fn a_hollow_solid_is_sampled() {
        // A cube whose top is pushed in to a point at its centre.
        let mut vertices: Vec<DVec3> = Vec::new();
        for y in [0.0, 1.0] {
            vertices.extend([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, y, z)));
        }
        vertices.push(DVec3::splat(0.5));
        let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
        for i in 0..4 {
            let (a, b) = (i, (i + 1) % 4);
            triangles.extend([[a, 4 + a, 4 + b], [a, 4 + b, b], [4 + a, 8, 4 + b]]);
        }
        let features =
            ColliderFeatures::from_solid(ColliderPart::from_triangles(&vertices, &triangles).expect("triangles"));
        let at = |y: f64| {
            let points = [(0.45, 0.45), (0.5, 0.55), (0.55, 0.45)].map(|(x, z)| DVec3::new(x, y, z));
            let (skin, x) = one(points, 0.0);
            into_body(&skin, &x, &features, &HERE, false)
        };
        // At 0.2 the base is nearest; at 0.8 the triangle is in the hollow, outside the solid.
        assert!((at(0.2) - 0.2).abs() < 1e-6);
        assert_eq!(at(0.8), 0.0);
    }

    #[test]
    fn sheets_overlap_by_thickness_minus_distance() {
        let flat = [DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0), DVec3::new(0.0, 0.0, 2.0)];
        let (a, x) = one(flat, 0.05);
        let over = |h: f64| one(flat.map(|p| p + DVec3::Y * h), 0.03);
        let overlap = |h: f64| between_sheets((&a, &x), (&over(h).0, &over(h).1), false);
        assert_eq!(overlap(0.1), 0.0);
        assert!((overlap(0.07) - 0.01).abs() < 1e-12);
        // A node through the middle: the overlap is the whole sum.
        let (b, y) = one([DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.1, 1.0, 0.0), DVec3::new(-0.1, 1.0, 0.0)], 0.03);
        assert!((between_sheets((&a, &x), (&b, &y), false) - 0.08).abs() < 1e-12);
        assert_eq!(between_sheets((&a, &x), (&a, &x), true), 0.0);
    }
}
