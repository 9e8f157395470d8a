//! How time passes: by a fixed step with an accumulator.
//!
//! A frame of real time is turned into whole steps of the engine, and what is left over says where between the last two steps the picture is. A frame
//! never spends more than [`FRAME_BUDGET`] on stepping; time that could not be made up is dropped and counted, so that a slow scene
//! runs slowly instead of choking.

use std::time::{Duration, Instant};

use sheetwork::sheet::Status;

use super::Session;
use crate::playback::Playback;
use crate::samples::Sample;

/// Most wall-clock time a frame spends on stepping.
pub const FRAME_BUDGET: Duration = Duration::from_millis(30);

/// Longest real time that one frame makes up for, s: after a pause of the whole program the scene goes on, it does not leap.
const LONGEST_FRAME: f64 = 0.1;

/// Speeds that the slower and faster keys walk through: simulated seconds a real second.
pub const SPEEDS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// How many of the last samples the small graph shows, and in how many parts a run at once is watched.
pub const HISTORY: usize = 240;

/// Part of a step that is none: times are sums of steps.
pub(crate) const ROUNDING: f64 = 1e-6;

impl Session {
    /// Lets `real` s of wall-clock time pass. Does nothing while paused.
    pub fn frame(&mut self, real: f64) {
        self.timing.steps = 0;
        if !self.playing || !real.is_finite() || real <= 0.0 {
            return;
        }
        if let Some(recording) = &self.playback {
            self.playing = !recording.is_over();
            self.seek(recording.at() + real.min(LONGEST_FRAME) * self.speed);
            return;
        }
        if self.looped && self.world.time() >= self.scene().duration {
            self.begin_again();
        }
        let dt = self.world.dt();
        self.owed += real.min(LONGEST_FRAME) * self.speed;
        // The slack keeps a frame that is a whole number of steps, but for rounding, at that number.
        let due = (self.owed / dt + 1e-9).floor();
        if due >= 1.0 {
            self.go_another_way();
        }
        let start = Instant::now();
        let mut taken = 0.0;
        while taken < due {
            let last = taken + 1.0 >= due || start.elapsed() > FRAME_BUDGET;
            if last {
                // Only the last step of a frame is shown on its way.
                self.keep_before();
            }
            self.world.step();
            taken += 1.0;
            if last {
                break;
            }
        }
        self.owed = (self.owed - taken * dt).max(0.0);
        if taken < due {
            let lost = (due - taken) * dt;
            self.owed = (self.owed - lost).max(0.0);
            self.timing.lost_s += lost / self.speed;
        }
        if taken > 0.0 {
            self.after_steps(taken, start.elapsed());
        }
    }

    /// Takes one step and pauses; shows its result.
    pub fn step(&mut self) {
        self.playing = false;
        self.owed = 0.0;
        if let Some(recording) = &mut self.playback {
            recording.step(&mut self.world);
            self.settle_display();
            return;
        }
        self.go_another_way();
        let start = Instant::now();
        self.world.step();
        self.settle_display();
        self.timing.steps = 1;
        self.after_steps(1.0, start.elapsed());
    }

    /// Runs `duration` s of simulated time at once, whatever the speed; shows the result. For runs without a window: whole steps, as in a scene that
    /// plays, and a shorter one for what is left.
    pub fn run(&mut self, duration: f64) {
        if duration <= 0.0 || !duration.is_finite() {
            return;
        }
        if let Some(recording) = &self.playback {
            self.seek(recording.at() + duration);
            return;
        }
        self.go_another_way();
        let end = self.world.time() + duration;
        let dt = self.world.dt();
        let steps = (duration / dt + ROUNDING).floor() as u64;
        let at_once = steps.div_ceil(HISTORY as u64).max(1);
        let mut left = steps;
        while left > 0 {
            let start = Instant::now();
            let now = at_once.min(left);
            (0..now).for_each(|_| self.world.step());
            self.after_steps(now as f64, start.elapsed());
            left -= now;
        }
        let rest = end - self.world.time();
        if rest > ROUNDING * dt {
            let start = Instant::now();
            let steps = self.world.advance(rest);
            self.after_steps(steps as f64, start.elapsed());
        }
        self.settle_display();
    }

