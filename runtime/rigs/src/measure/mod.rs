//! Virtual test rigs: a sheet in a situation with a known answer, and the measured result.
//!
//! Each rig is one file with one row in [`TABLE`]. `sheetwork measure CASE` runs one; the test
//! suite checks the numbers. CPU time covers the steps and not the set-up.

pub(crate) mod bounce;
pub(crate) mod buckling;
pub(crate) mod cantilever;
pub(crate) mod capstan;
pub(crate) mod cards;
pub(crate) mod conduction;
pub(crate) mod contact_observer;
pub(crate) mod cooling;
pub(crate) mod creep;
pub(crate) mod crossing_detector;
pub(crate) mod detail;
pub(crate) mod disc;
pub(crate) mod drop_box;
pub mod drops;
pub(crate) mod edge;
pub(crate) mod edge_landing;
pub(crate) mod energy;
pub(crate) mod fold;
pub(crate) mod free_fall;
pub(crate) mod frequency;
pub(crate) mod ground;
pub(crate) mod harmonic;
pub(crate) mod hole;
pub mod hot_wedge;
pub(crate) mod impact;
pub(crate) mod incline;
pub mod kicks;
pub mod oscillator;
pub(crate) mod pedestal;
pub(crate) mod pull;
pub(crate) mod radiate;
pub(crate) mod random_sequence;
pub(crate) mod release;
pub(crate) mod runner;
pub(crate) mod setup;
pub(crate) mod slide;
pub(crate) mod softening;
pub(crate) mod spin;
pub mod stability_limit;
pub(crate) mod stack;
pub(crate) mod stiffness;
pub(crate) mod supports;
pub(crate) mod thermal;
pub(crate) mod view_factor;
pub(crate) mod weight;

use cpu_time::ProcessTime;
use glam::DVec3;
use serde_json::{Map, Value, json};

pub(crate) use crate::measure::edge::FreeEdge;
pub use crate::measure::random_sequence::SplitMix64;
pub(crate) use crate::measure::runner::Runner;
pub use crate::measure::setup::{Boundary, ElasticFlags, InelasticFlags, Setup};
pub use crate::measure::thermal::Thermal;
use sheetwork::InputError;
use sheetwork::scene::{BodySpec, Placement, Shape};

/// A rig: its name, its description and the function that runs it.
pub struct RigCase {
    /// Name on the command line.
    pub name: &'static str,
    /// Description in one line.
    pub about: &'static str,
    /// Whether the sheet touches bodies. Lattices with explicit integrators then use springs by
    /// length.
    pub contact: bool,
    pub(crate) run: fn(&Setup) -> RigResult,
}

/// Result of a run of a rig.
pub(crate) type RigResult = Result<RigOutcome, InputError>;

const fn rig(name: &'static str, about: &'static str, run: fn(&Setup) -> RigResult) -> RigCase {
    RigCase { name, about, contact: false, run }
}

/// Rig whose sheet touches bodies.
const fn contact_rig(name: &'static str, about: &'static str, run: fn(&Setup) -> RigResult) -> RigCase {
    RigCase { contact: true, ..rig(name, about, run) }
}

