//! Springs of a lattice for the implicit integrators (mixed-stress Newton).
//!
//! The elements of [`crate::elements::spring::Springs`] with tangent blocks and an axial force N*
//! (N) as an unknown of the geometric stiffness. `axial` has the equations of one spring. The
//! tangent block of a spring enters the diagonal blocks of both nodes with a plus sign and the
//! off-diagonal block with a minus sign. A spring of zero length has no direction and is skipped.

use crate::elements::axial::{Axial, axial_methods};
use crate::elements::spring::Springs;
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK, add_block};
use crate::math::Vectors;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};

#[derive(Clone, Copy, Debug)]
struct MixedSpring {
    /// Nodes, the larger index first.
    masses: (u32, u32),
    /// Indices of blocks (a, a), (b, b) and (a, b).
    blocks: [u32; 3],
    axial: Axial,
}

/// All springs of a sheet. [`MixedSprings::update_from`] sets their stiffness, which is that of the
/// present temperature.
#[derive(Clone, Debug, Default)]
pub struct MixedSprings {
    springs: Vec<MixedSpring>,
    per_time: f64,
}

impl MixedSprings {
    /// Springs with the nodes, stiffnesses, rest lengths and dashpots of `springs`.
    pub fn new(springs: &Springs) -> Self {
        let each = (0..springs.len()).map(|i| MixedSpring {
            masses: (springs.a[i].max(springs.b[i]), springs.a[i].min(springs.b[i])),
            blocks: [NO_BLOCK; 3],
            axial: Axial {
                stiffness: springs.stiffness[i],
                rest: springs.rest[i],
                dashpot: springs.damping[i],
                ..Axial::default()
            },
        });
        Self { springs: each.collect(), per_time: 0.0 }
    }

    /// Copies changed stiffnesses, rest lengths and dashpots from `springs`.
    pub fn update_from(&mut self, springs: &Springs) {
        for (i, spring) in self.springs.iter_mut().enumerate() {
            spring.axial.stiffness = springs.stiffness[i];
            spring.axial.rest = springs.rest[i];
            spring.axial.dashpot = springs.damping[i];
        }
    }
}

impl MixedSpring {
    /// Vector from the second node to the first (m), and its length (m).
    #[inline(always)]
    fn along(&self, x: &Vectors) -> (glam::DVec3, f64) {
        let d = x.get(self.masses.0 as usize) - x.get(self.masses.1 as usize);
        (d, d.length())
    }

    /// Change of that vector for the displacement `d` (m).
    #[inline(always)]
    fn change(&self, d: &Vectors) -> glam::DVec3 {
        self.along(d).0
    }
}

impl Element for MixedSprings {
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        self.springs.iter().for_each(|s| visit(s.masses.0, s.masses.1));
    }

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for spring in &mut self.springs {
            let (a, b) = spring.masses;
            spring.blocks = [block(a, a), block(b, b), block(a, b)];
        }
    }

    fn energy(&self, x: &Vectors) -> f64 {
        self.springs.iter().map(|s| s.axial.energy(s.along(x).1)).sum()
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let (a, b) = (s.masses.0 as usize, s.masses.1 as usize);
                let n = d / length;
                let f =
                    n * (s.axial.stiffness * (length - s.axial.rest) + s.axial.dashpot * (v.get(a) - v.get(b)).dot(n));
                force.set(a, force.get(a) - f);
                force.add(b, f);
            }
        }
    }

    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.per_time = per_time;
        for spring in self.springs.iter_mut().filter(|s| s.axial.dashpot > 0.0) {
            spring.axial.anchor = follow * spring.axial.rate;
            for anchor in anchors {
                spring.axial.anchor += anchor.weight * spring.along(anchor.x).1;
            }
        }
    }

    axial_methods!();

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let (a, b) = (s.masses.0 as usize, s.masses.1 as usize);
                let f = d * (s.axial.force_at(length, self.per_time) / length);
                gradient.add(a, f);
                gradient.set(b, gradient.get(b) - f);
            }
        }
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length <= 0.0 {
                continue;
            }
            let block = s.axial.block(d, length, geometric, self.per_time);
            add_block(values, s.blocks[0], &block);
            add_block(values, s.blocks[1], &block);
            add_block(values, s.blocks[2], &block.map(|b| -b));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::derivative_check;
    use crate::elements::spring::Spring;
    use crate::mesh::spring_class::SpringClass;

    #[test]
    fn gradient_and_tangent_are_those_of_the_potential() {
        let class = SpringClass::X;
        let join = |a, b| Spring { a, b, class, stiffness: 3.0, rest: 0.12, damping: 0.05 };
        let springs = Springs::new(&[join(0, 1), join(1, 2), join(5, 0), join(1, 6), join(6, 0), join(2, 8)]);
        let x = derivative_check::bent_grid(5, 3, (0.1, 0.15));
        derivative_check::derivatives(&mut MixedSprings::new(&springs), &x, 1e-6);
    }
}
