//! Spots of a sheet set to a temperature.

use crate::error::InputError;
use crate::scene::spot::SpotSpec;
use crate::sheet::{Sheet, temperature};

/// Set the temperatures of `spots`, through the whole thickness; other places keep theirs. A
/// sheet without a thermal model starts one at `ambient` (°C).
///
/// # Errors
/// When a spot is out of range; nothing changes then.
pub fn heat_spots(sheet: &mut Sheet, spots: &[SpotSpec], ambient: f64) -> Result<(), InputError> {
    if spots.is_empty() {
        return Ok(());
    }
    spots.iter().try_for_each(SpotSpec::check)?;
    temperature::start_temperatures(sheet, ambient);
    let (extent, uv) = (sheet.model.extent, sheet.model.uv.clone());
    if let Some(heat) = &mut sheet.state.heat {
        heat.blend(|i, now| {
            spots.iter().fold(now, |celsius, spot| {
                let apart = ((uv[i].0 - spot.at.0) * extent.0).hypot((uv[i].1 - spot.at.1) * extent.1);
                celsius + spot.weight(apart) * (spot.temperature - celsius)
            })
        });
    }
    temperature::update_thermal_stiffness(sheet);
    sheet.wake();
    Ok(())
}
