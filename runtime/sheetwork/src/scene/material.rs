//! Materials of sheets, by name, from a file, or in line.
//!
//! E Young's modulus (Pa), ν Poisson's ratio, ρ density (kg/m³), t thickness (m). An orthotropic
//! sheet has measured stiffnesses along its length (warp) and width (weft) in place of E and ν, as
//! the Kawabata system gives them (thesis 1.1 and 2.5.2). Thermal constants are used with heat;
//! plasticity and creep are used by sheets that enable them. The library's constants are averages
//! of their class; `thesis` is the soft sheet of the thesis, whose planar springs of 0.185 N/m
//! (table 4.3) equal E t with its layer distance of 1 mm as t.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::InputError;
use crate::material::calibration::{Orthotropic, StiffnessTarget};
use crate::material::law::ElementLaw;
use crate::material::loss_factor::ARMS;
use crate::scene::load::read_ron;
use crate::scene::validate;

/// Constants of a sheet material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Name in material pairs. Materials of the library and of files have the name they are loaded
    /// by; an in-line one may have none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Young's modulus E, Pa; 1e-3 to 2e12.
    pub young: f64,
    /// Poisson's ratio ν; -0.99 to 0.499.
    pub poisson: f64,
    /// Density ρ, kg/m³; 1e-3 to 1e6.
    pub density: f64,
    /// Thickness t, m; 1e-7 to 1.
    pub thickness: f64,
    /// Damping ratio of the slowest bending motion of a sheet; 0 to 10.
    pub damping_ratio: f64,
    /// Loss factor η = E''/E', equal at all frequencies, 0 to 0.3; `None` for `damping_ratio`.
    pub loss_factor: Option<f64>,
    /// Yield stress, Pa, 1 to 1e11; `None` for an elastic material.
    pub yield_stress: Option<f64>,
    /// Hardening modulus dσ/dε_p, growth of the yield stress with plastic strain, Pa; 0 to 1e12.
    pub hardening: f64,
    /// Creep constants; `None` for a material without creep.
    pub burgers: Option<BurgersCreep>,
    /// Measured stiffness along warp and weft, in place of that from E, ν and t; `None` for an
    /// isotropic sheet.
    pub orthotropic: Option<Orthotropic>,
    /// Specific heat c, J/(kg K); 1 to 1e5.
    pub specific_heat: f64,
    /// Thermal conductivity, W/(m K); 0 to 1e4.
    pub conductivity: f64,
    /// Emissivity of the surface, equal to its absorptivity, 0 to 1.
    pub emissivity: f64,
    /// Linear thermal expansion, 1/K; ±1e-2.
    pub expansion: f64,
    /// Glass transition, °C, -273.15 to 1000; `None` for a material that does not soften.
    pub glass_transition: Option<f64>,
    /// E at temperatures (°C, -273.15 to 5000, increasing) as fractions of `young`, 1e-9 to 1e3;
    /// log E is linear in between. Empty for the curve of the glass transition.
    pub softening: Vec<(f64, f64)>,
    /// C1 and C2 (K) of log10 aT = -C1 (T - Tg)/(C2 + T - Tg) above the glass transition (Williams,
    /// Landel and Ferry, J. Am. Chem. Soc. 77, 1955); 1 to 100 each in its unit, C2 to 1000.
    pub wlf: (f64, f64),
    /// Temperature above which cells of a sheet with fracture melt, °C, -273.15 to 5000; `None` for
    /// a material that does not melt.
    pub melts_at: Option<f64>,
    /// Fracture strain: largest principal strain of the mid-surface, 0.001 to 10; `None` for a
    /// material without fracture.
    pub tears_at: Option<f64>,
    /// Adhesion constants; `None` for a material without adhesion.
    pub tack: Option<Adhesion>,
    /// Thermal sensitivity C of the thesis's formulas, N/K, 0 to 1e6; `None` for that of the
    /// scene's `heat_mode`.
    pub thesis_sensitivity: Option<f64>,
    /// Thermal conductivity coefficient of the thesis's formulas, 0 to 1e3; `None` for that of the
    /// scene's `heat_mode`.
    pub thesis_conductivity: Option<f64>,
}

