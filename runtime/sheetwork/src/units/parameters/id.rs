//! Identifiers of the parameters.

/// Identifier of a parameter, one for each row of [`ParameterRow::all`](crate::ParameterRow::all).
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
