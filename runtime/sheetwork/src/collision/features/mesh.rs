//! Collider surface of plane faces: faces, sharp convex edges, convex corners, and distance
//! queries.
//!
//! The signed distance of a point x from face k is d_k = n_k·x - c_k, m. A convex solid is the set
//! of points for which all d_k are negative.

use glam::{DVec3, Vec3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d::parry::query::{PointQueryWithLocation, Ray, RayCast};
use rapier3d::parry::shape::{FeatureId, TriMesh, TriMeshFlags};

use crate::collision::features::topology::MeshTopology;
use crate::collision::settings::{BodySurfaceSettings, DetectionSettings};

const SETTINGS: BodySurfaceSettings = DetectionSettings::DEFAULT.surface;

/// A face: connected triangles of one plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColliderFace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// Offset of the plane: n·x of its points, m.
    pub distance: f64,
}

impl ColliderFace {
    /// Signed distance of a point, m; positive outside.
    #[inline]
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.distance
    }
}

/// A sharp convex edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColliderEdge {
    /// End points, m.
    pub ends: [DVec3; 2],
    /// Outward normals of the adjacent faces.
    pub normals: [DVec3; 2],
}

/// A convex corner: all its edges are sharp and convex.
#[derive(Clone, Debug, PartialEq)]
pub struct ColliderCorner {
    /// Position, m.
    pub position: DVec3,
    /// Unit directions of the edges that leave the corner.
    pub edges: Vec<DVec3>,
}

impl ColliderCorner {
    /// Whether the solid lies behind the plane through the corner with normal `n`, within the sine
    /// `slack`.
    pub fn lies_behind(&self, n: DVec3, slack: f64) -> bool {
        self.edges.iter().all(|e| e.dot(n) <= slack)
    }
}

/// Nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Position, m.
    pub point: DVec3,
    /// Whether the query point lies inside.
    pub inside: bool,
    /// Face of the nearest point.
    pub face: u32,
}

/// A surface of plane faces in double precision.
#[derive(Clone)]
pub struct ColliderMesh {
    /// Vertices, each once, m.
    pub vertices: Vec<DVec3>,
    /// Triangles with nonzero area.
    pub triangles: Vec<[u32; 3]>,
    face_of: Vec<u32>,
    faces: Vec<ColliderFace>,
    edges: Vec<ColliderEdge>,
    corners: Vec<ColliderCorner>,
    bounds: (DVec3, DVec3),
    thinness: f64,
    edge_tree: Bvh,
    /// Structure for distance and ray queries; `None` for convex solids with few faces.
    surface: Option<TriMesh>,
}

