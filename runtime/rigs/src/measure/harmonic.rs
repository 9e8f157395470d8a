//! Harmonic oscillator x'' = -x (ω = 1) in the interface of a sheet: one node of 1 kg on a spring
//! of 1 N/m, along x.
//!
//! A stage of an implicit scheme is M (x - y)/h² + x = 0, with tangent 1/h² + 1. It is linear, so
//! one solve is exact.

use sheetwork::elements::{Anchor, Geometric};
use sheetwork::integrators::Forces;
use sheetwork::integrators::implicit::{ImplicitProblem, StageProblem};
use sheetwork::linear::NotPositiveDefinite;
use sheetwork::math::Vectors;

/// One node on a spring.
pub(crate) struct Harmonic;

impl Forces for Harmonic {
    fn accelerations(&mut self, _t: f64, x: &Vectors, _v: &Vectors, a: &mut Vectors) {
        a.clear();
        a.add_scaled(-1.0, x);
    }

    fn implicit(&mut self) -> Option<&mut dyn ImplicitProblem> {
        Some(self)
    }
}

impl ImplicitProblem for Harmonic {
    fn begin_stage(&mut self, _per_time: f64, _anchors: &[Anchor], _follow: f64, _x: &Vectors, _v: &Vectors) {}

    fn finish_stage(&mut self, _x: &Vectors) {}

    fn reset_rates(&mut self) {}

    fn potential(&mut self, stage: &StageProblem, x: &Vectors) -> f64 {
        self.inertial_potential(stage, x) + 0.5 * x.get(0).length_squared()
    }

    fn inertial_potential(&self, stage: &StageProblem, x: &Vectors) -> f64 {
        0.5 * stage.per_time * stage.per_time * x.get(0).distance_squared(stage.y.get(0))
    }

    fn kinetic_energy_at(&self, speed: f64) -> f64 {
        0.5 * speed * speed
    }

    fn newton_direction(
        &mut self,
        stage: &StageProblem,
        x: &Vectors,
        _: Geometric,
        d: &mut Vectors,
    ) -> Result<f64, NotPositiveDefinite> {
        let inertia = stage.per_time * stage.per_time;
        let gradient = (x.get(0) - stage.y.get(0)) * inertia + x.get(0);
        let step = -gradient / (inertia + 1.0);
        d.set(0, step);
        Ok(step.dot(gradient))
    }

    fn predict_stress(&mut self, _x: &Vectors, _d: &Vectors) -> f64 {
        0.0
    }

    fn update_stress(&mut self, _x: &Vectors) {}

    fn zero_prescribed(&self, _a: &mut Vectors) {}

    fn copy_prescribed(&self, _x: &Vectors, _to: &mut Vectors) {}

    fn accelerations(&mut self, x: &Vectors, v: &Vectors, a: &mut Vectors) -> f64 {
        Forces::accelerations(self, 0.0, x, v, a);
        x.get(0).length()
    }
}
