//! Grab: a spring between a material point of the sheet and a target point.
//!
//! The material point is a weighted sum p = Σ w_i x_i of three nodes. The spring has zero rest
//! length and no dashpot: energy ½ k |p - t|² (J), force on node i -w_i k (p - t) (N), tangent
//! between nodes i and j w_i w_j k times the identity (N/m), independent of position. As part of
//! the implicit stages it is stable for any stiffness.

use glam::DVec3;

use crate::elements::{Element, NO_BLOCK, add_block};
use crate::math::Vectors;
use crate::serialize::{ReadResult, StateReader, StateWriter};

/// Pairs of the three nodes with a matrix block, larger index first.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// One grab spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrabSpring {
    /// Nodes, smallest index first.
    masses: [u32; 3],
    /// Weights, with sum 1. The last entry of a repeated node has its whole weight, the others
    /// zero.
    weights: [f64; 3],
    /// Target point, m.
    pub target: DVec3,
    /// Stiffness, N/m.
    pub stiffness: f64,
    blocks: [u32; 6],
}

impl GrabSpring {
    /// Grab of the point with these nodes and weights towards `target` (m) with `stiffness` (N/m).
    pub fn new(masses: [u32; 3], weights: [f64; 3], target: DVec3, stiffness: f64) -> Self {
        let mut terms = [(masses[0], weights[0]), (masses[1], weights[1]), (masses[2], weights[2])];
        terms.sort_unstable_by_key(|t| t.0);
        for i in 1..3 {
            if terms[i].0 == terms[i - 1].0 {
                terms[i].1 += terms[i - 1].1;
                terms[i - 1].1 = 0.0;
            }
        }
        let (masses, weights) = (terms.map(|t| t.0), terms.map(|t| t.1));
        Self { masses, weights, target, stiffness, blocks: [NO_BLOCK; 6] }
    }

    /// Serialises the grab.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        self.masses.iter().for_each(|m| to.count(u64::from(*m)));
        to.numbers(&self.weights);
        to.vector(self.target);
        to.number(self.stiffness);
    }

    /// Deserialises a grab of a sheet with `masses` nodes.
    pub(crate) fn deserialise(from: &mut StateReader, masses: usize) -> ReadResult<Self> {
        let at = [from.index(masses)?, from.index(masses)?, from.index(masses)?];
        let weights = [from.number()?, from.number()?, from.number()?];
        Ok(Self::new(at, weights, from.vector()?, from.number()?))
    }

    /// Whether the material point and the stiffness are equal, whatever the target.
    pub(crate) fn is_same_grab(&self, other: &Self) -> bool {
        (self.masses, self.weights, self.stiffness) == (other.masses, other.weights, other.stiffness)
    }

    /// The material point at positions `x`, m.
    pub fn point(&self, x: &Vectors) -> DVec3 {
        self.masses.iter().zip(self.weights).map(|(m, w)| x.get(*m as usize) * w).sum()
    }

    /// Material coordinates (u, v) of the point; `uv` are those of the nodes.
    pub(crate) fn material_point(&self, uv: &[(f64, f64)]) -> (f64, f64) {
        let each = self.masses.iter().zip(self.weights);
        each.fold((0.0, 0.0), |(u, v), (m, w)| (u + w * uv[*m as usize].0, v + w * uv[*m as usize].1))
    }

    /// Force on the sheet at positions `x` (m), N; the hand feels the opposite force.
    pub fn force(&self, x: &Vectors) -> DVec3 {
        (self.target - self.point(x)) * self.stiffness
    }

    /// Nodes and weights of the terms with non-zero weight.
    fn terms(&self) -> impl Iterator<Item = (usize, f64)> {
        self.masses.into_iter().map(|m| m as usize).zip(self.weights).filter(|t| t.1 != 0.0)
    }
}

impl Element for GrabSpring {
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        for (i, j) in PAIRS.into_iter().filter(|(i, j)| i != j) {
            if self.weights[i] != 0.0 && self.weights[j] != 0.0 {
                visit(self.masses[i], self.masses[j]);
            }
        }
    }

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for (slot, (i, j)) in self.blocks.iter_mut().zip(PAIRS) {
            let counts = self.weights[i] != 0.0 && self.weights[j] != 0.0;
            *slot = if counts { block(self.masses[i], self.masses[j]) } else { NO_BLOCK };
        }
    }

    fn energy(&self, x: &Vectors) -> f64 {
        0.5 * self.stiffness * self.point(x).distance_squared(self.target)
    }

    fn add_forces(&self, x: &Vectors, _v: &Vectors, force: &mut Vectors) {
        let all = self.force(x);
        for (i, w) in self.terms() {
            force.add(i, all * w);
        }
    }

    fn potential(&self, x: &Vectors) -> f64 {
        self.energy(x)
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        let all = self.force(x);
        for (i, w) in self.terms() {
            gradient.set(i, gradient.get(i) - all * w);
        }
    }

    fn add_constant_tangent(&self, _per_time: f64, values: &mut [f64]) {
        for (slot, (i, j)) in self.blocks.iter().zip(PAIRS) {
            let k = self.weights[i] * self.weights[j] * self.stiffness;
            add_block(values, *slot, &[k, 0.0, 0.0, 0.0, k, 0.0, 0.0, 0.0, k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::derivative_check;

    #[test]
    fn gradient_and_tangent_are_the_derivatives_of_the_energy() {
        let x = derivative_check::bent_grid(3, 2, (0.1, 0.2));
        let cases = [([4, 1, 3], [0.2, 0.5, 0.3]), ([2, 2, 0], [0.25, 0.25, 0.5]), ([1, 1, 1], [1.0, 0.0, 0.0])];
        for (masses, weights) in cases {
            let mut pull = GrabSpring::new(masses, weights, DVec3::new(0.3, -0.2, 0.7), 40.0);
            let point: DVec3 = (0..3).map(|i| x.get(masses[i] as usize) * weights[i]).sum();
            assert!(pull.point(&x).distance(point) < 1e-15);
            assert!(pull.force(&x).distance((pull.target - point) * 40.0) < 1e-12);
            derivative_check::derivatives(&mut pull, &x, 1e-6);
        }
    }
}