/// Adhesion of a hot material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adhesion {
    /// Adhesion strength, tensile stress that a bond bears, Pa; 1e-3 to 1e9.
    pub strength: f64,
    /// Temperature above which bonds form, °C, -273.15 to 5000.
    pub above: f64,
    /// Temperature below which bonds open, °C, -273.15 to 5000, at most `above`; `None` for bonds
    /// that last when cold.
    pub lets_go_below: Option<f64>,
}

/// Creep by Burgers' model: under a constant stress σ the strain is σ/E (1 + t/τ₁ + r (1 -
/// e^(-t/τ₂))). Times hold at the glass transition, or at any temperature where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BurgersCreep {
    /// Relaxation time τ₁ of the Maxwell element, s; 1e-6 to 1e30.
    pub relaxation_time: f64,
    /// Retardation time τ₂ of the Kelvin-Voigt element, s; 1e-6 to 1e30.
    #[serde(default = "BurgersCreep::retardation_by_default")]
    pub retardation_time: f64,
    /// Ratio r of retarded to instantaneous strain, 0 to 1e4; 0 for a Maxwell element alone.
    #[serde(default)]
    pub retarded: f64,
}

impl BurgersCreep {
    fn retardation_by_default() -> f64 {
        1.0
    }
}

/// Glassy polymers, estimates of the class. The relaxation time of 1e9 s at the glass transition
/// keeps a shape for hours; 40 K above it the WLF shift reduces it to 25 s.
const GLASSY: Option<BurgersCreep> = Some(BurgersCreep { relaxation_time: 1e9, retardation_time: 1e8, retarded: 0.5 });

/// C1 and C2 (K) of the universal WLF equation, which fit most polymers.
const UNIVERSAL_WLF: (f64, f64) = (17.44, 51.6);

impl Default for Material {
    /// Sheet of the thesis.
    fn default() -> Self {
        THESIS
    }
}

const THESIS: Material = row([185.0, 0.38, 1045.0, 1.0e-3], [1300.0, 0.16, 0.90, 7e-5], 0.02, None, None);

/// Row of the library: E, ν, ρ, t; c, k, ε, expansion; damping ratio, yield stress, glass
/// transition.
const fn row(
    [young, poisson, density, thickness]: [f64; 4],
    [specific_heat, conductivity, emissivity, expansion]: [f64; 4],
    damping_ratio: f64,
    yield_stress: Option<f64>,
    glass_transition: Option<f64>,
) -> Material {
    Material {
        name: String::new(),
        young,
        poisson,
        density,
        thickness,
        damping_ratio,
        loss_factor: None,
        yield_stress,
        hardening: 0.0,
        burgers: match glass_transition {
            Some(_) => GLASSY,
            None => None,
        },
        orthotropic: None,
        specific_heat,
        conductivity,
        emissivity,
        expansion,
        glass_transition,
        softening: Vec::new(),
        wlf: UNIVERSAL_WLF,
        melts_at: None,
        tears_at: None,
        thesis_sensitivity: None,
        thesis_conductivity: None,
        tack: None,
    }
}

impl Material {
    /// The material with a fracture strain `tears_at` and a melting temperature `melts_at` (°C).
    const fn with_fracture(mut self, tears_at: f64, melts_at: Option<f64>) -> Self {
        (self.tears_at, self.melts_at) = (Some(tears_at), melts_at);
        self
    }

    /// Stiffness per width of a sheet of this material.
    pub fn target(&self) -> StiffnessTarget {
        match &self.orthotropic {
            Some(measured) => StiffnessTarget::of_measured(measured),
            None => StiffnessTarget::of_plate(self.young, self.poisson, self.thickness),
        }
    }

    /// Damping ratio of a sheet's slowest bending motion, η/2 with a loss factor η.
    pub fn damping(&self) -> f64 {
        self.loss_factor.map_or(self.damping_ratio, |eta| 0.5 * eta)
    }

    /// Plate stiffness D = E t³ / (12 (1-ν²)) along the length, N m.
    pub fn plate_stiffness(&self) -> f64 {
        self.target().bending[0][0]
    }

    /// Mass per area ρ t, kg/m².
    pub fn areal_mass(&self) -> f64 {
        self.density * self.thickness
    }

