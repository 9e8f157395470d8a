//! Motion of a ball among static and kinematic bodies, in f64 and from impact to impact.
//!
//! Rapier has no continuous collision detection for half spaces, and its contact points rotate with
//! a ball. A ball however touches a surface below its centre c at any rotation, and its contact
//! depends only on the distance d(c) of the surface. Without contact c follows a parabola. The time
//! of impact is found by conservative advancement: a convex body lies behind the plane through its
//! nearest point, and c cannot touch it before it reaches that plane (Mirtich, Impulse-based
//! dynamic simulation of rigid body systems, 1996, 2.3); for other surfaces the distance falls at
//! most by the motion of c.
//!
//! An impact with approach speed v has the impulse (1 + e) m v along the normal, with e = 0 below
//! [`RigidSettings::restitution_speed`], and friction of at most μ times that, which reduces the
//! slip of the contact point to at least zero. While a ball rests, slides or rolls, the impulse of
//! gravity is compensated in the same way.

use glam::{DMat3, DVec3};
use rapier3d::prelude::*;

use crate::rigid::rolling_resistance::Support;
use crate::rigid::settings::{RigidSettings, RollingBallSettings};
use crate::rigid::state::BodyState;

const SETTINGS: RollingBallSettings = RigidSettings::DEFAULT.rolling_ball;
const RIGID: RigidSettings = RigidSettings::DEFAULT;

/// A static or kinematic collider near the ball.
pub(crate) struct Obstacle {
    pub body: usize,
    pub collider: ColliderHandle,
    pub friction: f64,
    pub restitution: f64,
    /// Whether the collider lies behind the plane through its point nearest to any exterior point.
    pub convex: bool,
    /// State of its body at the start of the step.
    pub body_state: BodyState,
}

/// Gap between a ball and an obstacle.
#[derive(Clone, Copy)]
pub(crate) struct ObstacleGap {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Unit normal from the obstacle to the ball.
    pub normal: DVec3,
    /// Gap, m; negative for penetration.
    pub size: f64,
    /// Nearest point of the obstacle in the frame of its body, m.
    pub place: DVec3,
    /// Velocity of that point, m/s.
    velocity: DVec3,
}

/// Solver for the motion of a ball, with buffers reused between steps.
#[derive(Default)]
pub(crate) struct RollingBallSolver {
    pub obstacles: Vec<Obstacle>,
    touching: Vec<ObstacleGap>,
    /// First gap of each obstacle that was touched.
    pub touched: Vec<ObstacleGap>,
}

/// Radius, mass and inverse inertia of a ball.
#[derive(Clone, Copy)]
struct RollingBall {
    radius: f64,
    mass: f64,
    inverse_inertia: DMat3,
}

impl RollingBall {
    /// Velocity of the contact point relative to the obstacle, m/s.
    fn slip(&self, gap: &ObstacleGap, (velocity, spin): (DVec3, DVec3)) -> DVec3 {
        velocity + spin.cross(gap.normal * -self.radius) - gap.velocity
    }

    /// Velocity and angular velocity after an impulse (N s) at the contact point.
    fn kicked(&self, gap: &ObstacleGap, (velocity, spin): (DVec3, DVec3), impulse: DVec3) -> (DVec3, DVec3) {
        let twist = (gap.normal * -self.radius).cross(impulse);
        (velocity + impulse / self.mass, spin + self.inverse_inertia * twist)
    }

    /// Friction impulse (N s) that ends the slip, limited to the friction bound `most`.
    fn friction(&self, gap: &ObstacleGap, motion: (DVec3, DVec3), before: DVec3, most: f64) -> DVec3 {
        let slip = self.slip(gap, motion).reject_from_normalized(gap.normal);
        let arm = gap.normal.any_orthonormal_vector();
        let spun = (self.inverse_inertia * (gap.normal * -self.radius).cross(arm)).cross(gap.normal * -self.radius);
        let yields = 1.0 / self.mass + spun.dot(arm);
        (before - slip / yields).clamp_length_max(most)
    }
}

