//! Substeps of Rapier within a step.
//!
//! Rapier detects contacts at the start of a step. A body that comes from beyond the prediction
//! distance penetrates deeply by the end of the step, or is held back although it would pass. A
//! step in which a dynamic body reaches a static or kinematic one therefore ends its first substep
//! at the impact. The substep of the impact is short, because a body leaves at its end. A body that
//! lies on a corner and turns brings other corners down: the rotation per substep is limited, and
//! the prediction distance covers the motion. Contacts of separate bodies that this adds are
//! removed (`view`). A step in which no body moves beyond the prediction distance is not divided;
//! balls are advanced by `rolling_ball`.

use glam::{DQuat, DVec3};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query;
use rapier3d::prelude::*;

use crate::rigid::RigidWorld;
use crate::rigid::settings::{RigidSettings, RigidSubstepSettings};
use crate::rigid::state::BodyState;
use crate::rigid::view::CONVEX;

const SETTINGS: RigidSubstepSettings = RigidSettings::DEFAULT.substeps;
const RIGID: RigidSettings = RigidSettings::DEFAULT;

/// A moving body and an obstacle near it.
struct SubstepPair<'a> {
    shape: &'a dyn Shape,
    body: &'a BodyState,
    extent: f64,
    wall: &'a dyn Shape,
    body_state: &'a BodyState,
    /// Whether both shapes are convex.
    convex: bool,
}

/// Distance (m), unit normal from the obstacle to the body, and contact point on the body (world,
/// m).
struct Separation {
    size: f64,
    normal: DVec3,
    place: DVec3,
}

impl SubstepPair<'_> {
    /// Separation at `time` s after the start of a substep that begins `begun` s after the start of
    /// the step; `None` beyond `reach` (m).
    fn apart(&self, (begun, time): (f64, f64), reach: f64, g: DVec3) -> Option<Separation> {
        let (body, over) = (self.body.free_flight(time, g), self.body_state.free_flight(begun + time, DVec3::ZERO));
        // In the frame of the obstacle the single-precision error is relative to the distance.
        let turn = over.rotation().conjugate();
        let pose = |origin: DVec3, rotation: DQuat| Pose::from_parts(origin.as_vec3(), rotation.as_quat());
        let of_body = pose(turn * (body.origin() - over.origin()), turn * body.rotation());
        let found = query::contact(&Pose::IDENTITY, self.wall, &of_body, self.shape, reach as f32).ok()??;
        let place = over.origin() + over.rotation() * found.point2.as_dvec3();
        Some(Separation { size: f64::from(found.dist), normal: over.rotation() * found.normal1.as_dvec3(), place })
    }

    /// Upper bound of the approach speed along `normal`, m/s, before gravity.
    fn approach(&self, normal: DVec3) -> f64 {
        let relative = self.body.velocity() - self.body_state.velocity_at(self.body.centre());
        let turning = self.body.spin().length() * self.extent;
        let along = if self.convex { -relative.dot(normal) } else { relative.length() };
        along + turning + self.body_state.spin().length() * self.extent
    }

    /// Length of the next substep, of the remaining `left` s of a step of `whole` s, and whether
    /// the pair touches. `reach` (m) is the contact distance.
    fn substep_length(&self, begun: f64, (left, whole): (f64, f64), reach: f64, g: DVec3) -> (f64, bool) {
        let pull = g.length() * left;
        let way = (self.approach_at_most() + pull) * left + reach;
        let Some(first) = self.apart((begun, 0.0), way, g) else { return (left, false) };
        if first.size <= reach {
            let over = self.body_state.velocity_at(first.place);
            let closing = -(self.body.velocity_at(first.place) - over).dot(first.normal);
            let turns = SETTINGS.maximum_rotation / self.body.spin().length().max(SETTINGS.maximum_rotation / whole);
            let strikes = closing * whole > reach;
            return (
                turns.max(SETTINGS.minimum_fraction * whole).min(if strikes {
                    SETTINGS.impact_fraction * whole
                } else {
                    whole
                }),
                true,
            );
        }
        let mut time = 0.0;
        let mut apart = first;
        for _ in 0..RIGID.maximum_advancement_steps {
            let fall = if self.convex { (-g.dot(apart.normal)).max(0.0) * left } else { pull };
            let speed = self.approach(apart.normal) + fall;
            if speed <= 0.0 {
                return (left, false);
            }
            time += (apart.size - 0.25 * reach) / speed;
            if time >= left {
                return (left, false);
            }
            match self.apart((begun, time), way, g) {
                Some(next) if next.size > 0.5 * reach => apart = next,
                _ => break,
            }
        }
        (time.max(SETTINGS.minimum_fraction * whole), false)
    }

    fn approach_at_most(&self) -> f64 {
        let relative = self.body.velocity() - self.body_state.velocity_at(self.body.centre());
        relative.length() + (self.body.spin().length() + self.body_state.spin().length()) * self.extent
    }
}

