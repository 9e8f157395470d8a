//! The limit on how far a layered sheet can be squeezed: a mass stays on its side of the layer it stands on.
//!
//! Inter-layer springs lean, so that a mass pushed hard enough snaps through the triangle or square below it and stays
//! there: the layers fall together and the sheet has no thickness left to bend with. A real sheet cannot do that. Here the
//! volume between a mass u and its cell, C = (u - m)·N with m the mean of the cell's corners and N = (b - a)×(c - a) for a
//! triangle, (c - a)×(d - b) for a square, keeps at least a fraction of what it is at rest. Where its rate would take it
//! below that within a step, equal and opposite impulses along its gradient stop it; where it is below, they bring it back
//! over a few steps. C does not change when the whole turns or moves, so linear and angular momentum are kept to rounding.
//! Corners that lie on a body pass the impulse on to it and do not move.

use glam::DVec3;

use crate::sheet::Vectors;

/// Fraction of a missing height that is given back per step, and the most heights that are given back per second: a mass
/// that was pushed far through its cell must not be shot back.
const RECOVERY: f64 = 0.2;
const FASTEST: f64 = 30.0;

/// A mass and the corners of the cell it stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    apex: u32,
    /// Corners; a triangle's fourth is its third again.
    base: [u32; 4],
    square: bool,
    /// C at rest, m³, and the length of N, m².
    rest: f64,
    area: f64,
}

/// A cell shrunk to less than this fraction of its area has no side to speak of, and hardly a gradient to push along.
const COLLAPSED: f64 = 0.3;

/// The limit of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThicknessLimit {
    cells: Vec<Cell>,
    /// Cells of masses that are gone.
    aside: Vec<Cell>,
    /// Fraction of the rest height that is kept, 0 (no limit) to 1.
    pub fraction: f64,
}

impl ThicknessLimit {
    /// No mass limited yet; `fraction` of the rest height is kept.
    pub fn new(fraction: f64) -> Self {
        Self { fraction, ..Self::default() }
    }

    /// Adds a mass over three or four corners, as they lie at rest at `x`; other counts are ignored. Four corners come row
    /// by row: (0, 0), (1, 0), (0, 1), (1, 1).
    pub fn add(&mut self, apex: u32, corners: &[u32], x: &[DVec3]) {
        let base = match corners {
            [a, b, c] => [*a, *b, *c, *c],
            [a, b, d, c] => [*a, *b, *c, *d],
            _ => return,
        };
        let mut cell = Cell { apex, base, square: corners.len() == 4, rest: 0.0, area: 0.0 };
        let (volume, normal) = cell.volume(x[apex as usize], base.map(|i| x[i as usize]));
        (cell.rest, cell.area) = (volume, normal.length());
        // A sheet read from a file may lie collapsed: there is no height to keep then.
        if cell.rest != 0.0 {
            self.cells.push(cell);
        }
    }

    /// Lets be the masses that are `gone`, and no others.
    pub fn open(&mut self, gone: &[bool]) {
        let mut all = std::mem::take(&mut self.cells);
        all.append(&mut self.aside);
        // In the order of their masses, as they were added.
        all.sort_by_key(|c| c.apex);
        (self.aside, self.cells) = all.into_iter().partition(|c| gone[c.apex as usize]);
    }

    /// Applies the limit to velocities `v` at positions `x` before a step of `dt` s. `inverse_mass` is 0 for held masses;
    /// those for which `fixed` holds lie on a body.
    pub fn apply(&self, x: &Vectors, v: &mut Vectors, inverse_mass: &[f64], fixed: &[bool], dt: f64) {
        for cell in &self.cells {
            cell.limit(self.fraction, x, v, inverse_mass, fixed, dt);
        }
    }

    /// Smallest height of a mass over its cell as a fraction of that at rest, where it lies now; 1 for a single layer.
    pub fn lowest(&self, x: &Vectors) -> f64 {
        let height = |c: &Cell| c.volume(x.get(c.apex as usize), c.base.map(|i| x.get(i as usize))).0 / c.rest;
        self.cells.iter().map(height).fold(1.0, f64::min)
    }
}

impl Cell {
    /// C and N at the given places.
    #[inline]
    fn volume(&self, apex: DVec3, [a, b, c, d]: [DVec3; 4]) -> (f64, DVec3) {
        let (mean, normal) = if self.square {
            ((a + b + c + d) / 4.0, (c - a).cross(d - b))
        } else {
            ((a + b + c) / 3.0, (b - a).cross(c - a))
        };
        ((apex - mean).dot(normal), normal)
    }

    /// Gradients of C with respect to the corners.
    #[inline]
    fn gradients(&self, apex: DVec3, [a, b, c, d]: [DVec3; 4], normal: DVec3) -> [DVec3; 4] {
        if self.square {
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
        // Arrays and loops, no iterators of several parts: whether those become plain code hangs on how the crate is cut into units.
        let [a, b, c, d] = self.base;
        let base = [a as usize, b as usize, c as usize, d as usize];
        let (place, corners) = (x.get(apex), [x.get(base[0]), x.get(base[1]), x.get(base[2]), x.get(base[3])]);
        let (volume, normal) = self.volume(place, corners);
        if normal.length() < COLLAPSED * self.area {
            return;
        }
        // Of the sign it has at rest, whichever way the cell is numbered.
        let missing = (keep * self.rest - volume) * self.rest.signum();
        let gradients = self.gradients(place, corners, normal);
        let masses = [apex, base[0], base[1], base[2], base[3]];
        let gradients = [normal, gradients[0], gradients[1], gradients[2], gradients[3]];
        let mut rate = 0.0;
        for (i, g) in masses.iter().zip(&gradients) {
            rate += g.dot(v.get(*i));
        }
        rate *= self.rest.signum();
        let wanted =
            if missing > 0.0 { (RECOVERY * missing / dt).min(FASTEST * self.rest.abs()) } else { missing / dt };
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
            v.set(*i, v.get(*i) + *g * (impulse * free(*i)));
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
    fn momentum_and_angular_momentum_are_kept() {
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
    fn a_squeezed_mass_comes_back_and_does_not_pass() {
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
    fn a_mass_well_above_its_cell_is_left_alone() {
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
