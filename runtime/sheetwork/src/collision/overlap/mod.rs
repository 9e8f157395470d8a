//! Overlap of sheets with bodies and with each other, for the test rigs.
//!
//! The solid of a sheet is its surface of triangles between nodes, with half a thickness on either
//! side: that of the material for a single layer with the stiffness of the material, otherwise the
//! minimum contact offset. The overlap of a pair is that of the two solids, m: a sheet that rests
//! on a body has overlap 0.

pub(crate) mod distance;
pub(crate) mod nearness;
pub(crate) mod rim;
pub(crate) mod sheets;
pub(crate) mod solid;

use glam::{DQuat, DVec3};

use crate::collision::collision_surface::outer_triangles;
pub use crate::collision::overlap::sheets::{between, pairs};
pub use crate::collision::overlap::solid::OverlapSolid;
use crate::math::Vectors;
use crate::scene::contact::MINIMUM_CONTACT_OFFSET;
use crate::sheet::Sheet;

/// Distance from the nodes of a sheet at which it touches, m.
pub fn half_thickness(sheet: &Sheet) -> f64 {
    if sheet.model.layers.len() == 1 && sheet.follows_material() {
        0.5 * sheet.material().thickness
    } else {
        MINIMUM_CONTACT_OFFSET
    }
}

/// Outer surfaces of a sheet as triangles between its nodes, without those of open cells.
pub fn faces(sheet: &Sheet) -> Vec<[u32; 3]> {
    outer_triangles(sheet)
}

/// Corners of a triangle, m.
pub fn corners(x: &Vectors, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| x.get(i as usize))
}

/// Position and rotation of a body.
#[derive(Clone, Copy)]
pub struct BodyPose {
    /// Position of the origin, m.
    pub position: DVec3,
    /// Rotation from the frame of the body to the world.
    pub rotation: DQuat,
}

impl BodyPose {
    /// A world point in the frame of the body, m.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.position)
    }
}

/// Overlap (m) of the deepest node, and of the deepest point of the whole surface, with a body;
/// negative if they are farther away than the half thickness.
pub fn with_body(sheet: &Sheet, faces: &[[u32; 3]], solid: &OverlapSolid, frame: &BodyPose) -> (f64, f64) {
    let half = half_thickness(sheet);
    let local: Vec<DVec3> = sheet.state.x.iter().map(|p| frame.local(p)).collect();
    let masses = local.iter().map(|p| half + solid.depth(*p)).fold(f64::NEG_INFINITY, f64::max);
    if matches!(solid, OverlapSolid::HalfSpace) {
        return (masses, masses);
    }
    let reach = 2.0 * half;
    let surface = faces.iter().map(|t| half + solid.overlap(&t.map(|i| local[i as usize]), reach));
    (masses, surface.fold(masses, f64::max))
}
