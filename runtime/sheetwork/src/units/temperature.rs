//! Temperatures: zero of the Celsius scale, accepted range, reference of material data; radiation
//! constant.

/// 0 °C in K.
pub const ZERO_CELSIUS: f64 = 273.15;
/// Absolute zero, °C.
pub const COLDEST: f64 = -ZERO_CELSIUS;
/// Maximum accepted temperature, °C.
pub const HOTTEST: f64 = 5000.0;
/// Stefan-Boltzmann constant σ, W/(m² K⁴) (CODATA 2018).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// Reference temperature of material constants and of the size of a sheet, °C.
pub const REFERENCE: f64 = 20.0;
