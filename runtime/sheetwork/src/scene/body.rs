//! Specification of a rigid body: shape, placement and motion.
//!
//! A body with neither a path nor a mass is static; one with a path is kinematic; one with a mass
//! (kg) or a density (kg/m³) is dynamic.

use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::{BodySpotSpec, OvenKey, PathKey, Placement, Polyhedron};

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Name in reports; empty for "body N".
    #[serde(default)]
    pub name: String,
    /// Shape of the body.
    pub shape: Shape,
    /// Initial placement.
    #[serde(default)]
    pub placement: Placement,
    /// Prescribed path; empty for a static or dynamic body.
    #[serde(default)]
    pub path: Vec<PathKey>,
    /// Mass of a dynamic body, kg, uniform over its shape; 1e-9 to 1e9. Excludes `density` and
    /// `path`, and the half space.
    pub mass: Option<f64>,
    /// Density of a dynamic body, kg/m³, in place of its mass; 1e-3 to 1e6.
    pub density: Option<f64>,
    /// Initial velocity of the centre of mass of a dynamic body, m/s; each component within ±1e3.
    #[serde(default)]
    pub velocity: DVec3,
    /// Initial angular velocity of a dynamic body, rad/s; each component within ±1e4.
    #[serde(default)]
    pub spin: DVec3,
    /// Material name in material pairs.
    pub material: Option<String>,
    /// Friction coefficient, 0 to 10; the scene's default if none.
    pub friction: Option<f64>,
    /// Restitution coefficient, 0 to 1; the scene's default if none.
    pub restitution: Option<f64>,
    /// Temperature, °C, -273.15 to 5000, of a body that exchanges heat by contact; `None` for a
    /// body without.
    pub temperature: Option<f64>,
    /// Temperatures at times, in place of `temperature`: linear in between, constant after the
    /// last; no exchange before the first. Empty for a constant temperature.
    #[serde(default)]
    pub temperature_schedule: Vec<OvenKey>,
    /// Rise of the temperature along the axes of the body from its origin, where it is
    /// `temperature`, K/m; each component within ±1e5. The temperature stays between absolute zero
    /// and 5000 °C.
    #[serde(default)]
    pub temperature_slope: DVec3,
    /// Places of the surface with another temperature, of a body that has one.
    #[serde(default)]
    pub hot_spots: Vec<BodySpotSpec>,
}

/// The shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// .POL file; all its polyhedra together are one body.
    File(PathBuf),
    /// One polyhedron of a .POL file, by index from 0.
    Part(PathBuf, usize),
    /// In-line polyhedron.
    Polyhedron(Polyhedron),
    /// Box of this size (x, y, z), m, about its centre.
    Box(DVec3),
    /// Ball of this radius, m, about its centre.
    Ball(f64),
    /// Half space below the local plane y = 0.
    HalfSpace,
}

impl BodySpec {
    /// Static body of this shape at the origin, with the scene's contact coefficients.
    pub fn new(shape: Shape) -> Self {
        Self {
            name: String::new(),
            shape,
            placement: Placement::default(),
            path: Vec::new(),
            mass: None,
            density: None,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            material: None,
            friction: None,
            restitution: None,
            temperature: None,
            temperature_schedule: Vec::new(),
            temperature_slope: DVec3::ZERO,
            hot_spots: Vec::new(),
        }
    }

    /// Whether the body is dynamic.
    pub fn is_dynamic(&self) -> bool {
        self.mass.is_some() || self.density.is_some()
    }

    /// Whether the body exchanges heat with sheets.
    pub fn is_hot(&self) -> bool {
        self.temperature.is_some() || !self.temperature_schedule.is_empty()
    }
}