impl ColliderMesh {
    /// Surface from triangles, counter-clockwise seen from outside; `None` if all have zero area.
    pub fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let topology = MeshTopology::from_triangles(vertices, triangles)?;
        let low = topology.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = topology.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let slack = 1e-6 * low.distance(high);
        let behind = |f: &ColliderFace| topology.vertices.iter().all(|v| f.height(*v) <= slack);
        let convex = topology.closed && topology.faces.iter().all(behind);
        let thinness = if convex { thinness(&topology) } else { f64::INFINITY };
        let boxes = topology.edges.iter().map(|e| {
            let (a, b) = (e.ends[0], e.ends[1]);
            let room = 1e-6 * (a.abs().max_element() + b.abs().max_element());
            Aabb::new((a.min(b) - room).as_vec3(), (a.max(b) + room).as_vec3())
        });
        let edge_tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
        let many = !convex || topology.faces.len() > SETTINGS.maximum_faces_without_tree;
        let surface = if many { surface_of(&topology) } else { None };
        let MeshTopology { vertices, triangles, face_of, faces, edges, corners, .. } = topology;
        let bounds = (low, high);
        Some(Self { vertices, triangles, face_of, faces, edges, corners, bounds, thinness, edge_tree, surface })
    }

    /// Faces.
    pub fn faces(&self) -> &[ColliderFace] {
        &self.faces
    }

    /// Sharp convex edges.
    pub fn edges(&self) -> &[ColliderEdge] {
        &self.edges
    }

    /// Convex corners.
    pub fn corners(&self) -> &[ColliderCorner] {
        &self.corners
    }

    /// Lower and upper corner of the bounding box, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Whether the solid is convex with few faces, so that all planes are tested.
    pub fn uses_planes(&self) -> bool {
        self.surface.is_none()
    }

    /// Whether the solid is convex.
    pub fn is_convex(&self) -> bool {
        self.thinness.is_finite()
    }

    /// Least width of a convex solid across any of its faces, m; infinite for other surfaces.
    pub fn min_width(&self) -> f64 {
        self.thinness
    }

    /// Call `visit` with the index of each edge whose box overlaps the box from `low` to `high`, m.
    pub fn edges_in(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        let around = Aabb::new(low.as_vec3(), high.as_vec3());
        for i in self.edge_tree.leaves(|node| boxes_intersect(&node.aabb(), &around)) {
            visit(i);
        }
    }

    /// Whether the box of a sharp edge, or a corner, overlaps the box from `low` to `high`, m.
    pub fn has_sharp_feature_in(&self, low: DVec3, high: DVec3) -> bool {
        let around = Aabb::new(low.as_vec3(), high.as_vec3());
        let edge = self.edge_tree.leaves(|node| boxes_intersect(&node.aabb(), &around)).next().is_some();
        edge || self.corners.iter().any(|c| c.position.cmpge(low).all() && c.position.cmple(high).all())
    }

    /// Point of the surface nearest to `p`, if its distance is below `reach` (m). Parry finds the
    /// triangle; its plane is evaluated in double precision.
    pub fn nearest(&self, p: DVec3, reach: f64) -> Option<ClosestPoint> {
        let surface = self.surface.as_ref()?;
        let (on, (triangle, _)) =
            surface.project_local_point_and_get_location_with_max_dist(p.as_vec3(), false, reach as f32)?;
        let face = *self.face_of.get(triangle as usize)?;
        let corners = self.triangles.get(triangle as usize)?.map(|i| self.vertices[i as usize]);
        let w = crate::collision::geometry::point_triangle(p, corners);
        let point = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
        let height = self.faces.get(face as usize)?.height(p);
        // Above the inside of a face its plane is more accurate than the single-precision query.
        let over = (p - point).length() <= 1.01 * height.abs();
        let inside = if over { height < 0.0 } else { on.is_inside };
        Some(ClosestPoint { point, inside, face })
    }

    /// First entry of the path from `a` to `b` into the surface: fraction of the path, and the
    /// face.
    pub fn entered(&self, a: DVec3, b: DVec3) -> Option<(f64, u32)> {
        let surface = self.surface.as_ref()?;
        let (from, to): (Vec3, Vec3) = (a.as_vec3(), b.as_vec3());
        let hit = surface.cast_local_ray_and_get_normal(&Ray::new(from, to - from), 1.0, false)?;
        let FeatureId::Face(triangle) = hit.feature else { return None };
        // Parry numbers the back sides of the triangles after the front sides.
        let triangle = triangle as usize % self.triangles.len();
        let face = *self.face_of.get(triangle)?;
        // A path that starts inside leaves through the back of a face.
        let n = self.faces.get(face as usize)?.normal;
        ((b - a).dot(n) < 0.0).then_some((f64::from(hit.time_of_impact), face))
    }
}

fn boxes_intersect(a: &Aabb, b: &Aabb) -> bool {
    a.mins.cmple(b.maxs).all() && b.mins.cmple(a.maxs).all()
}

fn surface_of(topology: &MeshTopology) -> Option<TriMesh> {
    let vertices = topology.vertices.iter().map(|v| v.as_vec3()).collect();
    let flags = if topology.closed { TriMeshFlags::ORIENTED } else { TriMeshFlags::empty() };
    TriMesh::with_flags(vertices, topology.triangles.clone(), flags).ok()
}

fn thinness(topology: &MeshTopology) -> f64 {
    let across = topology.faces.iter().map(|f| topology.vertices.iter().map(|v| -f.height(*v)).fold(0.0, f64::max));
    across.fold(f64::INFINITY, f64::min)
}
