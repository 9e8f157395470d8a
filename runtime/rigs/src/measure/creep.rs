//! Creep of a strip clamped at one end under its own weight.
//!
//! By the correspondence principle a small deflection under a constant load is the elastic one
//! times E J(t), for any shape:
//!
//!   w(t)/w(0) = 1 + t/τ₁ + r (1 - e^(-t/τ₂)),
//!
//! with times shifted by temperature. Gravity is chosen for an initial deflection of at most 1e-4
//! of the length and a final one of at most a tenth of the thickness, so that deflection is
//! proportional to load. The strip is in equilibrium throughout; with `--dynamic` it is stepped in
//! time, and inertia contributes.

use serde_json::json;

use crate::measure::{FreeEdge, RigResult, Runner, Setup};
use sheetwork::elements::creep::TimeShift;
use sheetwork::scene::{Material, MaterialChoice, Region};
use sheetwork::sheet::temperature::Softening;
use sheetwork::{InputError, World};

/// Initial deflection, as a fraction of the length.
const SAG: f64 = 1e-4;
/// Number of creep steps when no step is given.
const STEPS: f64 = 200.0;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let material = &setup.material;
    let Some(burgers) = material.burgers else {
        return Err(InputError::new("relaxation-time", "is not known of this material, which does not creep"));
    };
    let seconds = setup.thermal.seconds.unwrap_or(10.0);
    let celsius = setup.thermal.celsius.unwrap_or(material.glass_transition.map_or(20.0, |glass| glass + 40.0));
    let shift = TimeShift { glass_transition: material.glass_transition, wlf: material.wlf }.at(celsius);
    let (flow, delay) = (burgers.relaxation_time * shift, burgers.retardation_time * shift);
    let compliance = |t: f64| 1.0 + t / flow - burgers.retarded * (-t / delay).exp_m1();
    // Initial deflection w = ρ t g L⁴/(8 D).
    let stiffness = material.plate_stiffness() * Softening::of(material).fraction(celsius);
    let most = 0.1 * material.thickness / setup.length / compliance(seconds);
    let gravity = SAG.min(most) * 8.0 * stiffness / (material.areal_mass() * setup.length.powi(3));
    let mut scene = Setup { gravity: gravity.min(1e3), ..setup.clone() }.scene();
    setup.clamp(&mut scene, Region::Left);
    scene.sheets[0].creep = true;
    // Without expansion, because a sheet that expands against its clamp bulges.
    let material = Material { expansion: 0.0, ..material.clone() };
    scene.sheets[0].material = MaterialChoice::Inline(material);
    scene.sheets[0].temperature = Some(celsius);
    let mut runner = Runner::new(setup.world(&scene)?);
    runner.bring_to_rest(&Setup { dynamic: false, ..setup.clone() });
    let root = scene.sheets[0].placement.position.y;
    let first = sag(&runner.world, root);
    let (elapsed, worst) = creep((setup, seconds), &mut runner, root, compliance);
    let last = sag(&runner.world, root);
    let keys = json!({
        "temperature_c": celsius,
        "shift": shift,
        "relaxation_time_s": flow,
        "retardation_time_s": delay,
        "retarded": burgers.retarded,
        "elapsed_s": elapsed,
        "gravity_m_s2": scene.gravity.y.abs(),
        "elastic_deflection_m": first,
        "deflection_m": last,
        "expected_deflection_m": first * compliance(elapsed),
        "compliance": last / first,
        "expected_compliance": compliance(elapsed),
        "compliance_error": last / first / compliance(elapsed) - 1.0,
        "largest_error": worst,
    });
    Ok(runner.outcome(keys))
}

/// Sag of the free edge below the height `root` (m) of the clamp, m.
fn sag(world: &World, root: f64) -> f64 {
    let sheet = &world.sheets()[0];
    root - FreeEdge::new(sheet, &sheet.state.x).middle.y
}

/// Let the strip creep for `seconds`. Returns the elapsed time (s) and the largest
/// relative error of the sag against `compliance`.
fn creep(
    (setup, seconds): (&Setup, f64),
    runner: &mut Runner,
    root: f64,
    compliance: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let first = sag(&runner.world, root);
    let (mut elapsed, mut worst) = (0.0, 0.0_f64);
    let mut compare = |world: &World, by: f64| {
        elapsed += by;
        worst = worst.max((sag(world, root) / first / compliance(elapsed) - 1.0).abs());
    };
    if setup.dynamic {
        let dt = runner.world.dt();
        runner.run(seconds, |world| {
            compare(world, dt);
            true
        });
    } else {
        let steps = (seconds / setup.dt.unwrap_or(seconds / STEPS)).round().max(1.0);
        for _ in 0..steps as u64 {
            runner.world.creep_in_equilibrium(seconds / steps, 1e-12 * setup.length);
            compare(&runner.world, seconds / steps);
        }
    }
    (elapsed, worst)
}
