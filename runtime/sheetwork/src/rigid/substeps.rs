//! In how many parts Rapier takes a step.
//!
//! Rapier finds contacts at the start of a step: what comes from further away than it looks is deep in the other body by the end of it,
//! or held where it would have gone through. A step in which a body that moves freely comes down on something that does not give way ends its first part
//! there; the part in which the two strike is short, for a body leaves at the end of it; and of a body that lies on a corner and turns, others
//! come down too: no part takes it far around, and Rapier looks as far ahead as they move. What that lets it see of bodies that do not touch is
//! left out (`view`). A step in which nothing moves further than Rapier looks anyway is taken whole, and so are balls, which `roll` sees to.

use glam::{DQuat, DVec3};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query;
use rapier3d::prelude::*;

use crate::rigid::RigidWorld;
use crate::rigid::state::BodyState;
use crate::rigid::view::CONVEX;

/// A part in which two bodies strike, and the shortest, of a step.
pub(crate) const STRIKE: f64 = 1.0 / 16.0;
const SHORTEST: f64 = 1.0 / 64.0;
/// Most parts of a step.
const MOST: u32 = 48;
/// How far a body that touches something turns in a part, rad.
const TURN: f64 = 0.3;
/// Part of what Rapier sees by itself that a body that touches something goes in a part of which others of its corners are looked for.
const ROCKS: f64 = 0.05;
/// Steps of the advancement.
const ROUNDS: usize = 48;

/// A body on its way and a wall it may meet.
struct Pair<'a> {
    shape: &'a dyn Shape,
    body: &'a BodyState,
    extent: f64,
    wall: &'a dyn Shape,
    over: &'a BodyState,
    /// Whether both are convex.
    convex: bool,
}

/// How far apart they are, m, the normal from the wall to the body, and where on the body.
struct Apart {
    size: f64,
    normal: DVec3,
    place: DVec3,
}

impl Pair<'_> {
    /// At `time` s after the start of the part, which is `begun` s after that of the step; `None` when further apart than `reach` (m).
    fn apart(&self, (begun, time): (f64, f64), reach: f64, g: DVec3) -> Option<Apart> {
        let (body, over) = (self.body.fly(time, g), self.over.fly(begun + time, DVec3::ZERO));
        // In the frame of the wall, so that single precision is that of their distance.
        let turn = over.rotation().conjugate();
        let pose = |origin: DVec3, rotation: DQuat| Pose::from_parts(origin.as_vec3(), rotation.as_quat());
        let of_body = pose(turn * (body.origin() - over.origin()), turn * body.rotation());
        let found = query::contact(&Pose::IDENTITY, self.wall, &of_body, self.shape, reach as f32).ok()??;
        let place = over.origin() + over.rotation() * found.point2.as_dvec3();
        Some(Apart { size: f64::from(found.dist), normal: over.rotation() * found.normal1.as_dvec3(), place })
    }

    /// Speed at which they come together at most along `normal`, m/s, before gravity.
    fn approach(&self, normal: DVec3) -> f64 {
        let relative = self.body.velocity() - self.over.velocity_at(self.body.centre());
        let turning = self.body.spin().length() * self.extent;
        let along = if self.convex { -relative.dot(normal) } else { relative.length() };
        along + turning + self.over.spin().length() * self.extent
    }

    /// How long the next part is, of the `left` s of the step that are left and `whole` s of it, and whether they touch; `reach` (m) is how far
    /// Rapier looks.
    fn part(&self, begun: f64, (left, whole): (f64, f64), reach: f64, g: DVec3) -> (f64, bool) {
        let pull = g.length() * left;
        let way = (self.approach_at_most() + pull) * left + reach;
        let Some(first) = self.apart((begun, 0.0), way, g) else { return (left, false) };
        if first.size <= reach {
            let over = self.over.velocity_at(first.place);
            let closing = -(self.body.velocity_at(first.place) - over).dot(first.normal);
            let turns = TURN / self.body.spin().length().max(TURN / whole);
            let strikes = closing * whole > reach;
            return (turns.max(SHORTEST * whole).min(if strikes { STRIKE * whole } else { whole }), true);
        }
        let mut time = 0.0;
        let mut apart = first;
        for _ in 0..ROUNDS {
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
        (time.max(SHORTEST * whole), false)
    }

    fn approach_at_most(&self) -> f64 {
        let relative = self.body.velocity() - self.over.velocity_at(self.body.centre());
        relative.length() + (self.body.spin().length() + self.over.spin().length()) * self.extent
    }
}

