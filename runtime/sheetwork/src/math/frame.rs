//! Rigid frames in double precision: x_world = R x_local + o, m.

use glam::{DMat3, DQuat, DVec3};
use rapier3d::math::Pose;

/// Where a rigid body is: the turn from its own frame to the world's and the place of its origin, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidFrame {
    /// Place of the body's origin, m.
    pub origin: DVec3,
    /// Turn from the body's frame to the world's; a rotation.
    pub rotation: DMat3,
}

impl RigidFrame {
    /// The world's own frame.
    pub const IDENTITY: Self = Self { origin: DVec3::ZERO, rotation: DMat3::IDENTITY };

    /// From a place (m) and a turn, which need not be of unit length to the last bit.
    pub fn from_parts(origin: DVec3, turn: DQuat) -> Self {
        Self { origin, rotation: DMat3::from_quat(turn.normalize()) }
    }

    /// Of a single-precision pose.
    pub fn of(pose: &Pose) -> Self {
        Self::from_parts(pose.translation.as_dvec3(), pose.rotation.as_dquat())
    }

    /// A point of the world in the body's frame, m.
    #[inline]
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.rotation.transpose() * (p - self.origin)
    }

    /// A point of the body in the world, m.
    #[inline]
    pub fn world(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.origin
    }

    /// A direction of the body in the world.
    #[inline]
    pub fn direction(&self, d: DVec3) -> DVec3 {
        self.rotation * d
    }

    /// A direction of the world in the body's frame.
    #[inline]
    pub fn local_direction(&self, d: DVec3) -> DVec3 {
        self.rotation.transpose() * d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_where_it_was() {
        let frame = RigidFrame::from_parts(DVec3::new(1.0, -2.0, 3.0), DQuat::from_rotation_y(0.7));
        let p = DVec3::new(0.3, 0.2, -0.1);
        assert!(frame.local(frame.world(p)).distance(p) < 1e-15);
        assert!(frame.local_direction(frame.direction(p)).distance(p) < 1e-15);
        // A quarter turn about y takes x to -z.
        let quarter = RigidFrame::from_parts(DVec3::ZERO, DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2));
        assert!(quarter.world(DVec3::X).distance(DVec3::NEG_Z) < 1e-15);
    }
}
