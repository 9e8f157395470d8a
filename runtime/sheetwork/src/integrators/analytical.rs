//! The thesis's "analytical" integrator: constant acceleration over the step.
//!
//! x ← x + v h + ½ a h², v ← v + a h. Order 1 (the velocity is Euler's). On x'' = -ω²x the energy
//! grows by (1 + a²/2) per step, a = hω: exact for free fall, always unstable for an undamped
//! spring.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Analytical,
    name: "analytical",
    about: "constant acceleration over the step (thesis)",
    order: 1,
    stability_limit: 0.0,
    evaluations: 1,
    drift: 0.5,
    adaptive: false,
    implicit: false,
    amplification: None,
    make: || Box::new(Analytical::default()),
};

#[derive(Default)]
struct Analytical {
    a: Vectors,
}

impl Integrator for Analytical {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        forces.accelerations(t, x, v, &mut self.a);
        x.add_scaled(dt, v);
        x.add_scaled(0.5 * dt * dt, &self.a);
        v.add_scaled(dt, &self.a);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 1, globalised: 0 }
    }
}
