//! Settings of collision detection: tolerances and thresholds of surfaces and narrow phase.
//!
//! Lengths are multiples of the half thickness of the thinner sheet where a field does not say
//! otherwise, so that a scene of another size is detected alike. Fractions of the contact offset
//! are of the distance at which two surfaces touch.

use glam::DVec3;

use crate::units::settings::settings;

settings! {
    /// Settings of collision detection.
    pub struct DetectionSettings {
        /// Distance of two features at their time of impact: rounding.
        pub impact_distance_tolerance: f64 = 4e-6,
        /// Distance by which closest points may be displaced along their features: rounding.
        /// Below this height of a point over a triangle its side is taken from the start of the
        /// stage.
        pub rounding_distance: f64 = 4e-4,
        /// Distance, added to three contact offsets, up to which the closest features at the base
        /// determine the contact.
        pub closest_feature_distance: f64 = 2.0,
        /// Overlap at the start of a stage above which a pair is rejected: it then lies on
        /// opposite sides of a thin sheet or body.
        pub maximum_initial_overlap: f64 = 0.5,
        /// Slide from the base, as a fraction of an edge of the sheet, above which an edge contact
        /// is lost, unless an outer iteration has shown that contact holds it.
        pub maximum_slide: f64 = 0.4,
        /// Surfaces of bodies: faces, edges and corners.
        pub surface: BodySurfaceSettings = BodySurfaceSettings::DEFAULT,
        /// Equivalent constraints.
        pub duplicates: DuplicateSettings = DuplicateSettings::DEFAULT,
        /// Edges of sheets on edges of bodies or sheets.
        pub edge_edge: EdgeEdgeSettings = EdgeEdgeSettings::DEFAULT,
        /// Nodes on faces of bodies.
        pub vertex_face: VertexFaceSettings = VertexFaceSettings::DEFAULT,
        /// Triangles on balls.
        pub triangle_ball: TriangleBallSettings = TriangleBallSettings::DEFAULT,
        /// Pairs of sheets, and a sheet with itself.
        pub sheet_pairs: SheetPairSettings = SheetPairSettings::DEFAULT,
        /// Test of overlap, independent of the contacts.
        pub overlap: OverlapSettings = OverlapSettings::DEFAULT,
    }

    /// Test of overlap of sheets with bodies and with each other.
    pub struct OverlapSettings {
        /// Accepted overlap, in thicknesses.
        pub depth: f64 = 0.1,
        /// Cosine between the normal of a triangle and the mean normal of its sheet, above which
        /// for all triangles the sheet does not meet itself.
        pub unfolded_cosine: f64 = 0.5,
    }

    /// Surfaces of bodies: faces, edges and corners.
    pub struct BodySurfaceSettings {
        /// Maximum width of a face of a curved surface, m.
        pub maximum_face_width: f64 = 3e-3,
        /// Maximum distance of such a face from the true surface, m.
        pub maximum_face_distance: f64 = 2e-5,
        /// Sine of the angle between triangles below which they form one face.
        pub plane_sine: f64 = 1e-3,
        /// Distance, as a fraction of the size of the surface, below which vertices are merged.
        pub weld_distance: f64 = 1e-6,
        /// Number of faces up to which all planes of a convex solid are tested without a query
        /// structure.
        pub maximum_faces_without_tree: usize = 32,
    }

    /// Thresholds above which two constraints are equivalent.
    pub struct DuplicateSettings {
        /// Cosine between normals above which two constraints may be equivalent.
        pub normal_cosine: f64 = 0.98,
        /// Distance between the points of two constraints, as a fraction of the contact offset,
        /// below which they may be equivalent.
        pub point_distance: f64 = 0.05,
        /// Barycentric weight above which a point counts as the node.
        pub node_weight: f64 = 0.98,
    }

    /// Edges of sheets on edges of bodies or sheets. Sines and cosines are of angles.
    pub struct EdgeEdgeSettings {
        /// Sine of the angle below which two edges are parallel and have no edge contact.
        pub parallel_sine: f64 = 0.01,
        /// Sine of the angle below which the normal of the sheet is used.
        pub nearly_parallel_sine: f64 = 0.1,
        /// Tolerance, as a sine, for a normal beyond those of the faces.
        pub normal_cone_tolerance: f64 = 0.1,
        /// Tolerance of an edge parameter beyond its ends.
        pub parameter_tolerance: f64 = 1e-3,
        /// Cosine between contact normal and surface normal up to which an inner edge of a sheet
        /// has no contact.
        pub inner_edge_cosine: f64 = 0.3,
        /// Sine of the angle by which the normal at a border or a fold may point out of the sheet.
        pub inward_sine: f64 = 0.1,
    }

    /// Nodes on faces of bodies: choice of the face near a rim.
    pub struct VertexFaceSettings {
        /// Distance from a rim within which either adjacent face may be chosen.
        pub rim_distance: f64 = 0.2,
        /// Depth below its plane at which a node may pass a rim and still belong to the face
        /// parallel to the sheet, in addition to the free fall of a resting sheet in the stage.
        pub rim_passing_depth: f64 = 4.0,
        /// Cosine below which two faces form a ridge: a node that passes over it is below the
        /// planes of both and crosses neither face.
        pub ridge_cosine: f64 = -0.1,
        /// Cosine above which two faces are joined smoothly.
        pub smooth_cosine: f64 = 0.7,
        /// Depth up to which a node that cuts across a corner has not passed through the body.
        pub corner_cut_depth: f64 = 4.0,
    }

    /// Triangles of a sheet on balls.
    pub struct TriangleBallSettings {
        /// Maximum number of steps of conservative advancement; each removes most of the distance.
        pub maximum_advancement_steps: usize = 40,
        /// Cosine within which the direction at the end counts as that at the base.
        pub same_side_cosine: f64 = 0.8,
        /// Distance from contact within which the triangle rests on the ball.
        pub resting_distance: f64 = 0.08,
        /// Relative tolerance of comparisons of distances: rounding.
        pub relative_tolerance: f64 = 1e-9,
        /// Maximum number of triangles visited around a node.
        pub maximum_fan: usize = 64,
    }

    /// Pairs of sheets, and a sheet with itself.
    pub struct SheetPairSettings {
        /// Pairs of sheets per parallel task.
        pub pairs_per_task: usize = 4,
        /// Shift, as a fraction of the contact offset, by which one sheet is moved to test
        /// interpenetration. Two sheets interpenetrate if they intersect with the shift in either
        /// direction; sheets that only touch do not. The unequal components keep nodes off
        /// triangles and edges off edges of a sheet that is created in the same place.
        pub interpenetration_shift: DVec3 = DVec3::new(4.8e-4, 6.1e-4, 6.3e-4),
        /// Fraction of the contact offset below which the side of a node is undetermined.
        pub undetermined_side_height: f64 = 0.3,
        /// Fraction of an edge at each end within which a contact belongs to the end node.
        pub end_fraction: f64 = 0.02,
        /// Cosine between normals above which two constraints act in the same direction.
        pub same_direction_cosine: f64 = 0.9,
        /// Fraction of the contact offset above which one sheet lies over another.
        pub lying_over_height: f64 = 0.8,
        /// Fraction of the contact offset above which the motion within a stage may carry features
        /// past each other that are near at the base.
        pub fast_motion: f64 = 0.5,
        /// Factor on the neighbour distance at rest below which features belong to the same region
        /// of a sheet.
        pub neighbour_factor: f64 = 4.0,
        /// Fraction of the contact offset below which a ridge counts as flat.
        pub flat_ridge_height: f64 = 0.02,
        /// Minimum cosine between a triangle and the projection direction of a height graph, which
        /// excludes self-contact.
        pub minimum_graph_cosine: f64 = 0.2,
        /// Minimum cosine times height of a triangle over contact offset in a height graph. Two
        /// walls of that slope are farther apart than the thickness at a distance of one triangle
        /// from their common line.
        pub minimum_graph_height: f64 = 3.0,
    }
}
