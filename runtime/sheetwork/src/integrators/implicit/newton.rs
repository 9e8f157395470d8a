//! Solution of a stage: mixed-stress Newton method, globalised with the incremental potential Φ.
//!
//! The stress in the geometric stiffness is the one that the last linear solution predicted, not
//! that of the iterate (see [`crate::elements`]). For smooth motion one linear solve suffices;
//! after strong impacts the plain iteration can diverge. A step is accepted if Φ exceeds its value
//! at the better of two starting points by at most 2 % of the inertial term, and the strain energy
//! of the prediction error is small; otherwise more steps follow. If these fail, a globalised
//! Newton method (positive definite tangent and line search) starts again from the better starting
//! point; it never raises Φ.

use crate::elements::Geometric;
use crate::integrators::implicit::{ImplicitProblem, StageProblem};
use crate::integrators::settings::{IntegratorSettings, NewtonSettings};
use crate::math::Vectors;

const SETTINGS: NewtonSettings = IntegratorSettings::DEFAULT.newton;

/// Work of one stage solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NewtonReport {
    /// Linear solves.
    pub solves: u32,
    /// Whether the globalised method completed it.
    pub globalised: bool,
}

/// Arrays reused by all stages.
#[derive(Default)]
pub struct NewtonWorkspace {
    /// For the caller of an integrator's stages: initial guess, then solution, m.
    pub(crate) guess: Vectors,
    d: Vectors,
    start: Vectors,
    trial: Vectors,
}

/// Solves `stage` from the guess in `x` (m), which becomes the solution; `before` (m) are the
/// present positions.
pub fn solve(
    problem: &mut dyn ImplicitProblem,
    stage: &StageProblem,
    before: &Vectors,
    x: &mut Vectors,
    work: &mut NewtonWorkspace,
) -> NewtonReport {
    for buffer in [&mut work.d, &mut work.start, &mut work.trial] {
        crate::integrators::resize_like(buffer, x);
    }
    let NewtonWorkspace { d, start, trial, .. } = work;
    // The better starting point: the guess, or the present positions with prescribed degrees of
    // freedom.
    start.copy_from(before);
    problem.copy_prescribed(x, start);
    let ahead = problem.potential(stage, x);
    let back = problem.potential(stage, start);
    if !ahead.is_finite() && !back.is_finite() {
        // Non-finite state: no search can succeed. The guess keeps the non-finite values visible.
        return NewtonReport::default();
    }
    if back < ahead || !ahead.is_finite() {
        x.copy_from(start);
    } else {
        start.copy_from(x);
    }
    let reference = back.min(ahead);
    let scale = problem.inertial_potential(stage, before).max(problem.kinetic_energy_at(SETTINGS.reference_speed));
    let mut solved = NewtonReport::default();
    for step in 1..=SETTINGS.maximum_mixed_steps {
        let mut found = problem.newton_direction(stage, x, Geometric::Mixed, d);
        if found.is_err() {
            found = problem.newton_direction(stage, x, Geometric::Clipped, d);
        }
        if found.is_err() {
            break;
        }
        solved.solves += 1;
        let missed = problem.predict_stress(x, d);
        x.add_scaled(1.0, d);
        let rise = problem.potential(stage, x) - reference;
        // False for a NaN rise.
        if rise <= SETTINGS.potential_rise * scale
            && (missed <= SETTINGS.prediction_error * scale || step >= SETTINGS.maximum_mixed_steps)
        {
            return solved;
        }
        let hopeless = rise.is_nan() || rise > 1e3 * scale;
        if hopeless && step >= 3 {
            break;
        }
    }
    x.copy_from(start);
    descend_globally(problem, stage, x, reference, (d, trial), &mut solved);
    solved.globalised = true;
    solved
}

/// Newton method with positive definite tangent and line search, from `x` with Φ = `value` (J).
fn descend_globally(
    problem: &mut dyn ImplicitProblem,
    stage: &StageProblem,
    x: &mut Vectors,
    mut value: f64,
    (d, trial): (&mut Vectors, &mut Vectors),
    solved: &mut NewtonReport,
) {
    let mut fallen = 0.0;
    for _ in 0..SETTINGS.maximum_descent_steps {
        problem.update_stress(x);
        let Ok(slope) = problem.newton_direction(stage, x, Geometric::Clipped, d) else { break };
        solved.solves += 1;
        let mut length = 1.0;
        let mut found = None;
        while length > 1e-5 {
            trial.set_sum(x, length, d);
            let next = problem.potential(stage, trial);
            if next <= value + 1e-4 * length * slope {
                found = Some(next);
                break;
            }
            length *= 0.5;
        }
        let Some(next) = found else { break };
        x.copy_from(trial);
        let fall = value - next;
        fallen += fall;
        value = next;
        if fall <= 1e-3 * fallen {
            break;
        }
    }
    problem.update_stress(x);
}
