//! Stiffness of a material against temperature: E(T), as a fraction of E at 20 °C.
//!
//! The default for a polymer with a glass transition Tg (°C) is
//!
//!   E(T)/E(20 °C) = g(T)/g(20 °C),
//!   log₁₀ g(T) = -a (T - Tg)(1 - S) - 3 S,  S = 1/(1 + exp(-(T - Tg)/w)),
//!
//! with a = 0.0015 per kelvin and w = 4.5 K: a glass that loses a third of a percent per kelvin,
//! three decades from glass to rubber (GPa to MPa), of which nine tenths lie within 26 K around Tg,
//! and a plateau above. Amorphous polymers have curves of this shape (Ferry, *Viscoelastic
//! Properties of Polymers*, 1980, chapters 2 and 11); a particular grade may differ. A material may
//! have a table, (°C, fraction of E at 20 °C), with log E linear in between and constant beyond. A
//! material with neither has a constant stiffness.

use crate::scene::Material;
use crate::units::temperature::REFERENCE;

/// Slope of the glass, decades per kelvin.
const GLASS: f64 = 0.0015;
/// Width of the transition, K.
const WIDTH: f64 = 4.5;
/// Difference between glass and rubber, decades.
const DECADES: f64 = 3.0;

/// E(T) of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum Softening {
    /// Constant stiffness.
    Constant,
    /// Glass transition.
    Glass {
        /// Tg, °C.
        transition: f64,
        /// log₁₀ g at 20 °C.
        reference: f64,
    },
    /// Table of temperatures (°C, increasing) and log₁₀ of the fraction.
    Table(Vec<(f64, f64)>),
}

impl Softening {
    /// The curve of `material`.
    pub fn of(material: &Material) -> Self {
        if !material.softening.is_empty() {
            return Self::Table(material.softening.iter().map(|(t, fraction)| (*t, fraction.log10())).collect());
        }
        match material.glass_transition {
            Some(transition) => Self::Glass { transition, reference: glass(REFERENCE - transition) },
            None => Self::Constant,
        }
    }

    /// E(T)/E(20 °C) at `celsius` (°C); above 0.
    pub fn fraction(&self, celsius: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Glass { transition, reference } => tenth_power(glass(celsius - transition) - reference),
            Self::Table(rows) => tenth_power(interpolate(rows, celsius)),
        }
    }
}

fn tenth_power(decades: f64) -> f64 {
    (decades * std::f64::consts::LN_10).exp()
}

/// log₁₀ g at `above` (K) above the glass transition.
fn glass(above: f64) -> f64 {
    let rubber = 1.0 / (1.0 + (-above / WIDTH).exp());
    -GLASS * above * (1.0 - rubber) - DECADES * rubber
}

fn interpolate(rows: &[(f64, f64)], celsius: f64) -> f64 {
    let above = rows.partition_point(|(t, _)| *t <= celsius);
    match (above.checked_sub(1).and_then(|i| rows.get(i)), rows.get(above)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (celsius - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::{LIBRARY, by_name};

    #[test]
    fn a_polymer_falls_slowly_and_then_by_three_decades() {
        let hips = Softening::of(&by_name("hips").expect("there"));
        assert_eq!(hips.fraction(20.0), 1.0);
        assert!((0.6..0.85).contains(&hips.fraction(80.0)), "{}", hips.fraction(80.0));
        assert!(hips.fraction(87.0) / hips.fraction(113.0) > 500.0);
        assert!((3e-4..2e-3).contains(&hips.fraction(140.0)), "{}", hips.fraction(140.0));
        assert!((hips.fraction(200.0) / hips.fraction(150.0) - 1.0).abs() < 0.01);
    }

    #[test]
    fn no_material_stiffens_as_it_warms() {
        for (name, _, material) in LIBRARY {
            let curve = Softening::of(material);
            let all: Vec<f64> = (-250..400).map(|t| curve.fraction(f64::from(t))).collect();
            assert!(all.windows(2).all(|w| w[1] <= w[0] && w[1] > 0.0), "{name}");
        }
    }

    #[test]
    fn a_table_is_followed_in_decades_and_held_beyond_its_ends() {
        let material = Material { softening: vec![(0.0, 2.0), (100.0, 0.02)], ..Material::default() };
        let curve = Softening::of(&material);
        for (celsius, wanted) in [(-50.0, 2.0), (0.0, 2.0), (50.0, 0.2), (100.0, 0.02), (900.0, 0.02)] {
            assert!((curve.fraction(celsius) / wanted - 1.0).abs() < 1e-12, "{celsius}");
        }
    }
}
