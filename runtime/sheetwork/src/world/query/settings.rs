//! Settings of geometric queries.

use crate::units::settings::settings;

settings! {
    /// Settings of geometric queries.
    pub struct QuerySettings {
        /// Triangles of a block, which has one bounding box.
        pub block: usize = 32,
        /// Growth of bounding boxes against rounding, relative to the largest coordinate.
        pub box_growth: f64 = 1e-14,
        /// Relative rounding error of a distance to a plane of a box, with a margin.
        pub distance_rounding: f64 = 16.0 * f64::EPSILON,
        /// Weight by which a material point may lie outside a triangle, so that none falls between
        /// two.
        pub weight_slack: f64 = 1e-6,
        /// Rings of triangles around a point whose curvature is fitted.
        pub curvature_rings: usize = 2,
        /// Least ratio of the pivots of the normal equations at which the nodes define the fit:
        /// above the rounding error of nodes on two parallel lines, 1e-16, and below a regular
        /// grid, 1e-3.
        pub least_pivot_ratio: f64 = 1e-9,
    }
}