    /// Stiffness and damping of a sheet of this material whose longer side is `length` (m), with a
    /// damping ratio `damping_ratio` of its slowest bending motion as a cantilever of that length,
    /// and of its slowest stretching motion when held at both ends.
    ///
    ///   ω = 1.8751² √(D/ρt)/L²,  ω = π √(A/ρt)/L,  ζ = τ ω/2,
    ///
    /// the angular frequencies of these motions, A membrane stiffness, and the damping of a
    /// Kelvin-Voigt solid, give the two retardation times τ (s).
    pub fn law(&self, length: f64, damping_ratio: f64) -> ElementLaw {
        let StiffnessTarget { membrane, bending } = self.target();
        let slowest = 3.516_015 * (bending[0][0] / self.areal_mass()).sqrt() / (length * length);
        let stretching = PI * (membrane[0][0] / self.areal_mass()).sqrt() / length;
        let (retardation, membrane_retardation) = (2.0 * damping_ratio / slowest, 2.0 * damping_ratio / stretching);
        ElementLaw { membrane, bending, retardation, membrane_retardation, arms: [0.0; ARMS] }
    }
}

/// Library: name, one-line description, constants.
///
/// Damping ratios are half the loss factors of the class at room temperature (from 0.002 for metals
/// to 0.3 for plasticised PVC). Yield stresses are tensile, for paper and card the end of
/// proportionality. Expansions and fracture strains (elongations at break) are those of the class.
/// Polymers without a melting point melt where they are soft enough to drip.
pub const LIBRARY: &[(&str, &str, Material)] = &[
    ("thesis", "the thesis's soft sheet: planar springs of 0.185 N/m", THESIS),
    (
        "hips",
        "high-impact polystyrene, 0.5 mm",
        row([2.0e9, 0.38, 1045.0, 5.0e-4], [1300.0, 0.16, 0.90, 8e-5], 0.015, Some(2.0e7), Some(100.0))
            .with_fracture(0.4, Some(240.0)),
    ),
    (
        "pvc",
        "rigid PVC, 0.4 mm",
        row([2.8e9, 0.38, 1390.0, 4.0e-4], [950.0, 0.16, 0.91, 7e-5], 0.015, Some(5.0e7), Some(82.0))
            .with_fracture(0.3, Some(200.0)),
    ),
    (
        "pvc-plasticised",
        "plasticised PVC, 0.4 mm",
        row([1.0e7, 0.45, 1250.0, 4.0e-4], [1400.0, 0.17, 0.92, 1.2e-4], 0.15, None, Some(0.0))
            .with_fracture(2.5, Some(180.0)),
    ),
    (
        "packaging-pvc",
        "packaging PVC, 0.15 mm",
        row([2.8e9, 0.38, 1390.0, 1.5e-4], [950.0, 0.16, 0.91, 7e-5], 0.015, Some(5.0e7), Some(80.0))
            .with_fracture(0.3, Some(160.0)),
    ),
    (
        "pet",
        "PET film, 0.1 mm",
        row([4.5e9, 0.38, 1395.0, 1.0e-4], [1170.0, 0.15, 0.85, 6e-5], 0.01, Some(1.0e8), Some(70.0))
            .with_fracture(1.0, Some(255.0)),
    ),
    (
        "paper",
        "printer paper, 80 g/m²",
        row([3.0e9, 0.30, 800.0, 1.0e-4], [1340.0, 0.10, 0.93, 1e-5], 0.02, Some(2.0e7), None)
            .with_fracture(0.02, None),
    ),
    (
        "card",
        "card, 300 g/m²",
        row([2.5e9, 0.30, 750.0, 4.0e-4], [1340.0, 0.10, 0.93, 1e-5], 0.02, Some(1.5e7), None)
            .with_fracture(0.02, None),
    ),
    (
        "playing-card",
        "playing card, 0.3 mm",
        row([3.0e9, 0.30, 850.0, 3.0e-4], [1340.0, 0.10, 0.93, 1e-5], 0.02, Some(2.0e7), None)
            .with_fracture(0.02, None),
    ),
    (
        "steel-foil",
        "steel foil, 0.1 mm",
        row([2.05e11, 0.29, 7850.0, 1.0e-4], [480.0, 50.0, 0.15, 1.2e-5], 0.001, Some(5.0e8), None)
            .with_fracture(0.1, Some(1450.0)),
    ),
    (
        "aluminium-foil",
        "aluminium foil, 16 µm",
        row([6.9e10, 0.33, 2700.0, 1.6e-5], [900.0, 220.0, 0.04, 2.3e-5], 0.001, Some(5.0e7), None)
            .with_fracture(0.03, Some(660.0)),
    ),
    // The four sheets that the thesis dropped (5.2.2). It names material and thickness and says how
    // they bend; constants are those of the class. Styrene: as `hips` (E 1.6 to 2.4 GPa, 1040
    // kg/m³; Cardarelli, Materials Handbook). The 0.4 mm PVC has no bending stiffness to speak of
    // and is dense: plasticised and filled (1350 to 1700 kg/m³; Practical Guide to Polyvinyl
    // Chloride, Rapra), E an estimate. The packaging grade is thinner and less dense: rigid,
    // modified for impact (1350 to 1420 kg/m³ there), its thickness an estimate.
    (
        "styrene-0.25mm",
        "the thesis's 0.25 mm styrene",
        row([2.0e9, 0.38, 1045.0, 2.5e-4], [1300.0, 0.16, 0.90, 8e-5], 0.015, Some(2.0e7), Some(100.0))
            .with_fracture(0.4, Some(240.0)),
    ),
    (
        "styrene-0.5mm",
        "the thesis's 0.5 mm styrene",
        row([2.0e9, 0.38, 1045.0, 5.0e-4], [1300.0, 0.16, 0.90, 8e-5], 0.015, Some(2.0e7), Some(100.0))
            .with_fracture(0.4, Some(240.0)),
    ),
    (
        "soft-pvc-0.4mm",
        "the thesis's 0.4 mm PVC, soft",
        row([1.0e7, 0.45, 1400.0, 4.0e-4], [1400.0, 0.17, 0.92, 1.2e-4], 0.15, None, Some(0.0))
            .with_fracture(2.0, Some(180.0)),
    ),
    (
        "packaging-grade-pvc",
        "the thesis's packaging/industrial grade PVC, 0.15 mm",
        row([2.4e9, 0.38, 1350.0, 1.5e-4], [950.0, 0.16, 0.91, 7e-5], 0.015, Some(4.5e7), Some(78.0))
            .with_fracture(0.5, Some(160.0)),
    ),
    (
        "rubber",
        "rubber sheet, 1 mm",
        row([3.0e6, 0.49, 1100.0, 1.0e-3], [1900.0, 0.16, 0.94, 2e-4], 0.05, None, None).with_fracture(4.0, None),
    ),
];

