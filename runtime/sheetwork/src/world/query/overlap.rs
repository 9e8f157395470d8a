//! Overlap of balls and cuboids with points and triangles.

use glam::{DMat3, DVec3};

use crate::collision::bvh::BoundingBox;
use crate::collision::geometry::point_triangle;
use crate::world::query::QueryShape;
use crate::world::query::surface::combine;

/// Valid solid with its bounding box in the world; lengths in m.
pub(super) struct OverlapShape {
    centre: DVec3,
    solid: Solid,
    pub bounds: BoundingBox,
}

enum Solid {
    Ball { squared_radius: f64 },
    Cuboid { to_local: DMat3, half_extents: DVec3 },
}

impl OverlapShape {
    /// `None` for a value that is not finite or out of range.
    pub fn new(shape: &QueryShape) -> Option<Self> {
        let (centre, reach, solid) = match *shape {
            QueryShape::Ball { centre, radius } if radius >= 0.0 => {
                (centre, DVec3::splat(radius), Solid::Ball { squared_radius: radius * radius })
            }
            QueryShape::Cuboid { centre, rotation, half_extents }
                if half_extents.cmpge(DVec3::ZERO).all() && rotation.length_squared() > 0.0 =>
            {
                let turn = DMat3::from_quat(rotation.normalize());
                let reach = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs()) * half_extents;
                (centre, reach, Solid::Cuboid { to_local: turn.transpose(), half_extents })
            }
            _ => return None,
        };
        let is_valid = centre.is_finite() && reach.is_finite();
        let bounds = BoundingBox { low: centre - reach, high: centre + reach };
        is_valid.then_some(Self { centre, solid, bounds })
    }

    /// Whether the solid contains a point.
    pub fn contains(&self, point: DVec3) -> bool {
        let from = point - self.centre;
        match &self.solid {
            Solid::Ball { squared_radius } => from.length_squared() <= *squared_radius,
            Solid::Cuboid { to_local, half_extents } => (*to_local * from).abs().cmple(*half_extents).all(),
        }
    }

    /// Whether the solid and a triangle have a common point.
    pub fn meets_triangle(&self, corners: [DVec3; 3]) -> bool {
        match &self.solid {
            Solid::Ball { squared_radius } => {
                let nearest = combine(corners, point_triangle(self.centre, corners));
                nearest.distance_squared(self.centre) <= *squared_radius
            }
            Solid::Cuboid { to_local, half_extents } => {
                cuboid_meets_triangle(*half_extents, corners.map(|p| *to_local * (p - self.centre)))
            }
        }
    }
}

/// Separating axes of a cuboid about the origin and a triangle: the axes of the cuboid, the normal
/// of the triangle, and the products of axes and sides (Akenine-Möller, *Fast 3D triangle-box
/// overlap testing*, 2001).
fn cuboid_meets_triangle(half_extents: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let sides = [b - a, c - b, a - c];
    let is_separated = |axis: DVec3| {
        let at = [a, b, c].map(|p| p.dot(axis));
        let reach = half_extents.dot(axis.abs());
        let low = at[0].min(at[1]).min(at[2]);
        let high = at[0].max(at[1]).max(at[2]);
        low > reach || high < -reach
    };
    let axes = DVec3::AXES;
    let products = axes.iter().flat_map(|axis| sides.iter().map(|side| axis.cross(*side)));
    !axes.into_iter().chain([sides[0].cross(sides[1])]).chain(products).any(is_separated)
}
