//! Boundary or cut in units of cells, and its points that become nodes.
//!
//! Coordinates are in cells of the grid, (x - x₀)/h_x and (z - z₀)/h_z, so that a cell is a
//! distance of 1 in every direction. Angles are those of the outline in metres.

use glam::DVec2;

use crate::error::InputError;
use crate::mesh::outline::metres;

/// Turn above which a point of a polyline is a corner instead of part of a curve, degrees.
const CORNER_ANGLE: f64 = 20.0;
/// Turn within half a cell above which a curve is a corner at this grid, degrees.
const TIGHT_ANGLE: f64 = 60.0;
/// Maximum turn between neighbouring nodes on a curve, degrees.
const MAX_NODE_ANGLE: f64 = 60.0;
/// Distance below which corners are grouped, cells.
const CORNER_GROUP_DISTANCE: f64 = 0.45;

/// Conversion between metres and cells.
#[derive(Clone, Copy, Debug)]
pub struct CellScale {
    /// Corner of the grid, m.
    pub low: DVec2,
    /// Size of a cell, m.
    pub size: DVec2,
}

impl CellScale {
    /// Point in cells.
    pub fn of(&self, p: DVec2) -> DVec2 {
        (p - self.low) / self.size
    }

    /// Point in metres.
    pub fn metres(&self, p: DVec2) -> DVec2 {
        self.low + p * self.size
    }

    /// Distance of two points in cells, m.
    pub fn distance(&self, p: DVec2, q: DVec2) -> f64 {
        (self.metres(p) - self.metres(q)).length()
    }

    /// Error of a feature of `size` (m) at `p` (cells) that is too small for the grid.
    pub fn too_small(&self, field: &str, what: &str, size: f64, p: DVec2) -> InputError {
        let p = self.metres(p);
        let place = format!("near ({}, {}) m", metres(p.x), metres(p.y));
        let cell = format!("{} x {} m", metres(self.size.x), metres(self.size.y));
        let problem = format!("{what} {} m {place}, smaller than the cell of {cell}; use a finer grid", metres(size));
        InputError::new(field, problem)
    }
}

/// Polyline with arc lengths and stops: points that become nodes.
#[derive(Clone, Debug)]
pub struct OutlineLine {
    /// Field of the scene.
    pub field: String,
    /// Points, cells; of a closed line the first one is repeated at the end.
    pub points: Vec<DVec2>,
    /// Arc length at each point, cells.
    pub arc: Vec<f64>,
    /// Turn at each point, degrees, positive to the left; of a closed line the last equals the
    /// first.
    turn: Vec<f64>,
    /// Whether the line is closed.
    pub closed: bool,
    /// Arc length and position of the stops.
    pub stops: Vec<(f64, DVec2)>,
}

impl OutlineLine {
    /// Line of points in metres.
    ///
    /// # Errors
    /// When corners are too close together for the grid.
    pub fn new(points: &[DVec2], closed: bool, field: &str, cells: &CellScale) -> Result<Self, InputError> {
        let mut real = points.to_vec();
        real.dedup();
        if closed {
            real.extend(points.first());
        }
        let mut line = Self {
            field: field.into(),
            points: real.iter().map(|p| cells.of(*p)).collect(),
            arc: Vec::new(),
            turn: turns(&real, closed),
            closed,
            stops: Vec::new(),
        };
        line.measure();
        line.find_corners(cells)?;
        Ok(line)
    }

    fn measure(&mut self) {
        let mut length = 0.0;
        self.arc = vec![0.0];
        for pair in self.points.windows(2) {
            length += pair[0].distance(pair[1]);
            self.arc.push(length);
        }
    }

    /// Length, cells.
    pub fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// Sides of the line.
    pub fn sides(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        self.points.windows(2).map(|w| (w[0], w[1]))
    }

    /// Index of the side at arc length `s`.
    pub fn side_at(&self, s: f64) -> usize {
        self.arc.partition_point(|a| *a <= s).clamp(1, self.points.len().max(2) - 1) - 1
    }

    /// Point at arc length `s`; on a closed line `s` is periodic.
    pub fn at(&self, s: f64) -> DVec2 {
        let s = if self.closed { s.rem_euclid(self.length()) } else { s };
        let i = self.side_at(s);
        let (a, b) = (self.points[i], self.points[i + 1]);
        let t = (s - self.arc[i]) / (self.arc[i + 1] - self.arc[i]).max(f64::MIN_POSITIVE);
        a.lerp(b, t.clamp(0.0, 1.0))
    }

