//! Timeline of a run: snapshots for rollback, and events.
//!
//! Snapshots are stored in bounded memory: when it is full, every second one of the older half is
//! dropped, so that the whole run stays accessible, its beginning at a coarser interval. Moments
//! after the present one are kept until time advances again.

use sheetwork::islands::event::Event;
use sheetwork::sheet::Sheet;
use sheetwork::{Snapshot, World};

/// Default memory for snapshots, bytes.
pub const DEFAULT_CAPACITY: usize = 256 << 20;

/// Snapshot with its time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Simulated time, s.
    pub time: f64,
    /// Number of steps up to that moment.
    pub steps: u64,
    /// Snapshot of the world.
    pub snapshot: Snapshot,
    /// Number of events up to that moment.
    events: usize,
}

/// History of a run for rollback.
#[derive(Clone, Debug)]
pub struct Timeline {
    moments: Vec<Moment>,
    events: Vec<Event>,
    /// Number of the world's events already stored; it decreases with a rollback.
    seen: usize,
    /// Approximate size of a snapshot, bytes.
    each: usize,
    capacity: usize,
}

impl Default for Timeline {
    fn default() -> Self {
        Self::with_capacity(DEFAULT_CAPACITY)
    }
}

impl Timeline {
    /// Timeline with this much memory for snapshots, bytes.
    pub fn with_capacity(capacity: usize) -> Self {
        Self { moments: Vec::new(), events: Vec::new(), seen: 0, each: 1, capacity }
    }

    /// Delete everything, for a new run.
    pub fn clear(&mut self) {
        self.moments.clear();
        self.events.clear();
        self.seen = 0;
    }

    /// Store a snapshot of the world, if it is later than the last moment.
    pub fn record(&mut self, world: &World) {
        self.store_events(world.events());
        if self.moments.last().is_some_and(|m| m.steps >= world.steps()) {
            return;
        }
        self.each = bytes_of(world).max(1);
        if (self.moments.len() + 1) * self.each > self.capacity && self.moments.len() > 8 {
            self.drop_every_second();
        }
        self.moments.push(Moment {
            time: world.time(),
            steps: world.steps(),
            snapshot: world.snapshot(),
            events: self.events.len(),
        });
    }

    /// Replace the present moment after an edit of the state.
    pub fn replace_present(&mut self, world: &World) {
        match self.moments.binary_search_by_key(&world.steps(), |m| m.steps) {
            Ok(at) => self.moments[at].snapshot = world.snapshot(),
            Err(at) => {
                let events = at.checked_sub(1).map_or(0, |before| self.moments[before].events);
                let (time, steps, snapshot) = (world.time(), world.steps(), world.snapshot());
                self.moments.insert(at, Moment { time, steps, snapshot, events });
            }
        }
    }

    /// Store new events.
    fn store_events(&mut self, events: &[Event]) {
        self.events.extend_from_slice(events.get(self.seen..).unwrap_or_default());
        self.seen = events.len();
    }

    /// Drop every second moment of the older half, except the first.
    fn drop_every_second(&mut self) {
        let half = self.moments.len() / 2;
        let mut index = 0;
        self.moments.retain(|_| {
            index += 1;
            index > half || index % 2 == 1
        });
    }

    /// Follow a rollback of `world` to one of the moments.
    pub fn follow_rollback(&mut self, world: &World) {
        self.seen = world.events().len();
    }

    /// Delete the moments after the present of `world`.
    pub fn discard_after(&mut self, world: &World) {
        self.moments.retain(|m| m.steps <= world.steps());
        self.events.truncate(self.moments.last().map_or(0, |m| m.events));
    }

    /// Last moment with at most this number of steps.
    pub fn at_steps(&self, steps: u64) -> Option<&Moment> {
        let after = self.moments.partition_point(|m| m.steps <= steps);
        after.checked_sub(1).and_then(|i| self.moments.get(i))
    }

    /// Moment nearest to a time, s.
    pub fn nearest(&self, time: f64) -> Option<&Moment> {
        let after = self.moments.partition_point(|m| m.time <= time);
        let (a, b) = (after.checked_sub(1).and_then(|i| self.moments.get(i)), self.moments.get(after));
        match (a, b) {
            (Some(a), Some(b)) => Some(if time - a.time <= b.time - time { a } else { b }),
            (a, b) => a.or(b),
        }
    }

    /// First and last time of the moments, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.moments.first()?.time, self.moments.last()?.time))
    }

    /// Number of moments.
    pub fn len(&self) -> usize {
        self.moments.len()
    }

    /// Whether there are no moments.
    pub fn is_empty(&self) -> bool {
        self.moments.is_empty()
    }

    /// Approximate memory of the snapshots, bytes.
    pub fn bytes(&self) -> usize {
        self.moments.len() * self.each
    }

    /// Events of the whole run, including those after the present moment.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

/// Upper estimate of the size of a snapshot of `world`: node positions and velocities, and per
/// element the state of heat, creep and plasticity.
fn bytes_of(world: &World) -> usize {
    let of = |sheet: &Sheet| {
        let changes = sheet.heat().is_some() || world.scene().sheets.iter().any(|s| s.plastic || s.creep);
        // The state of a shell's element is larger than that of a spring.
        let elements = if sheet.springs().is_empty() { 1200 } else { 250 };
        let more = if changes { elements * sheet.node_count() + 100 * sheet.springs().len() } else { 0 };
        64 * sheet.node_count() + more
    };
    512 + world.sheets().iter().map(of).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{Scene, SheetSpec};

    fn world() -> World {
        World::new(&Scene { sheets: vec![SheetSpec::default()], ..Scene::default() }).expect("valid")
    }

    #[test]
    fn moments_are_found_by_time_and_by_step() {
        let (mut world, mut timeline) = (world(), Timeline::default());
        assert!(timeline.nearest(0.0).is_none() && timeline.span().is_none() && timeline.is_empty());
        for _ in 0..5 {
            timeline.record(&world);
            timeline.record(&world);
            (0..10).for_each(|_| _ = world.step());
        }
        assert_eq!(timeline.len(), 5, "one a moment");
        let (first, last) = timeline.span().expect("some");
        assert!(first == 0.0 && (last - 0.04).abs() < 1e-12);
        assert_eq!(timeline.nearest(0.0149).map(|m| m.steps), Some(10));
        assert_eq!(timeline.nearest(0.0151).map(|m| m.steps), Some(20));
        assert_eq!(timeline.nearest(-1.0).map(|m| m.steps), Some(0));
        assert_eq!(timeline.nearest(9.0).map(|m| m.steps), Some(40));
        assert_eq!(timeline.at_steps(29).map(|m| m.steps), Some(20));
        let back = timeline.at_steps(20).expect("there").snapshot.clone();
        world.restore(&back).expect("its own");
        timeline.discard_after(&world);
        assert_eq!((timeline.len(), world.steps()), (3, 20));
    }

    #[test]
    fn memory_is_bounded_and_the_beginning_stays() {
        let mut world = world();
        let capacity = 40 * bytes_of(&world);
        let mut timeline = Timeline::with_capacity(capacity);
        for _ in 0..500 {
            timeline.record(&world);
            world.step();
        }
        assert!(timeline.bytes() <= capacity && timeline.len() > 15, "{} in {}", timeline.len(), timeline.bytes());
        assert_eq!(timeline.span().map(|s| s.0), Some(0.0));
        assert_eq!(timeline.at_steps(499).map(|m| m.steps), Some(499), "the end is whole");
    }
}
