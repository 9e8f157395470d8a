//! Component that describes a rigid body.

use bevy::math::DVec3;
use bevy::prelude::*;
use sheetwork::scene::{PathKey, Polyhedron};

use super::SheetPolyhedra;

/// Rigid body in contact with sheets: static, kinematic or dynamic.
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
/// The scale of the entity scales the body; a ball uses the x component. A body without mass or
/// density is kinematic: when its `Transform` or that of an ancestor changes, the body moves to the
/// new pose at constant velocity during the next tick. A body with mass or density is dynamic: its
/// `Transform` is the initial pose, which the plugin then overwrites.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform)]
#[cfg_attr(feature = "render", require(Visibility))]
pub struct SheetBody {
    /// Name in the world and in events, made unique there. When empty, the entity's `Name` is used.
    pub name: String,
    /// Shape.
    pub shape: BodyShape,
    /// Coulomb friction coefficient, 0 to 10; `None` for the world's default.
    pub friction: Option<f64>,
    /// Coefficient of restitution, 0 to 1; `None` for the world's default.
    pub restitution: Option<f64>,
    /// Path of displacements from the initial pose, with times in s since the spawn. A body with a
    /// path is kinematic, and the plugin writes its `Transform`.
    #[reflect(ignore)]
    pub path: Vec<PathKey>,
    /// Mass of a dynamic body, kg, 1e-9 to 1e9. Excludes `density` and `path`.
    pub mass: Option<f64>,
    /// Density of a dynamic body, kg/m³, 1e-3 to 1e6. Excludes `mass` and `path`.
    pub density: Option<f64>,
    /// Initial velocity of a dynamic body, m/s; each component within ±1e3.
    pub velocity: DVec3,
    /// Initial angular velocity of a dynamic body, rad/s; each component within ±1e4.
    pub spin: DVec3,
    /// Name of the material in the world's material pairs.
    pub material: Option<String>,
    /// Constant temperature, °C, -273.15 to 5000, of a body that exchanges heat with sheets in
    /// contact; `None` for no exchange.
    pub temperature: Option<f64>,
}

/// Shape of a [`SheetBody`].
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum BodyShape {
    /// Box of this size (x, y, z), m, about its centre.
    Cuboid(DVec3),
    /// Ball of this radius, m.
    Ball(f64),
    /// Half-space below the local plane y = 0.
    HalfSpace {
        /// Side of the displayed square, m; 0 for none.
        drawn: f32,
    },
    /// Closed polyhedra, convex or not.
    Polyhedra(#[reflect(ignore)] Vec<Polyhedron>),
    /// Polyhedra of a `.pol` file. The body is added to the world once the file is loaded.
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
    /// Box of this size, m, about its centre.
    pub fn cuboid(x: impl Into<f64>, y: impl Into<f64>, z: impl Into<f64>) -> Self {
        BodyShape::Cuboid(DVec3::new(x.into(), y.into(), z.into())).into()
    }

    /// Ball of this radius, m, about its centre.
    pub fn ball(radius: impl Into<f64>) -> Self {
        BodyShape::Ball(radius.into()).into()
    }

    /// Half-space below the local plane y = 0, displayed as a square of 10 m.
    pub fn floor() -> Self {
        BodyShape::HalfSpace { drawn: 10.0 }.into()
    }

    /// Closed polyhedron, convex or not.
    pub fn polyhedron(polyhedron: Polyhedron) -> Self {
        BodyShape::Polyhedra(vec![polyhedron]).into()
    }

    /// Polyhedra of a `.pol` file.
    pub fn from_asset(handle: Handle<SheetPolyhedra>) -> Self {
        BodyShape::Asset(handle).into()
    }

    /// Set the name in the world and in events.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Set the Coulomb friction coefficient, 0 to 10. A contact combines the coefficients of sheet
    /// and body.
    pub fn friction(mut self, friction: impl Into<f64>) -> Self {
        self.friction = Some(friction.into());
        self
    }

    /// Set the coefficient of restitution, 0 to 1.
    pub fn restitution(mut self, restitution: impl Into<f64>) -> Self {
        self.restitution = Some(restitution.into());
        self
    }

    /// Make the body dynamic, with this mass, kg.
    pub fn mass(mut self, mass: impl Into<f64>) -> Self {
        self.mass = Some(mass.into());
        self
    }

    /// Make the body dynamic, with the mass of this density, kg/m³.
    pub fn density(mut self, density: impl Into<f64>) -> Self {
        self.density = Some(density.into());
        self
    }

    /// Set the initial velocity of a dynamic body, m/s.
    pub fn velocity(mut self, velocity: impl Into<DVec3>) -> Self {
        self.velocity = velocity.into();
        self
    }

    /// Set the initial angular velocity of a dynamic body, rad/s.
    pub fn spin(mut self, spin: impl Into<DVec3>) -> Self {
        self.spin = spin.into();
        self
    }

    /// Set the name of the material in the world's material pairs.
    pub fn made_of(mut self, material: impl Into<String>) -> Self {
        self.material = Some(material.into());
        self
    }

    /// Set the temperature, °C, at which the body exchanges heat with sheets in contact.
    pub fn temperature(mut self, celsius: impl Into<f64>) -> Self {
        self.temperature = Some(celsius.into());
        self
    }

    /// Whether the body is dynamic.
    pub fn is_free(&self) -> bool {
        self.mass.is_some() || self.density.is_some()
    }

    /// Make the body kinematic: it follows a path of displacements from its initial pose, with
    /// times in s since the spawn.
    pub fn along(mut self, path: impl Into<Vec<PathKey>>) -> Self {
        self.path = path.into();
        self
    }
}
