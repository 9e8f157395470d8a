//! Probes: named material points (u, v) of the bottom layer.

use glam::DVec3;

use crate::math::Vectors;

/// Point of the bottom layer as a weighted sum of three nodes; the weights sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Name in reports.
    pub name: String,
    masses: [u32; 3],
    weights: [f64; 3],
}

impl Probe {
    /// Create the probe at (u, v), each 0 to 1, of the layer that `triangles` cover, whose first
    /// node is `first` and whose material coordinates are `uv`. Outside the triangles of a zigzag
    /// edge it is extrapolated from the nearest one.
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

    /// Nodes and weights.
    pub(crate) fn terms(&self) -> ([u32; 3], [f64; 3]) {
        (self.masses, self.weights)
    }

    /// Value of a nodal quantity at the probe; its position (m) for positions.
    pub fn at(&self, field: &Vectors) -> DVec3 {
        self.masses.iter().zip(&self.weights).map(|(i, w)| field.get(*i as usize) * *w).sum()
    }
}
