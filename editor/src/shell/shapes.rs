//! Meshes of the editor: dots of nodes, heat gun, backdrop.

use bevy::prelude::*;

/// Dot of radius 1 for a node.
pub fn dot() -> Mesh {
    Sphere::new(1.0).mesh().ico(2).unwrap_or_else(|_| Sphere::new(1.0).mesh().uv(12, 8))
}

/// Heat gun of reach 1 that blows along +y, with its nozzle at the origin: a nozzle and a tapered
/// barrel.
pub fn barrel() -> Mesh {
    let frustum = |radius_top: f32, radius_bottom: f32, from: f32, to: f32| {
        let height = to - from;
        let middle = Vec3::Y * (0.5 * (from + to));
        ConicalFrustum { radius_top, radius_bottom, height }.mesh().resolution(32).build().translated_by(middle)
    };
    let mut all = frustum(0.07, 0.07, -0.22, 0.0);
    for part in [frustum(0.075, 0.15, -0.36, -0.22), frustum(0.15, 0.15, -1.0, -0.36)] {
        // All parts have the same attributes.
        let _ = all.merge(&part);
    }
    all
}

/// Jet of a heat gun of reach 1 along +y, up to half of its convection, as wide as its half angle
/// (radians).
pub fn jet(half_angle: f32) -> Mesh {
    let wide = half_angle.clamp(0.01, 1.4).tan();
    ConicalFrustum { radius_top: wide, radius_bottom: 0.02, height: 1.0 }
        .mesh()
        .resolution(32)
        .build()
        .translated_by(0.5 * Vec3::Y)
}

/// Inside of a large ball behind the room, darker above than below.
pub fn backdrop() -> Mesh {
    let mut mesh = Sphere::new(1.0).mesh().uv(48, 32);
    let colours: Vec<[f32; 4]> = match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(positions) => positions
            .as_float3()
            .unwrap_or_default()
            .iter()
            .map(|p| {
                let below = LinearRgba::rgb(0.60, 0.61, 0.62);
                let above = LinearRgba::rgb(0.13, 0.19, 0.29);
                let s = (0.72 + 0.9 * p[1]).clamp(0.0, 1.0);
                let colour = below + (above - below) * (s * s * (3.0 - 2.0 * s));
                [colour.red, colour.green, colour.blue, 1.0]
            })
            .collect(),
        None => Vec::new(),
    };
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colours);
    mesh
}
