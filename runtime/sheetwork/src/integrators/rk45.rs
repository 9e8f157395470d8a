//! Adaptive Runge-Kutta method: the pair of orders 5 and 4 of Dormand and Prince (1980), with local
//! extrapolation.
//!
//! Seven stages, the last of which equals the first of the next step. The difference of the two
//! results estimates the error of a step h: err = max over nodes and coordinates of max(|e_x|, h
//! |e_v|), in metres. A step is accepted when err <= tolerance; the next step is h · 0.9
//! (tolerance/err)^(1/5), between a fifth and five times the last. One call takes one accepted step
//! of at most `dt`, so that contact is resolved after each. The thesis names this method as future
//! work.

use crate::integrators::settings::IntegratorSettings;
use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};

const SETTINGS: IntegratorSettings = IntegratorSettings::DEFAULT;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Rk45,
    name: "rk45",
    about: "Dormand-Prince 5(4), adaptive with error control",
    order: 5,
    // Stability limit of the order-5 formula at fixed steps; error control stays well below it.
    stability_limit: 0.997,
    evaluations: 7,
    adaptive: true,
    make: || Box::new(Rk45::default()),
    ..IntegratorInfo::EXPLICIT
};

const STAGES: usize = 7;
/// Times of the stages as fractions of the step.
const C: [f64; STAGES] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
/// Weights of the earlier derivatives in each stage; the last row is the order-5 result.
const A: [[f64; 6]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Order-5 weights minus order-4 weights: the error estimate.
const E: [f64; STAGES] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

struct Rk45 {
    tolerance: f64,
    /// Step that the last error suggests for the next call, s.
    next: Option<f64>,
    x_stage: Vectors,
    v_stage: Vectors,
    /// Derivatives of x and v at each stage.
    u: [Vectors; STAGES],
    a: [Vectors; STAGES],
}

impl Default for Rk45 {
    fn default() -> Self {
        Self {
            tolerance: 1e-7,
            next: None,
            x_stage: Vectors::default(),
            v_stage: Vectors::default(),
            u: Default::default(),
            a: Default::default(),
        }
    }
}

impl Rk45 {
    /// Evaluates the stages for a step of `h` s; stores the result in the stage arrays and returns
    /// the error, m.
    fn attempt(&mut self, forces: &mut dyn Forces, t: f64, h: f64, x: &Vectors, v: &Vectors) -> f64 {
        for s in 1..STAGES {
            self.x_stage.copy_from(x);
            self.v_stage.copy_from(v);
            for (j, weight) in A[s].iter().take(s).enumerate().filter(|(_, w)| **w != 0.0) {
                self.x_stage.add_scaled(h * weight, &self.u[j]);
                self.v_stage.add_scaled(h * weight, &self.a[j]);
            }
            self.u[s].copy_from(&self.v_stage);
            forces.accelerations(t + C[s] * h, &self.x_stage, &self.v_stage, &mut self.a[s]);
        }
        h * largest_error(&self.u).max(h * largest_error(&self.a))
    }
}

/// Largest component of Σ E_s k_s; infinite if any is not finite.
fn largest_error(slopes: &[Vectors; STAGES]) -> f64 {
    let mut largest = 0.0_f64;
    for axis in 0..3 {
        let k: [&[f64]; STAGES] = std::array::from_fn(|s| slopes[s].axes()[axis]);
        for i in 0..k[0].len() {
            let e: f64 = (0..STAGES).map(|s| E[s] * k[s][i]).sum();
            if !e.is_finite() {
                return f64::INFINITY;
            }
            largest = largest.max(e.abs());
        }
    }
    largest
}

impl Integrator for Rk45 {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.x_stage, x);
        resize_like(&mut self.v_stage, x);
        self.u.iter_mut().chain(&mut self.a).for_each(|k| resize_like(k, x));
        let mut done = AdvanceReport::default();
        self.u[0].copy_from(v);
        forces.accelerations(t, x, v, &mut self.a[0]);
        done.evaluations += 1;
        let smallest = SETTINGS.minimum_adaptive_step * dt;
        let mut h = self.next.map_or(dt, |next| next.min(dt)).max(smallest.min(dt));
        loop {
            let error = self.attempt(forces, t, h, x, v);
            done.evaluations += STAGES as u64 - 1;
            let factor = if error > 0.0 { 0.9 * (self.tolerance / error).powf(0.2) } else { 5.0 };
            let suggested = h * factor.clamp(0.2, 5.0);
            if error <= self.tolerance || h <= smallest {
                // A step shortened by the end of `dt` does not reduce the stored step.
                let cut = if h >= dt { self.next.unwrap_or(0.0) } else { 0.0 };
                self.next = Some(suggested.max(smallest).max(cut));
                break;
            }
            done.rejected += 1;
            h = suggested.max(smallest);
        }
        x.copy_from(&self.x_stage);
        v.copy_from(&self.v_stage);
        done.accepted = 1;
        done.elapsed = h;
        done
    }

    fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }

    fn serialise(&self, to: &mut StateWriter) {
        self.next.serialise(to);
    }

    fn deserialise(&mut self, from: &mut StateReader, _masses: usize) -> ReadResult {
        self.next.deserialise(from)
    }

    fn restart(&mut self) {
        self.next = None;
    }
}
