//! Virtual test rigs: a sheet in a situation with a known answer, and what it did.
//!
//! Each case is one file with one row in [`TABLE`]. `sheetwork measure CASE` runs them; tests hold their numbers. CPU time is
//! that of the stepping alone, set-up apart.

pub(crate) mod bodies;
mod bounce;
mod buckling;
mod cantilever;
mod cards;
mod conduction;
mod cooling;
mod creep;
mod detail;
mod disc;
mod draw;
mod drop_box;
pub mod drops;
mod edge;
mod edge_landing;
mod energy;
mod fold;
mod free_fall;
mod frequency;
mod ground;
mod harmonic;
mod hole;
mod impact;
mod incline;
pub mod kicks;
pub mod limit;
pub mod oscillator;
pub mod overlap;
mod paths;
mod pedestal;
mod radiate;
pub mod reference;
mod release;
mod runner;
mod setup;
mod slide;
mod softening;
mod spin;
mod stack;
mod stiffness;
mod supports;
mod thermal;
mod view_factor;
mod watch;
mod weight;

use cpu_time::ProcessTime;
use glam::DVec3;
use serde_json::{Map, Value, json};

pub(crate) use self::edge::Edge;
pub(crate) use self::runner::Runner;
pub use self::setup::{Boundary, Setup};
pub use self::thermal::Thermal;
use crate::error::InputError;
use crate::scene::{BodySpec, Placement, Shape};

/// A case: what is measured, and how.
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// One line on what it does.
    pub about: &'static str,
    /// Whether the sheet meets bodies in it: lattices with explicit engines then have springs by their lengths.
    pub contact: bool,
    pub(crate) run: fn(&Setup) -> Result<Outcome, InputError>,
}

/// Every case, in the order they are listed.
pub const TABLE: &[Case] = &[
    bounce::CASE,
    buckling::CASE,
    cantilever::CASE,
    cards::HOUSE,
    cards::PACK,
    conduction::CASE,
    cooling::CASE,
    creep::CASE,
    detail::CASE,
    disc::CASE,
    drop_box::CASE,
    edge_landing::CASE,
    energy::CASE,
    fold::CASE,
    free_fall::CASE,
    frequency::CASE,
    hole::CASE,
    impact::CASE,
    incline::CASE,
    oscillator::CASE,
    pedestal::CASE,
    radiate::CASE,
    release::CASE,
    slide::CASE,
    softening::CASE,
    spin::CASE,
    stack::CASE,
    stiffness::CASE,
    supports::CASE,
    view_factor::CASE,
    weight::CASE,
];

/// A body with nothing of its own but its place: everything below its plane, with the scene's contact coefficients.
pub(crate) fn plane(name: &str, placement: Placement) -> BodySpec {
    BodySpec { name: name.into(), placement, ..BodySpec::new(Shape::HalfSpace) }
}

/// A body of this shape at `position` (m), with the scene's contact coefficients.
pub(crate) fn body(name: &str, shape: Shape, position: DVec3) -> BodySpec {
    let placement = Placement { position, ..Placement::default() };
    BodySpec { name: name.into(), placement, ..BodySpec::new(shape) }
}

/// What a case found.
pub struct Outcome {
    /// Keys of the case's own.
    pub(crate) keys: Map<String, Value>,
    /// Step of the engine, s.
    pub(crate) dt: f64,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Simulated time, s.
    pub(crate) simulated: f64,
    /// CPU time of the stepping, s.
    pub(crate) cpu: f64,
    /// CPU time of the step that took longest, s.
    pub(crate) worst: f64,
    /// Whether the sheet was at rest at the end; `None` where the case does not wait for it.
    pub(crate) settled: Option<bool>,
    /// Whether the equilibrium found is one the sheet stays in by itself; `None` where none was looked for.
    pub(crate) stable: Option<bool>,
    /// "ok" or "unstable ...".
    pub(crate) status: String,
}

/// Runs the case of that name and returns its JSON object.
///
/// # Errors
/// When there is no such case, or a value of `setup` is out of range.
pub fn measure(case: &str, setup: &Setup) -> Result<Value, InputError> {
    let row = TABLE.iter().find(|c| c.name == case).ok_or_else(|| {
        let names: Vec<&str> = TABLE.iter().map(|c| c.name).collect();
        InputError::new("case", format!("no case is named \"{case}\"; there are {}", names.join(", ")))
    })?;
    if row.name != fold::CASE.name {
        crate::error::check_range("angle", setup.angle, 0.0, 89.0, "degrees")?;
    }
    setup.check()?;
    let start = ProcessTime::now();
    let found = (row.run)(setup)?;
    let set_up = (start.elapsed().as_secs_f64() - found.cpu).max(0.0);
    let ((nx, nz), width) = setup.as_built();
    let per_second = if found.simulated > 0.0 { 1e3 * found.cpu / found.simulated } else { 0.0 };
    let mut all = json!({
        "case": case,
        "structure": setup.structure.name(),
        "grid": format!("{nx}x{nz}"),
        "layers": setup.layers,
        "length_m": setup.length,
        "width_m": width,
        "engine": setup.engine.name(),
        "dt_s": found.dt,
        "steps": found.steps,
        "simulated_s": found.simulated,
        "cpu_s": found.cpu,
        "cpu_ms_per_simulated_s": per_second,
        "cpu_ms_per_step": 1e3 * found.cpu / found.steps.max(1) as f64,
        "worst_step_ms": 1e3 * found.worst,
        "setup_cpu_s": set_up,
        "settled": found.settled,
        "stable": found.stable,
        "status": found.status,
    });
    if let Value::Object(map) = &mut all {
        map.extend(found.keys);
    }
    Ok(all)
}
