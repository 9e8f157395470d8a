//! Sheets whose stiffness differs along warp and weft, and the tests of fabrics that measure it.
//!
//! Moduli of a strip cut at θ from the warp, per width: D_θ in tension (N/m) and H_θ in bending
//! (N m), with D1, D2, Ds, ν1 the moduli along warp and weft, the shear stiffness and the
//! Poisson's ratio, and H1, H2, Hs, µ1 the same of bending (thesis equations 1.14 and 1.15):
//!
//!   1/D_θ = cos⁴θ/D1 + (1/Ds - 2 ν1/D1) cos²θ sin²θ + sin⁴θ/D2,
//!   1/H_θ = cos⁴θ/H1 + (1/Hs - 2 µ1/H1) cos²θ sin²θ + sin⁴θ/H2,
//!
//! with ν1/D1 = ν2/D2. At 45° they give what no strip along the thread shows (1.16, 1.17):
//!
//!   ν1 = ½ D1 (1/D1 + 1/D2 + 1/Ds - 4/D45),  1/Hs = 4/H45 - 1/H1 - 1/H2 + 2 µ1/H1.
//!
//! The thesis prints a sum between ½ D1 and the bracket of 1.16, where 1.14 gives a product, and
//! neglects µ1 in 1.17.
//!
//! H is the stiffness of a strip that is free to curve across, D11 = H1/(1 - µ1 µ2) that of a
//! wide one, which bends to a cylinder.
//!
//! Kawabata's instruments print shear in gf/(cm degree), bending in gf cm²/cm and the extension in
//! percent at 500 gf/cm (S. Kawabata, *The Standardization and Analysis of Hand Evaluation*, 1980).

use serde::{Deserialize, Serialize};

use crate::error::{InputError, check_range};
use crate::material::calibration::target::Voigt;

/// Measured stiffness of an orthotropic sheet along warp and weft, per width.
///
/// In a file, values at 45° may stand in place of some fields, and values may be in the units of
/// Kawabata's instruments: see [`MeasuredFabric`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MeasuredFabric")]
pub struct Orthotropic {
    /// Uniaxial tensile stiffness along the warp, E t, N/m; 1e-6 to 1e12.
    pub young_warp: f64,
    /// Uniaxial tensile stiffness along the weft, N/m; 1e-6 to 1e12.
    pub young_weft: f64,
    /// In-plane shear stiffness G t, N/m; 0 to 1e12.
    pub shear: f64,
    /// Contraction along the weft per extension along the warp; its square times weft over warp
    /// stiffness is below 1.
    pub poisson: f64,
    /// Cylindrical bending stiffness along the warp, N m; 1e-15 to 1e9.
    pub bending_warp: f64,
    /// Cylindrical bending stiffness along the weft, N m; 1e-15 to 1e9.
    pub bending_weft: f64,
    /// Twisting stiffness: twisting moment per 2 κ12, N m; D (1-ν)/2 for an isotropic plate; 0 to
    /// 1e9.
    pub twist: f64,
    /// Curvature along the weft per opposite curvature along the warp of a strip that is free to
    /// curve across; its square times warp over weft bending stiffness is below 1. `None` for the
    /// coupling of the membrane.
    pub bending_poisson: Option<f64>,
    /// Angle from the sheet's length to the warp, towards the width, degrees; -180 to 180. An angle
    /// between the axes is for sheets with an outline.
    pub direction: f64,
}

/// Units of a [`MeasuredFabric`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FabricUnits {
    /// N/m and N m.
    #[default]
    Si,
    /// Those of Kawabata's instruments: tension in gf/cm, shear in gf/(cm degree), bending in gf
    /// cm²/cm.
    Kawabata,
}

