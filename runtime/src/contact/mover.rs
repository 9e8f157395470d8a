//! A body as a contact problem sees it over one stage: where it would be without the sheets, and how it gives way.
//!
//! A force p at arm r (m, from the centre of mass) moves it in a stage of weight h (s) by h² p/m and turns it by
//! h² I⁻¹ (r × p); an impulse h p changes its velocities by h p/m and h I⁻¹ (r × p). That is how the sheets answer with
//! their tangent M/h² + K for K = 0, so action and reaction agree.

use glam::{DMat3, DVec3};

use super::frame::RigidFrame;
use super::rigid::BodyState;

/// A body over a stage.
#[derive(Clone, Copy)]
pub(crate) struct Mover {
    /// At the start of the stage, and at its end, were there no sheets.
    pub start: BodyState,
    pub free: BodyState,
    /// I⁻¹ in the world at the end, 1/(kg m²).
    inverse_inertia: DMat3,
    /// What contact did to it: displacement of the centre (m), turn (rad), jumps of velocity (m/s) and angular velocity (rad/s).
    pub shift: DVec3,
    pub turn: DVec3,
    pub kick: DVec3,
    pub twist: DVec3,
}

impl Mover {
    /// A body that is at `start`.
    pub fn new(start: BodyState) -> Self {
        let none = DVec3::ZERO;
        Self { start, free: start, inverse_inertia: DMat3::ZERO, shift: none, turn: none, kick: none, twist: none }
    }

    /// Begins a stage at whose end it would be at `free`.
    pub fn begin(&mut self, free: BodyState) {
        self.free = free;
        self.inverse_inertia = free.inverse_inertia();
        self.release();
        (self.kick, self.twist) = (DVec3::ZERO, DVec3::ZERO);
    }

    /// Forgets what contact did to its place.
    pub fn release(&mut self) {
        (self.shift, self.turn) = (DVec3::ZERO, DVec3::ZERO);
    }

    /// Where the stage leaves it, contact included.
    pub fn end(&self) -> BodyState {
        if !self.gives() {
            return self.free;
        }
        let placed = self.free.displaced(self.shift, self.turn);
        placed.with_velocity(self.free.velocity() + self.kick, self.free.spin() + self.twist)
    }

    /// Its frame at the end of the stage, as far as contact has been solved for.
    pub fn end_frame(&self) -> RigidFrame {
        frame(&self.free.displaced(self.shift, self.turn))
    }

    /// Displacement by contact of what is at arm `r`, m.
    pub fn moved(&self, r: DVec3) -> DVec3 {
        self.shift + self.turn.cross(r)
    }

    /// Adds what `force` (N) with `moment` about the centre (N m) does to its place in a stage of weight `h`.
    pub fn displace(&mut self, force: DVec3, moment: DVec3, h: f64) {
        self.shift += force * (h * h * self.free.inverse_mass());
        self.turn += self.inverse_inertia * moment * (h * h);
    }

    /// Adds what they do to its velocities.
    pub fn strike(&mut self, force: DVec3, moment: DVec3, h: f64) {
        self.kick += force * (h * self.free.inverse_mass());
        self.twist += self.inverse_inertia * moment * h;
    }

    /// What forces of 1 N at arm `at` do at arm `r`, in units of h²: a 3x3 matrix, 1/kg.
    pub fn compliance(&self, r: DVec3, at: DVec3) -> DMat3 {
        let inverse_mass = self.free.inverse_mass();
        let column = |e: DVec3| e * inverse_mass + (self.inverse_inertia * at.cross(e)).cross(r);
        DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
    }

    /// Whether it gives way.
    pub fn gives(&self) -> bool {
        self.free.gives()
    }
}

/// Frame of a body.
pub(crate) fn frame(state: &BodyState) -> RigidFrame {
    let (origin, rotation) = state.frame();
    RigidFrame { origin, rotation }
}
