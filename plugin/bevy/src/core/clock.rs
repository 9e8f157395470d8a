//! The sheets' clock: pause, speed, single steps, and what happens when the computer cannot keep up.

use bevy::prelude::*;

use super::SheetWorld;

/// How the sheets' time follows Bevy's.
///
/// Each run of `FixedUpdate` is a tick; a tick advances the sheets by the period of `Time<Fixed>` times [`SheetClock::speed`].
#[derive(Resource, Reflect, Clone, Debug)]
#[reflect(Resource, Clone, Debug, Default)]
pub struct SheetClock {
    /// Whether the sheets stand still. Bodies moved meanwhile are put to their new places without pushing.
    pub paused: bool,
    /// Simulated seconds per second of Bevy's virtual time, 0 or more; 1 is real time.
    pub speed: f64,
    /// Most ticks in one frame; what is beyond is dropped and counted in [`SheetClock::time_lost`]. 1 or more.
    pub max_ticks_per_frame: u32,
    /// Whether the world's engine step is chosen: the period of `Time<Fixed>` with an implicit engine, as at the start; with
    /// an explicit one it is shortened when a [`Sheet`](super::Sheet) is spawned that it would be too long for. A step that
    /// was set with `set_dt`, or came with a scene, is not touched for implicit engines.
    pub auto_step: bool,
    single_steps: u32,
    due: f64,
    ticks: u32,
    time_lost: f64,
}

impl Default for SheetClock {
    fn default() -> Self {
        Self {
            paused: false,
            speed: 1.0,
            max_ticks_per_frame: 4,
            auto_step: true,
            single_steps: 0,
            due: 0.0,
            ticks: 0,
            time_lost: 0.0,
        }
    }
}

impl SheetClock {
    /// Asks for one engine step, [`World::dt`](sheetwork::World::dt) long, to be taken in the next tick even though paused.
    pub fn step_once(&mut self) {
        self.single_steps = self.single_steps.saturating_add(1);
    }

    /// How far the sheets go in this tick, s; 0 when they stand still.
    pub fn due(&self) -> f64 {
        self.due
    }

    /// Simulated seconds per second: the speed, or 0 while paused.
    pub(super) fn rate(&self) -> f64 {
        if self.paused || !self.speed.is_finite() { 0.0 } else { self.speed.max(0.0) }
    }

    /// Seconds that were not simulated because frames took too long, since the start.
    pub fn time_lost(&self) -> f64 {
        self.time_lost
    }
}

/// Starts counting the frame's ticks, and counts the time that Bevy itself dropped (`Time<Virtual>::max_delta`).
pub(super) fn begin_frame(mut clock: ResMut<SheetClock>, real: Res<Time<Real>>, virt: Res<Time<Virtual>>) {
    clock.ticks = 0;
    if !clock.paused && !virt.is_paused() {
        let wanted = real.delta_secs_f64() * virt.relative_speed_f64();
        let dropped = (wanted - virt.delta_secs_f64()).max(0.0);
        // Below a microsecond it is the rounding of the two clocks.
        if dropped > 1e-6 && real.delta() > virt.max_delta() {
            clock.time_lost += dropped;
        }
    }
}

/// Decides how far the sheets go in this tick.
pub(super) fn begin_tick(mut clock: ResMut<SheetClock>, mut world: ResMut<SheetWorld>, fixed: Res<Time<Fixed>>) {
    let period = fixed.timestep().as_secs_f64();
    if clock.auto_step && world.wants_step(period) {
        world.fit_step(period);
    }
    clock.ticks += 1;
    clock.due = 0.0;
    if clock.paused {
        clock.due = f64::from(clock.single_steps) * world.dt();
    } else if clock.ticks > clock.max_ticks_per_frame.max(1) {
        clock.time_lost += period;
    } else {
        clock.due = period * clock.rate();
    }
    clock.single_steps = 0;
}