/// Results of the tests of a fabric, as they come.
///
/// Tension: `young_*`, or the extension at Kawabata's load of 500 gf/cm, whose secant it takes. Two
/// of `shear`, `poisson` and the value at 45° are given, and one of `twist` and the bending at
/// 45°.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeasuredFabric {
    /// Units of stiffness.
    pub units: FabricUnits,
    /// Tensile stiffness along the warp, N/m or gf/cm.
    pub young_warp: Option<f64>,
    /// Tensile stiffness along the weft, N/m or gf/cm.
    pub young_weft: Option<f64>,
    /// Tensile stiffness of a strip at 45° to the thread, N/m or gf/cm.
    pub young_bias: Option<f64>,
    /// Extension at 500 gf/cm along the warp (EM), percent; above 0.
    pub extension_warp: Option<f64>,
    /// Extension at 500 gf/cm along the weft, percent; above 0.
    pub extension_weft: Option<f64>,
    /// Extension at 500 gf/cm at 45° to the thread, percent; above 0.
    pub extension_bias: Option<f64>,
    /// Shear stiffness (G), N/m or gf/(cm degree).
    pub shear: Option<f64>,
    /// Poisson's ratio, as in [`Orthotropic`].
    pub poisson: Option<f64>,
    /// Bending stiffness along the warp (B), N m or gf cm²/cm.
    pub bending_warp: Option<f64>,
    /// Bending stiffness along the weft, N m or gf cm²/cm.
    pub bending_weft: Option<f64>,
    /// Bending stiffness of a strip at 45° to the thread, N m or gf cm²/cm.
    pub bending_bias: Option<f64>,
    /// Twisting stiffness, N m or gf cm²/cm.
    pub twist: Option<f64>,
    /// Poisson's ratio of bending, as in [`Orthotropic`].
    pub bending_poisson: Option<f64>,
    /// Angle from the sheet's length to the warp, degrees.
    pub direction: f64,
}

/// One gram-force, N: the unit of Kawabata's instruments.
const GRAM_FORCE: f64 = 9.80665e-3;
/// One gf/cm, N/m: 0.980665.
const GF_PER_CM: f64 = GRAM_FORCE / 1e-2;
/// One gf cm²/cm, N m: 9.80665e-5.
const GF_CM2_PER_CM: f64 = GRAM_FORCE * 1e-4 / 1e-2;
/// Load of the tensile test, gf/cm, at which the extension is read.
const TENSILE_LOAD: f64 = 500.0;

impl FabricUnits {
    /// Tensile stiffness (N/m).
    fn tension(self, value: f64) -> f64 {
        if self == Self::Si { value } else { value * GF_PER_CM }
    }

    /// Shear stiffness (N/m per radian): one gf/(cm degree) is 56.19 N/m.
    fn shear(self, value: f64) -> f64 {
        if self == Self::Si { value } else { value * GF_PER_CM * 180.0 / std::f64::consts::PI }
    }

    /// Bending stiffness (N m).
    fn bending(self, value: f64) -> f64 {
        if self == Self::Si { value } else { value * GF_CM2_PER_CM }
    }
}

impl MeasuredFabric {
    /// Stiffness along warp and weft.
    ///
    /// # Errors
    /// When a value is missing or given twice, is not positive, or no elastic sheet has these
    /// values.
    pub fn orthotropic(&self) -> Result<Orthotropic, InputError> {
        let warp = self.tension("warp", self.young_warp, self.extension_warp)?;
        let weft = self.tension("weft", self.young_weft, self.extension_weft)?;
        let warp = warp.ok_or_else(|| missing("young_warp"))?;
        let weft = weft.ok_or_else(|| missing("young_weft"))?;
        let bias = self.tension("bias", self.young_bias, self.extension_bias)?;
        let (shear, poisson) = self.membrane_coupling(warp, weft, bias)?;
        let bending = |name: &str, value: Option<f64>| value.ok_or_else(|| missing(name));
        let mut found = Orthotropic {
            young_warp: warp,
            young_weft: weft,
            shear,
            poisson,
            bending_warp: self.units.bending(bending("bending_warp", self.bending_warp)?),
            bending_weft: self.units.bending(bending("bending_weft", self.bending_weft)?),
            twist: 0.0,
            bending_poisson: self.bending_poisson,
            direction: self.direction,
        };
        found.twist = match (self.twist, self.bending_bias) {
            (Some(twist), None) => self.units.bending(twist),
            (None, Some(bias)) => found.twist_from_bias(self.units.bending(positive("bending_bias", bias)?))?,
            (None, None) => return Err(missing("twist, or bending_bias")),
            (Some(_), Some(_)) => return Err(overdetermined("twist and bending_bias", "one")),
        };
        Ok(found)
    }

    /// Tensile stiffness in one direction, N/m.
    fn tension(&self, end: &str, young: Option<f64>, extension: Option<f64>) -> Result<Option<f64>, InputError> {
        match (young, extension) {
            (Some(_), Some(_)) => Err(overdetermined(&format!("young_{end} and extension_{end}"), "one")),
            (Some(young), None) => Ok(Some(self.units.tension(positive(&format!("young_{end}"), young)?))),
            (None, Some(percent)) => {
                let percent = positive(&format!("extension_{end}"), percent)?;
                Ok(Some(TENSILE_LOAD * GF_PER_CM / (percent / 100.0)))
            }
            (None, None) => Ok(None),
        }
    }

