//! Limit of the compression of a layered sheet: a node stays above the cell of the layer below it.
//!
//! Inter-layer springs are oblique. A node pushed hard enough snaps through the triangle or square
//! below it and stays there: the layers coincide, and the sheet loses its thickness and bending
//! stiffness. The limit keeps the volume between a node u and its cell, C = (u - m)·N (m³), above a
//! fraction of its rest value. Here m is the mean of the corners, and N = (b - a)×(c - a) for a
//! triangle, (c - a)×(d - b) for a square. Where Ċ would take C below the bound within a step,
//! equal and opposite impulses along the gradient of C prevent it; where C is below the bound, they
//! restore it over a few steps. C is invariant under rigid motion, so linear and angular momentum
//! are conserved to rounding. Corners in contact with a body transmit the impulse to the body and
//! do not move.

use glam::DVec3;

use crate::math::Vectors;

/// Fraction of a missing height that one step restores, and the largest rate of recovery (rest
/// heights per second): a node pushed far through its cell must not return with a high speed.
const RECOVERY_FRACTION: f64 = 0.2;
const MAXIMUM_RECOVERY_RATE: f64 = 30.0;

/// A node and the corners of the cell below it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LimitedCell {
    apex: u32,
    /// Corners; the fourth corner of a triangle repeats the third.
    base: [u32; 4],
    is_square: bool,
    /// C at rest, m³, and |N| at rest, m².
    rest: f64,
    area: f64,
}

/// A node near its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearLimit {
    /// Index of the cell.
    pub index: u32,
    /// Node.
    pub apex: u32,
    /// Corners of the cell, in order around it; the fourth of a triangle repeats the third.
    pub corners: [u32; 4],
    /// Whether the cell is a square.
    pub is_square: bool,
    /// Unit normal from the cell to the node.
    pub normal: DVec3,
    /// Least height of the node above the cell, m.
    pub least_height: f64,
}

/// Fraction of the rest area below which a cell is ignored: its gradient is too small for an
/// impulse.
const COLLAPSED_AREA_THRESHOLD: f64 = 0.3;

/// Height of a node above the limit of its cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellHeight {
    /// The node and the corners of its cell.
    pub nodes: [u32; 5],
    /// Gradient of the height with respect to them.
    pub gradient: [DVec3; 5],
    /// Height above the limit, m; negative below it.
    pub excess: f64,
    /// Height at rest, m.
    rest: f64,
}

impl CellHeight {
    /// Smallest rate (m/s) of the height in a step of `dt` (s): back to the limit over a few steps
    /// from below it, and not beyond it from above.
    pub fn smallest_rate(&self, dt: f64) -> f64 {
        if self.excess < 0.0 {
            (-RECOVERY_FRACTION * self.excess / dt).min(MAXIMUM_RECOVERY_RATE * self.rest)
        } else {
            -self.excess / dt
        }
    }
}

/// Thickness limit of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThicknessLimit {
    cells: Vec<LimitedCell>,
    /// Cells of removed nodes.
    removed: Vec<LimitedCell>,
    /// Fraction of the rest height that is kept, 0 (no limit) to 1.
    pub fraction: f64,
}

impl ThicknessLimit {
    /// A limit without nodes that keeps `fraction` of the rest height.
    pub fn new(fraction: f64) -> Self {
        Self { fraction, ..Self::default() }
    }

    /// Adds a node above three or four corners at rest positions `x` (m); other counts are ignored.
    /// Four corners come row by row: (0, 0), (1, 0), (0, 1), (1, 1).
    pub fn add(&mut self, apex: u32, corners: &[u32], x: &[DVec3]) {
        let base = match corners {
            [a, b, c] => [*a, *b, *c, *c],
            [a, b, d, c] => [*a, *b, *c, *d],
            _ => return,
        };
        let mut cell = LimitedCell { apex, base, is_square: corners.len() == 4, rest: 0.0, area: 0.0 };
        let (volume, normal) = cell.volume(x[apex as usize], base.map(|i| x[i as usize]));
        (cell.rest, cell.area) = (volume, normal.length());
        // A sheet from a file may be collapsed: a height of zero needs no limit.
        if cell.rest != 0.0 {
            self.cells.push(cell);
        }
    }

    /// Suspends the limit of the nodes for which `gone` holds, and restores it for all others.
    pub fn set_open_cells(&mut self, gone: &[bool]) {
        let mut all = std::mem::take(&mut self.cells);
        all.append(&mut self.removed);
        // In the order of the nodes, as they were added.
        all.sort_by_key(|c| c.apex);
        (self.removed, self.cells) = all.into_iter().partition(|c| gone[c.apex as usize]);
    }