impl RigidWorld {
    /// Length (s) of substep `number`, which begins `begun` s after the start of a step of `whole`
    /// s. Sets Rapier's prediction distance.
    pub(crate) fn next_substep(&mut self, (begun, whole): (f64, f64), number: u32, g: DVec3) -> f64 {
        let (left, reach) = (whole - begun, self.contact_distance());
        let mut part = left;
        let mut far = 0.0_f64;
        for index in 0..self.motions.len() {
            let motion = &self.motions[index];
            let speed = motion.end.velocity().length() + motion.end.spin().length() * motion.extent;
            let way = (speed + g.length() * left) * left;
            let ball = self.radius(index).is_some() && !self.is_jointed(index);
            if !motion.is_free()
                || motion.asleep
                || ball
                || (way <= reach && !self.has_kinematic)
                || number >= SETTINGS.maximum_substeps
            {
                continue;
            }
            let mut touches = false;
            self.for_each_obstacle_near(index, way + reach, |pair| {
                let (most, touching) = pair.substep_length(begun, (left, whole), reach, g);
                part = part.min(most);
                touches |= touching;
            });
            // Resting bodies need no extended prediction.
            if touches && speed * part > SETTINGS.prediction_motion * reach {
                far = far.max(speed + g.length() * part);
            }
        }
        self.set_prediction_distance(far * part);
        part
    }

    /// Extend Rapier's prediction distance to `far` (m), at least the default.
    pub(crate) fn set_prediction_distance(&mut self, far: f64) {
        let p = &mut self.inner.integration_parameters;
        let own = IntegrationParameters::default().normalized_prediction_distance;
        p.normalized_prediction_distance = own.max(far as Real / p.length_unit);
    }

    /// Call `with` for body `index` and each static or kinematic collider nearer than `way` (m).
    fn for_each_obstacle_near(&self, index: usize, way: f64, mut with: impl FnMut(&SubstepPair)) {
        let motion = &self.motions[index];
        for (other, handle) in self.obstacles_near(index, way) {
            let Some(wall) = self.inner.colliders.get(handle) else { continue };
            for own in &self.bodies[index].colliders {
                let Some(own) = self.inner.colliders.get(*own) else { continue };
                let convex = is_convex(wall) && own.shape().is_convex();
                let (shape, wall, over) = (own.shape(), wall.shape(), &self.motions[other].start);
                with(&SubstepPair { shape, body: &motion.end, extent: motion.extent, wall, body_state: over, convex });
            }
        }
    }

    /// Static and kinematic colliders that body `index` can touch, nearer to it than `way` (m),
    /// with their body indices.
    pub(crate) fn obstacles_near(&self, index: usize, way: f64) -> impl Iterator<Item = (usize, ColliderHandle)> {
        let motion = &self.motions[index];
        let centre = motion.end.centre().as_vec3();
        let own = self.bodies[index].colliders.first().and_then(|own| self.inner.colliders.get(*own));
        let walls = self.motions.iter().zip(&self.bodies).enumerate();
        let walls = walls.filter(move |(at, (other, _))| !other.is_free() && !self.joint_excludes_contact(index, *at));
        walls.flat_map(move |(index, (other, body))| {
            let led = other.start.origin().distance(other.end.origin());
            let turns = other.start.spin() != DVec3::ZERO;
            let around = Aabb::from_half_extents(centre, Vector::splat((motion.extent + way + led) as f32));
            let near = move |handle: &ColliderHandle| {
                let touches = |c: &Collider| own.is_some_and(|own| can_touch(own, c));
                let is_near = |c: &&Collider| turns || c.compute_aabb().intersects(&around);
                self.inner.colliders.get(*handle).filter(is_near).is_some_and(touches)
            };
            body.colliders.iter().copied().filter(near).map(move |handle| (index, handle))
        })
    }
}

/// Whether two colliders are solid and of groups that meet.
fn can_touch(a: &Collider, b: &Collider) -> bool {
    !a.is_sensor() && !b.is_sensor() && a.collision_groups().test(b.collision_groups())
}

/// Whether a collider lies behind the plane through its point nearest to any exterior point.
pub(crate) fn is_convex(collider: &Collider) -> bool {
    let shape = collider.shape();
    shape.as_halfspace().is_some() || shape.is_convex() || collider.user_data == CONVEX
}
