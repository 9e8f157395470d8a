//! The component that describes a sheet.

use std::path::PathBuf;

use bevy::math::DVec3;
use bevy::prelude::*;
use sheetwork::mesh::outline::{HoleSpec, OutlineSpec};
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{DetailSpec, Material, MaterialChoice, PathKey, PinSpec, Region, SheetSpec, SpringLaw};

use super::SheetState;
use super::reflect::SheetSpecReflect;

/// A sheet: spawn it, and it falls.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # fn setup(mut commands: Commands) {
/// commands.spawn(Sheet::new("hips"));
/// commands.spawn(Sheet::new("rubber").size(0.5, 0.3).grid(25, 15));
/// commands.spawn((Sheet::new("paper").clamp(Region::Left), Transform::from_xyz(0.0, 1.0, 0.0)));
/// # }
/// ```
///
/// It starts where the entity's global transform has it: length along local x, width along z, upper side +y, origin in the
/// middle of the bottom layer; the scale multiplies size and gap. From then on it is where the simulation takes it; its
/// mesh, [`SheetState`] and [`SheetMotion`](super::SheetMotion) follow, its `Transform` does not.
///
/// Changing the component while the sheet is in the world changes material, damping, drag, friction, restitution and the grid of a shell at once;
/// any other change builds the sheet anew at its entity's transform.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform, Visibility, SheetState)]
pub struct Sheet {
    /// All there is to say about it. Velocities and paths are along the world's axes; the placement is within the entity.
    #[reflect(remote = SheetSpecReflect)]
    pub spec: SheetSpec,
}

impl From<SheetSpec> for Sheet {
    fn from(spec: SheetSpec) -> Self {
        Self { spec }
    }
}

impl Sheet {
    /// A sheet of a real material, as stiff as that is, by its name in the library: `hips` (polystyrene), `pvc`, `pet`,
    /// `paper`, `card`, `steel-foil`, `rubber`... ([`LIBRARY`](sheetwork::scene::material::LIBRARY)). A name that is not in it
    /// is refused in the log.
    ///
    /// A shell of 21 by 21 masses, 25 cm square, of the thickness the material has there. It wants an implicit engine, which
    /// [`SheetWorld`](super::SheetWorld) has unless told otherwise.
    pub fn new(material: impl Into<String>) -> Self {
        SheetSpec {
            material: MaterialChoice::Named(material.into()),
            structure: StructureKind::Shell,
            springs: SpringLaw::Calibrated,
            grid: (21, 1, 21),
            size: (0.25, 0.25),
            ..SheetSpec::default()
        }
        .into()
    }

    /// A sheet read from a `.sht` file of this path (relative to the working directory).
    pub fn from_file(file: impl Into<PathBuf>) -> Self {
        SheetSpec { file: Some(file.into()), ..SheetSpec::default() }.into()
    }

