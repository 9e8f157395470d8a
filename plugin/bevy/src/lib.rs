//! Stiff thin sheets in [Bevy](https://bevy.org): add [`SheetworkPlugins`], spawn a [`Sheet`].
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_sheetwork::prelude::*;
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, SheetworkPlugins)).add_systems(Startup, setup).run();
//! }
//!
//! fn setup(mut commands: Commands) {
//!     commands.spawn(Sheet::new("rubber").size(0.5, 0.5));
//! }
//! ```
//!
//! The sheets live in one [`sheetwork::World`], the resource [`SheetWorld`]; entities describe what is in it and show it.
//! Lengths are metres, one Bevy unit each; +y is up.
//!
//! | Plugin | What it does | Needs |
//! |---|---|---|
//! | [`SheetworkCorePlugin`] | puts [`Sheet`], [`SheetBody`], [`SheetHeater`] and [`SheetHeatGun`] entities into the world, steps it in `FixedUpdate`, sends [`SheetEvent`]s | time and transforms |
//! | [`SheetworkAssetPlugin`] | scene files, `.sht` and `.pol` files as assets; [`SheetSceneRoot`] spawns a scene and follows its file | `AssetPlugin` |
//! | [`SheetworkRenderPlugin`] | meshes and materials for sheets, bodies and the room | `PbrPlugin` |
//! | [`SheetworkDiagnosticsPlugin`] | step time, masses, contacts, energy in Bevy's `DiagnosticsStore` | nothing |
//! | `SheetLinkPlugin` (feature `link`) | shows the sheets to other processes and lets them turn their knobs; not in the group | nothing |
//! | `SheetInspectorPlugin` (feature `inspector`) | a window with the sheets' parameters, turned while the game runs; not in the group | a window, bevy_egui |
//! | [`SheetworkDebugPlugin`] | draws springs and masses as gizmos; not in the group, add it where you want it | `GizmoPlugin` |
//!
//! `SheetworkPlugins.build().disable::<SheetworkRenderPlugin>()` is a server's set.
//!
//! # Order of a frame
//! In `FixedUpdate`, the sets of [`SheetworkSet`]: `Sync` (entities to world), `Step` (time passes), `Writeback` (world to
//! entities). Systems of your own that move bodies go before `Sync`; those that read sheets go after `Writeback`. Once a
//! frame, in `PostUpdate`, the display is drawn between the last states, at [`SheetWorld::shown_time`].
//!
//! # Time
//! Every run of `FixedUpdate` advances the sheets by the period of `Time<Fixed>`, in whole engine steps of
//! [`World::dt`](sheetwork::World::dt); what is left over waits for the next. [`SheetClock`] pauses, slows, single-steps and
//! caps it.

#![forbid(unsafe_op_in_unsafe_fn)]
// A system's queries say what it touches; an alias for each would say it somewhere else.
#![allow(clippy::type_complexity)]

pub mod asset;
pub mod core;
pub mod debug;
pub mod diagnostics;
#[cfg(feature = "inspector")]
pub mod inspector;
#[cfg(feature = "link")]
pub mod link;
pub mod prelude;
pub mod render;

use bevy::app::{PluginGroup, PluginGroupBuilder};

pub use asset::{SheetFileAsset, SheetPolyhedra, SheetScene, SheetSceneRoot, SheetSceneSpawned, SheetworkAssetPlugin};
pub use core::{
    BodyMotion, BodyShape, HeaterPlace, Sheet, SheetBody, SheetClock, SheetDetail, SheetEvent, SheetHeatGun,
    SheetHeater, SheetMotion, SheetState, SheetWorld, SheetworkCorePlugin, SheetworkSet, StepTimes,
};
pub use debug::{SheetDebug, SheetGizmos, SheetworkDebugPlugin};
pub use diagnostics::SheetworkDiagnosticsPlugin;
#[cfg(feature = "inspector")]
pub use inspector::{SheetInspector, SheetInspectorPlugin};
#[cfg(feature = "link")]
pub use link::{SheetLink, SheetLinkPlugin};
pub use render::{SheetColour, SheetDisplay, SheetLayer, SheetRoom, SheetworkRenderPlugin};
pub use sheetwork;
#[cfg(feature = "link")]
pub use sheetwork_link;

/// Everything a game needs: core, assets, rendering, diagnostics. [`SheetworkDebugPlugin`] is apart.
pub struct SheetworkPlugins;

impl PluginGroup for SheetworkPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(SheetworkCorePlugin::default())
            .add(SheetworkAssetPlugin)
            .add(SheetworkRenderPlugin)
            .add(SheetworkDiagnosticsPlugin)
    }
}
