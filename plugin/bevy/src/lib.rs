//! Stiff thin sheets in [Bevy](https://bevy.org): add [`SheetworkPlugins`], spawn a [`Sheet`].
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_sheetwork::prelude::*;
//!
//! fn main() {
//!     App::new()
//!         .add_plugins((DefaultPlugins, SheetworkPlugins))
//!         .add_systems(Startup, setup)
//!         .run();
//! }
//!
//! fn setup(mut commands: Commands) {
//!     commands.spawn(Sheet::new("rubber").size(0.5, 0.5));
//! }
//! ```
//!
//! All sheets live in one [`sheetwork::World`], the resource [`SheetWorld`]. Entities describe and
//! display its contents. Lengths are in metres; one Bevy unit is one metre; +y is up.
//!
//! | Plugin | Purpose | Needs |
//! |---|---|---|
//! | [`SheetworkCorePlugin`] | entities into the world, steps, [`SheetEvent`]s | time, transforms |
//! | [`SheetworkAssetPlugin`] | files as assets, scenes as entities | `AssetPlugin` |
//! | [`SheetworkDiagnosticsPlugin`] | measurements in Bevy's `DiagnosticsStore` | |
//! | `SheetworkRenderPlugin` (feature `render`) | meshes and materials | `PbrPlugin` |
//! | `SheetPickingPlugin` (feature `render`) | sheets under the pointer | `PickingPlugin` |
//! | `SheetworkDebugPlugin` (feature `render`) | springs and nodes as gizmos | `GizmoPlugin` |
//! | `SheetLinkPlugin` (feature `link`) | the world in shared memory | |
//! | `SheetInspectorPlugin` (feature `inspector`) | panels with parameters | bevy_egui |
//!
//! [`SheetworkPlugins`] adds the first four. Entities with [`Sheet`], [`SheetBody`],
//! [`SheetHeater`] and [`SheetHeatGun`] form the world; [`SheetSceneRoot`] spawns a scene and
//! follows its file.
//!
//! A server depends on this crate with `default-features = false`: without the feature `render`
//! neither wgpu nor winit nor x11 is compiled, and [`SheetworkPlugins`] has the first three.
//!
//! # Order of a frame
//! In `FixedUpdate` the sets of [`SheetworkSet`] run in this order: `Sync` (entities to world),
//! `Step` (time integration), `Writeback` (world to entities). Systems that move bodies run before
//! `Sync`; systems that read sheets run after `Writeback`. Once a frame, in `PostUpdate`, the
//! displayed state is interpolated between the last two states, at [`SheetWorld::shown_time`].
//!
//! # Time
//! Every run of `FixedUpdate` advances the sheets by the period of `Time<Fixed>`, in whole time
//! steps of [`World::dt`](sheetwork::World::dt). The remainder is added to the next run.
//! [`SheetClock`] pauses, scales, single-steps and limits the simulated time.

#![forbid(unsafe_op_in_unsafe_fn)]
// The query of a system documents its accesses; a type alias would hide them.
#![allow(clippy::type_complexity)]

pub mod asset;
pub mod core;
#[cfg(feature = "render")]
pub mod debug;
pub mod diagnostics;
#[cfg(all(doctest, feature = "inspector", feature = "link"))]
mod documents;
#[cfg(feature = "inspector")]
pub mod inspector;
#[cfg(feature = "link")]
pub mod link;
#[cfg(feature = "render")]
pub mod picking;
pub mod prelude;
#[cfg(feature = "render")]
pub mod render;

use bevy::app::{PluginGroup, PluginGroupBuilder};

pub use asset::{SheetFileAsset, SheetPolyhedra, SheetScene, SheetSceneRoot, SheetSceneSpawned, SheetworkAssetPlugin};
pub use core::{
    BodyMotion, BodyShape, HeaterHandle, JointLink, Sheet, SheetAttachments, SheetBody, SheetCheckpoint, SheetClock,
    SheetContact, SheetContactPair, SheetContacts, SheetDetail, SheetEvent, SheetForces, SheetHeatGun, SheetHeater,
    SheetJoint, SheetMotion, SheetRayCast, SheetState, SheetThreading, SheetWind, SheetWorld, SheetworkCorePlugin,
    SheetworkSet, StepTimes,
};
#[cfg(feature = "render")]
pub use debug::{SheetDebug, SheetGizmos, SheetworkDebugPlugin};
pub use diagnostics::SheetworkDiagnosticsPlugin;
#[cfg(feature = "inspector")]
pub use inspector::{SheetInspector, SheetInspectorPlugin};
#[cfg(feature = "link")]
pub use link::{SheetLink, SheetLinkPlugin};
#[cfg(feature = "render")]
pub use picking::SheetPickingPlugin;
#[cfg(feature = "render")]
pub use render::{SheetColour, SheetDisplay, SheetLayer, SheetRoom, SheetSide, SheetSides, SheetworkRenderPlugin};
pub use sheetwork;
#[cfg(feature = "link")]
pub use sheetwork_link;

/// Plugin group with core, assets, diagnostics and, with the feature `render`, rendering;
/// without `SheetPickingPlugin` and `SheetworkDebugPlugin`.
pub struct SheetworkPlugins;

impl PluginGroup for SheetworkPlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>();
        let group = group.add(SheetworkCorePlugin::default()).add(SheetworkAssetPlugin).add(SheetworkDiagnosticsPlugin);
        #[cfg(feature = "render")]
        let group = group.add(SheetworkRenderPlugin);
        group
    }
}
