//! Keeps what is drawn of a sheet out of what it lies on.
//!
//! Only masses touch bodies. Between them the drawn surface cuts across an edge or a curve that the masses lie around; here
//! its vertices are brought back out of the body they are in, and a skin's thickness above it, so that the triangles between
//! them come clear of sharp edges too. This is display alone.

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, ParallelSliceMut};
use rapier3d::prelude::{QueryPipeline, Ray};
use sheetwork::contact::rigid::RigidView;

/// Vertices that one task works on.
const CHUNK: usize = 512;

/// Brings the vertices of a surface (world space, m) that are inside a body, or nearer to it than `skin` (m), to that
/// distance outside it; works out the normals anew if there were any, as is returned. `reach` (m) is how deep one may be.
///
/// Costs about a microsecond a vertex, shared among the threads of Bevy's compute pool where there is one.
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
        let mut any = false;
        for (position, normal) in part.iter_mut().zip(&normals[first.min(normals.len())..]) {
            if let Some(clear) = brought_out(&query, Vec3::from(*position), Vec3::from(*normal), reach, skin) {
                *position = clear.to_array();
                any = true;
            }
        }
        any
    };
    let any = match ComputeTaskPool::try_get() {
        Some(pool) if positions.len() > CHUNK => {
            let parts = positions.par_chunk_map_mut(pool, CHUNK, |part, chunk| bring_out(part * CHUNK, chunk));
            parts.contains(&true)
        }
        _ => bring_out(0, positions),
    };
    if any {
        write_normals(triangles, positions, normals);
    }
    any
}

/// Where a vertex goes; `None` for one that is clear of everything.
fn brought_out(query: &QueryPipeline, p: Vec3, normal: Vec3, reach: f32, skin: f32) -> Option<Vec3> {
    // The query that asks for the feature too is the one that knows the inside of a polyhedron.
    let (_, nearest, _) = query.project_point_and_get_feature(p, reach.max(skin))?;
    let distance = nearest.point.distance(p);
    if nearest.is_inside && distance > 0.02 * skin {
        // Straight out through the sheet, so that what cuts across an edge comes to lie over it; the nearest point of the
        // body may be on either side of the edge and would tear the surface open there.
        let exit = |out: Vec3| {
            let hit = query.cast_ray(&Ray::new(p, out), 3.0 * distance + skin, false);
            hit.map(|(_, far)| (far, p + (far + skin) * out))
        };
        let shorter = match (exit(normal), exit(-normal)) {
            (Some(a), Some(b)) => Some(if a.0 <= b.0 { a.1 } else { b.1 }),
            (a, b) => a.or(b).map(|(_, place)| place),
        };
        return Some(shorter.unwrap_or(nearest.point + (nearest.point - p) * (skin / distance)));
    }
    if distance >= skin {
        return None;
    }
    let out = if distance > 0.02 * skin {
        (p - nearest.point) / distance
    } else {
        // On the surface the distance does not tell which way is out: one side of the sheet is.
        let above = p + 0.5 * skin * normal;
        let inside = query.project_point_and_get_feature(above, skin).is_some_and(|(_, nearest, _)| nearest.is_inside);
        if inside { -normal } else { normal }
    };
    Some(nearest.point + skin * out)
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
        let mut cutting = [[0.0, 1.0, 0.0], [0.3, 0.8, 0.0], [0.0, 0.8, 0.3]];
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
}
