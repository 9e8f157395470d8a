//! Specification of a scene: sheets, bodies, heaters, integrator, gravity, room, as data.
//!
//! The structs of this module are the scene file (RON) field by field; `assets/README.md` documents
//! the fields for authors of files. All values are SI, except angles, which are in degrees for
//! readability. `load` reads files and `validate` checks ranges, so that files, command-line
//! overrides and programs pass the same checks.

pub mod adhesion;
pub(crate) mod air;
pub(crate) mod body;
pub(crate) mod builder;
#[doc(hidden)]
pub mod contact;
pub mod contact_surface;
mod defaults;
pub mod fracture;
pub(crate) mod heat_sources;
pub mod heater_file;
pub mod integrator;
pub mod inter_layer;
#[doc(hidden)]
pub mod library;
pub(crate) mod literal;
pub mod load;
pub(crate) mod locate;
pub(crate) mod lod;
pub mod material;
pub(crate) mod nesting;
pub mod pol;
pub mod polyhedron;
pub(crate) mod record_lines;
pub(crate) mod recovery_policy;
pub(crate) mod refine;
pub mod rest_shape;
pub mod sht;
#[doc(hidden)]
pub mod sleep;
pub mod spot;
#[doc(hidden)]
pub mod validate;

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

pub use crate::scene::air::{
    Aerodynamics, Air, BlastSpec, FluidSpec, GustSpec, TurbulenceSpec, VortexSpec, WindZone, ZoneVolume,
};
pub use crate::scene::body::{BodySpec, Shape};
pub use crate::scene::contact::{ContactDefaults, PairSpec};
pub use crate::scene::contact_surface::ContactSurface;
pub use crate::scene::heat_sources::{HeatGunSpec, HeatMode, HeaterSpec, HotFaceSpec, OvenKey, OvenSpec};
pub use crate::scene::integrator::IntegratorKind;
pub use crate::scene::inter_layer::InterLayerLaw;
pub use crate::scene::lod::{DetailLevel, DetailSpec};
pub use crate::scene::material::{Adhesion, BurgersCreep, Material, MaterialChoice};
pub use crate::scene::polyhedron::Polyhedron;
pub use crate::scene::recovery_policy::WhenUnstable;
pub use crate::scene::refine::RefineSpec;
pub use crate::scene::rest_shape::CreaseSpec;

use crate::mesh::outline::{HoleSpec, OutlineSpec};
use crate::mesh::slits::Slit;
use crate::mesh::structure::StructureKind;
pub use crate::scene::spot::{BodySpotSpec, SpotSpec};

/// Scene: the contents of a scene file. The default is empty, with the implicit integrator
/// `tr-bdf2` and steps of 1/60 s; [`Scene::thesis`] has the explicit integrator of the thesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// Short name, shown in menus and reports.
    pub name: String,
    /// Description of the scene, in a sentence or two.
    pub description: String,
    /// Acceleration of gravity, m/s²; each component within ±1000.
    pub gravity: DVec3,
    /// Time integrator of every sheet.
    pub engine: IntegratorKind,
    /// Time step, s; 1e-7 to 1.
    pub dt: f64,
    /// Position error tolerance of the adaptive integrator (`rk45`) per step, m; 1e-15 to 1.
    pub tolerance: f64,
    /// Default duration of a run, s; 0 to 1e6.
    pub duration: f64,
    /// Whether sheets that start inside a body or another sheet are moved out of it, undeformed,
    /// instead of refused.
    pub repair: bool,
    /// Floor and back wall, if any.
    pub room: Option<Room>,
    /// Default friction and restitution, and those of material pairs.
    pub contact: ContactDefaults,
    /// Drag of the air on every sheet.
    pub air: Air,
    /// Wind, gusts, turbulence, vortices, blasts and fluids in parts of space.
    pub wind_zones: Vec<WindZone>,
    /// Temperature of the surroundings, °C; -273.15 to 5000.
    pub ambient_temperature: f64,
    /// Convection coefficient of both sides of a sheet together in still air, W/(m² K); 0 to 1e6.
    pub convection: f64,
    /// Contact conductance between a hot body and an object that touches it, W/(m² K); 1e-3 to 1e6.
    pub contact_conductance: f64,
    /// Factor by which thermal time is faster than mechanical time; 1e-3 to 1e4.
    pub time_lapse: f64,
    /// Thermal model.
    pub heat_mode: HeatMode,
    /// Oven: the whole room at one temperature.
    pub oven: Option<OvenSpec>,
    /// Heat gun: a jet of hot air.
    pub heat_gun: Option<HeatGunSpec>,
    /// The sheets.
    pub sheets: Vec<SheetSpec>,
    /// The rigid bodies.
    pub bodies: Vec<BodySpec>,
    /// Hot polyhedra that radiate.
    pub heaters: Vec<HeaterSpec>,
    /// Maximum cost of a step of all sheets by the model of `docs/detail.md`, ms, 1e-3 to 1e6:
    /// sheets with levels of `detail` are coarsened to stay below it. `None` uses the distance
    /// alone.
    pub detail_budget: Option<f64>,
    /// View for pictures of the scene.
    pub camera: Option<CameraSpec>,
    /// Base folder of relative file names in the scene; set by the loader, not part of the file.
    #[serde(skip)]
    pub base: PathBuf,
    /// File of the scene, for messages; set by the loader, not part of the file.
    #[serde(skip)]
    pub file: Option<PathBuf>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            name: "untitled".into(),
            description: String::new(),
            gravity: DVec3::new(0.0, -9.81, 0.0),
            engine: IntegratorKind::TrBdf2,
            dt: 1.0 / 60.0,
            tolerance: 1.0e-7,
            duration: 10.0,
            repair: false,
            room: None,
            contact: ContactDefaults::default(),
            air: Air::default(),
            wind_zones: Vec::new(),
            ambient_temperature: 20.0,
            convection: 10.0,
            contact_conductance: 500.0,
            time_lapse: 1.0,
            heat_mode: HeatMode::default(),
            oven: None,
            heat_gun: None,
            sheets: Vec::new(),
            bodies: Vec::new(),
            heaters: Vec::new(),
            detail_budget: None,
            camera: None,
            base: PathBuf::new(),
            file: None,
        }
    }
}

