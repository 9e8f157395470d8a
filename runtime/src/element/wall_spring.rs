//! Springs from a mass to a fixed place: what a clamp leaves of the springs of a lattice that it cuts.
//!
//! As [`super::mixed_spring`], with one end that does not move.

use glam::DVec3;

use super::{Anchor, Element, Geometric, Law, NO_BLOCK, add_block};
use crate::sheet::Vectors;

/// One spring.
#[derive(Clone, Copy, Debug)]
struct Spring {
    mass: usize,
    block: u32,
    point: DVec3,
    rest: f64,
    /// Stiffness per unit of bending stiffness, 1/m².
    per_bending: f64,
    stiffness: f64,
    dashpot: f64,
    /// N*, N.
    force: f64,
    anchor: f64,
    rate: f64,
}

/// All springs of a sheet that end at walls.
#[derive(Clone, Debug, Default)]
pub struct WallSprings {
    springs: Vec<Spring>,
    per_time: f64,
}

impl WallSprings {
    /// Springs (mass, fixed end in m, rest length in m, stiffness in N/m) of a sheet whose bending stiffness along its length is
    /// `bending` (N m): their own goes with that.
    pub fn new(springs: impl Iterator<Item = (u32, DVec3, f64, f64)>, bending: f64) -> Self {
        let each = springs.map(|(mass, point, rest, stiffness)| Spring {
            mass: mass as usize,
            block: NO_BLOCK,
            point,
            rest,
            per_bending: stiffness / bending,
            stiffness,
            dashpot: 0.0,
            force: 0.0,
            anchor: 0.0,
            rate: 0.0,
        });
        Self { springs: each.collect(), per_time: 0.0 }
    }
}

impl Spring {
    #[inline(always)]
    fn along(&self, x: &Vectors) -> (DVec3, f64) {
        let d = x.get(self.mass) - self.point;
        (d, d.length())
    }

    #[inline(always)]
    fn force_at(&self, length: f64, per_time: f64) -> f64 {
        self.stiffness * (length - self.rest) + self.dashpot * per_time * (length - self.anchor)
    }
}

impl Element for WallSprings {
    fn couples(&self, _visit: &mut dyn FnMut(u32, u32)) {}

    fn bind(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for s in &mut self.springs {
            s.block = block(s.mass as u32, s.mass as u32);
        }
    }

    fn set_law(&mut self, law: &Law) {
        for s in &mut self.springs {
            s.stiffness = s.per_bending * law.bending[0][0];
            s.dashpot = s.stiffness * law.retardation;
        }
    }

    fn energy(&self, x: &Vectors) -> f64 {
        self.springs.iter().map(|s| 0.5 * s.stiffness * (s.along(x).1 - s.rest).powi(2)).sum()
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let n = d / length;
                let pull = s.stiffness * (length - s.rest) + s.dashpot * v.get(s.mass).dot(n);
                force.set(s.mass, force.get(s.mass) - n * pull);
            }
        }
    }

    fn begin(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.per_time = per_time;
        for s in self.springs.iter_mut().filter(|s| s.dashpot > 0.0) {
            s.anchor = follow * s.rate + anchors.iter().map(|a| a.weight * s.along(a.x).1).sum::<f64>();
        }
    }

    fn finish(&mut self, x: &Vectors) {
        let per_time = self.per_time;
        for s in self.springs.iter_mut().filter(|s| s.dashpot > 0.0) {
            s.rate = (s.along(x).1 - s.anchor) * per_time;
        }
    }

    fn forget(&mut self) {
        self.springs.iter_mut().for_each(|s| s.rate = 0.0);
    }

    fn potential(&self, x: &Vectors) -> f64 {
        let each = self.springs.iter().map(|s| {
            let length = s.along(x).1;
            let (stretch, change) = (length - s.rest, length - s.anchor);
            0.5 * s.stiffness * stretch * stretch + 0.5 * s.dashpot * self.per_time * change * change
        });
        each.sum()
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let pull = d * (s.force_at(length, self.per_time) / length);
                gradient.set(s.mass, gradient.get(s.mass) + pull);
            }
        }
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length <= 0.0 {
                continue;
            }
            let n = (d / length).to_array();
            let across = if geometric == Geometric::Clipped { s.force.max(0.0) } else { s.force } / length;
            let along = s.stiffness + s.dashpot * self.per_time - across;
            let mut block = [0.0; 9];
            for r in 0..3 {
                for c in 0..3 {
                    block[3 * r + c] = along * n[r] * n[c];
                }
                block[4 * r] += across;
            }
            add_block(values, s.block, &block);
        }
    }

    fn predict(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        let mut missed = 0.0;
        for s in &mut self.springs {
            let (along, length) = s.along(x);
            if length > 0.0 {
                let change = d.get(s.mass);
                let predicted = length + along.dot(change) / length;
                s.force = s.force_at(predicted, self.per_time);
                let miss = (along + change).length() - predicted;
                missed += 0.5 * (s.stiffness + s.dashpot * self.per_time) * miss * miss;
            }
        }
        missed
    }

    fn settle(&mut self, x: &Vectors) {
        for s in &mut self.springs {
            s.force = s.force_at(s.along(x).1, self.per_time);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::*;

    #[test]
    fn gradient_and_tangent_are_those_of_the_potential() {
        let x = check::bent_grid(3, 2, (0.1, 0.15));
        let ends = [(0, DVec3::new(-0.1, 0.0, 0.0), 0.2, 3.0), (4, DVec3::new(0.0, 0.3, 0.1), 0.1, 2.0)];
        let mut springs = WallSprings::new(ends.into_iter(), 1.0);
        springs.set_law(&check::law());
        check::derivatives(&mut springs, &x, 1e-6);
    }
}