    /// Lets whole steps pass until `time` (s) is reached, and shows that moment: between the last two steps where it lies between them. For pictures of
    /// a run, and variants, whose steps are their own whatever they are in step with. A moment before the last step is not gone back to.
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
            self.go_another_way();
            self.keep_before();
            let start = Instant::now();
            self.world.step();
            self.after_steps(1.0, start.elapsed());
        }
        let late = self.world.time() - time;
        if late <= ROUNDING * dt {
            self.settle_display();
        } else {
            self.owed = (dt - late).max(0.0);
        }
    }

    fn after_steps(&mut self, steps: f64, elapsed: Duration) {
        let elapsed = elapsed.as_secs_f64();
        let each = elapsed / steps;
        self.timing.steps = steps as u32;
        self.timing.spent_s += elapsed;
        self.timing.step_s = if self.timing.step_s > 0.0 { 0.9 * self.timing.step_s + 0.1 * each } else { each };
        if let Some(clock) = &self.stages {
            let now = clock.take().map(|spent| spent / steps);
            let before = self.timing.stages.unwrap_or(now);
            self.timing.stages = Some(std::array::from_fn(|i| 0.9 * before[i] + 0.1 * now[i]));
        }
        self.world.watch_penetration(&mut self.penetration);
        self.samples.push(Sample { stages: self.timing.stages, ..Sample::of(&self.world, self.timing.step_s) });
        self.timeline.take(&self.world);
        self.lead();
        if let Some(sheet) = self.world.unstable().filter(|_| !self.told_unstable)
            && let Status::Unstable { time, speed, .. } = sheet.status
        {
            self.told_unstable = true;
            let text = format!(
                "{} went unstable at {time:.4} s (a mass at {speed:.2e} m/s) and was stopped. \
                 A shorter step, a softer sheet or another engine may hold; Reset starts again.",
                sheet.name
            );
            self.fail_of_run(text);
        }
    }

    /// Plays.
    pub fn play(&mut self) {
        if self.playback.as_ref().is_some_and(Playback::is_over) {
            self.seek(0.0);
        }
        if !self.playing && self.before_play.is_none() && self.playback.is_none() {
            self.before_play = Some(self.world.snapshot());
        }
        self.playing = true;
    }

    /// Pauses.
    pub fn pause(&mut self) {
        self.playing = false;
    }

    /// Plays if it was paused, and the other way round.
    pub fn toggle(&mut self) {
        if self.playing { self.pause() } else { self.play() }
    }

    /// Whether it plays.
    pub fn playing(&self) -> bool {
        self.playing
    }

    /// Whether it begins again after the scene's own duration.
    pub fn looped(&self) -> bool {
        self.looped
    }

    /// Makes it begin again after the scene's own duration, or not.
    pub fn set_looped(&mut self, looped: bool) {
        self.looped = looped;
    }

    /// Simulated seconds a real second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Sets the speed, simulated seconds a real second; what is not finite is ignored, the rest taken to 0.001 to 1000.
    pub fn set_speed(&mut self, speed: f64) {
        if speed.is_finite() {
            self.speed = speed.clamp(1e-3, 1e3);
        }
    }

    /// The next faster of [`SPEEDS`].
    pub fn faster(&mut self) {
        if let Some(speed) = SPEEDS.iter().find(|s| **s > self.speed * 1.001) {
            self.speed = *speed;
        }
    }

    /// The next slower of [`SPEEDS`].
    pub fn slower(&mut self) {
        if let Some(speed) = SPEEDS.iter().rev().find(|s| **s < self.speed * 0.999) {
            self.speed = *speed;
        }
    }
}
