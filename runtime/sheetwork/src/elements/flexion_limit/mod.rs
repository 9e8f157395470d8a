//! Limit of the angle between two springs in line (Provot 1995; thesis 3.4 and 6.2).
//!
//! A triple of nodes (a, b, c) bends at b by θ, the angle between b - a and c - b: cos θ = u₁·u₂
//! with their unit vectors. Where θ exceeds the limit, equal and opposite impulses along the
//! gradient of cos θ stop its growth and return the excess in about 1/`RECOVERY_FRACTION` steps.
//! The gradient sums to zero and has no moment, so linear and angular momentum are conserved to
//! rounding. (The thesis moves the nodes, which does not conserve them.)
//!
//! That is enough in free flight and with implicit integrators. A sheet of an explicit integrator
//! that lies on something or hangs from something has its limit and its contacts solved together
//! (`solver`): one after the other, each would undo the other in every step.

pub mod solver;

use glam::DVec3;

use crate::math::Vectors;

/// Fraction of the excess that one step removes. Small, so that a sheet bent by its weight comes to
/// rest.
const RECOVERY_FRACTION: f64 = 0.2;

/// Gauss-Seidel iterations over all triples per step: neighbouring triples share nodes, so one
/// iteration leaves them inconsistent.
const ITERATIONS: usize = 4;

/// Angle limit of the flexion triples of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct FlexionLimit {
    /// Nodes (a, b, c) in line.
    pub triples: Vec<[u32; 3]>,
    /// Largest angle θ, degrees, 1 to 180.
    pub limit: f64,
}

impl FlexionLimit {
    /// Applies the limit to velocities `v` (m/s) at positions `x` (m) after a step of `dt` s;
    /// `inverse_mass` (1/kg) is 0 for fixed nodes.
    pub fn apply(&self, x: &Vectors, v: &mut Vectors, inverse_mass: &[f64], dt: f64) {
        let floor = self.limit.to_radians().cos();
        for _ in 0..ITERATIONS {
            for triple in &self.triples {
                limit_one(triple.map(|i| i as usize), floor, x, v, inverse_mass, dt);
            }
        }
    }

    /// Whether a triple bends by more than `margin` (rad) below the limit at positions `x` (m).
    pub fn is_near(&self, x: &Vectors, margin: f64) -> bool {
        let floor = (self.limit.to_radians() - margin).max(0.0).cos();
        self.triples.iter().any(|t| bend(t.map(|i| x.get(i as usize))).is_some_and(|b| b.0 < floor))
    }

    /// Largest angle at positions `x` (m), degrees.
    pub fn largest_angle(&self, x: &Vectors) -> f64 {
        let cosines = self.triples.iter().filter_map(|t| bend(t.map(|i| x.get(i as usize))).map(|b| b.0));
        cosines.fold(1.0_f64, f64::min).clamp(-1.0, 1.0).acos().to_degrees()
    }
}

/// cos θ and its gradients (1/m) with respect to a and c; the gradient with respect to b is minus
/// their sum. `None` for a spring of zero length.
fn bend([a, b, c]: [DVec3; 3]) -> Option<(f64, DVec3, DVec3)> {
    let (d1, d2) = (b - a, c - b);
    let (l1, l2) = (d1.length(), d2.length());
    if l1 <= 0.0 || l2 <= 0.0 {
        return None;
    }
    let (u1, u2) = (d1 / l1, d2 / l2);
    let cosine = u1.dot(u2);
    Some((cosine, (u1 * cosine - u2) / l1, (u1 - u2 * cosine) / l2))
}

fn limit_one([a, b, c]: [usize; 3], floor: f64, x: &Vectors, v: &mut Vectors, inverse_mass: &[f64], dt: f64) {
    let Some((cosine, ga, gc)) = bend([x.get(a), x.get(b), x.get(c)]) else { return };
    if cosine >= floor {
        return;
    }
    let gb = -(ga + gc);
    let gradients = [(a, ga), (b, gb), (c, gc)];
    let weight: f64 = gradients.iter().map(|(i, g)| inverse_mass[*i] * g.length_squared()).sum();
    let rate: f64 = gradients.iter().map(|(i, g)| g.dot(v.get(*i))).sum();
    let wanted = RECOVERY_FRACTION * (floor - cosine) / dt;
    // A triple folded flat has no gradient, hence no direction.
    if rate >= wanted || weight <= f64::MIN_POSITIVE {
        return;
    }
    let impulse = (wanted - rate) / weight;
    for (i, g) in gradients {
        v.add(i, g * (impulse * inverse_mass[i]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent() -> (FlexionLimit, Vectors, Vectors) {
        let limit = FlexionLimit { triples: vec![[0, 1, 2]], limit: 20.0 };
        let mut x = Vectors::default();
        let mut v = Vectors::default();
        for (p, u) in [
            (DVec3::new(-1.0, 0.5, 0.0), DVec3::new(0.1, 0.4, 0.2)),
            (DVec3::ZERO, DVec3::new(0.0, -0.8, 0.1)),
            (DVec3::new(1.2, 0.4, 0.3), DVec3::new(-0.2, 0.5, 0.0)),
        ] {
            x.push(p);
            v.push(u);
        }
        (limit, x, v)
    }

    #[test]
    fn momentum_and_angular_momentum_are_conserved() {
        let (limit, x, mut v) = bent();
        let mass = [2.0, 3.0, 5.0];
        let inverse = mass.map(|m| 1.0 / m);
        let sums = |v: &Vectors| {
            let p: DVec3 = (0..3).map(|i| v.get(i) * mass[i]).sum();
            let l: DVec3 = (0..3).map(|i| x.get(i).cross(v.get(i)) * mass[i]).sum();
            (p, l)
        };
        let (p0, l0) = sums(&v);
        limit.apply(&x, &mut v, &inverse, 0.01);
        let (p1, l1) = sums(&v);
        assert!(p0.distance(p1) < 1e-13 && l0.distance(l1) < 1e-13);
    }

    #[test]
    fn a_triple_beyond_the_limit_comes_back_to_it() {
        let (limit, mut x, mut v) = bent();
        let before = limit.largest_angle(&x);
        assert!(before > 40.0);
        for _ in 0..200 {
            limit.apply(&x, &mut v, &[1.0; 3], 0.01);
            x.add_scaled(0.01, &v);
        }
        assert!(limit.largest_angle(&x) < 20.5, "{}", limit.largest_angle(&x));
    }
}
