//! Constitutive law of a sheet: membrane and bending stiffness in Voigt notation, retardation time.

/// Stiffness of a sheet per width, and its retardation time. Components are (uu, vv, uv) with
/// engineering shear and twist (γ = 2 ε_uv, 2 κ_uv); u is along the sheet's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementLaw {
    /// Membrane stiffness, N/m.
    pub membrane: [[f64; 3]; 3],
    /// Bending stiffness, N m.
    pub bending: [[f64; 3]; 3],
    /// Retardation time τ, s; 0 for a sheet without damping.
    pub retardation: f64,
}
