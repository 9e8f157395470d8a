//! Which masses met which surfaces in a step.
//!
//! Rapier's broad phase gives the colliders near the box that the sheet swept; each mass is then taken into the collider's
//! frame, at the pose of the start and of the end of the step, and Parry projects its end point on the shape. A mass that
//! moved further than it is away from the surface is cast as a ray too, so that nothing passes through a thin plate.

use glam::{DQuat, DVec3};
use rapier3d::math::{Pose, Real, Vector};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::Ray;
use rapier3d::parry::shape::Shape;
use rapier3d::prelude::{CoefficientCombineRule, Collider, ColliderHandle, FeatureId};

use super::SKIN;
use super::response::{Flight, Outcome, Surface, resolve};
use super::rigid::RigidView;
use super::through_thickness::{Strike, share_impacts};
use crate::sheet::Sheet;

/// Called for every mass that touches a collider in a step.
pub trait Touch {
    /// Mass `mass` touched `collider`.
    fn touched(&mut self, collider: ColliderHandle, mass: usize);
}

/// A collider over a step of the sheet, with what is needed to meet it.
struct Target<'a> {
    handle: ColliderHandle,
    shape: &'a dyn Shape,
    /// Box of the shape in its own frame, grown by the skin.
    bounds: Aabb,
    end: Frame,
    start: Frame,
    linear: DVec3,
    angular: DVec3,
    centre: DVec3,
    friction: f64,
    restitution: f64,
}

/// A rigid frame in f64.
#[derive(Clone, Copy)]
struct Frame {
    origin: DVec3,
    rotation: DQuat,
}

impl Frame {
    fn of(pose: &Pose) -> Self {
        Self { origin: pose.translation.as_dvec3(), rotation: pose.rotation.as_dquat().normalize() }
    }

    fn local(&self, p: DVec3) -> Vector {
        (self.rotation.inverse() * (p - self.origin)).as_vec3()
    }

    fn world(&self, p: Vector) -> DVec3 {
        self.rotation * p.as_dvec3() + self.origin
    }

    /// The frame a time `dt` earlier, moving with `linear` and `angular` about `centre`.
    fn earlier(&self, linear: DVec3, angular: DVec3, centre: DVec3, dt: f64) -> Self {
        let back = DQuat::from_scaled_axis(-angular * dt);
        Self { origin: centre + back * (self.origin - centre) - linear * dt, rotation: back * self.rotation }
    }
}

/// Resolves the contact of `sheet` after its engine moved it for `dt` s from `work.x_before`, `work.v_before`.
///
/// `remaining` is the time from the end of this part of the step to the time the bodies' poses are of.
pub(crate) fn contact(sheet: &mut Sheet, view: &RigidView, dt: f64, remaining: f64, touch: &mut dyn Touch) {
    let Some((low, high)) = swept(sheet) else { return };
    let margin = Vector::splat(2.0 * SKIN as Real);
    let reach = reach_of_moving(view, dt + remaining);
    let swept = Aabb::new(low.as_vec3() - margin, high.as_vec3() + margin).loosened(reach);
    let mut struck = false;
    for (handle, collider) in view.query().intersect_aabb_conservative(swept) {
        let target = Target::new(handle, collider, view, sheet, dt, remaining);
        struck |= meet(sheet, &target, dt, touch);
    }
    if struck {
        if sheet.stack.is_layered() {
            share_impacts(sheet, dt);
        }
        sheet.work.struck.fill(Strike::default());
    }
}

/// The broad phase knows where bodies are at the end of the step; a moving one may have come this far.
fn reach_of_moving(view: &RigidView, time: f64) -> Real {
    let moving = view.bodies.iter().filter(|(_, b)| !b.is_fixed());
    // A turning body sweeps at most its own size, which its box already covers but for the turn within one step.
    moving.map(|(_, b)| (b.linvel().length() + b.angvel().length()) * time as Real).fold(0.0, Real::max)
}

fn swept(sheet: &Sheet) -> Option<(DVec3, DVec3)> {
    let (a, b) = sheet.work.x_before.bounds()?;
    let (c, d) = sheet.x.bounds()?;
    Some((a.min(c), b.max(d)))
}

impl<'a> Target<'a> {
    fn new(
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
        let last = Frame::of(collider.position());
        let (end, start) = if body.is_some() {
            let end = last.earlier(linear, angular, centre, remaining);
            (end, last.earlier(linear, angular, centre, remaining + dt))
        } else {
            (last, last)
        };
        let combine = |ours: f64, theirs: Real, rule| combined(ours, f64::from(theirs), rule);
        Self {
            handle,
            shape: collider.shape(),
            bounds: collider.shape().compute_local_aabb().loosened(2.0 * SKIN as Real),
            end,
            start,
            linear,
            angular,
            centre: centre - linear * remaining,
            friction: combine(sheet.friction, collider.friction(), collider.friction_combine_rule()),
            restitution: combine(sheet.restitution, collider.restitution(), collider.restitution_combine_rule()),
        }
    }

    fn velocity_at(&self, p: DVec3) -> DVec3 {
        self.linear + self.angular.cross(p - self.centre)
    }

