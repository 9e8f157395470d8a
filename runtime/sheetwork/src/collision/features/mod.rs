//! Features of a collider for contact: half spaces, balls and closed surfaces of plane faces.
//!
//! Surfaces have faces, sharp convex edges and convex corners, in double precision and in the frame
//! of the collider (m). A sheet touches a body in three ways: nodes on faces, body edges on sheet
//! edges, body corners on sheet triangles. Only convex edges and corners can touch first; concave
//! parts are touched by nodes.

pub(crate) mod mesh;
pub(crate) mod tessellate;
#[cfg(test)]
mod tests;
pub(crate) mod topology;

use glam::DVec3;

pub use crate::collision::features::mesh::{ClosestPoint, ColliderCorner, ColliderEdge, ColliderFace, ColliderMesh};
use rapier3d::parry::shape::Shape;

/// One part of a collider, convex or concave.
#[derive(Clone)]
pub enum ColliderPart {
    /// The half space behind the plane through the origin.
    HalfSpace {
        /// Outward unit normal.
        normal: DVec3,
    },
    /// A ball.
    Ball {
        /// Centre, m.
        centre: DVec3,
        /// Radius, m.
        radius: f64,
    },
    /// A surface of plane faces.
    Mesh(Box<ColliderMesh>),
}

/// The parts of a collider, with feature indices that are unique within the collider.
#[derive(Clone, Default)]
pub struct ColliderFeatures {
    solids: Vec<(u32, ColliderPart)>,
}

impl ColliderFeatures {
    /// Features of a Parry shape. Round and curved shapes other than balls and half spaces are
    /// tessellated into faces about 3 mm wide and within 20 µm of the true surface, with at most
    /// 128 faces around. Shapes without a surface (segments, polylines, custom shapes) have no
    /// features.
    pub fn from_shape(shape: &dyn Shape) -> Self {
        let mut features = Self::default();
        tessellate::add(shape, &rapier3d::math::Pose::IDENTITY, &mut features);
        features
    }

    /// Features of a collider with one part.
    pub fn from_solid(solid: ColliderPart) -> Self {
        let mut features = Self::default();
        features.push(solid);
        features
    }

    /// Add a part.
    pub fn push(&mut self, solid: ColliderPart) {
        let first = self.solids.last().map_or(0, |(first, last)| first + last.count());
        self.solids.push((first, solid));
    }

    /// Parts, each with the index of its first feature.
    pub fn solids(&self) -> &[(u32, ColliderPart)] {
        &self.solids
    }

    /// Whether any part has corners and edges, which balls and half spaces lack.
    pub fn has_corners(&self) -> bool {
        self.solids.iter().any(|(_, solid)| matches!(solid, ColliderPart::Mesh(_)))
    }
}

impl ColliderPart {
    /// Part with a closed surface of triangles, counter-clockwise seen from outside; `None` without
    /// a triangle of nonzero area.
    pub fn from_triangles(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        ColliderMesh::new(vertices, triangles).map(|mesh| Self::Mesh(Box::new(mesh)))
    }

    /// Number of feature indices that the part needs.
    fn count(&self) -> u32 {
        match self {
            Self::HalfSpace { .. } | Self::Ball { .. } => 1,
            Self::Mesh(mesh) => mesh.faces().len().max(mesh.edges().len()).max(mesh.corners().len()) as u32,
        }
    }

    /// Lower and upper corner of the bounding box, m; infinite for a half space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::HalfSpace { .. } => (DVec3::NEG_INFINITY, DVec3::INFINITY),
            Self::Ball { centre, radius } => (*centre - DVec3::splat(*radius), *centre + DVec3::splat(*radius)),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }
}
