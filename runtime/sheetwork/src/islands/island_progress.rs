//! Progress of an island through its steps: what an implicit step takes from the step before.

use crate::islands::step_report::StepReport;
use crate::serialize::state;

/// Report of the present step, and the memory of earlier steps of an island.
#[derive(Default)]
pub(crate) struct IslandProgress {
    /// Present step.
    pub report: StepReport,
    /// Previous step in which contact was possible.
    pub previous: StepReport,
    /// Consecutive steps with a fallback.
    pub consecutive_fallbacks: u32,
    /// Energy error (J) that exceeded the available kinetic energy and is carried to the next
    /// steps.
    pub energy_error: f64,
    /// Least bisection level of the present step, for its rotation.
    pub least_bisection: u32,
    /// Whether a substep was accepted that began with a sheet in something.
    pub starts_in_something: bool,
}

impl IslandProgress {
    /// Begin a step.
    pub fn begin_step(&mut self) {
        self.report = StepReport { islands: 1, ..StepReport::default() };
        self.starts_in_something = false;
    }

    /// Forget contact: none is possible in the present step.
    pub fn reset_contact(&mut self) {
        self.previous.fallbacks = 0;
        self.energy_error = 0.0;
    }

    /// Bisection level at which the step of `sheets` sheets starts. After an impact of several it
    /// is one less than the deepest level of the previous step.
    pub fn initial_bisection_level(&self, sheets: usize) -> u32 {
        let after_impact = if sheets > 1 { self.previous.deepest_bisection.saturating_sub(1) } else { 0 };
        after_impact.max(self.least_bisection)
    }

    /// Whether an episode of steps with fallbacks begins with this one.
    pub fn begins_fallbacks(&self) -> bool {
        self.report.fallbacks > 0 && self.previous.fallbacks == 0
    }

    /// Count a step with a fallback at its end. Returns whether `most` such steps have followed
    /// one another.
    pub fn count_fallback_step(&mut self, most: u32) -> bool {
        self.consecutive_fallbacks = if self.report.fallbacks > 0 { self.consecutive_fallbacks + 1 } else { 0 };
        let reached = self.consecutive_fallbacks >= most;
        if reached {
            self.consecutive_fallbacks = 0;
        }
        reached
    }
}

state!(IslandProgress { report, previous, consecutive_fallbacks, energy_error; without least_bisection, starts_in_something });
