//! Step of the rigid bodies: Rapier advances them, with the state of dynamic bodies stored in f64.
//!
//! The f64 states are authoritative and are passed to Rapier in f32. A body without a contact
//! impulse in a step follows the exact free flight of its f64 state (`state`); a body with impulses
//! takes Rapier's result. A body that sheets push receives its state from the contact solver of the
//! sheets after the step.
//!
//! A body fast enough to penetrate another deeply within a step is advanced in substeps
//! (`substeps`), and bounces off static and kinematic bodies according to its restitution
//! (`impact`). A ball with only such bodies around it is advanced without Rapier (`rolling_ball`).
//!
//! Touching bodies fall asleep together if each has rested (slower than
//! [`SleepSettings::speed`](crate::scene::sleep::SleepSettings::speed) for
//! [`SleepSettings::delay`](crate::scene::sleep::SleepSettings::delay)) and one of them lies on a
//! body at rest. A sleeping body keeps its state bit for bit until a moving body touches it.

use glam::{DQuat, DVec3};
use rapier3d::prelude::*;

use crate::rigid::body_contacts::{self, BodyContact};
use crate::rigid::rolling_ball::{Obstacle, RollingBallSolver};
use crate::rigid::rolling_resistance::Support;
use crate::rigid::settings::{RigidSettings, RigidSubstepSettings};
use crate::rigid::state::BodyState;
use crate::rigid::{MotionKind, RigidWorld, path_pose, substeps};
use crate::scene::sleep::SLEEP;

const SETTINGS: RigidSettings = RigidSettings::DEFAULT;
const SUBSTEPS: RigidSubstepSettings = RigidSettings::DEFAULT.substeps;

/// Motion of a body in a step.
#[derive(Clone)]
pub(crate) struct RigidMotion {
    pub kind: MotionKind,
    /// States at the start and at the end of the last step.
    pub start: BodyState,
    pub end: BodyState,
    /// State at the start of the last substep.
    pub substep_start: BodyState,
    pub asleep: bool,
    /// Time for which the body has rested, s.
    pub rest_time: f64,
    /// Whether the contact solver of the sheets has set the state in the last step.
    pub set_by_contact: bool,
    /// Whether a contact impulse acted in the last step.
    pub had_impulse: bool,
    /// Distance of the farthest point from the centre of mass, m.
    pub extent: f64,
}

impl RigidMotion {
    pub fn is_free(&self) -> bool {
        matches!(self.kind, MotionKind::Dynamic)
    }

    /// Upper bound of the speed of any point of the body at the start of the step, m/s.
    fn speed(&self) -> f64 {
        self.start.velocity().length() + self.start.spin().length() * self.extent
    }
}

impl RigidWorld {
    /// Advance the bodies from time `t` to `t + dt` (s) in the gravity `g` (m/s²).
    pub fn step(&mut self, t: f64, dt: f64, g: DVec3) {
        for motion in &mut self.motions {
            motion.start = motion.end;
            (motion.set_by_contact, motion.had_impulse) = (false, false);
        }
        if self.has_loads() {
            self.apply_loads(0.5 * dt);
            self.motions.iter_mut().for_each(|motion| motion.start = motion.end);
        }
        self.lost_joints = 0;
        let awake = self.motions.iter().any(|m| m.is_free() && !m.asleep);
        self.contacts.clear();
        if !(self.has_kinematic || awake) {
            return;
        }
        self.update_kinematic_bodies(t, dt);
        self.wake_jointed();
        self.inner.gravity = g.as_vec3();
        let has_free = self.motions.iter().any(RigidMotion::is_free);
        let (mut done, mut number) = (0.0, 0);
        while done < dt {
            let part = if has_free { self.next_substep((done, dt), number, g) } else { dt };
            self.advance_substep((done, part, dt), g);
            done = if part < dt - done { done + part } else { dt };
            number += 1;
        }
        if has_free {
            self.set_prediction_distance(0.0);
            (0..self.motions.len()).for_each(|index| self.update_rest_time(index, dt));
            if self.sleep {
                self.sleep_resting_islands(dt);
            }
        }
    }

