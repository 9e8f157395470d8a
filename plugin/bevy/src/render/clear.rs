//! Depenetration of the displayed surface from bodies.
//!
//! Contact acts at nodes. Between nodes the displayed surface can intersect an edge or a curved
//! face of a body. Here vertices inside a body, or closer to it than a margin, are moved to that
//! margin outside it, and triangle sides that still intersect a body are lifted with both their
//! ends. The simulation is not affected.

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, ParallelSliceMut};
use rapier3d::prelude::{QueryPipeline, Ray};
use sheetwork::rigid::RigidView;

/// Vertices per task.
const VERTICES_PER_TASK: usize = 512;

/// Maximum number of lifting passes: a lifted side may leave a shallower intersection elsewhere.
const MAX_PASSES: usize = 4;

/// Geometry near a vertex after depenetration.
#[derive(Clone, Copy)]
enum NearbyBody {
    /// Point on the nearest body and its outward normal. A convex body lies behind this plane.
    Plane(Vec3, Vec3),
    /// The vertex was moved to a place without a known plane.
    Edge,
}

/// Move the surface (world space, m) out of the bodies: vertices closer to a body than `clearance`
/// (m) to that distance, and sides of triangles that intersect a body. Recomputes the normals if
/// any vertex moved, and returns whether one did. `reach` (m) is the largest penetration of a
/// vertex.
///
/// Costs about 1 µs per vertex, shared among the threads of Bevy's compute pool where there is one,
/// and more for each intersecting side.
pub fn clear_of_bodies(
    view: &RigidView,
    triangles: &[[u32; 3]],
    reach: f32,
    clearance: f32,
    mut positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
) -> bool {
    let bring_out = |first: usize, part: &mut [[f32; 3]]| {
        // One query per task: its filter is not `Sync`.
        let query = view.query();
        let mut near = Vec::new();
        let mut any = false;
        for (i, (position, normal)) in part.iter_mut().zip(&normals[first.min(normals.len())..]).enumerate() {
            let Some((clear, known)) =
                depenetrated(&query, Vec3::from(*position), Vec3::from(*normal), reach, clearance)
            else {
                continue;
            };
            near.push((first + i, known));
            if let Some(clear) = clear {
                *position = clear.to_array();
                any = true;
            }
        }
        (any, near)
    };
    let parts = match ComputeTaskPool::try_get() {
        Some(pool) if positions.len() > VERTICES_PER_TASK => {
            positions
                .par_chunk_map_mut(pool, VERTICES_PER_TASK, |part, chunk| bring_out(part * VERTICES_PER_TASK, chunk))
        }
        _ => vec![bring_out(0, positions)],
    };
    let mut any = parts.iter().any(|part| part.0);
    if parts.iter().any(|part| !part.1.is_empty()) {
        let mut near = vec![None; positions.len()];
        for (i, known) in parts.into_iter().flat_map(|part| part.1) {
            near[i] = Some(known);
        }
        let sides = candidate_sides(triangles, &near, positions);
        any |= lift_sides(&view.query(), &sides, reach, 0.1 * clearance, positions, normals);
    }
    if any {
        write_normals(triangles, positions, normals);
    }
    any
}

/// New position of a vertex, if it moves, and the geometry near it; `None` for a vertex far from
/// all bodies.
fn depenetrated(
    query: &QueryPipeline,
    p: Vec3,
    normal: Vec3,
    reach: f32,
    clearance: f32,
) -> Option<(Option<Vec3>, NearbyBody)> {
    // Only the query with feature tests whether a point is inside a polyhedron.
    let (_, nearest, _) = query.project_point_and_get_feature(p, reach.max(clearance))?;
    let distance = nearest.point.distance(p);
    if nearest.is_inside && distance > 0.02 * clearance {
        // The vertex leaves along the surface normal, so that a triangle across an edge comes to
        // lie over it. The nearest points of neighbouring vertices may be on different faces and
        // would tear the surface.
        let place = match exit(query, p, normal, 3.0 * distance + clearance) {
            Some((far, out)) => p + (far + clearance) * out,
            None => nearest.point + (nearest.point - p) * (clearance / distance),
        };
        return Some((Some(place), NearbyBody::Edge));
    }
    let out = if distance > 0.02 * clearance {
        (p - nearest.point) / distance
    } else {
        // On the surface of a body the distance has no sign; the sheet's normal decides the side.
        let above = p + 0.5 * clearance * normal;
        let inside =
            query.project_point_and_get_feature(above, clearance).is_some_and(|(_, nearest, _)| nearest.is_inside);
        if inside { -normal } else { normal }
    };
    let moved = (distance < clearance).then(|| nearest.point + clearance * out);
    Some((moved, NearbyBody::Plane(nearest.point, out)))
}

