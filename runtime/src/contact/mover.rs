//! A body as a contact problem sees it over one stage: where it would be without the sheets, and how it gives way.
//!
//! A force p at arm r (m, from the centre of mass) moves it in a stage of weight h (s) by h² p/m and turns it by
//! h² I⁻¹ (r × p); an impulse h p changes its velocities by h p/m and h I⁻¹ (r × p). That is how the sheets answer with
//! their tangent M/h² + K for K = 0, so action and reaction agree.

use glam::{DMat3, DVec3};

use super::target::Frame;

/// A body over a stage.
#[derive(Clone, Copy)]
pub(crate) struct Mover {
    /// Its frame at the start of the stage.
    pub start: Frame,
    /// Its frame at the end, were there no sheets.
    pub free: Frame,
    /// Centre of mass at the start and, without sheets, at the end, m.
    pub centre: [DVec3; 2],
    /// Velocity of the centre at the start and, without sheets, at the end, m/s.
    pub linear: [DVec3; 2],
    /// Angular velocity likewise, rad/s.
    pub angular: [DVec3; 2],
    /// 1/m, 1/kg; 0 for a body that does not give way.
    pub inverse_mass: f64,
    /// I⁻¹ in the world, 1/(kg m²).
    pub inverse_inertia: DMat3,
    /// What contact did to it: displacement of the centre (m), turn (rad), jumps of velocity (m/s) and angular velocity (rad/s).
    pub shift: DVec3,
    pub turn: DVec3,
    pub kick: DVec3,
    pub twist: DVec3,
}

impl Mover {
    /// Forgets what contact did.
    pub fn release(&mut self) {
        self.shift = DVec3::ZERO;
        self.turn = DVec3::ZERO;
    }

    /// Its frame at the end of the stage, contact included.
    pub fn end(&self) -> Frame {
        if self.shift == DVec3::ZERO && self.turn == DVec3::ZERO {
            self.free
        } else {
            self.free.moved(self.centre[1], self.shift, self.turn)
        }
    }

    /// Displacement by contact of what is at arm `r`, m.
    pub fn moved(&self, r: DVec3) -> DVec3 {
        self.shift + self.turn.cross(r)
    }

    /// What forces of 1 N at arm `at` do at arm `r`, in units of h²: a 3x3 matrix, 1/kg.
    pub fn compliance(&self, r: DVec3, at: DVec3) -> DMat3 {
        let column = |e: DVec3| e * self.inverse_mass + (self.inverse_inertia * at.cross(e)).cross(r);
        DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
    }

    /// Whether it gives way.
    pub fn gives(&self) -> bool {
        self.inverse_mass > 0.0
    }
}