/// All rigs, in the order of listing.
pub const TABLE: &[RigCase] = &[
    contact_rig("bounce", "rebound heights of a flat drop: --height M --restitution E", bounce::run),
    rig("buckling", "weight at which a strip on its edge, clamped at one end, falls sideways", buckling::run),
    rig(
        "cantilever",
        "droop of a sheet clamped along one edge, under its own weight: --dynamic to step to rest",
        cantilever::run,
    ),
    contact_rig("capstan", "tensions of a strip that slips over a cylinder: --friction MU", capstan::run),
    contact_rig(
        "card-house",
        "a house of cards that stands for 10 s, and then a ball: [--threads N] [--throw TIMES]",
        cards::house,
    ),
    contact_rig("card-pack", "52 cards dropped as a pack: [--threads N]", cards::pack),
    rig(
        "conduction",
        "temperature along an insulated sheet after a step of temperature at one edge: --fo",
        conduction::run,
    ),
    rig(
        "cooling",
        "time from one temperature to another in the open: --from, --to, --ambient, --convection",
        cooling::run,
    ),
    rig(
        "creep",
        "creep of a strip under a constant weight against the compliance of Burgers' model: --celsius C --seconds S",
        creep::run,
    ),
    contact_rig(
        "detail",
        "how far the drawn surface jumps when a sheet changes to another grid, at rest and in motion",
        detail::run,
    ),
    rig(
        "disc",
        "slowest vibrations of a round sheet: --radius M --boundary clamped|supported|free --modes K",
        disc::run,
    ),
    contact_rig("drop-box", "a flat drop on a box, to rest: --height M --box M --friction MU", drop_box::run),
    contact_rig(
        "edge-landing",
        "a landing on an edge: --angle DEG --height M [--corner] [--edge-of-body] [--refine N]",
        edge_landing::run,
    ),
    rig(
        "energy",
        "largest rise of the energy of an undamped sheet in ten seconds after its release from flat",
        energy::run,
    ),
    rig(
        "fold",
        "angle that remains of a card folded by --angle DEG and released, and that of return mapping: --yield-stress --hardening",
        fold::run,
    ),
    rig("free-fall", "error of a second's free fall against ½ g t²", free_fall::run),
    rig("frequency", "slowest vibrations: --boundary cantilever|clamped|supported|free --modes K", frequency::run),
    rig(
        "hole",
        "a square with a round hole: --side M --hole M (its diameter) --boundary supported|clamped --modes K",
        hole::run,
    ),
    contact_rig("impact", "a ball or sheet hits a free sheet: --speed M_S [--on-sheet]", impact::run),
    contact_rig("incline", "stick or slide on an incline: --angle DEG --friction MU", incline::run),
    rig("oscillator", "order and stability limit of an engine: --engine NAME", oscillator::run),
    rig("pedestal", "droop of a square clamped on its central patch: --side M --patch M", pedestal::run),
    contact_rig("pull", "drag of a sheet under a box over a floor: --speed M_S --friction MU", pull::run),
    rig(
        "radiate",
        "temperature after a time before a black heater: --heater, --view, --seconds, --ambient, --from",
        radiate::run,
    ),
    rig("release", "first swing of a sheet clamped along one edge and released from flat, undamped", release::run),
    contact_rig("slide", "stopping distance on a floor: --speed M_S --friction MU", slide::run),
    rig(
        "softening",
        "modulus at a temperature, and the droop of a clamped sheet then: --material, --celsius",
        softening::run,
    ),
    rig("spin", "momentum and energy kept by a second's spin: --rate RAD_S", spin::run),
    contact_rig("stack", "sheets dropped in a pile on a floor: --sheets N", stack::run),
    rig(
        "stiffness",
        "bending in every direction, twist, membrane and Poisson's ratio over those asked for",
        stiffness::run,
    ),
    rig("supports", "sag of a square on two opposite edge lines, free to turn and slide in: --side M", supports::run),
    rig(
        "view-factor",
        "share of a patch's view that a polygon takes up: --polygon, --point, --normal",
        view_factor::run,
    ),
    contact_rig(
        "weight",
        "what carries a sheet on the floor, and a box on a sheet held at two edges: --box M",
        weight::run,
    ),
];

/// A static half space below the plane of `placement`, with the scene's contact coefficients.
pub(crate) fn plane(name: &str, placement: Placement) -> BodySpec {
    BodySpec { name: name.into(), placement, ..BodySpec::new(Shape::HalfSpace) }
}

/// A body of this shape at `position` (m), with the scene's contact coefficients.
pub(crate) fn body(name: &str, shape: Shape, position: DVec3) -> BodySpec {
    let placement = Placement { position, ..Placement::default() };
    BodySpec { name: name.into(), placement, ..BodySpec::new(shape) }
}

/// Halves an interval `count` times. `is_low` holds at its lower end and not at its upper end.
pub(crate) fn bisect((mut low, mut high): (f64, f64), count: u32, is_low: impl Fn(f64) -> bool) -> (f64, f64) {
    for _ in 0..count {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    (low, high)
}

/// Keys of a JSON object; none of another value.
pub(crate) fn object(value: Value) -> Map<String, Value> {
    if let Value::Object(map) = value { map } else { Map::new() }
}

/// Result of a rig.
#[derive(Default)]
pub struct RigOutcome {
    /// JSON keys specific to the rig.
    pub(crate) keys: Map<String, Value>,
    /// Step of the integrator, s.
    pub(crate) dt: f64,
    /// Steps taken.
    pub(crate) steps: u64,
    /// Simulated time, s.
    pub(crate) simulated: f64,
    /// CPU time of the stepping, s.
    pub(crate) cpu: f64,
    /// CPU time of the step that took longest, s.
    pub(crate) worst: f64,
    /// Whether the sheet was at rest at the end; `None` for a rig that does not wait for rest.
    pub(crate) settled: Option<bool>,
    /// Whether the equilibrium is stable; `None` for a rig without an equilibrium solution.
    pub(crate) stable: Option<bool>,
    /// "ok" or "unstable ...".
    pub(crate) status: String,
}

/// Runs the rig of that name and returns its JSON object.
///
/// # Errors
/// An unknown name, or a value of `setup` out of range.
pub fn measure(case: &str, setup: &Setup) -> Result<Value, InputError> {
    let row = TABLE.iter().find(|c| c.name == case).ok_or_else(|| {
        let names: Vec<&str> = TABLE.iter().map(|c| c.name).collect();
        InputError::unknown_name("case", "case", case, &names)
    })?;
    if row.name != "fold" {
        sheetwork::check_range("angle", setup.angle, 0.0, 89.0, "degrees")?;
    }
    setup.check()?;
    let start = ProcessTime::now();
    let found = (row.run)(setup)?;
    let set_up = (start.elapsed().as_secs_f64() - found.cpu).max(0.0);
    let ((nx, nz), width) = setup.as_built();
    let per_second = if found.simulated > 0.0 { 1e3 * found.cpu / found.simulated } else { 0.0 };
    let mut all = object(json!({
        "case": case,
        "structure": setup.structure.name(),
        "grid": format!("{nx}x{nz}"),
        "layers": setup.layer_count(),
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
    }));
    all.extend(found.keys);
    Ok(Value::Object(all))
}