    fn surface(&self, point: Vector, normal: Vector) -> Surface {
        let point = self.end.world(point);
        Surface {
            point,
            normal: (self.end.rotation * normal.as_dvec3()).normalize_or(DVec3::Y),
            velocity: self.velocity_at(point),
            friction: self.friction,
            restitution: self.restitution,
        }
    }

    /// The surface that a mass going from `a` (local, at the start) to `b` (local, at the end) meets, if any.
    fn met(&self, a: Vector, b: Vector) -> Option<Surface> {
        let swept = Aabb::new(a.min(b), a.max(b));
        if !self.bounds.intersects(&swept) {
            return None;
        }
        let skin = SKIN as Real;
        let (projection, feature) = self.shape.project_local_point_and_get_feature(b);
        let offset = b - projection.point;
        let distance = offset.length();
        let travel = (b - a).length();
        // Fast enough to have come in through another face than the nearest, or right through.
        if travel > 10.0 * skin && (projection.is_inside || distance < travel) {
            if let Some(surface) = self.cast(a, b) {
                return Some(surface);
            }
        }
        if !projection.is_inside && distance >= skin {
            return None;
        }
        let away = if projection.is_inside { -offset } else { offset };
        let normal = normal_of(self.shape, feature, projection.point)
            .or_else(|| away.try_normalize())
            .or_else(|| (a - b).try_normalize())?;
        Some(self.surface(projection.point, normal))
    }

    fn cast(&self, a: Vector, b: Vector) -> Option<Surface> {
        let ray = Ray::new(a, b - a);
        let hit = self.shape.cast_local_ray_and_get_normal(&ray, 1.0, false)?;
        let point = ray.point_at(hit.time_of_impact);
        let normal = normal_of(self.shape, hit.feature, point).unwrap_or(hit.normal);
        // A ray that starts inside meets the surface from behind: it is on its way out.
        (ray.dir.dot(normal) < 0.0).then(|| self.surface(point, normal))
    }
}

/// Rapier's rules for a pair's coefficient, with the sheet's own rule taken to be the average.
fn combined(ours: f64, theirs: f64, rule: CoefficientCombineRule) -> f64 {
    match rule {
        CoefficientCombineRule::Min => ours.min(theirs),
        CoefficientCombineRule::Multiply => ours * theirs,
        CoefficientCombineRule::Max => ours.max(theirs),
        _ => 0.5 * (ours + theirs),
    }
}

/// The exact normal of the face a feature names. Directions to nearby points lose all accuracy at a distance of a skin.
fn normal_of(shape: &dyn Shape, feature: FeatureId, point: Vector) -> Option<Vector> {
    if let Some(mesh) = shape.as_trimesh() {
        let FeatureId::Face(face) = feature else { return None };
        // Parry counts the back of face i as face i + n.
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

/// Meets every free mass with one collider; true if any took an impact.
fn meet(sheet: &mut Sheet, target: &Target, dt: f64, touch: &mut dyn Touch) -> bool {
    let mut struck = false;
    for i in 0..sheet.x.len() {
        if sheet.inverse_mass[i] == 0.0 {
            continue;
        }
        let (x0, x1) = (sheet.work.x_before.get(i), sheet.x.get(i));
        let Some(surface) = target.met(target.start.local(x0), target.end.local(x1)) else { continue };
        let flight = Flight { x0, v0: sheet.work.v_before.get(i), x1, v1: sheet.v.get(i), dt };
        let Outcome { x, v, impact, rest } = resolve(&flight, &surface, SKIN);
        sheet.x.set(i, x);
        sheet.v.set(i, v);
        sheet.counters.contacts += 1;
        sheet.work.touching[i] = true;
        touch.touched(target.handle, i);
        if impact > 0.0 {
            struck = true;
            sheet.work.struck[i] = Strike {
                share: 1.0,
                normal: surface.normal,
                body: surface.velocity,
                restitution: surface.restitution,
                friction: surface.friction,
                rest,
            };
        }
    }
    struck
}

/// Whether a body that moves is where it could touch `sheet` within `dt` s.
pub(crate) fn moving_body_near(sheet: &Sheet, view: &RigidView, dt: f64) -> bool {
    let reach = reach_of_moving(view, dt);
    if reach <= 0.0 {
        return false;
    }
    let Some((low, high)) = sheet.x.bounds() else { return false };
    let near = Aabb::new(low.as_vec3(), high.as_vec3()).loosened(reach + 4.0 * SKIN as Real);
    view.query().intersect_aabb_conservative(near).any(|(_, collider)| {
        let body = collider.parent().and_then(|h| view.bodies.get(h));
        body.is_some_and(|b| !b.is_fixed() && (b.linvel().length() > 0.0 || b.angvel().length() > 0.0))
    })
}

/// How deep the deepest mass of `sheet` is inside a body now, m; 0 when none is.
pub fn deepest(sheet: &Sheet, view: &RigidView) -> f64 {
    let Some((low, high)) = sheet.x.bounds() else { return 0.0 };
    let mut deepest = 0.0_f64;
    for (_, collider) in view.query().intersect_aabb_conservative(Aabb::new(low.as_vec3(), high.as_vec3())) {
        let frame = Frame::of(collider.position());
        for p in sheet.x.iter() {
            let projection = collider.shape().project_local_point(frame.local(p), false);
            if projection.is_inside {
                deepest = deepest.max(frame.world(projection.point).distance(p));
            }
        }
    }
    deepest
}
