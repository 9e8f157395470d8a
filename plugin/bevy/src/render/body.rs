//! Meshes of rigid bodies, each in the space of its entity.
//!
//! Faces of a polyhedron at an angle below 30° are shaded as one smooth surface: a dome looks
//! round, a wedge sharp.

use bevy::prelude::*;
use sheetwork::scene::Polyhedron;

use super::materials::Materials;
use super::triangle_mesh::triangle_mesh;
use crate::core::{BodyShape, SheetBody, SheetPolyhedra};

/// Cosine of the largest angle between smoothly shaded faces, 30°.
const SMOOTH_COSINE: f64 = 0.866;

/// Shape of which the entity's mesh was made.
#[derive(Component)]
pub(super) struct DisplayedBody(BodyShape);

/// Insert mesh and material where they are missing, and a new mesh after a change of shape.
pub(super) fn insert_meshes(
    mut commands: Commands,
    assets: Option<Res<Assets<SheetPolyhedra>>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut defaults: ResMut<Materials>,
    bodies: Query<
        (Entity, &SheetBody, Option<&DisplayedBody>, Has<Mesh3d>, Has<MeshMaterial3d<StandardMaterial>>),
        Or<(Changed<SheetBody>, Without<DisplayedBody>)>,
    >,
) {
    for (entity, body, drawn, has_mesh, has_material) in &bodies {
        // A mesh without this marker belongs to the user.
        if drawn.map_or(has_mesh, |d| d.0 == body.shape) {
            continue;
        }
        let Some(mesh) = mesh_of(&body.shape, assets.as_deref()) else { continue };
        commands.entity(entity).try_insert((Mesh3d(meshes.add(mesh)), DisplayedBody(body.shape.clone())));
        if !has_material {
            commands.entity(entity).try_insert(MeshMaterial3d(defaults.body(&mut materials)));
        }
    }
}

/// Mesh of a shape; `None` for a shape that is not displayed, or whose file is still loading.
fn mesh_of(shape: &BodyShape, assets: Option<&Assets<SheetPolyhedra>>) -> Option<Mesh> {
    match shape {
        BodyShape::Cuboid(size) => Some(Cuboid::from_size(size.as_vec3()).into()),
        BodyShape::Ball(radius) => Some(Sphere::new(*radius as f32).mesh().uv(64, 32)),
        BodyShape::HalfSpace { drawn } if *drawn > 0.0 => Some(Plane3d::default().mesh().size(*drawn, *drawn).into()),
        BodyShape::HalfSpace { .. } => None,
        BodyShape::Polyhedra(polyhedra) => Some(polyhedra_mesh(polyhedra)),
        BodyShape::Asset(handle) => assets?.get(handle).map(|a| polyhedra_mesh(&a.polyhedra)),
    }
}

/// Mesh of polyhedra, in their own coordinates, m.
pub fn polyhedra_mesh(polyhedra: &[Polyhedron]) -> Mesh {
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for polyhedron in polyhedra {
        let faces_at = faces_at_vertices(polyhedron);
        let areas: Vec<_> = (0..polyhedron.faces.len()).map(|f| polyhedron.area_vector(f)).collect();
        for (face, area) in areas.iter().enumerate() {
            let normal = area.normalize_or_zero();
            for triangle in polyhedron.triangulate_face(face) {
                for vertex in triangle {
                    let around = faces_at.get(vertex as usize).map_or(&[][..], Vec::as_slice);
                    let alike =
                        around.iter().map(|f| areas[*f]).filter(|a| a.normalize_or_zero().dot(normal) > SMOOTH_COSINE);
                    let smooth = alike.fold(bevy::math::DVec3::ZERO, |sum, a| sum + a).normalize_or(normal);
                    indices.push(positions.len() as u32);
                    positions.push(polyhedron.vertices[vertex as usize].as_vec3().to_array());
                    normals.push(smooth.as_vec3().to_array());
                }
            }
        }
    }
    let uvs = vec![[0.0_f32, 0.0]; positions.len()];
    triangle_mesh(positions, normals, uvs, indices)
}

/// Faces at each vertex.
fn faces_at_vertices(polyhedron: &Polyhedron) -> Vec<Vec<usize>> {
    let mut faces_at = vec![Vec::new(); polyhedron.vertices.len()];
    for (face, corners) in polyhedron.faces.iter().enumerate() {
        for corner in corners {
            if let Some(faces) = faces_at.get_mut(*corner as usize) {
                faces.push(face);
            }
        }
    }
    faces_at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(mesh: &Mesh) -> Vec<Vec3> {
        let values = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|a| a.as_float3()).expect("normals");
        values.iter().map(|n| Vec3::from(*n)).collect()
    }

    #[test]
    fn a_box_is_sharp_and_a_dome_is_round() {
        let cube = polyhedra_mesh(&[Polyhedron::cuboid(bevy::math::DVec3::ONE)]);
        assert!(normals(&cube).iter().all(|n| n.abs().max_element() > 0.9999), "along the axes");
        let dome = polyhedra_mesh(&[Polyhedron::hemisphere(1.0, 8, 32)]);
        let positions = dome.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions");
        for (p, n) in positions.iter().zip(normals(&dome)).filter(|(p, n)| p[1] > 0.1 && n.y > -0.5) {
            assert!(Vec3::from(*p).normalize().dot(n) > 0.99, "{p:?} {n}");
        }
    }
}