/// Material `name` of the library.
///
/// # Errors
/// When there is none; the message lists the names.
pub fn by_name(name: &str) -> Result<Material, InputError> {
    let found = LIBRARY.iter().find(|(n, _, _)| *n == name);
    found.map(|(_, _, m)| Material { name: name.to_owned(), ..m.clone() }).ok_or_else(|| {
        let names: Vec<&str> = LIBRARY.iter().map(|(n, _, _)| *n).collect();
        InputError::unknown_name("material", "material", name, &names)
    })
}

/// Read a material file: constants as in a scene, `(young: 2e9, thickness: 5e-4, ...)`; defaults
/// are those of `thesis`.
///
/// # Errors
/// When it cannot be opened, is not RON, has an unknown or ill-typed field, or a value out of
/// range: with file, line, field.
pub fn read_material_file(file: &Path) -> Result<Material, InputError> {
    let text = std::fs::read_to_string(file).map_err(|e| InputError::io(file, &e))?;
    let material = read_material(&text).map_err(|e| e.in_file(file))?;
    Ok(Material { name: stem(file), ..material })
}

/// Read a material from the text of a file; its name is that of its `name` field.
///
/// # Errors
/// As [`read_material_file`], without the file.
pub fn read_material(text: &str) -> Result<Material, InputError> {
    Ok(read_ron(text, |m| validate::material("", m))?)
}

/// Name of a material from its file's name.
fn stem(file: &Path) -> String {
    file.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Material in a scene: `"hips"`, `"materials/cloth.ron"` or `(young: 2e9, thickness: 0.0005,
/// ...)`.
// A scene has few materials, and most in-line ones are read once.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialChoice {
    /// A material of the library, by name.
    Named(String),
    /// A material file, relative to the scene's folder; its name ends in `.ron`.
    File(PathBuf),
    /// An in-line material; defaults are those of the `thesis` material.
    Inline(Material),
}

