//! Spots: places of a sheet that are warmer or colder than the rest from the start, and warmth that is put on while it runs.
//!
//! A spot of radius r makes what is within of it as warm as it says: wholly up to r/2 from its middle, and from there less and less by a smooth
//! step, nothing at r. Distances are along the flat sheet. Of several spots the later one is put over the earlier.

use serde::{Deserialize, Serialize};

use crate::error::{InputError, check_range};
use crate::sheet::Sheet;

/// A warm place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotSpec {
    /// Its middle, (u, v), each 0 to 1.
    pub at: (f64, f64),
    /// Its radius, m, 1e-6 to 1e3.
    pub radius: f64,
    /// Its temperature, °C, -273.15 to 5000.
    pub temperature: f64,
}

impl SpotSpec {
    /// Checks its ranges.
    ///
    /// # Errors
    /// When one is out of its range.
    pub fn check(&self) -> Result<(), InputError> {
        check_range("at.0", self.at.0, 0.0, 1.0, "")?;
        check_range("at.1", self.at.1, 0.0, 1.0, "")?;
        check_range("radius", self.radius, 1e-6, 1e3, "m")?;
        check_range("temperature", self.temperature, crate::thermal::COLDEST, crate::thermal::HOTTEST, "°C")
    }

    /// How much of its temperature there is `distance` m from its middle, 0 to 1.
    pub fn share(&self, distance: f64) -> f64 {
        let s = (2.0 - 2.0 * distance / self.radius).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    }
}

impl Sheet {
    /// Makes what is within `spots` as warm as they say, through the whole thickness; the rest stays as warm as it is. A sheet that nothing
    /// heats has temperatures from then on; `ambient` (°C) is what it had until now.
    ///
    /// # Errors
    /// When a spot is out of range; nothing is changed then.
    pub fn warm(&mut self, spots: &[SpotSpec], ambient: f64) -> Result<(), InputError> {
        if spots.is_empty() {
            return Ok(());
        }
        spots.iter().try_for_each(SpotSpec::check)?;
        self.begin_heat(ambient);
        let (extent, uv) = (self.extent, self.uv.clone());
        if let Some(heat) = &mut self.heat {
            heat.mix(|i, now| {
                spots.iter().fold(now, |celsius, spot| {
                    let apart = ((uv[i].0 - spot.at.0) * extent.0).hypot((uv[i].1 - spot.at.1) * extent.1);
                    celsius + spot.share(apart) * (spot.temperature - celsius)
                })
            });
        }
        self.follow_heat();
        self.wake();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_is_whole_inside_and_gone_at_its_rim() {
        let spot = SpotSpec { at: (0.5, 0.5), radius: 0.02, temperature: 120.0 };
        assert_eq!((spot.share(0.0), spot.share(0.01)), (1.0, 1.0));
        assert!((spot.share(0.015) - 0.5).abs() < 1e-12);
        assert_eq!((spot.share(0.02), spot.share(1.0)), (0.0, 0.0));
        assert!(SpotSpec { radius: 0.0, ..spot }.check().is_err());
        assert!(SpotSpec { at: (1.5, 0.0), ..spot }.check().is_err());
        assert!(SpotSpec { temperature: f64::NAN, ..spot }.check().is_err());
    }
}
