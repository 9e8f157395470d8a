//! Hot and cold spots: initial temperatures of places of a sheet, heating while a world runs, and
//! places of a body with another temperature.
//!
//! A spot of radius r sets the temperature around its centre: fully up to r/2, from there with a
//! weight that falls by a smooth step to zero at r. Distances are along the flat sheet, or straight
//! from a point of a body. A later spot is applied over an earlier one.

use glam::DVec3;
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
        weight(distance, self.radius)
    }
}

/// Weight of a spot of `radius` (m) at `distance` (m) from its centre, 0 to 1.
fn weight(distance: f64, radius: f64) -> f64 {
    let s = (2.0 - 2.0 * distance / radius).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Hot or cold spot of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpotSpec {
    /// Centre along the axes of the body from its origin, m; each component within ±1e4.
    pub at: DVec3,
    /// Radius, m, 1e-6 to 1e3.
    pub radius: f64,
    /// Temperature, °C, -273.15 to 5000.
    pub temperature: f64,
}

impl BodySpotSpec {
    /// Check the ranges.
    ///
    /// # Errors
    /// When a value is out of its range.
    pub fn check(&self) -> Result<(), InputError> {
        Id::BodySpotCentre.check_each("at", self.at.to_array())?;
        Id::BodySpotRadius.check("radius", self.radius)?;
        Id::BodySpotTemperature.check("temperature", self.temperature)
    }

    /// Temperature (°C) at `place` (m, along the axes of the body from its origin), where the body
    /// without the spot has `celsius`.
    pub fn apply(&self, celsius: f64, place: DVec3) -> f64 {
        celsius + weight(place.distance(self.at), self.radius) * (self.temperature - celsius)
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
        let of_body = BodySpotSpec { at: DVec3::X, radius: 0.02, temperature: 120.0 };
        assert_eq!(of_body.apply(20.0, DVec3::X), 120.0);
        assert_eq!(of_body.apply(20.0, DVec3::new(1.02, 0.0, 0.0)), 20.0);
        assert!((of_body.apply(20.0, DVec3::new(1.0, 0.015, 0.0)) - 70.0).abs() < 1e-9);
        assert!(BodySpotSpec { radius: f64::NAN, ..of_body }.check().is_err());
        assert!(SpotSpec { radius: 0.0, ..spot }.check().is_err());
        assert!(SpotSpec { at: (1.5, 0.0), ..spot }.check().is_err());
        assert!(SpotSpec { temperature: f64::NAN, ..spot }.check().is_err());
    }
}
