//! TR-BDF2: a trapezoidal stage over γ dt, then a BDF2 stage over the rest, γ = 2 - √2, so that
//! both stages weight the new acceleration with h = γ dt/2 and their matrices have equal scale.
//!
//! Stage 1: x_γ = x₀ + h (v₀ + v_γ), v_γ = v₀ + h (a₀ + a_γ). Stage 2: x₁ = p x_γ + q x₀ + h v₁,
//! v₁ = p v_γ + q v₀ + h a₁, p = 1/(γ(2-γ)), q = -(1-γ)²/(γ(2-γ)). Order 2, L-stable, with little
//! damping among L-stable one-step integrators of order 2: on x'' = -ω²x a slow motion loses about
//! 0.0037 (ω dt)⁴ of its amplitude per step.
//!
//! Sources: Bank, Coughran, Fichtner, Grosse, Rose, Smith, "Transient simulation of silicon devices
//! and circuits", IEEE Trans. CAD 4, 1985; Hosea and Shampine, "Analysis and implementation of
//! TR-BDF2", Appl. Numer. Math. 20, 1996.
//!
//! Accelerations and strain rates persist from step to step: they are values of the integrator, not
//! recomputed from forces.

use glam::DVec3;

use crate::elements::Anchor;
use crate::integrators::implicit::newton::{NewtonWorkspace, solve};
use crate::integrators::implicit::staged::{ContactJump, StagedIntegrator};
use crate::integrators::implicit::{Complex, ImplicitProblem, StageProblem};
use crate::integrators::{Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;
use crate::serialize::{ReadResult, StateReader, StateWriter};

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::TrBdf2,
    name: "tr-bdf2",
    about: "implicit, trapezoidal and BDF2 stages, order 2, stable at any step",
    order: 2,
    evaluations: 2,
    amplification: Some(amplification),
    make: || Box::new(TrBdf2::default()),
    ..IntegratorInfo::IMPLICIT
};

const GAMMA: f64 = 2.0 - std::f64::consts::SQRT_2;

/// R(z) = (p (1 + γz/2)/(1 - γz/2) + q)/(1 - γz/2) at z = iθ.
fn amplification(angle: f64) -> (f64, f64) {
    let half = 0.5 * GAMMA * angle;
    let below = Complex(1.0, -half);
    let p = 1.0 / (GAMMA * (2.0 - GAMMA));
    Complex(1.0, half).over(below).scaled(p).plus(Complex(1.0 - p, 0.0)).over(below).polar()
}

#[derive(Default)]
struct TrBdf2 {
    /// Acceleration at the end of the last step, m/s²; empty before the first.
    a: Vectors,
    a_mid: Vectors,
    y: Vectors,
    w: Vectors,
    per_time: f64,
    /// Positions at the start of the step, m: reference of the strain rates.
    x_start: Vectors,
    /// Positions (m) and velocities (m/s) at the start of the step as the second stage uses them:
    /// moved by contact in the first.
    x_past: Vectors,
    v_past: Vectors,
    work: NewtonWorkspace,
}

impl TrBdf2 {
    fn second(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        dt: f64,
        (x, v): (&Vectors, &Vectors),
        guess: &mut Vectors,
    ) {
        let h = 0.5 * GAMMA * dt;
        let p = 1.0 / (GAMMA * (2.0 - GAMMA));
        let q = 1.0 - p;
        guess.set_sum(x, (1.0 - GAMMA) * dt, v);
        guess.add_scaled(0.5 * ((1.0 - GAMMA) * dt).powi(2), &self.a_mid);
        self.w.blend(p, x, q, &self.x_past);
        self.v_past.scale_and_add(q, p, v);
        self.y.set_sum(&self.w, h, &self.v_past);
        let anchors = [Anchor { weight: p, x }, Anchor { weight: q, x: &self.x_start }];
        problem.begin_stage(1.0 / h, &anchors, 0.0, x, v);
    }
}

impl StagedIntegrator for TrBdf2 {
    fn stages(&self) -> usize {
        2
    }

