//! State of a rigid body in f64: position, rotation, velocities.
//!
//! A dynamic body conserves its momentum m v and its angular momentum L about the centre of mass,
//! apart from gravity and impulses. L is stored, and the angular velocity is ω = I⁻¹ L. Without
//! impulses the centre of mass follows the parabola x + v t + ½ g t² exactly. The rotation q
//! follows the midpoint rule of Simo and Wong (Unconditionally stable algorithms for rigid body
//! dynamics that exactly preserve energy and momentum, Int. J. Numer. Meth. Eng. 31, 1991): with J
//! the principal inertia and W = J⁻¹ q⁻¹L the angular velocity in the body,
//!
//!   q₁ = q₀ exp(θ),  θ = h/2 (W₀ + W₁),
//!
//! of second order in h. L is conserved because it is constant, and the energy ½ L·ω because exp(θ)
//! leaves the component of L along θ unchanged and θ is parallel to W₀ + W₁. The rotation of a
//! ball, or of a body that spins about a principal axis, is exact.
//!
//! A static or kinematic body has the same state with zero mobility: impulses have no effect, and
//! it continues with constant velocity and angular velocity about its origin.

use glam::{DMat3, DQuat, DVec3};

use crate::rigid::mass_properties::MassProperties;
use crate::rigid::settings::{RigidSettings, RotationSettings};
use crate::serialize::state;

const SETTINGS: RotationSettings = RigidSettings::DEFAULT.rotation;

/// State of a rigid body at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    centre: DVec3,
    rotation: DQuat,
    velocity: DVec3,
    angular_velocity: DVec3,
    /// Angular momentum about the centre of mass, world axes, kg m²/s; zero for a static or
    /// kinematic body.
    angular_momentum: DVec3,
    mass_properties: MassProperties,
}

state!(BodyState: centre, rotation, velocity, angular_velocity, angular_momentum, mass_properties.centre,
    mass_properties.principal, mass_properties.axes, mass_properties.mass);

impl BodyState {
    /// State of a body with its origin at `origin` (m) and the rotation `rotation`, whose centre of
    /// mass moves with `velocity` (m/s) and which spins with `spin` (rad/s).
    pub fn new(spread: MassProperties, origin: DVec3, rotation: DQuat, velocity: DVec3, spin: DVec3) -> Self {
        let rotation = rotation.normalize();
        let centre = origin + rotation * spread.centre;
        let still = Self {
            centre,
            rotation,
            velocity,
            angular_velocity: spin,
            angular_momentum: DVec3::ZERO,
            mass_properties: spread,
        };
        still.with_velocity(velocity, spin)
    }

    /// State of a static or kinematic body at rest, with its origin at `origin` (m).
    pub(crate) fn fixed_at(origin: DVec3, rotation: DQuat) -> Self {
        Self::new(MassProperties::immovable(), origin, rotation, DVec3::ZERO, DVec3::ZERO)
    }

    /// States of a kinematic body at the start and at the end of a motion from this pose to
    /// `origin` (m) and `rotation` in `time` (s).
    pub(crate) fn kinematic(&self, origin: DVec3, rotation: DQuat, time: f64) -> (Self, Self) {
        let rotation = rotation.normalize();
        let turn = rotation * self.rotation.conjugate();
        // A rotation has two quaternions; the one with the smaller angle is used.
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let (velocity, spin) = ((origin - self.origin()) / time, turn.to_scaled_axis() / time);
        let start = Self { velocity, angular_velocity: spin, ..*self };
        (start, Self { centre: origin, rotation, ..start })
    }

    /// State with this velocity of the centre of mass (m/s) and this angular velocity (rad/s).
    pub(crate) fn with_velocity(&self, velocity: DVec3, spin: DVec3) -> Self {
        let angular_momentum = if self.is_dynamic() { self.inertia() * spin } else { DVec3::ZERO };
        Self { velocity, angular_velocity: spin, angular_momentum, ..*self }
    }

    /// State with zero velocity and angular velocity.
    pub(crate) fn at_rest(&self) -> Self {
        Self { velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO, angular_momentum: DVec3::ZERO, ..*self }
    }

