//! Where a sheet was at the end of every stage of a step, for one who judges how it came to where it is: a step may be parted, and what
//! goes around something in it is seen nowhere else. Times in s after the start of the step, places in m.

use super::{Sheet, Vectors};

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
    /// Does something with the trace of a sheet that has one.
    pub(crate) fn trace(&mut self, with: impl FnOnce(&mut Trace, &Vectors)) {
        if let Some(trace) = &mut self.work.trace {
            with(trace, &self.x);
        }
    }
}
