//! Reflection of the scene description, whose types do not depend on Bevy.
//!
//! Each struct here repeats one of [`sheetwork::scene`] field by field; a difference fails to
//! compile. The range of a number in the table of parameters is an attribute of its field. Not
//! reflected: lists of regions (pins, probes, applied velocities and forces), creases, the
//! recovery policy, the law of aerodynamics, levels of detail, refinement, Burgers' model,
//! adhesion, the stiffness of woven sheets, and the shape and hot faces of heaters.

#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::reflect::reflect_remote;
use sheetwork::ParameterId as Id;
use sheetwork::material::calibration::Orthotropic;
use sheetwork::mesh::outline::{HoleSpec, OutlineSpec};
use sheetwork::mesh::slits::Slit;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    Adhesion, Aerodynamics, BurgersCreep, ContactSurface, CreaseSpec, DetailSpec, HeaterSpec, HotFaceSpec,
    InterLayerLaw, Material, MaterialChoice, PinSpec, Placement, Polyhedron, PressureKey, RefineSpec, RegionVector,
    SheetSpec, SpotSpec, SpringLaw, WhenUnstable,
};

/// Range of a parameter, the attribute of its reflected field.
fn range(id: Id) -> RangeInclusive<f64> {
    let (min, max) = id.row().range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    min..=max
}

#[reflect_remote(SheetSpec)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct SheetSpecReflect {
    name: String,
    #[reflect(remote = StructureKindReflect)]
    structure: StructureKind,
    grid: (u32, u32, u32),
    #[reflect(@range(Id::Size))]
    size: (f64, f64),
    #[reflect(@range(Id::Gap))]
    gap: f64,
    file: Option<PathBuf>,
    #[reflect(ignore)]
    outline: Option<OutlineSpec>,
    #[reflect(ignore)]
    holes: Vec<HoleSpec>,
    #[reflect(ignore)]
    cuts: Vec<Vec<(f64, f64)>>,
    #[reflect(remote = MaterialChoiceReflect)]
    material: MaterialChoice,
    #[reflect(remote = SpringLawReflect)]
    springs: SpringLaw,
    #[reflect(remote = InterLayerLawReflect)]
    inter_layer: InterLayerLaw,
    #[reflect(@range(Id::InterLayerStiffness))]
    inter_layer_stiffness: Option<f64>,
    #[reflect(@range(Id::NodeMass))]
    node_mass: Option<f64>,
    #[reflect(@range(Id::Damping))]
    damping: f64,
    #[reflect(@range(Id::DampingRatio))]
    damping_ratio: Option<f64>,
    drag: (f64, f64),
    #[reflect(ignore)]
    aerodynamics: Aerodynamics,
    cross_over: bool,
    #[reflect(@range(Id::FlexionStiffness))]
    flexion_stiffness: f64,
    #[reflect(@range(Id::FlexionLimit))]
    flexion_limit: Option<f64>,
    #[reflect(@range(Id::ThicknessLimit))]
    thickness_limit: f64,
    #[reflect(remote = PlacementReflect)]
    placement: Placement,
    #[reflect(@range(Id::SheetVelocity))]
    velocity: DVec3,
    #[reflect(@range(Id::SheetSpin))]
    spin: DVec3,
    #[reflect(ignore)]
    velocities: Vec<RegionVector>,
    #[reflect(ignore)]
    forces: Vec<RegionVector>,
    #[reflect(ignore)]
    pins: Vec<PinSpec>,
    #[reflect(ignore)]
    probes: BTreeMap<String, (f64, f64)>,
    #[reflect(@range(Id::Friction))]
    friction: Option<f64>,
    #[reflect(@range(Id::Restitution))]
    restitution: Option<f64>,
    #[reflect(@range(Id::Temperature))]
    temperature: Option<f64>,
    temperature_gradient: bool,
    plastic: bool,
    creep: bool,
    sticky: bool,
    #[reflect(ignore)]
    contact_surface: ContactSurface,
    tearing: bool,
    #[reflect(ignore)]
    spots: Vec<SpotSpec>,
    #[reflect(ignore)]
    slits: Vec<Slit>,
    #[reflect(ignore)]
    creases: Vec<CreaseSpec>,
    #[reflect(ignore)]
    pressure: Vec<PressureKey>,
    #[reflect(@range(Id::Curl))]
    curl: (f64, f64),
    #[reflect(ignore)]
    when_unstable: WhenUnstable,
    #[reflect(ignore)]
    detail: Option<DetailSpec>,
    #[reflect(ignore)]
    refine: Option<RefineSpec>,
}

