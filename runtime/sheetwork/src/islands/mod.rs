//! Islands: sets of sheets and dynamic bodies that may touch in a step, and the step of each.
//!
//!   `island_manager`  builds the islands, steps them in parallel, keeps their state
//!   `island_builder`  swept boxes, `broad_phase` (sweep and prune), `union_find`
//!   `island_step`     one island: forks by integrator; the end of the step that both share
//!   `explicit`        sheets one by one, then contact of the island at the end of the step
//!   `implicit_step`   stages with contact inside; a substep is accepted, bisected or replaced
//!   `fallback`        the replacements; `rigid_motion` and `energy_budget` serve them
//!   `instability`     recovery policies of sheets of explicit integrators
//!   `resting`, `unstable`  sleep, and the end of a sheet that is out of bounds
//!   `event`, `contact_log`, `step_report`  records of a step
//!
//! Islands share no state that changes, so any number of threads gives the same result. Features
//! that a scene does not use cost no call. The first step sizes the working arrays; later steps
//! allocate nothing here.

pub(crate) mod broad_phase;
pub(crate) mod contact_log;
pub(crate) mod energy_budget;
pub mod event;
pub(crate) mod explicit;
pub(crate) mod fallback;
pub(crate) mod force_record;
pub(crate) mod implicit_step;
pub(crate) mod instability;
pub(crate) mod island_builder;
pub(crate) mod island_detection;
pub(crate) mod island_manager;
pub(crate) mod island_progress;
pub(crate) mod island_step;
pub(crate) mod overlap_test;
pub(crate) mod resting;
pub(crate) mod rigid_motion;
pub(crate) mod settings;
pub mod step_report;
pub(crate) mod union_find;
pub(crate) mod unstable;

use crate::profiler::Profiler;
use crate::rigid::RigidView;
use crate::rigid::lent::LentBodies;

pub use crate::sheet::Field;

/// Inputs of a step that all sheets share.
#[derive(Clone, Copy)]
pub(crate) struct StepContext<'a> {
    pub field: Field,
    /// Time at the start, s.
    pub time: f64,
    /// Length, s.
    pub dt: f64,
    /// Rigid bodies; `None` in a world without.
    pub view: Option<&'a RigidView<'a>>,
    /// Bodies of the caller that sheets move.
    pub lent: &'a LentBodies,
    /// Whether resting sheets may sleep.
    pub sleep: bool,
    /// Whether contact between sheets is enabled.
    pub sheets_meet: bool,
    /// Work budget of the step for each node of an island, in node-iterations; `None` for the
    /// default.
    pub work_per_node: Option<f64>,
    pub profiler: &'a Profiler,
}