impl RollingBallSolver {
    /// Advance the ball `start` of radius `radius` (m) by `span` s in the gravity `g` (m/s²), from
    /// `begun` s after the start of the step. `None` without contact.
    pub fn advance(
        &mut self,
        colliders: &ColliderSet,
        start: &BodyState,
        radius: f64,
        (begun, span): (f64, f64),
        g: DVec3,
    ) -> Option<BodyState> {
        self.touched.clear();
        let ball = RollingBall { radius, mass: start.mass(), inverse_inertia: start.inverse_inertia() };
        let mut state = *start;
        let mut done = 0.0;
        for stretch in 0..SETTINGS.maximum_segments {
            state = self.resolve_penetration(colliders, &ball, &state, begun + done);
            let motion =
                self.resolve_impacts(&ball, (state.velocity(), state.spin()), stretch + 1 < SETTINGS.maximum_segments);
            let left = span - done;
            let mut end = self.apply_gravity(&ball, motion, g * left);
            let acceleration = (end.0 - motion.0) / left;
            let path = (state.centre(), motion.0, acceleration);
            let arrival = self.time_of_impact(colliders, &ball, path, (begun + done, left));
            let taken = arrival.unwrap_or(left);
            if arrival.is_some() {
                end = self.apply_gravity(&ball, motion, g * taken);
            }
            let (velocity, spin) = ((motion.0 + end.0) * 0.5, (motion.1 + end.1) * 0.5);
            state = state.displaced(velocity * taken, spin * taken).with_velocity(end.0, end.1);
            done += taken;
            if arrival.is_none() {
                break;
            }
        }
        state = self.resolve_penetration(colliders, &ball, &state, begun + span);
        (!self.touched.is_empty()).then_some(state)
    }

    /// Collect the obstacles touched at `time` (s after the start of the step), and remove
    /// penetration.
    fn resolve_penetration(
        &mut self,
        colliders: &ColliderSet,
        ball: &RollingBall,
        state: &BodyState,
        time: f64,
    ) -> BodyState {
        self.touching.clear();
        let mut state = *state;
        for wall in 0..self.obstacles.len() {
            let Some(gap) = self.gap(colliders, ball, wall, state.centre(), time) else { continue };
            if gap.size >= SETTINGS.touch_distance {
                continue;
            }
            if gap.size < 0.0 {
                let is_deep = gap.size < -RIGID.penetration_tolerance;
                let out = if is_deep { -RIGID.penetration_recovery * gap.size } else { SETTINGS.impact_gap - gap.size };
                state = state.displaced(gap.normal * out, DVec3::ZERO);
            }
            self.touching.push(gap);
            if !self.touched.iter().any(|g| g.obstacle == wall) {
                self.touched.push(gap);
            }
        }
        state
    }

    /// Velocities after the impacts with all approaching contacts; restitution acts only if
    /// `may_bounce`.
    fn resolve_impacts(&self, ball: &RollingBall, mut motion: (DVec3, DVec3), may_bounce: bool) -> (DVec3, DVec3) {
        for _ in 0..SETTINGS.maximum_sweeps {
            let mut struck = false;
            for gap in &self.touching {
                let approach = -ball.slip(gap, motion).dot(gap.normal);
                if approach <= 1e-12 {
                    continue;
                }
                struck = true;
                let wall = &self.obstacles[gap.obstacle];
                let bounces = may_bounce && approach > RIGID.restitution_speed;
                let push = ball.mass * approach * if bounces { 1.0 + wall.restitution } else { 1.0 };
                let friction = ball.friction(gap, motion, DVec3::ZERO, wall.friction * push);
                motion = ball.kicked(gap, motion, gap.normal * push + friction);
            }
            if !struck {
                break;
            }
        }
        motion
    }

    /// Velocities after gravity has added `pull` (m/s), with the support, friction and rolling
    /// resistance of the touched obstacles.
    fn apply_gravity(&self, ball: &RollingBall, motion: (DVec3, DVec3), pull: DVec3) -> (DVec3, DVec3) {
        let below = |gap: &&ObstacleGap| ball.slip(gap, motion).dot(gap.normal) < SETTINGS.support_speed;
        let mut support = Support::default();
        for gap in self.touching.iter().filter(below) {
            let wall = &self.obstacles[gap.obstacle];
            support.add(gap.normal, wall.friction, wall.body_state.spin());
        }
        // Rolling resistance precedes friction, which then restores rolling without slip.
        let spin = support.resisted_spin(motion.1, (ball.mass, ball.radius, &ball.inverse_inertia), pull);
        let mut now = (motion.0 + pull, spin);
        let mut held = [(0.0, DVec3::ZERO); 8];
        for _ in 0..SETTINGS.maximum_sweeps {
            for (gap, (push, friction)) in self.touching.iter().filter(below).zip(&mut held) {
                let more = (*push - ball.mass * ball.slip(gap, now).dot(gap.normal)).max(0.0) - *push;
                *push += more;
                now = ball.kicked(gap, now, gap.normal * more);
                let whole = ball.friction(gap, now, *friction, self.obstacles[gap.obstacle].friction * *push);
                now = ball.kicked(gap, now, whole - *friction);
                *friction = whole;
            }
            if self.touching.len() < 2 {
                break;
            }
        }
        now
    }