    /// Applies the limit to velocities `v` (m/s) at positions `x` (m) before a step of `dt` s.
    /// `inverse_mass` (1/kg) is 0 for fixed nodes; `fixed` marks nodes in contact with a body.
    pub fn apply(&self, x: &Vectors, v: &mut Vectors, inverse_mass: &[f64], fixed: &[bool], dt: f64) {
        for cell in &self.cells {
            cell.limit(self.fraction, x, v, inverse_mass, fixed, dt);
        }
    }

    /// Number of limited cells.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether no cell is limited.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Cell `index` at positions `x` (m) as a distance: its height above the limit (m) over the
    /// rest area, with the gradient of it for each node; `None` for a collapsed cell.
    pub(crate) fn height(&self, index: usize, x: &Vectors) -> Option<CellHeight> {
        let cell = self.cells.get(index)?;
        let (place, corners) = (x.get(cell.apex as usize), cell.base.map(|i| x.get(i as usize)));
        let (volume, normal) = cell.volume(place, corners);
        if normal.length() < COLLAPSED_AREA_THRESHOLD * cell.area {
            return None;
        }
        let scale = cell.rest.signum() / cell.area;
        let [a, b, c, d] = cell.gradients(place, corners, normal).map(|g| g * scale);
        let excess = (volume - self.fraction * cell.rest) * scale;
        let ([p, q, r, s], rest) = (cell.base, cell.rest.abs() / cell.area);
        Some(CellHeight { nodes: [cell.apex, p, q, r, s], gradient: [normal * scale, a, b, c, d], excess, rest })
    }

    /// Nodes whose height above their cell at `x` (m) is less than the limit and a `margin`, as a
    /// fraction of the rest height.
    pub fn near_limit<'a>(&'a self, x: &'a Vectors, margin: f64) -> impl Iterator<Item = NearLimit> + 'a {
        (0_u32..).zip(&self.cells).filter_map(move |(index, cell)| {
            let (volume, normal) = cell.volume(x.get(cell.apex as usize), cell.base.map(|i| x.get(i as usize)));
            let (area, rest) = (normal.length(), cell.rest / cell.area);
            let is_near = volume * cell.rest.signum() < (self.fraction + margin) * rest.abs() * area;
            (is_near && area >= COLLAPSED_AREA_THRESHOLD * cell.area).then(|| NearLimit {
                index,
                apex: cell.apex,
                corners: cell.base,
                is_square: cell.is_square,
                normal: normal * (cell.rest.signum() / area),
                least_height: self.fraction * rest.abs(),
            })
        })
    }

    /// Smallest height of a node above its cell at `x` (m), as a fraction of the rest height; 1 for
    /// a single layer.
    pub fn lowest(&self, x: &Vectors) -> f64 {
        let height = |c: &LimitedCell| c.volume(x.get(c.apex as usize), c.base.map(|i| x.get(i as usize))).0 / c.rest;
        self.cells.iter().map(height).fold(1.0, f64::min)
    }
}

impl LimitedCell {
    /// C (m³) and N (m²) at the given positions.
    #[inline(always)]
    fn volume(&self, apex: DVec3, [a, b, c, d]: [DVec3; 4]) -> (f64, DVec3) {
        let (mean, normal) = if self.is_square {
            ((a + b + c + d) / 4.0, (c - a).cross(d - b))
        } else {
            ((a + b + c) / 3.0, (b - a).cross(c - a))
        };
        ((apex - mean).dot(normal), normal)
    }

    /// Gradients of C with respect to the corners, m².
    #[inline(always)]
    fn gradients(&self, apex: DVec3, [a, b, c, d]: [DVec3; 4], normal: DVec3) -> [DVec3; 4] {
        if self.is_square {
            let w = apex - (a + b + c + d) / 4.0;
            let (over_c, over_d) = ((d - b).cross(w), w.cross(c - a));
            let share = normal / 4.0;
            [-over_c - share, -over_d - share, over_c - share, over_d - share]
        } else {
            let w = apex - (a + b + c) / 3.0;
            let (over_b, over_c) = ((c - a).cross(w), w.cross(b - a));
            let share = normal / 3.0;
            [-over_b - over_c - share, over_b - share, over_c - share, DVec3::ZERO]
        }
    }

