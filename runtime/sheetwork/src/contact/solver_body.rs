//! A rigid body as the contact solver sees it over one stage: its motion without contact, and its
//! response to contact forces.
//!
//! In a stage of weight h (s), a force p (N) at arm r (m, from the centre of mass) displaces the
//! centre by h² p/m and rotates the body by h² I⁻¹ (r × p). An impulse h p changes the velocities
//! by h p/m and h I⁻¹ (r × p). A sheet responds with its tangent M/h² + K; the body is the case K =
//! 0, so that action equals reaction.

use glam::{DMat3, DVec3};

use crate::math::RigidFrame;
use crate::rigid::BodyState;

/// A rigid body over one stage.
#[derive(Clone, Copy)]
pub(crate) struct SolverBody {
    /// State at the start of the stage.
    pub start: BodyState,
    /// State at the end of the stage without contact.
    pub free: BodyState,
    /// I⁻¹ in world axes at the end of the stage, 1/(kg m²).
    inverse_inertia: DMat3,
    /// Displacement of the centre of mass by contact, m.
    pub displacement: DVec3,
    /// Rotation by contact, as a rotation vector, rad.
    pub rotation: DVec3,
    /// Velocity change by contact, m/s.
    pub kick: DVec3,
    /// Change of the angular velocity by contact, rad/s.
    pub spin_jump: DVec3,
}

impl SolverBody {
    /// A body at rest in state `start`.
    pub fn new(start: BodyState) -> Self {
        let none = DVec3::ZERO;
        Self {
            start,
            free: start,
            inverse_inertia: DMat3::ZERO,
            displacement: none,
            rotation: none,
            kick: none,
            spin_jump: none,
        }
    }

    /// Begin a stage that ends in state `free` without contact.
    pub fn begin(&mut self, free: BodyState) {
        self.free = free;
        self.inverse_inertia = free.inverse_inertia();
        self.clear_displacement();
        (self.kick, self.spin_jump) = (DVec3::ZERO, DVec3::ZERO);
    }

    /// Clear the displacement by contact.
    pub fn clear_displacement(&mut self) {
        (self.displacement, self.rotation) = (DVec3::ZERO, DVec3::ZERO);
    }

    /// State at the end of the stage, with contact.
    pub fn end(&self) -> BodyState {
        if !self.is_dynamic() {
            return self.free;
        }
        let placed = self.free.displaced(self.displacement, self.rotation);
        placed.with_velocity(self.free.velocity() + self.kick, self.free.spin() + self.spin_jump)
    }

    /// Frame at the end of the stage, with the contact displacement found so far.
    pub fn end_frame(&self) -> RigidFrame {
        frame_of_body(&self.free.displaced(self.displacement, self.rotation))
    }

    /// Displacement (m) by contact of the point at arm `r` (m).
    pub fn displacement_at(&self, r: DVec3) -> DVec3 {
        self.displacement + self.rotation.cross(r)
    }

    /// Add the displacement by `force` (N) with `moment` (N m) about the centre of mass in a stage
    /// of weight `h` (s).
    pub fn add_displacement(&mut self, force: DVec3, moment: DVec3, h: f64) {
        self.displacement += force * (h * h * self.free.inverse_mass());
        self.rotation += self.inverse_inertia * moment * (h * h);
    }

    /// Add the velocity change by `force` (N) with `moment` (N m) in a stage of weight `h` (s).
    pub fn add_velocity_jump(&mut self, force: DVec3, moment: DVec3, h: f64) {
        self.kick += force * (h * self.free.inverse_mass());
        self.spin_jump += self.inverse_inertia * moment * h;
    }

    /// Compliance block for a force at arm `at` and a displacement at arm `r`, divided by h²: a 3×3
    /// matrix, 1/kg.
    pub fn compliance(&self, r: DVec3, at: DVec3) -> DMat3 {
        let inverse_mass = self.free.inverse_mass();
        let column = |e: DVec3| e * inverse_mass + (self.inverse_inertia * at.cross(e)).cross(r);
        DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
    }

    /// Whether the body is dynamic.
    pub fn is_dynamic(&self) -> bool {
        self.free.is_dynamic()
    }
}

/// Frame of a body in state `state`.
pub(crate) fn frame_of_body(state: &BodyState) -> RigidFrame {
    let (origin, rotation) = state.frame();
    RigidFrame { origin, rotation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::test_island::{ball, fixed_body};

    const H: f64 = 0.02;

    #[test]
    fn force_at_the_centre_moves_a_body_by_h_squared_over_m() {
        let mut body = ball(2.0, DVec3::Y);
        let force = DVec3::new(1.0, -2.0, 3.0);
        body.add_displacement(force, DVec3::ZERO, H);
        body.add_velocity_jump(force, DVec3::ZERO, H);
        assert!(body.displacement.distance(force * (H * H / 2.0)) < 1e-18);
        let end = body.end();
        assert!(end.velocity().distance(force * (H / 2.0)) < 1e-16, "{}", end.velocity());
        assert!(end.centre().distance(DVec3::Y + force * (H * H / 2.0)) < 1e-16);
    }

    #[test]
    fn compliance_is_the_displacement_of_a_point_by_a_force_at_another() {
        let mut body = ball(2.0, DVec3::ZERO);
        let (r, at, force) = (DVec3::new(0.1, 0.0, 0.03), DVec3::new(0.0, -0.07, 0.05), DVec3::new(3.0, 1.0, -2.0));
        body.add_displacement(force, at.cross(force), H);
        // δ + θ × r with δ = h² p/m, θ = h² (at × p)/I and I = 2/5 m (0.1 m)².
        let turn = at.cross(force) * (H * H / (0.4 * 2.0 * 0.01));
        let expected = force * (H * H / 2.0) + turn.cross(r);
        assert!(body.displacement_at(r).distance(expected) < 1e-16);
        assert!((body.compliance(r, at) * force * (H * H)).distance(expected) < 1e-16);
    }

    #[test]
    fn static_body_ignores_forces() {
        let mut body = fixed_body();
        body.add_displacement(DVec3::ONE, DVec3::ONE, H);
        body.add_velocity_jump(DVec3::ONE, DVec3::ONE, H);
        assert_eq!(body.compliance(DVec3::X, DVec3::Y), DMat3::ZERO);
        assert_eq!((body.displacement_at(DVec3::X), body.end()), (DVec3::ZERO, body.start));
    }
}