    /// Shear stiffness (N/m) and Poisson's ratio, from two of shear, ratio and the value at 45°.
    fn membrane_coupling(&self, warp: f64, weft: f64, bias: Option<f64>) -> Result<(f64, f64), InputError> {
        let shear = self.shear.map(|s| self.units.shear(s));
        match (shear, self.poisson, bias) {
            (Some(shear), Some(poisson), None) => Ok((shear, poisson)),
            (Some(shear), None, Some(bias)) => {
                let shear = positive("shear", shear)?;
                let ratio = 0.5 * warp * (1.0 / warp + 1.0 / weft + 1.0 / shear - 4.0 / bias);
                let most = (warp / weft).sqrt();
                if ratio.abs() < most {
                    return Ok((shear, ratio));
                }
                // Range of the value at 45° between ratios of -most and most.
                let at = |ratio: f64| 4.0 / (1.0 / warp + 1.0 / weft + 1.0 / shear - 2.0 * ratio / warp);
                Err(InputError::new(
                    "young_bias",
                    format!(
                        "{bias:.4} N/m at 45° and a shear stiffness of {shear:.4} N/m need a Poisson's ratio of \
                         {ratio:.3}, beyond ±{most:.3}; with this shear stiffness a strip at 45° has {:.4} to {:.4} \
                         N/m",
                        at(-most),
                        at(most)
                    ),
                ))
            }
            (None, Some(poisson), Some(bias)) => {
                let compliance = 4.0 / bias - 1.0 / warp - 1.0 / weft + 2.0 * poisson / warp;
                if compliance > 0.0 {
                    return Ok((1.0 / compliance, poisson));
                }
                let most = 4.0 / (1.0 / warp + 1.0 / weft - 2.0 * poisson / warp);
                Err(InputError::new(
                    "young_bias",
                    format!("{bias:.4} N/m is beyond the {most:.4} N/m of a sheet that does not shear"),
                ))
            }
            (Some(_), Some(_), Some(_)) => Err(overdetermined("shear, poisson and young_bias", "two")),
            _ => Err(missing("two of shear, poisson and young_bias")),
        }
    }
}

impl TryFrom<MeasuredFabric> for Orthotropic {
    type Error = InputError;

    fn try_from(fabric: MeasuredFabric) -> Result<Self, InputError> {
        fabric.orthotropic()
    }
}

impl Orthotropic {
    /// Tensile stiffness (N/m) of a strip cut at `degrees` from the warp.
    pub fn young_at(&self, degrees: f64) -> f64 {
        let cross = 1.0 / self.shear - 2.0 * self.poisson / self.young_warp;
        strip_modulus(degrees, self.young_warp, self.young_weft, cross)
    }

    /// Bending stiffness (N m) of a narrow strip cut at `degrees` from the warp, free to curve
    /// across and to twist.
    pub fn bending_at(&self, degrees: f64) -> f64 {
        let (warp, weft, coupling) = self.strip_bending();
        strip_modulus(degrees, warp, weft, 1.0 / self.twist - 2.0 * coupling)
    }

    /// D12 of bending, N m.
    pub(crate) fn bending_coupling(&self) -> f64 {
        if let Some(ratio) = self.bending_poisson {
            return ratio * self.bending_weft;
        }
        let back = self.poisson * self.young_weft / self.young_warp;
        self.poisson.signum() * (self.poisson * back * self.bending_warp * self.bending_weft).sqrt()
    }

    /// H1 and H2, N m, and µ1/H1, 1/(N m).
    fn strip_bending(&self) -> (f64, f64, f64) {
        let coupling = self.bending_coupling();
        let product = self.bending_warp * self.bending_weft - coupling * coupling;
        (product / self.bending_weft, product / self.bending_warp, coupling / product)
    }

    /// Twisting stiffness (N m) at which a strip at 45° has a bending stiffness of `bias` (N m).
    fn twist_from_bias(&self, bias: f64) -> Result<f64, InputError> {
        let (warp, weft, coupling) = self.strip_bending();
        let compliance = 4.0 / bias - 1.0 / warp - 1.0 / weft + 2.0 * coupling;
        if compliance > 0.0 {
            return Ok(1.0 / compliance);
        }
        let most = 4.0 / (1.0 / warp + 1.0 / weft - 2.0 * coupling);
        let problem = format!("{bias:.4e} N m is beyond the {most:.4e} N m of a sheet that does not twist");
        Err(InputError::new("bending_bias", problem))
    }

