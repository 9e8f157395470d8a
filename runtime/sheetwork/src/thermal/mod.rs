//! Heat exchange of sheets with their surroundings, and the thermal step of a world.
//!
//! Per area of a sheet
//!
//!   ρ c t ∂T/∂t = k t ∇²T + α Σ q_in - h (T - T_air) - 2 ε σ (T⁴ - T_wall⁴).
//!
//! `source` computes the exchange, with `view_factor` and `shadow` for radiation; `model` is the
//! thermal model of a world and steps all sheets. Conduction, time integration and the effect on
//! stiffness are in [`crate::sheet::temperature`].
//!
//! A sheet without heat stores no temperatures and none of this runs. Temperatures are in °C, all
//! else in SI. Sheets are heated in sequence, so results do not depend on threads.

pub mod model;
pub(crate) mod shadow;
pub mod source;
pub(crate) mod thesis_mode;
pub mod view_factor;

pub use crate::thermal::model::ThermalModel;
pub use crate::units::temperature::REFERENCE;
