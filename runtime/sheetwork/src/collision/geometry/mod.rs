//! Distances between points, triangles and edges, and times of impact of moving ones.
//!
//! Pure functions. Lengths in m; time is the fraction 0 to 1 of the motion.

pub(crate) mod closest_points;
pub(crate) mod time_of_impact;
pub(crate) mod triangle_intersection;

pub use crate::collision::geometry::closest_points::{
    barycentric_along, point_segment, point_triangle, segment_segment,
};
pub use crate::collision::geometry::time_of_impact::{EdgeImpact, PointImpact, edges_meet, point_meets_triangle};
pub use crate::collision::geometry::triangle_intersection::triangles_intersect;
pub use crate::math::cubic::{Roots, roots_in_unit_interval};
