//! Sleep thresholds of sheets and bodies.

/// Thresholds below which a sheet or a body counts as resting, and the delay until it sleeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SleepSettings {
    /// Speed threshold, m/s: the displacement of a node in a step over the step, and the same of
    /// the farthest point of a body. Well above the residual velocity of resting contact.
    pub speed: f64,
    /// Sleep delay, s: duration of rest until sleep.
    pub delay: f64,
    /// Displacement threshold, m. Over-constrained contacts can make nodes oscillate between two
    /// positions; below this amplitude the sheet counts as resting at any speed.
    pub displacement: f64,
    /// Displacement threshold of a sheet smaller than 5 cm, as a fraction of its diagonal.
    pub displacement_of_small: f64,
}

/// Sleep thresholds in use.
pub const SLEEP: SleepSettings =
    SleepSettings { speed: 1e-3, delay: 0.5, displacement: 1e-4, displacement_of_small: 2e-3 };
