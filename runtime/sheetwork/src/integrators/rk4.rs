//! Classical Runge-Kutta method of order 4, the thesis's fourth-order integrator (equations 3.27 to
//! 3.30), with the forces of the whole sheet evaluated at each of the four stages.
//!
//! On x'' = -ω²x stable for a = hω up to 2√2; the energy decays by (1 - a⁶/72) per step.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Rk4,
    name: "rk4",
    about: "classical Runge-Kutta, order 4 (thesis, fourth order)",
    order: 4,
    stability_limit: 2.0 * std::f64::consts::SQRT_2,
    evaluations: 4,
    make: || Box::new(Rk4::default()),
    ..IntegratorInfo::EXPLICIT
};

/// Time of each later stage as a fraction of the step, and weight of every stage in the result.
const STAGE: [f64; 3] = [0.5, 0.5, 1.0];
const WEIGHT: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

#[derive(Default)]
struct Rk4 {
    /// Derivative of v at the current stage, m/s².
    a: Vectors,
    /// Derivative of x at the current stage: the stage's velocity, m/s.
    u: Vectors,
    x_stage: Vectors,
    x_sum: Vectors,
    v_sum: Vectors,
}

impl Integrator for Rk4 {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        for buffer in [&mut self.a, &mut self.u, &mut self.x_stage, &mut self.x_sum, &mut self.v_sum] {
            resize_like(buffer, x);
        }
        self.u.copy_from(v);
        forces.accelerations(t, x, v, &mut self.a);
        self.x_sum.set_sum(x, dt * WEIGHT[0], &self.u);
        self.v_sum.set_sum(v, dt * WEIGHT[0], &self.a);
        for (stage, weight) in STAGE.into_iter().zip(&WEIGHT[1..]) {
            self.x_stage.set_sum(x, stage * dt, &self.u);
            self.u.set_sum(v, stage * dt, &self.a);
            forces.accelerations(t + stage * dt, &self.x_stage, &self.u, &mut self.a);
            self.x_sum.add_scaled(dt * weight, &self.u);
            self.v_sum.add_scaled(dt * weight, &self.a);
        }
        x.copy_from(&self.x_sum);
        v.copy_from(&self.v_sum);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 4, globalised: 0 }
    }
}
