//! A collider over one step, and the contact of a node's path with it.
//!
//! The path goes from a (in the collider's frame at the start of the step) to b (in its frame at
//! the end). Parry projects b on the shape. A convex shape lies behind the plane of the nearest
//! face with normal n: a path that ends outside and has both ends in front of that plane has no
//! contact; a path that ends inside and starts in front has entered through the face. All other
//! cases (a concave shape, entry through another face, passage through a thin plate) are decided by
//! a ray cast from a to b.

use glam::DVec3;
use rapier3d::math::{Real, Vector};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{PointQuery, PointQueryWithLocation, Ray};
use rapier3d::parry::shape::{Shape, TriMesh, TypedShape};
use rapier3d::prelude::{Collider, ColliderHandle, FeatureId};

use crate::contact::node::response::NodeContactSurface;
use crate::math::RigidFrame;
use crate::rigid::{CONVEX, RigidView};
use crate::scene::contact::MINIMUM_CONTACT_OFFSET;
use crate::sheet::{Sheet, node_contact};

/// Result of testing a path against a collider.
pub(crate) enum PathHit {
    /// The path ends behind this surface, or passes through it.
    Surface(NodeContactSurface),
    /// The path has no contact; the shape is at least this far away, m.
    Clear(Real),
}

/// A collider over one step of a sheet.
pub(crate) struct StepTarget<'a> {
    pub handle: ColliderHandle,
    pub end: RigidFrame,
    pub start: RigidFrame,
    shape: &'a dyn Shape,
    kind: TargetShape<'a>,
    pub convex: bool,
    /// Whether its body may move.
    moves: bool,
    /// Bounding box in its own frame, extended by the contact offset.
    bounds: Aabb,
    linear: DVec3,
    angular: DVec3,
    centre: DVec3,
    friction: f64,
    restitution: f64,
    /// Contact offset, m.
    contact_offset: f64,
}

/// Shapes with a specialised test.
#[derive(Clone, Copy)]
enum TargetShape<'a> {
    Mesh(&'a TriMesh),
    /// A half-space with this outward normal.
    Plane(Vector),
    Other,
}

/// Projection of a point on a shape.
struct SurfaceProjection {
    point: Vector,
    inside: bool,
    normal: Option<Vector>,
    face: u32,
}

/// Face index for no face.
pub(crate) const NO_FACE: u32 = u32::MAX;

impl<'a> StepTarget<'a> {
    /// Prepare `collider` for a step of `dt` (s). `remaining` (s) is the time from the end of the
    /// step to that of the body's pose.
    pub fn new(
        handle: ColliderHandle,
        collider: &'a Collider,
        view: &RigidView<'a>,
        sheet: &Sheet,
        dt: f64,
        remaining: f64,
    ) -> Self {
        let body = collider.parent().and_then(|h| view.bodies.get(h)).filter(|b| !b.is_fixed());
        let (linear, angular, centre) = body.map_or((DVec3::ZERO, DVec3::ZERO, DVec3::ZERO), |b| {
            (b.linvel().as_dvec3(), b.angvel().as_dvec3(), b.center_of_mass().as_dvec3())
        });
        let last = RigidFrame::from_pose(collider.position());
        let (mut end, mut start) = (last, last);
        if body.is_some() {
            end = last.earlier(linear, angular, centre, remaining);
            start = last.earlier(linear, angular, centre, remaining + dt);
        }
        let shape = collider.shape();
        let kind = match shape.as_typed_shape() {
            TypedShape::TriMesh(mesh) => TargetShape::Mesh(mesh),
            TypedShape::HalfSpace(plane) => TargetShape::Plane(plane.normal),
            _ => TargetShape::Other,
        };
        let skin = node_contact::contact_offset(sheet);
        let (friction, restitution) = view.coefficients(node_contact::surface_coefficients(sheet), handle, collider);
        Self {
            handle,
            shape,
            kind,
            moves: body.is_some(),
            convex: collider.user_data == CONVEX || is_convex(shape),
            bounds: shape.compute_local_aabb().loosened(2.0 * skin as Real),
            end,
            start,
            linear,
            angular,
            centre: centre - linear * remaining,
            friction,
            restitution,
            contact_offset: skin,
        }
    }

    /// Frame at the time `dt` (s) before the end of the step.
    pub fn before_end(&self, dt: f64) -> RigidFrame {
        if self.moves { self.end.earlier(self.linear, self.angular, self.centre, dt) } else { self.end }
    }

    /// Test the path from `a` (local, at the start) to `b` (local, at the end). Surfaces further
    /// than `reach` (m) from b may be ignored. `face` is the last known nearest face and is
    /// updated.
    pub fn test_path(&self, a: Vector, b: Vector, reach: Real, face: &mut u32) -> PathHit {
        let (skin, fine) = (self.contact_offset as Real, MINIMUM_CONTACT_OFFSET as Real);
        if let TargetShape::Plane(n) = self.kind {
            let height = b.dot(n);
            return if height < skin {
                PathHit::Surface(self.surface(b - n * height, n))
            } else {
                PathHit::Clear(height)
            };
        }
        if !self.bounds.intersects(&Aabb::new(a.min(b), a.max(b))) {
            return PathHit::Clear(self.bounds.distance_to_local_point(b, true));
        }
        if let Some(surface) = self.resting_face(*face, a, b) {
            return PathHit::Surface(surface);
        }
        let travel = (b - a).length();
        let reach = reach.max(travel + 2.0 * skin);
        let Some(nearest) = self.nearest(b, reach) else { return PathHit::Clear(reach) };
        *face = nearest.face;
        let offset = b - nearest.point;
        let distance = offset.length();
        if let Some(n) = nearest.normal.filter(|_| self.convex) {
            let came_in_front = (a - nearest.point).dot(n) >= -0.5 * fine;
            if came_in_front && (nearest.inside || distance < skin) {
                return PathHit::Surface(self.surface(nearest.point, n));
            }
            if came_in_front && offset.dot(n) > 0.0 {
                return PathHit::Clear(distance);
            }
        }
        let may_have_crossed = travel > 10.0 * fine && (nearest.inside || distance < travel);
        if let Some(surface) = may_have_crossed.then(|| self.cast(a, b)).flatten() {
            return PathHit::Surface(surface);
        }
        if !nearest.inside && distance >= skin {
            return PathHit::Clear(distance);
        }
        let away = if nearest.inside { -offset } else { offset };
        let normal = nearest.normal.or_else(|| away.try_normalize()).or_else(|| (a - b).try_normalize());
        normal.map_or(PathHit::Clear(0.0), |n| PathHit::Surface(self.surface(nearest.point, n)))
    }