impl Scene {
    /// Names of the bodies as they are built, in order: "body N" for those without a name, then
    /// those of the room.
    pub fn body_names(&self) -> Vec<String> {
        let own = self.bodies.iter().enumerate().map(|(i, b)| body_name(&b.name, i));
        let room = self.room.iter().flat_map(|r| [Some("floor"), r.back_wall.then_some("back wall")]);
        own.chain(room.flatten().map(str::to_owned)).collect()
    }
}

/// Name of the sheet `index` of a scene.
pub(crate) fn sheet_name(name: &str, index: usize) -> String {
    if name.is_empty() { format!("sheet {index}") } else { name.to_owned() }
}

/// Name of the body `index` of a scene.
pub(crate) fn body_name(name: &str, index: usize) -> String {
    if name.is_empty() { format!("body {index}") } else { name.to_owned() }
}

/// Room of the thesis: a floor below and a wall behind, each a plane with a square grid drawn on
/// it.
///
/// The other two numbers of `x`, `y`, `z` only bound the drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Extent along x, m: (left, right).
    pub x: (f64, f64),
    /// Extent along y, m: (floor, top). The floor is the plane y = `y.0`.
    pub y: (f64, f64),
    /// Extent along z, m: (back wall, front). The back wall is the plane z = `z.0`.
    pub z: (f64, f64),
    /// Spacing of the drawn grid, m; 1e-4 to 100.
    #[serde(default = "Room::default_grid")]
    pub grid: f64,
    /// Whether the back wall exists, for contact and drawing.
    #[serde(default = "yes")]
    pub back_wall: bool,
}

impl Room {
    fn default_grid() -> f64 {
        0.005
    }
}

fn yes() -> bool {
    true
}

/// Position and orientation. A point is rotated about x, then y, then z (fixed axes), then
/// translated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// Position of the local origin, m; each component within ±1e4.
    pub position: DVec3,
    /// Rotations about the fixed x, y and z axes, applied in that order, degrees; each within
    /// ±36000.
    pub rotation: DVec3,
}

impl Placement {
    /// The rotation as a quaternion.
    pub fn quaternion(&self) -> DQuat {
        let r = self.rotation * (std::f64::consts::PI / 180.0);
        DQuat::from_rotation_z(r.z) * DQuat::from_rotation_y(r.y) * DQuat::from_rotation_x(r.x)
    }

    /// A local point in the world, m.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        self.quaternion() * p + self.position
    }
}

