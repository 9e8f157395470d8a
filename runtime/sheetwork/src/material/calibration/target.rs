//! Target of a calibration: membrane and bending stiffness of a thin plate.
//!
//! Directions: 1 along the length (x, warp), 2 along the width (z, weft). With strains ε = (ε11,
//! ε22, γ12) and curvatures κ = (κ11, κ22, 2 κ12) the energy per area is ½ εᵀ A ε + ½ κᵀ D κ; A in
//! N/m, D in N m.
//!
//! - Isotropic (Timoshenko and Woinowsky-Krieger, *Theory of Plates and Shells*, equation 38): with
//!   B = E t/(1-ν²) and D = E t³/(12 (1-ν²)), A = B [1 ν 0; ν 1 0; 0 0 (1-ν)/2] and the same for D.
//! - Orthotropic (section 85 there): the moduli per width as the Kawabata system measures them.

use crate::error::InputError;
use crate::material::calibration::orthotropic::{Orthotropic, turned};
use crate::units::parameters::ParameterId as Id;

/// A symmetric 3 by 3 matrix over (11, 22, 12).
pub type Voigt = [[f64; 3]; 3];

/// Requested stiffness of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessTarget {
    /// Membrane stiffness A, N/m.
    pub membrane: Voigt,
    /// Bending stiffness D, N m.
    pub bending: Voigt,
}

impl StiffnessTarget {
    /// Target as by [`Self::isotropic`], from values that have been checked.
    pub(crate) fn of_plate(young: f64, poisson: f64, thickness: f64) -> Self {
        let scale = young * thickness / (1.0 - poisson * poisson);
        let plane = |s: f64| [[s, s * poisson, 0.0], [s * poisson, s, 0.0], [0.0, 0.0, s * (1.0 - poisson) / 2.0]];
        Self { membrane: plane(scale), bending: plane(scale * thickness * thickness / 12.0) }
    }

    /// Target of measured stiffness. The Poisson coupling of bending is that of the membrane, D12 =
    /// √(ν12 ν21 D11 D22), where none is given.
    ///
    /// # Errors
    /// When a value is out of range, or the values together have no positive energy.
    pub fn orthotropic(data: &Orthotropic) -> Result<Self, InputError> {
        Id::YoungWarp.check("young_warp", data.young_warp)?;
        Id::YoungWeft.check("young_weft", data.young_weft)?;
        Id::Shear.check("shear", data.shear)?;
        Id::BendingWarp.check("bending_warp", data.bending_warp)?;
        Id::BendingWeft.check("bending_weft", data.bending_weft)?;
        Id::Twist.check("twist", data.twist)?;
        Id::WarpDirection.check("direction", data.direction)?;
        data.check_ratios()?;
        Ok(Self::of_measured(data))
    }

    /// Target as by [`Self::orthotropic`], from values that have been checked.
    pub(crate) fn of_measured(data: &Orthotropic) -> Self {
        let back = data.poisson * data.young_weft / data.young_warp;
        let share = 1.0 - data.poisson * back;
        let (a11, a22) = (data.young_warp / share, data.young_weft / share);
        let coupling = data.bending_coupling();
        let membrane = [[a11, data.poisson * a22, 0.0], [data.poisson * a22, a22, 0.0], [0.0, 0.0, data.shear]];
        let bending = [[data.bending_warp, coupling, 0.0], [coupling, data.bending_weft, 0.0], [0.0, 0.0, data.twist]];
        if data.direction == 0.0 {
            return Self { membrane, bending };
        }
        Self { membrane: turned(&membrane, data.direction), bending: turned(&bending, data.direction) }
    }

    /// Requested Poisson's ratio in bending: D12 over the geometric mean of D11 and D22.
    pub fn poisson(&self) -> f64 {
        ratio(self.bending[0][1], (self.bending[0][0] * self.bending[1][1]).sqrt())
    }

    /// The larger of the two bending stiffnesses, N m.
    pub fn largest_bending(&self) -> f64 {
        self.bending[0][0].max(self.bending[1][1])
    }
}

/// Quotient; zero when the divisor is zero.
pub(crate) fn ratio(above: f64, below: f64) -> f64 {
    if below.abs() > 0.0 { above / below } else { 0.0 }
}

/// Stiffness for cylindrical bending (or extension without contraction) along the direction at
/// `angle` (rad) from 1.
pub(crate) fn along(d: &Voigt, angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    let v = [c * c, s * s, 2.0 * c * s];
    (0..3).map(|i| (0..3).map(|j| v[i] * d[i][j] * v[j]).sum::<f64>()).sum()
}

/// Weights of the entries (11, 22, 12-12, 11-22, 11-12, 22-12) in the squared norm of a stiffness
/// tensor, which does not depend on the choice of axes (Mandel's notation, in which the tensor is
/// an ordinary matrix).
pub(crate) const ENTRIES: [(usize, usize, f64); 6] =
    [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 4.0), (0, 1, 2.0), (0, 2, 4.0), (1, 2, 4.0)];

/// Norm of a stiffness tensor.
pub(crate) fn norm(d: &Voigt) -> f64 {
    ENTRIES.iter().map(|(i, j, weight)| weight * d[*i][*j] * d[*i][*j]).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_isotropic_target_is_alike_in_all_directions() {
        let target = StiffnessTarget::of_plate(3e9, 0.35, 5e-4);
        let d = 3e9 * 5e-4_f64.powi(3) / 12.0 / (1.0 - 0.35 * 0.35);
        for degrees in [0.0_f64, 13.0, 45.0, 90.0, 135.0] {
            assert!((along(&target.bending, degrees.to_radians()) / d - 1.0).abs() < 1e-12);
        }
        assert!((target.poisson() - 0.35).abs() < 1e-12);
    }

    #[test]
    fn orthotropic_data_of_an_isotropic_sheet_give_the_isotropic_target() {
        let (e, nu, t) = (3e9, 0.3, 5e-4);
        let d = e * t * t * t / 12.0 / (1.0 - nu * nu);
        let found = StiffnessTarget::orthotropic(&Orthotropic {
            young_warp: e * t,
            young_weft: e * t,
            shear: e * t / (2.0 * (1.0 + nu)),
            poisson: nu,
            bending_warp: d,
            bending_weft: d,
            twist: d * (1.0 - nu) / 2.0,
            ..Orthotropic::default()
        });
        let wanted = StiffnessTarget::of_plate(e, nu, t);
        let found = found.expect("valid");
        for i in 0..3 {
            for j in 0..3 {
                assert!((found.membrane[i][j] - wanted.membrane[i][j]).abs() < 1e-9 * wanted.membrane[0][0]);
                assert!((found.bending[i][j] - wanted.bending[i][j]).abs() < 1e-9 * wanted.bending[0][0]);
            }
        }
    }

    #[test]
    fn an_impossible_stiffness_is_rejected() {
        let cloth = Orthotropic {
            young_warp: 4000.0,
            young_weft: 1000.0,
            shear: 40.0,
            poisson: 2.1,
            bending_warp: 1e-5,
            bending_weft: 5e-6,
            twist: 3e-6,
            ..Orthotropic::default()
        };
        assert_eq!(StiffnessTarget::orthotropic(&cloth).expect_err("ν12 ν21 above 1").field, "poisson");
        assert!(StiffnessTarget::orthotropic(&Orthotropic { poisson: 0.2, ..cloth }).is_ok());
    }
}
