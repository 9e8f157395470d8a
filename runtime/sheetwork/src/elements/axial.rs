//! Axial law of a spring within an implicit stage: elastic force, dashpot and mixed axial force.
//!
//! For length L, rest length s, stiffness k, dashpot c, reference length L_w and a stage with 1/h:
//!
//! - axial force N = k (L - s) + (c/h)(L - L_w);
//! - potential ½ k (L - s)² + ½ (c/h)(L - L_w)²;
//! - tangent (k + c/h) n nᵀ + (N*/L)(I - n nᵀ), with the unit direction n and the axial force N*
//!   that the last linear solution predicted.

use glam::DVec3;

use crate::elements::Geometric;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};

/// Law and state of one spring.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Axial {
    /// Stiffness k, N/m.
    pub stiffness: f64,
    /// Rest length s, m.
    pub rest: f64,
    /// Dashpot c, N s/m.
    pub dashpot: f64,
    /// Predicted axial force N*, N.
    pub force: f64,
    /// Reference length L_w, m.
    pub anchor: f64,
    /// Rate of length at the end of the last stage, m/s.
    pub rate: f64,
}

impl State for Axial {
    fn serialise(&self, to: &mut StateWriter) {
        to.sparse(&[self.force, self.rate]);
    }

    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        [self.force, self.rate] = from.sparse_array()?;
        Ok(())
    }
}

impl Axial {
    /// See [`crate::elements::Element::visit_history`].
    pub fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        visit(std::slice::from_mut(&mut self.force));
        visit(std::slice::from_mut(&mut self.rate));
    }

    /// Axial force N at `length` (m), N.
    #[inline(always)]
    pub fn force_at(&self, length: f64, per_time: f64) -> f64 {
        self.stiffness * (length - self.rest) + self.dashpot * per_time * (length - self.anchor)
    }

    /// Elastic energy and viscous potential at `length` (m), J.
    #[inline(always)]
    pub fn potential(&self, length: f64, per_time: f64) -> f64 {
        let (stretch, change) = (length - self.rest, length - self.anchor);
        0.5 * self.stiffness * stretch * stretch + 0.5 * self.dashpot * per_time * change * change
    }

    /// Elastic energy at `length` (m), J.
    #[inline(always)]
    pub fn energy(&self, length: f64) -> f64 {
        let stretch = length - self.rest;
        0.5 * self.stiffness * stretch * stretch
    }

    /// Stores the rate of length at the end of the stage, at `length` (m).
    pub fn finish(&mut self, length: f64, per_time: f64) {
        self.rate = (length - self.anchor) * per_time;
    }

    /// Tangent block for the vector `d` (m) along the spring, row by row, N/m.
    #[inline(always)]
    pub fn block(&self, d: DVec3, length: f64, geometric: Geometric, per_time: f64) -> [f64; 9] {
        let n = (d / length).to_array();
        let force = if geometric == Geometric::Clipped { self.force.max(0.0) } else { self.force };
        let across = force / length;
        let along = self.stiffness + self.dashpot * per_time - across;
        let mut block = [0.0; 9];
        for r in 0..3 {
            for c in 0..3 {
                block[3 * r + c] = along * n[r] * n[c];
            }
            block[4 * r] += across;
        }
        block
    }

    /// Sets N* to the force that a change `change` (m) of `d` predicts to first order. Returns the
    /// energy of the prediction error, J.
    #[inline(always)]
    pub fn predict_stress(&mut self, d: DVec3, length: f64, change: DVec3, per_time: f64) -> f64 {
        let predicted = length + d.dot(change) / length;
        self.force = self.force_at(predicted, per_time);
        let miss = (d + change).length() - predicted;
        0.5 * (self.stiffness + self.dashpot * per_time) * miss * miss
    }

    /// Sets N* to the force at `length` (m).
    pub fn update_stress(&mut self, length: f64, per_time: f64) {
        self.force = self.force_at(length, per_time);
    }
}

/// The methods of [`crate::elements::Element`] on springs with an axial law that do not depend on
/// the ends of the springs.
macro_rules! axial_methods {
    () => {
        fn finish_stage(&mut self, x: &Vectors) {
            for s in self.springs.iter_mut().filter(|s| s.axial.dashpot > 0.0) {
                s.axial.finish(s.along(x).1, self.per_time);
            }
        }

        fn reset_rates(&mut self) {
            self.springs.iter_mut().for_each(|s| s.axial.rate = 0.0);
        }

        fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
            self.springs.iter_mut().for_each(|s| s.axial.visit_history(visit));
        }

        fn serialise_history(&self, to: &mut StateWriter) {
            self.springs.iter().for_each(|s| s.axial.serialise(to));
        }

        fn deserialise_history(&mut self, from: &mut StateReader) -> ReadResult {
            self.springs.iter_mut().try_for_each(|s| s.axial.deserialise(from))
        }

        fn potential(&self, x: &Vectors) -> f64 {
            self.springs.iter().map(|s| s.axial.potential(s.along(x).1, self.per_time)).sum()
        }

        fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
            let mut missed = 0.0;
            for s in &mut self.springs {
                let (along, length) = s.along(x);
                if length > 0.0 {
                    let change = s.change(d);
                    missed += s.axial.predict_stress(along, length, change, self.per_time);
                }
            }
            missed
        }

        fn update_stress(&mut self, x: &Vectors) {
            for s in &mut self.springs {
                s.axial.update_stress(s.along(x).1, self.per_time);
            }
        }
    };
}

pub(crate) use axial_methods;
