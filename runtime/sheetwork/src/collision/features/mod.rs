//! What a collider is made of, as contact sees it: half spaces, balls and closed surfaces of plane faces with their sharp
//! convex edges and corners, in double precision and in the collider's frame (m).
//!
//! A sheet meets a body in three ways: masses on faces, body edges on sheet edges, body corners on sheet triangles. Only
//! convex edges and corners can come first; what lies in a hollow is met by the masses.

pub(crate) mod mesh;
pub(crate) mod tessellate;
#[cfg(test)]
mod tests;
pub(crate) mod topology;

use glam::DVec3;

pub use crate::collision::features::mesh::{Corner, Edge, Face, Mesh, Nearest};
use rapier3d::parry::shape::Shape;

/// One convex or concave piece of a collider.
#[derive(Clone)]
pub enum Solid {
    /// Everything behind the plane through the origin with this outward unit normal.
    HalfSpace {
        /// Outward normal, unit.
        normal: DVec3,
    },
    /// A ball.
    Ball {
        /// Its centre, m.
        centre: DVec3,
        /// Its radius, m.
        radius: f64,
    },
    /// A surface of plane faces.
    Mesh(Box<Mesh>),
}

/// A collider's pieces. The features of all pieces are numbered through, so that a number names one.
#[derive(Clone, Default)]
pub struct Features {
    solids: Vec<(u32, Solid)>,
}

impl Features {
    /// Of any Parry shape. Round and curved shapes other than balls and half spaces become surfaces of faces of about 3 mm
    /// that lie within 20 µm of the true surface, as far as 128 faces around allow. Shapes without a surface (segments,
    /// polylines, shapes of other crates) have no features.
    pub fn of(shape: &dyn Shape) -> Self {
        let mut features = Self::default();
        tessellate::add(shape, &rapier3d::math::Pose::IDENTITY, &mut features);
        features
    }

    /// A collider of one piece.
    pub fn from_solid(solid: Solid) -> Self {
        let mut features = Self::default();
        features.push(solid);
        features
    }

    /// Adds a piece.
    pub fn push(&mut self, solid: Solid) {
        let first = self.solids.last().map_or(0, |(first, last)| first + last.count());
        self.solids.push((first, solid));
    }

    /// Its pieces, each with the number of its first feature.
    pub fn solids(&self) -> &[(u32, Solid)] {
        &self.solids
    }

    /// Whether it has corners and edges, which a ball or a half space has not.
    pub fn has_corners(&self) -> bool {
        self.solids.iter().any(|(_, solid)| matches!(solid, Solid::Mesh(_)))
    }
}

impl Solid {
    /// A closed surface of triangles, counter-clockwise seen from outside; `None` when there is no triangle.
    pub fn from_triangles(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        Mesh::new(vertices, triangles).map(|mesh| Self::Mesh(Box::new(mesh)))
    }

    /// How many numbers its features need.
    fn count(&self) -> u32 {
        match self {
            Self::HalfSpace { .. } | Self::Ball { .. } => 1,
            Self::Mesh(mesh) => mesh.faces().len().max(mesh.edges().len()).max(mesh.corners().len()) as u32,
        }
    }

    /// Corners of the box around it, m; infinite for a half space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::HalfSpace { .. } => (DVec3::NEG_INFINITY, DVec3::INFINITY),
            Self::Ball { centre, radius } => (*centre - DVec3::splat(*radius), *centre + DVec3::splat(*radius)),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }
}
