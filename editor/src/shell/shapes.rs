//! Meshes and textures: bodies with flat faces, planes with a square grid, dots for masses, the backdrop.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use sheetwork::scene::Polyhedron;
use sheetwork::sheet::surface::SurfaceMesh;

fn triangles(positions: Vec<[f32; 3]>, normals: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}

/// Polyhedra with a normal a face, in their own coordinates, m.
pub fn polyhedra(bodies: &[Polyhedron]) -> Mesh {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for body in bodies {
        for face in 0..body.faces.len() {
            let normal = body.face_normal(face).as_vec3().to_array();
            for corner in body.triangulate_face(face).into_iter().flatten() {
                let vertex = body.vertices.get(corner as usize).copied().unwrap_or_default();
                positions.push(vertex.as_vec3().to_array());
                normals.push(normal);
            }
        }
    }
    let indices = (0..positions.len() as u32).collect();
    triangles(positions, normals, indices)
}

/// A rectangle from `corner` along two edges, m, seen from the side of their cross product; the texture repeats every
/// `tile` m and starts at the world's origin.
pub fn plane(corner: Vec3, [along, up]: [Vec3; 2], tile: f32) -> Mesh {
    let corners = [corner, corner + along, corner + along + up, corner + up];
    let (u, v) = (along.normalize_or(Vec3::X), up.normalize_or(Vec3::Y));
    let uvs: Vec<[f32; 2]> = corners.iter().map(|p| [p.dot(u) / tile, p.dot(v) / tile]).collect();
    let normal = u.cross(v).to_array();
    let positions = corners.iter().map(Vec3::to_array).collect();
    let mesh = triangles(positions, vec![normal; 4], vec![0, 1, 2, 0, 2, 3]);
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
    // Tangents are not needed: there is no normal map.
    mesh
}

/// A sheet's surface.
pub fn sheet(surface: &SurfaceMesh) -> Mesh {
    let indices = surface.indices.iter().flatten().copied().collect();
    triangles(surface.positions.clone(), surface.normals.clone(), indices)
}

/// A round dot of radius 1, for a mass.
pub fn dot() -> Mesh {
    Sphere::new(1.0).mesh().ico(2).unwrap_or_else(|_| Sphere::new(1.0).mesh().uv(12, 8))
}

/// Cells along each edge of the grid texture; the lines around a tile are stronger.
pub const CELLS: u32 = 5;

/// A tile of [`CELLS`] by [`CELLS`] grid cells: white with soft grey lines, and every smaller copy down to a pixel, so that
/// far lines fade instead of flickering.
pub fn grid_texture() -> Image {
    let size = 1024_u32;
    let mut level: Vec<f32> = (0..size * size).map(|i| grid_value(i % size, i / size, size)).collect();
    let (mut data, mut side, mut levels) = (Vec::new(), size as usize, 0);
    loop {
        for value in &level {
            let byte = (255.0 * value + 0.5) as u8;
            data.extend([byte, byte, byte, 255]);
        }
        levels += 1;
        if side == 1 {
            break;
        }
        let half = side / 2;
        let at = |x: usize, y: usize| level[y * side + x];
        let mean = |i: usize| {
            let (x, y) = (2 * (i % half), 2 * (i / half));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        level = (0..half * half).map(mean).collect();
        side = half;
    }
    let extent = Extent3d { width: size, height: size, depth_or_array_layers: 1 };
    let mut image = Image::new_uninit(
        extent,
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 16,
        ..default()
    });
    image
}

/// Brightness of pixel (x, y) of the grid: lines lie on the edges of cells.
fn grid_value(x: u32, y: u32, size: u32) -> f32 {
    let cell = size as f32 / CELLS as f32;
    let mut value = 1.0_f32;
    for c in [x, y] {
        let p = c as f32 + 0.5;
        let to = |step: f32| (p / step - (p / step).round()).abs() * step;
        for (step, width, depth) in [(cell, 1.6, 0.13), (size as f32, 3.2, 0.30)] {
            let cover = (width + 0.5 - to(step)).clamp(0.0, 1.0);
            value = value.min(1.0 - depth * cover);
        }
    }
    value
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
