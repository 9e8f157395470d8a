//! Explicit Euler (thesis equation 3.17): x ← x + v h, v ← v + a h, both evaluated at the start of
//! the step.
//!
//! Order 1. On x'' = -ω²x the energy grows by exactly (1 + a²) per step, a = hω.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Euler,
    name: "euler",
    about: "explicit Euler, order 1",
    order: 1,
    stability_limit: 0.0,
    evaluations: 1,
    drift: 0.0,
    adaptive: false,
    implicit: false,
    amplification: None,
    make: || Box::new(Euler::default()),
};

#[derive(Default)]
struct Euler {
    a: Vectors,
}

impl Integrator for Euler {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        forces.accelerations(t, x, v, &mut self.a);
        x.add_scaled(dt, v);
        v.add_scaled(dt, &self.a);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 1, globalised: 0 }
    }
}
