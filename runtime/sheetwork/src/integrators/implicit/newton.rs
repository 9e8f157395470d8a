//! Solves a stage: mixed-stress Newton steps, guarded by the incremental potential.
//!
//! The stress in the geometric stiffness is not that of the iterate but the one the last linear solve predicted (see
//! [`crate::elements`]). In calm motion one solve is all it takes; on violent impacts alone it can diverge. So an iterate is
//! taken only if Φ has not risen by more than 2 % of its inertial term over the better of the two places the stage
//! could begin at, and if the strain it mispredicts carries little energy; otherwise further steps follow. Where they do not help,
//! a Newton method with a positive definite tangent and a line search goes down from the start (it cannot rise).

use crate::elements::Geometric;
use crate::integrators::implicit::{Implicit, Stage};
use crate::math::Vectors;

/// By how much Φ may rise, as a fraction of its inertial term.
const SLACK: f64 = 0.02;
/// Energy of mispredicted strain that is let pass, as a fraction of the inertial term.
const MISSED: f64 = 1e-4;
/// Mixed steps before the guard gives up on them.
const MIXED_STEPS: u32 = 9;
/// Steps of the guarded descent.
const DESCENT_STEPS: u32 = 15;
/// A sheet this slow (m/s) carries no energy worth a further solve.
pub const STILL: f64 = 1e-3;

/// What solving a stage took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Solved {
    /// Linear solves.
    pub solves: u32,
    /// Whether the guarded descent had to finish it.
    pub guarded: bool,
}

/// Arrays kept between stages.
#[derive(Default)]
pub struct Work {
    /// For whoever drives a scheme: where the solution is looked for, m.
    pub(crate) guess: Vectors,
    d: Vectors,
    start: Vectors,
    trial: Vectors,
}

/// Solves `stage` from the guess in `x`, which becomes the solution; `before` is where the sheet is.
pub fn solve(problem: &mut dyn Implicit, stage: &Stage, before: &Vectors, x: &mut Vectors, work: &mut Work) -> Solved {
    for buffer in [&mut work.d, &mut work.start, &mut work.trial] {
        crate::integrators::fit(buffer, x);
    }
    let Work { d, start, trial, .. } = work;
    // The better start: the guess, or where the sheet is (with held masses where they are led).
    start.copy_from(before);
    problem.led(x, start);
    let ahead = problem.potential(stage, x);
    let back = problem.potential(stage, start);
    if !ahead.is_finite() && !back.is_finite() {
        // What the sheet has is no number, and nothing the search could find would be true: the guess shows it.
        return Solved::default();
    }
    if back < ahead || !ahead.is_finite() {
        x.copy_from(start);
    } else {
        start.copy_from(x);
    }
    let reference = back.min(ahead);
    let scale = problem.inertial(stage, before).max(problem.kinetic_at(STILL));
    let mut solved = Solved::default();
    for step in 1..=MIXED_STEPS {
        let mut found = problem.direction(stage, x, Geometric::Mixed, d);
        if found.is_err() {
            found = problem.direction(stage, x, Geometric::Clipped, d);
        }
        if found.is_err() {
            break;
        }
        solved.solves += 1;
        let missed = problem.predict(x, d);
        x.add_scaled(1.0, d);
        let rise = problem.potential(stage, x) - reference;
        // A rise that is not a number fails this too.
        if rise <= SLACK * scale && (missed <= MISSED * scale || step >= MIXED_STEPS) {
            return solved;
        }
        let hopeless = rise.is_nan() || rise > 1e3 * scale;
        if hopeless && step >= 3 {
            break;
        }
    }
    x.copy_from(start);
    descend(problem, stage, x, reference, (d, trial), &mut solved);
    solved.guarded = true;
    solved
}

/// Newton with a positive definite tangent and a line search, from `x` with Φ = `value`.
fn descend(
    problem: &mut dyn Implicit,
    stage: &Stage,
    x: &mut Vectors,
    mut value: f64,
    (d, trial): (&mut Vectors, &mut Vectors),
    solved: &mut Solved,
) {
    let mut fallen = 0.0;
    for _ in 0..DESCENT_STEPS {
        problem.settle(x);
        let Ok(slope) = problem.direction(stage, x, Geometric::Clipped, d) else { break };
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
    problem.settle(x);
}
