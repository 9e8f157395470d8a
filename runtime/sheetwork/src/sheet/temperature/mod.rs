//! Temperatures of a sheet: state, conduction within the sheet, softening and thermal expansion.
//!
//! Per area of a sheet ρ c t ∂T/∂t = k t ∇²T + q: `network` holds capacities and conductances,
//! `conduction` integrates in time, `patches` are the two sides that exchange heat, `softening` is
//! E(T), `state` the temperatures and their effect on the elements. The sources of q are in
//! [`crate::thermal`]. Temperatures are in °C, everything else in SI.

pub mod conduction;
pub mod network;
pub mod patches;
pub(crate) mod playback;
pub mod softening;
pub(crate) mod spots;
pub mod state;

pub use playback::RecordedTemperature;
pub use softening::Softening;
pub use state::SheetTemperature;
#[doc(hidden)]
pub use state::start_temperatures;
pub(crate) use state::{faces, set_side_temperatures, update_thermal_stiffness};