    /// Advance all bodies by a substep of `part` s that begins `done` s after the start of a step
    /// of `dt` s.
    fn advance_substep(&mut self, (done, part, dt): (f64, f64, f64), g: DVec3) {
        let is_last = part >= dt - done;
        for (body, motion) in self.bodies.iter().zip(&mut self.motions) {
            match motion.kind {
                MotionKind::Static => {}
                MotionKind::Dynamic => motion.substep_start = motion.end,
                MotionKind::Path | MotionKind::Target(_) => {
                    let to = if is_last { motion.end } else { motion.start.free_flight(done + part, DVec3::ZERO) };
                    if let Some(rigid) = self.inner.bodies.get_mut(body.handle) {
                        let pose = Pose::from_parts(to.origin().as_vec3(), to.rotation().as_quat());
                        rigid.set_next_kinematic_position(pose);
                    }
                }
            }
        }
        let p = &mut self.inner.integration_parameters;
        // The warm start scales with the length of the substep.
        p.warmstart_coefficient = (part as f32 / p.dt).min(1.0);
        p.dt = part as f32;
        self.inner.step_with_events(&self.owners, &());
        body_contacts::collect(&self.inner, &self.owners, &self.motions, &mut self.contacts);
        for index in 0..self.motions.len() {
            if self.motions[index].is_free() {
                self.restore_excluded(index);
                self.read_back(index, (done, part, dt), g);
            }
        }
    }

    /// Set the velocities with which kinematic bodies reach their poses at `t + dt`.
    fn update_kinematic_bodies(&mut self, t: f64, dt: f64) {
        for (body, motion) in self.bodies.iter().zip(&mut self.motions) {
            let to = match &mut motion.kind {
                MotionKind::Static | MotionKind::Dynamic => continue,
                MotionKind::Path => path_pose(&body.placement, &body.path, t + dt),
                MotionKind::Target(to) => to.take().unwrap_or((motion.end.origin(), motion.end.rotation())),
            };
            (motion.start, motion.end) = motion.end.kinematic(to.0, to.1, dt);
        }
    }

    /// Read back the motion of the dynamic body `index` in a substep of `part` s that begins `done`
    /// s after the start of a step of `dt` s.
    fn read_back(&mut self, index: usize, (done, part, dt): (f64, f64, f64), g: DVec3) {
        let jointed = self.is_jointed(index);
        let push = jointed || self.has_contact_impulse(index);
        let disturbed = self.motions[index].asleep && self.is_woken(index);
        let motion = &mut self.motions[index];
        if motion.asleep && !disturbed {
            motion.had_impulse |= push;
            self.write_to_rapier(index);
            return;
        }
        motion.asleep = false;
        let flown = motion.substep_start.free_flight(part, g);
        let alone = !jointed && self.touches_no_dynamic_body(index);
        let (end, pushed) = match self.radius(index).filter(|_| alone) {
            Some(radius) => {
                let rolled = self.roll_ball(index, radius, (done, part), g);
                (rolled.unwrap_or(flown), rolled.is_some())
            }
            None => {
                let strikes = push && alone && part <= dt * SUBSTEPS.impact_fraction;
                let bounced = if strikes { self.state_after_impact(index, part, g) } else { None };
                let end = bounced.or_else(|| self.rapier_state(index, part, g, push)).unwrap_or(flown);
                let ball = self.radius(index).filter(|_| push);
                (ball.map_or(end, |radius| self.support(index).resist(&end, radius, g * part)), push)
            }
        };
        let motion = &mut self.motions[index];
        motion.had_impulse |= pushed;
        motion.end = end;
        self.write_to_rapier(index);
    }

    /// Sum of the contacts on which body `index` lies.
    fn support(&self, index: usize) -> Support {
        let mut support = Support::default();
        for c in self.contacts.iter().filter(|c| (c.a == index || c.b == index) && c.distance < self.contact_distance())
        {
            let (normal, other) = if c.a == index { (c.normal, c.b) } else { (-c.normal, c.a) };
            support.add(normal, c.friction, self.motions[other].start.spin());
        }
        support
    }