    /// Name in the world, in events and parameter paths; made unique there. The entity's `Name` is used if this is empty.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.spec.name = name.into();
        self
    }

    /// Length (x) and width (z), m; 1e-6 to 1000.
    pub fn size(mut self, length: impl Into<f64>, width: impl Into<f64>) -> Self {
        self.spec.size = (length.into(), width.into());
        self
    }

    /// Levels of detail, followed where there is a [`SheetDetail`](super::SheetDetail): the grid as it is up to `distance` (m) from the camera, half
    /// as many cells along each side up to three times that, and a quarter beyond. After [`Sheet::grid`].
    pub fn detail_within(self, distance: impl Into<f64>) -> Self {
        let (distance, (nu, _, nv)) = (distance.into(), self.spec.grid);
        let part = |n: u32, by: u32| (n.saturating_sub(1) / by).max(2) + 1;
        let grid = |by: u32| (part(nu, by), part(nv, by));
        self.detail(DetailSpec::new([(grid(1), Some(distance)), (grid(2), Some(3.0 * distance)), (grid(4), None)]))
    }

    /// Levels of detail: grids, finest first, with the distances up to which they are wanted.
    pub fn detail(mut self, levels: DetailSpec) -> Self {
        self.spec.detail = Some(levels);
        self
    }

    /// Masses along length and width, 2 to 2000 each.
    pub fn grid(mut self, along_length: u32, along_width: u32) -> Self {
        self.spec.grid = (along_length, self.spec.grid.1, along_width);
        self
    }

    /// Layers (1 to 64) of a lattice and the distance between them, m (1e-7 to 10). The farther apart, the stiffer in bending,
    /// unless springs are [`SpringLaw::Calibrated`], which choose the distance themselves.
    pub fn layers(mut self, layers: u32, gap: impl Into<f64>) -> Self {
        self.spec.grid.1 = layers;
        self.spec.gap = gap.into();
        self
    }

    /// How the masses are connected; a lattice gets two layers if it can have them, without which it does not resist bending.
    pub fn structure(mut self, structure: StructureKind) -> Self {
        self.spec.structure = structure;
        let (fewest, most) = structure.info().layers;
        self.spec.grid.1 = 2.clamp(fewest, most);
        self
    }

    /// How springs get their stiffness from the material.
    pub fn springs(mut self, law: SpringLaw) -> Self {
        self.spec.springs = law;
        self
    }

    /// The outer boundary of a shell that is no rectangle.
    pub fn outline(mut self, outline: OutlineSpec) -> Self {
        self.spec.outline = Some(outline);
        self
    }

    /// A hole in a shell.
    pub fn hole(mut self, hole: HoleSpec) -> Self {
        self.spec.holes.push(hole);
        self
    }

    /// A line, (x, z) in m from the middle, that a shell is cut along.
    pub fn cut(mut self, line: impl Into<Vec<(f64, f64)>>) -> Self {
        self.spec.cuts.push(line.into());
        self
    }

    /// The material, given in place.
    pub fn material(mut self, material: Material) -> Self {
        self.spec.material = MaterialChoice::Inline(material);
        self
    }

    /// Damping ratio of the slowest bending motion, 0 to 10, in place of the material's own.
    pub fn damping_ratio(mut self, ratio: impl Into<f64>) -> Self {
        self.spec.damping_ratio = Some(ratio.into());
        self
    }

    /// Drag coefficients across and along the air stream, each 0 to 10.
    pub fn drag(mut self, across: impl Into<f64>, along: impl Into<f64>) -> Self {
        self.spec.drag = (across.into(), along.into());
        self
    }

    /// Dashpot along every spring, as a fraction of critical, 0 to 10: for the spring laws `Uniform` and `Length`.
    pub fn damping(mut self, damping: impl Into<f64>) -> Self {
        self.spec.damping = damping.into();
        self
    }

    /// Coulomb friction coefficient, 0 to 10.
    pub fn friction(mut self, friction: impl Into<f64>) -> Self {
        self.spec.friction = Some(friction.into());
        self
    }

    /// Coefficient of restitution, 0 to 1.
    pub fn restitution(mut self, restitution: impl Into<f64>) -> Self {
        self.spec.restitution = Some(restitution.into());
        self
    }

    /// Velocity it starts with, m/s, along the world's axes; each component within ±1e4.
    pub fn velocity(mut self, velocity: Vec3) -> Self {
        self.spec.velocity = velocity.as_dvec3();
        self
    }

    /// Spin it starts with about its centre of mass, rad/s, along the world's axes; each component within ±1e4.
    pub fn spin(mut self, spin: Vec3) -> Self {
        self.spec.spin = spin.as_dvec3();
        self
    }

    /// Holds the masses of a region where they start, and the slope of the sheet there: an edge between two boards.
    pub fn clamp(mut self, region: Region) -> Self {
        self.spec.pins.push(PinSpec::clamped(region));
        self
    }

    /// Glues the masses of `region` to the body of that name, where they are when the sheet is built; the body is there before
    /// the sheet.
    pub fn glue(mut self, region: Region, body: impl Into<String>) -> Self {
        self.spec.pins.push(PinSpec::glued(region, body));
        self
    }

    /// Holds the masses of a region where they start; a shell can turn about them, as on a hinge.
    pub fn pin(self, region: Region) -> Self {
        self.pin_along(region, [])
    }

    /// Leads the masses of a region along a path of displacements from where they start; times are s since the sheet was
    /// spawned.
    pub fn pin_along(mut self, region: Region, path: impl Into<Vec<PathKey>>) -> Self {
        self.spec.pins.push(PinSpec { path: path.into(), ..PinSpec::held(region) });
        self
    }

    /// Names the material point at (u, v), each 0 to 1 over the bottom layer, so that its place can be asked for.
    pub fn probe(mut self, name: impl Into<String>, u: f64, v: f64) -> Self {
        self.spec.probes.insert(name.into(), (u, v));
        self
    }

    /// The description of a sheet that is scaled by `scale`.
    pub(super) fn scaled(&self, scale: Vec3) -> SheetSpec {
        let mut spec = self.spec.clone();
        let scale = scale.abs().as_dvec3();
        // Left alone when it is 1 but for rounding, so that a plain sheet keeps exactly the size it was given.
        if (scale - DVec3::ONE).abs().max_element() > 1e-5 {
            spec.size = (spec.size.0 * scale.x, spec.size.1 * scale.z);
            spec.gap *= scale.y;
        }
        spec
    }
}
