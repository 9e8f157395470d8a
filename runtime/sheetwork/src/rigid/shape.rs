//! Conversion of body shapes to Parry's shapes.
//!
//! Static and kinematic bodies are oriented triangle meshes, for which Parry knows the inside
//! whether they are convex or not. Dynamic bodies touch each other in Rapier, which is most
//! accurate for convex solids: boxes and convex polyhedra are converted to these.

use glam::DVec3;
use rapier3d::prelude::{SharedShape, TriMeshFlags, Vector};

use crate::error::{InputError, reject_if};
use crate::scene::{Polyhedron, Scene, Shape, pol};

/// Polyhedra of a shape; empty for balls and half spaces.
pub(crate) fn polyhedra_of(scene: &Scene, shape: &Shape) -> Result<Vec<Polyhedron>, InputError> {
    match shape {
        Shape::File(file) => pol::read_pol_file(&scene.base.join(file)),
        Shape::Part(file, index) => {
            let mut all = pol::read_pol_file(&scene.base.join(file))?;
            let (count, name) = (all.len(), file.display());
            reject_if!(*index >= count, "shape", "polyhedron {index} of {name}, which holds {count}");
            Ok(vec![all.swap_remove(*index)])
        }
        Shape::Polyhedron(polyhedron) => {
            polyhedron.check_closed().map_err(|e| e.within("shape"))?;
            Ok(vec![polyhedron.clone()])
        }
        Shape::Box(size) => Ok(vec![Polyhedron::cuboid(*size)]),
        Shape::Ball(_) | Shape::HalfSpace => Ok(Vec::new()),
    }
}

/// Parry's shapes, one per polyhedron; `is_dynamic` states that the body is dynamic.
pub(crate) fn shapes_of(
    shape: &Shape,
    polyhedra: &[Polyhedron],
    is_dynamic: bool,
) -> Result<Vec<SharedShape>, InputError> {
    match shape {
        Shape::Ball(radius) => Ok(vec![SharedShape::ball(*radius as f32)]),
        Shape::HalfSpace => Ok(vec![SharedShape::halfspace(Vector::Y)]),
        Shape::Box(size) if is_dynamic => Ok(vec![cuboid(*size)]),
        Shape::File(_) | Shape::Part(..) | Shape::Polyhedron(_) | Shape::Box(_) => {
            polyhedra.iter().map(|p| solid_of(p, is_dynamic)).collect()
        }
    }
}

fn cuboid(size: DVec3) -> SharedShape {
    let half = (size * 0.5).as_vec3();
    SharedShape::cuboid(half.x, half.y, half.z)
}

fn solid_of(polyhedron: &Polyhedron, is_dynamic: bool) -> Result<SharedShape, InputError> {
    let vertices: Vec<Vector> = polyhedron.vertices.iter().map(|p| p.as_vec3()).collect();
    let triangles = polyhedron.triangulate();
    let convex = (is_dynamic && is_convex(polyhedron)).then(|| SharedShape::convex_mesh(vertices.clone(), &triangles));
    if let Some(convex) = convex.flatten() {
        return Ok(convex);
    }
    SharedShape::trimesh_with_flags(vertices, triangles, TriMeshFlags::ORIENTED)
        .map_err(|e| InputError::new("shape", format!("cannot be made into a surface: {e}")))
}

/// Whether every vertex lies behind every face, within 1e-6 of the size.
pub(crate) fn is_convex(polyhedron: &Polyhedron) -> bool {
    let (low, high) = polyhedron.bounds();
    let slack = 1e-6 * low.distance(high);
    (0..polyhedron.faces.len()).all(|face| {
        let normal = polyhedron.face_normal(face);
        let Some(on) = polyhedron.faces[face].first().and_then(|v| polyhedron.vertices.get(*v as usize)) else {
            return false;
        };
        polyhedron.vertices.iter().all(|p| (*p - *on).dot(normal) <= slack)
    })
}