    /// Distance along the line between two arc lengths.
    fn between(&self, s: f64, t: f64) -> f64 {
        let d = (s - t).abs();
        if self.closed { d.min(self.length() - d) } else { d }
    }

    /// Stop within `reach` of arc length `s`, or a new one there.
    pub fn stop(&mut self, s: f64, reach: f64) -> DVec2 {
        if let Some(found) = self.stops.iter().find(|stop| self.between(stop.0, s) < reach) {
            return found.1;
        }
        let point = self.at(s);
        self.stops.push((s, point));
        point
    }

    /// Replace an end of an open line, the first point or the last.
    pub fn move_end(&mut self, last: bool, to: DVec2) {
        let end = if last { self.points.len() - 1 } else { 0 };
        self.points[end] = to;
        let lengths = self.arc.clone();
        self.measure();
        // Stops keep their fraction of the side whose length has changed.
        for (s, _) in &mut self.stops {
            let i = lengths.partition_point(|a| *a <= *s).clamp(1, lengths.len() - 1) - 1;
            let t = (*s - lengths[i]) / (lengths[i + 1] - lengths[i]).max(f64::MIN_POSITIVE);
            *s = self.arc[i] + t * (self.arc[i + 1] - self.arc[i]);
        }
    }

    /// Move a stop to `to`.
    pub fn replace_stop(&mut self, stop: DVec2, to: DVec2) {
        for s in self.stops.iter_mut().filter(|s| s.1 == stop) {
            s.1 = to;
        }
    }

