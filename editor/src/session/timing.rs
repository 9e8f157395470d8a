//! Wall-clock time of the steps of a session.

/// How long steps take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Wall-clock time of a step, smoothed over some frames, s; 0 before the first.
    pub step_s: f64,
    /// Wall-clock time spent on stepping since the scene was opened or reset, s.
    pub spent_s: f64,
    /// Real time that could not be simulated because stepping was too slow, s.
    pub lost_s: f64,
    /// Steps taken in the last frame.
    pub steps: u32,
    /// The same of each part of a step ([`sheetwork::profiler::Phase::ALL`]), while that is asked for, s.
    pub stages: Option<[f64; 5]>,
}