    /// Rapier's result for body `index` after a substep in which contact impulses did (`pushed`) or
    /// did not act; `None` for a free flight.
    fn rapier_state(&self, index: usize, part: f64, g: DVec3, pushed: bool) -> Option<BodyState> {
        let rigid = self.inner.bodies.get(self.bodies[index].handle)?;
        let from = &self.motions[index].substep_start;
        let pose = rigid.position();
        let (origin, rotation) = (pose.translation.as_dvec3(), pose.rotation.as_dquat().normalize());
        if pushed {
            let (velocity, spin) = (rigid.linvel().as_dvec3(), rigid.angvel().as_dvec3());
            return Some(BodyState::new(*from.mass_properties(), origin, rotation, velocity, spin));
        }
        // Rapier's free flight updates the velocity first, in equal substeps.
        let substeps = self.inner.integration_parameters.num_solver_iterations as f64;
        let fall = g * (0.5 * part * part * (1.0 + 1.0 / substeps));
        let centre = from.centre() + from.velocity() * part + fall;
        let there = origin + rotation * from.mass_properties().centre;
        let size = there.abs().max_element() + self.motions[index].extent + centre.distance(from.centre());
        // Rapier's continuous collision detection has stopped the body short of an obstacle.
        let stopped = there.distance(centre) > 1e-5 * size;
        let flown = from.free_flight(part, g);
        stopped.then(|| flown.displaced(there - flown.centre(), DVec3::ZERO))
    }

    /// Whether no dynamic body is near body `index`.
    fn touches_no_dynamic_body(&self, index: usize) -> bool {
        let mut of = self.contacts.iter().filter(|c| c.a == index || c.b == index);
        of.all(|c| !(self.motions[c.a].is_free() && self.motions[c.b].is_free()))
    }

    /// Advance ball `index` by a substep among static and kinematic bodies; `None` without contact.
    fn roll_ball(&mut self, index: usize, radius: f64, (done, part): (f64, f64), g: DVec3) -> Option<BodyState> {
        let mut rolling = std::mem::take(&mut self.rolling);
        rolling.obstacles.clear();
        let from = self.motions[index].substep_start;
        let own = self.bodies[index].colliders.first().copied();
        let way = (from.velocity().length() + g.length() * part) * part;
        let ours = own.and_then(|handle| self.inner.colliders.get(handle));
        for (body, collider) in self.obstacles_near(index, way) {
            let Some((a, b)) = ours.zip(self.inner.colliders.get(collider)) else { continue };
            let mean = |a: f32, b: f32| 0.5 * (f64::from(a) + f64::from(b));
            let combined = (mean(a.friction(), b.friction()), mean(a.restitution(), b.restitution()));
            let name = |index: usize| self.bodies[index].material.as_deref().unwrap_or_default();
            let (friction, restitution) = self.owners.contact.between((name(index), name(body)), combined);
            let (convex, over) = (substeps::is_convex(b), self.motions[body].start);
            rolling.obstacles.push(Obstacle { body, collider, friction, restitution, convex, body_state: over });
        }
        let end = rolling.advance(&self.inner.colliders, &from, radius, (done, part), g);
        if let Some(own) = own.filter(|_| end.is_some()) {
            self.record_contacts(index, own, radius, &rolling);
        }
        self.rolling = rolling;
        end
    }

    /// Add the contacts of ball `index` that Rapier has not detected.
    fn record_contacts(&mut self, index: usize, own: ColliderHandle, radius: f64, rolling: &RollingBallSolver) {
        let start = self.motions[index].start;
        for gap in &rolling.touched {
            let wall = &rolling.obstacles[gap.obstacle];
            let is_known = |c: &BodyContact| (c.a == index && c.b == wall.body) || (c.b == index && c.a == wall.body);
            if self.contacts.iter().any(is_known) {
                continue;
            }
            let (on_a, on_b) = (start.local_point(start.centre() - gap.normal * radius), gap.place);
            let is_ball = self.inner.colliders.get(wall.collider).is_some_and(|c| c.shape().as_ball().is_some());
            self.contacts.push(BodyContact {
                a: index,
                b: wall.body,
                on_a,
                on_b,
                round: [true, is_ball],
                normal: gap.normal,
                distance: (start.world_point(on_a) - wall.body_state.world_point(on_b)).dot(gap.normal),
                friction: wall.friction,
                restitution: wall.restitution,
                key: [body_contacts::feature_key(own, 0), body_contacts::feature_key(wall.collider, 0)],
            });
            body_contacts::sort(&mut self.contacts);
        }
    }

    /// Update the rest time of body `index` after a step of `dt` s.
    fn update_rest_time(&mut self, index: usize, dt: f64) {
        let motion = &mut self.motions[index];
        if !motion.is_free() || motion.asleep {
            return;
        }
        let (start, end) = (&motion.start, &motion.end);
        let gone = end.centre().distance(start.centre());
        let turned = (end.rotation() * start.rotation().conjugate()).to_scaled_axis().length();
        let turned = turned.min(std::f64::consts::TAU - turned);
        let still = gone + turned * motion.extent < SLEEP.speed * dt;
        motion.rest_time = if still { motion.rest_time + dt } else { 0.0 };
    }

