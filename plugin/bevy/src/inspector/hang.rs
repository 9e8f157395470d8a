//! Droop of a heavy inextensible strip, clamped horizontally at one end.
//!
//! The shape depends on the load parameter Γ = ρ g t L³/D alone; see [`elastica_curve`].

use sheetwork::material::elastica::elastica_curve;
use sheetwork::scene::Material;

/// Integration steps along the strip.
const STEPS: usize = 96;

/// Shape of a hanging strip; lengths are fractions of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Hang {
    /// Load parameter Γ.
    pub gamma: f64,
    /// Vertical distance of the tip below the clamp.
    pub drop: f64,
    /// Horizontal distance of the tip from the clamp.
    pub reach: f64,
    /// Points from the clamp to the tip: (reach, drop).
    pub points: Vec<(f32, f32)>,
}

/// Load parameter Γ of a strip of `material`, `length` m long, under gravity of `gravity` m/s².
pub fn gamma(material: &Material, length: f64, gravity: f64) -> f64 {
    material.areal_mass() * gravity.abs() * length.powi(3) / material.plate_stiffness().max(1e-300)
}

/// Shape of the strip with load parameter Γ.
pub fn hang(gamma: f64) -> Hang {
    let flat = Hang { gamma, drop: 0.0, reach: 1.0, points: vec![(0.0, 0.0), (1.0, 0.0)] };
    if !gamma.is_finite() || gamma < 1e-12 {
        return flat;
    }
    // Above 2e5 the strip is vertical within rounding, and the angle of the tip underflows.
    let gamma = gamma.min(2e5);
    let points = elastica_curve(gamma, STEPS);
    let (reach, drop) = points.last().copied().unwrap_or((1.0, 0.0));
    // Reversed: integration starts at the tip.
    let seen = points.iter().rev().map(|(r, d)| ((reach - r) as f32, (drop - d) as f32));
    Hang { gamma, drop, reach, points: seen.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::material::elastica::elastica;
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
