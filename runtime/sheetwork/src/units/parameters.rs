//! Table of parameters: every number of a scene with its path, unit and range, and every parameter
//! that can change while a world runs.
//!
//! Scene files, command-line overrides, [`World::set`](crate::World::set), the live link, the
//! inspector and the editor read this table. The accessors of the parameters of a running world are
//! in `world/parameters.rs`; defaults are read from the specifications by path.

use crate::error::{InputError, check_range};
use crate::units::Quantity;
use crate::units::temperature::{COLDEST, HOTTEST};

/// Identifier of a parameter, one for each row of [`ParameterRow::all`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum ParameterId {
    /// Gravity.
    Gravity,
    /// Time integrator.
    Engine,
    /// Time step.
    TimeStep,
    /// Error tolerance of an adaptive integrator, per step.
    Tolerance,
    /// Linear damping: fraction of its speed that a node keeps in every `air.per`.
    AirFactor,
    /// Time of the linear damping.
    AirPer,
    /// Density of the air, for drag.
    AirDensity,
    /// Wind.
    AirWind,
    /// Temperature of the surroundings.
    AmbientTemperature,
    /// Convection coefficient of both sides of a sheet together.
    Convection,
    /// Thermal time over mechanical time.
    TimeLapse,
    /// Temperature of the oven; setting it replaces the schedule.
    OvenTemperature,
    /// Whether the oven is on.
    OvenOn,
    /// Whether a heater is on.
    HeaterOn,
    /// Temperature of all hot faces of a heater.
    HeaterTemperature,
    /// Temperature of a hot body.
    BodyTemperature,
    /// Whether the heat gun is on.
    HeatGunOn,
    /// Temperature of the jet at the nozzle.
    HeatGunTemperature,
    /// Position of the nozzle, x.
    HeatGunPositionX,
    /// Position of the nozzle, y.
    HeatGunPositionY,
    /// Position of the nozzle, z.
    HeatGunPositionZ,
    /// Direction of the jet, x.
    HeatGunDirectionX,
    /// Direction of the jet, y.
    HeatGunDirectionY,
    /// Direction of the jet, z.
    HeatGunDirectionZ,
    /// Maximum cost of a step by the cost model of the levels of detail.
    DetailBudget,
    /// Eye that the levels of detail follow.
    Viewpoint,
    /// Young's modulus.
    MaterialYoung,
    /// Thickness of a sheet.
    MaterialThickness,
    /// Poisson's ratio.
    MaterialPoisson,
    /// Dashpots along the springs of a lattice.
    Damping,
    /// Damping ratio of the slowest bending mode.
    DampingRatio,
    /// Drag coefficient for air across the sheet.
    DragAcross,
    /// Drag coefficient for air along the sheet.
    DragAlong,
    /// Pressure difference from the upper to the lower side.
    Pressure,
    /// Coulomb friction coefficient of a sheet.
    Friction,
    /// Ratio of separation to approach speed of a sheet.
    Restitution,
    /// Temperature of a sheet.
    Temperature,
    /// Largest bending angle of a flexion spring.
    FlexionLimit,
    /// Recovery policy of a sheet.
    WhenUnstable,
    /// Nodes along length and width of a sheet, as `21x11`.
    Grid,
    /// Simulated duration.
    Duration,
    /// Conductance of a contact.
    ContactConductance,
    /// Thermal sensitivity of the thesis's formulas.
    ThesisSensitivity,
    /// Thermal conductivity coefficient of the thesis's formulas.
    ThesisConductivity,
    /// Convection coefficient in the oven.
    OvenConvection,
    /// Time of a temperature of the oven's schedule.
    OvenScheduleTime,
    /// Temperature of the oven's schedule.
    OvenScheduleTemperature,
    /// Convection coefficient at the nozzle.
    HeatGunConvection,
    /// Half angle of the jet.
    HeatGunHalfAngle,
    /// Distance at which the convection of the jet is halved.
    HeatGunReach,
    /// Edges of a heater that is a box.
    HeaterSize,
    /// Temperature of a hot face.
    HotFaceTemperature,
    /// Emissivity of a hot face.
    HotFaceEmissivity,
    /// Friction coefficient of objects without one of their own.
    ContactFriction,
    /// Restitution of objects without one of their own.
    ContactRestitution,
    /// Friction coefficient of two materials.
    PairFriction,
    /// Restitution of two materials.
    PairRestitution,
    /// Eye of the camera.
    CameraEye,
    /// Point that the camera looks at.
    CameraTarget,
    /// Spacing of the grid on the floor.
    RoomGrid,
    /// Extent of the room along an axis.
    RoomExtent,
    /// Position of a sheet, a body or a heater.
    PlacementPosition,
    /// Rotation of a sheet, a body or a heater about x, y and z.
    PlacementRotation,
    /// Time of a point of a path.
    PathTime,
    /// Displacement at a point of a path.
    PathOffset,
    /// Rotation at a point of a path.
    PathRotation,
    /// Density of a material.
    MaterialDensity,
    /// Specific heat.
    MaterialSpecificHeat,
    /// Thermal conductivity.
    MaterialConductivity,
    /// Emissivity.
    MaterialEmissivity,
    /// Coefficient of thermal expansion.
    MaterialExpansion,
    /// Temperature of a row of stiffness against temperature.
    SofteningTemperature,
    /// Fraction of Young's modulus at that temperature.
    SofteningFraction,
    /// Damping ratio of the slowest bending mode, of a material.
    MaterialDampingRatio,
    /// Yield stress.
    MaterialYieldStress,
    /// Linear hardening modulus.
    MaterialHardening,
    /// Relaxation time of Burgers' model.
    BurgersRelaxationTime,
    /// Retardation time of Burgers' model.
    BurgersRetardationTime,
    /// Retarded over instantaneous strain of Burgers' model.
    BurgersRetarded,
    /// Glass transition temperature.
    GlassTransition,
    /// First constant of Williams, Landel and Ferry.
    WlfFirst,
    /// Second constant of Williams, Landel and Ferry.
    WlfSecond,
    /// Temperature at which a cell opens.
    MeltsAt,
    /// Strength of adhesion.
    TackStrength,
    /// Temperature above which adhesion begins.
    TackAbove,
    /// Temperature below which bonds open, at most `above`.
    TackLetsGoBelow,
    /// Fracture strain.
    TearsAt,
    /// Membrane stiffness of a woven sheet along the warp.
    YoungWarp,
    /// Membrane stiffness of a woven sheet along the weft.
    YoungWeft,
    /// Shear stiffness of a woven sheet.
    Shear,
    /// Bending stiffness of a woven sheet along the warp.
    BendingWarp,
    /// Bending stiffness of a woven sheet along the weft.
    BendingWeft,
    /// Twisting stiffness of a woven sheet.
    Twist,
    /// Nodes along the length of a sheet.
    GridLength,
    /// Nodes along the width of a sheet.
    GridWidth,
    /// Length and width of a sheet.
    Size,
    /// Distance of the layers of a lattice.
    Gap,
    /// Time of a pressure.
    PressureTime,
    /// Pressure difference at that time.
    PressureValue,
    /// Factor on the stiffness of flexion springs.
    FlexionStiffness,
    /// Least thickness of a lattice over its gap.
    ThicknessLimit,
    /// Mass of a node.
    NodeMass,
    /// Initial velocity of a sheet.
    SheetVelocity,
    /// Initial angular velocity of a sheet.
    SheetSpin,
    /// Initial velocity of a region.
    RegionVelocity,
    /// Force on a region.
    RegionForce,
    /// Coordinate u or v of a region.
    RegionCoordinate,
    /// Time at which a pin is released.
    PinUntil,
    /// Position (u, v) of a probe.
    ProbePosition,
    /// Start (u, v) of a crease.
    CreaseFrom,
    /// End (u, v) of a crease.
    CreaseTo,
    /// Rest angle of a crease.
    CreaseAngle,
    /// Rest curvatures of a sheet.
    Curl,
    /// End (u, v) of a slit.
    SlitEnd,
    /// Centre (u, v) of a hot spot.
    SpotCentre,
    /// Radius of a hot spot.
    SpotRadius,
    /// Temperature of a hot spot.
    SpotTemperature,
    /// Hysteresis of the distances of levels of detail.
    DetailHysteresis,
    /// Nodes along length and width at a level of detail.
    DetailGrid,
    /// Distance up to which a level of detail is used.
    DetailDistance,
    /// Radius of a ball, or edge of a box.
    BodySize,
    /// Mass of a dynamic body.
    BodyMass,
    /// Density of a dynamic body.
    BodyDensity,
    /// Initial velocity of a dynamic body.
    BodyVelocity,
    /// Initial angular velocity of a dynamic body.
    BodySpin,
    /// Friction coefficient of a body.
    BodyFriction,
    /// Restitution of a body.
    BodyRestitution,
}

/// Kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterKind {
    /// A number.
    Number,
    /// A number, or `none`.
    Optional,
    /// Two numbers with one unit.
    Pair,
    /// Three numbers with one unit.
    Vector,
    /// Three numbers with one unit, or `none`.
    OptionalVector,
    /// `true` or `false`.
    Boolean,
    /// One of several names.
    Name,
}

impl ParameterKind {
    /// Name of the kind in listings: "number", "vector", "boolean" or "name".
    pub fn name(self) -> &'static str {
        match self {
            Self::Number | Self::Optional => "number",
            Self::Pair | Self::Vector | Self::OptionalVector => "vector",
            Self::Boolean => "boolean",
            Self::Name => "name",
        }
    }
}

/// Time at which a parameter can be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterAccess {
    /// In a scene only.
    Scene,
    /// In a scene, and in a running world, which lists it among its parameters.
    Live,
    /// In a running world, which does not list it: its value is state.
    State,
}

/// Source of a parameter's default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DefaultSource {
    /// Field of a scene in which every other field has its default.
    Field,
    /// Another field of that scene.
    SameAs(&'static str),
    /// This value.
    Text(&'static str),
    /// The field has no default.
    Required,
}

/// Usual values of a number, as the range of a slider. Other values within the range of the
/// parameter are valid too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UsualRange {
    /// Least usual value.
    pub min: f64,
    /// Largest usual value.
    pub max: f64,
    /// Whether a slider is logarithmic.
    pub logarithmic: bool,
}

