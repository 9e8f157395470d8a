//! Component that describes a sheet.

use std::path::PathBuf;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::reflect::{FromReflect, PartialReflect, ReflectDeserialize, ReflectFromReflect, ReflectSerialize};
use serde::{Deserialize, Serialize};
use sheetwork::mesh::outline::{HoleSpec, OutlineSpec};
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{DetailSpec, Material, MaterialChoice, PathKey, PinSpec, Region, SheetSpec, SpringLaw};

use super::SheetState;
use super::reflect::SheetSpecReflect;

/// Thin sheet, simulated from the time it is spawned.
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
/// The entity's global transform is the initial pose: length along local x, width along z, upper
/// side +y, origin in the middle of the bottom layer. Its scale multiplies size and gap. The
/// simulation then moves the nodes: mesh, [`SheetState`], [`SheetMotion`](super::SheetMotion) and
/// the `Transform` follow. The `Transform` is the pose that fits the bent sheet best. Writing it
/// puts the sheet there at once, with its shape and velocities; a restart of the world puts it back
/// to its first place. A tube has no such pose: its `Transform` stays, and writing it moves the
/// tube by the difference.
///
/// When a parent moves after the spawn, it leads the pinned nodes, at constant velocity during a
/// tick, and the free ones follow by their forces; a sheet without pins stays. A parent that moves
/// while time is paused takes a pinned sheet along at once. A changed scale of a parent, a turn of
/// one with clamped nodes, and pins with axes are refused with a message.
///
/// A change of material, damping, drag, friction, restitution, the grid of a shell, or of pins
/// without clamp, body and axes acts on the running sheet; paths and ends of new pins count from
/// then. Any other change of the component rebuilds the sheet at its entity's transform.
///
/// While its entity has Bevy's `Disabled`, the sheet is out of the simulation; it comes back with
/// its shape and velocities, and its paths go on from there. A hidden sheet is simulated.
///
/// It is serialised as in a scene file, with pins, outline and all that reflection does not name:
/// Bevy's scenes keep it.
///
/// The default is `Sheet::new("card")`. [`Sheet::thesis`] is the soft lattice of the thesis.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Clone, Debug, Default, FromReflect, PartialEq, Serialize, Deserialize)]
#[reflect(from_reflect = false)]
#[serde(transparent)]
#[require(Transform, SheetState)]
#[cfg_attr(feature = "render", require(Visibility))]
pub struct Sheet {
    /// Description of the sheet. Velocities and paths are in world axes; the placement is relative
    /// to the entity.
    #[reflect(remote = SheetSpecReflect)]
    pub spec: SheetSpec,
}

impl FromReflect for Sheet {
    /// A whole sheet keeps what reflection does not name.
    fn from_reflect(reflect: &dyn PartialReflect) -> Option<Self> {
        if let Some(sheet) = reflect.try_downcast_ref::<Self>() {
            return Some(sheet.clone());
        }
        let mut sheet = Self::default();
        sheet.try_apply(reflect).ok()?;
        Some(sheet)
    }
}

impl From<SheetSpec> for Sheet {
    fn from(spec: SheetSpec) -> Self {
        Self { spec }
    }
}

impl Sheet {
    /// Sheet of a library material with the stiffness of the real material: `hips` (polystyrene),
    /// `pvc`, `pet`, `paper`, `card`, `steel-foil`, `rubber`...
    /// ([`LIBRARY`](sheetwork::scene::material::LIBRARY)). An unknown name is reported in the log,
    /// and the sheet is not built.
    ///
    /// The sheet is a square shell of 21 x 21 nodes, 25 cm wide, with the thickness of the library.
    /// It needs an implicit integrator, as [`SheetWorld`](super::SheetWorld) has from its start.
    pub fn new(material: impl Into<String>) -> Self {
        SheetSpec::new(material).into()
    }

    /// The soft lattice of the thesis: `trimm`, 11 x 2 x 11 nodes, 25 mm square, of the material
    /// `thesis`.
    pub fn thesis() -> Self {
        SheetSpec::thesis().into()
    }

    /// Sheet of a `.sht` file at this path (relative to the working directory), of the material
    /// `thesis`.
    pub fn from_file(file: impl Into<PathBuf>) -> Self {
        SheetSpec { file: Some(file.into()), ..SheetSpec::thesis() }.into()
    }

