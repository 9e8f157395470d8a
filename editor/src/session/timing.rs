//! Wall-clock time of the steps of a session.

/// Wall-clock times of steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Wall-clock time of a step, exponential mean over frames, s; 0 before the first.
    pub step_s: f64,
    /// Wall-clock time of all steps since the scene was opened or reset, s.
    pub spent_s: f64,
    /// Real time that was not simulated because stepping was too slow, s.
    pub lost_s: f64,
    /// Steps of the last frame.
    pub steps: u32,
    /// Wall-clock time of each phase of a step ([`sheetwork::profiler::Phase::ALL`]), s, while the
    /// profiler is on.
    pub stages: Option<[f64; sheetwork::profiler::Phase::ALL.len()]>,
}
