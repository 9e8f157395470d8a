//! Constitutive law of a sheet: membrane and bending stiffness in Voigt notation, and damping.

use crate::material::loss_factor::{ARMS, fit_arms};

/// Stiffness of a sheet per width, and its retardation time. Components are (uu, vv, uv) with
/// engineering shear and twist (γ = 2 ε_uv, 2 κ_uv); u is along the sheet's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementLaw {
    /// Membrane stiffness, N/m.
    pub membrane: [[f64; 3]; 3],
    /// Bending stiffness, N m.
    pub bending: [[f64; 3]; 3],
    /// Retardation time τ of bending, s; 0 for a sheet without Kelvin-Voigt damping.
    pub retardation: f64,
    /// Retardation time of the membrane, s.
    pub membrane_retardation: f64,
    /// Modulus of each Maxwell arm relative to the stiffnesses, which then are the relaxed ones; 0
    /// without a flat loss factor.
    pub arms: [f64; ARMS],
}

impl ElementLaw {
    /// The law with the flat loss factor `eta` (0 to 0.3) as its only damping, and the present
    /// stiffnesses at rest.
    #[must_use]
    pub fn with_loss_factor(self, eta: f64) -> Self {
        Self { retardation: 0.0, membrane_retardation: 0.0, arms: fit_arms(eta), ..self }
    }
}