/// Row of the table of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParameterRow {
    /// Identifier.
    pub id: ParameterId,
    /// Path: `*` stands for a name or a number, `**` at the start for any path.
    pub path: &'static str,
    /// Unit of the number, as in messages; empty for a name or a dimensionless number.
    pub unit: &'static str,
    /// Smallest and largest value of a number, or of each component.
    pub range: Option<(f64, f64)>,
    /// Kind of the value.
    pub kind: ParameterKind,
    /// Time at which it can be set.
    pub access: ParameterAccess,
    /// Usual values.
    pub usual: Option<UsualRange>,
    pub(crate) default: DefaultSource,
}

/// Temperatures, °C.
const TEMPERATURE: (f64, f64) = (COLDEST, HOTTEST);
/// Coordinates (m), and velocities (m/s, rad/s) of the same magnitude.
const COORDINATE: (f64, f64) = (-1e4, 1e4);
/// Extents of objects, m.
const EXTENT: (f64, f64) = (1e-6, 1e4);
/// Simulated times, s.
const TIME: (f64, f64) = (0.0, 1e6);
/// Rotations, degrees: a hundred turns.
const TURN: (f64, f64) = (-36000.0, 36000.0);
/// Fractions of a whole.
const FRACTION: (f64, f64) = (0.0, 1.0);
/// Coefficients of friction.
const FRICTION: (f64, f64) = (0.0, 10.0);

/// Row of a number; other kinds and properties are set by the functions below.
const fn number(id: ParameterId, path: &'static str, unit: &'static str, range: (f64, f64)) -> ParameterRow {
    let (kind, access, default) = (ParameterKind::Number, ParameterAccess::Scene, DefaultSource::Field);
    ParameterRow { id, path, unit, range: Some(range), kind, access, usual: None, default }
}

