//! Specification of the air: drag of the whole scene, and zones of wind, gusts, turbulence,
//! vortices, blasts and fluids.
//!
//! `sheet/wind` evaluates the zones, and names the source of each formula.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::{InputError, reject_if};
use crate::scene::{Placement, validate};
use crate::units::parameters::ParameterId as Id;

/// Air, with two models. Linear damping: a node keeps the fraction `factor` of its velocity every
/// `per` seconds (thesis table 4.3), applied as the force -λ m v with λ = -ln(factor)/per,
/// independent of integrator and step. Pressure drag: a `density` and a `wind` act on the area of
/// the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Fraction of its velocity that a node keeps, above 0 up to 1; 1 disables linear damping.
    pub factor: f64,
    /// Time in which the node keeps that fraction, s; 1e-6 to 1e3. The default is the time step of
    /// the thesis, 0.015 s.
    pub per: f64,
    /// Density of the air for pressure drag, kg/m³; 0 to 1e4. 0 disables it; air in a room has
    /// 1.2.
    pub density: f64,
    /// Velocity of the air, m/s; each component within ±1e3.
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

/// Law of the aerodynamic force on a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Aerodynamics {
    /// Normal force proportional to the square of the normal velocity: for sheets that fall, flap
    /// or drift.
    #[default]
    Drag,
    /// Thin plate with lift at small incidence and a centre of pressure ahead of the middle: for
    /// sheets that glide. `drag.0` is the normal force coefficient across the stream.
    Plate,
}

/// Volume of a wind zone, about the origin of its placement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ZoneVolume {
    /// The whole space.
    #[default]
    Everywhere,
    /// Box with these edges along its axes, m; each 1e-3 to 1e6.
    Box(DVec3),
    /// Ball of this radius, m; 1e-3 to 1e6.
    Ball(f64),
    /// Cylinder of this radius and height about the y axis, m; each 1e-3 to 1e6.
    Cylinder(f64, f64),
}

/// Part of space in which the air moves. The velocities of overlapping zones and of `air.wind` add
/// up. Where `air.density` is 0 the air of a zone has 1.2 kg/m³.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WindZone {
    /// Name for people; may be empty.
    pub name: String,
    /// Volume.
    pub volume: ZoneVolume,
    /// Position and orientation of the volume.
    pub placement: Placement,
    /// Distance inside the border over which the zone fades in, m; 0 to 1e6.
    pub falloff: f64,
    /// Mean velocity along the axes of the zone, m/s; each component within ±1e3.
    pub velocity: DVec3,
    /// Gusts of the mean velocity.
    pub gusts: Option<GustSpec>,
    /// Turbulence, carried along by the mean velocity.
    pub turbulence: Option<TurbulenceSpec>,
    /// Vortex about the y axis of the zone.
    pub vortex: Option<VortexSpec>,
    /// Blast from the origin of the zone.
    pub blast: Option<BlastSpec>,
    /// Fluid that fills the volume up to a level.
    pub fluid: Option<FluidSpec>,
    /// Distance up to which a body upwind shelters a node from mean velocity, gusts, turbulence and
    /// vortex, m; 0 to 1e6. 0 disables shelter, which costs a ray per node.
    pub shelter: f64,
    /// Whether moving bodies displace the air and drag a wake behind them.
    pub wakes: bool,
}

/// Gusts: at regular intervals the mean velocity rises by a fraction and falls again, as 1 - cos.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GustSpec {
    /// Largest increase as a fraction of the mean velocity; 0 to 100.
    pub amplitude: f64,
    /// Duration of a gust, s; 1e-2 to 1e6.
    pub duration: f64,
    /// Time from the start of one gust to that of the next, s; at least `duration`, up to 1e6.
    pub period: f64,
}

/// Isotropic turbulence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurbulenceSpec {
    /// Root mean square of each component of the velocity, m/s; 0 to 1e3.
    pub intensity: f64,
    /// Wavelength of the largest eddies, m; 1e-3 to 1e6.
    pub length: f64,
    /// Seed of directions and phases.
    #[serde(default)]
    pub seed: u32,
}

/// Lamb-Oseen vortex.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VortexSpec {
    /// Circulation, right-handed about the y axis of the zone, m²/s; within ±1e6.
    pub circulation: f64,
    /// Radius of the core, m; 1e-3 to 1e6.
    pub core: f64,
}

/// Spherical blast wave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlastSpec {
    /// Simulated time of the explosion, s; 0 to 1e6.
    pub time: f64,
    /// Peak overpressure at `radius` and nearer, Pa; 0 to 1e5. It falls as 1/distance beyond.
    pub overpressure: f64,
    /// Reference distance, m; 1e-2 to 1e4.
    pub radius: f64,
    /// Duration of the positive phase, s; 1e-5 to 10.
    pub duration: f64,
}

/// Fluid at rest up to a level, for buoyancy and drag.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidSpec {
    /// Density, kg/m³; 1e-3 to 1e5. Water has 1000.
    pub density: f64,
    /// Height y of the surface in the world, m; within ±1e4.
    pub surface: f64,
}

impl WindZone {
    /// Check the ranges.
    pub(crate) fn check(&self) -> Result<(), InputError> {
        match self.volume {
            ZoneVolume::Everywhere => {}
            ZoneVolume::Box(edges) => Id::ZoneVolume.check_each("volume", edges.to_array())?,
            ZoneVolume::Ball(radius) => Id::ZoneVolume.check("volume", radius)?,
            ZoneVolume::Cylinder(radius, height) => Id::ZoneVolume.check_each("volume", [radius, height])?,
        }
        validate::placement(&self.placement)?;
        Id::ZoneFalloff.check("falloff", self.falloff)?;
        Id::ZoneVelocity.check_each("velocity", self.velocity.to_array())?;
        Id::ZoneShelter.check("shelter", self.shelter)?;
        if let Some(gusts) = &self.gusts {
            Id::GustAmplitude.check("gusts.amplitude", gusts.amplitude)?;
            Id::GustDuration.check("gusts.duration", gusts.duration)?;
            Id::GustPeriod.check("gusts.period", gusts.period)?;
            let problem = "is shorter than the duration of a gust";
            reject_if!(gusts.period < gusts.duration, "gusts.period", "{} s {problem}", gusts.period);
        }
        if let Some(turbulence) = &self.turbulence {
            Id::TurbulenceIntensity.check("turbulence.intensity", turbulence.intensity)?;
            Id::TurbulenceLength.check("turbulence.length", turbulence.length)?;
        }
        if let Some(vortex) = &self.vortex {
            Id::VortexCirculation.check("vortex.circulation", vortex.circulation)?;
            Id::VortexCore.check("vortex.core", vortex.core)?;
        }
        if let Some(blast) = &self.blast {
            Id::BlastTime.check("blast.time", blast.time)?;
            Id::BlastOverpressure.check("blast.overpressure", blast.overpressure)?;
            Id::BlastRadius.check("blast.radius", blast.radius)?;
            Id::BlastDuration.check("blast.duration", blast.duration)?;
        }
        self.fluid.as_ref().map_or(Ok(()), |fluid| {
            Id::FluidDensity.check("fluid.density", fluid.density)?;
            Id::FluidSurface.check("fluid.surface", fluid.surface)
        })
    }
}