    /// Whether the body is dynamic: impulses change its motion.
    pub fn is_dynamic(&self) -> bool {
        self.mass_properties.mass.is_finite()
    }

    /// Centre of mass, m; the origin for a static or kinematic body.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Origin of the body frame in the world, m.
    pub fn origin(&self) -> DVec3 {
        self.centre - self.rotation * self.mass_properties.centre
    }

    /// Rotation from the body frame to the world.
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }

    /// Body frame: position of its origin (m) and rotation to the world.
    pub fn frame(&self) -> (DVec3, DMat3) {
        (self.origin(), DMat3::from_quat(self.rotation))
    }

    /// World position of a point of the body frame, m.
    pub fn world_point(&self, local: DVec3) -> DVec3 {
        self.centre + self.rotation * (local - self.mass_properties.centre)
    }

    /// Point of the body frame at the world position `p`, m.
    pub fn local_point(&self, p: DVec3) -> DVec3 {
        self.mass_properties.centre + self.rotation.conjugate() * (p - self.centre)
    }

    /// Velocity of the centre of mass, m/s.
    pub fn velocity(&self) -> DVec3 {
        self.velocity
    }

    /// Angular velocity, rad/s.
    pub fn spin(&self) -> DVec3 {
        self.angular_velocity
    }

    /// Velocity of the point of the body at the world position `p`, m/s.
    pub fn velocity_at(&self, p: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(p - self.centre)
    }

    /// Whether the velocity or the angular velocity is nonzero.
    pub fn is_moving(&self) -> bool {
        self.velocity != DVec3::ZERO || self.angular_velocity != DVec3::ZERO
    }

    /// Mass, kg; infinite for a static or kinematic body.
    pub fn mass(&self) -> f64 {
        self.mass_properties.mass
    }

    /// Mass, centre of mass and inertia.
    pub fn mass_properties(&self) -> &MassProperties {
        &self.mass_properties
    }

    /// Inverse mass, 1/kg; 0 for a static or kinematic body.
    pub(crate) fn inverse_mass(&self) -> f64 {
        1.0 / self.mass_properties.mass
    }

    /// I⁻¹ about the centre of mass, world axes, 1/(kg m²); zero for a static or kinematic body.
    pub(crate) fn inverse_inertia(&self) -> DMat3 {
        if !self.is_dynamic() {
            return DMat3::ZERO;
        }
        let axes = DMat3::from_quat(self.principal_rotation());
        axes * DMat3::from_diagonal(self.mass_properties.principal.recip()) * axes.transpose()
    }

    /// I about the centre of mass of a dynamic body, world axes, kg m².
    pub fn inertia(&self) -> DMat3 {
        let axes = DMat3::from_quat(self.principal_rotation());
        axes * DMat3::from_diagonal(self.mass_properties.principal) * axes.transpose()
    }

    fn principal_rotation(&self) -> DQuat {
        self.rotation * self.mass_properties.axes
    }

    /// Mobility: velocity change at `p` per impulse at `at`, a 3x3 matrix, 1/kg.
    pub(crate) fn mobility(&self, p: DVec3, at: DVec3) -> DMat3 {
        let (inverse, r, s) = (self.inverse_inertia(), p - self.centre, at - self.centre);
        let column = |e: DVec3| e * self.inverse_mass() + (inverse * s.cross(e)).cross(r);
        DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
    }

    /// Momentum m v, kg m/s; zero for a static or kinematic body.
    pub fn momentum(&self) -> DVec3 {
        if self.is_dynamic() { self.velocity * self.mass_properties.mass } else { DVec3::ZERO }
    }

    /// Angular momentum about the point `about` (m), kg m²/s; zero for a static or kinematic body.
    pub fn angular_momentum(&self, about: DVec3) -> DVec3 {
        self.angular_momentum + (self.centre - about).cross(self.momentum())
    }

    /// Kinetic energy ½ m v² + ½ L·ω, J; zero for a static or kinematic body.
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * (self.momentum().dot(self.velocity) + self.angular_momentum.dot(self.angular_velocity))
    }

    /// Potential energy -m g·x in the gravity `g` (m/s²), J; zero at the origin and for a static or
    /// kinematic body.
    pub(crate) fn gravity_energy(&self, g: DVec3) -> f64 {
        if self.is_dynamic() { -self.mass_properties.mass * g.dot(self.centre) } else { 0.0 }
    }

    /// State after `time` (s) of free flight in the gravity `g` (m/s²). A static or kinematic body
    /// continues with constant velocities.
    pub(crate) fn free_flight(&self, time: f64, g: DVec3) -> Self {
        if !self.is_dynamic() {
            let rotation = (DQuat::from_scaled_axis(self.angular_velocity * time) * self.rotation).normalize();
            return Self { centre: self.centre + self.velocity * time, rotation, ..*self };
        }
        let centre = self.centre + (self.velocity + g * (0.5 * time)) * time;
        let flown = Self { centre, velocity: self.velocity + g * time, ..*self };
        flown.with_rotation(self.rotation_after(time))
    }

    /// Rotation after `time` (s) without torque.
    fn rotation_after(&self, time: f64) -> DQuat {
        if self.has_isotropic_inertia() || self.angular_momentum == DVec3::ZERO {
            return DQuat::from_scaled_axis(self.angular_velocity * time) * self.rotation;
        }
        let steps = (self.angular_velocity.length() * time.abs() / SETTINGS.maximum_rotation)
            .ceil()
            .clamp(1.0, SETTINGS.maximum_steps);
        let mut q = self.principal_rotation();
        for _ in 0..steps as u32 {
            q = (q * DQuat::from_scaled_axis(self.rotation_increment(q, time / steps))).normalize();
        }
        q * self.mass_properties.axes.conjugate()
    }

    /// Rotation vector θ of a step of `h` s from the rotation `q` of the principal axes.
    fn rotation_increment(&self, q: DQuat, h: f64) -> DVec3 {
        let inverse = self.mass_properties.principal.recip();
        let momentum = q.conjugate() * self.angular_momentum;
        let before = inverse * momentum;
        let mut turn = before * h;
        for _ in 0..SETTINGS.maximum_newton_iterations {
            let after = DQuat::from_scaled_axis(turn).conjugate() * momentum;
            let residual = turn - (before + inverse * after) * (0.5 * h);
            // d(J⁻¹ exp(-θ) L) = J⁻¹ L₁ × T dθ with T = 1 - ½ θ× + ⅙ θ×θ× - ...; the truncation
            // affects the number of iterations only.
            let scaled = inverse * (0.5 * h);
            let tangent = |e: DVec3| e - 0.5 * turn.cross(e) + turn.cross(turn.cross(e)) / 6.0;
            let column = |e: DVec3| e - scaled * after.cross(tangent(e));
            let slope = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
            let change = slope.inverse() * residual;
            if !change.is_finite() {
                break;
            }
            turn -= change;
            if change.length() <= 1e-16 {
                break;
            }
        }
        turn
    }

    /// State with the given rotation and unchanged angular momentum.
    fn with_rotation(&self, rotation: DQuat) -> Self {
        let turned = Self { rotation: rotation.normalize(), ..*self };
        if !self.is_dynamic() || self.has_isotropic_inertia() {
            return turned;
        }
        Self { angular_velocity: turned.inverse_inertia() * self.angular_momentum, ..turned }
    }

    /// Whether the inertia is equal about all axes, so that rotation does not change the angular
    /// velocity.
    fn has_isotropic_inertia(&self) -> bool {
        let principal = self.mass_properties.principal;
        principal.max_element() - principal.min_element() <= 1e-12 * principal.max_element()
    }

    /// State with the centre of mass displaced by `shift` (m) and the body rotated about it by
    /// `turn` (rad). Momentum and angular momentum are unchanged.
    pub(crate) fn displaced(&self, shift: DVec3, turn: DVec3) -> Self {
        let moved = Self { centre: self.centre + shift, ..*self };
        moved.with_rotation(DQuat::from_scaled_axis(turn) * self.rotation)
    }

    /// State after an impulse (N s) at `at` (m); unchanged for a static or kinematic body.
    pub(crate) fn with_impulse_at(&self, impulse: DVec3, at: DVec3) -> Self {
        self.with_impulse(impulse, (at - self.centre).cross(impulse))
    }

    /// State after an impulse (N s) at the centre of mass and an angular impulse (N m s); unchanged
    /// for a static or kinematic body.
    pub(crate) fn with_impulse(&self, impulse: DVec3, twist: DVec3) -> Self {
        if !self.is_dynamic() {
            return *self;
        }
        let angular_momentum = self.angular_momentum + twist;
        let velocity = self.velocity + impulse * self.inverse_mass();
        Self { velocity, angular_momentum, angular_velocity: self.inverse_inertia() * angular_momentum, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of 1 kg with its main spin about the unstable intermediate axis.
    fn brick(spin: DVec3) -> BodyState {
        let spread = MassProperties {
            mass: 1.0,
            centre: DVec3::new(0.1, -0.2, 0.3),
            principal: DVec3::new(1.0, 2.0, 3.0) * 1e-3,
            axes: DQuat::from_rotation_x(0.4),
        };
        let rotation = DQuat::from_rotation_z(0.7);
        BodyState::new(spread, DVec3::ONE, rotation, DVec3::new(1.0, 2.0, 0.0), rotation * spread.axes * spin)
    }

    #[test]
    fn a_flight_is_a_parabola_and_keeps_angular_momentum_to_the_bit() {
        let g = DVec3::new(0.0, -9.81, 0.0);
        let start = brick(DVec3::new(3.0, 20.0, 0.1));
        let mut state = start;
        for _ in 0..60 {
            state = state.free_flight(1.0 / 60.0, g);
        }
        assert_eq!(state.angular_momentum(state.centre()), start.angular_momentum(start.centre()));
        assert!(state.centre().distance(start.centre() + start.velocity() + 0.5 * g) < 1e-13);
        assert!(state.velocity().distance(start.velocity() + g) < 1e-13);
        assert!((state.origin() - state.world_point(DVec3::ZERO)).length() < 1e-15);
        assert!(
            state.local_point(state.world_point(DVec3::new(3.0, 4.0, 5.0))).distance(DVec3::new(3.0, 4.0, 5.0)) < 1e-13
        );
        let energy = |s: &BodyState| s.kinetic_energy() + s.gravity_energy(g);
        assert!((energy(&state) - energy(&start)).abs() < 1e-12 * start.kinetic_energy());
    }

    #[test]
    fn a_tumbling_brick_turns_over_to_second_order() {
        // Reference: Euler's equations J Ẇ = (J W) × W, q̇ = ½ q W, by the Runge-Kutta method with
        // a step a thousand times smaller.
        let start = brick(DVec3::new(0.3, 6.0, 0.1));
        let (time, j) = (2.0, start.mass_properties.principal);
        let euler = |w: DVec3| (j * w).cross(w) / j;
        let mut q = start.principal_rotation();
        let mut w = q.conjugate() * start.spin();
        let turning = |q: DQuat, w: DVec3| q * DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * 0.5;
        let h = time / 40_000.0;
        for _ in 0..40_000 {
            let (a, qa) = (euler(w), turning(q, w));
            let (wb, qb0) = (w + a * (0.5 * h), q + qa * (0.5 * h));
            let (b, qb) = (euler(wb), turning(qb0, wb));
            let (wc, qc0) = (w + b * (0.5 * h), q + qb * (0.5 * h));
            let (c, qc) = (euler(wc), turning(qc0, wc));
            let (wd, qd0) = (w + c * h, q + qc * h);
            let (d, qd) = (euler(wd), turning(qd0, wd));
            w += (a + 2.0 * b + 2.0 * c + d) * (h / 6.0);
            q = (q + (qa + qb * 2.0 + qc * 2.0 + qd) * (h / 6.0)).normalize();
        }
        let error = |steps: u32| {
            let flown = (0..steps).fold(start, |s, _| s.free_flight(time / f64::from(steps), DVec3::ZERO));
            assert!((flown.kinetic_energy() / start.kinetic_energy() - 1.0).abs() < 1e-12);
            flown.principal_rotation().angle_between(q)
        };
        let (coarse, fine) = (error(200), error(400));
        assert!(coarse < 0.05 && (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn a_spin_about_a_principal_axis_or_of_a_ball_is_exact() {
        let about = brick(DVec3::new(0.0, 0.0, 7.0)).free_flight(2.0, DVec3::ZERO);
        let wanted = DQuat::from_scaled_axis(about.spin() * 2.0) * DQuat::from_rotation_z(0.7);
        assert!(about.rotation().angle_between(wanted) < 1e-7);
        let spread = MassProperties { principal: DVec3::splat(0.4), ..brick(DVec3::ZERO).mass_properties };
        let ball = BodyState::new(spread, DVec3::ZERO, DQuat::IDENTITY, DVec3::ZERO, DVec3::new(100.0, 50.0, 20.0));
        let after = ball.free_flight(0.1, DVec3::ZERO);
        assert_eq!(after.spin(), ball.spin());
        assert!((after.rotation() - DQuat::from_scaled_axis(DVec3::new(10.0, 5.0, 2.0))).length() < 1e-14);
    }

    #[test]
    fn a_needle_keeps_its_energy_at_any_spin() {
        // A blade with a length of 100 thicknesses: no principal inertia exceeds the sum of the
        // others.
        let spread =
            MassProperties { principal: DVec3::new(1.0, 2e-4, 1.00015) * 1e-5, ..brick(DVec3::ZERO).mass_properties };
        let spin = DVec3::new(300.0, 2000.0, -100.0);
        let start = BodyState::new(spread, DVec3::ZERO, DQuat::IDENTITY, DVec3::ZERO, spin);
        let mut state = start;
        for _ in 0..100 {
            state = state.free_flight(1.0 / 60.0, DVec3::ZERO);
        }
        let gain = state.kinetic_energy() / start.kinetic_energy() - 1.0;
        assert!(gain.abs() < 1e-9, "{gain:e}");
    }

    #[test]
    fn impulses_change_momentum_by_themselves_and_velocity_by_the_mobility() {
        let start = brick(DVec3::new(3.0, 2.0, 1.0));
        let (impulse, at, p) = (DVec3::new(0.1, -0.3, 0.2), DVec3::new(1.2, 0.7, 0.9), DVec3::new(0.5, 1.5, 1.1));
        let after = start.with_impulse_at(impulse, at);
        assert!((after.momentum() - start.momentum()).distance(impulse) < 1e-15);
        let twist = after.angular_momentum(DVec3::ZERO) - start.angular_momentum(DVec3::ZERO);
        assert!(twist.distance(at.cross(impulse)) < 1e-14);
        let jump = after.velocity_at(p) - start.velocity_at(p);
        assert!(jump.distance(start.mobility(p, at) * impulse) < 1e-10 * jump.length());
        let work = impulse.dot(0.5 * (start.velocity_at(at) + after.velocity_at(at)));
        assert!((after.kinetic_energy() - start.kinetic_energy() - work).abs() < 1e-12);
    }

    #[test]
    fn a_kinematic_body_reaches_its_target_and_ignores_impulses() {
        let from = BodyState::fixed_at(DVec3::X, DQuat::from_rotation_y(3.0));
        let (to, rotation) = (DVec3::new(0.3, 0.2, 0.1), DQuat::from_rotation_y(3.2) * DQuat::from_rotation_x(0.1));
        let (start, end) = from.kinematic(to, rotation, 0.02);
        let flown = start.free_flight(0.02, DVec3::NEG_Y);
        assert_eq!((end.origin(), end.rotation()), (to, rotation.normalize()));
        assert!(flown.origin().distance(to) < 1e-15 && (flown.rotation().dot(rotation).abs() - 1.0).abs() < 1e-15);
        assert_eq!(start.with_impulse_at(DVec3::ONE, DVec3::ZERO), start);
        assert_eq!((start.inverse_mass(), start.inverse_inertia()), (0.0, DMat3::ZERO));
        assert_eq!((start.momentum(), start.kinetic_energy()), (DVec3::ZERO, 0.0));
        assert_eq!(start.displaced(DVec3::Z, DVec3::Z).spin(), start.spin());
        assert_eq!(start.mobility(DVec3::ZERO, DVec3::ONE), DMat3::ZERO);
    }
}
