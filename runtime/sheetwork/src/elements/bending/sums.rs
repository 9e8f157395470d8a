//! Sums over the groups of a shell's bending: the energy ½ Σ S (κ - κ₀)ᵀ D (κ - κ₀) (J) and its
//! gradient, at one instant and within a stage.
//!
//! Each function is compiled with and without κ₀, so that a sheet without rest curvature does no
//! work for it.

use glam::DVec3;

use crate::elements::bending::{Bending, Pair, along, axes, normal, normal_and_rate, times, times_scalar};
use crate::elements::curvature::dot;
use crate::math::Vectors;

impl Bending {
    /// Subtracts κ₀ of group `i` from its curvatures `k`.
    #[inline(always)]
    pub(crate) fn less_rest<const REST: bool>(&self, i: usize, k: &mut [DVec3; 3], x: &Vectors) {
        if REST {
            let rest = &self.rest[i];
            // Most groups with a thermal history have zero κ₀.
            if *rest == [DVec3::ZERO; 3] {
                return;
            }
            let [p, n, q] = axes(&self.groups[i], x);
            for (k, rest) in k.iter_mut().zip(rest) {
                *k -= p * rest.x + n * rest.y + q * rest.z;
            }
        }
    }

    /// Energy at positions `x` (m), J.
    pub(crate) fn stored_energy<const REST: bool>(&self, x: &Vectors) -> f64 {
        let each = self.groups.iter().enumerate().map(|(i, g)| {
            let mut k = self.curvature(g, x, &g.prescribed);
            self.less_rest::<REST>(i, &mut k, x);
            let m = times(&g.stiffness, &k);
            0.5 * (k[0].dot(m[0]) + k[1].dot(m[1]) + k[2].dot(m[2]))
        });
        each.sum()
    }

    /// Energy of the arms of a flat loss factor, J.
    pub(crate) fn arm_energy(&self) -> f64 {
        let one = |i: usize, strain: &dyn Fn(usize) -> f64| {
            let s = [strain(3 * i), strain(3 * i + 1), strain(3 * i + 2)];
            0.5 * dot(&s, &times_scalar(&self.groups[i].stiffness, &s))
        };
        self.arms.energy(|strain| (0..self.groups.len()).map(|i| one(i, strain)).sum())
    }

    /// Adds the forces (N) at `x` (m), with damping at velocities `v` (m/s).
    pub(crate) fn forces<const REST: bool>(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        for (i, g) in self.groups.iter().enumerate() {
            let mut k = self.curvature(g, x, &g.prescribed);
            if self.retardation > 0.0 {
                let (n, turning) = normal_and_rate(g, x, v);
                let rate = self.curvature(g, v, &[DVec3::ZERO; 3]);
                // k̇ = κ̇·n + κ·ṅ, consistent with the stages, which difference k.
                let rate = [0, 1, 2].map(|a| rate[a].dot(n) + k[a].dot(turning));
                for a in 0..3 {
                    k[a] += n * (rate[a] * self.retardation);
                }
            }
            if !self.arms.is_empty() {
                let (n, mut held) = (normal(g, x), [0.0; 3]);
                self.arms.add_strain(3 * i, &mut held);
                (0..3).for_each(|a| k[a] += n * held[a]);
            }
            self.less_rest::<REST>(i, &mut k, x);
            self.add_moments(g, &times(&g.stiffness, &k), -1.0, force);
        }
    }

    /// Elastic energy and viscous potential of the stage at `x` (m), J.
    pub(crate) fn staged<const REST: bool>(&self, x: &Vectors) -> f64 {
        let mut sum = 0.0;
        for (i, g) in self.groups.iter().enumerate() {
            let whole = self.curvature(g, x, &g.prescribed);
            let mut k = whole;
            self.less_rest::<REST>(i, &mut k, x);
            let m = times(&g.stiffness, &k);
            sum += 0.5 * (k[0].dot(m[0]) + k[1].dot(m[1]) + k[2].dot(m[2]));
            if self.viscous > 0.0 {
                let k = along(&whole, normal(g, x));
                let change = [k[0] - g.anchor[0], k[1] - g.anchor[1], k[2] - g.anchor[2]];
                let m = times_scalar(&g.stiffness, &change);
                sum += 0.5 * self.viscous * (change[0] * m[0] + change[1] * m[1] + change[2] * m[2]);
            }
        }
        sum
    }

    /// Adds the gradient of [`Bending::staged`], N.
    pub(crate) fn gradient<const REST: bool>(&self, x: &Vectors, gradient: &mut Vectors) {
        for (i, g) in self.groups.iter().enumerate() {
            let mut k = self.curvature(g, x, &g.prescribed);
            if self.viscous > 0.0 {
                let n = normal(g, x);
                let scalar = along(&k, n);
                for a in 0..3 {
                    k[a] += n * (self.viscous * (scalar[a] - g.anchor[a]));
                }
            }
            self.less_rest::<REST>(i, &mut k, x);
            self.add_moments(g, &times(&g.stiffness, &k), 1.0, gradient);
        }
    }

    /// Sums the contributions of all groups to each block. The matrix is symmetric: a block of two
    /// nodes appears once.
    pub(crate) fn sum_constant(&mut self) {
        self.constant.clear();
        for i in &self.order {
            let Pair { block, value, .. } = self.pairs[*i as usize];
            if value == 0.0 {
                continue;
            }
            match self.constant.last_mut() {
                Some((last, sum)) if *last == block => *sum += value,
                _ => self.constant.push((block, value)),
            }
        }
    }
}
