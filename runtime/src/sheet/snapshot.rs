//! What is kept of a sheet to go back to: positions, velocities, whether it sleeps.

use super::{Sheet, Status, Vectors};

/// A sheet at one time.
#[derive(Clone, Debug)]
pub(crate) struct SheetState {
    x: Vectors,
    v: Vectors,
    status: Status,
    quiet: f64,
}

impl Sheet {
    /// The sheet as it is now.
    pub(crate) fn state(&self) -> SheetState {
        SheetState { x: self.x.clone(), v: self.v.clone(), status: self.status, quiet: self.quiet }
    }

    /// Whether `state` is one of this sheet.
    pub(crate) fn takes(&self, state: &SheetState) -> bool {
        state.x.len() == self.masses()
    }

    /// Goes back to `state`, which it must take. Its engine begins anew from there, as after a change of engine.
    pub(crate) fn go_back(&mut self, state: &SheetState) {
        self.wake();
        self.x.copy_from(&state.x);
        self.v.copy_from(&state.v);
        self.status = state.status;
        self.quiet = state.quiet;
        self.work.touching.fill(false);
        self.work.stage.astray = false;
        self.engine.restart();
        self.field_before = None;
    }
}
