//! Common parts of the implicit integrators: the stage problem, and the interface to its solution.
//!
//! Every implicit integrator is a sequence of stages. A stage solves for x in
//!
//! M (x - y)/h² + ∇E(x) + (viscous and air forces at v = (x - w)/h) = f,
//!
//! where y is the position that inertia alone gives, h (s) the integrator's weight of the new
//! acceleration, and f (N) gravity and applied forces. The solution is the stationary point of the
//! incremental potential (J)
//!
//! Φ(x) = ½ (x - y)ᵀ M (x - y)/h² + E(x) + viscous and air potentials - f·x.
//!
//! Accelerations are (x - y)/h², values of the integrator: recomputing them from forces would
//! restore the high frequencies that the stage damps.

pub mod newton;
pub mod staged;
#[cfg(test)]
mod tests;

use crate::elements::{Anchor, Geometric};
use crate::linear::NotPositiveDefinite;
use crate::math::Vectors;

/// Known quantities of a stage.
#[derive(Clone, Copy)]
pub struct StageProblem<'a> {
    /// 1/h, 1/s; 0 for equilibrium, without inertia and damping.
    pub per_time: f64,
    /// Positions that inertia alone gives, m.
    pub y: &'a Vectors,
    /// Reference of the velocities, v = (x - w)/h, m.
    pub w: &'a Vectors,
}

/// A sheet as implicit integrators see it. Fixed and kinematic nodes keep the given positions.
pub trait ImplicitProblem {
    /// Begins a stage: sets the reference of the strain rates (see
    /// [`crate::elements::Element::begin_stage`]), and the positions (m) and velocities (m/s) at
    /// which air drag is evaluated.
    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64, x: &Vectors, v: &Vectors);

    /// Ends a stage at `x` (m) and stores its strain rates.
    fn finish_stage(&mut self, x: &Vectors);

    /// Undoes the effect of a trial stage on the arms of a flat loss factor.
    fn undo_arms(&mut self) {}

    /// Sets the stored strain rates to zero.
    fn reset_rates(&mut self);

    /// Φ(x), J.
    fn potential(&mut self, stage: &StageProblem, x: &Vectors) -> f64;

    /// Inertial term of Φ, J.
    fn inertial_potential(&self, stage: &StageProblem, x: &Vectors) -> f64;

    /// Kinetic energy (J) of the whole sheet at the uniform speed `speed`, m/s.
    fn kinetic_energy_at(&self, speed: f64) -> f64;

    /// Whether the sheet is attached to a dynamic body.
    fn has_dynamic_attachments(&self) -> bool {
        false
    }

    /// Work of pressure for a motion of the sheet from `_from` to `_to` (m), J.
    fn pressure_work(&self, _from: &Vectors, _to: &Vectors) -> f64 {
        0.0
    }

    /// Newton step from `x` (m): writes -H⁻¹ g to `d` (m) and returns g·d (J).
    ///
    /// # Errors
    /// If H has no Cholesky factor.
    fn newton_direction(
        &mut self,
        stage: &StageProblem,
        x: &Vectors,
        geometric: Geometric,
        d: &mut Vectors,
    ) -> Result<f64, NotPositiveDefinite>;

    /// Sets σ* to the stress that a displacement `d` from `x` (m) predicts; returns the energy of
    /// the prediction error, J.
    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64;

    /// Sets σ* to the stress at `x` (m).
    fn update_stress(&mut self, x: &Vectors);

    /// Sets the components of fixed and prescribed degrees of freedom to zero.
    fn zero_prescribed(&self, a: &mut Vectors);

    /// Copies the fixed and prescribed degrees of freedom from `x` to `to`.
    fn copy_prescribed(&self, x: &Vectors, to: &mut Vectors);

    /// Writes the accelerations (m/s²) of the forces at `x` (m) and `v` (m/s); returns the largest
    /// acceleration from internal forces.
    fn accelerations(&mut self, x: &Vectors, v: &Vectors, a: &mut Vectors) -> f64;
}

/// A complex number: stability functions are rational functions of i ω dt.
#[derive(Clone, Copy)]
pub(crate) struct Complex(pub f64, pub f64);

impl Complex {
    pub fn over(self, o: Self) -> Self {
        let size = o.0 * o.0 + o.1 * o.1;
        Self((self.0 * o.0 + self.1 * o.1) / size, (self.1 * o.0 - self.0 * o.1) / size)
    }

    pub fn plus(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }

    pub fn scaled(self, s: f64) -> Self {
        Self(self.0 * s, self.1 * s)
    }

    /// The square root with non-negative real part.
    pub fn root(self) -> Self {
        let (modulus, angle) = self.polar();
        Self(modulus.sqrt() * (0.5 * angle).cos(), modulus.sqrt() * (0.5 * angle).sin())
    }

    /// Modulus and angle (rad).
    pub fn polar(self) -> (f64, f64) {
        (self.0.hypot(self.1), self.1.atan2(self.0))
    }
}
