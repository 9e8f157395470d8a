//! Tangents of a displayed sheet, for normal maps.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

/// Insert or update the tangents of a mesh with positions, normals and (u, v) from `triangles`.
///
/// The tangent of a vertex is the mean of dx/du over its triangles, weighted by area, without its
/// part along the normal; the fourth component gives the bitangent w (n × t) = -dx/dv, as
/// [`Mesh::generate_tangents`] does, without splitting vertices. A vertex without a direction of u
/// has any tangent. Nothing is allocated where the mesh has tangents; a mesh without positions is
/// unchanged.
pub(super) fn update_tangents(mesh: &mut Mesh, triangles: &[[u32; 3]]) {
    let Some(count) = vectors(mesh, Mesh::ATTRIBUTE_POSITION).map(<[_]>::len) else { return };
    let mut tangents = match mesh.try_attribute_mut(Mesh::ATTRIBUTE_TANGENT) {
        Ok(VertexAttributeValues::Float32x4(values)) => std::mem::take(values),
        _ => Vec::new(),
    };
    tangents.clear();
    tangents.resize(count, [0.0; 4]);
    if let (Some(positions), Some(normals), Ok(VertexAttributeValues::Float32x2(uvs))) = (
        vectors(mesh, Mesh::ATTRIBUTE_POSITION),
        vectors(mesh, Mesh::ATTRIBUTE_NORMAL),
        mesh.try_attribute(Mesh::ATTRIBUTE_UV_0),
    ) {
        compute(positions, normals, uvs, triangles, &mut tangents);
    }
    match mesh.try_attribute_mut(Mesh::ATTRIBUTE_TANGENT) {
        Ok(VertexAttributeValues::Float32x4(values)) => *values = tangents,
        _ => mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, tangents),
    }
}

fn vectors(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Option<&[[f32; 3]]> {
    mesh.try_attribute(attribute).ok()?.as_float3()
}

fn compute(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    uvs: &[[f32; 2]],
    triangles: &[[u32; 3]],
    tangents: &mut [[f32; 4]],
) {
    for corners in triangles.iter().map(|t| t.map(|i| i as usize)) {
        let get = |i: usize| Some((Vec3::from(*positions.get(i)?), Vec2::from(*uvs.get(i)?)));
        let [Some((p, a)), Some((q, b)), Some((r, c))] = corners.map(get) else { continue };
        let (first, second, du, dv) = (q - p, r - p, b - a, c - a);
        // Twice the area in (u, v); its sign is the handedness of the triangle.
        let area = du.perp_dot(dv);
        if area == 0.0 {
            continue;
        }
        let direction = (first * dv.y - second * du.y) * area.signum();
        let weight = first.cross(second).length();
        let direction = direction.normalize_or_zero() * weight;
        for i in corners {
            if let Some(sum) = tangents.get_mut(i) {
                *sum = (Vec4::from(*sum) + direction.extend(weight * area.signum())).to_array();
            }
        }
    }
    for (tangent, normal) in tangents.iter_mut().zip(normals) {
        let (normal, sum) = (Vec3::from(*normal), Vec4::from(*tangent));
        let along = sum.truncate().reject_from_normalized(normal).try_normalize();
        let unit = along.unwrap_or_else(|| normal.any_orthonormal_vector());
        // Corners counter-clockwise in (u, v) have n × t along dx/dv.
        *tangent = unit.extend(if sum.w > 0.0 { -1.0 } else { 1.0 }).to_array();
    }
}