    /// Contact of a point that lay on a face of a convex mesh and ends behind it within the same
    /// triangle. This needs no search and covers most nodes of a resting sheet.
    fn resting_face(&self, face: u32, a: Vector, b: Vector) -> Option<NodeContactSurface> {
        let TargetShape::Mesh(mesh) = self.kind else { return None };
        if face == NO_FACE || !self.convex || face as usize >= mesh.num_triangles() {
            return None;
        }
        let triangle = mesh.triangle(face);
        let (u, v) = (triangle.b - triangle.a, triangle.c - triangle.a);
        let area = u.cross(v);
        let n = area.try_normalize()?;
        let (before, after) = ((a - triangle.a).dot(n), (b - triangle.a).dot(n));
        if before < -0.5 * MINIMUM_CONTACT_OFFSET as Real || after >= self.contact_offset as Real {
            return None;
        }
        let along = b - n * after - triangle.a;
        let whole = area.dot(area);
        let (s, t) = (along.cross(v).dot(area), u.cross(along).dot(area));
        (s >= 0.0 && t >= 0.0 && s + t <= whole).then(|| self.surface(b - n * after, n))
    }

    /// Surface that holds a point at `p` (world, m), if it is inside or nearer than the contact
    /// offset.
    pub fn surface_at(&self, p: DVec3) -> Option<NodeContactSurface> {
        let b = self.end.local_point(p).as_vec3();
        if !self.bounds.contains_local_point(b) {
            return None;
        }
        let nearest = self.nearest(b, Real::MAX)?;
        let close = nearest.inside || b.distance(nearest.point) < self.contact_offset as Real;
        Some(self.surface(nearest.point, nearest.normal?)).filter(|_| close)
    }

    /// Projection of `b` on the shape, or `None` if it is further than `reach` (m).
    fn nearest(&self, b: Vector, reach: Real) -> Option<SurfaceProjection> {
        match self.kind {
            TargetShape::Mesh(mesh) => {
                let (on, (face, _)) = mesh.project_local_point_and_get_location_with_max_dist(b, false, reach)?;
                let normal = mesh.triangle(face).normal();
                Some(SurfaceProjection { point: on.point, inside: on.is_inside, normal, face })
            }
            TargetShape::Plane(n) => {
                let height = b.dot(n);
                Some(SurfaceProjection { point: b - n * height, inside: height <= 0.0, normal: Some(n), face: NO_FACE })
            }
            TargetShape::Other => {
                let (on, feature) = self.shape.project_local_point_and_get_feature(b);
                let normal = normal_of(self.shape, feature, on.point);
                Some(SurfaceProjection { point: on.point, inside: on.is_inside, normal, face: NO_FACE })
            }
        }
    }

    /// Surface that the ray from `a` to `b` enters first.
    fn cast(&self, a: Vector, b: Vector) -> Option<NodeContactSurface> {
        let ray = Ray::new(a, b - a);
        let hit = self.shape.cast_local_ray_and_get_normal(&ray, 1.0, false)?;
        let point = ray.point_at(hit.time_of_impact);
        let normal = normal_of(self.shape, hit.feature, point).unwrap_or(hit.normal);
        // A ray that starts inside meets the surface from behind and leaves the shape.
        (ray.dir.dot(normal) < 0.0).then(|| self.surface(point, normal))
    }

    fn surface(&self, point: Vector, normal: Vector) -> NodeContactSurface {
        let point = self.end.world(point.as_dvec3());
        NodeContactSurface {
            point,
            normal: (self.end.rotation * normal.as_dvec3()).normalize_or(DVec3::Y),
            velocity: self.linear + self.angular.cross(point - self.centre),
            friction: self.friction,
            restitution: self.restitution,
        }
    }
}

/// Whether the type of the shape is convex.
fn is_convex(shape: &dyn Shape) -> bool {
    matches!(
        shape.as_typed_shape(),
        TypedShape::Ball(_)
            | TypedShape::Cuboid(_)
            | TypedShape::Capsule(_)
            | TypedShape::HalfSpace(_)
            | TypedShape::Cylinder(_)
            | TypedShape::Cone(_)
            | TypedShape::ConvexPolyhedron(_)
    )
}

/// Exact normal of the face `feature`. The direction to the projected point is inaccurate at
/// distances of the contact offset.
fn normal_of(shape: &dyn Shape, feature: FeatureId, point: Vector) -> Option<Vector> {
    if let Some(mesh) = shape.as_trimesh() {
        let FeatureId::Face(face) = feature else { return None };
        // Parry numbers the back of face i as face i + n.
        let face = face % mesh.num_triangles() as u32;
        return mesh.triangle(face).normal();
    }
    if let Some(plane) = shape.as_halfspace() {
        return Some(plane.normal);
    }
    match feature {
        FeatureId::Face(_) => shape.feature_normal_at_point(feature, point),
        _ => None,
    }
}