#[reflect_remote(StructureKind)]
#[derive(Clone, Debug)]
pub(super) enum StructureKindReflect {
    Samm,
    Slamm,
    DoubleDiagonal,
    Trimm,
    Provot2d,
    Provot3d,
    ProvotTrimm,
    Shell,
}

#[reflect_remote(SpringLaw)]
#[derive(Clone, Debug)]
pub(super) enum SpringLawReflect {
    Uniform,
    Calibrated,
    Length,
}

#[reflect_remote(InterLayerLaw)]
#[derive(Clone, Debug)]
pub(super) enum InterLayerLawReflect {
    Planar,
    Modulus(f64),
    SumModulus(f64),
    SumStiffness(f64),
}

#[reflect_remote(MaterialChoice)]
#[derive(Clone, Debug)]
pub(super) enum MaterialChoiceReflect {
    Named(String),
    File(PathBuf),
    Inline(#[reflect(remote = MaterialReflect)] Material),
}

#[reflect_remote(Material)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct MaterialReflect {
    name: String,
    #[reflect(@range(Id::MaterialYoung))]
    young: f64,
    #[reflect(@range(Id::MaterialPoisson))]
    poisson: f64,
    #[reflect(@range(Id::MaterialDensity))]
    density: f64,
    #[reflect(@range(Id::MaterialThickness))]
    thickness: f64,
    #[reflect(@range(Id::MaterialDampingRatio))]
    damping_ratio: f64,
    #[reflect(@range(Id::MaterialLossFactor))]
    loss_factor: Option<f64>,
    #[reflect(@range(Id::MaterialYieldStress))]
    yield_stress: Option<f64>,
    #[reflect(@range(Id::MaterialHardening))]
    hardening: f64,
    #[reflect(ignore)]
    burgers: Option<BurgersCreep>,
    #[reflect(ignore)]
    orthotropic: Option<Orthotropic>,
    #[reflect(@range(Id::MaterialSpecificHeat))]
    specific_heat: f64,
    #[reflect(@range(Id::MaterialConductivity))]
    conductivity: f64,
    #[reflect(@range(Id::MaterialEmissivity))]
    emissivity: f64,
    #[reflect(@range(Id::MaterialExpansion))]
    expansion: f64,
    #[reflect(@range(Id::GlassTransition))]
    glass_transition: Option<f64>,
    softening: Vec<(f64, f64)>,
    wlf: (f64, f64),
    #[reflect(@range(Id::MeltsAt))]
    melts_at: Option<f64>,
    #[reflect(@range(Id::TearsAt))]
    tears_at: Option<f64>,
    #[reflect(ignore)]
    tack: Option<Adhesion>,
    #[reflect(@range(Id::MaterialThesisSensitivity))]
    thesis_sensitivity: Option<f64>,
    #[reflect(@range(Id::MaterialThesisConductivity))]
    thesis_conductivity: Option<f64>,
}

#[reflect_remote(HeaterSpec)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct HeaterSpecReflect {
    name: String,
    file: Option<PathBuf>,
    #[reflect(ignore)]
    polyhedron: Option<Polyhedron>,
    #[reflect(@range(Id::HeaterSize))]
    size: Option<DVec3>,
    #[reflect(ignore)]
    hot: Vec<HotFaceSpec>,
    on: bool,
    #[reflect(remote = PlacementReflect)]
    placement: Placement,
}

#[reflect_remote(Placement)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct PlacementReflect {
    #[reflect(@range(Id::PlacementPosition))]
    position: DVec3,
    #[reflect(@range(Id::PlacementRotation))]
    rotation: DVec3,
}