    /// Whether a contact impulse of Rapier acted on body `index` in the last step.
    fn has_contact_impulse(&self, index: usize) -> bool {
        let colliders = self.bodies[index].colliders.iter();
        colliders
            .flat_map(|c| self.inner.narrow_phase.contact_pairs_with(*c))
            .any(|p| p.total_impulse_magnitude() > 0.0)
    }

    /// Whether a moving body touches the sleeping body `index`.
    fn is_woken(&self, index: usize) -> bool {
        self.contacts.iter().filter(|c| c.a == index || c.b == index).any(|c| {
            let other = &self.motions[if c.a == index { c.b } else { c.a }];
            let touches = c.distance < self.contact_distance();
            match other.kind {
                MotionKind::Static => false,
                MotionKind::Dynamic => !other.asleep && touches && other.speed() > SETTINGS.wake_speed,
                MotionKind::Path | MotionKind::Target(_) => touches && other.start.is_moving(),
            }
        })
    }

    /// Distance (m) below which two bodies count as touching.
    pub(crate) fn contact_distance(&self) -> f64 {
        f64::from(self.owners.contact_distance)
    }

    /// Put to sleep the islands of touching bodies that all rest and lie on a body at rest.
    fn sleep_resting_islands(&mut self, dt: f64) {
        let ready =
            |m: &RigidMotion| m.is_free() && !m.asleep && !m.set_by_contact && m.rest_time >= SLEEP.delay - 0.5 * dt;
        if !self.motions.iter().any(ready) {
            return;
        }
        self.island_roots.clear();
        self.island_roots.extend(0..self.motions.len());
        for c in &self.contacts {
            if self.motions[c.a].is_free() && self.motions[c.b].is_free() {
                let (a, b) = (island_root(&self.island_roots, c.a), island_root(&self.island_roots, c.b));
                self.island_roots[a.max(b)] = a.min(b);
            }
        }
        self.unite_jointed();
        for first in 0..self.motions.len() {
            if self.motions[first].is_free()
                && island_root(&self.island_roots, first) == first
                && self.can_sleep(first, ready)
            {
                for index in first..self.motions.len() {
                    if island_root(&self.island_roots, index) == first {
                        self.put_to_sleep(index);
                    }
                }
            }
        }
    }

    /// Whether the island with the root `first` may sleep.
    fn can_sleep(&self, first: usize, ready: impl Fn(&RigidMotion) -> bool) -> bool {
        let member = |index: usize| self.motions[index].is_free() && island_root(&self.island_roots, index) == first;
        let mut members = (first..self.motions.len()).filter(|i| member(*i)).map(|i| &self.motions[i]).peekable();
        let all_still = members.all(|m| ready(m) || m.asleep);
        // A body without contact rests only if it is exactly motionless.
        let floats = |m: &RigidMotion| !m.had_impulse && !m.end.is_moving() && m.start == m.end;
        let mut lies = floats(&self.motions[first]);
        for c in self.contacts.iter().filter(|c| member(c.a) != member(c.b)) {
            let other = &self.motions[if member(c.a) { c.b } else { c.a }];
            if other.start.is_moving() {
                return false;
            }
            lies |= c.distance < self.contact_distance();
        }
        if !self.inner.impulse_joints.is_empty() {
            let held = (first..self.motions.len()).filter(|index| member(*index));
            for other in held.flat_map(|index| self.jointed_with(index)).filter(|other| !member(*other)) {
                if self.motions[other].start.is_moving() {
                    return false;
                }
                lies = true;
            }
        }
        all_still && lies
    }

    /// Unite the islands of dynamic bodies that joints connect.
    fn unite_jointed(&mut self) {
        if self.inner.impulse_joints.is_empty() {
            return;
        }
        for index in 0..self.motions.len() {
            let mut roots = std::mem::take(&mut self.island_roots);
            for other in self.jointed_with(index).filter(|other| self.motions[*other].is_free()) {
                if self.motions[index].is_free() {
                    let (a, b) = (island_root(&roots, index), island_root(&roots, other));
                    roots[a.max(b)] = a.min(b);
                }
            }
            self.island_roots = roots;
        }
    }