    fn limit(&self, keep: f64, x: &Vectors, v: &mut Vectors, inverse_mass: &[f64], fixed: &[bool], dt: f64) {
        let apex = self.apex as usize;
        // Arrays and plain loops: whether chained iterators are inlined depends on the codegen
        // units.
        let [a, b, c, d] = self.base;
        let base = [a as usize, b as usize, c as usize, d as usize];
        let (place, corners) = (x.get(apex), [x.get(base[0]), x.get(base[1]), x.get(base[2]), x.get(base[3])]);
        let (volume, normal) = self.volume(place, corners);
        if normal.length() < COLLAPSED_AREA_THRESHOLD * self.area {
            return;
        }
        // The sign of the rest volume makes the expression independent of the orientation of the
        // cell.
        let missing = (keep * self.rest - volume) * self.rest.signum();
        let gradients = self.gradients(place, corners, normal);
        let masses = [apex, base[0], base[1], base[2], base[3]];
        let gradients = [normal, gradients[0], gradients[1], gradients[2], gradients[3]];
        let mut rate = 0.0;
        for (i, g) in masses.iter().zip(&gradients) {
            rate += g.dot(v.get(*i));
        }
        rate *= self.rest.signum();
        let wanted = if missing > 0.0 {
            (RECOVERY_FRACTION * missing / dt).min(MAXIMUM_RECOVERY_RATE * self.rest.abs())
        } else {
            missing / dt
        };
        if rate >= wanted {
            return;
        }
        let free = |i: usize| if fixed[i] { 0.0 } else { inverse_mass[i] };
        let mut weight = 0.0;
        for (i, g) in masses.iter().zip(&gradients) {
            weight += free(*i) * g.length_squared();
        }
        if weight <= f64::MIN_POSITIVE {
            return;
        }
        let impulse = (wanted - rate) / weight * self.rest.signum();
        for (i, g) in masses.iter().zip(&gradients) {
            v.add(*i, *g * (impulse * free(*i)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(corners: usize) -> (ThicknessLimit, Vectors, Vectors) {
        let base = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::new(1.1, 0.1, 0.9)];
        let mut places = base[..corners].to_vec();
        places.push(DVec3::new(0.4, 0.8, 0.3));
        let mut limit = ThicknessLimit::new(0.5);
        limit.add(corners as u32, &[0, 1, 2, 3][..corners], &places);
        let (mut x, mut v) = (Vectors::default(), Vectors::default());
        for (i, p) in places.iter().enumerate() {
            x.push(*p * DVec3::new(1.0, 0.4, 1.0));
            v.push(DVec3::new(0.1 * i as f64, if i == corners { -3.0 } else { 0.2 }, 0.3));
        }
        (limit, x, v)
    }

    #[test]
    fn momentum_and_angular_momentum_are_conserved() {
        for corners in [3, 4] {
            let (limit, x, mut v) = cell(corners);
            let masses: Vec<f64> = (0..=corners).map(|i| 1.0 + i as f64).collect();
            let inverse: Vec<f64> = masses.iter().map(|m| 1.0 / m).collect();
            let sums = |v: &Vectors| {
                let p: DVec3 = masses.iter().enumerate().map(|(i, m)| v.get(i) * *m).sum();
                let l: DVec3 = masses.iter().enumerate().map(|(i, m)| x.get(i).cross(v.get(i)) * *m).sum();
                (p, l)
            };
            let before = sums(&v);
            limit.apply(&x, &mut v, &inverse, &vec![false; corners + 1], 0.01);
            let after = sums(&v);
            assert!(before.0.distance(after.0) < 1e-13 && before.1.distance(after.1) < 1e-13);
        }
    }

    #[test]
    fn a_compressed_node_returns_without_overshoot() {
        for corners in [3, 4] {
            let (limit, mut x, mut v) = cell(corners);
            assert!(limit.lowest(&x) < 0.45);
            for _ in 0..100 {
                limit.apply(&x, &mut v, &vec![1.0; corners + 1], &vec![false; corners + 1], 0.01);
                x.add_scaled(0.01, &v);
            }
            assert!(limit.lowest(&x) > 0.49, "{corners} corners: {}", limit.lowest(&x));
        }
    }

    #[test]
    fn a_node_far_above_its_cell_is_not_changed() {
        let (limit, _, _) = cell(3);
        let mut x = Vectors::default();
        [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::new(0.4, 0.8, 0.3)].into_iter().for_each(|p| x.push(p));
        let mut v = Vectors::zeros(4);
        v.set(3, DVec3::new(0.0, -1.0, 0.0));
        let before = v.clone();
        limit.apply(&x, &mut v, &[1.0; 4], &[false; 4], 0.01);
        assert_eq!(v, before);
    }
}
