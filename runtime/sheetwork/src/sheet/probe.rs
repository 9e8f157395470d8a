//! Named material points: where a given (u, v) of the bottom layer is now.

use glam::DVec3;

use crate::math::Vectors;

/// A point of the bottom layer, as three masses and weights that sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Name in reports.
    pub name: String,
    masses: [u32; 3],
    weights: [f64; 3],
}

impl Probe {
    /// The probe at (u, v), each 0 to 1, of the layer that these triangles cover and whose first mass is `first`; outside the triangles of a zigzag edge it is extrapolated from the nearest one.
    pub fn new(name: &str, (u, v): (f64, f64), first: u32, triangles: &[[u32; 3]], uv: &[(f64, f64)]) -> Self {
        let mut best = Self { name: name.to_owned(), masses: [first; 3], weights: [1.0, 0.0, 0.0] };
        let mut best_slack = f64::NEG_INFINITY;
        for masses in triangles {
            let [a, b, c] = masses.map(|i| uv[i as usize]);
            let area = (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1);
            let wb = ((u - a.0) * (c.1 - a.1) - (c.0 - a.0) * (v - a.1)) / area;
            let wc = ((b.0 - a.0) * (v - a.1) - (u - a.0) * (b.1 - a.1)) / area;
            let weights = [1.0 - wb - wc, wb, wc];
            let slack = weights.iter().copied().fold(f64::INFINITY, f64::min);
            if slack > best_slack {
                best_slack = slack;
                best.masses = *masses;
                best.weights = weights;
            }
            if slack >= 0.0 {
                break;
            }
        }
        best
    }

    /// Its masses and their weights.
    pub(crate) fn terms(&self) -> ([u32; 3], [f64; 3]) {
        (self.masses, self.weights)
    }

    /// Its value of a quantity given per mass: with positions, where it is (m).
    pub fn of(&self, field: &Vectors) -> DVec3 {
        self.masses.iter().zip(&self.weights).map(|(i, w)| field.get(*i as usize) * *w).sum()
    }
}