    /// Time until the first impact within `left` s of `now` (s after the start of the step), on the
    /// path with the given position (m), velocity and acceleration.
    fn time_of_impact(
        &self,
        colliders: &ColliderSet,
        ball: &RollingBall,
        path: (DVec3, DVec3, DVec3),
        (now, left): (f64, f64),
    ) -> Option<f64> {
        let mut first = None;
        for wall in 0..self.obstacles.len() {
            let within = first.unwrap_or(left);
            first = self.time_of_impact_with(colliders, ball, wall, path, (now, within)).or(first);
        }
        first
    }

    /// Time until the impact with one obstacle.
    fn time_of_impact_with(
        &self,
        colliders: &ColliderSet,
        ball: &RollingBall,
        wall: usize,
        (place, velocity, acceleration): (DVec3, DVec3, DVec3),
        (now, left): (f64, f64),
    ) -> Option<f64> {
        let mut time = 0.0;
        for _ in 0..RIGID.maximum_advancement_steps {
            let there = place + (velocity + acceleration * (0.5 * time)) * time;
            let gap = self.gap(colliders, ball, wall, there, now + time)?;
            let speed = velocity + acceleration * time - gap.velocity;
            let (along, bend) = (speed.dot(gap.normal), acceleration.dot(gap.normal));
            let room = gap.size - SETTINGS.impact_gap;
            if gap.size < 0.5 * SETTINGS.touch_distance && along < -SETTINGS.zero_speed {
                return Some(time);
            }
            // A touched obstacle that is neither left nor approached supports the ball.
            if gap.size < SETTINGS.touch_distance
                && along < SETTINGS.zero_speed
                && bend.abs() * (left - time) < SETTINGS.zero_speed
            {
                return None;
            }
            time += if self.obstacles[wall].convex || gap.size < SETTINGS.touch_distance {
                fall_time(room, along, bend)?
            } else {
                room / (speed.length() + acceleration.length() * (left - time))
            };
            if time.is_nan() || time >= left {
                return None;
            }
        }
        (time > 0.0).then_some(time)
    }

    /// Gap between a ball centred at `centre` (m) and an obstacle; `None` if no outward direction
    /// is defined.
    fn gap(
        &self,
        colliders: &ColliderSet,
        ball: &RollingBall,
        wall: usize,
        centre: DVec3,
        time: f64,
    ) -> Option<ObstacleGap> {
        let of = self.obstacles.get(wall)?;
        let shape = colliders.get(of.collider)?.shape();
        let over = if of.body_state.is_moving() { of.body_state.free_flight(time, DVec3::ZERO) } else { of.body_state };
        let local = over.local_point(centre);
        let (normal, distance) = if shape.as_halfspace().is_some() {
            (DVec3::Y, local.y)
        } else {
            let rounded = local.as_vec3();
            let nearest = shape.project_local_point(rounded, false);
            let way = rounded.as_dvec3() - nearest.point.as_dvec3();
            let out = if nearest.is_inside { -way } else { way }.try_normalize()?;
            (out, way.dot(out) + (local - rounded.as_dvec3()).dot(out))
        };
        let place = local - normal * distance;
        let velocity = over.velocity_at(over.world_point(place));
        Some(ObstacleGap {
            obstacle: wall,
            normal: over.rotation() * normal,
            size: distance - ball.radius,
            place,
            velocity,
        })
    }
}

/// Time (s) in which a point `room` (m) above a plane, with the upward velocity `speed` (m/s) and
/// the acceleration `bend` (m/s²), reaches the plane; `None` if never.
fn fall_time(room: f64, speed: f64, bend: f64) -> Option<f64> {
    let square = speed * speed - 2.0 * bend * room;
    if square < 0.0 {
        return None;
    }
    let root = square.sqrt();
    if speed < 0.0 {
        return Some((2.0 * room / (root - speed)).max(0.0));
    }
    (bend < 0.0).then(|| (speed + root) / -bend)
}