    /// Set the state of the dynamic body `index` at the end of the step, as solved together with
    /// the sheets. Other bodies are unchanged.
    pub fn set_state(&mut self, index: usize, end: BodyState) {
        let Some(motion) = self.motions.get_mut(index).filter(|m| m.is_free()) else { return };
        motion.end = end;
        (motion.set_by_contact, motion.asleep, motion.rest_time) = (true, false, 0.0);
        self.write_to_rapier(index);
    }

    /// Set the velocity (m/s) and the angular velocity (rad/s) of the dynamic body `index` and wake
    /// it.
    pub(crate) fn set_velocity(&mut self, index: usize, velocity: DVec3, spin: DVec3) {
        let Some(motion) = self.motions.get_mut(index).filter(|m| m.is_free()) else { return };
        motion.end = motion.end.with_velocity(velocity, spin);
        self.wake(index);
    }

    /// Place the dynamic body called `name` at `origin` (m), at rest, and wake all bodies. Return
    /// false if there is none.
    pub(crate) fn teleport(&mut self, index: usize, origin: DVec3, rotation: DQuat) -> bool {
        let Some(motion) = self.motions.get_mut(index).filter(|m| m.is_free()) else { return false };
        motion.end = BodyState::new(*motion.end.mass_properties(), origin, rotation, DVec3::ZERO, DVec3::ZERO);
        motion.start = motion.end;
        // Bodies that lay on it have lost their support.
        self.wake_all();
        true
    }

    /// Place body `index` at `origin` (m) as a static body, for display. Its former state is lost.
    pub(crate) fn place_static(&mut self, index: usize, origin: DVec3, rotation: DQuat) {
        let Some(motion) = self.motions.get_mut(index) else { return };
        motion.end = BodyState::fixed_at(origin, rotation);
        motion.start = motion.end;
        self.write_to_rapier(index);
    }

    /// Put the dynamic body `index` to sleep: it keeps its pose until woken.
    pub fn put_to_sleep(&mut self, index: usize) {
        let Some(motion) = self.motions.get_mut(index).filter(|m| m.is_free()) else { return };
        motion.end = motion.end.at_rest();
        motion.asleep = true;
        self.write_to_rapier(index);
    }

    /// Wake body `index`.
    pub fn wake(&mut self, index: usize) {
        let Some(motion) = self.motions.get_mut(index).filter(|m| m.is_free()) else { return };
        (motion.asleep, motion.rest_time) = (false, 0.0);
        self.write_to_rapier(index);
    }

    /// Wake all bodies.
    pub fn wake_all(&mut self) {
        (0..self.motions.len()).for_each(|index| self.wake(index));
    }

    /// Enable or disable sleep of resting bodies; enabled by default.
    pub fn set_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
        if !sleep {
            self.wake_all();
        }
    }

    /// Pass the pose and velocities of body `index` at the end of the step to Rapier.
    pub(crate) fn write_to_rapier(&mut self, index: usize) {
        let (motion, body) = (&self.motions[index], &self.bodies[index]);
        let Some(rigid) = self.inner.bodies.get(body.handle) else { return };
        let pose = Pose::from_parts(motion.end.origin().as_vec3(), motion.end.rotation().as_quat());
        let (velocity, spin) = (motion.end.velocity().as_vec3(), motion.end.spin().as_vec3());
        let moved = *rigid.position() != pose;
        let turns_in = motion.asleep != rigid.is_sleeping();
        if !moved && !turns_in && rigid.linvel() == velocity && rigid.angvel() == spin {
            return;
        }
        // Only changed bodies are accessed mutably: Rapier re-examines each body accessed in this
        // way.
        let Some(rigid) = self.inner.bodies.get_mut(body.handle) else { return };
        rigid.set_position(pose, false);
        rigid.set_linvel(velocity, false);
        rigid.set_angvel(spin, false);
        match (motion.asleep, turns_in) {
            (true, true) => rigid.sleep(),
            (false, true) => rigid.wake_up(true),
            _ => {}
        }
        if moved {
            for handle in &body.colliders {
                if let Some(collider) = self.inner.colliders.get_mut(*handle) {
                    collider.set_position(pose);
                }
            }
        }
    }

    /// Contacts between bodies at the start of the last step, at least one of each pair dynamic, in
    /// a deterministic order.
    pub fn body_contacts(&self) -> &[BodyContact] {
        &self.contacts
    }
}

/// Root of the island of `index`.
fn island_root(groups: &[usize], mut index: usize) -> usize {
    while groups[index] != index {
        index = groups[index];
    }
    index
}
