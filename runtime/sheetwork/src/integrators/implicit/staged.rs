//! Implicit schemes one stage at a time, so that what is in contact can go through each stage together.
//!
//! A stage takes a sheet from (x, v) over the time [`Staged::length`]. The scheme says what the stage problem is
//! ([`Staged::prepare`]); whoever drives it solves that, with contact or without, and hands the solution back
//! ([`Staged::finish`]), with what contact did to it as a [`Jump`].
//!
//! Contact acts as if in an instant at the end of the stage: positions by the displacement Δ_c x, velocities by the jump
//! Δ_c v, which is another matter (a sheet that lands is put on the surface by the one, and rebounds by the other).
//! Velocities are those of the free motion plus the jump; accelerations leave the contact force out; and schemes that
//! look back further than the stage see a history moved as if the sheet had always had the velocity after the jump, because
//! extrapolating across it would bring part of it back.

use crate::integrators::implicit::newton::{Work, solve};
use crate::integrators::implicit::{Implicit, Stage};
use crate::integrators::{Advance, Forces};
use crate::math::Vectors;

/// What contact did to a sheet in a stage.
#[derive(Clone, Debug, Default)]
pub struct Jump {
    /// By how much it moved the masses, m.
    pub dx: Vectors,
    /// By how much it changed their velocities, m/s.
    pub dv: Vectors,
    /// The force that moved them, by mass, m/s².
    pub acceleration: Vectors,
}

/// An implicit scheme, stage by stage.
pub trait Staged {
    /// Stages in a step.
    fn stages(&self) -> usize;

    /// Begins a step of `dt` s from positions `x` (m) and velocities `v` (m/s); returns the linear solves that took.
    fn begin(&mut self, _problem: &mut dyn Implicit, _dt: f64, _x: &Vectors, _v: &Vectors) -> u32 {
        0
    }

    /// Begins stage `k` at `x`, `v`: tells `problem` what rates are measured from and writes a guess of the solution.
    fn prepare(&mut self, problem: &mut dyn Implicit, k: usize, dt: f64, at: (&Vectors, &Vectors), guess: &mut Vectors);

    /// The problem of the stage that was prepared.
    fn stage(&self) -> Stage<'_>;

    /// Time that passes in stage `k` of a step of `dt`, s.
    fn length(&self, k: usize, dt: f64) -> f64;

    /// Ends stage `k`: makes `x` the `solution`, and `v` the velocity after it.
    fn finish(
        &mut self,
        problem: &mut dyn Implicit,
        k: usize,
        dt: f64,
        solution: &Vectors,
        jump: Option<&Jump>,
        state: (&mut Vectors, &mut Vectors),
    );

    /// Arrays to solve in.
    fn work(&mut self) -> &mut Work;
}

/// A whole step without contact: what implicit engines do when they are asked to advance.
pub(crate) fn advance(
    scheme: &mut dyn Staged,
    forces: &mut dyn Forces,
    dt: f64,
    x: &mut Vectors,
    v: &mut Vectors,
) -> Advance {
    let Some(problem) = forces.implicit() else { return Advance::default() };
    let mut done = Advance { taken: dt, accepted: 1, ..Advance::default() };
    done.evaluations += u64::from(scheme.begin(problem, dt, x, v));
    for k in 0..scheme.stages() {
        let mut work = std::mem::take(scheme.work());
        let mut guess = std::mem::take(&mut work.guess);
        crate::integrators::fit(&mut guess, x);
        scheme.prepare(problem, k, dt, (x, v), &mut guess);
        let solved = solve(problem, &scheme.stage(), x, &mut guess, &mut work);
        scheme.finish(problem, k, dt, &guess, None, (x, v));
        done.evaluations += u64::from(solved.solves);
        done.guarded += u64::from(solved.guarded);
        work.guess = guess;
        *scheme.work() = work;
    }
    done
}
