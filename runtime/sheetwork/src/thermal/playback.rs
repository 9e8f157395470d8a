//! Temperatures of a recording on a sheet, for display only.

use crate::error::{InputError, check_range};
use crate::sheet::Sheet;
use crate::units::temperature::{COLDEST, HOTTEST, REFERENCE};
use crate::world::recording::Warmth;

/// Minimum remaining stiffness: a recording can round it to zero.
const LEAST: f64 = 1e-6;

impl Warmth {
    /// Check the ranges of the values.
    ///
    /// # Errors
    /// When one is out of range.
    pub(crate) fn check(&self) -> Result<(), InputError> {
        let (name, low, high, unit) = match self {
            Self::Stiffness(_) => ("stiffness", 0.0, 1.0, ""),
            _ => ("temperature", COLDEST, HOTTEST, "°C"),
        };
        // Rounding can exceed the ends of the range slightly.
        self.values().iter().try_for_each(|v| check_range(name, f64::from(*v), low - 0.1, high + 0.1, unit))
    }
}

impl Sheet {
    /// Set recorded temperatures, which must be in range. Without effect when the number of values
    /// does not fit.
    pub(crate) fn show_warmth(&mut self, warmth: &Warmth) {
        let n = self.masses();
        if warmth.values().len() != warmth.count(n) || *warmth == Warmth::Unknown {
            return;
        }
        self.begin_heat(REFERENCE);
        let Some(mut heat) = self.heat.take() else { return };
        let two = heat.halves().is_some();
        let celsius = |t: f32| f64::from(t).clamp(COLDEST, HOTTEST);
        match warmth {
            Warmth::Unknown => {}
            Warmth::Mean(mean) => {
                let sides = if two { 2 } else { 1 };
                heat.set_nodes((0..sides * n).map(|k| celsius(mean[k % n])));
            }
            Warmth::Sides(sides) if two => heat.set_nodes(sides.iter().map(|t| celsius(*t))),
            Warmth::Sides(sides) => heat.set_nodes((0..n).map(|i| celsius(0.5 * (sides[i] + sides[i + n])))),
            Warmth::Stiffness(left) => {
                let room = heat.celsius().first().copied().unwrap_or(REFERENCE);
                heat.set_fractions(room, |i| f64::from(left[i]).clamp(LEAST, 1.0));
            }
        }
        self.heat = Some(heat);
        self.follow_heat();
    }
}
