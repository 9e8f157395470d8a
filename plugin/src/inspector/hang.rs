//! How far a strip would hang: the shape of a heavy strip that is clamped level at one end.
//!
//! The strip is thin and does not stretch: θ'' = -Γ (1 - s) cos θ, θ(0) = 0, θ'(1) = 0, with the one number Γ = ρ g t L³/D. It is integrated
//! from the tip on, as [`sheetwork::measure::reference::elastica`] does, whose drop and reach it has; here the points in between are kept, to draw it.

use std::f64::consts::FRAC_PI_2;

use sheetwork::scene::Material;

/// Steps along the strip.
const STEPS: usize = 96;

/// A hanging strip; lengths are fractions of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Hang {
    /// Γ.
    pub gamma: f64,
    /// How far the tip is below the clamp.
    pub drop: f64,
    /// How far it is from it, level.
    pub reach: f64,
    /// Points from the clamp to the tip: (reach, drop).
    pub points: Vec<(f32, f32)>,
}

/// Γ of a strip of `material`, `length` m long, under gravity of `gravity` m/s².
pub fn gamma(material: &Material, length: f64, gravity: f64) -> f64 {
    material.areal_mass() * gravity.abs() * length.powi(3) / material.plate_stiffness().max(1e-300)
}

/// The strip of this Γ.
pub fn hang(gamma: f64) -> Hang {
    let flat = Hang { gamma, drop: 0.0, reach: 1.0, points: vec![(0.0, 0.0), (1.0, 0.0)] };
    if !gamma.is_finite() || gamma < 1e-12 {
        return flat;
    }
    // Beyond this it hangs plumb but for a hair, and the tip's angle has no place in a number.
    let gamma = gamma.min(2e5);
    let (mut low, mut high) = (f64::MIN_POSITIVE, FRAC_PI_2);
    for _ in 0..200 {
        // The angle at the tip may be as small as e^(-⅔√Γ): halved in its logarithm while it is small.
        let middle = if high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
        if run(gamma, middle, &mut |_, _| ()) < FRAC_PI_2 {
            low = middle;
        } else {
            high = middle;
        }
        if high / low < 1.0 + 1e-13 {
            break;
        }
    }
    let mut points = Vec::with_capacity(STEPS + 1);
    run(gamma, 0.5 * (low + high), &mut |reach, drop| points.push((reach, drop)));
    let (reach, drop) = points.last().copied().unwrap_or((1.0, 0.0));
    // From the tip, so seen from the clamp.
    let seen = points.iter().rev().map(|(r, d)| ((reach - r) as f32, (drop - d) as f32));
    Hang { gamma, drop, reach, points: seen.collect() }
}

/// Goes from the tip, which is at the angle `tip` from the plumb line, to the clamp; tells reach and drop so far. The angle there.
fn run(gamma: f64, tip: f64, visit: &mut dyn FnMut(f64, f64)) -> f64 {
    let mut u = [tip, 0.0, 0.0, 0.0];
    let rate = |s: f64, u: [f64; 4]| [u[1], gamma * s * u[0].sin(), u[0].sin(), u[0].cos()];
    let moved = |u: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| u[i] + h * k[i]);
    visit(0.0, 0.0);
    let mut s = 0.0;
    for step in 0..STEPS {
        // Short steps near the clamp, where a long strip bends.
        let next = 1.0 - (1.0 - (step + 1) as f64 / STEPS as f64).powi(2);
        let h = next - s;
        let k1 = rate(s, u);
        let k2 = rate(s + 0.5 * h, moved(u, k1, 0.5 * h));
        let k3 = rate(s + 0.5 * h, moved(u, k2, 0.5 * h));
        let k4 = rate(s + h, moved(u, k3, h));
        for i in 0..4 {
            u[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        if u[0] > FRAC_PI_2 * 1.5 {
            return u[0];
        }
        visit(u[2], u[3]);
        s = next;
    }
    u[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::measure::reference::elastica;
    use sheetwork::scene::material::LIBRARY;

    #[test]
    fn a_strip_hangs_as_the_reference_says() {
        for gamma in [1e-3, 0.1, 1.0, 10.0, 100.0, 1e3] {
            let (drop, reach) = elastica(gamma);
            let found = hang(gamma);
            assert!((found.drop - drop).abs() < 2e-3 && (found.reach - reach).abs() < 2e-3, "{gamma}: {found:?}");
            let ends = (found.points[0], found.points[found.points.len() - 1]);
            assert_eq!(ends.0, (0.0, 0.0));
            assert!((f64::from(ends.1.1) - found.drop).abs() < 1e-6);
        }
    }

    #[test]
    fn every_material_at_every_length_has_a_shape() {
        for (name, _, material) in LIBRARY {
            for length in [1e-3, 0.1, 1.0, 10.0] {
                let found = hang(gamma(material, length, 9.81));
                let fine = (0.0..=1.0).contains(&found.drop) && (-0.01..=1.0).contains(&found.reach);
                assert!(fine && found.points.len() > 1, "{name} at {length} m: {} {}", found.drop, found.reach);
            }
        }
        assert_eq!(hang(0.0).drop, 0.0);
        assert_eq!(hang(f64::NAN).reach, 1.0);
    }
}