/// Specification of a sheet.
///
/// Local axes: x along the length (u), z along the width (v), y through the thickness; the origin
/// is the middle of the bottom layer.
///
/// The default is a square of card, 25 cm wide: a shell of 21 by 21 nodes. [`SheetSpec::thesis`] is
/// the soft lattice of the thesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SheetSpec {
    /// Name in reports and parameter paths; empty for "sheet N".
    pub name: String,
    /// Discretisation: shell or lattice.
    pub structure: StructureKind,
    /// Numbers of nodes along the length, layers, and nodes along the width: 2 to 2000, 1 to 64, 2
    /// to 2000.
    pub grid: (u32, u32, u32),
    /// Length (x) and width (z) of the bottom layer, m; 1e-6 to 1e3.
    pub size: (f64, f64),
    /// Distance between layers, m; 1e-7 to 10.
    pub gap: f64,
    /// .SHT file of the sheet, which then determines `structure`, `grid`, `size` and `gap`.
    pub file: Option<PathBuf>,
    /// Outer boundary of a sheet that is not a rectangle (shell only). `grid` then counts nodes
    /// over its bounding box, and `size` only scales round corners.
    pub outline: Option<OutlineSpec>,
    /// Holes in the sheet (shell only).
    pub holes: Vec<HoleSpec>,
    /// Polylines (x, z), m, of cuts, in the plane of the sheet, from its middle (shell only). They
    /// may cross each other and extend beyond the sheet.
    pub cuts: Vec<Vec<(f64, f64)>>,
    /// Material, by name, from a file, or in line.
    pub material: MaterialChoice,
    /// Law of the spring stiffnesses of a lattice.
    pub springs: SpringLaw,
    /// Law of the stiffness of the springs between layers (spring law `Uniform`).
    pub inter_layer: InterLayerLaw,
    /// Stiffness of the springs between layers, N/m, 1e-9 to 1e12, in place of that of
    /// `inter_layer`. For the spring law `Uniform`, and for a sheet of a file.
    pub inter_layer_stiffness: Option<f64>,
    /// Mass of each node, kg, 1e-12 to 1e6; it replaces density x thickness x area of the node.
    pub node_mass: Option<f64>,
    /// Dashpot along every spring, as a fraction of the critical damping of the spring with its two
    /// nodes; 0 to 10. For the spring laws `Uniform` and `Length`.
    pub damping: f64,
    /// Damping ratio of the slowest bending motion of the sheet, as a cantilever of its longer
    /// side, 0 to 10. Kelvin-Voigt damping: faster motions are damped more. `None` takes the value
    /// of the material. For the shell and the spring law `Calibrated`.
    pub damping_ratio: Option<f64>,
    /// Drag coefficients of the sheet across and along the air stream, each 0 to 10; used with an
    /// air density above 0.
    pub drag: (f64, f64),
    /// Law of the aerodynamic force.
    pub aerodynamics: Aerodynamics,
    /// Whether cross-over springs join second neighbours along every spring line of a layer (slamm,
    /// double-diagonal, trimm).
    pub cross_over: bool,
    /// Stiffness of flexion and cross-over springs as a fraction of a planar spring's, 0 to 1000.
    pub flexion_stiffness: f64,
    /// Maximum angle of a flexion triple, degrees, 1 to 180 (provot2d, provot3d, provot-trimm);
    /// `None` for no limit.
    pub flexion_limit: Option<f64>,
    /// Minimum distance between layers under compression, as a fraction of `gap`, 0 to 0.95. With
    /// 0, no limit, the layers of a soft sheet can snap through each other.
    pub thickness_limit: f64,
    /// Initial placement.
    pub placement: Placement,
    /// Initial velocity of the whole sheet, m/s; each component within ±1e4.
    pub velocity: DVec3,
    /// Initial spin of the whole sheet about its centre of mass, rad/s; each component within ±1e4.
    pub spin: DVec3,
    /// Initial velocities of regions, m/s, added to the above.
    pub velocities: Vec<RegionVector>,
    /// Constant forces on regions, N per node.
    pub forces: Vec<RegionVector>,
    /// Fixed, kinematic or attached nodes.
    pub pins: Vec<PinSpec>,
    /// Probes: material points (u, v), each 0 to 1, on the bottom layer, whose positions are
    /// reported.
    pub probes: BTreeMap<String, (f64, f64)>,
    /// Friction coefficient of the sheet; the scene's default if none.
    pub friction: Option<f64>,
    /// Restitution coefficient of the sheet; the scene's default if none.
    pub restitution: Option<f64>,
    /// Initial temperature, °C, -273.15 to 5000; `None` for ambient temperature.
    pub temperature: Option<f64>,
    /// Whether the two sides have separate temperatures, so that the sheet curls: for sheets of one
    /// layer with bending elements. The layers of lattices have temperatures of their own.
    pub temperature_gradient: bool,
    /// Whether the sheet has plasticity above the yield moment (shell only).
    pub plastic: bool,
    /// Whether the sheet creeps by the material's `burgers`.
    pub creep: bool,
    /// Whether the sheet adheres to bodies, sheets and itself by the material's `tack`.
    pub sticky: bool,
    /// Surface that meets bodies, with an explicit integrator.
    pub contact_surface: ContactSurface,
    /// Whether cells open above the material's `tears_at` or `melts_at` (rectangles of square
    /// cells: shell, samm, slamm, double-diagonal, provot2d, provot3d).
    pub tearing: bool,
    /// Initial hot or cold spots.
    pub spots: Vec<SpotSpec>,
    /// Lines from (u, v) to (u, v) along which cells are open initially (structures that can
    /// fracture).
    pub slits: Vec<Slit>,
    /// Creases (shell only).
    pub creases: Vec<CreaseSpec>,
    /// Pressure on the upper side minus pressure on the lower, at times: linear in between,
    /// constant before the first and after the last; empty for none. The force follows the surface
    /// normals. A vacuum below a sheet is a positive pressure.
    pub pressure: Vec<PressureKey>,
    /// Rest curvature along the length and along the width, towards the upper side, 1/m; each
    /// within ±1e5 (shell only).
    pub curl: (f64, f64),
    /// Recovery policy for instability.
    pub when_unstable: WhenUnstable,
    /// Levels of detail by distance and budget; `None` for a fixed `grid`.
    pub detail: Option<DetailSpec>,
    /// Local refinement of the triangle mesh of a sheet with an outline, holes or cuts; `None` for
    /// a fixed mesh.
    pub refine: Option<RefineSpec>,
}

