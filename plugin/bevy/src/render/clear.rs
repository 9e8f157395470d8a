//! Keeps what is drawn of a sheet out of what it lies on.
//!
//! Only masses touch bodies. Between them the drawn surface cuts across an edge or a curve that the masses lie around; here
//! its vertices are brought back out of the body they are in, and a skin's thickness above it; a triangle's side that still cuts
//! through an edge is lifted with both its ends until it does not. This is display alone.

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, ParallelSliceMut};
use rapier3d::prelude::{QueryPipeline, Ray};
use sheetwork::rigid::RigidView;

/// Vertices that one task works on.
const CHUNK: usize = 512;

/// How often sides that still cut through a body are lifted: a lifted one may cut a little less deep somewhere else.
const ROUNDS: usize = 4;

/// What is known of a vertex, once it is clear of bodies.
#[derive(Clone, Copy)]
enum Near {
    /// A point of the nearest body, and the way out of it there: a convex body is wholly behind that plane.
    Plane(Vec3, Vec3),
    /// It was brought out to where no plane is known.
    Edge,
}

/// Brings the surface (world space, m) out of the bodies: its vertices that are inside one, or nearer to it than `skin` (m), to
/// that distance outside it, and the sides of its triangles that cut through an edge or a curve between two vertices; works out
/// the normals anew if anything moved, as is returned. `reach` (m) is how deep a vertex may be.
///
/// Costs about a microsecond a vertex, shared among the threads of Bevy's compute pool where there is one, and some more for
/// each side across an edge.
pub fn clear_of_bodies(
    view: &RigidView,
    triangles: &[[u32; 3]],
    reach: f32,
    skin: f32,
    mut positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
) -> bool {
    let bring_out = |first: usize, part: &mut [[f32; 3]]| {
        // Each task has its own: a query's filter may not be shared.
        let query = view.query();
        let mut near = Vec::new();
        let mut any = false;
        for (i, (position, normal)) in part.iter_mut().zip(&normals[first.min(normals.len())..]).enumerate() {
            let Some((clear, known)) = brought_out(&query, Vec3::from(*position), Vec3::from(*normal), reach, skin)
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
        Some(pool) if positions.len() > CHUNK => {
            positions.par_chunk_map_mut(pool, CHUNK, |part, chunk| bring_out(part * CHUNK, chunk))
        }
        _ => vec![bring_out(0, positions)],
    };
    let mut any = parts.iter().any(|part| part.0);
    if parts.iter().any(|part| !part.1.is_empty()) {
        let mut near = vec![None; positions.len()];
        for (i, known) in parts.into_iter().flat_map(|part| part.1) {
            near[i] = Some(known);
        }
        let sides = doubtful(triangles, &near, positions);
        any |= lift_sides(&view.query(), &sides, reach, 0.1 * skin, positions, normals);
    }
    if any {
        write_normals(triangles, positions, normals);
    }
    any
}

/// Where a vertex goes, if it does not stay, and what is then known of it; `None` for one that is far from everything.
fn brought_out(query: &QueryPipeline, p: Vec3, normal: Vec3, reach: f32, skin: f32) -> Option<(Option<Vec3>, Near)> {
    // The query that asks for the feature too is the one that knows the inside of a polyhedron.
    let (_, nearest, _) = query.project_point_and_get_feature(p, reach.max(skin))?;
    let distance = nearest.point.distance(p);
    if nearest.is_inside && distance > 0.02 * skin {
        // Straight out through the sheet, so that what cuts across an edge comes to lie over it; the nearest point of the
        // body may be on either side of the edge and would tear the surface open there.
        let place = match exit(query, p, normal, 3.0 * distance + skin) {
            Some((far, out)) => p + (far + skin) * out,
            None => nearest.point + (nearest.point - p) * (skin / distance),
        };
        return Some((Some(place), Near::Edge));
    }
    let out = if distance > 0.02 * skin {
        (p - nearest.point) / distance
    } else {
        // On the surface the distance does not tell which way is out: one side of the sheet is.
        let above = p + 0.5 * skin * normal;
        let inside = query.project_point_and_get_feature(above, skin).is_some_and(|(_, nearest, _)| nearest.is_inside);
        if inside { -normal } else { normal }
    };
    let moved = (distance < skin).then(|| nearest.point + skin * out);
    Some((moved, Near::Plane(nearest.point, out)))
}

/// How far (m), and which way along `normal`, a point inside a body is from its outside, the shorter of both; `None` if it is
/// farther than `most` (m).
fn exit(query: &QueryPipeline, p: Vec3, normal: Vec3, most: f32) -> Option<(f32, Vec3)> {
    let way = |out: Vec3| query.cast_ray(&Ray::new(p, out), most, false).map(|(_, far)| (far, out));
    match (way(normal), way(-normal)) {
        (Some(a), Some(b)) => Some(if a.0 <= b.0 { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// The sides of triangles that may cut through a body, lower vertex first, in order: all but those that have both ends before
/// the planes that the bodies near them are behind.
fn doubtful(triangles: &[[u32; 3]], near: &[Option<Near>], positions: &[[f32; 3]]) -> Vec<[usize; 2]> {
    let before = |known: Near, other: usize| match known {
        Near::Plane(point, out) => (Vec3::from(positions[other]) - point).dot(out) >= 0.0,
        Near::Edge => false,
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

/// Lifts both ends of the sides that cut through a body by how deep the middle of the cut is, along the surface's normal, to
/// `margin` (m) above it; whether any was.
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
    for _ in 0..ROUNDS {
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
        // The longest lift of each vertex.
        lifts.sort_by(|p, q| p.0.cmp(&q.0).then(q.1.length_squared().total_cmp(&p.1.length_squared())));
        lifts.dedup_by_key(|lift| lift.0);
        for (i, lift) in lifts.drain(..) {
            positions[i] = (Vec3::from(positions[i]) + lift).to_array();
        }
    }
    any
}

/// Normals weighted by the area of the triangles around each vertex.
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
    fn a_surface_in_a_ball_is_brought_out_of_it_and_one_outside_is_left() {
        let scene = Scene::parse("(bodies: [(shape: Ball(1.0))])").expect("valid");
        let world = World::new(&scene).expect("valid");
        let view = world.rigid().expect("its own").view();
        let mut normals = [[0.0, 1.0, 0.0]; 3];
        let mut cutting = [[0.0, 1.0, 0.0], [0.1, 0.95, 0.0], [0.0, 0.95, 0.1]];
        let triangles = [[0, 2, 1]];
        assert!(clear_of_bodies(&view, &triangles, 10.0, 0.01, &mut cutting, &mut normals));
        for (p, n) in cutting.iter().zip(&normals) {
            // Out along its own normal, so not everywhere by the whole distance.
            assert!((1.003..1.0101).contains(&Vec3::from(*p).length()), "{p:?}");
            assert!(Vec3::from(*n).dot(Vec3::Y) > 0.9, "{n:?}");
        }
        let mut outside = cutting.map(|p| (Vec3::from(p) * 2.0).to_array());
        let before = outside;
        assert!(!clear_of_bodies(&view, &triangles, 10.0, 0.01, &mut outside, &mut normals));
        assert_eq!(outside, before);
    }

    #[test]
    fn a_surface_across_the_edge_of_a_box_is_brought_out_on_both_sides() {
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
                    // Not far above it either: the longest side's arc is 24 mm high, and the ridge's slope takes 100 mm.
                    assert!(nearest.point.distance(p) < 0.15, "{p:?}");
                }
            }
        }
    }
}
