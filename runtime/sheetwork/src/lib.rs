//! Simulation of thin, stiff sheets in real time, without graphics, window or ECS.
//!
//! ```
//! use sheetwork::prelude::*;
//!
//! let sheet = SheetSpec::new("card").at(0.0, 0.3, 0.0).clamp(Region::Left);
//! let mut world = World::new(&Scene::new().with_sheet(sheet))?;
//! world.advance(1.0);
//! assert!(world.sheets()[0].centre_of_mass().y < 0.3);
//! # Ok::<(), sheetwork::InputError>(())
//! ```
//!
//! A [`Scene`](scene::Scene) is built in code or read from a file
//! ([`Scene::load`](scene::Scene::load)); a [`World`] steps it.
//!
//! | what | where |
//! |---|---|
//! | specifications of sheets, bodies, heat, contact; scene files | [`scene`] |
//! | world: step, parameters by path, events, snapshots, reports | [`World`] |
//! | state of a sheet: positions, energies, temperatures, probes | [`Sheet`] |
//! | rays, closest points, overlaps, curvature, area of sheets | [`World::queries`] |
//! | journals of a run, recordings of what was seen | [`journal`], [`recording`] |
//! | numbers with units, as people type them | [`units`] |
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `parallel` | yes | steps islands and assembles large systems on rayon's thread pool |
//!
//! A debug build of a dependent steps about 80 times slower than a release build, unless its
//! `Cargo.toml` has `[profile.dev.package."*"] opt-level = 3`. [`World::set_threads`] sets the
//! number of threads, 1 by default; results do not depend on it.
//!
//! Units are SI (temperatures in °C), numbers `f64`; equal input gives equal bits on any
//! number of threads. The hidden modules are internals that the test rigs use; they are not part of
//! the public interface.

#[doc(hidden)]
pub mod collision;
#[doc(hidden)]
pub mod contact;
#[doc(hidden)]
pub mod elements;
pub(crate) mod error;
#[doc(hidden)]
pub mod integrators;
#[doc(hidden)]
pub mod islands;
#[doc(hidden)]
pub mod linear;
#[doc(hidden)]
pub mod material;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod mesh;
pub(crate) mod parallel;
pub mod prelude;
#[doc(hidden)]
pub mod profiler;
#[doc(hidden)]
pub mod rigid;
pub mod scene;
pub(crate) mod serialize;
#[doc(hidden)]
pub mod sheet;
#[doc(hidden)]
pub mod thermal;
pub mod units;
#[doc(hidden)]
pub mod world;

/// Optimisation level that this library was compiled with: "0" to "3", "s" or "z". At "0" a step
/// takes about 80 times as long as at "3".
pub const OPTIMISATION_LEVEL: &str = env!("SHEETWORK_OPT_LEVEL");

pub use glam;
pub use rapier3d;

pub use crate::error::{BuildError, InputError, ParameterError, SceneError, SnapshotError, check_range};
pub use crate::islands::event::{Event, EventKind};
pub use crate::islands::step_report::{StepOutcome, StepReport};
pub use crate::math::Vectors;
pub use crate::mesh::structure::StructureKind;
pub use crate::profiler::{Phase, StepObserver};
pub use crate::rigid::{BodyState, RigidView};
pub use crate::sheet::{Energy, Equilibrium, ForceKind, ForcePartner, Sheet, Status};
pub use crate::units::parameters::{ParameterId, ParameterKind, ParameterRow, ParameterScope, UsualRange};
pub use crate::world::{
    BodyId, BodyReport, Checkpoint, ContactEvent, ContactEventKind, ContactPair, ContactPartner, ForceEntry,
    ForceReport, ForceTarget, HeaterId, InterpolatedNodes, JointId, OpeningReport, Parameter, QueryFilter, QueryLayer,
    QueryShape, Report, SheetId, SheetQueries, SheetReport, Snapshot, SurfaceArea, SurfaceCurvature, SurfaceOverlaps,
    SurfacePoint, TemperatureReport, UnresolvedFolds, World, journal, recording,
};