/// Distance (m) and signed direction along `normal` from a point inside a body to its outside, on
/// the shorter side; `None` beyond `most` (m).
fn exit(query: &QueryPipeline, p: Vec3, normal: Vec3, most: f32) -> Option<(f32, Vec3)> {
    let way = |out: Vec3| query.cast_ray(&Ray::new(p, out), most, false).map(|(_, far)| (far, out));
    match (way(normal), way(-normal)) {
        (Some(a), Some(b)) => Some(if a.0 <= b.0 { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// Sides of triangles that may intersect a body, lower vertex first, sorted: all sides except those
/// with both ends in front of the planes of both ends.
fn candidate_sides(triangles: &[[u32; 3]], near: &[Option<NearbyBody>], positions: &[[f32; 3]]) -> Vec<[usize; 2]> {
    let before = |known: NearbyBody, other: usize| match known {
        NearbyBody::Plane(point, out) => (Vec3::from(positions[other]) - point).dot(out) >= 0.0,
        NearbyBody::Edge => false,
    };
    let mut sides = Vec::new();
    for [a, b, c] in triangles.iter().map(|t| t.map(|i| i as usize)) {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            let (Some(Some(first)), Some(Some(second))) = (near.get(i), near.get(j)) else { continue };
            if !(before(*first, j) && before(*second, i)) {
                sides.push([i.min(j), i.max(j)]);
            }
        }
    }
    sides.sort_unstable();
    sides.dedup();
    sides
}

/// Lift both ends of each intersecting side by the depth at the middle of the intersection, along
/// the surface normal, to `margin` (m) above it. Returns whether any side was lifted.
fn lift_sides(
    query: &QueryPipeline,
    sides: &[[usize; 2]],
    reach: f32,
    margin: f32,
    positions: &mut [[f32; 3]],
    normals: &[[f32; 3]],
) -> bool {
    let mut any = false;
    let mut lifts: Vec<(usize, Vec3)> = Vec::new();
    for _ in 0..MAX_PASSES {
        for &[i, j] in sides {
            let (a, b) = (Vec3::from(positions[i]), Vec3::from(positions[j]));
            let length = a.distance(b);
            let normal = (Vec3::from(normals[i]) + Vec3::from(normals[j])).normalize_or_zero();
            if length == 0.0 || normal == Vec3::ZERO {
                continue;
            }
            let along = (b - a) / length;
            let Some((_, entry)) = query.cast_ray(&Ray::new(a, along), length, true) else { continue };
            let back = query.cast_ray(&Ray::new(b, -along), length, true).map_or(0.0, |(_, far)| far);
            let middle = a + 0.5 * (entry + length - back) * along;
            if let Some((far, out)) = exit(query, middle, normal, reach) {
                lifts.extend([(i, (far + margin) * out), (j, (far + margin) * out)]);
            }
        }
        if lifts.is_empty() {
            break;
        }
        any = true;
        // The longest lift of each vertex comes first.
        lifts.sort_by(|p, q| p.0.cmp(&q.0).then(q.1.length_squared().total_cmp(&p.1.length_squared())));
        lifts.dedup_by_key(|lift| lift.0);
        for (i, lift) in lifts.drain(..) {
            positions[i] = (Vec3::from(positions[i]) + lift).to_array();
        }
    }
    any
}

/// Normals weighted by the areas of the adjacent triangles.
fn write_normals(triangles: &[[u32; 3]], positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    normals.fill([0.0; 3]);
    for corners in triangles.iter().map(|t| t.map(|i| i as usize)) {
        let [Some(p), Some(q), Some(r)] = corners.map(|i| positions.get(i).map(|p| Vec3::from(*p))) else { continue };
        let normal = (q - p).cross(r - p);
        for i in corners {
            if let Some(n) = normals.get_mut(i) {
                *n = (Vec3::from(*n) + normal).to_array();
            }
        }
    }
    for n in normals {
        *n = Vec3::from(*n).normalize_or(Vec3::Y).to_array();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::World;
    use sheetwork::scene::Scene;

    #[test]
    fn a_surface_in_a_ball_is_moved_out_and_one_outside_is_unchanged() {
        let scene = Scene::parse("(bodies: [(shape: Ball(1.0))])").expect("valid");
        let world = World::new(&scene).expect("valid");
        let view = world.rigid().expect("its own").view();
        let mut normals = [[0.0, 1.0, 0.0]; 3];
        let mut cutting = [[0.0, 1.0, 0.0], [0.1, 0.95, 0.0], [0.0, 0.95, 0.1]];
        let triangles = [[0, 2, 1]];
        assert!(clear_of_bodies(&view, &triangles, 10.0, 0.01, &mut cutting, &mut normals));
        for (p, n) in cutting.iter().zip(&normals) {
            // Moved along the vertex normal, so the distance from the body varies.
            assert!((1.003..1.0101).contains(&Vec3::from(*p).length()), "{p:?}");
            assert!(Vec3::from(*n).dot(Vec3::Y) > 0.9, "{n:?}");
        }
        let mut outside = cutting.map(|p| (Vec3::from(p) * 2.0).to_array());
        let before = outside;
        assert!(!clear_of_bodies(&view, &triangles, 10.0, 0.01, &mut outside, &mut normals));
        assert_eq!(outside, before);
    }

    #[test]
    fn a_surface_across_the_edge_of_a_box_is_moved_out_on_both_sides() {
        let scene = Scene::parse("(bodies: [(shape: Box((2.0, 2.0, 2.0)))])").expect("valid");
        let world = World::new(&scene).expect("valid");
        let view = world.rigid().expect("its own").view();
        let mut normals = [Vec3::new(1.0, 1.0, 0.0).normalize().to_array(); 4];
        let mut cutting = [[0.8, 0.8, 0.0], [0.9, 0.7, 0.0], [0.5, 1.0, 0.0], [0.5, 1.004, 0.0]];
        normals[2] = [0.0, 1.0, 0.0];
        assert!(clear_of_bodies(&view, &[], 10.0, 0.01, &mut cutting, &mut normals));
        let there = [[1.00707, 1.00707, 0.0], [1.00707, 0.80707, 0.0], [0.5, 1.01, 0.0], [0.5, 1.01, 0.0]];
        for (p, there) in cutting.iter().zip(there) {
            assert!(Vec3::from(*p).distance(Vec3::from(there)) < 1e-3, "{p:?} {there:?}");
        }
    }

    #[test]
    fn sides_that_cut_across_a_curve_or_a_ridge_are_lifted_over_it() {
        let ball = Scene::parse("(bodies: [(shape: Ball(1.0))])").expect("valid");
        let ridge = Scene::parse("(bodies: [(shape: Box((2.0, 2.0, 2.0)), placement: (rotation: (0, 0, 45)))])")
            .expect("valid");
        let top = 2.0_f32.sqrt();
        let over_ball = [[0.0, 1.005, 0.0], [0.3, 0.8, 0.0], [0.0, 0.8, 0.3]];
        let over_ridge = [[-0.1, top - 0.07, 0.0], [0.13, top - 0.1, 0.0], [0.02, top - 0.04, 0.2]];
        for (scene, mut positions) in [(ball, over_ball), (ridge, over_ridge)] {
            let world = World::new(&scene).expect("valid");
            let view = world.rigid().expect("its own").view();
            let mut normals = [[0.0, 1.0, 0.0]; 3];
            assert!(clear_of_bodies(&view, &[[0, 1, 2]], 10.0, 0.002, &mut positions, &mut normals));
            let query = view.query();
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                for part in 0..=20 {
                    let p = Vec3::from(positions[i]).lerp(Vec3::from(positions[j]), part as f32 / 20.0);
                    let (_, nearest, _) = query.project_point_and_get_feature(p, 1.0).expect("near");
                    assert!(!nearest.is_inside, "{p:?} of side {i} {j}");
                    // Upper bound: the arc of the longest side is 24 mm high, and the slope of the
                    // ridge adds 100 mm.
                    assert!(nearest.point.distance(p) < 0.15, "{p:?}");
                }
            }
        }
    }
}
