//! What a scene is, as data: sheets, bodies, heaters, engine, gravity, room. Nothing here moves.
//!
//! The structs of this module are the scene file (RON) field by field; `assets/README.md` documents the same fields for
//! those who write files. All values are SI (metres, kilograms, seconds, radians are never used: angles are degrees
//! because people type them). Reading is in `load`, range checks in `validate`, so that files, command-line overrides and
//! programs meet the same checks.

pub(crate) mod body;
pub mod cards;
pub(crate) mod contact;
pub(crate) mod detail;
pub mod flow;
pub(crate) mod heat;
pub mod heater;
pub mod library;
pub(crate) mod literal;
pub mod load;
pub(crate) mod locate;
pub mod material;
pub mod pol;
pub mod polyhedron;
pub(crate) mod record_lines;
pub mod sht;
pub mod spot;
pub mod sticking;
pub mod tearing;
pub(crate) mod unstable;
pub mod validate;

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

pub use crate::scene::body::{BodySpec, Shape};
pub use crate::scene::contact::{ContactDefaults, PairSpec};
pub use crate::scene::detail::{DetailLevel, DetailSpec};
pub use crate::scene::flow::CreaseSpec;
pub use crate::scene::heat::{HeatGunSpec, HeatMode, HeaterSpec, HotFaceSpec, OvenKey, OvenSpec};
pub use crate::scene::material::{Burgers, Material, MaterialChoice, Tack};
pub use crate::scene::polyhedron::Polyhedron;
pub use crate::scene::unstable::WhenUnstable;

use crate::integrators::EngineKind;
use crate::mesh::outline::{HoleSpec, OutlineSpec};
use crate::mesh::slits::Slit;
use crate::mesh::structure::StructureKind;
pub use crate::scene::spot::SpotSpec;

/// A whole scene: the contents of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// Short name, shown in menus and reports.
    pub name: String,
    /// What the scene shows, in a sentence or two.
    pub description: String,
    /// Acceleration of gravity, m/s²; each component within ±1000.
    pub gravity: DVec3,
    /// Time-stepping scheme of every sheet.
    pub engine: EngineKind,
    /// Step of the engine, s; 1e-7 to 1.
    pub dt: f64,
    /// Position error that the adaptive engine (`rk45`) allows itself per step, m; 1e-15 to 1.
    pub tolerance: f64,
    /// How long a run lasts unless told otherwise, s; 0 to 1e6.
    pub duration: f64,
    /// The floor and the back wall, if any.
    pub room: Option<Room>,
    /// Friction and restitution of everything that does not say otherwise.
    pub contact: ContactDefaults,
    /// Slowing of every mass by the air.
    pub air: Air,
    /// Temperature of the surroundings, °C; -273.15 to 5000.
    pub ambient_temperature: f64,
    /// Convection of both sides of a sheet together in still air, W/(m² K); 0 to 1e6.
    pub convection: f64,
    /// Conductance between a hot body and what touches it, W/(m² K); 1e-3 to 1e6.
    pub contact_conductance: f64,
    /// How many times faster time runs for heat than for motion; 1e-3 to 1e4.
    pub time_lapse: f64,
    /// How heat is modelled.
    pub heat_mode: HeatMode,
    /// The whole room at a temperature.
    pub oven: Option<OvenSpec>,
    /// A jet of hot air.
    pub heat_gun: Option<HeatGunSpec>,
    /// The sheets.
    pub sheets: Vec<SheetSpec>,
    /// The rigid bodies the sheets meet.
    pub bodies: Vec<BodySpec>,
    /// Hot polyhedra, which radiate.
    pub heaters: Vec<HeaterSpec>,
    /// What a step of all sheets may cost, by the model of `docs/detail.md`, ms, 1e-3 to 1e6: sheets with levels of `detail` go to coarser
    /// grids where they would cost more. None for distance alone.
    pub detail_budget: Option<f64>,
    /// Where a picture of the scene is taken from.
    pub camera: Option<CameraSpec>,
    /// Folder that file names in the scene are relative to; set by the loader, not part of the file.
    #[serde(skip)]
    pub base: PathBuf,
    /// The file it was read from, for messages; set by the loader, not part of the file.
    #[serde(skip)]
    pub file: Option<PathBuf>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            name: "untitled".into(),
            description: String::new(),
            gravity: DVec3::new(0.0, -9.81, 0.0),
            engine: EngineKind::EulerRichardson,
            dt: 1.0e-3,
            tolerance: 1.0e-7,
            duration: 10.0,
            room: None,
            contact: ContactDefaults::default(),
            air: Air::default(),
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
    /// Names of the bodies as they are built, in order: "body N" for those without one, then the room's.
    pub fn body_names(&self) -> Vec<String> {
        let own = self.bodies.iter().enumerate().map(|(i, b)| body_name(&b.name, i));
        let room = self.room.iter().flat_map(|r| [Some("floor"), r.back_wall.then_some("back wall")]);
        own.chain(room.flatten().map(str::to_owned)).collect()
    }
}

