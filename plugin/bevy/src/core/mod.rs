//! The simulated world inside Bevy's: entities in, time integration, motion out.
//!
//! `sheet`, `body`, `heater`, `heat_gun`, `wind` hold the components that describe; `state` and
//! `motion` those that report; `world` and `clock` the resources; `polyhedra` the asset of body
//! shapes. `sync` adds entities to the world, `step` advances it.

mod attachments;
mod body;
mod clock;
mod contacts;
mod detail;
mod disabled;
mod event;
mod forces;
mod frame;
mod heat_gun;
pub(crate) mod heater;
mod joints;
mod links;
pub(crate) mod motion;
mod parents;
pub(crate) mod placement;
mod polyhedra;
mod query;
mod reflect;
mod sheet;
mod state;
mod step;
pub(crate) mod sync;
mod transforms;
mod wind;
mod world;
mod world_cell;

use bevy::prelude::*;
use bevy::transform::TransformSystems;

pub use attachments::SheetAttachments;
pub use body::{BodyShape, SheetBody};
pub use clock::SheetClock;
pub use contacts::{SheetContact, SheetContactPair, SheetContacts};
pub use detail::{SheetDetail, StepTimes};
pub use event::SheetEvent;
pub use forces::SheetForces;
pub use heat_gun::SheetHeatGun;
pub use heater::{HeaterHandle, SheetHeater};
pub use joints::{JointLink, SheetJoint};
pub use motion::{BodyMotion, SheetMotion};
pub use polyhedra::SheetPolyhedra;
pub use query::SheetRayCast;
pub use sheet::Sheet;
pub use state::SheetState;
pub use wind::SheetWind;
pub use world::{SheetCheckpoint, SheetWorld};

/// Stages of the simulation in `FixedUpdate`, in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SheetworkSet {
    /// New, changed and moved entities are passed to the world.
    Sync,
    /// The world is advanced in time.
    Step,
    /// Positions and states are written to the entities, and events are sent.
    Writeback,
}

/// Set in `PostUpdate`, before the display: entities spawned in this frame are in the world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SheetworkSynced;

/// Set in `PostUpdate`, before transform propagation: the displayed time advances.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SheetworkDisplay;

/// Set of the systems in [`SheetworkSet::Writeback`] that write to entities.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SheetworkWritten;

/// Thread on which the plugin steps the world. The bits of the world are equal in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SheetThreading {
    /// The step is a system of `FixedUpdate`, and its results are there in the same tick.
    #[default]
    Inline,
    /// A task on Bevy's `AsyncComputeTaskPool` takes the step while the frame goes on, and its
    /// results are there one tick later: the sets of [`SheetworkSet`] run in the order `Writeback`,
    /// `Sync`, `Step`. Any access to the [`SheetWorld`] waits for the end of the step, as do spawns
    /// and despawns of sheets and bodies; let systems that need it run before
    /// [`SheetworkSet::Step`]. The display of colours, and of surfaces kept clear of bodies that
    /// they touch, waits as well. Not for `borrow_bodies`.
    Background,
}

/// Plugin that adds [`Sheet`], [`SheetBody`], [`SheetHeater`] and [`SheetHeatGun`] entities to a
/// [`SheetWorld`] and steps it in `FixedUpdate`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkCorePlugin {
    /// Whether sheets meet the bodies of the caller's Rapier world instead of [`SheetBody`]
    /// entities. If so, the plugin does not step the world: a system of the caller in
    /// [`SheetworkSet::Step`] calls [`SheetWorld::advance_with`].
    pub borrow_bodies: bool,
    /// Thread on which the world is stepped.
    pub threading: SheetThreading,
}

impl SheetworkCorePlugin {
    /// Order the stages, and add the step.
    fn order_sets(&self, app: &mut App) {
        if self.threading == SheetThreading::Background && !self.borrow_bodies {
            let order = (SheetworkSet::Writeback, SheetworkSet::Sync, SheetworkSet::Step);
            app.configure_sets(FixedUpdate, order.chain());
            app.add_systems(FixedUpdate, step::begin.in_set(SheetworkSet::Step));
            app.add_systems(FixedUpdate, step::finish.in_set(SheetworkSet::Writeback).before(SheetworkWritten));
        } else {
            app.configure_sets(FixedUpdate, (SheetworkSet::Sync, SheetworkSet::Step, SheetworkSet::Writeback).chain());
            app.add_systems(FixedUpdate, step::advance.run_if(step::owns_bodies).in_set(SheetworkSet::Step));
        }
    }
}

impl Plugin for SheetworkCorePlugin {
    fn build(&self, app: &mut App) {
        if sheetwork::OPTIMISATION_LEVEL == "0" {
            warn!(
                "sheetwork was compiled without optimisation: a step takes about 80 times as long. Add \
                 [profile.dev.package.\"*\"] with opt-level = 3 to the Cargo.toml of your workspace"
            );
        }
        app.insert_resource(SheetWorld::new(self.borrow_bodies)).init_resource::<SheetClock>();
        app.add_message::<SheetEvent>().add_message::<SheetContact>();
        self.order_sets(app);
        add_observers(app);
        app.add_systems(First, clock::begin_frame.after(bevy::time::TimeSystems));
        app.add_systems(
            FixedUpdate,
            (
                // Bodies first: sheets may be attached to them.
                (
                    clock::begin_tick,
                    forces::request,
                    links::discard_stale,
                    sync::sync_bodies,
                    sync::sync_sheets,
                    parents::lead,
                    sync::move_sheets,
                    sync::move_bodies,
                    attachments::sync,
                    joints::sync,
                    heater::sync,
                    heat_gun::aim,
                    contacts::request,
                    wind::sync,
                    detail::follow.run_if(resource_exists::<SheetDetail>),
                )
                    .chain()
                    .in_set(SheetworkSet::Sync),
                (step::write_sheets, step::write_bodies, forces::write, event::send, contacts::send)
                    .chain()
                    .in_set(SheetworkSet::Writeback)
                    .in_set(SheetworkWritten),
            ),
        );
        // Once a frame as well, so that entities spawned in this frame are displayed in it.
        app.add_systems(
            PostUpdate,
            (links::discard_stale, sync::sync_bodies, sync::sync_sheets, heater::sync)
                .chain()
                .in_set(SheetworkSynced)
                .before(SheetworkDisplay)
                .before(TransformSystems::Propagate),
        );
        app.add_systems(
            PostUpdate,
            (step::show, step::show_bodies, transforms::show_sheets)
                .chain()
                .in_set(SheetworkDisplay)
                .before(TransformSystems::Propagate),
        );
        register_types(app);
    }
}

fn add_observers(app: &mut App) {
    app.add_observer(sync::sheet_removed).add_observer(sync::body_removed);
    app.add_observer(heater::removed).add_observer(heat_gun::removed).add_observer(contacts::removed);
    app.add_observer(attachments::removed).add_observer(joints::removed);
    app.add_observer(disabled::disabled).add_observer(disabled::enabled);
}

fn register_types(app: &mut App) {
    app.register_type::<Sheet>()
        .register_type::<SheetBody>()
        .register_type::<SheetHeater>()
        .register_type::<SheetHeatGun>()
        .register_type::<SheetWind>()
        .register_type::<SheetState>()
        .register_type::<SheetClock>()
        .register_type::<SheetDetail>();
}
