//! BDF2: x₁ = (4 x₀ - x₋₁)/3 + ⅔ dt v₁, and v₁ correspondingly from a₁; backward Euler for the
//! first step and after a change of the step length.
//!
//! Order 2, L-stable, more damped than TR-BDF2 at an equal step, but one stage. Available for
//! comparison.
//!
//! Contact within a step moves the history that the next step extrapolates. At rest in contact this
//! happens in every step and leaves a persistent force error, so a resting sheet in contact uses
//! backward Euler, which has no history. A sheet attached to a dynamic body does so too: the
//! attachment forces rotate with the body, but the extrapolated history does not.

use crate::elements::Anchor;
use crate::integrators::implicit::newton::NewtonWorkspace;
use crate::integrators::implicit::staged::{ContactJump, StagedIntegrator};
use crate::integrators::implicit::{Complex, ImplicitProblem, StageProblem};
use crate::integrators::settings::IntegratorSettings;
use crate::integrators::{Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;
use crate::serialize::{ReadResult, StateReader, StateWriter};

const SETTINGS: IntegratorSettings = IntegratorSettings::DEFAULT;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Bdf2,
    name: "bdf2",
    about: "implicit BDF2, order 2, stable at any step",
    order: 2,
    evaluations: 1,
    amplification: Some(amplification),
    make: || Box::new(Bdf2::default()),
    ..IntegratorInfo::IMPLICIT
};

/// The root ζ of (3/2 - z) ζ² - 2 ζ + 1/2 = 0 that approximates e^z, at z = iθ.
fn amplification(angle: f64) -> (f64, f64) {
    let a = Complex(1.5, -angle);
    // Discriminant 4 - 4 a/2.
    let root = Complex(4.0 - 2.0 * a.0, -2.0 * a.1).root();
    Complex(2.0, 0.0).plus(root).over(a.scaled(2.0)).polar()
}

#[derive(Default)]
struct Bdf2 {
    /// Positions (m) and velocities (m/s) of the previous step, moved by contact, and the length of
    /// that step, s; 0 without a previous step.
    x_old: Vectors,
    v_old: Vectors,
    step: f64,
    /// Actual positions of the previous step, m: reference of the strain rates.
    x_previous: Vectors,
    /// 1 for a sheet that rests in contact or is attached to a dynamic body, else 0.
    uses_backward_euler: f64,
    /// Weight h of the new acceleration, s.
    h: f64,
    y: Vectors,
    w: Vectors,
    work: NewtonWorkspace,
}

impl Bdf2 {
    /// Whether a step of `dt` s uses the previous step.
    fn has_history(&self, dt: f64) -> bool {
        (self.step - dt).abs() <= 1e-9 * dt && self.uses_backward_euler == 0.0
    }
}

impl StagedIntegrator for Bdf2 {
    fn prepare(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        _k: usize,
        dt: f64,
        (x, v): (&Vectors, &Vectors),
        guess: &mut Vectors,
    ) {
        for buffer in [&mut self.x_old, &mut self.v_old, &mut self.x_previous, &mut self.y, &mut self.w] {
            resize_like(buffer, x);
        }
        let (p, q, h) = if self.has_history(dt) { (4.0 / 3.0, -1.0 / 3.0, dt * 2.0 / 3.0) } else { (1.0, 0.0, dt) };
        self.h = h;
        self.w.blend(p, x, q, &self.x_old);
        // y = w + h (p v + q v_old).
        self.y.set_sum(&self.w, h * p, v);
        self.y.add_scaled(h * q, &self.v_old);
        guess.set_sum(x, dt, v);
        let anchors = [Anchor { weight: p, x }, Anchor { weight: q, x: &self.x_previous }];
        problem.begin_stage(1.0 / h, &anchors, 0.0, x, v);
    }

    fn stage(&self) -> StageProblem<'_> {
        StageProblem { per_time: 1.0 / self.h, y: &self.y, w: &self.w }
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
        self.x_old.copy_from(x);
        self.x_previous.copy_from(x);
        self.v_old.copy_from(v);
        self.step = dt;
        v.set_rate(solution, &self.w, self.h);
        x.copy_from(solution);
        if let Some(jump) = jump {
            v.add_scaled(-1.0 / self.h, &jump.dx);
            v.add_scaled(1.0, &jump.dv);
            self.x_old.add_scaled(1.0, &jump.dx);
            self.x_old.add_scaled(-dt, &jump.dv);
            self.v_old.add_scaled(1.0, &jump.dv);
        }
        let limit = if self.uses_backward_euler > 0.0 { SETTINGS.leaving_speed } else { SETTINGS.resting_speed };
        self.uses_backward_euler =
            f64::from(problem.has_dynamic_attachments() || jump.is_some() && v.max_squared() < limit * limit);
    }

    fn work(&mut self) -> &mut NewtonWorkspace {
        &mut self.work
    }
}

impl Integrator for Bdf2 {
    fn staged(&mut self) -> Option<&mut dyn StagedIntegrator> {
        Some(self)
    }

    fn drift(&self, dt: f64) -> Option<f64> {
        (!self.has_history(dt)).then_some(1.0)
    }

    fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        visit(std::slice::from_mut(&mut self.step));
        visit(std::slice::from_mut(&mut self.uses_backward_euler));
        let Self { x_old, v_old, x_previous: x_was, .. } = self;
        [x_old, v_old, x_was].into_iter().flat_map(Vectors::axes_mut).for_each(visit);
    }

    fn serialise(&self, to: &mut StateWriter) {
        to.number(self.step);
        to.number(self.uses_backward_euler);
        to.vector_list(&self.x_old);
        to.vector_list(&self.v_old);
        to.vector_list(&self.x_previous);
    }

    fn deserialise(&mut self, from: &mut StateReader, masses: usize) -> ReadResult {
        self.step = from.number()?;
        self.uses_backward_euler = from.number()?;
        from.vector_list(&mut self.x_old, masses)?;
        from.vector_list(&mut self.v_old, masses)?;
        from.vector_list(&mut self.x_previous, masses)
    }

    fn restart(&mut self) {
        self.step = 0.0;
    }
}
