//! Clock of the simulation: pause, speed, single steps, and a limit of work per frame.

use bevy::prelude::*;

use super::SheetWorld;

/// Relation of simulated time to Bevy's time.
///
/// Each run of `FixedUpdate` is a tick. A tick advances the sheets by the period of `Time<Fixed>`
/// times [`SheetClock::speed`].
#[derive(Resource, Reflect, Clone, Debug)]
#[reflect(Resource, Clone, Debug, Default)]
pub struct SheetClock {
    /// Whether simulated time is paused. Bodies moved during a pause are placed without pushing.
    pub paused: bool,
    /// Simulated seconds per second of Bevy's virtual time, 0 or more; 1 is real time.
    pub speed: f64,
    /// Maximum number of ticks per frame, 1 or more. Further ticks are dropped and counted in
    /// [`SheetClock::time_lost`].
    pub max_ticks_per_frame: u32,
    /// Whether the plugin chooses the time step. With an implicit integrator the step is the period
    /// of `Time<Fixed>`. With an explicit integrator the step is reduced to the stability limit of
    /// each spawned [`Sheet`](super::Sheet). A step set by `set_dt` or by a scene is kept for
    /// implicit integrators.
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
    /// Request one time step of [`World::dt`](sheetwork::World::dt) in the next tick, even while
    /// paused.
    pub fn step_once(&mut self) {
        self.single_steps = self.single_steps.saturating_add(1);
    }

    /// Simulated duration of this tick, s; 0 while paused.
    pub fn due(&self) -> f64 {
        self.due
    }

    /// Simulated seconds per second: the speed, or 0 while paused.
    pub(super) fn rate(&self) -> f64 {
        if self.paused || !self.speed.is_finite() { 0.0 } else { self.speed.max(0.0) }
    }

    /// Seconds since the start that were not simulated because frames took too long.
    pub fn time_lost(&self) -> f64 {
        self.time_lost
    }
}

/// Reset the tick count of the frame, and add the time that Bevy dropped
/// (`Time<Virtual>::max_delta`).
pub(super) fn begin_frame(mut clock: ResMut<SheetClock>, real: Res<Time<Real>>, virt: Res<Time<Virtual>>) {
    clock.ticks = 0;
    if !clock.paused && !virt.is_paused() {
        let wanted = real.delta_secs_f64() * virt.relative_speed_f64();
        let dropped = (wanted - virt.delta_secs_f64()).max(0.0);
        // A difference below a microsecond is rounding of the two clocks.
        if dropped > 1e-6 && real.delta() > virt.max_delta() {
            clock.time_lost += dropped;
        }
    }
}

/// Compute the simulated duration of this tick.
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
