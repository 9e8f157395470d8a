//! Flow around and behind a moving body.
//!
//! Around: potential flow of a sphere of radius R with the volume of the body, which moves with
//! the velocity U through air at rest: u = R³/(2r³) (3 (U·r̂) r̂ - U) (Batchelor, *An
//! Introduction to Fluid Dynamics*, 1967, 2.9); within the radius, its value at the surface.
//!
//! Behind: far wake of a sphere, with the velocity in the direction of motion u_s exp(-ln 2
//! (ρ/b)²) at the distance ρ from the axis. Its half width b grows by db/ds = S u_s/U with S =
//! 0.51 (Pope, *Turbulent Flows*, 2000, 5.4), and its momentum is that of the drag, u_s = C_D R²
//! U ln 2/(2 b²) with C_D = 0.5, so that b³ = R³ + 3/2 S C_D R² ln 2 s at the distance s
//! behind the body. It ends 40 radii behind, as if the body had come from there.

use std::f64::consts::LN_2;

use glam::DVec3;
use rapier3d::prelude::RigidBodySet;

use crate::rigid::RigidView;
use crate::sheet::wind::settings::{WakeSettings, WindSettings};

const SETTINGS: WakeSettings = WindSettings::DEFAULT.wake;

/// Sphere that stands for a moving body.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingBody {
    /// Centre, m.
    pub centre: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Radius of the sphere of equal volume, m.
    pub radius: f64,
}

impl MovingBody {
    /// Collect the moving bodies of a view, in the order of its set.
    pub fn collect(view: &RigidView, to: &mut Vec<Self>) {
        let bodies: &RigidBodySet = view.bodies;
        for (_, body) in bodies.iter() {
            let velocity = body.linvel().as_dvec3();
            if body.is_fixed()
                || velocity.length_squared() < SETTINGS.minimum_speed * SETTINGS.minimum_speed
                || !velocity.is_finite()
            {
                continue;
            }
            let solid = body.colliders().iter().filter_map(|handle| view.colliders.get(*handle));
            let (mut volume, mut moment) = (0.0, DVec3::ZERO);
            for collider in solid.filter(|collider| !collider.is_sensor()) {
                let own = f64::from(collider.volume());
                if own.is_finite() && own > 0.0 {
                    volume += own;
                    let pose = *collider.position() * collider.shape().mass_properties(1.0).local_com;
                    moment += pose.as_dvec3() * own;
                }
            }
            if volume > 0.0 {
                let radius = (0.75 * volume / std::f64::consts::PI).cbrt();
                to.push(Self { centre: moment / volume, velocity, radius });
            }
        }
    }

    /// Velocity of the air at `x` (m), m/s.
    pub fn induced(&self, x: DVec3) -> DVec3 {
        let (away, radius) = (x - self.centre, self.radius);
        let distance = away.length();
        if distance > SETTINGS.reach * radius {
            return DVec3::ZERO;
        }
        let direction = away.normalize_or_zero();
        if direction == DVec3::ZERO {
            return self.velocity;
        }
        let ratio = radius / distance.max(radius);
        let around = (direction * (3.0 * self.velocity.dot(direction)) - self.velocity) * (0.5 * ratio * ratio * ratio);
        around + self.trailing(away)
    }

    /// Velocity of the wake at the place `away` (m) from the centre, m/s.
    fn trailing(&self, away: DVec3) -> DVec3 {
        let ahead = self.velocity.normalize_or_zero();
        let behind = -away.dot(ahead);
        if behind <= 0.0 {
            return DVec3::ZERO;
        }
        let radius = self.radius;
        let width =
            (radius.powi(3) + 1.5 * SETTINGS.spreading * SETTINGS.drag * LN_2 * radius * radius * behind).cbrt();
        let deficit = 0.5 * SETTINGS.drag * LN_2 * radius * radius / (width * width);
        let aside = (away.length_squared() - behind * behind).max(0.0) / (width * width);
        // The far wake begins behind the body and ends gradually.
        let part = (behind / radius).min(1.0) * (1.0 - behind / (SETTINGS.reach * radius)).max(0.0);
        self.velocity * (deficit * part * (-LN_2 * aside).exp())
    }

    /// Whether it moves air in the box from `low` to `high` (m) at more than 1/50 of its velocity.
    pub fn reaches(&self, (low, high): (DVec3, DVec3)) -> bool {
        let nearest = self.centre.clamp(low, high);
        nearest.distance_squared(self.centre) < (12.0 * self.radius).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: MovingBody = MovingBody { centre: DVec3::ZERO, velocity: DVec3::new(10.0, 0.0, 0.0), radius: 0.5 };

    #[test]
    fn the_air_at_the_surface_of_a_sphere_follows_its_normal_velocity() {
        for angle in [0.0_f64, 0.5, 1.2] {
            // Ahead of the body, where there is no wake.
            let n = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let u = BODY.induced(n * 0.5);
            assert!((u.dot(n) - BODY.velocity.dot(n)).abs() < 1e-12, "{angle}");
        }
        let beside = BODY.induced(DVec3::new(0.0, 1.0, 0.0));
        assert!(beside.distance(DVec3::new(-10.0 / 16.0, 0.0, 0.0)) < 1e-12, "{beside}");
    }

    #[test]
    fn the_wake_carries_the_momentum_of_the_drag() {
        for behind in [2.0_f64, 8.0] {
            // Flux U ∫u dA over a section, without the part that fades the wake out.
            let (mut flux, step) = (0.0, 0.005);
            for i in 0..4000 {
                let aside = (f64::from(i) + 0.5) * step;
                let u = BODY.trailing(DVec3::new(-behind, aside, 0.0)).x;
                flux += 10.0 * u * std::f64::consts::TAU * aside * step;
            }
            let drag = 0.5 * 100.0 * SETTINGS.drag * std::f64::consts::PI * 0.25 * (1.0 - behind / 20.0);
            assert!((flux / drag - 1.0).abs() < 1e-3, "{flux} {drag}");
        }
    }
}
