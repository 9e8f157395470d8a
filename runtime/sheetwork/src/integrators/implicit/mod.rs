//! What implicit schemes have in common: a stage to solve for, and who can solve it.
//!
//! Every scheme here is a sequence of stages. A stage looks for x with
//!
//! M (x - y)/h² + ∇E(x) + (viscous and air forces at v = (x - w)/h) = f,
//!
//! where y is where inertia alone would take the masses, h the scheme's weight of the new acceleration, f gravity and
//! applied forces. It is the stationary point of the incremental potential
//!
//! Φ(x) = ½ (x - y)ᵀ M (x - y)/h² + E(x) + viscous and air potentials - f·x.
//!
//! Accelerations are the scheme's own, (x - y)/h²: recomputing them from forces would bring back what the stage filtered.

pub mod newton;
pub mod staged;

use crate::elements::{Anchor, Geometric};
use crate::linear::NotPositive;
use crate::math::Vectors;

/// What a stage knows before it is solved.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// 1/h, 1/s; 0 for equilibrium, where inertia and rates play no part.
    pub per_time: f64,
    /// Where inertia alone would take the masses, m.
    pub y: &'a Vectors,
    /// What velocities are measured from, v = (x - w)/h, m.
    pub w: &'a Vectors,
}

/// A sheet as implicit schemes see it. Held masses keep the place that the positions they are given say.
pub trait Implicit {
    /// Begins a stage: what rates of strain are measured from (see [`crate::elements::Element::begin`]), and where (m) and how fast
    /// (m/s) the air is met.
    fn begin(&mut self, per_time: f64, anchors: &[Anchor], follow: f64, x: &Vectors, v: &Vectors);

    /// Ends a stage at `x`: keeps its rates of strain.
    fn finish(&mut self, x: &Vectors);

    /// Forgets rates of strain.
    fn forget(&mut self);

    /// Φ(x), J.
    fn potential(&mut self, stage: &Stage, x: &Vectors) -> f64;

    /// The first term of Φ, J.
    fn inertial(&self, stage: &Stage, x: &Vectors) -> f64;

    /// Kinetic energy (J) of the whole sheet at this speed, m/s.
    fn kinetic_at(&self, speed: f64) -> f64;

    /// Whether the sheet is glued to a body that moves freely.
    fn is_glued(&self) -> bool {
        false
    }

    /// What pressure does in moving the sheet from `from` to `to`, J.
    fn pressed(&self, _from: &Vectors, _to: &Vectors) -> f64 {
        0.0
    }

    /// Newton's step from `x`: writes -H⁻¹ g to `d` (m), returns g·d (J).
    ///
    /// # Errors
    /// When H has no Cholesky factor.
    fn direction(
        &mut self,
        stage: &Stage,
        x: &Vectors,
        geometric: Geometric,
        d: &mut Vectors,
    ) -> Result<f64, NotPositive>;

    /// Takes up the stress that moving from `x` by `d` predicts; returns the energy of what the prediction misses, J.
    fn predict(&mut self, x: &Vectors, d: &Vectors) -> f64;

    /// Takes up the stress at `x`.
    fn settle(&mut self, x: &Vectors);

    /// Sets to zero what belongs to held masses and held directions.
    fn hold(&self, a: &mut Vectors);

    /// Copies the places of held masses and held directions from `x` to `to`.
    fn led(&self, x: &Vectors, to: &mut Vectors);

    /// Accelerations (m/s²) of the forces at `x` and `v`, and the largest part of them that is the sheet's own.
    fn accelerations(&mut self, x: &Vectors, v: &Vectors, a: &mut Vectors) -> f64;
}

/// A complex number: engines' stability functions are rational functions of i ω dt.
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

    /// A root with a positive imaginary part or on the real axis.
    pub fn root(self) -> Self {
        let (modulus, angle) = self.polar();
        Self(modulus.sqrt() * (0.5 * angle).cos(), modulus.sqrt() * (0.5 * angle).sin())
    }

    /// Modulus and angle.
    pub fn polar(self) -> (f64, f64) {
        (self.0.hypot(self.1), self.1.atan2(self.0))
    }
}