impl Default for SheetSpec {
    fn default() -> Self {
        Self {
            name: String::new(),
            structure: StructureKind::Shell,
            grid: (21, 1, 21),
            size: (0.25, 0.25),
            gap: 0.001,
            file: None,
            outline: None,
            holes: Vec::new(),
            cuts: Vec::new(),
            material: MaterialChoice::Named("card".into()),
            springs: SpringLaw::Calibrated,
            inter_layer: InterLayerLaw::Planar,
            inter_layer_stiffness: None,
            node_mass: None,
            damping: 0.115,
            damping_ratio: None,
            drag: (1.17, 0.02),
            aerodynamics: Aerodynamics::Drag,
            cross_over: false,
            flexion_stiffness: 1.0,
            flexion_limit: None,
            thickness_limit: 0.5,
            placement: Placement::default(),
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            velocities: Vec::new(),
            forces: Vec::new(),
            pins: Vec::new(),
            probes: BTreeMap::new(),
            friction: None,
            restitution: None,
            temperature: None,
            temperature_gradient: false,
            plastic: false,
            creep: false,
            sticky: false,
            contact_surface: ContactSurface::Masses,
            tearing: false,
            spots: Vec::new(),
            slits: Vec::new(),
            creases: Vec::new(),
            pressure: Vec::new(),
            curl: (0.0, 0.0),
            when_unstable: WhenUnstable::Stop,
            detail: None,
            refine: None,
        }
    }
}

/// Law of the stiffness of a spring from Young's modulus E and thickness t (thesis 3.5: k = E A /
/// L).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpringLaw {
    /// k = E t for every spring: the value of a square cell, k = E (w t) / l with w = l, used for
    /// all springs as in the thesis.
    #[default]
    Uniform,
    /// Stiffness from the material by homogenisation: the sheet has the bending stiffness of the
    /// material where the structure permits. The membrane is softer; `sheetwork material` prints by
    /// how much. The distance between layers is then a quarter of the grid spacing, each node has
    /// the mass of the area around it, and a clamp includes the stiffness of the edge.
    Calibrated,
    /// k = E A / L with the spring's own length L and A = t/layers x (area of the layer per spring)
    /// / L; between layers k = E t/layers.
    Length,
}

