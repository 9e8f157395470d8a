//! Advance of time: fixed time steps with an accumulator.
//!
//! The real time of a frame is divided into whole time steps; the remainder interpolates the
//! display between the last two states. Stepping takes at most [`FRAME_BUDGET`] per frame. Time
//! beyond that is dropped and counted, so that a slow scene runs in slow motion.

use std::time::{Duration, Instant};

use sheetwork::sheet::Status;

use super::Session;
use crate::playback::Playback;
use crate::samples::Sample;

/// Maximum wall-clock time of stepping per frame.
pub const FRAME_BUDGET: Duration = Duration::from_millis(30);

/// Longest real time of one frame, s: after a suspension of the program the scene continues without
/// a jump.
const MAX_FRAME: f64 = 0.1;

/// Speeds of the slower and faster keys, simulated seconds per real second.
pub const SPEEDS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// Number of samples in the small graph, and of intervals in which a run at once is sampled.
pub const HISTORY: usize = 240;

/// Relative tolerance, in steps, for times that are sums of steps.
pub(crate) const ROUNDING: f64 = 1e-6;

impl Session {
    /// Advance by `real` s of wall-clock time. Does nothing while paused.
    pub fn frame(&mut self, real: f64) {
        self.run_state.timing.steps = 0;
        if !self.playing || !real.is_finite() || real <= 0.0 {
            return;
        }
        if let Some(recording) = &self.playback {
            self.playing = !recording.is_over();
            self.seek(recording.at() + real.min(MAX_FRAME) * self.speed);
            return;
        }
        if self.looped && self.world.time() >= self.scene().duration {
            self.restart_run();
        }
        let dt = self.world.dt();
        self.run_state.unstepped += real.min(MAX_FRAME) * self.speed;
        // The slack of 1e-9 steps absorbs the rounding of a frame of whole steps.
        let due = (self.run_state.unstepped / dt + 1e-9).floor();
        if due >= 1.0 {
            self.discard_future();
        }
        let start = Instant::now();
        let mut taken = 0.0;
        while taken < due {
            let last = taken + 1.0 >= due || start.elapsed() > FRAME_BUDGET;
            if last {
                // Only the last step of a frame is interpolated.
                self.store_previous();
            }
            self.world.step();
            taken += 1.0;
            if last {
                break;
            }
        }
        self.run_state.unstepped = (self.run_state.unstepped - taken * dt).max(0.0);
        if taken < due {
            let lost = (due - taken) * dt;
            self.run_state.unstepped = (self.run_state.unstepped - lost).max(0.0);
            self.run_state.timing.lost_s += lost / self.speed;
        }
        if taken > 0.0 {
            self.after_steps(taken, start.elapsed());
        }
    }

    /// Take one step, pause, and show the result.
    pub fn step(&mut self) {
        self.playing = false;
        self.run_state.unstepped = 0.0;
        if let Some(recording) = &mut self.playback {
            recording.step(&mut self.world);
            self.show_present();
            return;
        }
        self.discard_future();
        let start = Instant::now();
        self.world.step();
        self.show_present();
        self.run_state.timing.steps = 1;
        self.after_steps(1.0, start.elapsed());
    }

    /// Run `duration` s of simulated time at once, at any speed, and show the result. For runs
    /// without a window: whole steps, as during playback, and a shorter last step.
    pub fn run(&mut self, duration: f64) {
        if duration <= 0.0 || !duration.is_finite() {
            return;
        }
        if let Some(recording) = &self.playback {
            self.seek(recording.at() + duration);
            return;
        }
        self.discard_future();
        let end = self.world.time() + duration;
        let dt = self.world.dt();
        let steps = (duration / dt + ROUNDING).floor() as u64;
        let at_once = steps.div_ceil(HISTORY as u64).max(1);
        let mut left = steps;
        while left > 0 {
            let start = Instant::now();
            let now = at_once.min(left);
            (0..now).for_each(|_| _ = self.world.step());
            self.after_steps(now as f64, start.elapsed());
            left -= now;
        }
        let rest = end - self.world.time();
        if rest > ROUNDING * dt {
            let start = Instant::now();
            let steps = self.world.advance(rest);
            self.after_steps(steps as f64, start.elapsed());
        }
        self.show_present();
    }