    /// Set the name in the world, in events and in parameter paths, made unique there. When empty,
    /// the entity's `Name` is used.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.spec.name = name.into();
        self
    }

    /// Set length (x) and width (z), m; 1e-6 to 1000.
    pub fn size(mut self, length: impl Into<f64>, width: impl Into<f64>) -> Self {
        self.spec.size = (length.into(), width.into());
        self
    }

    /// Set three levels of detail: the present grid up to `distance` (m) from the camera, half as
    /// many cells along each side up to three times that distance, and a quarter beyond. Call it
    /// after [`Sheet::grid`]. Needs the resource [`SheetDetail`](super::SheetDetail).
    pub fn detail_within(self, distance: impl Into<f64>) -> Self {
        let (distance, (nu, _, nv)) = (distance.into(), self.spec.grid);
        let part = |n: u32, by: u32| (n.saturating_sub(1) / by).max(2) + 1;
        let grid = |by: u32| (part(nu, by), part(nv, by));
        self.detail(DetailSpec::new([(grid(1), Some(distance)), (grid(2), Some(3.0 * distance)), (grid(4), None)]))
    }

    /// Set the levels of detail: grids, finest first, and their maximum distances.
    pub fn detail(mut self, levels: DetailSpec) -> Self {
        self.spec.detail = Some(levels);
        self
    }

    /// Set the numbers of nodes along length and width, 2 to 2000 each.
    pub fn grid(mut self, along_length: u32, along_width: u32) -> Self {
        self.spec.grid = (along_length, self.spec.grid.1, along_width);
        self
    }

    /// Set the number of layers (1 to 64) of a lattice and the distance between them, m (1e-7 to
    /// 10). A larger distance increases the bending stiffness. [`SpringLaw::Calibrated`] computes
    /// the distance itself.
    pub fn layers(mut self, layers: u32, gap: impl Into<f64>) -> Self {
        self.spec.grid.1 = layers;
        self.spec.gap = gap.into();
        self
    }

    /// Set the discretisation. A lattice gets two layers where its structure permits; a single
    /// layer of springs has no bending stiffness.
    pub fn structure(mut self, structure: StructureKind) -> Self {
        self.spec.structure = structure;
        let (fewest, most) = structure.info().layers;
        self.spec.grid.1 = 2.clamp(fewest, most);
        self
    }

    /// Set the law that determines spring stiffnesses from the material.
    pub fn springs(mut self, law: SpringLaw) -> Self {
        self.spec.springs = law;
        self
    }

    /// Set the outer boundary of a shell that is not a rectangle.
    pub fn outline(mut self, outline: OutlineSpec) -> Self {
        self.spec.outline = Some(outline);
        self
    }

    /// Add a hole to a shell.
    pub fn hole(mut self, hole: HoleSpec) -> Self {
        self.spec.holes.push(hole);
        self
    }

    /// Cut a shell along a line of points (x, z), m, from its middle.
    pub fn cut(mut self, line: impl Into<Vec<(f64, f64)>>) -> Self {
        self.spec.cuts.push(line.into());
        self
    }

    /// Set the material by its constants.
    pub fn material(mut self, material: Material) -> Self {
        self.spec.material = MaterialChoice::Inline(material);
        self
    }

    /// Set the damping ratio of the slowest bending mode, 0 to 10, in place of the material's.
    pub fn damping_ratio(mut self, ratio: impl Into<f64>) -> Self {
        self.spec.damping_ratio = Some(ratio.into());
        self
    }

    /// Set the drag coefficients across and along the air stream, each 0 to 10.
    pub fn drag(mut self, across: impl Into<f64>, along: impl Into<f64>) -> Self {
        self.spec.drag = (across.into(), along.into());
        self
    }

    /// Set the dashpot of every spring, as a fraction of critical damping, 0 to 10. Used by the
    /// spring laws `Uniform` and `Length`.
    pub fn damping(mut self, damping: impl Into<f64>) -> Self {
        self.spec.damping = damping.into();
        self
    }

    /// Set the Coulomb friction coefficient, 0 to 10.
    pub fn friction(mut self, friction: impl Into<f64>) -> Self {
        self.spec.friction = Some(friction.into());
        self
    }

    /// Set the coefficient of restitution, 0 to 1.
    pub fn restitution(mut self, restitution: impl Into<f64>) -> Self {
        self.spec.restitution = Some(restitution.into());
        self
    }

    /// Set the initial velocity, m/s, in world axes; each component within ±1e4.
    pub fn velocity(mut self, velocity: Vec3) -> Self {
        self.spec.velocity = velocity.as_dvec3();
        self
    }

    /// Set the initial angular velocity about the centre of mass, rad/s, in world axes; each
    /// component within ±1e4.
    pub fn spin(mut self, spin: Vec3) -> Self {
        self.spec.spin = spin.as_dvec3();
        self
    }

    /// Clamp the nodes of a region: position and slope are fixed, as for an edge between two
    /// boards.
    pub fn clamp(mut self, region: Region) -> Self {
        self.spec.pins.push(PinSpec::clamped(region));
        self
    }

    /// Let the sheet tear where it is strained beyond the fracture strain of its material, and melt
    /// where it is hotter than its melting temperature.
    pub fn tearing(mut self) -> Self {
        self.spec.tearing = true;
        self
    }

    /// Attach the nodes of `region` to the body of that name, at their positions when the sheet is
    /// built. The body must exist before the sheet.
    pub fn glue(mut self, region: Region, body: impl Into<String>) -> Self {
        self.spec.pins.push(PinSpec::attached(region, body));
        self
    }

    /// Fix the nodes of a region at their initial positions. A shell can rotate about them, as on a
    /// hinge.
    pub fn pin(self, region: Region) -> Self {
        self.pin_along(region, [])
    }

    /// Prescribe the motion of the nodes of a region: a path of displacements from their initial
    /// positions, with times in s since the spawn.
    pub fn pin_along(mut self, region: Region, path: impl Into<Vec<PathKey>>) -> Self {
        self.spec.pins.push(PinSpec { path: path.into(), ..PinSpec::fixed(region) });
        self
    }

    /// Name the material point (u, v), each 0 to 1 on the bottom layer, as a probe whose position
    /// is reported.
    pub fn probe(mut self, name: impl Into<String>, u: f64, v: f64) -> Self {
        self.spec.probes.insert(name.into(), (u, v));
        self
    }

    /// Description of the sheet scaled by `scale`.
    pub(super) fn scaled(&self, scale: Vec3) -> SheetSpec {
        let mut spec = self.spec.clone();
        let scale = scale.abs().as_dvec3();
        // A scale of 1 within rounding keeps the exact size.
        if (scale - DVec3::ONE).abs().max_element() > 1e-5 {
            spec.size = (spec.size.0 * scale.x, spec.size.1 * scale.z);
            spec.gap *= scale.y;
        }
        spec
    }
}