    /// Part of an open line between two arc lengths, with its corners.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let within = |s: f64| s > from + 1e-9 && s < to - 1e-9;
        let kept: Vec<usize> = (0..self.points.len()).filter(|i| within(self.arc[*i])).collect();
        let mut points = vec![self.at(from)];
        points.extend(kept.iter().map(|i| self.points[*i]));
        points.push(self.at(to));
        let mut turn = vec![0.0];
        turn.extend(kept.iter().map(|i| self.turn[*i]));
        turn.push(0.0);
        let stops = self.stops.iter().filter(|s| within(s.0)).map(|s| (s.0 - from, s.1)).collect();
        let mut part = Self { field: self.field.clone(), points, arc: Vec::new(), turn, closed: false, stops };
        part.measure();
        part
    }

    /// Add stops at corners, and at turns too tight for the grid.
    fn find_corners(&mut self, cells: &CellScale) -> Result<(), InputError> {
        let groups = self.corner_groups();
        for group in groups {
            let (first, last) = (group[0], group[group.len() - 1]);
            if group.len() == 1 {
                self.stops.push((self.arc[first], self.points[first]));
                continue;
            }
            let inside = self.range(first, last);
            let net: f64 = inside.iter().map(|i| self.turn[*i]).sum();
            let all: f64 = inside.iter().map(|i| self.turn[*i].abs()).sum();
            if all - net.abs() > CORNER_ANGLE || (net.abs() > 135.0 && net.abs() < 225.0) {
                let (a, b) = (self.points[first], self.points[last]);
                let size = cells.distance(a, b);
                return Err(cells.too_small(&self.field, "has a feature of", size, a.midpoint(b)));
            }
            // A rounded corner becomes a corner in its middle; a longer run of small turns is a
            // curve.
            if self.between(self.arc[first], self.arc[last]) < 0.7 {
                let mut turned = 0.0;
                let middle = inside.iter().find(|i| {
                    turned += self.turn[**i];
                    turned.abs() >= 0.5 * net.abs()
                });
                let middle = middle.copied().unwrap_or(first);
                self.stops.push((self.arc[middle], self.points[middle]));
            }
        }
        Ok(())
    }

    /// Points from `first` to `last`, across the end of a closed line if needed.
    fn range(&self, first: usize, last: usize) -> Vec<usize> {
        if first <= last { (first..=last).collect() } else { (first..self.points.len() - 1).chain(0..=last).collect() }
    }

    /// Corners and points of tight turns, with close ones in one group.
    fn corner_groups(&self) -> Vec<Vec<usize>> {
        let n = self.points.len() - 1;
        let range = if self.closed { 0..n } else { 1..n };
        let tight = self.tight();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for i in range.filter(|i| self.turn[*i].abs() > CORNER_ANGLE || tight[*i]) {
            match groups.last_mut() {
                Some(group) if self.between(self.arc[group[group.len() - 1]], self.arc[i]) < CORNER_GROUP_DISTANCE => {
                    group.push(i)
                }
                _ => groups.push(vec![i]),
            }
        }
        if self.closed {
            let ends = groups.first().map(|g| g[0]).zip(groups.last().map(|g| g[g.len() - 1]));
            let joined =
                ends.is_some_and(|(a, b)| a != b && self.between(self.arc[a], self.arc[b]) < CORNER_GROUP_DISTANCE);
            if joined && groups.len() > 1 {
                let first = groups.remove(0);
                if let Some(last) = groups.last_mut() {
                    last.extend(first);
                }
            } else if joined && self.arc[groups[0][groups[0].len() - 1]] - self.arc[groups[0][0]] > 0.5 * self.length()
            {
                // Small turns all around: a curve without a corner.
                groups.clear();
            }
        }
        groups
    }

    /// Points of a curve that turns by more than [`TIGHT_ANGLE`] within half a cell.
    fn tight(&self) -> Vec<bool> {
        let n = self.points.len() - 1;
        let mut tight = vec![false; n + 1];
        let smooth = |i: usize| if self.turn[i].abs() > CORNER_ANGLE { 0.0 } else { self.turn[i].abs() };
        let (mut end, mut sum) = (0, 0.0);
        let laps = if self.closed { 2 * n } else { n };
        let arc = |i: usize| self.arc[i % n] + if i >= n { self.length() } else { 0.0 };
        for start in 0..n {
            while end < laps && arc(end) - arc(start) <= 0.5 {
                sum += smooth(end % n);
                end += 1;
            }
            if sum > TIGHT_ANGLE {
                (start..end).for_each(|i| tight[i % n] = smooth(i % n) > 0.0);
            }
            sum -= smooth(start);
        }
        tight
    }

    /// Positions of nodes: the stops, and points about a cell apart between them. The points of a
    /// closed line form a ring, without repetition of the first.
    pub fn sample(&self) -> Vec<DVec2> {
        let mut stops = self.stops.clone();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let length = self.length();
        if stops.is_empty() && self.closed {
            // A multiple of four where there is room, so that a disc keeps its symmetry.
            let n = if length > 10.0 { 4.0 * (0.25 * length).round() } else { length.round().max(6.0) };
            return (0..n as usize).map(|i| self.at(i as f64 * length / n)).collect();
        }
        if !self.closed {
            let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
            stops.retain(|s| s.0 > 1e-9 && s.0 < length - 1e-9);
            stops.insert(0, (0.0, first));
            stops.push((length, last));
        } else if let Some(first) = stops.first().copied() {
            stops.push((first.0 + length, first.1));
        }
        let fewest = if self.closed { (3_usize).div_ceil(stops.len().max(2) - 1) } else { 1 };
        let mut points = Vec::new();
        for pair in stops.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let n = self.parts(from.0, to.0).max(fewest);
            points.push(from.1);
            points.extend((1..n).map(|i| self.at(from.0 + (to.0 - from.0) * i as f64 / n as f64)));
        }
        if !self.closed {
            points.extend(self.points.last());
        }
        points
    }

    /// Number of sides between two stops.
    fn parts(&self, from: f64, to: f64) -> usize {
        let n = self.points.len() - 1;
        let inside = |s: f64| s > from + 1e-9 && s < to - 1e-9;
        let turned: f64 = (0..n)
            .filter(|i| inside(self.arc[*i]) || inside(self.arc[*i] + self.length()))
            .map(|i| self.turn[i].abs())
            .sum();
        ((to - from).round() as usize).max((turned / MAX_NODE_ANGLE - 1e-6).ceil() as usize).max(1)
    }
}

/// Turn at each point, degrees; 0 at the ends of an open line.
fn turns(points: &[DVec2], closed: bool) -> Vec<f64> {
    let n = points.len().saturating_sub(1);
    let mut turn = vec![0.0; points.len()];
    let angle = |a: DVec2, b: DVec2, c: DVec2| (b - a).angle_to(c - b).to_degrees();
    for i in 1..n {
        turn[i] = angle(points[i - 1], points[i], points[i + 1]);
    }
    if closed && n > 1 {
        turn[0] = angle(points[n - 1], points[0], points[1]);
        turn[n] = turn[0];
    }
    turn
}
