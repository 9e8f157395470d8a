//! Dynamic bodies of a caller's Rapier world that contact with sheets moves.
//!
//! The caller steps its world first. The state at the end of a time T there, in free flight
//! backwards over T, gives the start; the sheets then step with the bodies, and the caller takes
//! over the states of those that a sheet was near. A body far from all sheets keeps the state that
//! the caller gave it, to the bit.

use glam::{DQuat, DVec3};
use rapier3d::prelude::{Pose, RigidBody, RigidBodyHandle, RigidBodySet};

use crate::rigid::settings::RigidSettings;
use crate::rigid::{BodyState, MassProperties, RigidView};

/// A dynamic body of the caller after a step with sheets.
#[derive(Clone, Copy, Debug)]
pub struct LentBody {
    pub(crate) state: BodyState,
    /// Handle in the caller's set.
    pub handle: RigidBodyHandle,
    /// Whether sheets have moved it in the last [`World::advance_with`](crate::World::advance_with)
    /// and [`World::write_lent_bodies`](crate::World::write_lent_bodies) has not written it yet.
    pub is_moved: bool,
    /// Whether it rests on sheets that have gone to sleep.
    pub is_asleep: bool,
}

impl LentBody {
    fn new(handle: RigidBodyHandle, body: &RigidBody) -> Self {
        let pose = body.position();
        let (origin, rotation) = (pose.translation.as_dvec3(), pose.rotation.as_dquat());
        let (velocity, spin) = (body.linvel().as_dvec3(), body.angvel().as_dvec3());
        let state = BodyState::new(MassProperties::from_rapier(body), origin, rotation, velocity, spin);
        Self { state, handle, is_moved: false, is_asleep: body.is_sleeping() }
    }

    /// Position of the origin of the body (m) and rotation.
    pub fn pose(&self) -> (DVec3, DQuat) {
        (self.state.origin(), self.state.rotation())
    }

    /// Velocity of the centre of mass (m/s) and angular velocity (rad/s).
    pub fn velocity(&self) -> (DVec3, DVec3) {
        (self.state.velocity(), self.state.spin())
    }

    /// Write the state to the caller's body; one that rests on sleeping sheets is put to sleep.
    fn write_to(&self, bodies: &mut RigidBodySet) {
        let Some(body) = bodies.get_mut(self.handle) else { return };
        let (origin, rotation) = self.pose();
        let (velocity, spin) = self.velocity();
        body.set_position(Pose::from_parts(origin.as_vec3(), rotation.as_quat()), !self.is_asleep);
        body.set_linvel(velocity.as_vec3(), !self.is_asleep);
        body.set_angvel(spin.as_vec3(), !self.is_asleep);
        if self.is_asleep {
            body.sleep();
        }
    }
}

/// Pose and motion of a body of the caller that leads nodes attached to it.
pub(crate) fn lent_pose(body: &RigidBody) -> BodyState {
    let pose = body.position();
    let (origin, rotation) = (pose.translation.as_dvec3(), pose.rotation.as_dquat());
    let spin = body.angvel().as_dvec3();
    let velocity = body.linvel().as_dvec3() + spin.cross(origin - body.center_of_mass().as_dvec3());
    let still = BodyState::fixed_at(origin, rotation);
    if body.is_fixed() { still } else { still.with_velocity(velocity, spin) }
}

const SETTINGS: RigidSettings = RigidSettings::DEFAULT;

/// The lent bodies, in the order of the caller's set.
#[derive(Default)]
pub(crate) struct LentBodies {
    pub bodies: Vec<LentBody>,
}

impl LentBodies {
    /// Take over the dynamic bodies of `view` at the start of a time `duration` (s), whose end is
    /// their present state, in the gravity `g` (m/s²).
    pub fn begin(&mut self, view: &RigidView, duration: f64, g: DVec3) {
        self.bodies.clear();
        for (handle, body) in view.bodies.iter().filter(|(_, body)| view.is_dynamic(body)) {
            let lent = LentBody::new(handle, body);
            self.bodies.push(LentBody { state: lent.state.free_flight(-duration, g), ..lent });
        }
    }

    /// End a step of `dt` (s) without sheets.
    pub fn fly(&mut self, dt: f64, g: DVec3) {
        self.bodies.iter_mut().for_each(|body| body.state = body.state.free_flight(dt, g));
    }

    /// Set the state of the body `index` at the end of a step with sheets; `sleeps` where it rests
    /// on sheets that go to sleep.
    pub fn set(&mut self, index: usize, end: BodyState, sleeps: bool) {
        let body = &mut self.bodies[index];
        let differs = |a: DVec3, b: DVec3| a.distance(b) > SETTINGS.lent_rounding * (a.length() + b.length());
        let free = &body.state;
        body.is_moved |= differs(free.velocity(), end.velocity()) || differs(free.spin(), end.spin());
        body.state = end;
        body.is_asleep = sleeps || body.is_asleep && !body.is_moved;
    }

    /// Write the states of the bodies that sheets have moved to the caller's set, once.
    pub fn write_to(&mut self, bodies: &mut RigidBodySet) {
        for body in self.bodies.iter_mut().filter(|body| body.is_moved) {
            body.write_to(bodies);
            body.is_moved = false;
        }
    }

    /// Index of a body of the caller.
    pub fn index_of(&self, handle: RigidBodyHandle) -> Option<usize> {
        let place = |handle: RigidBodyHandle| handle.into_raw_parts().0;
        self.bodies.binary_search_by_key(&place(handle), |body| place(body.handle)).ok()
    }
}
