//! Distance of a triangle of a sheet from a convex part of a collider, as far as it is less than a
//! given length, m.
//!
//! A plane between the two proves a distance; most triangles near a body end there. The rest is
//! measured triangle by triangle. Parts that are not convex are left out.

use glam::DVec3;

use crate::collision::features::{ColliderMesh, ColliderPart};
use crate::collision::overlap::distance::{point_triangle, triangles};
use crate::collision::overlap::sheets::{apart, bounds};

/// Distance of a triangle, in the frame of the collider, from the part if it is less than `than`
/// (m); 0 where they intersect.
pub fn distance_below(part: &ColliderPart, triangle: &[DVec3; 3], than: f64) -> Option<f64> {
    let distance = match part {
        ColliderPart::HalfSpace { normal } => triangle.iter().map(|p| p.dot(*normal)).fold(f64::INFINITY, f64::min),
        ColliderPart::Ball { centre, radius } => point_triangle(*centre, *triangle) - radius,
        ColliderPart::Mesh(mesh) if mesh.is_convex() => distance_of_mesh(mesh, triangle, than)?,
        ColliderPart::Mesh(_) => return None,
    };
    (distance < than).then_some(distance.max(0.0))
}

fn distance_of_mesh(mesh: &ColliderMesh, triangle: &[DVec3; 3], than: f64) -> Option<f64> {
    if apart(bounds(*triangle), mesh.bounds(), than) {
        return None;
    }
    for face in mesh.faces() {
        if triangle.iter().all(|p| face.height(*p) >= than) {
            return None;
        }
    }
    if lies_on_one_side(mesh, triangle, than) {
        return None;
    }
    let is_inside = |p: &DVec3| mesh.faces().iter().all(|face| face.height(*p) <= 0.0);
    if triangle.iter().any(is_inside) {
        return Some(0.0);
    }
    let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize]);
    Some(mesh.triangles.iter().map(|t| triangles(triangle, &corners(t))).fold(f64::INFINITY, f64::min))
}

/// Whether all vertices are at least `than` (m) from the plane of the triangle, on one side.
fn lies_on_one_side(mesh: &ColliderMesh, [a, b, c]: &[DVec3; 3], than: f64) -> bool {
    let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
    let heights = || mesh.vertices.iter().map(|v| (*v - *a).dot(normal));
    heights().all(|height| height >= than) || heights().all(|height| height <= -than)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::collision::overlap::solid::{ConvexSolid, OverlapSolid};
    use crate::scene::Polyhedron;

    fn point(reach: f64) -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(move |(x, y, z)| reach * DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(5000))]

        #[test]
        fn distances_agree_with_those_of_separating_axes(
            centre in point(0.9), a in point(0.3), b in point(0.3), c in point(0.3),
        ) {
            let cuboid = Polyhedron::cuboid(DVec3::new(1.0, 0.6, 0.4));
            let mut sides: Vec<[u32; 3]> = Vec::new();
            for face in &cuboid.faces {
                sides.extend((1..face.len() - 1).map(|i| [face[0], face[i], face[i + 1]]));
            }
            let part = ColliderPart::from_triangles(&cuboid.vertices, &sides).expect("a cuboid");
            let solid = OverlapSolid::Convex(ConvexSolid::new(&cuboid));
            let triangle = [a, b, c].map(|p| p + centre);
            let depth = solid.overlap(&triangle, 2.0);
            match distance_below(&part, &triangle, 0.2) {
                Some(distance) if depth < 0.0 => prop_assert!((distance + depth).abs() < 1e-12, "{distance} {depth}"),
                Some(distance) => prop_assert_eq!(distance, 0.0),
                None => prop_assert!(depth < -0.2 + 1e-12, "{depth}"),
            }
        }
    }
}