    /// Take whole steps until `time` (s) is reached, and show that moment, interpolated between the
    /// last two states. For pictures of a run and for variants with a step of their own. Does not
    /// go back in time.
    pub fn run_to(&mut self, time: f64) {
        if !time.is_finite() {
            return;
        }
        if let Some(recording) = &self.playback {
            self.seek(recording.at() + time - self.world.time());
            return;
        }
        let dt = self.world.dt();
        let steps = ((time - self.world.time()) / dt - ROUNDING).ceil().max(0.0);
        if steps > 1.0 {
            self.run((steps - 1.0) * dt);
        }
        if steps > 0.0 {
            self.discard_future();
            self.store_previous();
            let start = Instant::now();
            self.world.step();
            self.after_steps(1.0, start.elapsed());
        }
        let late = self.world.time() - time;
        if late <= ROUNDING * dt {
            self.show_present();
        } else {
            self.run_state.unstepped = (dt - late).max(0.0);
        }
    }

    fn after_steps(&mut self, steps: f64, elapsed: Duration) {
        let elapsed = elapsed.as_secs_f64();
        let each = elapsed / steps;
        self.run_state.timing.steps = steps as u32;
        self.run_state.timing.spent_s += elapsed;
        self.run_state.timing.step_s =
            if self.run_state.timing.step_s > 0.0 { 0.9 * self.run_state.timing.step_s + 0.1 * each } else { each };
        if let Some(clock) = &self.stages {
            let now = clock.take().map(|spent| spent / steps);
            let before = self.run_state.timing.stages.unwrap_or(now);
            self.run_state.timing.stages = Some(std::array::from_fn(|i| 0.9 * before[i] + 0.1 * now[i]));
        }
        self.world.update_max_penetration(&mut self.run_state.penetration);
        self.run_state.samples.push(Sample {
            stages: self.run_state.timing.stages,
            ..Sample::from_world(&self.world, self.run_state.timing.step_s)
        });
        self.run_state.timeline.record(&self.world);
        self.advance_variants();
        if let Some(sheet) = self.world.unstable().filter(|_| !self.run_state.instability_reported)
            && let Status::Unstable { time, speed, .. } = sheet.state.status
        {
            self.run_state.instability_reported = true;
            let text = format!(
                "{} became unstable at {time:.4} s (a node at {speed:.2e} m/s) and was stopped. \
                 A shorter step, a softer sheet or another integrator may be stable; Reset restarts.",
                sheet.name
            );
            self.fail_of_run(text);
        }
    }

    /// Play.
    pub fn play(&mut self) {
        if self.playback.as_ref().is_some_and(Playback::is_over) {
            self.seek(0.0);
        }
        if !self.playing && self.run_state.before_play.is_none() && self.playback.is_none() {
            self.run_state.before_play = Some(self.world.snapshot());
        }
        self.playing = true;
    }

    /// Pause.
    pub fn pause(&mut self) {
        self.playing = false;
    }

    /// Toggle between playing and paused.
    pub fn toggle(&mut self) {
        if self.playing { self.pause() } else { self.play() }
    }

    /// Whether the session plays.
    pub fn playing(&self) -> bool {
        self.playing
    }

    /// Whether the run starts again after the scene's duration.
    pub fn looped(&self) -> bool {
        self.looped
    }

    /// Set whether the run starts again after the scene's duration.
    pub fn set_looped(&mut self, looped: bool) {
        self.looped = looped;
    }

    /// Simulated seconds per real second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Set the speed, simulated seconds per real second, clamped to 0.001 to 1000; a value that is
    /// not finite is ignored.
    pub fn set_speed(&mut self, speed: f64) {
        if speed.is_finite() {
            self.speed = speed.clamp(1e-3, 1e3);
        }
    }

    /// Change to the next higher of [`SPEEDS`].
    pub fn faster(&mut self) {
        if let Some(speed) = SPEEDS.iter().find(|s| **s > self.speed * 1.001) {
            self.speed = *speed;
        }
    }

    /// Change to the next lower of [`SPEEDS`].
    pub fn slower(&mut self) {
        if let Some(speed) = SPEEDS.iter().rev().find(|s| **s < self.speed * 0.999) {
            self.speed = *speed;
        }
    }
}
