//! The heater of the campaigns: a box with six hot faces above the sheet.

use glam::DVec3;
use sheetwork::scene::{HeaterSpec, HotFaceSpec, Placement};

/// A box of 10 cm by 2 cm by 10 cm with its centre 10 cm above the origin, its faces at 300 °C with
/// an emissivity of 0.9.
pub fn hot_box() -> HeaterSpec {
    HeaterSpec {
        size: Some(DVec3::new(0.1, 0.02, 0.1)),
        hot: (0..6).map(|face| HotFaceSpec { face, temperature: 300.0, emissivity: 0.9 }).collect(),
        placement: Placement { position: DVec3::new(0.0, 0.1, 0.0), ..Placement::default() },
        ..HeaterSpec::default()
    }
}