impl From<&str> for MaterialChoice {
    /// A file where the name ends in `.ron`, otherwise a material of the library.
    fn from(name: &str) -> Self {
        if name.ends_with(".ron") { Self::File(name.into()) } else { Self::Named(name.to_owned()) }
    }
}

impl MaterialChoice {
    /// Constants of the material; a file's name is relative to `base`.
    ///
    /// # Errors
    /// When the name is not in the library, or the file is not a valid material.
    pub fn resolve(&self, base: &Path) -> Result<Material, InputError> {
        match self {
            Self::Named(name) => by_name(name),
            Self::File(file) => read_material_file(&base.join(file)),
            Self::Inline(material) => Ok(material.clone()),
        }
    }

    /// Apply `check` to the constants of the material; a file is checked when the sheet is built.
    pub(crate) fn check(&self, check: impl Fn(&Material) -> Result<(), InputError>) -> Result<(), InputError> {
        match self {
            Self::Named(name) => check(&by_name(name)?),
            Self::Inline(constants) => check(constants),
            Self::File(_) => Ok(()),
        }
    }

    /// Name in material pairs, empty for an in-line material without a name. No file is read.
    pub fn name(&self) -> String {
        match self {
            Self::Named(name) => name.clone(),
            Self::File(file) => stem(file),
            Self::Inline(material) => material.name.clone(),
        }
    }
}

