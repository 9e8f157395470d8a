//! Where a sheet was at the end of every stage of a step, for one who judges how it came to where it is: a step may be parted, and what
//! goes around something in it is seen nowhere else. Times in s after the start of the step, places in m.

use crate::math::Vectors;
use crate::sheet::Sheet;

/// The stages of the last step by an implicit engine, without those that were taken back.
#[derive(Default)]
pub(crate) struct Trace {
    pub ends: Vec<(f64, Vectors)>,
    kept: usize,
}

impl Trace {
    /// Begins with a step.
    pub fn begin(&mut self) {
        self.ends.clear();
        self.kept = 0;
    }

    /// Takes note of what is to be come back to.
    pub fn keep(&mut self) {
        self.kept = self.ends.len();
    }

    /// Forgets what has been taken back.
    pub fn put_back(&mut self) {
        self.ends.truncate(self.kept);
    }
}

impl Sheet {
    /// Records the positions of the nodes at the end of every stage of a step from now on, for rigs that judge paths.
    #[doc(hidden)]
    pub fn record_stages(&mut self) {
        self.work.trace = Some(Box::default());
    }

    /// Times after the start of the last step (s) and positions (m) at the end of each of its stages, where they are recorded.
    #[doc(hidden)]
    pub fn recorded_stages(&self) -> Option<&[(f64, Vectors)]> {
        self.work.trace.as_ref().map(|trace| &trace.ends[..])
    }

    /// Does something with the trace of a sheet that has one.
    pub(crate) fn trace(&mut self, with: impl FnOnce(&mut Trace, &Vectors)) {
        if let Some(trace) = &mut self.work.trace {
            with(trace, &self.x);
        }
    }
}
