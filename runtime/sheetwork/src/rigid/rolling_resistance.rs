//! Rolling and drilling resistance of a ball, from a contact patch of finite size.
//!
//! Contact at a point, the only contact of a rigid ball of radius r, resists neither rolling nor
//! rotation about the normal, so that a ball would never come to rest. On a patch the pressure is
//! centred a length f ahead of the ball while it rolls, and friction has an arm. With a normal
//! force N the torques are at most
//!
//!   rolling: N f,  f = C r        drilling: 2/3 μ N a,  a = A r
//!
//! (Johnson, Contact Mechanics, 1985, 8.4 and 9.1; disc of uniform pressure). N is taken as the
//! weight m |g·n|, its value for a ball near rest. A rolling ball decelerates by 5/7 C g (m/s²), a
//! spinning one by 5/3 μ A g/r (rad/s²).

use glam::{DMat3, DVec3};

use crate::rigid::settings::{RigidSettings, RollingResistanceSettings};
use crate::rigid::state::BodyState;

const SETTINGS: RollingResistanceSettings = RigidSettings::DEFAULT.rolling_resistance;

/// Contacts on which a body lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Support {
    /// Sum of the unit normals towards the body.
    normal: DVec3,
    /// Sums of the friction coefficients and of the angular velocities (rad/s) of the touched
    /// bodies, and their number.
    friction: f64,
    spin: DVec3,
    count: u32,
}

impl Support {
    /// Add a contact with a body that rotates with `spin` (rad/s), with the unit normal towards the
    /// supported body and the friction coefficient.
    pub fn add(&mut self, normal: DVec3, friction: f64, spin: DVec3) {
        self.normal += normal;
        self.friction += friction;
        self.spin += spin;
        self.count += 1;
    }

    /// State of a ball of radius `radius` (m) after the resistance during which gravity adds `pull`
    /// (m/s).
    pub fn resist(&self, ball: &BodyState, radius: f64, pull: DVec3) -> BodyState {
        let spin = self.resisted_spin(ball.spin(), (ball.mass(), radius, &ball.inverse_inertia()), pull);
        ball.with_velocity(ball.velocity(), spin)
    }

    /// Angular velocity (rad/s) of a ball of this mass (kg), radius (m) and I⁻¹ after the
    /// resistance during which gravity adds `pull` (m/s).
    pub fn resisted_spin(
        &self,
        spin: DVec3,
        (mass, radius, inverse_inertia): (f64, f64, &DMat3),
        pull: DVec3,
    ) -> DVec3 {
        let Some(normal) = self.normal.try_normalize() else { return spin };
        let pressed = (-pull.dot(normal)).max(0.0) * mass;
        let count = f64::from(self.count);
        let (friction, ground) = (self.friction / count, self.spin / count);
        let yields = |axis: DVec3| (*inverse_inertia * axis).dot(axis);
        let spin = spin - ground;
        let drilling = spin.dot(normal);
        let rolling = spin - normal * drilling;
        let brake = (2.0 / 3.0) * friction * SETTINGS.patch_ratio * radius * pressed * yields(normal);
        let kept = drilling - drilling.clamp(-brake, brake);
        let slower = SETTINGS.coefficient * radius * pressed * yields(rolling.normalize_or_zero());
        let rolls = rolling - rolling.clamp_length_max(slower);
        ground + normal * kept + rolls
    }
}
