//! Session that plays a recording in place of a simulation.

use super::Session;
use crate::playback::Playback;

impl Session {
    /// The session with a recording of its scene to play.
    pub fn play_back(mut self, mut recording: Playback) -> Self {
        recording.seek(0.0, &mut self.world);
        self.playback = Some(recording);
        self.show_present();
        self
    }

    /// Recording that is played, if any.
    pub fn playback(&self) -> Option<&Playback> {
        self.playback.as_ref()
    }

    /// Go to `at` s from the start of the recording, if one is played.
    pub fn seek(&mut self, at: f64) {
        if let Some(recording) = &mut self.playback {
            recording.seek(at, &mut self.world);
            self.show_present();
        }
    }
}