    /// Computes the acceleration before the first step: from the forces where the sheet is almost
    /// free of stress, else from an implicit step, which filters frequencies that the integrator
    /// does not resolve.
    fn begin(&mut self, problem: &mut dyn ImplicitProblem, dt: f64, x: &Vectors, v: &Vectors) -> u32 {
        let Self { a_mid, y, w, x_start, x_past, v_past, .. } = self;
        for buffer in [a_mid, y, w, x_start, x_past, v_past] {
            resize_like(buffer, x);
        }
        if self.a.len() == x.len() {
            return 0;
        }
        self.a = Vectors::zeros(x.len());
        problem.reset_rates();
        let own = problem.accelerations(x, v, &mut self.a);
        problem.zero_prescribed(&mut self.a);
        if own <= 1e-6 * self.a.max_squared().sqrt() {
            return 0;
        }
        let h = 0.5 * GAMMA * dt;
        self.y.set_sum(x, h, v);
        self.x_start.copy_from(x);
        let mut end = self.y.clone();
        problem.begin_stage(1.0 / h, &[Anchor { weight: 1.0, x }], 0.0, x, v);
        let stage = StageProblem { per_time: 1.0 / h, y: &self.y, w: x };
        let solved = solve(problem, &stage, &self.x_start, &mut end, &mut self.work);
        problem.finish_stage(&end);
        problem.undo_arms();
        self.a.set_rate(&end, &self.y, h * h);
        problem.zero_prescribed(&mut self.a);
        solved.solves
    }

    fn prepare(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        k: usize,
        dt: f64,
        at: (&Vectors, &Vectors),
        guess: &mut Vectors,
    ) {
        let h = 0.5 * GAMMA * dt;
        self.per_time = 1.0 / h;
        if k > 0 {
            return self.second(problem, dt, at, guess);
        }
        let (x, v) = at;
        self.x_start.copy_from(x);
        self.x_past.copy_from(x);
        self.v_past.copy_from(v);
        self.w.set_sum(x, h, v);
        self.y.set_sum(x, 2.0 * h, v);
        guess.copy_from(&self.y);
        self.y.add_scaled(h * h, &self.a);
        // The stored acceleration improves the guess: without it a stage needs half a linear solve
        // more.
        guess.add_scaled(2.0 * h * h, &self.a);
        problem.begin_stage(self.per_time, &[Anchor { weight: 1.0, x }], h, x, v);
    }

    fn stage(&self) -> StageProblem<'_> {
        StageProblem { per_time: self.per_time, y: &self.y, w: &self.w }
    }

    fn length(&self, k: usize, dt: f64) -> f64 {
        if k == 0 { GAMMA * dt } else { (1.0 - GAMMA) * dt }
    }

    fn finish(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        k: usize,
        dt: f64,
        solution: &Vectors,
        jump: Option<&ContactJump>,
        (x, v): (&mut Vectors, &mut Vectors),
    ) {
        let h = 0.5 * GAMMA * dt;
        problem.finish_stage(solution);
        let a = if k == 0 { &mut self.a_mid } else { &mut self.a };
        a.set_rate(solution, &self.y, h * h);
        problem.zero_prescribed(a);
        if k == 0 {
            // v + h a + h a_mid.
            v.add_scaled(h, &self.a);
            v.add_scaled(h, &self.a_mid);
        } else {
            v.set_sum(&self.v_past, h, &self.a);
        }
        x.copy_from(solution);
        let Some(jump) = jump else { return };
        // Removes the contact force from the stored acceleration, and replaces the velocity change
        // that the contact displacement implies by the velocity jump.
        v.add_scaled(-1.0 / h, &jump.dx);
        v.add_scaled(1.0, &jump.dv);
        let a = if k == 0 { &mut self.a_mid } else { &mut self.a };
        a.add_scaled(-1.0, &jump.acceleration);
        if k == 0 {
            self.x_past.add_scaled(1.0, &jump.dx);
            self.x_past.add_scaled(-GAMMA * dt, &jump.dv);
            self.v_past.add_scaled(1.0, &jump.dv);
        }
    }

    fn work(&mut self) -> &mut NewtonWorkspace {
        &mut self.work
    }
}

impl Integrator for TrBdf2 {
    fn staged(&mut self) -> Option<&mut dyn StagedIntegrator> {
        Some(self)
    }

    fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        self.a.axes_mut().into_iter().for_each(visit);
    }

    fn serialise(&self, to: &mut StateWriter) {
        to.vector_list(&self.a);
    }

    fn deserialise(&mut self, from: &mut StateReader, masses: usize) -> ReadResult {
        from.vector_list(&mut self.a, masses)
    }

    fn restart(&mut self) {
        self.a = Vectors::default();
    }

    fn add_acceleration(&mut self, node: usize, by: DVec3) {
        if node < self.a.len() {
            self.a.add(node, by);
        }
    }
}