/// Row of a boolean or a name.
const fn word(id: ParameterId, path: &'static str, kind: ParameterKind) -> ParameterRow {
    ParameterRow { range: None, kind, ..number(id, path, "", (0.0, 0.0)) }
}

impl ParameterRow {
    const fn kind(self, kind: ParameterKind) -> Self {
        Self { kind, ..self }
    }

    const fn live(self) -> Self {
        Self { access: ParameterAccess::Live, ..self }
    }

    const fn state(self) -> Self {
        Self { access: ParameterAccess::State, ..self }
    }

    const fn usual(self, min: f64, max: f64) -> Self {
        Self { usual: Some(UsualRange { min, max, logarithmic: false }), ..self }
    }

    const fn usual_logarithmic(self, min: f64, max: f64) -> Self {
        Self { usual: Some(UsualRange { min, max, logarithmic: true }), ..self }
    }

    const fn same_as(self, path: &'static str) -> Self {
        Self { default: DefaultSource::SameAs(path), ..self }
    }

    const fn default(self, text: &'static str) -> Self {
        Self { default: DefaultSource::Text(text), ..self }
    }

    const fn required(self) -> Self {
        Self { default: DefaultSource::Required, ..self }
    }

    /// All rows, in the order of [`ParameterId`].
    pub fn all() -> &'static [Self] {
        TABLE
    }

    /// Physical quantity of the number; `None` for a unit that is not converted.
    pub fn quantity(&self) -> Option<Quantity> {
        Quantity::from_unit(self.unit)
    }

    /// Path of the parameter of the object called `name`.
    pub(crate) fn path_of(&self, name: &str) -> String {
        self.path.replacen('*', name, 1)
    }

    /// Whether `path` is a path of this row.
    fn has_path(&self, path: &str) -> bool {
        let (mut wanted, mut given) = (self.path.rsplit('.'), path.rsplit('.'));
        loop {
            match (wanted.next(), given.next()) {
                (Some("**"), _) | (None, None) => return true,
                (Some(pattern), Some(part)) if pattern == "*" || pattern == part => {}
                _ => return false,
            }
        }
    }
}

impl ParameterId {
    /// Row of the parameter.
    pub fn row(self) -> &'static ParameterRow {
        &TABLE[self as usize]
    }

    /// Smallest and largest value; unbounded for a value that is no number.
    pub(crate) fn range(self) -> (f64, f64) {
        self.row().range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Parameter at `path`; a component of a vector or pair has the parameter of the whole.
    pub fn from_path(path: &str) -> Option<Self> {
        let whole = || path.rsplit_once('.').filter(|(_, part)| part.parse::<usize>().is_ok());
        Self::from_whole_path(path).or_else(|| Self::from_whole_path(whole()?.0))
    }

    /// Parameter at `path`; `None` for a component of a vector or pair.
    pub(crate) fn from_whole_path(path: &str) -> Option<Self> {
        TABLE.iter().find(|row| row.has_path(path)).map(|row| row.id)
    }

    /// Check that `value` is finite and within the range of the parameter. The error names `field`,
    /// value, unit and range.
    ///
    /// # Errors
    /// When it is not.
    pub(crate) fn check(self, field: &str, value: f64) -> Result<(), InputError> {
        let (min, max) = self.range();
        check_range(field, value, min, max, self.row().unit)
    }

    /// Check every component of a vector or pair; the error names `field` and the component.
    ///
    /// # Errors
    /// When one is not finite or is out of range.
    pub(crate) fn check_each(self, field: &str, values: impl IntoIterator<Item = f64>) -> Result<(), InputError> {
        values.into_iter().enumerate().try_for_each(|(axis, value)| self.check(&format!("{field}.{axis}"), value))
    }

    /// Check a value that may be absent.
    ///
    /// # Errors
    /// When it is present and not finite or out of range.
    pub(crate) fn check_option(self, field: &str, value: Option<f64>) -> Result<(), InputError> {
        value.map_or(Ok(()), |value| self.check(field, value))
    }
}

use ParameterId as Id;
use ParameterKind::{Boolean, Name, Optional, OptionalVector, Pair, Vector};

