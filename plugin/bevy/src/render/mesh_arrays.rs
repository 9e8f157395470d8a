//! Positions and normals of a mesh, written in place.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

type Array = Vec<[f32; 3]>;

/// Let `change` write the positions and normals of a mesh, both at once and without a copy. Returns
/// false for a mesh without positions.
pub(super) fn write_arrays(mesh: &mut Mesh, change: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]])) -> bool {
    let Some((mut positions, mut normals)) = take_arrays(mesh) else { return false };
    change(&mut positions, &mut normals);
    put_arrays(mesh, positions, normals);
    true
}

/// Take positions and normals out of a mesh.
fn take_arrays(mesh: &mut Mesh) -> Option<(Array, Array)> {
    let mut take = |attribute| match mesh.try_attribute_mut(attribute) {
        Ok(VertexAttributeValues::Float32x3(values)) => Some(std::mem::take(values)),
        _ => None,
    };
    let positions = take(Mesh::ATTRIBUTE_POSITION)?;
    Some((positions, take(Mesh::ATTRIBUTE_NORMAL).unwrap_or_default()))
}

/// Return positions and normals to the mesh.
fn put_arrays(mesh: &mut Mesh, positions: Array, normals: Array) {
    for (attribute, array) in [(Mesh::ATTRIBUTE_POSITION, positions), (Mesh::ATTRIBUTE_NORMAL, normals)] {
        if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(attribute) {
            *values = array;
        }
    }
}

/// Transform from world space into the space of the entity.
pub(super) fn to_local(there: &GlobalTransform, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
    let affine = there.affine();
    if affine == bevy::math::Affine3A::IDENTITY || affine.matrix3.determinant() == 0.0 {
        return;
    }
    let inverse = affine.inverse();
    // Normals transform by the inverse transpose.
    let turn = affine.matrix3.transpose();
    for p in positions {
        *p = inverse.transform_point3(Vec3::from(*p)).to_array();
    }
    for n in normals {
        *n = (turn * Vec3::from(*n)).normalize_or(Vec3::Y).to_array();
    }
}
