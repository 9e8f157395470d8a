//! The component that describes a rigid body.

use bevy::math::DVec3;
use bevy::prelude::*;
use sheetwork::scene::{PathKey, Polyhedron};

use super::SheetPolyhedra;

/// A rigid body that sheets meet: it stands still, goes where its entity's `Transform` is moved, or moves freely.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # fn setup(mut commands: Commands, server: Res<AssetServer>) {
/// commands.spawn(SheetBody::floor());
/// commands.spawn((SheetBody::ball(0.1), Transform::from_xyz(0.0, 0.3, 0.0)));
/// commands.spawn((SheetBody::ball(0.1).mass(0.2), Transform::from_xyz(0.0, 1.0, 0.0)));
/// commands.spawn(SheetBody::from_asset(server.load("polyhedra/wedge.pol")));
/// # }
/// ```
///
/// Scale the entity to scale the body (a ball by its x alone). Moving the `Transform`, or an ancestor's, carries sheets along:
/// the body gets there evenly during the next tick. A body with a mass or a density falls, is pushed and pushes; its
/// `Transform` is where it starts, and is then written, not read.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform, Visibility)]
pub struct SheetBody {
    /// Name in the world and in events; made unique there. The entity's `Name` is used if this is empty.
    pub name: String,
    /// What it is.
    pub shape: BodyShape,
    /// Coulomb friction coefficient, 0 to 10; the world's default if none.
    pub friction: Option<f64>,
    /// Coefficient of restitution, 0 to 1; the world's default if none.
    pub restitution: Option<f64>,
    /// A path it follows from where it is spawned, times in s since then. Its `Transform` is then written, not read.
    #[reflect(ignore)]
    pub path: Vec<PathKey>,
    /// Mass, kg, 1e-9 to 1e9, of a body that moves freely. Neither with `density` nor with a path.
    pub mass: Option<f64>,
    /// Density, kg/m³, 1e-3 to 1e6, of a body that moves freely, in place of its mass.
    pub density: Option<f64>,
    /// Velocity at the start, m/s, of a body that moves freely; each component within ±1e3.
    pub velocity: DVec3,
    /// Angular velocity at the start, rad/s, of a body that moves freely; each component within ±1e4.
    pub spin: DVec3,
    /// What it is made of, as the world's pairs of materials name it.
    pub material: Option<String>,
    /// Temperature, °C, -273.15 to 5000, of a body that gives heat to what touches it; it stays as warm as it is.
    pub temperature: Option<f64>,
}

/// The shape of a [`SheetBody`].
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum BodyShape {
    /// A box of this size (x, y, z), m, about its centre.
    Cuboid(DVec3),
    /// A ball of this radius, m.
    Ball(f64),
    /// Everything below the local plane y = 0.
    HalfSpace {
        /// Side of the square that is drawn of it, m; 0 for none.
        drawn: f32,
    },
    /// Closed polyhedra, convex or not.
    Polyhedra(#[reflect(ignore)] Vec<Polyhedron>),
    /// The polyhedra of a `.pol` file, once it is loaded.
    Asset(Handle<SheetPolyhedra>),
}

impl Default for BodyShape {
    fn default() -> Self {
        Self::Cuboid(DVec3::ONE)
    }
}

impl From<BodyShape> for SheetBody {
    fn from(shape: BodyShape) -> Self {
        Self { shape, ..Self::default() }
    }
}

impl SheetBody {
    /// A box of this size, m, about its centre.
    pub fn cuboid(x: impl Into<f64>, y: impl Into<f64>, z: impl Into<f64>) -> Self {
        BodyShape::Cuboid(DVec3::new(x.into(), y.into(), z.into())).into()
    }

    /// A ball of this radius, m, about its centre.
    pub fn ball(radius: impl Into<f64>) -> Self {
        BodyShape::Ball(radius.into()).into()
    }

    /// Everything below the local plane y = 0, drawn as a square of 10 m.
    pub fn floor() -> Self {
        BodyShape::HalfSpace { drawn: 10.0 }.into()
    }

    /// A closed polyhedron, convex or not.
    pub fn polyhedron(polyhedron: Polyhedron) -> Self {
        BodyShape::Polyhedra(vec![polyhedron]).into()
    }

    /// The polyhedra of a `.pol` file.
    pub fn from_asset(handle: Handle<SheetPolyhedra>) -> Self {
        BodyShape::Asset(handle).into()
    }

    /// Name in the world and in events.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Coulomb friction coefficient, 0 to 10. A sheet and a body meet with the friction that both together have.
    pub fn friction(mut self, friction: impl Into<f64>) -> Self {
        self.friction = Some(friction.into());
        self
    }

    /// Coefficient of restitution, 0 to 1.
    pub fn restitution(mut self, restitution: impl Into<f64>) -> Self {
        self.restitution = Some(restitution.into());
        self
    }

    /// Lets it move freely with this mass, kg.
    pub fn mass(mut self, mass: impl Into<f64>) -> Self {
        self.mass = Some(mass.into());
        self
    }

    /// Lets it move freely with the mass that this density gives it, kg/m³.
    pub fn density(mut self, density: impl Into<f64>) -> Self {
        self.density = Some(density.into());
        self
    }

    /// Velocity at the start, m/s, of a body that moves freely.
    pub fn velocity(mut self, velocity: impl Into<DVec3>) -> Self {
        self.velocity = velocity.into();
        self
    }

    /// Angular velocity at the start, rad/s, of a body that moves freely.
    pub fn spin(mut self, spin: impl Into<DVec3>) -> Self {
        self.spin = spin.into();
        self
    }

    /// What it is made of, as the world's pairs of materials name it.
    pub fn made_of(mut self, material: impl Into<String>) -> Self {
        self.material = Some(material.into());
        self
    }

    /// Makes it as warm as this, °C: it gives heat to the sheets that touch it.
    pub fn temperature(mut self, celsius: impl Into<f64>) -> Self {
        self.temperature = Some(celsius.into());
        self
    }

    /// Whether it moves freely.
    pub fn is_free(&self) -> bool {
        self.mass.is_some() || self.density.is_some()
    }

    /// Leads it along a path of displacements from where it is spawned; times are s since then.
    pub fn along(mut self, path: impl Into<Vec<PathKey>>) -> Self {
        self.path = path.into();
        self
    }
}
