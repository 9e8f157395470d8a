//! Closed polylines: area, containment, distance, crossings.

use glam::DVec2;

/// Distance of points that are one, as a fraction of the ring's larger extent.
const SAME_POINT: f64 = 1e-9;

/// Closed polyline; the last point is joined to the first. After the checks the sheet is on its
/// left.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Points, m; neighbours are distinct.
    pub points: Vec<DVec2>,
    /// Field of the scene.
    pub field: String,
}

impl Ring {
    /// Ring of points that may repeat, up to rounding: the end of an arc and the start of the next
    /// one differ by that.
    pub fn new(points: impl IntoIterator<Item = DVec2>, field: &str) -> Self {
        let points: Vec<DVec2> = points.into_iter().collect();
        let (low, high) = crate::mesh::outline::bounds(&points);
        let near = SAME_POINT * (high - low).max_element();
        let mut kept: Vec<DVec2> = Vec::new();
        for p in points {
            if kept.last().is_none_or(|last| last.distance(p) > near) {
                kept.push(p);
            }
        }
        while kept.len() > 1 && kept[0].distance(kept[kept.len() - 1]) <= near {
            kept.pop();
        }
        Self { points: kept, field: field.into() }
    }

    /// Sides, from point to point.
    pub fn sides(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let n = self.points.len();
        (0..n).map(move |i| (self.points[i], self.points[(i + 1) % n]))
    }

    /// Area, m², positive when counter-clockwise in (x, z).
    pub fn area(&self) -> f64 {
        // Computed about the first point, to keep digits of a small ring far from the origin.
        let origin = self.points.first().copied().unwrap_or_default();
        self.sides().map(|(a, b)| 0.5 * (a - origin).perp_dot(b - origin)).sum()
    }

    /// Whether `p` is inside (even-odd rule).
    pub fn contains(&self, p: DVec2) -> bool {
        let right_of =
            |(a, b): (DVec2, DVec2)| (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x;
        self.sides().filter(|s| right_of(*s)).count() % 2 == 1
    }

    /// Point of the ring nearest to `p`.
    pub fn nearest(&self, p: DVec2) -> DVec2 {
        let mut best = (f64::INFINITY, p);
        for (a, b) in self.sides() {
            let q = a + (b - a) * foot(p, a, b);
            if p.distance_squared(q) < best.0 {
                best = (p.distance_squared(q), q);
            }
        }
        best.1
    }
}

/// Parameter (0 to 1) of the point of the segment from a to b nearest to `p`.
pub fn foot(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let l = d.length_squared();
    if l > 0.0 { ((p - a).dot(d) / l).clamp(0.0, 1.0) } else { 0.0 }
}

/// Distance of `p` from the segment from a to b.
pub fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    p.distance(a + (b - a) * foot(p, a, b))
}

/// Intersection of two segments, as fractions of each, touching included. `None` when they are
/// apart or parallel.
pub fn meeting(a: (DVec2, DVec2), b: (DVec2, DVec2)) -> Option<(f64, f64)> {
    let (d, e) = (a.1 - a.0, b.1 - b.0);
    let cross = d.perp_dot(e);
    if cross == 0.0 {
        return None;
    }
    let between = b.0 - a.0;
    let (s, t) = (between.perp_dot(e) / cross, between.perp_dot(d) / cross);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some((s, t))
}

/// Whether two parallel segments overlap.
fn overlap(a: (DVec2, DVec2), b: (DVec2, DVec2)) -> bool {
    let d = a.1 - a.0;
    let reach = d.length_squared().max((b.1 - b.0).length_squared());
    if d.perp_dot(b.0 - a.0).abs() > 1e-12 * reach || d.perp_dot(b.1 - a.0).abs() > 1e-12 * reach {
        return false;
    }
    let (l, s, t) = (d.length_squared(), (b.0 - a.0).dot(d), (b.1 - a.0).dot(d));
    s.min(t) < l && s.max(t) > 0.0
}

/// Side of one of several rings.
#[derive(Clone, Copy)]
struct RingSide {
    ends: (DVec2, DVec2),
    ring: usize,
    index: usize,
    low: DVec2,
    high: DVec2,
}

/// Two rings (or one, twice) that cross or touch each other, and the point.
pub fn crossing(rings: &[Ring]) -> Option<(usize, usize, DVec2)> {
    let mut sides = Vec::new();
    for (ring, r) in rings.iter().enumerate() {
        for (index, ends) in r.sides().enumerate() {
            sides.push(RingSide { ends, ring, index, low: ends.0.min(ends.1), high: ends.0.max(ends.1) });
        }
    }
    // Sweep along x: only sides whose extents overlap are compared.
    sides.sort_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.ring.cmp(&b.ring)).then(a.index.cmp(&b.index)));
    for (i, a) in sides.iter().enumerate() {
        for b in sides[i + 1..].iter().take_while(|b| b.low.x <= a.high.x) {
            let near = b.low.y <= a.high.y && b.high.y >= a.low.y;
            if let Some(p) = near.then(|| sides_meet(a, b, rings)).flatten() {
                return Some((a.ring.min(b.ring), a.ring.max(b.ring), p));
            }
        }
    }
    None
}

fn sides_meet(a: &RingSide, b: &RingSide, rings: &[Ring]) -> Option<DVec2> {
    if a.ring == b.ring {
        let n = rings[a.ring].points.len();
        let after = |i: usize, j: usize| (i + 1) % n == j;
        for (first, second) in [(a, b), (b, a)] {
            if after(first.index, second.index) {
                // Neighbours share a point; they meet elsewhere only where the ring turns back on
                // itself.
                let (d, e) = (first.ends.1 - first.ends.0, second.ends.1 - second.ends.0);
                let back = d.dot(e) < 0.0 && d.perp_dot(e).abs() <= 1e-9 * d.length() * e.length();
                return back.then_some(second.ends.0);
            }
        }
    }
    match meeting(a.ends, b.ends) {
        Some((s, _)) => Some(a.ends.0 + (a.ends.1 - a.ends.0) * s),
        None => overlap(a.ends, b.ends).then_some(b.ends.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Ring {
        Ring::new(points.iter().map(|p| DVec2::new(p.0, p.1)), "outline")
    }

    #[test]
    fn area_inside_and_distance_of_a_square() {
        let square = ring(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)]);
        assert_eq!(square.points.len(), 4);
        assert_eq!(square.area(), 4.0);
        assert!(square.contains(DVec2::new(1.9, 0.1)) && !square.contains(DVec2::new(2.1, 0.1)));
        assert_eq!(square.nearest(DVec2::new(3.0, 1.0)), DVec2::new(2.0, 1.0));
    }

    #[test]
    fn crossings_are_found_and_plain_rings_have_none() {
        let square = ring(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
        let bow = ring(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)]);
        let spike = ring(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (2.0, 4.0), (2.0, 2.0), (0.0, 2.0)]);
        let inner = ring(&[(0.5, 0.5), (1.5, 0.5), (1.0, 1.5)]);
        let across = ring(&[(1.5, 0.5), (3.0, 0.5), (3.0, 1.5)]);
        let beside = ring(&[(2.0, 0.5), (3.0, 0.5), (3.0, 1.5), (2.0, 1.5)]);
        assert_eq!(crossing(&[square.clone(), inner]), None);
        assert_eq!(crossing(&[bow]), Some((0, 0, DVec2::new(1.0, 1.0))));
        assert!(crossing(&[spike]).is_some());
        assert!(crossing(&[square.clone(), across]).is_some());
        assert!(crossing(&[square, beside]).is_some());
    }
}