/// The name of body number `index` of a scene.
pub(crate) fn body_name(name: &str, index: usize) -> String {
    if name.is_empty() { format!("body {index}") } else { name.to_owned() }
}

/// The thesis's room: a floor below and a wall behind, each a plane with a square grid drawn on it.
///
/// The other two numbers of `x`, `y`, `z` only bound what is drawn.
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
    /// Whether the back wall is there to touch (and to be drawn).
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

/// Air, in two ways. As the thesis has it, in every `per` seconds a mass keeps `factor` of its velocity (thesis table 4.3),
/// applied as the force -λ m v with λ = -ln(factor)/per, so that it means the same for every engine and step. And as air
/// is: a `density` and a `wind` that press on the sheet's area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Fraction of its velocity that a mass keeps, more than 0 up to 1; 1 is no air.
    pub factor: f64,
    /// Time in which it keeps that fraction, s; 1e-6 to 1e3. The thesis's own step is 0.015 s.
    pub per: f64,
    /// Density of air that presses on sheets that move through it, kg/m³; 0 to 1e4. 0 is none, a room's is 1.2.
    pub density: f64,
    /// Velocity of that air, m/s; each component within ±1e3.
    pub wind: DVec3,
}

impl Default for Air {
    fn default() -> Self {
        Self { factor: 1.0, per: 0.015, density: 0.0, wind: DVec3::ZERO }
    }
}

impl Air {
    /// Decay rate λ of a velocity, 1/s.
    pub fn rate(&self) -> f64 {
        if self.factor >= 1.0 { 0.0 } else { -self.factor.ln() / self.per }
    }
}

/// Position and orientation. The rotation turns about x, then y, then z (fixed axes), then the position is added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// Where the local origin goes, m; each component within ±1e4.
    pub position: DVec3,
    /// Turns about the fixed x, y and z axes, applied in that order, degrees; each within ±36000.
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

