//! Creep of the membrane of a triangle mesh: each edge has a rest strain and each triangle a
//! relative stiffness for the step. [`crate::elements::creep`] has the equations.

use crate::elements::ThermalFields;
use crate::elements::creep::{CreepStrain, InelasticElement, InelasticStep};
use crate::elements::triangle_membrane::{EdgeMembrane, dot, product};
use crate::math::Vectors;
use crate::serialize::state;

/// Creep state of all edges and triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeCreep {
    /// Creep state of each edge.
    pub(crate) strains: Vec<CreepStrain>,
    /// Instantaneous stiffness G of each triangle, J.
    full: Vec<[[f64; 3]; 3]>,
    /// Stiffness of each triangle in the step, relative to the instantaneous one.
    scale: Vec<f64>,
    share: [f64; 2],
    is_in_step: bool,
    /// Remaining stiffness along each edge as a fraction of the law's, and thermal expansion of the
    /// edge.
    warmth: Vec<(f64, f64)>,
}

state!(EdgeCreep: is_in_step, strains, full, scale, warmth);

impl EdgeCreep {
    pub fn new(edges: usize, triangles: usize, share: [f64; 2]) -> Self {
        Self {
            strains: vec![CreepStrain::default(); edges],
            full: vec![[[0.0; 3]; 3]; triangles],
            scale: vec![1.0; triangles],
            share,
            is_in_step: false,
            warmth: vec![(1.0, 0.0); edges],
        }
    }

    /// Whether a step is in progress.
    pub fn is_running(&self) -> bool {
        self.is_in_step
    }
}

impl EdgeMembrane {
    /// Stores newly set stiffnesses as the instantaneous ones and applies the scale of the step.
    pub(crate) fn store_full_stiffness(&mut self) {
        let Some(creeping) = &mut self.creep else { return };
        for (full, t) in creeping.full.iter_mut().zip(&self.triangles) {
            *full = t.stiffness;
        }
        self.rescale();
    }

    fn rescale(&mut self) {
        let Some(creeping) = &self.creep else { return };
        for ((t, full), scale) in self.triangles.iter_mut().zip(&creeping.full).zip(&creeping.scale) {
            t.stiffness = full.map(|row| row.map(|g| g * scale));
        }
    }

    /// Strain of edge `e` at `x` (m) relative to the expanded edge, creep strain included.
    fn whole(&self, e: usize, x: &Vectors, creeping: &EdgeCreep) -> f64 {
        let strain = &self.strains[e];
        strain.at(x) + 0.5 * (strain.unit - 1.0 - self.arc_change(e)) - creeping.warmth[e].1
    }

    /// Sets the rest strain of edge `e` from `creeping`.
    pub(crate) fn apply_rest_strain(&mut self, e: usize, creeping: &EdgeCreep) {
        let rest = creeping.warmth[e].1 + creeping.strains[e].rest;
        self.strains[e].unit = 1.0 + 2.0 * rest + self.arc_change(e);
    }

    /// Applies temperature to the edges, as [`crate::elements::Element::apply_temperature`];
    /// returns false without creep.
    pub(crate) fn apply_temperature_to_creep(&mut self, x: &Vectors, warmth: &ThermalFields) -> bool {
        let Some(mut creeping) = self.creep.take() else { return false };
        for e in 0..self.strains.len() {
            let strain = self.whole(e, x, &creeping) + creeping.warmth[e].1;
            let ends = self.strains[e].ends;
            let (softness, grown) = (warmth.stiffness(&ends), warmth.mean_expansion(&ends));
            let kept = (creeping.warmth[e].0 / softness).min(1.0);
            creeping.warmth[e] = (softness, grown);
            let share = creeping.share;
            let own = &mut creeping.strains[e];
            own.scale_stress(strain - grown, kept, share);
            own.rest = own.stress_free();
            self.apply_rest_strain(e, &creeping);
        }
        for (t, full) in self.triangles.iter_mut().zip(&creeping.full) {
            t.stiffness = *full;
        }
        self.creep = Some(creeping);
        true
    }

    /// Energy stored in the arms between steps, J.
    pub(crate) fn creep_energy(&self, creeping: &EdgeCreep, x: &Vectors) -> f64 {
        let share = creeping.share;
        let mut sum = 0.0;
        for (t, full) in self.triangles.iter().zip(&creeping.full) {
            let arms =
                t.edges.map(|e| creeping.strains[e as usize].arms_at(self.whole(e as usize, x, creeping), share));
            for i in (0..2).filter(|i| share[*i] > 0.0) {
                let s = arms.map(|s| s[i]);
                sum += 0.5 * dot(&s, &product(full, &s)) / share[i];
            }
        }
        sum
    }
}

impl InelasticElement for EdgeMembrane {
    fn begin_step(&mut self, x: &Vectors, step: Option<&InelasticStep>) -> bool {
        let Some(mut creeping) = self.creep.take() else { return false };
        creeping.is_in_step = step.is_some();
        for e in 0..self.strains.len() {
            let decay = step.and_then(|step| step.decay(&self.strains[e].ends));
            let (strain, share) = (self.whole(e, x, &creeping), creeping.share);
            creeping.strains[e].begin(strain, share, decay.as_ref());
            self.apply_rest_strain(e, &creeping);
        }
        for (t, scale) in self.triangles.iter().zip(&mut creeping.scale) {
            *scale = t.edges.iter().map(|e| creeping.strains[*e as usize].stiffness).sum::<f64>() / 3.0;
        }
        self.creep = Some(creeping);
        self.rescale();
        false
    }

    fn end_step(&mut self, x: &Vectors, step: &InelasticStep) {
        let Some(mut creeping) = self.creep.take() else { return };
        creeping.is_in_step = false;
        for e in 0..self.strains.len() {
            let Some(decay) = step.decay(&self.strains[e].ends) else { continue };
            let strain = self.whole(e, x, &creeping);
            creeping.strains[e].end(strain, &decay);
        }
        self.creep = Some(creeping);
    }
}
