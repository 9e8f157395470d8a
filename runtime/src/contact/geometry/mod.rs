//! Distances between points, triangles and edges, and the times at which moving ones meet. Pure functions, m and s-free:
//! time runs from 0 to 1 over the motion.

mod closest;
mod cubic;
mod cut;
mod moving;

pub use closest::{barycentric_along, point_segment, point_triangle, segment_segment};
pub use cubic::{Roots, roots_in_unit_interval};
pub use cut::triangles_cut;
pub use moving::{EdgeImpact, PointImpact, edges_meet, point_meets_triangle};
