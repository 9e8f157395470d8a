//! Rollback: stop, step back, timeline, numbered snapshots.
//!
//! Moments after the present one stay on the timeline until time advances again. Parameters are not
//! rolled back: another value can be tried from an earlier moment.

use sheetwork::Snapshot;

use super::Session;
use crate::timeline::Timeline;

impl Session {
    /// Pause and return to the state before playing. Returns whether there was one.
    pub fn stop(&mut self) -> bool {
        self.playing = false;
        if self.playback.is_some() {
            self.seek(0.0);
            return true;
        }
        let Some(before) = self.run_state.before_play.take() else { return false };
        self.go_to(&before)
    }

    /// Whether there is a state before playing.
    pub fn can_stop(&self) -> bool {
        self.run_state.before_play.is_some() || (self.playback.is_some() && self.playing)
    }

    /// Go back by one time step and pause: the last earlier snapshot is restored and stepped.
    /// Returns whether there was one.
    pub fn step_back(&mut self) -> bool {
        self.playing = false;
        if let Some(recording) = &self.playback {
            self.seek(recording.at() - recording.duration() / recording.len().max(2) as f64);
            return true;
        }
        let Some(wanted) = self.world.steps().checked_sub(1) else { return false };
        let Some(moment) = self.run_state.timeline.at_steps(wanted) else { return false };
        let (from, snapshot) = (moment.steps, moment.snapshot.clone());
        if !self.go_to(&snapshot) {
            return false;
        }
        for _ in from..wanted {
            self.world.step();
        }
        self.run_state.timeline.follow_rollback(&self.world);
        self.show_present();
        self.advance_variants();
        true
    }

    /// Go to the moment of the timeline nearest to `time` (s) and pause. Returns whether there was
    /// one.
    pub fn scrub(&mut self, time: f64) -> bool {
        self.playing = false;
        if self.playback.is_some() {
            self.seek(time);
            return true;
        }
        let Some(moment) = self.run_state.timeline.nearest(time) else { return false };
        if moment.steps == self.world.steps() {
            return true;
        }
        let snapshot = moment.snapshot.clone();
        self.go_to(&snapshot)
    }

    /// Store a snapshot of the world under a number from 1 to 9.
    pub fn store_snapshot(&mut self, number: usize) {
        if self.playback.is_some() {
            self.fail("a recording needs no snapshots");
            return;
        }
        if let Some(slot) = number.checked_sub(1).and_then(|i| self.run_state.slots.get_mut(i)) {
            *slot = Some(self.world.snapshot());
        }
    }

    /// Restore the snapshot of a number. Returns whether there was one.
    pub fn restore_snapshot(&mut self, number: usize) -> bool {
        let slot = number.checked_sub(1).and_then(|i| self.run_state.slots.get(i));
        let Some(snapshot) = slot.cloned().flatten() else { return false };
        self.playing = false;
        // A snapshot that is not on the timeline starts a new one.
        self.go_to(&snapshot)
    }

    /// Times of the snapshots 1 to 9, s.
    pub fn snapshot_times(&self) -> [Option<f64>; 9] {
        std::array::from_fn(|i| self.run_state.slots[i].as_ref().map(Snapshot::time))
    }

    /// Timeline of the run.
    pub fn timeline(&self) -> &Timeline {
        &self.run_state.timeline
    }

    /// Restart from the first moment while playing.
    pub(super) fn restart_run(&mut self) {
        let first = self.run_state.timeline.at_steps(0).map(|m| m.snapshot.clone());
        match first {
            Some(snapshot) => _ = self.go_to(&snapshot),
            None => _ = self.reset(),
        }
    }

    pub(super) fn go_to(&mut self, snapshot: &Snapshot) -> bool {
        let restored = self.world.restore(snapshot);
        if self.accept(restored).is_none() {
            return false;
        }
        self.run_state.unstepped = 0.0;
        self.run_state.instability_reported = self.world.unstable().is_some();
        self.run_state.timeline.follow_rollback(&self.world);
        self.show_present();
        self.advance_variants();
        true
    }

    /// Before time advances: discard the moments after the present one.
    pub(super) fn discard_future(&mut self) {
        let later = |(_, last): (f64, f64)| last > self.world.time() + 1e-12;
        if self.run_state.timeline.span().is_some_and(later) {
            self.run_state.timeline.discard_after(&self.world);
            self.run_state.samples.discard_after(self.world.time());
        }
    }
}
