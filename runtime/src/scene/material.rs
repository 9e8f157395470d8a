//! Materials: what a sheet is made of, by name or in line.
//!
//! E Young's modulus (Pa), ν Poisson's ratio, ρ density (kg/m³), t thickness (m). The thermal values are carried for the
//! heat model. Class averages for the real ones; `thesis` is the thesis's own soft sheet, whose planar springs of
//! 0.185 N/m (table 4.3) are E t with its layer distance of 1 mm as t.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::element::Law;
use crate::error::InputError;

/// Constants of a sheet material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Young's modulus E, Pa; 1e-3 to 2e12.
    pub young: f64,
    /// Poisson's ratio ν; -0.99 to 0.499.
    pub poisson: f64,
    /// Density ρ, kg/m³; 1e-3 to 1e6.
    pub density: f64,
    /// Thickness t, m; 1e-7 to 1.
    pub thickness: f64,
    /// Specific heat c, J/(kg K); 1 to 1e5.
    pub specific_heat: f64,
    /// Thermal conductivity, W/(m K); 0 to 1e4.
    pub conductivity: f64,
    /// Emissivity of the surface, 0 to 1.
    pub emissivity: f64,
}

impl Default for Material {
    /// The thesis's sheet.
    fn default() -> Self {
        THESIS
    }
}

const THESIS: Material = row(185.0, 0.38, 1045.0, 1.0e-3, 1300.0, 0.16, 0.90);

const fn row(young: f64, poisson: f64, density: f64, thickness: f64, c: f64, k: f64, emissivity: f64) -> Material {
    Material { young, poisson, density, thickness, specific_heat: c, conductivity: k, emissivity }
}

impl Material {
    /// Plate stiffness D = E t³ / (12 (1-ν²)), N m.
    pub fn plate_stiffness(&self) -> f64 {
        self.young * self.thickness.powi(3) / (12.0 * (1.0 - self.poisson * self.poisson))
    }

    /// Stiffness of a sheet of it whose longer side is `length` (m) and whose slowest bending motion, as a cantilever of
    /// that length, is damped by the fraction `damping_ratio` of critical.
    ///
    /// That motion has ω = 1.8751² √(D/ρt)/L²; a Kelvin-Voigt solid damps it by ζ = τ ω/2, which gives τ.
    pub fn law(&self, length: f64, damping_ratio: f64) -> Law {
        let nu = self.poisson;
        let shape = [[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]];
        let membrane = self.young * self.thickness / (1.0 - nu * nu);
        let bending = self.plate_stiffness();
        let slowest = 3.516_015 * (bending / (self.density * self.thickness)).sqrt() / (length * length);
        Law {
            membrane: shape.map(|row| row.map(|s| s * membrane)),
            bending: shape.map(|row| row.map(|s| s * bending)),
            retardation: 2.0 * damping_ratio / slowest,
        }
    }
}

/// The library: name, one-line description, constants.
pub const LIBRARY: &[(&str, &str, Material)] = &[
    ("thesis", "the thesis's soft sheet: planar springs of 0.185 N/m", THESIS),
    ("hips", "high-impact polystyrene, 0.5 mm", row(2.0e9, 0.38, 1045.0, 5.0e-4, 1300.0, 0.16, 0.90)),
    ("pvc", "rigid PVC, 0.4 mm", row(2.8e9, 0.38, 1390.0, 4.0e-4, 950.0, 0.16, 0.91)),
    ("pvc-plasticised", "plasticised PVC, 0.4 mm", row(1.0e7, 0.45, 1250.0, 4.0e-4, 1400.0, 0.17, 0.92)),
    ("packaging-pvc", "packaging PVC, 0.15 mm", row(2.8e9, 0.38, 1390.0, 1.5e-4, 950.0, 0.16, 0.91)),
    ("pet", "PET film, 0.1 mm", row(4.5e9, 0.38, 1395.0, 1.0e-4, 1170.0, 0.15, 0.85)),
    ("paper", "printer paper, 80 g/m²", row(3.0e9, 0.30, 800.0, 1.0e-4, 1340.0, 0.10, 0.93)),
    ("card", "card, 300 g/m²", row(2.5e9, 0.30, 750.0, 4.0e-4, 1340.0, 0.10, 0.93)),
    ("steel-foil", "steel foil, 0.1 mm", row(2.05e11, 0.29, 7850.0, 1.0e-4, 480.0, 50.0, 0.15)),
    ("aluminium-foil", "aluminium foil, 16 µm", row(6.9e10, 0.33, 2700.0, 1.6e-5, 900.0, 220.0, 0.04)),
    ("rubber", "rubber sheet, 1 mm", row(3.0e6, 0.49, 1100.0, 1.0e-3, 1900.0, 0.16, 0.94)),
];

/// The material of that name in the library.
///
/// # Errors
/// When there is none; the message lists the names.
pub fn by_name(name: &str) -> Result<Material, InputError> {
    LIBRARY.iter().find(|(n, _, _)| *n == name).map(|(_, _, m)| m.clone()).ok_or_else(|| {
        let names: Vec<&str> = LIBRARY.iter().map(|(n, _, _)| *n).collect();
        InputError::new("material", format!("no material is named \"{name}\"; there are {}", names.join(", ")))
    })
}

/// A material in a scene: `"hips"` or `(young: 2e9, thickness: 0.0005, ...)`.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialChoice {
    /// One of the library, by name.
    Named(String),
    /// Given in place; fields left out are those of the `thesis` material.
    Inline(Material),
}

impl MaterialChoice {
    /// The constants meant.
    ///
    /// # Errors
    /// When the name is not in the library.
    pub fn resolve(&self) -> Result<Material, InputError> {
        match self {
            Self::Named(name) => by_name(name),
            Self::Inline(material) => Ok(material.clone()),
        }
    }
}

impl Serialize for MaterialChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Named(name) => serializer.serialize_str(name),
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
                f.write_str("a material's name or its constants")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(MaterialChoice::Named(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Material::deserialize(MapAccessDeserializer::new(map)).map(MaterialChoice::Inline)
            }
        }
        deserializer.deserialize_any(Choice)
    }
}
