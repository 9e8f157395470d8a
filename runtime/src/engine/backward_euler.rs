//! Backward Euler: one stage over dt, x₁ = x₀ + dt v₁, v₁ = v₀ + dt a₁. Order 1, L-stable, and strongly damped: kept for
//! comparison, because it is what most real-time solvers use.

use super::implicit::newton::{Work, solve};
use super::implicit::{Complex, Stage};
use super::{Advance, Engine, EngineInfo, EngineKind, Forces, fit};
use crate::element::Anchor;
use crate::sheet::Vectors;

pub(super) const INFO: EngineInfo = EngineInfo {
    kind: EngineKind::BackwardEuler,
    name: "backward-euler",
    about: "implicit Euler, order 1, stable at any step, strongly damped",
    order: 1,
    stability_limit: f64::INFINITY,
    evaluations: 1,
    drift: 1.0,
    adaptive: false,
    implicit: true,
    amplification: Some(amplification),
    make: || Box::new(BackwardEuler::default()),
};

/// R(z) = 1/(1 - z) at z = iθ.
fn amplification(angle: f64) -> (f64, f64) {
    Complex(1.0, 0.0).over(Complex(1.0, -angle)).polar()
}

#[derive(Default)]
struct BackwardEuler {
    y: Vectors,
    before: Vectors,
    work: Work,
}

impl Engine for BackwardEuler {
    fn advance(&mut self, forces: &mut dyn Forces, _t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> Advance {
        let Some(problem) = forces.implicit() else { return Advance::default() };
        fit(&mut self.y, x);
        fit(&mut self.before, x);
        self.before.copy_from(x);
        self.y.set_sum(&self.before, dt, v);
        x.copy_from(&self.y);
        problem.begin(1.0 / dt, &[Anchor { weight: 1.0, x: &self.before }], 0.0, &self.before, v);
        let stage = Stage { per_time: 1.0 / dt, y: &self.y, w: &self.before };
        let solved = solve(problem, &stage, &self.before, x, &mut self.work);
        super::tr_bdf2::velocity(x, &self.before, dt, v);
        Advance {
            taken: dt,
            accepted: 1,
            evaluations: u64::from(solved.solves),
            guarded: u64::from(solved.guarded),
            ..Advance::default()
        }
    }
}
