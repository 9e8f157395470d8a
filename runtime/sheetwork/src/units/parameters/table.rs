//! Parameters: identifiers and rows.

use crate::units::parameters::ParameterKind::{self, Boolean, Name, Optional, OptionalVector, Pair, Vector};
use crate::units::parameters::{DefaultSource, ParameterRow, ParameterScope, UsualRange};
use crate::units::temperature::{COLDEST, HOTTEST};

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
    let (kind, scope, default) = (ParameterKind::Number, ParameterScope::Scene, DefaultSource::Field);
    ParameterRow { id, path, unit, range: Some(range), kind, scope, usual: None, default }
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
        Self { scope: ParameterScope::Live, ..self }
    }

    const fn state(self) -> Self {
        Self { scope: ParameterScope::State, ..self }
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
}

/// Declare the parameters, each with its row: the variants of [`ParameterId`], and [`TABLE`] in
/// their order.
macro_rules! parameters {
    ($($(#[$doc:meta])* $id:ident: $kind:ident($($value:tt)*)$(.$set:ident($($argument:tt)*))*,)+) => {
        /// Identifier of a parameter, one for each row of [`ParameterRow::all`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum ParameterId {
            $($(#[$doc])* $id,)+
        }

        /// All parameters. The order of those of a running world is that of its listing.
        pub(super) const TABLE: &[ParameterRow] =
            &[$($kind(ParameterId::$id, $($value)*)$(.$set($($argument)*))*,)+];
    };
}

#[rustfmt::skip]
parameters! {
    /// Gravity.
    Gravity: number("gravity", "m/s²", (-1e3, 1e3)).kind(Vector).live(),
    /// Time integrator.
    Engine: word("engine", Name).live(),
    /// Time step.
    TimeStep: number("dt", "s", (1e-7, 1.0)).live(),
    /// Error tolerance of an adaptive integrator, per step.
    Tolerance: number("tolerance", "m", (1e-15, 1.0)).live(),
    /// Linear damping: fraction of its speed that a node keeps in every `air.per`.
    AirFactor: number("air.factor", "", (1e-6, 1.0)).live().usual(0.8, 1.0),
    /// Time of the linear damping.
    AirPer: number("air.per", "s", (1e-6, 1e3)).live(),
    /// Density of the air, for drag.
    AirDensity: number("air.density", "kg/m³", (0.0, 1e4)).live().usual(0.0, 2.0),
    /// Wind.
    AirWind: number("air.wind", "m/s", (-1e3, 1e3)).kind(Vector).live(),
    /// Temperature of the surroundings.
    AmbientTemperature: number("ambient_temperature", "°C", TEMPERATURE).live().usual(-20.0, 60.0),
    /// Convection coefficient of both sides of a sheet together.
    Convection: number("convection", "W/(m² K)", (0.0, 1e6)).live().usual(0.0, 100.0),
    /// Thermal time over mechanical time.
    TimeLapse: number("time_lapse", "", (1e-3, 1e4)).live().usual_logarithmic(0.1, 100.0),
    /// Temperature of the oven; setting it replaces the schedule.
    OvenTemperature: number("oven.temperature", "°C", TEMPERATURE).live().usual(20.0, 300.0),
    /// Whether the oven is on.
    OvenOn: word("oven.on", Boolean).live(),
    /// Whether a heater is on.
    HeaterOn: word("heaters.*.on", Boolean).live(),
    /// Temperature of all hot faces of a heater.
    HeaterTemperature: number("heaters.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    /// Temperature of a hot body; setting it replaces the schedule.
    BodyTemperature: number("bodies.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    /// Whether the heat gun is on.
    HeatGunOn: word("heat_gun.on", Boolean).live(),
    /// Temperature of the jet at the nozzle.
    HeatGunTemperature: number("heat_gun.temperature", "°C", TEMPERATURE).live().usual(50.0, 600.0),
    /// Position of the nozzle, x.
    HeatGunPositionX: number("heat_gun.position.0", "m", COORDINATE).live(),
    /// Position of the nozzle, y.
    HeatGunPositionY: number("heat_gun.position.1", "m", COORDINATE).live(),
    /// Position of the nozzle, z.
    HeatGunPositionZ: number("heat_gun.position.2", "m", COORDINATE).live(),
    /// Direction of the jet, x.
    HeatGunDirectionX: number("heat_gun.direction.0", "", COORDINATE).live(),
    /// Direction of the jet, y.
    HeatGunDirectionY: number("heat_gun.direction.1", "", COORDINATE).live(),
    /// Direction of the jet, z.
    HeatGunDirectionZ: number("heat_gun.direction.2", "", COORDINATE).live(),
    /// Maximum cost of a step by the cost model of the levels of detail.
    DetailBudget: number("detail_budget", "ms", (1e-3, 1e6)).kind(Optional).live(),
    /// Eye that the levels of detail follow.
    Viewpoint: number("viewpoint", "m", (-1e6, 1e6)).kind(OptionalVector).state().default("none"),
    /// Young's modulus.
    MaterialYoung: number("sheets.*.material.young", "Pa", (1e-3, 2e12)).live().usual_logarithmic(1.0, 1e11),
    /// Thickness of a sheet.
    MaterialThickness: number("sheets.*.material.thickness", "m", (1e-7, 1.0)).live().usual_logarithmic(1e-5, 5e-3),
    /// Poisson's ratio.
    MaterialPoisson: number("sheets.*.material.poisson", "", (-0.99, 0.499)).live().usual(0.0, 0.49),
    /// Dashpots along the springs of a lattice.
    Damping: number("sheets.*.damping", "of critical", (0.0, 10.0)).live().usual(0.0, 1.0),
    /// Damping ratio of the slowest bending mode.
    DampingRatio: number("sheets.*.damping_ratio", "of critical", (0.0, 10.0)).live().usual(0.0, 0.5).same_as("sheets.0.material.damping_ratio"),
    /// Stiffness of the springs between the layers of a lattice.
    InterLayerStiffness: number("sheets.*.inter_layer_stiffness", "N/m", (1e-9, 1e12))
        .kind(Optional).live().usual_logarithmic(0.01, 10.0),
    /// Drag coefficient for air across the sheet.
    DragAcross: number("sheets.*.drag.0", "", (0.0, 10.0)).live().usual(0.0, 2.0),
    /// Drag coefficient for air along the sheet.
    DragAlong: number("sheets.*.drag.1", "", (0.0, 10.0)).live().usual(0.0, 0.2),
    /// Pressure difference from the upper to the lower side.
    Pressure: number("sheets.*.pressure", "Pa", (-1e6, 1e6)).live().default("0"),
    /// Coulomb friction coefficient of a sheet.
    Friction: number("sheets.*.friction", "", FRICTION).live().usual(0.0, 1.0).same_as("contact.friction"),
    /// Ratio of separation to approach speed of a sheet.
    Restitution: number("sheets.*.restitution", "", FRACTION).live().usual(0.0, 1.0).same_as("contact.restitution"),
    /// Temperature of a sheet.
    Temperature: number("sheets.*.temperature", "°C", TEMPERATURE).live().same_as("ambient_temperature"),
    /// Largest bending angle of a flexion spring.
    FlexionLimit: number("sheets.*.flexion_limit", "degrees", (1.0, 180.0)).kind(Optional).live().usual(1.0, 180.0),
    /// Recovery policy of a sheet.
    WhenUnstable: word("sheets.*.when_unstable", Name).live(),
    /// Nodes along length and width of a sheet, as `21x11`.
    Grid: word("sheets.*.grid", Name).state().default("21x21"),
    /// Edge, radius or height of the volume of a wind zone.
    ZoneVolume: number("wind_zones.*.volume.*", "m", (1e-3, 1e6)).required(),
    /// Distance inside the border over which a wind zone fades in.
    ZoneFalloff: number("wind_zones.*.falloff", "m", (0.0, 1e6)).default("0"),
    /// Mean velocity of a wind zone.
    ZoneVelocity: number("wind_zones.*.velocity", "m/s", (-1e3, 1e3)).kind(Vector).default("(0, 0, 0)"),
    /// Distance up to which a body upwind shelters a node.
    ZoneShelter: number("wind_zones.*.shelter", "m", (0.0, 1e6)).default("0"),
    /// Largest increase of the mean velocity in a gust.
    GustAmplitude: number("wind_zones.*.gusts.amplitude", "of velocity", (0.0, 100.0)).required(),
    /// Duration of a gust.
    GustDuration: number("wind_zones.*.gusts.duration", "s", (1e-2, 1e6)).required(),
    /// Time between the starts of two gusts.
    GustPeriod: number("wind_zones.*.gusts.period", "s", (1e-2, 1e6)).required(),
    /// Root mean square of each component of turbulence.
    TurbulenceIntensity: number("wind_zones.*.turbulence.intensity", "m/s", (0.0, 1e3)).required(),
    /// Wavelength of the largest eddies.
    TurbulenceLength: number("wind_zones.*.turbulence.length", "m", (1e-3, 1e6)).required(),
    /// Circulation of a vortex.
    VortexCirculation: number("wind_zones.*.vortex.circulation", "m²/s", (-1e6, 1e6)).required(),
    /// Radius of the core of a vortex.
    VortexCore: number("wind_zones.*.vortex.core", "m", (1e-3, 1e6)).required(),
    /// Time of an explosion.
    BlastTime: number("wind_zones.*.blast.time", "s", TIME).required(),
    /// Peak overpressure of a blast.
    BlastOverpressure: number("wind_zones.*.blast.overpressure", "Pa", (0.0, 1e5)).required(),
    /// Distance to which the overpressure of a blast refers.
    BlastRadius: number("wind_zones.*.blast.radius", "m", (1e-2, 1e4)).required(),
    /// Duration of the positive phase of a blast.
    BlastDuration: number("wind_zones.*.blast.duration", "s", (1e-5, 10.0)).required(),
    /// Density of a fluid.
    FluidDensity: number("wind_zones.*.fluid.density", "kg/m³", (1e-3, 1e5)).required(),
    /// Height of the surface of a fluid.
    FluidSurface: number("wind_zones.*.fluid.surface", "m", COORDINATE).required(),
    /// Simulated duration.
    Duration: number("duration", "s", TIME),
    /// Whether sheets that start inside a body or another sheet are moved out of it.
    Repair: word("repair", Boolean),
    /// Conductance of a contact.
    ContactConductance: number("contact_conductance", "W/(m² K)", (1e-3, 1e6)),
    /// Thermal sensitivity of the thesis's formulas.
    ThesisSensitivity: number("heat_mode.*.sensitivity", "N/K", (0.0, 1e6)).required(),
    /// Thermal conductivity coefficient of the thesis's formulas.
    ThesisConductivity: number("heat_mode.*.conductivity", "", (0.0, 1e3)).default("0"),
    /// Convection coefficient in the oven.
    OvenConvection: number("oven.convection", "W/(m² K)", (0.0, 1e6)).kind(Optional),
    /// Time of a temperature of the oven's schedule.
    OvenScheduleTime: number("oven.schedule.*.time", "s", TIME).required(),
    /// Temperature of the oven's schedule.
    OvenScheduleTemperature: number("oven.schedule.*.temperature", "°C", TEMPERATURE).kind(Optional).default("none"),
    /// Time of a temperature of a body's schedule.
    BodyScheduleTime: number("bodies.*.temperature_schedule.*.time", "s", TIME).required(),
    /// Temperature of a body's schedule.
    BodyScheduleTemperature: number("bodies.*.temperature_schedule.*.temperature", "°C", TEMPERATURE)
        .kind(Optional).default("none"),
    /// Rise of the temperature of a body along its axes.
    BodyTemperatureSlope: number("bodies.*.temperature_slope", "K/m", (-1e5, 1e5)).kind(Vector).default("(0, 0, 0)"),
    /// Centre of a hot spot of a body.
    BodySpotCentre: number("bodies.*.hot_spots.*.at", "m", COORDINATE).kind(Vector).required(),
    /// Radius of a hot spot of a body.
    BodySpotRadius: number("bodies.*.hot_spots.*.radius", "m", (1e-6, 1e3)).required(),
    /// Temperature of a hot spot of a body.
    BodySpotTemperature: number("bodies.*.hot_spots.*.temperature", "°C", TEMPERATURE).required(),
    /// Convection coefficient at the nozzle.
    HeatGunConvection: number("heat_gun.convection", "W/(m² K)", (0.0, 1e6)),
    /// Half angle of the jet.
    HeatGunHalfAngle: number("heat_gun.half_angle", "degrees", (0.1, 90.0)),
    /// Distance at which the convection of the jet is halved.
    HeatGunReach: number("heat_gun.reach", "m", (1e-6, 1e4)),
    /// Edges of a heater that is a box.
    HeaterSize: number("heaters.*.size", "m", EXTENT).kind(OptionalVector),
    /// Temperature of a hot face.
    HotFaceTemperature: number("heaters.*.hot.*.temperature", "°C", TEMPERATURE).required(),
    /// Emissivity of a hot face.
    HotFaceEmissivity: number("heaters.*.hot.*.emissivity", "", FRACTION).default("1"),
    /// Friction coefficient of objects without one of their own.
    ContactFriction: number("contact.friction", "", FRICTION).usual(0.0, 1.0),
    /// Restitution of objects without one of their own.
    ContactRestitution: number("contact.restitution", "", FRACTION).usual(0.0, 1.0),
    /// Friction coefficient of two materials.
    PairFriction: number("contact.pairs.*.friction", "", FRICTION).kind(Optional).default("none"),
    /// Restitution of two materials.
    PairRestitution: number("contact.pairs.*.restitution", "", FRACTION).kind(Optional).default("none"),
    /// Eye of the camera.
    CameraEye: number("camera.eye", "m", COORDINATE).kind(Vector).required(),
    /// Point that the camera looks at.
    CameraTarget: number("camera.target", "m", COORDINATE).kind(Vector).required(),
    /// Spacing of the grid on the floor.
    RoomGrid: number("room.grid", "m", (1e-4, 100.0)),
    /// Extent of the room along an axis.
    RoomExtent: number("room.*", "m", COORDINATE).kind(Pair).required(),
    /// Position of a sheet, a body or a heater.
    PlacementPosition: number("**.placement.position", "m", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    /// Rotation of a sheet, a body or a heater about x, y and z.
    PlacementRotation: number("**.placement.rotation", "degrees", TURN).kind(Vector).default("(0, 0, 0)"),
    /// Time of a point of a path.
    PathTime: number("**.path.*.time", "s", TIME).default("0"),
    /// Displacement at a point of a path.
    PathOffset: number("**.path.*.offset", "m", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    /// Rotation at a point of a path.
    PathRotation: number("**.path.*.rotation", "degrees", TURN).kind(Vector).default("(0, 0, 0)"),
    /// Density of a material.
    MaterialDensity: number("sheets.*.material.density", "kg/m³", (1e-3, 1e6)).usual_logarithmic(10.0, 2e4),
    /// Specific heat.
    MaterialSpecificHeat: number("sheets.*.material.specific_heat", "J/(kg K)", (1.0, 1e5)),
    /// Thermal conductivity.
    MaterialConductivity: number("sheets.*.material.conductivity", "W/(m K)", (0.0, 1e4)),
    /// Emissivity.
    MaterialEmissivity: number("sheets.*.material.emissivity", "", FRACTION),
    /// Coefficient of thermal expansion.
    MaterialExpansion: number("sheets.*.material.expansion", "1/K", (-1e-2, 1e-2)),
    /// Temperature of a row of stiffness against temperature.
    SofteningTemperature: number("sheets.*.material.softening.*.0", "°C", TEMPERATURE).required(),
    /// Fraction of Young's modulus at that temperature.
    SofteningFraction: number("sheets.*.material.softening.*.1", "of young", (1e-9, 1e3)).required(),
    /// Damping ratio of the slowest bending mode, of a material.
    MaterialDampingRatio: number("sheets.*.material.damping_ratio", "of critical", (0.0, 10.0)),
    /// Flat loss factor.
    MaterialLossFactor: number("sheets.*.material.loss_factor", "", (0.0, 0.3)).kind(Optional),
    /// Yield stress.
    MaterialYieldStress: number("sheets.*.material.yield_stress", "Pa", (1.0, 1e11)).kind(Optional),
    /// Linear hardening modulus.
    MaterialHardening: number("sheets.*.material.hardening", "Pa", (0.0, 1e12)),
    /// Relaxation time of Burgers' model.
    BurgersRelaxationTime: number("sheets.*.material.burgers.relaxation_time", "s", (1e-6, 1e30)).required(),
    /// Retardation time of Burgers' model.
    BurgersRetardationTime: number("sheets.*.material.burgers.retardation_time", "s", (1e-6, 1e30)).required(),
    /// Retarded over instantaneous strain of Burgers' model.
    BurgersRetarded: number("sheets.*.material.burgers.retarded", "", (0.0, 1e4)).required(),
    /// Glass transition temperature.
    GlassTransition: number("sheets.*.material.glass_transition", "°C", (COLDEST, 1000.0)).kind(Optional),
    /// First constant of Williams, Landel and Ferry.
    WlfFirst: number("sheets.*.material.wlf.0", "", (1.0, 100.0)),
    /// Second constant of Williams, Landel and Ferry.
    WlfSecond: number("sheets.*.material.wlf.1", "K", (1.0, 1000.0)),
    /// Temperature at which a cell opens.
    MeltsAt: number("sheets.*.material.melts_at", "°C", TEMPERATURE).kind(Optional),
    /// Strength of adhesion.
    TackStrength: number("sheets.*.material.tack.strength", "Pa", (1e-3, 1e9)).required(),
    /// Temperature above which adhesion begins.
    TackAbove: number("sheets.*.material.tack.above", "°C", TEMPERATURE).required(),
    /// Temperature below which bonds open, at most `above`.
    TackLetsGoBelow: number("sheets.*.material.tack.lets_go_below", "°C", TEMPERATURE).kind(Optional).default("none"),
    /// Thermal sensitivity of a material in the thesis's formulas.
    MaterialThesisSensitivity: number("sheets.*.material.thesis_sensitivity", "N/K", (0.0, 1e6))
        .kind(Optional).live().usual(0.0, 1e-3),
    /// Thermal conductivity coefficient of a material in the thesis's formulas.
    MaterialThesisConductivity: number("sheets.*.material.thesis_conductivity", "", (0.0, 1e3))
        .kind(Optional).live().usual(0.0, 2.0),
    /// Fracture strain.
    TearsAt: number("sheets.*.material.tears_at", "of strain", (1e-3, 10.0)).kind(Optional),
    /// Membrane stiffness of a woven sheet along the warp.
    YoungWarp: number("sheets.*.material.orthotropic.young_warp", "N/m", (1e-6, 1e12)).required(),
    /// Membrane stiffness of a woven sheet along the weft.
    YoungWeft: number("sheets.*.material.orthotropic.young_weft", "N/m", (1e-6, 1e12)).required(),
    /// Shear stiffness of a woven sheet.
    Shear: number("sheets.*.material.orthotropic.shear", "N/m", (0.0, 1e12)).required(),
    /// Bending stiffness of a woven sheet along the warp.
    BendingWarp: number("sheets.*.material.orthotropic.bending_warp", "N m", (1e-15, 1e9)).required(),
    /// Bending stiffness of a woven sheet along the weft.
    BendingWeft: number("sheets.*.material.orthotropic.bending_weft", "N m", (1e-15, 1e9)).required(),
    /// Twisting stiffness of a woven sheet.
    Twist: number("sheets.*.material.orthotropic.twist", "N m", (0.0, 1e9)).required(),
    /// Angle from the length of a sheet to the warp.
    WarpDirection: number("sheets.*.material.orthotropic.direction", "degrees", (-180.0, 180.0)).default("0"),
    /// Nodes along the length of a sheet.
    GridLength: number("sheets.*.grid.0", "masses", (2.0, 2000.0)),
    /// Nodes along the width of a sheet.
    GridWidth: number("sheets.*.grid.2", "masses", (2.0, 2000.0)),
    /// Length and width of a sheet.
    Size: number("sheets.*.size", "m", (1e-6, 1e3)).kind(Pair),
    /// Distance of the layers of a lattice.
    Gap: number("sheets.*.gap", "m", (1e-7, 10.0)),
    /// Time of a pressure.
    PressureTime: number("sheets.*.pressure.*.time", "s", TIME).required(),
    /// Pressure difference at that time.
    PressureValue: number("sheets.*.pressure.*.pressure", "Pa", (-1e6, 1e6)).required(),
    /// Factor on the stiffness of flexion springs.
    FlexionStiffness: number("sheets.*.flexion_stiffness", "", (0.0, 1e3)),
    /// Least thickness of a lattice over its gap.
    ThicknessLimit: number("sheets.*.thickness_limit", "", (0.0, 0.95)),
    /// Mass of a node.
    NodeMass: number("sheets.*.node_mass", "kg", (1e-12, 1e6)).kind(Optional),
    /// Initial velocity of a sheet.
    SheetVelocity: number("sheets.*.velocity", "m/s", COORDINATE).kind(Vector),
    /// Initial angular velocity of a sheet.
    SheetSpin: number("sheets.*.spin", "rad/s", COORDINATE).kind(Vector),
    /// Initial velocity of a region.
    RegionVelocity: number("sheets.*.velocities.*.value", "m/s", (-1e6, 1e6)).kind(Vector).required(),
    /// Force on a region.
    RegionForce: number("sheets.*.forces.*.value", "N", (-1e6, 1e6)).kind(Vector).required(),
    /// Coordinate u or v of a region.
    RegionCoordinate: number("sheets.*.*.*.region.*", "", FRACTION).required(),
    /// Time at which a pin is released.
    PinUntil: number("sheets.*.pins.*.until", "s", TIME).kind(Optional).default("none"),
    /// Position (u, v) of a probe.
    ProbePosition: number("sheets.*.probes.*", "", FRACTION).kind(Pair).required(),
    /// Start (u, v) of a crease.
    CreaseFrom: number("sheets.*.creases.*.from", "", FRACTION).kind(Pair).required(),
    /// End (u, v) of a crease.
    CreaseTo: number("sheets.*.creases.*.to", "", FRACTION).kind(Pair).required(),
    /// Rest angle of a crease.
    CreaseAngle: number("sheets.*.creases.*.angle", "degrees", (-175.0, 175.0)).required(),
    /// Rest curvatures of a sheet.
    Curl: number("sheets.*.curl", "1/m", (-1e5, 1e5)).kind(Pair),
    /// End (u, v) of a slit.
    SlitEnd: number("sheets.*.slits.*.*", "", FRACTION).kind(Pair).required(),
    /// Coordinate of a corner of an outline.
    OutlineCorner: number("sheets.*.outline.*.*", "m", (-1e3, 1e3)).required(),
    /// Coordinate of a corner of a hole, or of its centre.
    HoleCorner: number("sheets.*.holes.*.*.*", "m", (-1e3, 1e3)).required(),
    /// Coordinate of a point of a cut.
    CutPoint: number("sheets.*.cuts.*.*.*", "m", (-1e3, 1e3)).required(),
    /// Coordinate of a vertex of a polyhedron.
    VertexCoordinate: number("bodies.*.shape.vertices.*.*", "m", COORDINATE).required(),
    /// Centre (u, v) of a hot spot.
    SpotCentre: number("sheets.*.spots.*.at", "", FRACTION).kind(Pair).required(),
    /// Radius of a hot spot.
    SpotRadius: number("sheets.*.spots.*.radius", "m", (1e-6, 1e3)).required(),
    /// Temperature of a hot spot.
    SpotTemperature: number("sheets.*.spots.*.temperature", "°C", TEMPERATURE).required(),
    /// Hysteresis of the distances of levels of detail.
    DetailHysteresis: number("sheets.*.detail.hysteresis", "of a distance", (0.0, 0.5)).default("0.1"),
    /// Nodes along length and width at a level of detail.
    DetailGrid: number("sheets.*.detail.levels.*.grid", "masses", (2.0, 2000.0)).kind(Pair).required(),
    /// Distance up to which a level of detail is used.
    DetailDistance: number("sheets.*.detail.levels.*.within", "m", (0.0, 1e6)).kind(Optional).default("none"),
    /// Largest number of times that an edge is halved by local refinement.
    RefineLevels: number("sheets.*.refine.levels", "halvings", (1.0, 3.0)).default("2"),
    /// Largest fold angle per edge of a refined mesh.
    RefineFold: number("sheets.*.refine.fold", "degrees", (0.5, 90.0)).default("10"),
    /// Strain that is refined.
    RefineStrain: number("sheets.*.refine.strain", "of tears_at", (0.01, 1.0)).kind(Optional).default("none"),
    /// Part of the limits below which a refined mesh is coarsened.
    RefineHysteresis: number("sheets.*.refine.hysteresis", "of the limits", (0.0, 0.9)).default("0.5"),
    /// Steps between changes of a refined mesh.
    RefineEvery: number("sheets.*.refine.every", "steps", (1.0, 1e5)).default("10"),
    /// Radius of a ball, or edge of a box.
    BodySize: number("bodies.*.shape", "m", EXTENT).required(),
    /// Mass of a dynamic body.
    BodyMass: number("bodies.*.mass", "kg", (1e-9, 1e9)).kind(Optional).default("none"),
    /// Density of a dynamic body.
    BodyDensity: number("bodies.*.density", "kg/m³", (1e-3, 1e6)).kind(Optional).default("none"),
    /// Initial velocity of a dynamic body.
    BodyVelocity: number("bodies.*.velocity", "m/s", (-1e3, 1e3)).kind(Vector).default("(0, 0, 0)"),
    /// Initial angular velocity of a dynamic body.
    BodySpin: number("bodies.*.spin", "rad/s", COORDINATE).kind(Vector).default("(0, 0, 0)"),
    /// Friction coefficient of a body.
    BodyFriction: number("bodies.*.friction", "", FRICTION).kind(Optional).usual(0.0, 1.0).default("none"),
    /// Restitution of a body.
    BodyRestitution: number("bodies.*.restitution", "", FRACTION).kind(Optional).usual(0.0, 1.0).default("none"),
}
