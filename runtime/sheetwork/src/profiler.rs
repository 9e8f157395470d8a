//! Phases of a step, for the measurement of their durations.
//!
//! The library has no clock: it notifies a [`StepObserver`] at the start and at the end of each
//! phase, and the observer may read one. Without an observer, the default, a notification is a test
//! of an empty option in about ten places of a step. An observer does not affect results.

use std::sync::Arc;

/// Phase of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Phase {
    /// Motion of sheets by internal forces: elements, integrator, linear solves, and all that
    /// belongs to no other phase.
    Motion,
    /// Broad phase over the world, and building of islands.
    Islands,
    /// Collision detection within islands. Explicit integrators resolve node contacts with static
    /// bodies in the same pass, which counts here.
    Detection,
    /// Contact solver.
    Contact,
    /// Heat.
    Heat,
    /// Motion of rigid bodies among themselves.
    Rigid,
}

impl Phase {
    /// All phases with their names.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Motion, "motion"),
        (Self::Detection, "detection"),
        (Self::Contact, "contact"),
        (Self::Heat, "heat"),
        (Self::Rigid, "bodies"),
        (Self::Islands, "islands"),
    ];
}

/// Observer of the phases of a step. Phases are nested, properly within each thread; sheets stepped
/// in parallel notify from several threads.
pub trait StepObserver: Send + Sync {
    /// Notification of the start of a phase.
    fn begin(&self, phase: Phase);

    /// Notification of the end of a phase.
    fn end(&self, phase: Phase);
}

/// An optional step observer.
#[derive(Clone, Default)]
pub(crate) struct Profiler(pub Option<Arc<dyn StepObserver>>);

impl Profiler {
    /// Run `work` as part of `phase`.
    pub fn measure<T>(&self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let Some(watch) = &self.0 else { return work() };
        watch.begin(phase);
        let done = work();
        watch.end(phase);
        done
    }
}
