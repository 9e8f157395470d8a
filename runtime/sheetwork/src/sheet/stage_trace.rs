//! Positions of a sheet at the end of every stage of a step, for tests of its path, because a step
//! can consist of substeps. Times in s after the start of the step, positions in m.

use crate::math::Vectors;
use crate::sheet::Sheet;

/// Stages of the last implicit step, without rolled-back ones.
#[derive(Default)]
pub(crate) struct StageTrace {
    pub ends: Vec<(f64, Vectors)>,
    kept: usize,
}

impl StageTrace {
    /// Start the trace of a step.
    pub fn begin(&mut self) {
        self.ends.clear();
        self.kept = 0;
    }

    /// Mark the present stage for a rollback.
    pub fn mark_saved(&mut self) {
        self.kept = self.ends.len();
    }

    /// Remove the stages after the mark.
    pub fn truncate_to_saved(&mut self) {
        self.ends.truncate(self.kept);
    }
}

impl Sheet {
    /// Record the positions of the nodes at the end of every later stage, for rigs that test
    /// paths.
    #[doc(hidden)]
    pub fn record_stages(&mut self) {
        self.work.trace = Some(Box::default());
    }

    /// Times after the start of the last step (s) and positions (m) at the end of each of its
    /// stages; `None` without recording.
    #[doc(hidden)]
    pub fn recorded_stages(&self) -> Option<&[(f64, Vectors)]> {
        self.work.trace.as_ref().map(|trace| &trace.ends[..])
    }

    /// Call `with` on the trace of a sheet with recording.
    pub(crate) fn update_trace(&mut self, with: impl FnOnce(&mut StageTrace, &Vectors)) {
        if let Some(trace) = &mut self.work.trace {
            with(trace, &self.x);
        }
    }
}
