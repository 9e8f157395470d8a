//! Names that most programs need: `use bevy_sheetwork::prelude::*`.

pub use crate::asset::{SheetPolyhedra, SheetScene, SheetSceneRoot, SheetSceneSpawned, SheetworkAssetPlugin};
pub use crate::core::{
    BodyMotion, BodyShape, Sheet, SheetAttachments, SheetBody, SheetCheckpoint, SheetClock, SheetContact,
    SheetContacts, SheetDetail, SheetEvent, SheetForces, SheetHeatGun, SheetHeater, SheetJoint, SheetMotion,
    SheetRayCast, SheetState, SheetThreading, SheetWind, SheetWorld, SheetworkCorePlugin, SheetworkSet,
};
#[cfg(feature = "render")]
pub use crate::debug::{SheetDebug, SheetworkDebugPlugin};
pub use crate::diagnostics::SheetworkDiagnosticsPlugin;
#[cfg(feature = "inspector")]
pub use crate::inspector::{SheetInspector, SheetInspectorPlugin};
#[cfg(feature = "link")]
pub use crate::link::{SheetLink, SheetLinkPlugin};
#[cfg(feature = "render")]
pub use crate::picking::SheetPickingPlugin;
#[cfg(feature = "render")]
pub use crate::render::{
    SheetColour, SheetDisplay, SheetLayer, SheetRoom, SheetSide, SheetSides, SheetworkRenderPlugin,
};
pub use crate::{SheetworkPlugins, sheetwork};
pub use sheetwork::islands::event::EventKind;
pub use sheetwork::mesh::outline::{HoleSpec, OutlineSpec};
pub use sheetwork::mesh::structure::StructureKind;
pub use sheetwork::scene::{
    DetailSpec, Material as SheetMaterial, PathKey, PinSpec, Region, SpringLaw, WindZone, ZoneVolume,
};
pub use sheetwork::{ContactEventKind, ContactPair, ContactPartner, ForceTarget, SheetId, SurfacePoint};
