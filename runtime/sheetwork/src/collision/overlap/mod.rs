//! How deep sheets are in bodies and in each other: the surface as triangles between masses, with its half thickness on either side.
//!
//! A sheet of one layer that follows its material is as thick as its material says. Other lattices touch at their masses. The
//! penetration of a pair is what their solids overlap by, thickness included, m: a sheet that lies on a body as it should has 0.

pub(crate) mod distance;
pub(crate) mod sheets;
pub(crate) mod solid;

use glam::{DQuat, DVec3};

pub use crate::collision::overlap::sheets::{between, pairs};
pub use crate::collision::overlap::solid::Solid;
use crate::contact::SKIN;
use crate::math::Vectors;
use crate::sheet::Sheet;

/// Distance from a sheet's masses at which it touches, m.
pub fn half_thickness(sheet: &Sheet) -> f64 {
    if sheet.layers.len() == 1 && sheet.follows_material() { 0.5 * sheet.material().thickness } else { SKIN }
}

/// The outer surfaces of a sheet as triangles between its masses.
pub fn faces(sheet: &Sheet) -> Vec<[u32; 3]> {
    if let Some(triangles) = &sheet.triangles {
        return triangles.clone();
    }
    let outer = sheet.layers.first().into_iter().chain(sheet.layers.last().filter(|_| sheet.layers.len() > 1));
    outer.flat_map(crate::mesh::structure::Layer::triangles).collect()
}

/// Corners of a triangle between masses.
pub fn corners(x: &Vectors, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| x.get(i as usize))
}

/// Place and turn of a body.
#[derive(Clone, Copy)]
pub struct Frame {
    /// Where its origin is, m.
    pub position: DVec3,
    /// How it is turned.
    pub rotation: DQuat,
}

impl Frame {
    /// A point of the world in the body's frame.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.position)
    }
}

/// Overlap of the deepest mass and of the deepest place of the whole surface with a body, m; negative where all are further than the
/// half thickness.
pub fn with_body(sheet: &Sheet, faces: &[[u32; 3]], solid: &Solid, frame: &Frame) -> (f64, f64) {
    let half = half_thickness(sheet);
    let local: Vec<DVec3> = sheet.x.iter().map(|p| frame.local(p)).collect();
    let masses = local.iter().map(|p| half + solid.depth(*p)).fold(f64::NEG_INFINITY, f64::max);
    if matches!(solid, Solid::HalfSpace) {
        return (masses, masses);
    }
    let reach = 2.0 * half;
    let surface = faces.iter().map(|t| half + solid.overlap(&t.map(|i| local[i as usize]), reach));
    (masses, surface.fold(masses, f64::max))
}
