//! What slows a ball that rolls or spins in place: the patch of finite size on which a real one lies.
//!
//! Contact at a point, which is all that a rigid ball of radius r has, neither resists rolling nor turning about its normal, and a ball would never
//! come to rest. On the patch the pressure is ahead of the centre by a length f while it rolls, and friction has an arm: with a normal
//! force N the couples are at most
//!
//!   rolling: N f,  f = C r        drilling: 2/3 μ N a,  a = A r
//!
//! (Johnson, Contact Mechanics, 1985, 8.4 and 9.1; the disc of even pressure.) N is taken to be the weight m |g·n|, which is what it is
//! where balls come to rest. A ball that rolls loses 5/7 C g, one that spins 5/3 μ A g/r.

use glam::{DMat3, DVec3};

use crate::rigid::state::BodyState;

/// C: of hard balls on hard ground 0.0003 to 0.002.
const ROLLING: f64 = 5e-4;
/// A: as for a ball that is pressed in by 2e-4 of its radius.
const PATCH: f64 = 0.02;

/// What a body lies on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Support {
    /// Sum of the normals towards the body.
    normal: DVec3,
    /// Sums of the friction coefficients and of the angular velocities (rad/s) of what is touched, and how many.
    friction: f64,
    spin: DVec3,
    count: u32,
}

impl Support {
    /// Adds a place where it touches something that turns with `spin` (rad/s), with the normal towards it and the friction coefficient.
    pub fn add(&mut self, normal: DVec3, friction: f64, spin: DVec3) {
        self.normal += normal;
        self.friction += friction;
        self.spin += spin;
        self.count += 1;
    }

    /// The motion of a ball of radius `radius` (m) with what this takes from its spin while gravity gives it `pull` (m/s).
    pub fn resist(&self, ball: &BodyState, radius: f64, pull: DVec3) -> BodyState {
        let spin = self.slowed(ball.spin(), (ball.mass(), radius, &ball.inverse_inertia()), pull);
        ball.with_velocity(ball.velocity(), spin)
    }

    /// What this leaves of the spin (rad/s) of a ball of that mass (kg), radius (m) and I⁻¹ while gravity gives it `pull` (m/s).
    pub fn slowed(&self, spin: DVec3, (mass, radius, inverse_inertia): (f64, f64, &DMat3), pull: DVec3) -> DVec3 {
        let Some(normal) = self.normal.try_normalize() else { return spin };
        let pressed = (-pull.dot(normal)).max(0.0) * mass;
        let count = f64::from(self.count);
        let (friction, ground) = (self.friction / count, self.spin / count);
        let yields = |axis: DVec3| (*inverse_inertia * axis).dot(axis);
        let spin = spin - ground;
        let drilling = spin.dot(normal);
        let rolling = spin - normal * drilling;
        let brake = (2.0 / 3.0) * friction * PATCH * radius * pressed * yields(normal);
        let kept = drilling - drilling.clamp(-brake, brake);
        let slower = ROLLING * radius * pressed * yields(rolling.normalize_or_zero());
        let rolls = rolling - rolling.clamp_length_max(slower);
        ground + normal * kept + rolls
    }
}
