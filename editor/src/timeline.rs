//! Where a run has been: snapshots to go back to, and marks of what happened.
//!
//! Snapshots are taken as time goes on and kept in bounded memory: when there is no more room, every second one of the older half goes, so that
//! the whole run can be gone back to, its beginning in coarser steps. What comes after the present moment stays until the run
//! goes another way.

use sheetwork::islands::event::Event;
use sheetwork::sheet::Sheet;
use sheetwork::{Snapshot, World};

/// Memory for snapshots unless told otherwise, bytes.
pub const ROOM: usize = 256 << 20;

/// A snapshot and when it was.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Simulated time, s.
    pub time: f64,
    /// Steps taken until then.
    pub steps: u64,
    /// The world.
    pub snapshot: Snapshot,
    /// How much had happened.
    events: usize,
}

/// A run that can be gone back in.
#[derive(Clone, Debug)]
pub struct Timeline {
    moments: Vec<Moment>,
    events: Vec<Event>,
    /// How many of the world's own events have been taken up: a world that went back has forgotten some.
    seen: usize,
    /// Bytes of a snapshot, about.
    each: usize,
    room: usize,
}

impl Default for Timeline {
    fn default() -> Self {
        Self::with_room(ROOM)
    }
}

impl Timeline {
    /// One that takes about so many bytes at most.
    pub fn with_room(room: usize) -> Self {
        Self { moments: Vec::new(), events: Vec::new(), seen: 0, each: 1, room }
    }

    /// Forgets everything: another run begins.
    pub fn clear(&mut self) {
        self.moments.clear();
        self.events.clear();
        self.seen = 0;
    }

    /// Takes up the world as it is now; nothing where it is no further than the last moment.
    pub fn take(&mut self, world: &World) {
        self.learn(world.events());
        if self.moments.last().is_some_and(|m| m.steps >= world.steps()) {
            return;
        }
        self.each = bytes_of(world).max(1);
        if (self.moments.len() + 1) * self.each > self.room && self.moments.len() > 8 {
            self.thin();
        }
        self.moments.push(Moment {
            time: world.time(),
            steps: world.steps(),
            snapshot: world.snapshot(),
            events: self.events.len(),
        });
    }

    /// Takes up what `world` has become at the present moment, by other hands than time's.
    pub fn renew(&mut self, world: &World) {
        match self.moments.binary_search_by_key(&world.steps(), |m| m.steps) {
            Ok(at) => self.moments[at].snapshot = world.snapshot(),
            Err(at) => {
                let events = at.checked_sub(1).map_or(0, |before| self.moments[before].events);
                let (time, steps, snapshot) = (world.time(), world.steps(), world.snapshot());
                self.moments.insert(at, Moment { time, steps, snapshot, events });
            }
        }
    }

    /// Takes up events that it does not know yet.
    fn learn(&mut self, events: &[Event]) {
        self.events.extend_from_slice(events.get(self.seen..).unwrap_or_default());
        self.seen = events.len();
    }

    /// Every second moment of the older half goes; the first stays.
    fn thin(&mut self) {
        let half = self.moments.len() / 2;
        let mut index = 0;
        self.moments.retain(|_| {
            index += 1;
            index > half || index % 2 == 1
        });
    }

    /// Says that `world` has gone to one of the moments.
    pub fn went(&mut self, world: &World) {
        self.seen = world.events().len();
    }

    /// Forgets what came after the present of `world`: from here the run goes another way.
    pub fn forget_after(&mut self, world: &World) {
        self.moments.retain(|m| m.steps <= world.steps());
        self.events.truncate(self.moments.last().map_or(0, |m| m.events));
    }

    /// The last moment with at most so many steps taken.
    pub fn at_steps(&self, steps: u64) -> Option<&Moment> {
        let after = self.moments.partition_point(|m| m.steps <= steps);
        after.checked_sub(1).and_then(|i| self.moments.get(i))
    }

    /// The moment nearest to a time, s.
    pub fn nearest(&self, time: f64) -> Option<&Moment> {
        let after = self.moments.partition_point(|m| m.time <= time);
        let (a, b) = (after.checked_sub(1).and_then(|i| self.moments.get(i)), self.moments.get(after));
        match (a, b) {
            (Some(a), Some(b)) => Some(if time - a.time <= b.time - time { a } else { b }),
            (a, b) => a.or(b),
        }
    }

    /// First and last time that can be gone to, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.moments.first()?.time, self.moments.last()?.time))
    }

    /// How many moments there are.
    pub fn len(&self) -> usize {
        self.moments.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.moments.is_empty()
    }

    /// Memory of the snapshots, about, bytes.
    pub fn bytes(&self) -> usize {
        self.moments.len() * self.each
    }

    /// What happened in the whole run, the part after the present moment included.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

/// Memory of a snapshot of `world`, about: where masses are and how they move, and of what heat, creep and yield change, which is kept with
/// its elements, a generous guess.
fn bytes_of(world: &World) -> usize {
    let of = |sheet: &Sheet| {
        let changes = sheet.heat().is_some() || world.scene().sheets.iter().any(|s| s.plastic || s.creep);
        // Elements of a shell are large; those of a lattice are its springs.
        let elements = if sheet.springs().is_empty() { 1200 } else { 250 };
        let more = if changes { elements * sheet.masses() + 100 * sheet.springs().len() } else { 0 };
        64 * sheet.masses() + more
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
            timeline.take(&world);
            timeline.take(&world);
            (0..10).for_each(|_| world.step());
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
        timeline.forget_after(&world);
        assert_eq!((timeline.len(), world.steps()), (3, 20));
    }

    #[test]
    fn memory_is_bounded_and_the_beginning_stays() {
        let mut world = world();
        let room = 40 * bytes_of(&world);
        let mut timeline = Timeline::with_room(room);
        for _ in 0..500 {
            timeline.take(&world);
            world.step();
        }
        assert!(timeline.bytes() <= room && timeline.len() > 15, "{} in {}", timeline.len(), timeline.bytes());
        assert_eq!(timeline.span().map(|s| s.0), Some(0.0));
        assert_eq!(timeline.at_steps(499).map(|m| m.steps), Some(499), "the end is whole");
    }
}
