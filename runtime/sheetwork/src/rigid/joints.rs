//! Joints between the world's own bodies, which are Rapier's impulse joints.
//!
//! Rapier solves them in its step of the bodies, before the step of the sheets. Contact with sheets
//! changes the velocity of a jointed body after that; the joint takes this up in the next step. A
//! jointed body has Rapier's state in single precision, also if it is a ball. Jointed bodies wake
//! and fall asleep together.

use rapier3d::prelude::*;

use crate::error::InputError;
use crate::rigid::settings::RigidSettings;
use crate::rigid::{MotionKind, RigidWorld};
use crate::scene::sleep::SLEEP;

const SETTINGS: RigidSettings = RigidSettings::DEFAULT;

impl RigidWorld {
    /// Join bodies `a` and `b`, which exist.
    pub(crate) fn insert_joint(&mut self, (a, b): (usize, usize), joint: GenericJoint) -> ImpulseJointHandle {
        let handle = self.inner.impulse_joints.insert(self.bodies[a].handle, self.bodies[b].handle, joint, true);
        self.wake(a);
        self.wake(b);
        handle
    }

    /// Joint of this handle and the indices of its bodies.
    pub(crate) fn joint(&self, handle: ImpulseJointHandle) -> Option<(&GenericJoint, [usize; 2])> {
        let joint = self.inner.impulse_joints.get(handle)?;
        Some((&joint.data, [self.index_of_handle(joint.body1())?, self.index_of_handle(joint.body2())?]))
    }

    /// Replace the joint of this handle and wake its bodies. Return false if there is none.
    pub(crate) fn set_joint(&mut self, handle: ImpulseJointHandle, data: GenericJoint) -> bool {
        let Some(bodies) = self.joint(handle).map(|(_, bodies)| bodies) else { return false };
        if let Some(joint) = self.inner.impulse_joints.get_mut(handle, true) {
            joint.data = data;
        }
        bodies.into_iter().for_each(|index| self.wake(index));
        true
    }

    /// Remove the joint of this handle and wake its bodies. Return false if there is none.
    pub(crate) fn remove_joint(&mut self, handle: ImpulseJointHandle) -> bool {
        let Some(bodies) = self.joint(handle).map(|(_, bodies)| bodies) else { return false };
        self.inner.impulse_joints.remove(handle, true);
        bodies.into_iter().for_each(|index| self.wake(index));
        true
    }

    /// Index of the body with this handle of Rapier.
    fn index_of_handle(&self, handle: RigidBodyHandle) -> Option<usize> {
        let collider = self.inner.bodies.get(handle)?.colliders().first()?;
        self.owners.body_of(*collider)
    }

    /// Bodies that joints connect to body `index`.
    pub(super) fn jointed_with(&self, index: usize) -> impl Iterator<Item = usize> {
        let own = self.bodies[index].handle;
        let enabled = self.inner.impulse_joints.attached_enabled_joints(own);
        enabled.filter_map(move |(a, b, ..)| self.index_of_handle(if a == own { b } else { a }))
    }

    /// Whether a joint acts on body `index`.
    pub(super) fn is_jointed(&self, index: usize) -> bool {
        !self.inner.impulse_joints.is_empty() && self.jointed_with(index).next().is_some()
    }

    /// Restore body `index` if Rapier has excluded it, because its pose was not finite, and remove
    /// the joints that act on it: the body flies on.
    pub(super) fn restore_excluded(&mut self, index: usize) {
        let handle = self.bodies[index].handle;
        if self.inner.bodies.get(handle).is_none_or(RigidBody::is_enabled) {
            return;
        }
        let joints: Vec<ImpulseJointHandle> =
            self.inner.impulse_joints.attached_joints(handle).map(|(_, _, joint, _)| joint).collect();
        for joint in &joints {
            self.inner.impulse_joints.remove(*joint, true);
        }
        self.lost_joints += joints.len() as u32;
        if let Some(body) = self.inner.bodies.get_mut(handle) {
            body.set_enabled(true);
        }
    }

    /// Joints that were removed in the last step.
    pub(crate) fn lost_joints(&self) -> u32 {
        self.lost_joints
    }

    /// Whether a joint between two bodies excludes their contact.
    pub(super) fn joint_excludes_contact(&self, a: usize, b: usize) -> bool {
        let joints = &self.inner.impulse_joints;
        !joints.is_empty()
            && joints
                .joints_between(self.bodies[a].handle, self.bodies[b].handle)
                .any(|(_, j)| !j.data.contacts_enabled)
    }

    /// Wake the bodies that joints connect to a moving body.
    pub(super) fn wake_jointed(&mut self) {
        if self.inner.impulse_joints.is_empty() {
            return;
        }
        loop {
            let sleeping = (0..self.motions.len()).filter(|index| self.motions[*index].asleep);
            let pulled = |index: &usize| self.jointed_with(*index).any(|other| self.is_in_motion(other));
            let woken: Vec<usize> = sleeping.filter(pulled).collect();
            if woken.is_empty() {
                return;
            }
            woken.into_iter().for_each(|index| self.wake(index));
        }
    }

    /// Whether a body moves so that it wakes those joined to it.
    fn is_in_motion(&self, index: usize) -> bool {
        let motion = &self.motions[index];
        match motion.kind {
            MotionKind::Static => false,
            MotionKind::Dynamic => !motion.asleep && (motion.rest_time < SLEEP.delay || motion.set_by_contact),
            MotionKind::Path | MotionKind::Target(_) => motion.start.is_moving(),
        }
    }
}

/// Refuse a joint with a number that is not finite or out of range.
pub(crate) fn check_joint(joint: &GenericJoint) -> Result<(), InputError> {
    let frames = [joint.local_frame1, joint.local_frame2];
    let is_near = |frame: &Pose| frame.translation.length() <= SETTINGS.maximum_joint_distance;
    if !frames.iter().all(|frame| is_near(frame) && frame.rotation.is_normalized()) {
        let problem = "has a frame farther than 10 km from the origin of its body, or not of unit length";
        return Err(InputError::new("joint", problem));
    }
    let is_limit =
        |limits: &JointLimits<Real>| limits.min.is_finite() && limits.max.is_finite() && limits.min <= limits.max;
    if !joint.limits.iter().all(is_limit) {
        return Err(InputError::new("joint", "has limits that are not finite, or a minimum above its maximum"));
    }
    let is_motor = |motor: &JointMotor| {
        [motor.target_vel, motor.target_pos].iter().all(|x| x.is_finite())
            && [motor.stiffness, motor.damping].iter().all(|x| x.is_finite() && *x >= 0.0)
            && motor.max_force >= 0.0
    };
    if !joint.motors.iter().all(is_motor) {
        let problem = "has a motor with a target that is not finite, or a stiffness, damping or force below zero";
        return Err(InputError::new("joint", problem));
    }
    Ok(())
}