/// One sheet.
///
/// Local axes: x along the length (u), z along the width (v), y through the thickness; the origin is the middle of the
/// bottom layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SheetSpec {
    /// Name in reports and parameter paths; empty for "sheet N".
    pub name: String,
    /// How the masses are connected.
    pub structure: StructureKind,
    /// Masses along the length, layers, masses along the width: 2 to 2000, 1 to 64, 2 to 2000.
    pub grid: (u32, u32, u32),
    /// Length (x) and width (z) of the bottom layer, m; 1e-6 to 1e3.
    pub size: (f64, f64),
    /// Distance between layers, m; 1e-7 to 10.
    pub gap: f64,
    /// Read the sheet from a .SHT file instead of generating it; `structure`, `grid`, `size` and `gap` are then the file's.
    pub file: Option<PathBuf>,
    /// The outer boundary of a sheet that is not a rectangle (shell only): `grid` then counts masses over the box around it,
    /// and `size` is not used but by round corners.
    pub outline: Option<OutlineSpec>,
    /// Holes in the sheet (shell only).
    pub holes: Vec<HoleSpec>,
    /// Polylines (x, z), m, that the sheet is cut along, in its own plane from its middle (shell only). They may cross each
    /// other and reach out of the sheet.
    pub cuts: Vec<Vec<(f64, f64)>>,
    /// The material, by name, from a file, or in line.
    pub material: MaterialChoice,
    /// How springs get their stiffness from the material.
    pub springs: SpringLaw,
    /// Mass of each node, kg, in place of density x thickness x area shared by area; 1e-12 to 1e6.
    pub node_mass: Option<f64>,
    /// Dashpot along every spring, as a fraction of the critical damping of that spring with its two masses; 0 to 10. For
    /// the spring laws `Uniform` and `Length`.
    pub damping: f64,
    /// Damping ratio of the sheet's slowest bending motion, as a cantilever of its longer side, 0 to 10: the material
    /// resists its rate of strain (Kelvin-Voigt), so faster motions are damped more. The material's own if none. For the
    /// shell and the spring law `Calibrated`.
    pub damping_ratio: Option<f64>,
    /// Drag coefficients of the sheet across and along the air stream, each 0 to 10; matter where the air has a density.
    pub drag: (f64, f64),
    /// Whether second neighbours along every spring line of a layer are joined too (slamm, double-diagonal, trimm).
    pub cross_over: bool,
    /// Stiffness of flexion and cross-over springs as a fraction of a planar spring's, 0 to 1000.
    pub flexion_stiffness: f64,
    /// Largest angle a flexion triple may bend to, degrees, 1 to 180 (provot2d, provot3d); none for no limit.
    pub flexion_limit: Option<f64>,
    /// Fraction of the distance between layers that squeezing leaves, 0 to 0.95; 0 for no limit, with which the layers of a
    /// soft sheet can snap through each other.
    pub thickness_limit: f64,
    /// Where the sheet is put.
    pub placement: Placement,
    /// Velocity of the whole sheet, m/s; each component within ±1e4.
    pub velocity: DVec3,
    /// Spin of the whole sheet about its centre of mass, rad/s; each component within ±1e4.
    pub spin: DVec3,
    /// Velocities of some masses, added to the above.
    pub velocities: Vec<RegionVector>,
    /// Constant forces on some masses, N per mass.
    pub forces: Vec<RegionVector>,
    /// Masses that are held, or led along a path.
    pub pins: Vec<PinSpec>,
    /// Named material points whose place is reported: (u, v), each 0 to 1, on the bottom layer.
    pub probes: BTreeMap<String, (f64, f64)>,
    /// Friction coefficient of the sheet; the scene's default if none.
    pub friction: Option<f64>,
    /// Restitution coefficient of the sheet; the scene's default if none.
    pub restitution: Option<f64>,
    /// Temperature at the start, °C, -273.15 to 5000; that of the surroundings if none.
    pub temperature: Option<f64>,
    /// Whether its two sides may differ in temperature, so that it curls: for sheets of one layer that bend as their material; the
    /// layers of others have temperatures of their own.
    pub temperature_gradient: bool,
    /// Whether the sheet stays bent where the material yields (shell only).
    pub plastic: bool,
    /// Whether it creeps as the material's `burgers` says.
    pub creep: bool,
    /// Whether it sticks to what it touches, and to itself, as the material's `tack` says (implicit engines only).
    pub sticky: bool,
    /// Whether its cells open where the material's `tears_at` or `melts_at` is passed (rectangles of square cells: shell, samm, slamm,
    /// double-diagonal, provot2d, provot3d).
    pub tearing: bool,
    /// Places that are warmer or colder than the rest at the start.
    pub spots: Vec<SpotSpec>,
    /// Lines, each from (u, v) to (u, v), along which its cells are open from the start (of the structures that can tear).
    pub slits: Vec<Slit>,
    /// Lines along which the sheet is folded as it is made (shell only).
    pub creases: Vec<CreaseSpec>,
    /// Air pressure on the upper side above that on the lower, at times: linear in between, the first before, the last for good; empty for
    /// none. It pushes along the normals, wherever they turn: a vacuum below a sheet is a positive one.
    pub pressure: Vec<PressureKey>,
    /// Curvature along the length and along the width with which the sheet is made, towards its upper side, 1/m; each within
    /// ±1e5 (shell only).
    pub curl: (f64, f64),
    /// What is done when it is about to go unstable.
    pub when_unstable: WhenUnstable,
    /// Grids that it goes to while the world runs, by distance and budget; none for `grid` throughout.
    pub detail: Option<DetailSpec>,
}

impl Default for SheetSpec {
    fn default() -> Self {
        Self {
            name: String::new(),
            structure: StructureKind::Trimm,
            grid: (11, 2, 11),
            size: (0.025, 0.025),
            gap: 0.001,
            file: None,
            outline: None,
            holes: Vec::new(),
            cuts: Vec::new(),
            material: MaterialChoice::Named("thesis".into()),
            springs: SpringLaw::Uniform,
            node_mass: None,
            damping: 0.115,
            damping_ratio: None,
            drag: (1.17, 0.02),
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
            tearing: false,
            spots: Vec::new(),
            slits: Vec::new(),
            creases: Vec::new(),
            pressure: Vec::new(),
            curl: (0.0, 0.0),
            when_unstable: WhenUnstable::Stop,
            detail: None,
        }
    }
}

