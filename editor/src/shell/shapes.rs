//! Meshes that only the editor has: dots for masses, the backdrop.

use bevy::prelude::*;

/// A round dot of radius 1, for a mass.
pub fn dot() -> Mesh {
    Sphere::new(1.0).mesh().ico(2).unwrap_or_else(|_| Sphere::new(1.0).mesh().uv(12, 8))
}

/// The inside of a large ball, darker above than below: what lies behind the room.
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