impl Serialize for MaterialChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Named(name) => serializer.serialize_str(name),
            Self::File(file) => serializer.serialize_str(&file.to_string_lossy()),
            Self::Inline(material) => material.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for MaterialChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choice;
        impl<'de> Visitor<'de> for Choice {
            type Value = MaterialChoice;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a material's name, its file or its constants")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(name.into())
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Material::deserialize(MapAccessDeserializer::new(map)).map(MaterialChoice::Inline)
            }
        }
        deserializer.deserialize_any(Choice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn every_material_of_the_library_is_valid() {
        for (name, _, material) in LIBRARY {
            validate::material(name, material).expect("valid");
        }
    }

    #[test]
    fn sheets_bend_under_their_weight_over_the_tabled_lengths() {
        // Gravito-bending lengths (D/(ρ g t))^(1/3), m, by hand from the class averages.
        let tabled = [
            ("hips", 0.168),
            ("pvc", 0.147),
            ("pvc-plasticised", 0.024),
            ("packaging-pvc", 0.077),
            ("pet", 0.068),
            ("paper", 0.070),
            ("card", 0.171),
            ("playing-card", 0.144),
            ("steel-foil", 0.134),
            ("aluminium-foil", 0.040),
            ("rubber", 0.031),
            ("styrene-0.25mm", 0.106),
            ("styrene-0.5mm", 0.168),
            ("soft-pvc-0.4mm", 0.023),
            ("packaging-grade-pvc", 0.074),
        ];
        assert_eq!(tabled.len(), LIBRARY.len() - 1);
        for (name, length) in tabled {
            let m = by_name(name).expect("there");
            let found = (m.plate_stiffness() / (m.areal_mass() * 9.81)).cbrt();
            assert!((found - length).abs() < 6e-4, "{name}: {found}");
        }
    }

    #[test]
    fn the_sheets_of_the_thesis_are_in_its_order() {
        // Sections 5.2.2 and 5.2.3: thicker styrene is heavier and bends wider; the 0.4 mm PVC is
        // denser than styrene and drapes freely; packaging PVC is thinner and less dense than it.
        let of = |name: &str| by_name(name).expect("there");
        let (thin, thick) = (of("styrene-0.25mm"), of("styrene-0.5mm"));
        let (soft, packaging) = (of("soft-pvc-0.4mm"), of("packaging-grade-pvc"));
        let length = |m: &Material| (m.plate_stiffness() / (m.areal_mass() * 9.81)).cbrt();
        assert_eq!([&thin, &thick, &soft].map(|m| m.thickness), [2.5e-4, 5e-4, 4e-4]);
        assert!(thick.areal_mass() > thin.areal_mass() && length(&thick) > 1.5 * length(&thin));
        assert!(soft.density > thick.density && length(&soft) < 0.25 * length(&thin));
        assert!(packaging.thickness < 0.5 * soft.thickness && packaging.density < soft.density);
        assert!(length(&packaging) < length(&thin));
    }

    #[test]
    fn a_sheet_of_kawabata_goes_in_as_it_comes() {
        let text = r#"(sheets: [(structure: "shell", grid: (9, 1, 9), material: (orthotropic: (
            units: Kawabata, extension_warp: 4.2, extension_weft: 5.0, shear: 0.62, poisson: 0.2,
            bending_warp: 0.052, bending_weft: 0.045, bending_bias: 0.038, bending_poisson: 0)))])"#;
        let scene = Scene::parse(text).expect("valid");
        let found = scene.sheets[0].material.resolve(Path::new("")).expect("valid").orthotropic.expect("measured");
        assert!((found.young_warp - 500.0 * 0.980_665 / 0.042).abs() < 1e-6, "{found:?}");
        assert!((found.bending_at(45.0) / 0.038 / 9.806_65e-5 - 1.0).abs() < 1e-12);
        // A written law is in N/m and N m, and reads as the same material.
        assert_eq!(Scene::parse(&scene.to_text().expect("text")).expect("valid"), scene);
        let turned = |path: &str, value: &str| scene.with_override(&format!("sheets.0.{path}"), value);
        assert!(turned("material.orthotropic.direction", "90").is_ok());
        let error = turned("material.orthotropic.direction", "45").expect_err("a grid").to_string();
        assert!(error.contains("outline"), "{error}");
        let bad = text.replace("poisson: 0.2", "young_bias: 900").replace("units: Kawabata,", "units: Kawabata,\n");
        let error = Scene::parse(&bad).expect_err("contradictory").to_string();
        assert!(error.contains("Poisson's ratio of") && error.contains("young_bias"), "{error}");
    }

    #[test]
    fn a_material_is_a_name_a_file_or_constants() {
        let text = r#"(sheets: [(name: "a", material: "card"), (name: "b", material: "cloth.ron"),
            (name: "c", material: (young: 3e9, yield_stress: 2e7, orthotropic: (young_warp: 4000, young_weft: 3000,
            shear: 40, poisson: 0.2, bending_warp: 1e-5, bending_weft: 6e-6, twist: 3e-6)))])"#;
        let scene = Scene::parse(text).expect("valid");
        assert_eq!(scene.sheets[0].material, MaterialChoice::Named("card".into()));
        assert_eq!(scene.sheets[1].material, MaterialChoice::File("cloth.ron".into()));
        let MaterialChoice::Inline(inline) = &scene.sheets[2].material else { panic!("in line") };
        assert_eq!((inline.yield_stress, inline.density), (Some(2e7), THESIS.density));
        assert_eq!(inline.target().bending[1][1], 6e-6);
        assert_eq!(Scene::parse(&scene.to_text().expect("text")).expect("valid"), scene);
        let changed = scene.with_override("sheets.c.material.orthotropic.twist", "2e-6").expect("valid");
        assert_eq!(changed.sheets[2].material.resolve(Path::new("")).expect("valid").target().bending[2][2], 2e-6);
        assert!(scene.with_override("sheets.b.material.young", "1e9").expect_err("no such file").file.is_some());
    }

    #[test]
    fn a_bad_material_names_file_line_and_range() {
        let folder = std::env::temp_dir().join(format!("sheetwork-material-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("writable");
        let file = folder.join("bad.ron");
        let refused = |text: &str| {
            std::fs::write(&file, text).expect("writable");
            read_material_file(&file).expect_err("bad")
        };
        let error = refused("(\n  young: 1e9,\n  damping_ratio: 11,\n)");
        assert_eq!((error.file.as_deref(), error.line, error.field.as_str()), (Some(&*file), Some(3), "damping_ratio"));
        assert!(error.problem.contains("11 of critical") && error.problem.contains("0 to 10"), "{error}");
        let error = refused("(\n  yung: 1e9,\n)");
        assert!(error.line == Some(2) && error.problem.contains("yung"), "{error}");
        let woven = "(orthotropic: (young_warp: 1, young_weft: 1,\n shear: 0.3, poisson: 1.2, bending_warp: 1, \
                     bending_weft: 1, twist: 0.3))";
        let error = refused(woven);
        assert_eq!((error.line, error.field.as_str()), (Some(2), "orthotropic.poisson"));
        std::fs::remove_dir_all(&folder).expect("removable");
        assert!(read_material_file(&file).expect_err("gone").problem.contains("cannot be opened"));
    }
}