    /// Check the ratios and the direction.
    pub(crate) fn check_ratios(&self) -> Result<(), InputError> {
        // ν12 ν21 below 1 keeps the energy positive.
        let most = 0.999 * (self.young_warp / self.young_weft).sqrt();
        check_range("poisson", self.poisson, -most, most, "")?;
        let most = 0.999 * (self.bending_warp / self.bending_weft).sqrt();
        self.bending_poisson.map_or(Ok(()), |ratio| check_range("bending_poisson", ratio, -most, most, ""))
    }

    /// Whether the warp runs along the length or the width of the sheet.
    pub(crate) fn is_along_axes(&self) -> bool {
        self.direction % 90.0 == 0.0
    }
}

/// Modulus of a strip at `degrees` from 1, where the product term has the compliance `cross`.
fn strip_modulus(degrees: f64, along: f64, across: f64, cross: f64) -> f64 {
    let (s, c) = degrees.to_radians().sin_cos();
    let (s, c) = (s * s, c * c);
    1.0 / (c * c / along + cross * c * s + s * s / across)
}

/// Stiffness `of` (in the axes of warp and weft) in the axes of the sheet, to whose length the warp
/// has an angle of `degrees`.
pub(crate) fn turned(of: &Voigt, degrees: f64) -> Voigt {
    let (s, c) = degrees.to_radians().sin_cos();
    // Strains along warp and weft from those along the axes.
    let t = [[c * c, s * s, s * c], [s * s, c * c, -s * c], [-2.0 * s * c, 2.0 * s * c, c * c - s * s]];
    let half: Voigt = std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| of[i][k] * t[k][j]).sum()));
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| t[k][i] * half[k][j]).sum()))
}

fn positive(field: &str, value: f64) -> Result<f64, InputError> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(InputError::new(field, format!("{value} is not above 0")))
}

fn missing(what: &str) -> InputError {
    InputError::new("", format!("an orthotropic sheet needs {what}"))
}

