//! Hot and cold spots: initial temperatures of places of a sheet, and heating while a world runs.
//!
//! A spot of radius r sets the temperature around its centre: fully up to r/2, from there with a
//! weight that falls by a smooth step to zero at r. Distances are along the flat sheet. A later
//! spot is applied over an earlier one.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::units::parameters::ParameterId as Id;

/// Hot or cold spot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotSpec {
    /// Centre, (u, v), each 0 to 1.
    pub at: (f64, f64),
    /// Radius, m, 1e-6 to 1e3.
    pub radius: f64,
    /// Temperature, °C, -273.15 to 5000.
    pub temperature: f64,
}

impl SpotSpec {
    /// Check the ranges.
    ///
    /// # Errors
    /// When a value is out of its range.
    pub fn check(&self) -> Result<(), InputError> {
        Id::SpotCentre.check_each("at", [self.at.0, self.at.1])?;
        Id::SpotRadius.check("radius", self.radius)?;
        Id::SpotTemperature.check("temperature", self.temperature)
    }

    /// Weight of the spot's temperature at `distance` (m) from its centre, 0 to 1.
    pub fn weight(&self, distance: f64) -> f64 {
        let s = (2.0 - 2.0 * distance / self.radius).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_is_whole_inside_and_gone_at_its_rim() {
        let spot = SpotSpec { at: (0.5, 0.5), radius: 0.02, temperature: 120.0 };
        assert_eq!((spot.weight(0.0), spot.weight(0.01)), (1.0, 1.0));
        assert!((spot.weight(0.015) - 0.5).abs() < 1e-12);
        assert_eq!((spot.weight(0.02), spot.weight(1.0)), (0.0, 0.0));
        assert!(SpotSpec { radius: 0.0, ..spot }.check().is_err());
        assert!(SpotSpec { at: (1.5, 0.0), ..spot }.check().is_err());
        assert!(SpotSpec { temperature: f64::NAN, ..spot }.check().is_err());
    }
}
