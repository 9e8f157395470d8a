//! Reflection of the scene description, whose types do not depend on Bevy.
//!
//! Each struct here repeats one of [`sheetwork::scene`] field by field; a difference fails to
//! compile. Not reflected: lists of regions (pins, probes, applied velocities and forces), creases,
//! the recovery policy, levels of detail, Burgers' model, adhesion, the stiffness of woven sheets,
//! and the shape and hot faces of heaters.

#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::path::PathBuf;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::reflect::reflect_remote;
use sheetwork::material::calibration::Orthotropic;
use sheetwork::mesh::outline::{HoleSpec, OutlineSpec};
use sheetwork::mesh::slits::Slit;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    Adhesion, BurgersCreep, CreaseSpec, DetailSpec, HeaterSpec, HotFaceSpec, Material, MaterialChoice, PathKey,
    PinSpec, Placement, Polyhedron, PressureKey, RegionVector, SheetSpec, SpotSpec, SpringLaw, WhenUnstable,
};

#[reflect_remote(SheetSpec)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct SheetSpecReflect {
    name: String,
    #[reflect(remote = StructureKindReflect)]
    structure: StructureKind,
    grid: (u32, u32, u32),
    size: (f64, f64),
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
    node_mass: Option<f64>,
    damping: f64,
    damping_ratio: Option<f64>,
    drag: (f64, f64),
    cross_over: bool,
    flexion_stiffness: f64,
    flexion_limit: Option<f64>,
    thickness_limit: f64,
    #[reflect(remote = PlacementReflect)]
    placement: Placement,
    velocity: DVec3,
    spin: DVec3,
    #[reflect(ignore)]
    velocities: Vec<RegionVector>,
    #[reflect(ignore)]
    forces: Vec<RegionVector>,
    #[reflect(ignore)]
    pins: Vec<PinSpec>,
    #[reflect(ignore)]
    probes: BTreeMap<String, (f64, f64)>,
    friction: Option<f64>,
    restitution: Option<f64>,
    temperature: Option<f64>,
    temperature_gradient: bool,
    plastic: bool,
    creep: bool,
    sticky: bool,
    tearing: bool,
    #[reflect(ignore)]
    spots: Vec<SpotSpec>,
    #[reflect(ignore)]
    slits: Vec<Slit>,
    #[reflect(ignore)]
    creases: Vec<CreaseSpec>,
    #[reflect(ignore)]
    pressure: Vec<PressureKey>,
    curl: (f64, f64),
    #[reflect(ignore)]
    when_unstable: WhenUnstable,
    #[reflect(ignore)]
    detail: Option<DetailSpec>,
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
    Shell,
}

#[reflect_remote(SpringLaw)]
#[derive(Clone, Debug)]
pub(super) enum SpringLawReflect {
    Uniform,
    Calibrated,
    Length,
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
    young: f64,
    poisson: f64,
    density: f64,
    thickness: f64,
    damping_ratio: f64,
    yield_stress: Option<f64>,
    hardening: f64,
    #[reflect(ignore)]
    burgers: Option<BurgersCreep>,
    #[reflect(ignore)]
    orthotropic: Option<Orthotropic>,
    specific_heat: f64,
    conductivity: f64,
    emissivity: f64,
    expansion: f64,
    glass_transition: Option<f64>,
    softening: Vec<(f64, f64)>,
    wlf: (f64, f64),
    melts_at: Option<f64>,
    tears_at: Option<f64>,
    #[reflect(ignore)]
    tack: Option<Adhesion>,
}

#[reflect_remote(HeaterSpec)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct HeaterSpecReflect {
    name: String,
    file: Option<PathBuf>,
    #[reflect(ignore)]
    polyhedron: Option<Polyhedron>,
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
    position: DVec3,
    rotation: DVec3,
}

#[reflect_remote(PathKey)]
#[derive(Clone, Debug, Default)]
#[reflect(Default)]
pub(super) struct PathKeyReflect {
    time: f64,
    offset: DVec3,
    rotation: DVec3,
}
