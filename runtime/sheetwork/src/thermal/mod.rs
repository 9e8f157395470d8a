//! How warm sheets are: temperatures, what they make of the material, and where heat goes.
//!
//! Per area of a sheet ρ c t ∂T/∂t = k t ∇²T + α Σ q_in - h (T - T_air) - 2 ε σ (T⁴ - T_wall⁴): conduction is `network`'s, what comes in
//! and goes out that of the `source`s, time `stepper`'s, E(T) `softening`'s; `state` is what a sheet holds, `room` what a world does.
//!
//! A sheet that nothing heats holds no temperatures and none of this runs. Temperatures are in °C, everything else in SI. Nothing here
//! depends on the order of threads: sheets are heated one after the other.

pub mod network;
pub mod patches;
pub(crate) mod playback;
pub mod room;
pub(crate) mod shadow;
pub mod softening;
pub mod source;
pub mod state;
pub mod stepper;
pub(crate) mod thesis_mode;
pub mod view_factor;

pub use crate::scene::spot::SpotSpec;
pub use crate::thermal::room::Room;
pub use crate::thermal::softening::{REFERENCE, Softening};
pub use crate::thermal::state::Heat;

/// 0 °C, K.
pub const ZERO_CELSIUS: f64 = 273.15;
/// Coldest temperature there is, °C.
pub const COLDEST: f64 = -ZERO_CELSIUS;
/// Hottest temperature that is taken, °C.
pub const HOTTEST: f64 = 5000.0;
/// Stefan and Boltzmann's constant σ, W/(m² K⁴) (CODATA 2018).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
