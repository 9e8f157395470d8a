//! Implicit integrators stage by stage, so that sheets and bodies in contact solve each stage
//! together.
//!
//! A stage takes a sheet from (x, v) over the time [`StagedIntegrator::length`]. The integrator
//! defines the stage problem ([`StagedIntegrator::prepare`]); the caller solves it, with or without
//! contact, and returns the solution ([`StagedIntegrator::finish`]) with the effect of contact as a
//! [`ContactJump`].
//!
//! Contact acts instantaneously at the end of the stage: the displacement Δ_c x on positions and
//! the jump Δ_c v on velocities are independent (on landing, the former puts the sheet on the
//! surface, and the latter is the rebound). Velocities are those of the free motion plus the jump;
//! accelerations exclude the contact force. Integrators with a longer history move it as if the
//! sheet had always had the velocity after the jump, because extrapolation across the jump would
//! restore part of it.

use crate::integrators::implicit::newton::{NewtonWorkspace, solve};
use crate::integrators::implicit::{ImplicitProblem, StageProblem};
use crate::integrators::{AdvanceReport, Forces};
use crate::math::Vectors;

/// Effect of contact on a sheet in a stage.
#[derive(Clone, Debug, Default)]
pub struct ContactJump {
    /// Displacement of the nodes, m.
    pub dx: Vectors,
    /// Change of their velocities, m/s.
    pub dv: Vectors,
    /// Contact force per node mass that causes the displacement, m/s².
    pub acceleration: Vectors,
}

/// An implicit integrator, stage by stage.
pub trait StagedIntegrator {
    /// Number of stages in a step.
    fn stages(&self) -> usize {
        1
    }

    /// Begins a step of `_dt` s from positions `_x` (m) and velocities `_v` (m/s); returns the
    /// number of linear solves.
    fn begin(&mut self, _problem: &mut dyn ImplicitProblem, _dt: f64, _x: &Vectors, _v: &Vectors) -> u32 {
        0
    }

    /// Prepares stage `k` at positions and velocities `at`: sets the reference of rates in
    /// `problem` and writes an initial guess of the solution (m).
    fn prepare(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        k: usize,
        dt: f64,
        at: (&Vectors, &Vectors),
        guess: &mut Vectors,
    );

    /// The problem of the prepared stage.
    fn stage(&self) -> StageProblem<'_>;

    /// Duration of stage `_k` of a step of `dt` s, s.
    fn length(&self, _k: usize, dt: f64) -> f64 {
        dt
    }

    /// Ends stage `k`: sets the positions to `solution` and the velocities to those after the
    /// stage.
    fn finish(
        &mut self,
        problem: &mut dyn ImplicitProblem,
        k: usize,
        dt: f64,
        solution: &Vectors,
        jump: Option<&ContactJump>,
        state: (&mut Vectors, &mut Vectors),
    );

    /// Working arrays for the solution.
    fn work(&mut self) -> &mut NewtonWorkspace;
}

/// A whole step without contact: implements [`crate::integrators::Integrator::advance`] for
/// implicit integrators.
pub(crate) fn advance(
    scheme: &mut dyn StagedIntegrator,
    forces: &mut dyn Forces,
    dt: f64,
    x: &mut Vectors,
    v: &mut Vectors,
) -> AdvanceReport {
    let Some(problem) = forces.implicit() else { return AdvanceReport::default() };
    let mut done = AdvanceReport { elapsed: dt, accepted: 1, ..AdvanceReport::default() };
    done.evaluations += u64::from(scheme.begin(problem, dt, x, v));
    for k in 0..scheme.stages() {
        let mut work = std::mem::take(scheme.work());
        let mut guess = std::mem::take(&mut work.guess);
        crate::integrators::resize_like(&mut guess, x);
        scheme.prepare(problem, k, dt, (x, v), &mut guess);
        let solved = solve(problem, &scheme.stage(), x, &mut guess, &mut work);
        scheme.finish(problem, k, dt, &guess, None, (x, v));
        done.evaluations += u64::from(solved.solves);
        done.globalised += u64::from(solved.globalised);
        work.guess = guess;
        *scheme.work() = work;
    }
    done
}
