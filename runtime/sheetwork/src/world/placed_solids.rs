//! Convex parts of the bodies of a world as they lie, to measure the depth of sheets in them.

use glam::DVec3;

use crate::collision::overlap::sheets::{NearestPlace, PlacedSheet};
use crate::collision::overlap::solid::ConvexSolid;
use crate::collision::overlap::{BodyPose, OverlapSolid, half_thickness};
use crate::rigid::RigidWorld;
use crate::scene::Shape;

/// A convex part of a body.
pub(super) struct PlacedSolid<'a> {
    /// Index and name of the body.
    pub body: usize,
    pub name: &'a str,
    solid: OverlapSolid,
    pose: BodyPose,
    /// Normals of the faces.
    pub normals: Vec<DVec3>,
    /// Centre and radius of a sphere around it; `None` for a half space.
    sphere: Option<(DVec3, f64)>,
}

impl PlacedSolid<'_> {
    /// Greatest depth of a sheet, moved by `by`, in the solid, with the place; negative outside.
    pub fn depth_of(&self, sheet: &PlacedSheet, by: DVec3) -> Option<NearestPlace> {
        let reach = 2.0 * half_thickness(sheet.sheet);
        let away = |(centre, radius): (DVec3, f64)| {
            centre.clamp(sheet.low + by, sheet.high + by).distance(centre) > radius + reach
        };
        if self.sphere.is_some_and(away) { None } else { sheet.depth(by, &self.solid, &self.pose) }
    }

    /// Side of a triangle, 1 or -1 along its normal, on which the solid is nearer to its plane than
    /// `half` (m) without reaching it; `None` if it is not.
    pub fn side_of(&self, triangle: &[DVec3; 3], half: f64) -> Option<f64> {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let overlap = |by: f64| self.solid.overlap(&triangle.map(|p| self.pose.local(p + normal * by)), 2.0 * half);
        let depth = overlap(0.0);
        (depth < 0.0 && depth > -half).then(|| (overlap(half) - overlap(-half)).signum())
    }
}

/// The convex parts of all bodies, in the order of the bodies. Sensors and parts that are not
/// convex are left out.
pub(super) fn placed_solids(rigid: Option<&RigidWorld>) -> Vec<PlacedSolid<'_>> {
    let mut all = Vec::new();
    for (body, of) in rigid.into_iter().flat_map(|r| r.bodies().iter().enumerate()) {
        let Some(state) = rigid.filter(|r| !r.is_sensor(body)).and_then(|r| r.state(body)) else { continue };
        let pose = BodyPose { position: state.origin(), rotation: state.rotation() };
        let mut add = |solid, normals: Vec<DVec3>, sphere: Option<(DVec3, f64)>| {
            let normals = normals.into_iter().map(|n| pose.rotation * n).collect();
            let sphere = sphere.map(|(centre, radius)| (pose.position + pose.rotation * centre, radius));
            all.push(PlacedSolid { body, name: &of.name, solid, pose, normals, sphere });
        };
        match of.shape {
            Shape::HalfSpace => add(OverlapSolid::HalfSpace, vec![DVec3::Y], None),
            Shape::Ball(radius) => {
                add(OverlapSolid::Ball(radius), DVec3::AXES.to_vec(), Some((DVec3::ZERO, radius)));
            }
            _ => {
                for polyhedron in of.polyhedra.iter().filter(|p| crate::rigid::shape::is_convex(p)) {
                    let normals = (0..polyhedron.faces.len()).map(|face| polyhedron.face_normal(face)).collect();
                    let (low, high) = polyhedron.bounds();
                    let sphere = (low.midpoint(high), 0.5 * low.distance(high));
                    add(OverlapSolid::Convex(ConvexSolid::new(polyhedron)), normals, Some(sphere));
                }
            }
        }
    }
    all
}
