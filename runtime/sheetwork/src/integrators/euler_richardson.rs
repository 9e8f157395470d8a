//! Euler-Richardson (explicit midpoint rule), the thesis's second-order integrator (equations 3.20
//! to 3.25).
//!
//! With a₀ at the start: v_m = v + ½ a₀ h, x_m = x + ½ v h, a_m at (x_m, v_m); then v ← v + a_m h,
//! x ← x + v_m h. Order 2. On x'' = -ω²x the energy grows by (1 + a⁴/4) per step, a = hω: weakly
//! unstable without damping, stable up to about a = 2 ζ^(1/3) with damping ratio ζ.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::EulerRichardson,
    name: "euler-richardson",
    about: "explicit midpoint, order 2 (thesis, second order)",
    order: 2,
    evaluations: 2,
    make: || Box::new(EulerRichardson::default()),
    ..IntegratorInfo::EXPLICIT
};

#[derive(Default)]
struct EulerRichardson {
    a: Vectors,
    x_mid: Vectors,
    v_mid: Vectors,
}

impl Integrator for EulerRichardson {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        resize_like(&mut self.x_mid, x);
        resize_like(&mut self.v_mid, x);
        forces.accelerations(t, x, v, &mut self.a);
        self.x_mid.set_sum(x, 0.5 * dt, v);
        self.v_mid.set_sum(v, 0.5 * dt, &self.a);
        forces.accelerations(t + 0.5 * dt, &self.x_mid, &self.v_mid, &mut self.a);
        x.add_scaled(dt, &self.v_mid);
        v.add_scaled(dt, &self.a);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 2, globalised: 0 }
    }
}