/// Part of a sheet's bottom layer, or of all its layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Region {
    /// Every node of every layer.
    All,
    /// The node nearest to a material point (u, v) of the bottom layer.
    Point(f64, f64),
    /// Every node, in every layer, with u in the first range and v in the second; ranges within 0
    /// to 1.
    Rect((f64, f64), (f64, f64)),
    /// The row of nodes at u = 0, all layers; of a sheet with an outline, the nodes at that side of
    /// its bounding box.
    Left,
    /// The row of nodes at u = 1, all layers.
    Right,
    /// The row of nodes at v = 0, all layers.
    Back,
    /// The row of nodes at v = 1, all layers.
    Front,
    /// Every node on the outline, rims of holes and cuts included, all layers.
    Border,
    /// Nodes by index.
    Masses(Vec<u32>),
}

/// Vector quantity of each node of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionVector {
    /// Region of the nodes.
    pub region: Region,
    /// Value at each node, m/s or N; each component within ±1e6.
    pub value: DVec3,
}

/// Fixed, kinematic or attached nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinSpec {
    /// Region of the nodes.
    pub region: Region,
    /// Prescribed displacement from the start, over time. Empty for fixed nodes.
    #[serde(default)]
    pub path: Vec<PathKey>,
    /// Whether the slope of the sheet is fixed too. The nodes of a shell alone leave the slope
    /// free; the layers of a lattice fix it.
    #[serde(default)]
    pub clamp: bool,
    /// World axes (x, y, z) along which the nodes are fixed; along the others they slide.
    #[serde(default = "PinSpec::all_axes")]
    pub axes: (bool, bool, bool),
    /// Name of a body to which the nodes are attached at their initial positions; `None` for nodes
    /// fixed in the world. Excludes `path`, `clamp` and `axes`: two attached rows of nodes fix the
    /// slope.
    pub body: Option<String>,
    /// Time of release, s, 0 to 1e6; `None` for never. Excludes `clamp`, `axes` and `body`.
    pub until: Option<f64>,
}

impl PinSpec {
    /// Fixed nodes of `region`.
    pub fn fixed(region: Region) -> Self {
        Self { region, path: Vec::new(), clamp: false, axes: Self::all_axes(), body: None, until: None }
    }

    /// Attachment of `region` to a body.
    pub fn attached(region: Region, body: impl Into<String>) -> Self {
        Self { body: Some(body.into()), ..Self::fixed(region) }
    }

    /// Clamp of `region`: fixed nodes and slope.
    pub fn clamped(region: Region) -> Self {
        Self { clamp: true, ..Self::fixed(region) }
    }

    fn all_axes() -> (bool, bool, bool) {
        (true, true, true)
    }
}

/// Pressure difference at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PressureKey {
    /// Simulated time, s; 0 to 1e6, increasing along the list.
    pub time: f64,
    /// Pressure on the upper side minus pressure on the lower, Pa; within ±1e6.
    pub pressure: f64,
}

impl PressureKey {
    /// Pressure of a list at `time` (s), Pa.
    pub fn at(keys: &[Self], time: f64) -> f64 {
        let after = keys.partition_point(|k| k.time <= time);
        match (after.checked_sub(1).and_then(|i| keys.get(i)), keys.get(after)) {
            (Some(a), Some(b)) => a.pressure + (b.pressure - a.pressure) * (time - a.time) / (b.time - a.time),
            (Some(only), None) | (None, Some(only)) => only.pressure,
            (None, None) => 0.0,
        }
    }
}

/// Point of a path: at `time` the object is displaced by `offset` and rotated by `rotation` from
/// its start.
///
/// The motion is linear between the keys and constant before the first and after the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathKey {
    /// Simulated time, s; 0 to 1e6, increasing along the path.
    pub time: f64,
    /// Displacement from the start, m; each component within ±1e4.
    pub offset: DVec3,
    /// Rotation from the start about fixed x, y, z axes through the object's origin, degrees
    /// (bodies only).
    pub rotation: DVec3,
}

/// Displacement (m) and rotation (degrees) of a path at `time` (s).
pub fn path_at(path: &[PathKey], time: f64) -> (DVec3, DVec3) {
    let Some(first) = path.first() else { return (DVec3::ZERO, DVec3::ZERO) };
    if time <= first.time {
        return (first.offset, first.rotation);
    }
    for pair in path.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if time < b.time {
            let s = (time - a.time) / (b.time - a.time);
            return (a.offset.lerp(b.offset, s), a.rotation.lerp(b.rotation, s));
        }
    }
    path.last().map_or((DVec3::ZERO, DVec3::ZERO), |last| (last.offset, last.rotation))
}

/// A view of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// Position of the eye, m.
    pub eye: DVec3,
    /// Point in the middle of the view, m.
    pub target: DVec3,
}
