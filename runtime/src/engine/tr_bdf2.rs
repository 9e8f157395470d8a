//! TR-BDF2: a trapezoidal stage over γ dt, then a BDF2 stage over the rest, γ = 2 - √2, so that both weigh the new
//! acceleration with h = γ dt/2 and their matrices are of one scale.
//!
//! Stage 1: x_γ = x₀ + h (v₀ + v_γ), v_γ = v₀ + h (a₀ + a_γ). Stage 2: x₁ = p x_γ + q x₀ + h v₁, v₁ = p v_γ + q v₀ + h a₁,
//! p = 1/(γ(2-γ)), q = -(1-γ)²/(γ(2-γ)). Order 2, L-stable, and among L-stable one-step schemes of order 2 one with little
//! damping: on x'' = -ω²x a slow motion loses about 0.0037 (ω dt)⁴ of its amplitude a step.
//! Bank, Coughran, Fichtner, Grosse, Rose, Smith, "Transient simulation of silicon devices and circuits", IEEE Trans. CAD 4,
//! 1985; Hosea and Shampine, "Analysis and implementation of TR-BDF2", Appl. Numer. Math. 20, 1996.
//!
//! It carries accelerations and rates of strain from step to step: those of the scheme, not ones computed afresh.

use super::implicit::newton::{Work, solve};
use super::implicit::{Complex, Implicit, Stage};
use super::{Advance, Engine, EngineInfo, EngineKind, Forces, fit};
use crate::element::Anchor;
use crate::sheet::Vectors;

pub(super) const INFO: EngineInfo = EngineInfo {
    kind: EngineKind::TrBdf2,
    name: "tr-bdf2",
    about: "implicit, trapezoidal and BDF2 stages, order 2, stable at any step",
    order: 2,
    stability_limit: f64::INFINITY,
    evaluations: 2,
    drift: 0.5,
    adaptive: false,
    implicit: true,
    amplification: Some(amplification),
    make: || Box::new(TrBdf2::default()),
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
    x_mid: Vectors,
    v_mid: Vectors,
    a_mid: Vectors,
    y: Vectors,
    w: Vectors,
    before: Vectors,
    work: Work,
}

impl TrBdf2 {
    /// The acceleration the first step begins with: that of the forces where the sheet carries no stress to speak of;
    /// otherwise that of an implicit step, which leaves out what the scheme could not follow.
    fn begin(&mut self, problem: &mut dyn Implicit, dt: f64, x: &Vectors, v: &Vectors) -> u32 {
        self.a = Vectors::zeros(x.len());
        problem.forget();
        let own = problem.accelerations(x, v, &mut self.a);
        problem.hold(&mut self.a);
        if own <= 1e-6 * self.a.max_squared().sqrt() {
            return 0;
        }
        let h = 0.5 * GAMMA * dt;
        self.y.set_sum(x, h, v);
        self.before.copy_from(x);
        self.x_mid.copy_from(&self.y);
        problem.begin(1.0 / h, &[Anchor { weight: 1.0, x }], 0.0, x, v);
        let stage = Stage { per_time: 1.0 / h, y: &self.y, w: x };
        let solved = solve(problem, &stage, &self.before, &mut self.x_mid, &mut self.work);
        problem.finish(&self.x_mid);
        acceleration(&self.x_mid, &self.y, h, &mut self.a);
        problem.hold(&mut self.a);
        solved.solves
    }
}

/// a = (x - y)/h².
pub(super) fn acceleration(x: &Vectors, y: &Vectors, h: f64, a: &mut Vectors) {
    for ((a, x), y) in a.axes_mut().into_iter().zip(x.axes()).zip(y.axes()) {
        for ((a, x), y) in a.iter_mut().zip(x).zip(y) {
            *a = (x - y) / (h * h);
        }
    }
}

/// v = (x - w)/h.
pub(super) fn velocity(x: &Vectors, w: &Vectors, h: f64, v: &mut Vectors) {
    for ((v, x), w) in v.axes_mut().into_iter().zip(x.axes()).zip(w.axes()) {
        for ((v, x), w) in v.iter_mut().zip(x).zip(w) {
            *v = (x - w) / h;
        }
    }
}

impl Engine for TrBdf2 {
    fn advance(&mut self, forces: &mut dyn Forces, _t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> Advance {
        let Some(problem) = forces.implicit() else { return Advance::default() };
        for buffer in [&mut self.x_mid, &mut self.v_mid, &mut self.a_mid, &mut self.y, &mut self.w, &mut self.before] {
            fit(buffer, x);
        }
        let mut done = Advance { taken: dt, accepted: 1, ..Advance::default() };
        if self.a.len() != x.len() {
            done.evaluations += u64::from(self.begin(problem, dt, x, v));
        }
        let h = 0.5 * GAMMA * dt;

        // Trapezoidal stage.
        self.w.set_sum(x, h, v);
        self.y.set_sum(x, 2.0 * h, v);
        self.x_mid.copy_from(&self.y);
        self.y.add_scaled(h * h, &self.a);
        // Guessed with the acceleration there was: a guess without it costs half a solve more a stage.
        self.x_mid.add_scaled(2.0 * h * h, &self.a);
        problem.begin(1.0 / h, &[Anchor { weight: 1.0, x }], h, x, v);
        let stage = Stage { per_time: 1.0 / h, y: &self.y, w: &self.w };
        let first = solve(problem, &stage, x, &mut self.x_mid, &mut self.work);
        problem.finish(&self.x_mid);
        acceleration(&self.x_mid, &self.y, h, &mut self.a_mid);
        problem.hold(&mut self.a_mid);
        self.v_mid.set_sum(v, h, &self.a);
        self.v_mid.add_scaled(h, &self.a_mid);

        // BDF2 stage.
        let p = 1.0 / (GAMMA * (2.0 - GAMMA));
        let q = 1.0 - p;
        self.before.copy_from(x);
        x.set_sum(&self.x_mid, (1.0 - GAMMA) * dt, &self.v_mid);
        x.add_scaled(0.5 * ((1.0 - GAMMA) * dt).powi(2), &self.a_mid);
        self.w.blend(p, &self.x_mid, q, &self.before);
        v.scale_and_add(q, p, &self.v_mid);
        self.y.set_sum(&self.w, h, v);
        let anchors = [Anchor { weight: p, x: &self.x_mid }, Anchor { weight: q, x: &self.before }];
        problem.begin(1.0 / h, &anchors, 0.0, &self.x_mid, &self.v_mid);
        let stage = Stage { per_time: 1.0 / h, y: &self.y, w: &self.w };
        let second = solve(problem, &stage, &self.x_mid, x, &mut self.work);
        problem.finish(x);
        acceleration(x, &self.y, h, &mut self.a);
        problem.hold(&mut self.a);
        v.add_scaled(h, &self.a);

        done.evaluations += u64::from(first.solves + second.solves);
        done.guarded = u64::from(first.guarded) + u64::from(second.guarded);
        done
    }

    fn restart(&mut self) {
        self.a = Vectors::default();
    }
}