impl RigidWorld {
    /// How long the next part of a step of `whole` s is that begins `begun` s after the step does, the `number`th; tells Rapier how far it is to
    /// look.
    pub(crate) fn next_part(&mut self, (begun, whole): (f64, f64), number: u32, g: DVec3) -> f64 {
        let (left, reach) = (whole - begun, self.reach_of_rest());
        let mut part = left;
        let mut far = 0.0_f64;
        for index in 0..self.motions.len() {
            let motion = &self.motions[index];
            let speed = motion.end.velocity().length() + motion.end.spin().length() * motion.extent;
            let way = (speed + g.length() * left) * left;
            let ball = self.radius(index).is_some();
            if !motion.is_free() || motion.asleep || ball || (way <= reach && !self.moving) || number >= MOST {
                continue;
            }
            let mut touches = false;
            self.each_wall_near(index, way + reach, |pair| {
                let (most, touching) = pair.part(begun, (left, whole), reach, g);
                part = part.min(most);
                touches |= touching;
            });
            // What rests is let rest.
            if touches && speed * part > ROCKS * reach {
                far = far.max(speed + g.length() * part);
            }
        }
        self.look_ahead(far * part);
        part
    }

    /// Lets Rapier look further than it does otherwise, `far` (m), where that is further.
    pub(crate) fn look_ahead(&mut self, far: f64) {
        let p = &mut self.inner.integration_parameters;
        let own = IntegrationParameters::default().normalized_prediction_distance;
        p.normalized_prediction_distance = own.max(far as Real / p.length_unit);
    }

    /// Calls `with` for body `index` and each piece of what does not give way that is nearer to it than `way` (m).
    fn each_wall_near(&self, index: usize, way: f64, mut with: impl FnMut(&Pair)) {
        let motion = &self.motions[index];
        for (other, handle) in self.walls_near(index, way) {
            let Some(wall) = self.inner.colliders.get(handle) else { continue };
            for own in &self.bodies[index].colliders {
                let Some(own) = self.inner.colliders.get(*own) else { continue };
                let convex = is_convex(wall) && own.shape().is_convex();
                let (shape, wall, over) = (own.shape(), wall.shape(), &self.motions[other].start);
                with(&Pair { shape, body: &motion.end, extent: motion.extent, wall, over, convex });
            }
        }
    }

    /// The pieces of what does not give way that are nearer to body `index` than `way` (m), and the bodies that they are of.
    pub(crate) fn walls_near(&self, index: usize, way: f64) -> impl Iterator<Item = (usize, ColliderHandle)> {
        let motion = &self.motions[index];
        let centre = motion.end.centre().as_vec3();
        let walls = self.motions.iter().zip(&self.bodies).enumerate().filter(|(_, (other, _))| !other.is_free());
        walls.flat_map(move |(index, (other, body))| {
            let led = other.start.origin().distance(other.end.origin());
            let turns = other.start.spin() != DVec3::ZERO;
            let around = Aabb::from_half_extents(centre, Vector::splat((motion.extent + way + led) as f32));
            let near = move |handle: &ColliderHandle| {
                self.inner.colliders.get(*handle).is_some_and(|c| turns || c.compute_aabb().intersects(&around))
            };
            body.colliders.iter().copied().filter(near).map(move |handle| (index, handle))
        })
    }
}

/// Whether a collider lies behind the plane through any of its points that is nearest to something.
pub(crate) fn is_convex(collider: &Collider) -> bool {
    let shape = collider.shape();
    shape.as_halfspace().is_some() || shape.is_convex() || collider.user_data == CONVEX
}
