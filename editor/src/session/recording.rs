//! A session that shows a recording in place of a simulation.

use super::Session;
use crate::playback::Playback;

impl Session {
    /// The session with a recording of its scene to show in place of a simulation.
    pub fn play_back(mut self, mut recording: Playback) -> Self {
        recording.seek(0.0, &mut self.world);
        self.playback = Some(recording);
        self.settle_display();
        self
    }

    /// The recording that is shown, where one is.
    pub fn playback(&self) -> Option<&Playback> {
        self.playback.as_ref()
    }

    /// Goes to `at` s from the start of the recording, where one is shown.
    pub fn seek(&mut self, at: f64) {
        if let Some(recording) = &mut self.playback {
            recording.seek(at, &mut self.world);
            self.settle_display();
        }
    }
}
