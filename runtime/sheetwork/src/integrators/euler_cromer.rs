//! Euler-Cromer, the thesis's first-order integrator (equations 3.18 and 3.19): v ← v + a h, then
//! x ← x + v h with the new v.
//!
//! Order 1, symplectic. On x'' = -ω²x it is stable for a = hω up to 2, and the energy oscillates by
//! about ±a/2.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::EulerCromer,
    name: "euler-cromer",
    about: "semi-implicit Euler, order 1, symplectic (thesis, first order)",
    order: 1,
    stability_limit: 2.0,
    evaluations: 1,
    drift: 1.0,
    adaptive: false,
    implicit: false,
    amplification: None,
    make: || Box::new(EulerCromer::default()),
};

#[derive(Default)]
struct EulerCromer {
    a: Vectors,
}

impl Integrator for EulerCromer {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        forces.accelerations(t, x, v, &mut self.a);
        v.add_scaled(dt, &self.a);
        x.add_scaled(dt, v);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 1, globalised: 0 }
    }
}
