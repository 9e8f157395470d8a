//! Which part of a step is under way, for who wants to know how long each takes.
//!
//! The core has no clock: it tells a [`Watch`] where it begins and ends something, and the watch may look at one. Without a watch, which is
//! how every world begins, that is a look at an empty option in some ten places of a step. What a watch does is no part of the result.

use std::sync::Arc;

/// A part of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// Sheets move as their own forces have it: elements, engine, linear solves; and all that is none of the others.
    Motion,
    /// What may touch is looked for. Masses of explicit engines answer what stands in the same sweep, which counts here.
    Detection,
    /// Contact is solved for.
    Contact,
    /// Heat flows.
    Heat,
    /// Bodies move among themselves.
    Rigid,
}

impl Phase {
    /// All of them with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Motion, "motion"),
        (Self::Detection, "detection"),
        (Self::Contact, "contact"),
        (Self::Heat, "heat"),
        (Self::Rigid, "bodies"),
    ];
}

/// Is told when a part of a step begins and ends. Parts lie within one another; on a thread the last one that began ends first. Sheets that
/// are stepped side by side tell it from several threads.
pub trait Watch: Send + Sync {
    /// A part begins.
    fn begin(&self, phase: Phase);

    /// It ends.
    fn end(&self, phase: Phase);
}

/// A watch, where there is one.
#[derive(Clone, Default)]
pub(crate) struct Watched(pub Option<Arc<dyn Watch>>);

impl Watched {
    /// Does `work`, which is `phase`.
    pub fn within<T>(&self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let Some(watch) = &self.0 else { return work() };
        watch.begin(phase);
        let done = work();
        watch.end(phase);
        done
    }
}
