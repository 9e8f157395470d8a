//! Maxwell arms of a flat loss factor within the stages of an implicit integrator.
//!
//! An arm is a spring of g_i times the relaxed stiffness C in series with a dashpot of strain z_i:
//! ż_i = s_i/τ_i, with the strain s_i = ε - z_i of its spring as the state. The integrator is
//! applied to z as to positions, with ε_w the sum of the anchors and b_i = h/τ_i:
//!
//! ŝ_i = Σ w_a s_i(a) - (follow/τ_i) s_i,  s_i⁺ = (ε⁺ - ε_w + ŝ_i)/(1 + b_i),
//!
//! so σ = C [ε⁺ + Σ g_i/(1 + b_i) (ε⁺ - ε_w + ŝ_i)]. This is the stage of a Kelvin-Voigt
//! solid with τ/h = V = Σ g_i/(1 + b_i) and the reference strain ε_w - Σ g_i/(1 + b_i) ŝ_i/V.
//! An A-stable integrator of a dissipative law never raises the energy, that of the arms ½ Σ g_i
//! s_i C s_i included. Both stages of TR-BDF2 have one V and so one matrix.

use crate::elements::Anchor;
use crate::material::loss_factor::{ARM_TIMES, ARMS};
use crate::serialize::{ReadResult, StateReader, StateWriter};

/// Strains s_i of all arms of an element, by arm, then by strain component; without a value for a
/// sheet without arms.
#[derive(Clone, Debug, Default)]
pub struct ArmStrains {
    weights: [f64; ARMS],
    /// Number of strain components.
    count: usize,
    /// Values at the end of the last stage and, within a step or for a multistep integrator, of the
    /// stage before.
    now: Vec<f64>,
    before: Vec<f64>,
    stage: ArmStage,
}

/// Coefficients of a stage.
#[derive(Clone, Copy, Debug, Default)]
struct ArmStage {
    /// g_i/(1 + b_i)/V and 1/(1 + b_i).
    share: [f64; ARMS],
    retention: [f64; ARMS],
    /// Factors of the present and of the previous strain in ŝ_i.
    present: [f64; ARMS],
    previous: f64,
    /// Whether it is the trapezoidal stage of a step, or the one that follows and ends the step.
    is_trapezoidal: bool,
    ends_step: bool,
}

impl ArmStrains {
    /// Takes the weights g_i for `count` strain components.
    pub fn set_weights(&mut self, weights: [f64; ARMS], count: usize) {
        let size = if weights == [0.0; ARMS] { 0 } else { ARMS * count };
        (self.weights, self.count) = (weights, count);
        self.now.resize(size, 0.0);
        self.before.resize(size, 0.0);
    }

    /// Number of strains.
    pub fn len(&self) -> usize {
        self.now.len()
    }

    /// Whether the sheet has no arms.
    pub fn is_empty(&self) -> bool {
        self.now.is_empty()
    }

    /// Begins a stage, as [`crate::elements::Element::begin_stage`]; returns V.
    pub fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let weight = |k: usize| anchors.get(k).map_or(0.0, |a| a.weight);
        let retention = ARM_TIMES.map(|t| t * per_time / (1.0 + t * per_time));
        let viscous: f64 = self.weights.iter().zip(retention).map(|(g, r)| g * r).sum();
        let per_viscous = if viscous > 0.0 { 1.0 / viscous } else { 0.0 };
        self.stage = ArmStage {
            share: std::array::from_fn(|i| self.weights[i] * retention[i] * per_viscous),
            retention,
            present: ARM_TIMES.map(|t| weight(0) - follow / t),
            previous: weight(1),
            is_trapezoidal: follow > 0.0,
            ends_step: self.stage.is_trapezoidal && follow == 0.0,
        };
        viscous
    }

    /// Values of arm `i` from component `first` on.
    fn range(&self, i: usize, first: usize, length: usize) -> std::ops::Range<usize> {
        let at = i * self.count + first;
        at..at + length
    }

    /// Subtracts Σ g_i/(1 + b_i) ŝ_i/V from the strains from component `first` on.
    pub fn shift(&self, first: usize, strains: &mut [f64]) {
        if self.is_empty() {
            return;
        }
        let ArmStage { share, present, previous, .. } = self.stage;
        for i in 0..ARMS {
            let range = self.range(i, first, strains.len());
            let (a, b) = (share[i] * present[i], share[i] * previous);
            for ((e, now), before) in strains.iter_mut().zip(&self.now[range.clone()]).zip(&self.before[range]) {
                *e -= a * now + b * before;
            }
        }
    }

    /// Ends a stage at the strains `change` from component `first` on, relative to the shifted
    /// reference strains.
    pub fn finish(&mut self, first: usize, change: &mut [f64]) {
        if self.is_empty() {
            return;
        }
        // Now ε⁺ - ε_w.
        self.shift(first, change);
        let ArmStage { retention, present, previous, ends_step, .. } = self.stage;
        for i in 0..ARMS {
            let range = self.range(i, first, change.len());
            let (now, before) = (&mut self.now[range.clone()], &mut self.before[range]);
            for ((e, now), before) in change.iter().zip(now).zip(before) {
                let next = retention[i] * (e + present[i] * *now + previous * *before);
                *before = if ends_step { 0.0 } else { *now };
                *now = next;
            }
        }
    }

    /// Undoes the last stage, which was a trial from rest.
    pub fn undo_stage(&mut self) {
        self.now.copy_from_slice(&self.before);
    }

    /// Relaxes the arms, as after a long time.
    pub fn relax(&mut self) {
        self.now.fill(0.0);
        self.before.fill(0.0);
    }

    /// Adds Σ g_i s_i, the strain that the arms add to the relaxed law, from component `first` on.
    #[inline(always)]
    pub fn add_strain(&self, first: usize, to: &mut [f64]) {
        for (i, weight) in self.weights.iter().enumerate().filter(|_| !self.is_empty()) {
            let range = self.range(i, first, to.len());
            to.iter_mut().zip(&self.now[range]).for_each(|(to, s)| *to += weight * s);
        }
    }

    /// Sum over the arms of g_i times the energy of the strains that `strain` reads, J.
    pub fn energy(&self, energy: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> f64 {
        let each = self.weights.iter().enumerate().filter(|_| !self.is_empty());
        each.map(|(i, weight)| weight * energy(&|c| self.now[i * self.count + c])).sum()
    }

    /// Strains of the arms of component `c`.
    pub fn strains(&self, c: usize) -> [f64; ARMS] {
        std::array::from_fn(|i| self.now.get(i * self.count + c).copied().unwrap_or(0.0))
    }

    /// Sets the strains of component `c` of a sheet with arms.
    pub fn set_strains(&mut self, c: usize, strains: [f64; ARMS]) {
        for (i, strain) in strains.into_iter().enumerate() {
            self.now[i * self.count + c] = strain;
        }
    }

    /// Multiplies the strains of component `c` by `kept`: a stiffening element keeps its stress.
    pub fn scale(&mut self, c: usize, kept: f64) {
        let count = self.count.max(1);
        self.now.iter_mut().skip(c).step_by(count).filter(|_| kept < 1.0).for_each(|s| *s *= kept);
    }

    /// Visits the values, as [`crate::elements::Element::visit_history`].
    pub fn visit(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        visit(&mut self.now);
        visit(&mut self.before);
    }

    /// Serialises the values.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.sparse(&self.now);
        to.sparse(&self.before);
    }

    /// Deserialises the values.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        from.sparse(&mut self.now)?;
        from.sparse(&mut self.before)
    }
}
