//! An integrator on x'' = -ω²x: its order of convergence, its stability limit and its energy
//! behaviour.
//!
//! Every scheme is linear here, so a step is a 2x2 matrix on (x, v/ω), found from the images of the
//! two unit vectors. Its spectral radius decides stability; the order is the slope of the error
//! under halving of the step. Adaptive integrators get a tolerance that accepts every step.
//! Implicit integrators have more state than (x, v); their radius is the mean growth factor per
//! step over many steps.

use serde_json::json;

use crate::measure::harmonic::Harmonic;
use crate::measure::thermal::outcome;
use crate::measure::{RigResult, Setup, bisect};
use sheetwork::integrators::Forces;
use sheetwork::math::Vectors;
use sheetwork::scene::IntegratorKind;

/// Spectral radius minus 1 above which a motion grows, beyond rounding.
const GROWTH_TOLERANCE: f64 = 1e-12;

/// Steps before an implicit integrator is independent of its start-up, and steps of the
/// measurement.
const STEPS: (u32, u32) = (50, 200);

/// Steps (rad) beyond which a scheme that is stable there is stable at any step.
const LONG_STEPS: [f64; 3] = [30.0, 1e3, 1e5];

/// One step of `a` (hω with ω = 1) with these forces as a matrix on (x, v): columns are the
/// images of (1, 0) and (0, 1).
pub(crate) fn step_matrix(engine: IntegratorKind, forces: &mut dyn Forces, a: f64) -> [[f64; 2]; 2] {
    let mut columns = [[0.0; 2]; 2];
    for (column, start) in columns.iter_mut().zip([(1.0, 0.0), (0.0, 1.0)]) {
        let mut engine = engine.construct();
        engine.set_tolerance(f64::MAX);
        let (mut x, mut v) = (Vectors::zeros(1), Vectors::zeros(1));
        (x.x[0], v.x[0]) = start;
        engine.advance(forces, 0.0, a, &mut x, &mut v);
        *column = [x.x[0], v.x[0]];
    }
    columns
}

/// Largest growth factor per step of a = hω in the long run.
pub fn spectral_radius(engine: IntegratorKind, a: f64) -> f64 {
    if engine.info().implicit {
        return shrinking(engine, a);
    }
    radius_of(step_matrix(engine, &mut Harmonic, a))
}

/// Spectral radius of a step.
pub(crate) fn radius_of([[xx, vx], [xv, vv]]: [[f64; 2]; 2]) -> f64 {
    let (half_trace, determinant) = (0.5 * (xx + vv), xx * vv - xv * vx);
    let discriminant = half_trace * half_trace - determinant;
    if discriminant <= 0.0 { determinant.abs().sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

/// Growth factor per step over [`STEPS`]; 0 for a motion that vanishes.
fn shrinking(engine: IntegratorKind, a: f64) -> f64 {
    let mut engine = engine.construct();
    let (mut x, mut v) = (Vectors::zeros(1), Vectors::zeros(1));
    x.x[0] = 1.0;
    let mut size = |steps: u32| {
        for step in 0..steps {
            engine.advance(&mut Harmonic, f64::from(step) * a, a, &mut x, &mut v);
        }
        x.x[0].hypot(v.x[0])
    };
    let before = size(STEPS.0);
    if before < f64::MIN_POSITIVE { 0.0 } else { (size(STEPS.1) / before).powf(1.0 / f64::from(STEPS.1)) }
}

/// Largest a = hω up to which no step makes the motion grow; 0 when small steps do, infinite when
/// none does.
pub fn stability_limit(engine: IntegratorKind) -> f64 {
    let stable = |a: f64| spectral_radius(engine, a) <= 1.0 + GROWTH_TOLERANCE;
    let step = 0.01;
    let mut low = 0.0;
    while low < 10.0 && stable(low + step) {
        low += step;
    }
    if low == 0.0 {
        return 0.0;
    }
    if low >= 10.0 && LONG_STEPS.into_iter().all(stable) {
        return f64::INFINITY;
    }
    bisect((low, low + step), 40, stable).0
}

/// Slope of log error against log step in the (x, v) plane at t = 5, between 200 and 400 steps. At
/// whole half periods the first-order error of Euler-Cromer would vanish.
pub fn order(engine: IntegratorKind) -> f64 {
    (error(engine, 200) / error(engine, 400)).log2()
}

/// Distance from the exact position in the (x, v) plane at t = 5, from (cos 1, -sin 1) at t = 0.
fn error(engine: IntegratorKind, steps: u32) -> f64 {
    let mut engine = engine.construct();
    engine.set_tolerance(f64::MAX);
    let (mut x, mut v) = (Vectors::zeros(1), Vectors::zeros(1));
    let exact = |t: f64| ((1.0 + t).cos(), -(1.0 + t).sin());
    (x.x[0], v.x[0]) = exact(0.0);
    let h = 5.0 / f64::from(steps);
    for step in 0..steps {
        engine.advance(&mut Harmonic, f64::from(step) * h, h, &mut x, &mut v);
    }
    let (x1, v1) = exact(5.0);
    (x.x[0] - x1).hypot(v.x[0] - v1)
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let engine = setup.engine;
    let energy = |a: f64| spectral_radius(engine, a).powi(2) - 1.0;
    let keys = json!({
        "order": order(engine),
        "stability_limit": stability_limit(engine),
        "energy_growth_per_step_at_0.1": energy(0.1),
        "energy_growth_per_step_at_0.5": energy(0.5),
    });
    Ok(outcome(0.0, (0, 0.0, 0.0), keys))
}
