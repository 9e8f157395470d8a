//! What a spring does along itself in a stage, whatever its ends are: stretch, dashpot and the axial force of its own.
//!
//! For a length L, rest length s, stiffness k, dashpot c and a stage with 1/h: N = k (L - s) + (c/h)(L - L_w), potential
//! ½ k (L-s)² + ½ (c/h)(L-L_w)², tangent (k + c/h) n nᵀ + (N*/L)(I - n nᵀ) with n the unit direction and N* the force that the
//! last solve predicted.

use glam::DVec3;

use super::Geometric;
use crate::kept::{Keeper, Taken, Taker};

/// The state and the law of one spring.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axial {
    /// k, N/m.
    pub stiffness: f64,
    /// s, m.
    pub rest: f64,
    /// c, N s/m.
    pub dashpot: f64,
    /// N*, N.
    pub force: f64,
    /// L_w, m.
    pub anchor: f64,
    /// Rate of stretch at the end of the last stage, m/s.
    pub rate: f64,
}

impl Axial {
    /// See [`super::Element::history`].
    pub fn history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        visit(std::slice::from_mut(&mut self.force));
        visit(std::slice::from_mut(&mut self.rate));
    }

    /// See [`super::Element::keep_history`].
    pub fn keep(&self, to: &mut Keeper) {
        to.sparse(&[self.force, self.rate]);
    }

    /// See [`super::Element::take_history`].
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        let mut both = [0.0; 2];
        from.sparse(&mut both)?;
        [self.force, self.rate] = both;
        Ok(())
    }

    /// N at `length`.
    #[inline(always)]
    pub fn force_at(&self, length: f64, per_time: f64) -> f64 {
        self.stiffness * (length - self.rest) + self.dashpot * per_time * (length - self.anchor)
    }

    /// Stored and viscous potential at `length`, J.
    #[inline(always)]
    pub fn potential(&self, length: f64, per_time: f64) -> f64 {
        let (stretch, change) = (length - self.rest, length - self.anchor);
        0.5 * self.stiffness * stretch * stretch + 0.5 * self.dashpot * per_time * change * change
    }

    /// Stored energy at `length`, J.
    #[inline(always)]
    pub fn energy(&self, length: f64) -> f64 {
        let stretch = length - self.rest;
        0.5 * self.stiffness * stretch * stretch
    }

    /// Keeps the rate of stretch that the stage ends with at `length`.
    pub fn finish(&mut self, length: f64, per_time: f64) {
        self.rate = (length - self.anchor) * per_time;
    }

    /// The tangent's block for the vector `d` along the spring, by rows, N/m.
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

    /// Takes up the force that changing `d` by `change` predicts; returns the energy of the stretch it misses, J.
    #[inline(always)]
    pub fn predict(&mut self, d: DVec3, length: f64, change: DVec3, per_time: f64) -> f64 {
        let predicted = length + d.dot(change) / length;
        self.force = self.force_at(predicted, per_time);
        let miss = (d + change).length() - predicted;
        0.5 * (self.stiffness + self.dashpot * per_time) * miss * miss
    }

    /// Takes up the force at `length`.
    pub fn settle(&mut self, length: f64, per_time: f64) {
        self.force = self.force_at(length, per_time);
    }
}
