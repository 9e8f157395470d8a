//! A rigid body of a scene, as data: what it is, where it is put, and how it moves.
//!
//! A body with neither a path nor a mass stands still; one with a path is led along it, whatever it meets; one with a mass
//! (kg) or a density (kg/m³) moves freely: it falls, is pushed and pushes.

use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::{PathKey, Placement, Polyhedron};

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Name in reports; empty for "body N".
    #[serde(default)]
    pub name: String,
    /// What it is.
    pub shape: Shape,
    /// Where it is put.
    #[serde(default)]
    pub placement: Placement,
    /// How it is led; empty for a body that stands still or moves freely.
    #[serde(default)]
    pub path: Vec<PathKey>,
    /// Mass of a body that moves freely, kg, spread evenly over its shape; 1e-9 to 1e9. Not together with `density` or `path`,
    /// and not for a half space.
    #[serde(default)]
    pub mass: Option<f64>,
    /// Density of a body that moves freely, kg/m³, in place of its mass; 1e-3 to 1e6.
    #[serde(default)]
    pub density: Option<f64>,
    /// Velocity of the centre of mass at the start, m/s, for a body that moves freely; each component within ±1e3.
    #[serde(default)]
    pub velocity: DVec3,
    /// Angular velocity at the start, rad/s, for a body that moves freely; each component within ±1e4.
    #[serde(default)]
    pub spin: DVec3,
    /// What it is made of, as the scene's pairs of materials name it.
    #[serde(default)]
    pub material: Option<String>,
    /// Friction coefficient, 0 to 10; the scene's default if none.
    #[serde(default)]
    pub friction: Option<f64>,
    /// Restitution coefficient, 0 to 1; the scene's default if none.
    #[serde(default)]
    pub restitution: Option<f64>,
    /// Temperature, °C, -273.15 to 5000, of a body that gives heat to what touches it, or takes it; none for one that does not.
    #[serde(default)]
    pub temperature: Option<f64>,
}

/// The shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A .POL file; all its polyhedra together are one body.
    File(PathBuf),
    /// One polyhedron of a .POL file, by number from 0.
    Part(PathBuf, usize),
    /// A polyhedron given in place.
    Polyhedron(Polyhedron),
    /// A box of this size (x, y, z), m, about its centre.
    Box(DVec3),
    /// A ball of this radius, m, about its centre.
    Ball(f64),
    /// Everything below the local plane y = 0.
    HalfSpace,
}

impl BodySpec {
    /// A body of this shape that stands still at the origin, with the scene's contact coefficients.
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
        }
    }

    /// Whether it moves freely: falls, is pushed and pushes.
    pub fn is_dynamic(&self) -> bool {
        self.mass.is_some() || self.density.is_some()
    }
}
