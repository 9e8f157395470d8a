//! Rows of the table of parameters.

use crate::units::parameters::ParameterId as Id;
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
const fn number(id: Id, path: &'static str, unit: &'static str, range: (f64, f64)) -> ParameterRow {
    let (kind, scope, default) = (ParameterKind::Number, ParameterScope::Scene, DefaultSource::Field);
    ParameterRow { id, path, unit, range: Some(range), kind, scope, usual: None, default }
}

/// Row of a boolean or a name.
const fn word(id: Id, path: &'static str, kind: ParameterKind) -> ParameterRow {
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

/// All parameters. The order of those of a running world is that of its listing.
#[rustfmt::skip]
pub(super) const TABLE: &[ParameterRow] = &[
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
