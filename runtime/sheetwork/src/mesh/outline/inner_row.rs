//! Row of nodes one cell inside every boundary and beside every cut.
//!
//! The discretisation error of a clamped or free edge depends on the row next to it. With the row
//! one cell away, as on a grid that fits, an edge at an angle to the grid is as accurate as one
//! along it. Points closer than [`ROW_CLEARANCE`] to another boundary, or closer than
//! [`MIN_POINT_DISTANCE`] to each other, are omitted.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::mesh::outline::boundary_nodes::BoundaryNodes;
use crate::mesh::outline::ring::distance;

/// Minimum distance of the row from boundaries other than its own, cells.
const ROW_CLEARANCE: f64 = 0.85;
/// Minimum distance between inner points, cells.
pub const MIN_POINT_DISTANCE: f64 = 0.7;

/// Points by cell.
#[derive(Debug, Default)]
pub struct PointBins(BTreeMap<(i64, i64), Vec<DVec2>>);

impl PointBins {
    fn cell(p: DVec2) -> (i64, i64) {
        (p.x.floor() as i64, p.y.floor() as i64)
    }

    /// Add a point.
    pub fn add(&mut self, p: DVec2) {
        self.0.entry(Self::cell(p)).or_default().push(p);
    }

    /// Whether a point is closer to `p` than `reach`, which is at most 1.
    pub fn near(&self, p: DVec2, reach: f64) -> bool {
        let (i, j) = Self::cell(p);
        let around = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j)));
        around.filter_map(|c| self.0.get(&c)).flatten().any(|q| q.distance(p) < reach)
    }
}

/// Sides by the cells near them.
struct SideBins(BTreeMap<(i64, i64), Vec<(DVec2, DVec2)>>);

impl SideBins {
    fn new(nodes: &BoundaryNodes) -> Self {
        let mut bins: BTreeMap<(i64, i64), Vec<(DVec2, DVec2)>> = BTreeMap::new();
        for side in nodes.sides.iter().chain(&nodes.slits) {
            let [a, b] = side.map(|v| nodes.points[v as usize]);
            let (low, high) = (PointBins::cell(a.min(b) - 1.0), PointBins::cell(a.max(b) + 1.0));
            for i in low.0..=high.0 {
                (low.1..=high.1).for_each(|j| bins.entry((i, j)).or_default().push((a, b)));
            }
        }
        Self(bins)
    }

    fn clear(&self, p: DVec2) -> bool {
        self.0
            .get(&PointBins::cell(p))
            .is_none_or(|sides| sides.iter().all(|(a, b)| distance(p, *a, *b) >= ROW_CLEARANCE))
    }
}

/// Points of the row, in the order of the boundaries, without those on grid points.
pub fn points(nodes: &BoundaryNodes) -> (Vec<DVec2>, PointBins) {
    let sides = SideBins::new(nodes);
    let (mut row, mut bins) = (Vec::new(), PointBins::default());
    for p in candidates(nodes) {
        if sides.clear(p) && !bins.near(p, MIN_POINT_DISTANCE) {
            bins.add(p);
            if p.distance(p.round()) > 1e-6 {
                row.push(p);
            }
        }
    }
    (row, bins)
}

/// Candidates one cell inwards from every node of the boundary, and to both sides of every node
/// inside a cut.
fn candidates(nodes: &BoundaryNodes) -> Vec<DVec2> {
    let n = nodes.points.len();
    let mut before = vec![Vec::new(); n];
    let mut after = vec![Vec::new(); n];
    for [a, b] in nodes.sides.iter().chain(&nodes.slits) {
        after[*a as usize].push(*b as usize);
        before[*b as usize].push(*a as usize);
    }
    let mut found = Vec::new();
    for v in 0..n {
        let ([a], [c]) = (before[v].as_slice(), after[v].as_slice()) else { continue };
        let p = nodes.points[v];
        let (d, e) = ((p - nodes.points[*a]).normalize_or_zero(), (nodes.points[*c] - p).normalize_or_zero());
        let across = (d + e).perp().normalize_or_zero();
        // In a corner the row is a cell from both sides; the factor is bounded for sharp corners.
        let reach = 1.0 / across.dot(d.perp()).max(0.7);
        found.push(p + across * reach);
        if v >= nodes.rim {
            found.push(p - across * reach);
        }
    }
    found
}
