//! Heat: temperatures of sheets, their effect on the material, and heat flow.
//!
//! Per area of a sheet
//!
//!   ρ c t ∂T/∂t = k t ∇²T + α Σ q_in - h (T - T_air) - 2 ε σ (T⁴ - T_wall⁴).
//!
//! `network` models conduction, `source` the exchange, `stepper` integrates in time, `softening`
//! gives E(T); `state` is the state of a sheet, `room` that of a world.
//!
//! A sheet without heat stores no temperatures and none of this runs. Temperatures are in °C, all
//! else in SI. Sheets are heated in sequence, so results do not depend on threads.

pub mod room;
pub(crate) mod shadow;
pub mod source;
pub(crate) mod thesis_mode;
pub mod view_factor;

pub use crate::thermal::room::Room;
pub use crate::units::temperature::REFERENCE;
