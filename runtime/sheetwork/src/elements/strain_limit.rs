//! Strain limit of the springs between neighbouring nodes: Provot 1995, proposed as spring
//! retention in thesis 6.4.
//!
//! After a step, each spring longer than (1 + s) or shorter than (1 - s) times its rest length
//! moves to that bound. Its two ends move along it in proportion to their inverse masses, and their
//! velocities change by the displacement over the time step. Both changes are equal and opposite
//! along the spring, so linear and angular momentum are conserved to rounding.

use crate::math::Vectors;

/// Maximum Gauss-Seidel iterations over all springs per step: moving one spring may stretch the
/// next.
const ITERATIONS: usize = 24;

/// Two nodes and their rest distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitedSpring {
    /// Nodes.
    pub ends: [u32; 2],
    /// Rest distance, m.
    pub rest: f64,
}

/// Strain limit of all springs of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrainLimit {
    joints: Vec<LimitedSpring>,
}

impl StrainLimit {
    /// Limit of `joints`; joints of zero rest length are dropped.
    pub fn new(joints: impl Iterator<Item = LimitedSpring>) -> Self {
        Self { joints: joints.filter(|j| j.rest > 0.0).collect() }
    }

    /// The limited springs.
    pub fn joints(&self) -> &[LimitedSpring] {
        &self.joints
    }

    /// Applies the limit `most` (strain) after a step of `dt` s; `inverse_mass` (1/kg) is 0 for
    /// fixed nodes. Returns whether any node moved.
    pub fn apply(&self, most: f64, x: &mut Vectors, v: &mut Vectors, inverse_mass: &[f64], dt: f64) -> bool {
        let mut any = false;
        for _ in 0..ITERATIONS {
            let mut moved = false;
            for joint in &self.joints {
                moved |= joint.limit(most, x, v, inverse_mass, dt);
            }
            any |= moved;
            if !moved {
                break;
            }
        }
        any
    }
}

/// Largest absolute strain of `joints` at `x` (m); infinite for non-finite positions.
pub fn largest_strain(joints: impl Iterator<Item = LimitedSpring>, x: &Vectors) -> f64 {
    joints
        .filter(|j| j.rest > 0.0)
        .map(|j| j.strain(x).abs())
        .map(|s| if s.is_nan() { f64::INFINITY } else { s })
        .fold(0.0, f64::max)
}

impl LimitedSpring {
    fn strain(&self, x: &Vectors) -> f64 {
        let [a, b] = self.ends.map(|i| x.get(i as usize));
        a.distance(b) / self.rest - 1.0
    }

    fn limit(&self, most: f64, x: &mut Vectors, v: &mut Vectors, inverse_mass: &[f64], dt: f64) -> bool {
        let [a, b] = self.ends.map(|i| i as usize);
        let along = x.get(b) - x.get(a);
        let length = along.length();
        let wanted = length.max((1.0 - most) * self.rest).min((1.0 + most) * self.rest);
        let weight = inverse_mass[a] + inverse_mass[b];
        // Coincident nodes have no direction.
        if wanted == length || weight <= 0.0 || length <= 0.0 {
            return false;
        }
        let shift = along * ((length - wanted) / (length * weight));
        for (i, shift) in [(a, shift * inverse_mass[a]), (b, -shift * inverse_mass[b])] {
            x.add(i, shift);
            v.add(i, shift / dt);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_limit_conserves_momentum_and_holds_after_iteration() {
        let (mut x, mut v) = (Vectors::default(), Vectors::default());
        for (p, u) in [(0.0, 0.3), (1.6, -0.2), (2.1, 0.7), (3.9, 0.1)] {
            x.push(DVec3::new(p, 0.1 * p * p, 0.0));
            v.push(DVec3::new(0.1, u, -u));
        }
        let limit = StrainLimit::new((0..3).map(|i| LimitedSpring { ends: [i, i + 1], rest: 1.0 }));
        let mass = [1.0, 2.0, 0.5, 3.0];
        let inverse = mass.map(|m| 1.0 / m);
        let sums = |x: &Vectors, v: &Vectors| {
            let p: DVec3 = (0..4).map(|i| v.get(i) * mass[i]).sum();
            let centre: DVec3 = (0..4).map(|i| x.get(i) * mass[i]).sum();
            (p, centre)
        };
        let before = sums(&x, &v);
        assert!(largest_strain(limit.joints().iter().copied(), &x) > 0.5);
        for _ in 0..20 {
            limit.apply(0.1, &mut x, &mut v, &inverse, 0.01);
        }
        let after = sums(&x, &v);
        assert!(before.0.distance(after.0) < 1e-11 && before.1.distance(after.1) < 1e-12);
        assert!(
            largest_strain(limit.joints().iter().copied(), &x) < 0.1 + 1e-6,
            "{}",
            largest_strain(limit.joints().iter().copied(), &x)
        );
        assert!(!limit.apply(0.2, &mut x, &mut v, &inverse, 0.01), "nothing left to do");
    }

    #[test]
    fn a_nan_position_gives_infinite_strain() {
        let mut x = Vectors::zeros(2);
        x.set(1, DVec3::new(f64::NAN, 0.0, 0.0));
        let limit = StrainLimit::new(std::iter::once(LimitedSpring { ends: [0, 1], rest: 1.0 }));
        assert_eq!(largest_strain(limit.joints().iter().copied(), &x), f64::INFINITY);
    }
}