/// All parameters. The order of those of a running world is that of its listing.
#[rustfmt::skip]
const TABLE: &[ParameterRow] = &[
    number(Id::Gravity, "gravity", "m/s²", (-1e3, 1e3)).kind(Vector).live(),
    word(Id::Engine, "engine", Name).live(),
    number(Id::TimeStep, "dt", "s", (1e-7, 1.0)).live(),
    number(Id::Tolerance, "tolerance", "m", (1e-15, 1.0)).live(),
    number(Id::AirFactor, "air.factor", "", (1e-6, 1.0)).live().usual(0.8, 1.0),
    number(Id::AirPer, "air.per", "s", (1e-6, 1e3)).live(),
    number(Id::AirDensity, "air.density", "kg/m³", (0.0, 1e4)).live().usual(0.0, 2.0),
    number(Id::AirWind, "air.wind", "m/s", (-1e3, 1e3)).kind(Vector).live(),
    number(Id::AmbientTemperature, "ambient_temperature", "°C", TEMPERATURE).live().usual(-20.0, 60.0),
    number(Id::Convection, "convection", "W/(m² K)", (0.0, 1e6)).live().usual(0.0, 100.0),
    number(Id::TimeLapse, "time_lapse", "", (1e-3, 1e4)).live().usual_logarithmic(0.1, 100.0),
    number(Id::OvenTemperature, "oven.temperature", "°C", TEMPERATURE).live().usual(20.0, 300.0),
    word(Id::OvenOn, "oven.on", Boolean).live(),
    word(Id::HeaterOn, "heaters.*.on", Boolean).live(),
    number(Id::HeaterTemperature, "heaters.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    number(Id::BodyTemperature, "bodies.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    word(Id::HeatGunOn, "heat_gun.on", Boolean).live(),
    number(Id::HeatGunTemperature, "heat_gun.temperature", "°C", TEMPERATURE).live().usual(50.0, 600.0),
    number(Id::HeatGunPositionX, "heat_gun.position.0", "m", COORDINATE).live(),
    number(Id::HeatGunPositionY, "heat_gun.position.1", "m", COORDINATE).live(),
    number(Id::HeatGunPositionZ, "heat_gun.position.2", "m", COORDINATE).live(),
    number(Id::HeatGunDirectionX, "heat_gun.direction.0", "", COORDINATE).live(),
    number(Id::HeatGunDirectionY, "heat_gun.direction.1", "", COORDINATE).live(),
    number(Id::HeatGunDirectionZ, "heat_gun.direction.2", "", COORDINATE).live(),
    number(Id::DetailBudget, "detail_budget", "ms", (1e-3, 1e6)).kind(Optional).live(),
    number(Id::Viewpoint, "viewpoint", "m", (-1e6, 1e6)).kind(OptionalVector).state().default("none"),
    number(Id::MaterialYoung, "sheets.*.material.young", "Pa", (1e-3, 2e12)).live().usual_logarithmic(1.0, 1e11),
    number(Id::MaterialThickness, "sheets.*.material.thickness", "m", (1e-7, 1.0)).live().usual_logarithmic(1e-5, 5e-3),
    number(Id::MaterialPoisson, "sheets.*.material.poisson", "", (-0.99, 0.499)).live().usual(0.0, 0.49),
    number(Id::Damping, "sheets.*.damping", "of critical", (0.0, 10.0)).live().usual(0.0, 1.0),
    number(Id::DampingRatio, "sheets.*.damping_ratio", "of critical", (0.0, 10.0)).live().usual(0.0, 0.5).same_as("sheets.0.material.damping_ratio"),
    number(Id::DragAcross, "sheets.*.drag.0", "", (0.0, 10.0)).live().usual(0.0, 2.0),
    number(Id::DragAlong, "sheets.*.drag.1", "", (0.0, 10.0)).live().usual(0.0, 0.2),
    number(Id::Pressure, "sheets.*.pressure", "Pa", (-1e6, 1e6)).live().default("0"),
    number(Id::Friction, "sheets.*.friction", "", FRICTION).live().usual(0.0, 1.0).same_as("contact.friction"),
    number(Id::Restitution, "sheets.*.restitution", "", FRACTION).live().usual(0.0, 1.0).same_as("contact.restitution"),
    number(Id::Temperature, "sheets.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    number(Id::FlexionLimit, "sheets.*.flexion_limit", "degrees", (1.0, 180.0)).kind(Optional).live().usual(1.0, 180.0),
    word(Id::WhenUnstable, "sheets.*.when_unstable", Name).live(),
    word(Id::Grid, "sheets.*.grid", Name).state().default("21x21"),
    number(Id::Duration, "duration", "s", TIME),
    number(Id::ContactConductance, "contact_conductance", "W/(m² K)", (1e-3, 1e6)),
    number(Id::ThesisSensitivity, "heat_mode.*.sensitivity", "N/K", (0.0, 1e6)).required(),
    number(Id::ThesisConductivity, "heat_mode.*.conductivity", "", (0.0, 1e3)).default("0"),
    number(Id::OvenConvection, "oven.convection", "W/(m² K)", (0.0, 1e6)).kind(Optional),
    number(Id::OvenScheduleTime, "oven.schedule.*.time", "s", TIME).required(),
    number(Id::OvenScheduleTemperature, "oven.schedule.*.temperature", "°C", TEMPERATURE).kind(Optional).default("none"),
    number(Id::HeatGunConvection, "heat_gun.convection", "W/(m² K)", (0.0, 1e6)),
    number(Id::HeatGunHalfAngle, "heat_gun.half_angle", "degrees", (0.1, 90.0)),
    number(Id::HeatGunReach, "heat_gun.reach", "m", (1e-6, 1e4)),
    number(Id::HeaterSize, "heaters.*.size", "m", EXTENT).kind(OptionalVector),
    number(Id::HotFaceTemperature, "heaters.*.hot.*.temperature", "°C", TEMPERATURE).required(),
    number(Id::HotFaceEmissivity, "heaters.*.hot.*.emissivity", "", FRACTION).default("1"),
    number(Id::ContactFriction, "contact.friction", "", FRICTION).usual(0.0, 1.0),
    number(Id::ContactRestitution, "contact.restitution", "", FRACTION).usual(0.0, 1.0),
    number(Id::PairFriction, "contact.pairs.*.friction", "", FRICTION).kind(Optional).default("none"),
    number(Id::PairRestitution, "contact.pairs.*.restitution", "", FRACTION).kind(Optional).default("none"),
    number(Id::CameraEye, "camera.eye", "m", COORDINATE).kind(Vector).required(),
    number(Id::CameraTarget, "camera.target", "m", COORDINATE).kind(Vector).required(),
    number(Id::RoomGrid, "room.grid", "m", (1e-4, 100.0)),
    number(Id::RoomExtent, "room.*", "m", COORDINATE).kind(Pair).required(),
    number(Id::PlacementPosition, "**.placement.position", "m", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    number(Id::PlacementRotation, "**.placement.rotation", "degrees", TURN).kind(Vector).default("(0, 0, 0)"),
    number(Id::PathTime, "**.path.*.time", "s", TIME).default("0"),
    number(Id::PathOffset, "**.path.*.offset", "m", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    number(Id::PathRotation, "**.path.*.rotation", "degrees", TURN).kind(Vector).default("(0, 0, 0)"),
    number(Id::MaterialDensity, "sheets.*.material.density", "kg/m³", (1e-3, 1e6)).usual_logarithmic(10.0, 2e4),
    number(Id::MaterialSpecificHeat, "sheets.*.material.specific_heat", "J/(kg K)", (1.0, 1e5)),
    number(Id::MaterialConductivity, "sheets.*.material.conductivity", "W/(m K)", (0.0, 1e4)),
    number(Id::MaterialEmissivity, "sheets.*.material.emissivity", "", FRACTION),
    number(Id::MaterialExpansion, "sheets.*.material.expansion", "1/K", (-1e-2, 1e-2)),
    number(Id::SofteningTemperature, "sheets.*.material.softening.*.0", "°C", TEMPERATURE).required(),
    number(Id::SofteningFraction, "sheets.*.material.softening.*.1", "of young", (1e-9, 1e3)).required(),
    number(Id::MaterialDampingRatio, "sheets.*.material.damping_ratio", "of critical", (0.0, 10.0)),
    number(Id::MaterialYieldStress, "sheets.*.material.yield_stress", "Pa", (1.0, 1e11)).kind(Optional),
    number(Id::MaterialHardening, "sheets.*.material.hardening", "Pa", (0.0, 1e12)),
    number(Id::BurgersRelaxationTime, "sheets.*.material.burgers.relaxation_time", "s", (1e-6, 1e30)).required(),
    number(Id::BurgersRetardationTime, "sheets.*.material.burgers.retardation_time", "s", (1e-6, 1e30)).required(),
    number(Id::BurgersRetarded, "sheets.*.material.burgers.retarded", "", (0.0, 1e4)).required(),
    number(Id::GlassTransition, "sheets.*.material.glass_transition", "°C", (COLDEST, 1000.0)).kind(Optional),
    number(Id::WlfFirst, "sheets.*.material.wlf.0", "", (1.0, 100.0)),
    number(Id::WlfSecond, "sheets.*.material.wlf.1", "K", (1.0, 1000.0)),
    number(Id::MeltsAt, "sheets.*.material.melts_at", "°C", TEMPERATURE).kind(Optional),
    number(Id::TackStrength, "sheets.*.material.tack.strength", "Pa", (1e-3, 1e9)).required(),
    number(Id::TackAbove, "sheets.*.material.tack.above", "°C", TEMPERATURE).required(),
    number(Id::TackLetsGoBelow, "sheets.*.material.tack.lets_go_below", "°C", TEMPERATURE).kind(Optional).default("none"),
    number(Id::TearsAt, "sheets.*.material.tears_at", "of strain", (1e-3, 10.0)).kind(Optional),
    number(Id::YoungWarp, "sheets.*.material.orthotropic.young_warp", "N/m", (1e-6, 1e12)).required(),
    number(Id::YoungWeft, "sheets.*.material.orthotropic.young_weft", "N/m", (1e-6, 1e12)).required(),
    number(Id::Shear, "sheets.*.material.orthotropic.shear", "N/m", (0.0, 1e12)).required(),
    number(Id::BendingWarp, "sheets.*.material.orthotropic.bending_warp", "N m", (1e-15, 1e9)).required(),
    number(Id::BendingWeft, "sheets.*.material.orthotropic.bending_weft", "N m", (1e-15, 1e9)).required(),
    number(Id::Twist, "sheets.*.material.orthotropic.twist", "N m", (0.0, 1e9)).required(),
    number(Id::GridLength, "sheets.*.grid.0", "masses", (2.0, 2000.0)),
    number(Id::GridWidth, "sheets.*.grid.2", "masses", (2.0, 2000.0)),
    number(Id::Size, "sheets.*.size", "m", (1e-6, 1e3)).kind(Pair),
    number(Id::Gap, "sheets.*.gap", "m", (1e-7, 10.0)),
    number(Id::PressureTime, "sheets.*.pressure.*.time", "s", TIME).required(),
    number(Id::PressureValue, "sheets.*.pressure.*.pressure", "Pa", (-1e6, 1e6)).required(),
    number(Id::FlexionStiffness, "sheets.*.flexion_stiffness", "", (0.0, 1e3)),
    number(Id::ThicknessLimit, "sheets.*.thickness_limit", "", (0.0, 0.95)),
    number(Id::NodeMass, "sheets.*.node_mass", "kg", (1e-12, 1e6)).kind(Optional),
    number(Id::SheetVelocity, "sheets.*.velocity", "m/s", COORDINATE).kind(Vector),
    number(Id::SheetSpin, "sheets.*.spin", "rad/s", COORDINATE).kind(Vector),
    number(Id::RegionVelocity, "sheets.*.velocities.*.value", "m/s", (-1e6, 1e6)).kind(Vector).required(),
    number(Id::RegionForce, "sheets.*.forces.*.value", "N", (-1e6, 1e6)).kind(Vector).required(),
    number(Id::RegionCoordinate, "sheets.*.*.*.region.*", "", FRACTION).required(),
    number(Id::PinUntil, "sheets.*.pins.*.until", "s", TIME).kind(Optional).default("none"),
    number(Id::ProbePosition, "sheets.*.probes.*", "", FRACTION).kind(Pair).required(),
    number(Id::CreaseFrom, "sheets.*.creases.*.from", "", FRACTION).kind(Pair).required(),
    number(Id::CreaseTo, "sheets.*.creases.*.to", "", FRACTION).kind(Pair).required(),
    number(Id::CreaseAngle, "sheets.*.creases.*.angle", "degrees", (-175.0, 175.0)).required(),
    number(Id::Curl, "sheets.*.curl", "1/m", (-1e5, 1e5)).kind(Pair),
    number(Id::SlitEnd, "sheets.*.slits.*.*", "", FRACTION).kind(Pair).required(),
    number(Id::SpotCentre, "sheets.*.spots.*.at", "", FRACTION).kind(Pair).required(),
    number(Id::SpotRadius, "sheets.*.spots.*.radius", "m", (1e-6, 1e3)).required(),
    number(Id::SpotTemperature, "sheets.*.spots.*.temperature", "°C", TEMPERATURE).required(),
    number(Id::DetailHysteresis, "sheets.*.detail.hysteresis", "of a distance", (0.0, 0.5)).default("0.1"),
    number(Id::DetailGrid, "sheets.*.detail.levels.*.grid", "masses", (2.0, 2000.0)).kind(Pair).required(),
    number(Id::DetailDistance, "sheets.*.detail.levels.*.within", "m", (0.0, 1e6)).kind(Optional).default("none"),
    number(Id::BodySize, "bodies.*.shape", "m", EXTENT).required(),
    number(Id::BodyMass, "bodies.*.mass", "kg", (1e-9, 1e9)).kind(Optional).default("none"),
    number(Id::BodyDensity, "bodies.*.density", "kg/m³", (1e-3, 1e6)).kind(Optional).default("none"),
    number(Id::BodyVelocity, "bodies.*.velocity", "m/s", (-1e3, 1e3)).kind(Vector).default("(0, 0, 0)"),
    number(Id::BodySpin, "bodies.*.spin", "rad/s", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    number(Id::BodyFriction, "bodies.*.friction", "", FRICTION).kind(Optional).usual(0.0, 1.0).default("none"),
    number(Id::BodyRestitution, "bodies.*.restitution", "", FRACTION).kind(Optional).usual(0.0, 1.0).default("none"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_in_the_order_of_the_identifiers_and_their_paths_lead_back_to_them() {
        for (index, row) in TABLE.iter().enumerate() {
            assert_eq!(row.id as usize, index, "{row:?}");
            let path = row.path.replace("**", "bodies.0").replace('*', "3");
            assert_eq!(ParameterId::from_path(&path), Some(row.id), "{path}");
            assert!(row.range.is_none_or(|(min, max)| min < max), "{row:?}");
            let within = |usual: UsualRange| row.range.is_some_and(|(min, max)| min <= usual.min && usual.max <= max);
            assert!(row.usual.is_none_or(within), "{row:?}");
        }
        assert_eq!(ParameterId::from_path("gravity.1"), Some(ParameterId::Gravity));
        assert_eq!(ParameterId::from_path("sheets.strip.pins.0.path.2.offset.1"), Some(ParameterId::PathOffset));
        assert_eq!(ParameterId::from_path("sheets.strip.nothing"), None);
    }

    #[test]
    fn values_out_of_range_are_rejected_with_unit_and_range() {
        for row in TABLE {
            let Some((min, max)) = row.range else { continue };
            for good in [min, max, 0.5 * (min + max)] {
                row.id.check(row.path, good).unwrap_or_else(|e| panic!("{e}"));
            }
            for bad in [f64::NAN, f64::INFINITY, min - 1e-6 - 0.1 * min.abs(), max + 1e-6 + 0.1 * max.abs()] {
                let error = row.id.check(row.path, bad).expect_err(row.path);
                assert_eq!(error.field, row.path);
                assert!(error.problem.contains("is outside") && error.problem.ends_with(row.unit), "{error}");
            }
        }
    }
}
