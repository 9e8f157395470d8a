//! Rigid frames in double precision: x_world = R x_local + o, m.

use glam::{DMat3, DQuat, DVec3};
use rapier3d::math::Pose;

/// Pose of a rigid body: rotation from its frame to the world and position of its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidFrame {
    /// Position of the body's origin, m.
    pub origin: DVec3,
    /// Rotation matrix from the body's frame to the world.
    pub rotation: DMat3,
}

impl RigidFrame {
    /// The world frame.
    pub const IDENTITY: Self = Self { origin: DVec3::ZERO, rotation: DMat3::IDENTITY };

    /// Frame from a position (m) and a rotation, which is normalised.
    pub fn from_parts(origin: DVec3, turn: DQuat) -> Self {
        Self { origin, rotation: DMat3::from_quat(turn.normalize()) }
    }

    /// Frame from a single-precision pose.
    pub fn from_pose(pose: &Pose) -> Self {
        Self::from_parts(pose.translation.as_dvec3(), pose.rotation.as_dquat())
    }

    /// Position in the body's frame of the world point `p`, m.
    #[inline]
    pub fn local_point(&self, p: DVec3) -> DVec3 {
        self.rotation.transpose() * (p - self.origin)
    }

    /// World position of the point `p` of the body's frame, m.
    #[inline]
    pub fn world(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.origin
    }

    /// World direction from a direction in the body's frame.
    #[inline]
    pub fn direction(&self, d: DVec3) -> DVec3 {
        self.rotation * d
    }

    /// The frame a time `dt` (s) earlier, for a body with velocity `linear` (m/s) and angular
    /// velocity `angular` (rad/s) about `centre` (m).
    pub fn earlier(&self, linear: DVec3, angular: DVec3, centre: DVec3, dt: f64) -> Self {
        let back = DMat3::from_quat(DQuat::from_scaled_axis(-angular * dt));
        Self { origin: centre + back * (self.origin - centre) - linear * dt, rotation: back * self.rotation }
    }

    /// Direction in the body's frame from a world direction.
    #[inline]
    pub fn local_direction(&self, d: DVec3) -> DVec3 {
        self.rotation.transpose() * d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_and_world_are_inverse() {
        let frame = RigidFrame::from_parts(DVec3::new(1.0, -2.0, 3.0), DQuat::from_rotation_y(0.7));
        let p = DVec3::new(0.3, 0.2, -0.1);
        assert!(frame.local_point(frame.world(p)).distance(p) < 1e-15);
        assert!(frame.local_direction(frame.direction(p)).distance(p) < 1e-15);
        // A quarter turn about y maps x to -z.
        let quarter = RigidFrame::from_parts(DVec3::ZERO, DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2));
        assert!(quarter.world(DVec3::X).distance(DVec3::NEG_Z) < 1e-15);
    }
}