/// How a spring's stiffness follows from Young's modulus E and thickness t (thesis 3.5: k = E A / L).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpringLaw {
    /// Every spring has k = E t: a square cell's own k = E (w t) / l with w = l, given to all springs as the thesis does.
    #[default]
    Uniform,
    /// From the sheet's stiffness by homogenisation: it bends as the material says wherever the structure can (the membrane
    /// comes out softer; `sheetwork material` says by how much). The distance between layers is then a quarter of the grid's
    /// spacing, masses stand for the area around them, and a clamped edge is that of the sheet.
    Calibrated,
    /// k = E A / L with the spring's own length L and A = t/layers x (area of the layer that falls to the spring) / L;
    /// between layers k = E t/layers.
    Length,
}

/// Part of a sheet's bottom layer, or of all its layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Region {
    /// Every mass of every layer.
    All,
    /// The mass nearest to a material point (u, v) of the bottom layer.
    Point(f64, f64),
    /// Every mass, in every layer, with u in the first range and v in the second; ranges within 0 to 1.
    Rect((f64, f64), (f64, f64)),
    /// The row of masses at u = 0, all layers; of a sheet with an outline, those at that side of the box around it.
    Left,
    /// The row of masses at u = 1, all layers.
    Right,
    /// The row of masses at v = 0, all layers.
    Back,
    /// The row of masses at v = 1, all layers.
    Front,
    /// Every mass on the outline, the rims of holes and cuts included, all layers.
    Border,
    /// Masses by index.
    Masses(Vec<u32>),
}

/// A vector quantity given to each mass of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionVector {
    /// Which masses.
    pub region: Region,
    /// The value for each, m/s or N; each component within ±1e6.
    pub value: DVec3,
}

/// Masses that do not move freely.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinSpec {
    /// Which masses.
    pub region: Region,
    /// Where they are led: displacement from the start, over time. Empty for masses that are held.
    #[serde(default)]
    pub path: Vec<PathKey>,
    /// Whether the sheet's slope is held there too. A shell is otherwise free to turn about masses that are held; the
    /// layers of a lattice hold its slope by themselves.
    #[serde(default)]
    pub clamp: bool,
    /// World axes (x, y, z) along which the masses are held; those that are not let them slide.
    #[serde(default = "PinSpec::all_axes")]
    pub axes: (bool, bool, bool),
    /// Name of a body that the masses are glued to where they are at the start; none for masses held in the world. Goes
    /// with neither `path` nor `clamp` nor `axes`: two rows of masses on the body hold the sheet's slope.
    #[serde(default)]
    pub body: Option<String>,
    /// When the masses are let go, s, 0 to 1e6; none for never. Goes with neither `clamp` nor `axes` nor `body`.
    #[serde(default)]
    pub until: Option<f64>,
}

impl PinSpec {
    /// A pin that holds `region` where it is.
    pub fn held(region: Region) -> Self {
        Self { region, path: Vec::new(), clamp: false, axes: Self::all_axes(), body: None, until: None }
    }

    /// A pin that glues `region` to the body of that name.
    pub fn glued(region: Region, body: impl Into<String>) -> Self {
        Self { body: Some(body.into()), ..Self::held(region) }
    }

    /// A pin that holds `region` and the slope of the sheet there.
    pub fn clamped(region: Region) -> Self {
        Self { clamp: true, ..Self::held(region) }
    }

    fn all_axes() -> (bool, bool, bool) {
        (true, true, true)
    }
}

/// A difference of pressure at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PressureKey {
    /// Simulated time, s; 0 to 1e6, increasing along the list.
    pub time: f64,
    /// Pressure on the upper side above that on the lower, Pa; within ±1e6.
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

/// One point of a path: at `time` the thing is displaced by `offset` and turned by `rotation` from where it started.
///
/// Between keys the motion is linear; before the first and after the last it stands still.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathKey {
    /// Simulated time, s; 0 to 1e6, increasing along the path.
    pub time: f64,
    /// Displacement from the start, m; each component within ±1e4.
    pub offset: DVec3,
    /// Turn from the start about fixed x, y, z axes through the thing's origin, degrees (bodies only).
    pub rotation: DVec3,
}

/// Displacement (m) and turn (degrees) of a path at `time`.
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
    /// Where the eye is, m.
    pub eye: DVec3,
    /// What it looks at, m.
    pub target: DVec3,
}
