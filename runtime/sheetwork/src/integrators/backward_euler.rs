//! Backward Euler: one stage over dt, x₁ = x₀ + dt v₁, v₁ = v₀ + dt a₁.
//!
//! Order 1, L-stable, strongly damped. Available for comparison, because most real-time solvers use
//! it.

use crate::elements::Anchor;
use crate::integrators::implicit::newton::NewtonWorkspace;
use crate::integrators::implicit::staged::{ContactJump, StagedIntegrator};
use crate::integrators::implicit::{Complex, ImplicitProblem, StageProblem};
use crate::integrators::{Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::BackwardEuler,
    name: "backward-euler",
    about: "implicit Euler, order 1, stable at any step, strongly damped",
    order: 1,
    evaluations: 1,
    drift: 1.0,
    amplification: Some(amplification),
    make: || Box::new(BackwardEuler::default()),
    ..IntegratorInfo::IMPLICIT
};

/// R(z) = 1/(1 - z) at z = iθ.
fn amplification(angle: f64) -> (f64, f64) {
    Complex(1.0, 0.0).over(Complex(1.0, -angle)).polar()
}

#[derive(Default)]
struct BackwardEuler {
    y: Vectors,
    w: Vectors,
    per_time: f64,
    work: NewtonWorkspace,
}

impl StagedIntegrator for BackwardEuler {
    fn prepare(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        _k: usize,
        dt: f64,
        (x, v): (&Vectors, &Vectors),
        guess: &mut Vectors,
    ) {
        resize_like(&mut self.y, x);
        resize_like(&mut self.w, x);
        self.per_time = 1.0 / dt;
        self.w.copy_from(x);
        self.y.set_sum(x, dt, v);
        guess.copy_from(&self.y);
        problem.begin_stage(self.per_time, &[Anchor { weight: 1.0, x }], 0.0, x, v);
    }

    fn stage(&self) -> StageProblem<'_> {
        StageProblem { per_time: self.per_time, y: &self.y, w: &self.w }
    }

    fn finish(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        _k: usize,
        dt: f64,
        solution: &Vectors,
        jump: Option<&ContactJump>,
        (x, v): (&mut Vectors, &mut Vectors),
    ) {
        problem.finish_stage(solution);
        v.set_rate(solution, &self.w, dt);
        x.copy_from(solution);
        if let Some(jump) = jump {
            v.add_scaled(-1.0 / dt, &jump.dx);
            v.add_scaled(1.0, &jump.dv);
        }
    }

    fn work(&mut self) -> &mut NewtonWorkspace {
        &mut self.work
    }
}

impl Integrator for BackwardEuler {
    fn staged(&mut self) -> Option<&mut dyn StagedIntegrator> {
        Some(self)
    }
}