fn overdetermined(what: &str, count: &str) -> InputError {
    InputError::new("", format!("{what} determine one another: give {count} of them"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::calibration::StiffnessTarget;

    /// Wool-polyester of table 2.1, with the ratio of the table or the value at 45°.
    fn wool() -> MeasuredFabric {
        MeasuredFabric {
            young_warp: Some(3600.0),
            young_weft: Some(3200.0),
            shear: Some(35.0),
            poisson: Some(0.18),
            bending_warp: Some(5.1e-6),
            bending_weft: Some(4.4e-6),
            bending_bias: Some(3.7e-6),
            bending_poisson: Some(0.0),
            ..MeasuredFabric::default()
        }
    }

    #[test]
    fn the_twist_of_table_2_1_follows_from_its_bending_at_45_degrees() {
        // 1/(4/3.7 - 1/5.1 - 1/4.4) = 1.5203 µN m; the table prints 1.5.
        let found = wool().orthotropic().expect("valid");
        assert!((found.twist - 1.520_3e-6).abs() < 1e-10, "{}", found.twist);
        assert!((found.bending_at(45.0) / 3.7e-6 - 1.0).abs() < 1e-12);
        assert!((found.bending_at(0.0) / 5.1e-6 - 1.0).abs() < 1e-12);
        assert!((found.bending_at(90.0) / 4.4e-6 - 1.0).abs() < 1e-12);
        // ν2 = ν1 D2/D1 = 0.16, as the table.
        assert!((found.poisson * found.young_weft / found.young_warp - 0.16).abs() < 1e-12);
    }

    #[test]
    fn the_rigidity_of_table_2_1_contradicts_its_diagonal_modulus() {
        // ½ 3600 (1/3600 + 1/3200 + 1/35 - 4/1200) = 46.49, no Poisson's ratio. With a shear
        // stiffness of 35 N/m a strip at 45° has 137.6 N/m; 1200 N/m and 0.18 need 351.8 N/m.
        let both = MeasuredFabric { poisson: None, young_bias: Some(1200.0), ..wool() };
        let error = both.orthotropic().expect_err("inconsistent");
        assert!(error.problem.contains("46.491") && error.field == "young_bias", "{error}");
        let shear = MeasuredFabric { shear: None, young_bias: Some(1200.0), ..wool() }.orthotropic().expect("valid");
        assert!((shear.shear - 351.8).abs() < 0.1, "{}", shear.shear);
        assert!((shear.young_at(45.0) - 1200.0).abs() < 1e-9);
        assert!((wool().orthotropic().expect("valid").young_at(45.0) - 137.6).abs() < 0.1);
    }

    #[test]
    fn values_at_45_degrees_return_the_ratio_and_the_shear_they_came_from() {
        let made = Orthotropic { shear: 50.0, poisson: 0.3, twist: 2e-6, ..wool().orthotropic().expect("valid") };
        for coupling in [None, Some(0.2)] {
            let made = Orthotropic { bending_poisson: coupling, ..made };
            let bias = MeasuredFabric {
                poisson: None,
                young_bias: Some(made.young_at(45.0)),
                bending_bias: Some(made.bending_at(45.0)),
                bending_poisson: coupling,
                shear: Some(50.0),
                ..wool()
            };
            let ratio = bias.orthotropic().expect("valid");
            assert!((ratio.poisson - 0.3).abs() < 1e-9 && coupling.is_none_or(|_| (ratio.twist - 2e-6).abs() < 1e-15));
            let shear = MeasuredFabric { shear: None, poisson: Some(0.3), ..bias }.orthotropic().expect("valid");
            assert!((shear.shear - 50.0).abs() < 1e-9 && (shear.twist - 2e-6).abs() < 1e-15, "{shear:?}");
        }
    }

    #[test]
    fn moduli_at_an_angle_are_those_of_the_turned_stiffness() {
        // A strip free across has the modulus 1/S11 of the inverse of its stiffness.
        let cloth = Orthotropic { bending_poisson: Some(0.3), ..wool().orthotropic().expect("valid") };
        let target = StiffnessTarget::of_measured(&cloth);
        let uniaxial = |c: &Voigt| {
            let minor = c[1][1] * c[2][2] - c[1][2] * c[2][1];
            let det = c[0][0] * minor - c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0])
                + c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
            det / minor
        };
        for degrees in [0.0, 20.0, 45.0, 71.0, 90.0, -30.0] {
            let of = Orthotropic { direction: degrees, ..cloth };
            let there = StiffnessTarget::of_measured(&of);
            assert!((uniaxial(&there.membrane) / cloth.young_at(degrees) - 1.0).abs() < 1e-9, "{degrees}");
            assert!((uniaxial(&there.bending) / cloth.bending_at(degrees) - 1.0).abs() < 1e-9, "{degrees}");
        }
        let square = StiffnessTarget::of_measured(&Orthotropic { direction: 90.0, ..cloth });
        assert!((square.bending[0][0] / target.bending[1][1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn units_of_kawabata_are_converted() {
        // 1 gf/cm = 0.980665 N/m, 1 gf/(cm degree) = 56.188 N/m, 1 gf cm²/cm = 98.0665 µN m, and
        // 5 % at 500 gf/cm are 9806.65 N/m.
        let sheet = MeasuredFabric {
            units: FabricUnits::Kawabata,
            extension_warp: Some(5.0),
            young_weft: Some(3000.0),
            shear: Some(0.6),
            poisson: Some(0.2),
            bending_warp: Some(0.05),
            bending_weft: Some(0.04),
            twist: Some(0.02),
            ..MeasuredFabric::default()
        };
        let found = sheet.orthotropic().expect("valid");
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        assert!(near(found.young_warp, 9806.65) && near(found.young_weft, 2941.995), "{found:?}");
        assert!(
            near(found.shear, 33.712_79) && near(found.bending_warp, 4.903_325e-6) && near(found.twist, 1.961_33e-6)
        );
    }

    #[test]
    fn incomplete_and_contradictory_sheets_are_refused() {
        let refused = |fabric: MeasuredFabric| fabric.orthotropic().expect_err("not valid").to_string();
        let all = MeasuredFabric { young_bias: Some(140.0), ..wool() };
        assert!(refused(all).contains("give two of them"));
        assert!(refused(MeasuredFabric { shear: None, ..wool() }).contains("two of shear, poisson and young_bias"));
        assert!(refused(MeasuredFabric { twist: Some(1e-6), ..wool() }).contains("give one of them"));
        assert!(refused(MeasuredFabric { bending_bias: None, ..wool() }).contains("twist, or bending_bias"));
        assert!(refused(MeasuredFabric { young_warp: None, ..wool() }).contains("young_warp"));
        assert!(refused(MeasuredFabric { bending_bias: Some(1.0), ..wool() }).contains("does not twist"));
        assert!(refused(MeasuredFabric { young_warp: Some(-1.0), ..wool() }).contains("above 0"));
        assert!(refused(MeasuredFabric { extension_warp: Some(5.0), ..wool() }).contains("give one of them"));
    }
}
