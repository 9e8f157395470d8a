//! Broad phase of islands: pairs of swept boxes that may overlap, by sweep and prune along x.
//!
//! The box of an object encloses it at the start of the step; within the step the object moves by
//! at most its `reach` (m). Two objects may meet if their boxes, enlarged by both reaches, overlap.

use glam::DVec3;

/// Box (m) of an object at the start of a step, and its maximum displacement in the step (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptBox {
    pub low: DVec3,
    pub high: DVec3,
    pub reach: f64,
}

impl SweptBox {
    /// Whether the objects of the boxes may meet in the step.
    pub fn may_meet(&self, other: &Self) -> bool {
        let room = self.reach + other.reach;
        (self.low - room).cmple(other.high).all() && (other.low - room).cmple(self.high).all()
    }

    /// Interval along x, enlarged by the reach and by its rounding.
    fn interval(&self) -> (f64, f64) {
        let size = self.low.x.abs().max(self.high.x.abs()).max(self.reach);
        let margin = self.reach + if size.is_finite() { 1e-12 * size } else { 0.0 };
        (self.low.x - margin, self.high.x + margin)
    }
}

/// An object of a sweep.
#[derive(Clone, Copy, Debug)]
struct SweptItem {
    /// Interval along x, m.
    start: f64,
    end: f64,
    index: u32,
    is_moving: bool,
}

/// Sweep and prune, with its memory.
#[derive(Default)]
pub(crate) struct SweepAndPrune {
    items: Vec<SweptItem>,
    /// Items whose interval contains the present place, moving and still ones.
    open: [Vec<SweptItem>; 2],
}

impl SweepAndPrune {
    /// Remove all objects.
    pub fn clear(&mut self) {
        self.items.clear();
    }

    /// Add the object `index`. Pairs of objects that are both still are not reported.
    pub fn push(&mut self, index: usize, swept: &SweptBox, is_moving: bool) {
        let (start, end) = swept.interval();
        self.items.push(SweptItem { start, end, index: index as u32, is_moving });
    }

    /// Call `report` once for every pair whose intervals overlap, with the smaller index first. The
    /// order of the pairs depends on the boxes alone.
    pub fn for_each_pair(&mut self, mut report: impl FnMut(usize, usize)) {
        let Self { items, open } = self;
        items.sort_unstable_by(|a, b| a.start.total_cmp(&b.start).then(a.index.cmp(&b.index)));
        open.iter_mut().for_each(Vec::clear);
        for item in &*items {
            let partners = if item.is_moving { 0..2 } else { 0..1 };
            for list in &mut open[partners] {
                list.retain(|other| other.end >= item.start);
                for other in &*list {
                    report(other.index.min(item.index) as usize, other.index.max(item.index) as usize);
                }
            }
            open[usize::from(!item.is_moving)].push(*item);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swept(low: f64, high: f64, reach: f64) -> SweptBox {
        SweptBox { low: DVec3::splat(low), high: DVec3::splat(high), reach }
    }

    #[test]
    fn pairs_are_those_of_the_test_of_all_pairs() {
        let mut seed = 1_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut boxes: Vec<SweptBox> = (0..80).map(|_| draw()).map(|at| swept(at, at + 0.02, 0.003)).collect();
        boxes.push(swept(f64::NEG_INFINITY, 0.5, 0.0));
        boxes.push(swept(f64::INFINITY, f64::NEG_INFINITY, 0.0));
        let is_moving = |i: usize| !i.is_multiple_of(3);
        let mut sweep = SweepAndPrune::default();
        boxes.iter().enumerate().for_each(|(i, b)| sweep.push(i, b, is_moving(i)));
        let mut found = Vec::new();
        sweep.for_each_pair(|a, b| {
            if boxes[a].may_meet(&boxes[b]) {
                found.push((a, b));
            }
        });
        found.sort_unstable();
        let pairs = (0..boxes.len()).flat_map(|a| (a + 1..boxes.len()).map(move |b| (a, b)));
        let wanted: Vec<_> = pairs
            .filter(|(a, b)| is_moving(*a) || is_moving(*b))
            .filter(|(a, b)| boxes[*a].may_meet(&boxes[*b]))
            .collect();
        assert!(wanted.len() > 50, "{}", wanted.len());
        assert_eq!(found, wanted);
    }

    #[test]
    fn boxes_that_touch_exactly_at_their_reach_are_a_pair() {
        let (a, b) = (swept(0.0, 1.0, 0.1), swept(1.1 + 0.1, 2.0, 0.1));
        let mut sweep = SweepAndPrune::default();
        sweep.push(0, &a, true);
        sweep.push(1, &b, false);
        let mut count = 0;
        sweep.for_each_pair(|_, _| count += 1);
        assert_eq!(count, 1);
    }
}
