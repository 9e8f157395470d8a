//! Profiler of the phases of a step.
//!
//! Phases are nested; the time of an inner phase is not counted in the outer one. Times of sheets
//! stepped in parallel add up over threads.

use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use sheetwork::profiler::{Phase, StepObserver};

thread_local! {
    /// Open phases of this thread, each with the time at which its own time last started.
    static UNDER_WAY: RefCell<Vec<(Phase, Instant)>> = const { RefCell::new(Vec::new()) };
}

/// Time spent in each phase since the last reading.
#[derive(Debug, Default)]
pub struct StageClock {
    nanoseconds: [AtomicU64; Phase::ALL.len()],
}

impl StageClock {
    fn add(&self, phase: Phase, since: Instant, until: Instant) {
        let spent = until.saturating_duration_since(since).as_nanos() as u64;
        if let Some(at) = Phase::ALL.iter().position(|p| p.0 == phase) {
            self.nanoseconds[at].fetch_add(spent, Ordering::Relaxed);
        }
    }

    /// Time spent in each phase since the last call, s, in the order of [`Phase::ALL`].
    pub fn take(&self) -> [f64; Phase::ALL.len()] {
        std::array::from_fn(|i| self.nanoseconds[i].swap(0, Ordering::Relaxed) as f64 * 1e-9)
    }
}

impl StepObserver for StageClock {
    fn begin(&self, phase: Phase) {
        let now = Instant::now();
        UNDER_WAY.with_borrow_mut(|stack| {
            if let Some((outer, since)) = stack.last() {
                self.add(*outer, *since, now);
            }
            stack.push((phase, now));
        });
    }

    fn end(&self, phase: Phase) {
        let now = Instant::now();
        UNDER_WAY.with_borrow_mut(|stack| {
            if let Some((inner, since)) = stack.pop() {
                debug_assert_eq!(inner, phase);
                self.add(inner, since, now);
            }
            if let Some(outer) = stack.last_mut() {
                outer.1 = now;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_time_of_an_inner_phase_is_not_counted_in_the_outer_one() {
        let clock = StageClock::default();
        let spend = |ms: u64| {
            let start = Instant::now();
            while start.elapsed() < Duration::from_millis(ms) {
                std::hint::spin_loop();
            }
            start.elapsed().as_secs_f64()
        };
        clock.begin(Phase::Motion);
        let first = spend(4);
        clock.begin(Phase::Contact);
        let inner = spend(8);
        clock.end(Phase::Contact);
        let second = spend(4);
        clock.end(Phase::Motion);
        let all = clock.take();
        // Lower bounds: the clock includes its own overhead.
        assert!(all[0] >= first + second && all[2] >= inner, "{all:?}");
        assert_eq!((all[1], all[3], all[4], all[5]), (0.0, 0.0, 0.0, 0.0));
        assert_eq!(clock.take(), [0.0; 6]);
    }
}
