//! Tessellation of Parry's shapes.
//!
//! On a circle of radius r, faces of width w lie within w²/(8 r) of the circle. The number of faces
//! is chosen for a width of 3 mm and a distance of 20 µm, within 12 to 128. A rounded shape is the
//! convex hull of small balls at the vertices of its inner shape. Lengths in m.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use rapier3d::math::Pose;
use rapier3d::parry::shape::{Shape, TypedShape};
use rapier3d::parry::transformation::try_convex_hull;

use crate::collision::features::{ColliderFeatures, ColliderPart};
use crate::collision::settings::{BodySurfaceSettings, DetectionSettings};

const SETTINGS: BodySurfaceSettings = DetectionSettings::DEFAULT.surface;

type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// Number of faces around a circle of this radius (m).
fn around(radius: f32) -> u32 {
    let radius = f64::from(radius).max(1e-9);
    let width = SETTINGS.maximum_face_width.min((8.0 * radius * SETTINGS.maximum_face_distance).sqrt());
    // The cast is exact: the quotient is clamped.
    (TAU * radius / width).ceil().clamp(12.0, 128.0) as u32
}

/// Add the parts of `shape`, placed at `place` in the frame of the collider.
pub(crate) fn add(shape: &dyn Shape, place: &Pose, to: &mut ColliderFeatures) {
    let triangles = match shape.as_typed_shape() {
        TypedShape::HalfSpace(plane) if place.translation == Vec3::ZERO => {
            let normal = (place.rotation * plane.normal).as_dvec3().normalize_or(DVec3::Y);
            return to.push(ColliderPart::HalfSpace { normal });
        }
        TypedShape::Ball(ball) => {
            return to.push(ColliderPart::Ball { centre: place.translation.as_dvec3(), radius: ball.radius.into() });
        }
        TypedShape::Compound(compound) => {
            for (at, part) in compound.shapes() {
                add(part.as_ref(), &(*place * *at), to);
            }
            return;
        }
        typed => triangles_of(&typed),
    };
    let Some((vertices, triangles)) = triangles else { return };
    let vertices: Vec<DVec3> =
        vertices.into_iter().map(|v| (place.rotation * v + place.translation).as_dvec3()).collect();
    if let Some(solid) = ColliderPart::from_triangles(&vertices, &triangles) {
        to.push(solid);
    }
}

fn triangles_of(shape: &TypedShape) -> Option<Triangles> {
    match shape {
        TypedShape::Cuboid(s) => Some(s.to_trimesh()),
        TypedShape::ConvexPolyhedron(s) => Some(s.to_trimesh()),
        TypedShape::TriMesh(s) => Some((s.vertices().to_vec(), s.indices().to_vec())),
        TypedShape::Triangle(s) => Some((vec![s.a, s.b, s.c], vec![[0, 1, 2]])),
        TypedShape::HeightField(s) => Some(s.to_trimesh()),
        TypedShape::Voxels(s) => Some(s.to_trimesh()),
        TypedShape::Cylinder(s) => Some(s.to_trimesh(around(s.radius))),
        TypedShape::Cone(s) => Some(s.to_trimesh(around(s.radius))),
        TypedShape::Capsule(s) => rounded(vec![s.segment.a, s.segment.b], s.radius),
        TypedShape::RoundCuboid(s) => rounded(s.inner_shape.to_trimesh().0, s.border_radius),
        TypedShape::RoundTriangle(s) => {
            rounded(vec![s.inner_shape.a, s.inner_shape.b, s.inner_shape.c], s.border_radius)
        }
        TypedShape::RoundCylinder(s) => {
            rounded(s.inner_shape.to_trimesh(around(s.inner_shape.radius)).0, s.border_radius)
        }
        TypedShape::RoundCone(s) => rounded(s.inner_shape.to_trimesh(around(s.inner_shape.radius)).0, s.border_radius),
        TypedShape::RoundConvexPolyhedron(s) => rounded(s.inner_shape.points().to_vec(), s.border_radius),
        _ => None,
    }
}

/// Convex hull of balls of this radius about these centres (m). The balls have vertices on all
/// axes, so that plane faces keep their position.
fn rounded(centres: Vec<Vec3>, radius: f32) -> Option<Triangles> {
    // The number of vertices is bounded: few centres have fine balls, many centres coarse ones.
    let most = (4000 / centres.len().max(1)).max(32);
    let segments = around(radius).min((most as f64).sqrt() as u32 * 2).max(8).next_multiple_of(4);
    let rings = segments / 2;
    let mut points = Vec::new();
    for centre in centres {
        for ring in 0..=rings {
            let (reach, height) = (TAU / 2.0 * f64::from(ring) / f64::from(rings)).sin_cos();
            let count = if ring == 0 || ring == rings { 1 } else { segments };
            for k in 0..count {
                let (z, x) = (TAU * f64::from(k) / f64::from(segments)).sin_cos();
                points.push(centre + DVec3::new(reach * x, height, reach * z).as_vec3() * radius);
            }
        }
    }
    try_convex_hull(&points).ok()
}
