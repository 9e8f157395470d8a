//! Springs from a node to a fixed point: the remainder of lattice springs that a clamp cuts.
//!
//! The equations are those of `axial`, with one end fixed. Stiffness is in N/m, lengths in m.

use glam::DVec3;

use crate::elements::axial::{Axial, axial_methods};
use crate::elements::creep::{CreepStrain, InelasticElement, InelasticStep};
use crate::elements::fracture::OpenCells;
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK, ThermalFields, add_block, rest_strain_after_softening};
use crate::material::law::ElementLaw;
use crate::math::Vectors;
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};

#[derive(Clone, Copy, Debug)]
struct ClampSpring {
    mass: usize,
    block: u32,
    point: DVec3,
    /// Stiffness per unit of bending stiffness, 1/m².
    per_bending: f64,
    /// Length without load at 20 °C, m.
    cold: f64,
    /// Remaining stiffness as a fraction of the law's, and thermal expansion.
    softness: f64,
    expansion: f64,
    /// Whether fracture has removed the node.
    is_cut: bool,
    axial: Axial,
}

/// All wall springs of a sheet.
#[derive(Clone, Debug, Default)]
pub struct WallSprings {
    springs: Vec<ClampSpring>,
    per_time: f64,
    /// Creep state of each spring; empty without creep.
    creep: Vec<SpringCreep>,
    share: [f64; 2],
    /// Whether a step is in progress.
    is_in_step: bool,
}

/// Creep state of a spring: stretch (m) relative to the expanded length, and instantaneous
/// stiffness, N/m.
#[derive(Clone, Copy, Debug)]
struct SpringCreep {
    stiffness: f64,
    strain: CreepStrain,
}

state!(ClampSpring: softness, expansion, axial.stiffness, axial.rest, axial.dashpot);
state!(SpringCreep { stiffness, strain });

impl SpringCreep {
    /// Sets rest length and stiffness of the spring to those of the step.
    fn apply(&self, s: &mut ClampSpring) {
        s.axial.rest = s.expanded() + self.strain.rest;
        s.axial.stiffness = self.stiffness * self.strain.stiffness;
    }
}

impl WallSprings {
    /// Springs (node, fixed end in m, rest length in m, stiffness in N/m) of a sheet whose bending
    /// stiffness along its length is `bending` (N m). Their stiffness is proportional to it.
    pub fn new(springs: impl Iterator<Item = (u32, DVec3, f64, f64)>, bending: f64) -> Self {
        let each = springs.map(|(mass, point, rest, stiffness)| ClampSpring {
            mass: mass as usize,
            block: NO_BLOCK,
            point,
            per_bending: stiffness / bending,
            cold: rest,
            softness: 1.0,
            expansion: 0.0,
            is_cut: false,
            axial: Axial { stiffness, rest, ..Axial::default() },
        });
        Self { springs: each.collect(), ..Self::default() }
    }

    /// Adds creep with Maxwell arms of the shares `share`, if any.
    pub fn with_creep(mut self, share: Option<[f64; 2]>) -> Self {
        let Some(share) = share else { return self };
        let one = |s: &ClampSpring| SpringCreep { stiffness: s.axial.stiffness, strain: CreepStrain::default() };
        self.creep = self.springs.iter().map(one).collect();
        self.share = share;
        self
    }
}

/// State of a spring per unstressed length, without thermal expansion: permanent strain, and the
/// strains of the two creep arms.
pub(crate) type WallSpringState = [f64; 3];

impl WallSprings {
    /// Node, fixed end (m), strain at positions `x` (m) without thermal expansion, and state of
    /// each spring.
    pub(crate) fn stored_state<'a>(
        &'a self,
        x: &'a Vectors,
    ) -> impl Iterator<Item = (usize, DVec3, f64, WallSpringState)> + 'a {
        self.springs.iter().enumerate().map(|(i, s)| {
            let length = s.expanded();
            let held = match self.creep.get(i) {
                Some(c) => c.strain.stored_state().map(|e| e / length),
                None => [s.axial.rest / length - 1.0, 0.0, 0.0],
            };
            (s.mass, s.point, s.along(x).1 / length - 1.0, held)
        })
    }

    /// Sets the state of each spring from `held`, in the order of [`WallSprings::stored_state`];
    /// springs with `None` do not change.
    pub(crate) fn set_stored_state(&mut self, held: &[Option<WallSpringState>]) {
        for (i, (s, held)) in self.springs.iter_mut().zip(held).enumerate() {
            let Some(held) = held else { continue };
            let held = held.map(|h| h * s.expanded());
            s.axial.rest = s.expanded() + held[0];
            if let Some(c) = self.creep.get_mut(i) {
                c.strain = CreepStrain::from_stored_state(held);
                c.apply(s);
            }
        }
    }
}

impl ClampSpring {
    /// Length without load and without creep, m.
    fn expanded(&self) -> f64 {
        self.cold * (1.0 + self.expansion)
    }

    #[inline(always)]
    fn along(&self, x: &Vectors) -> (DVec3, f64) {
        let d = x.get(self.mass) - self.point;
        (d, d.length())
    }

    /// Change of that vector for the displacement `d` (m).
    #[inline(always)]
    fn change(&self, d: &Vectors) -> DVec3 {
        d.get(self.mass)
    }
}

impl Element for WallSprings {
    fn visit_coupled_nodes(&self, _visit: &mut dyn FnMut(u32, u32)) {}

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for s in &mut self.springs {
            s.block = block(s.mass as u32, s.mass as u32);
        }
    }

    fn set_law(&mut self, law: &ElementLaw) {
        for s in &mut self.springs {
            let bending = if s.is_cut { 0.0 } else { law.bending[0][0] };
            s.axial.stiffness = s.per_bending * bending * s.softness;
            s.axial.dashpot = s.axial.stiffness * law.retardation;
        }
        for (s, creeping) in self.springs.iter_mut().zip(&mut self.creep) {
            creeping.stiffness = s.axial.stiffness;
            creeping.apply(s);
        }
    }

    fn open(&mut self, _x: &Vectors, _open: &OpenCells, gone: &[bool]) {
        self.springs.iter_mut().for_each(|s| s.is_cut = gone[s.mass]);
    }

    fn apply_temperature(&mut self, x: &Vectors, warmth: &ThermalFields) {
        for (i, s) in self.springs.iter_mut().enumerate() {
            let mass = [s.mass as u32];
            let (softness, expansion) = (warmth.stiffness(&mass), warmth.mean_expansion(&mass));
            s.axial.rest += s.cold * (expansion - s.expansion);
            s.axial.rest = rest_strain_after_softening(s.along(x).1, s.axial.rest, s.softness, softness);
            let change = softness / s.softness;
            s.axial.stiffness *= change;
            s.axial.dashpot *= change;
            let kept = (s.softness / softness).min(1.0);
            (s.softness, s.expansion) = (softness, expansion);
            if let Some(creeping) = self.creep.get_mut(i) {
                let stretch = s.along(x).1 - s.expanded();
                creeping.strain.scale_stress(stretch, kept, self.share);
                creeping.strain.rest = creeping.strain.stress_free();
                creeping.stiffness *= change;
                creeping.apply(s);
            }
        }
    }

    fn energy(&self, x: &Vectors) -> f64 {
        if !self.is_in_step && !self.creep.is_empty() {
            let pairs = self.springs.iter().zip(&self.creep);
            return pairs
                .map(|(s, c)| c.stiffness * c.strain.stored_energy(s.along(x).1 - s.expanded(), self.share))
                .sum();
        }
        self.springs.iter().map(|s| s.axial.energy(s.along(x).1)).sum()
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let n = d / length;
                let pull = s.axial.stiffness * (length - s.axial.rest) + s.axial.dashpot * v.get(s.mass).dot(n);
                force.set(s.mass, force.get(s.mass) - n * pull);
            }
        }
    }

    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.per_time = per_time;
        for s in self.springs.iter_mut().filter(|s| s.axial.dashpot > 0.0) {
            let sum = anchors.iter().map(|a| a.weight * s.along(a.x).1).sum::<f64>();
            s.axial.anchor = follow * s.axial.rate + sum;
        }
    }

    axial_methods!();

    fn serialise_changes(&self, to: &mut StateWriter) {
        self.springs.serialise(to);
        self.creep.serialise(to);
        self.is_in_step.serialise(to);
    }

    fn deserialise_changes(&mut self, from: &mut StateReader) -> ReadResult {
        self.springs.deserialise(from)?;
        self.creep.deserialise(from)?;
        self.is_in_step.deserialise(from)
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length > 0.0 {
                let pull = d * (s.axial.force_at(length, self.per_time) / length);
                gradient.add(s.mass, pull);
            }
        }
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        for s in &self.springs {
            let (d, length) = s.along(x);
            if length <= 0.0 {
                continue;
            }
            let block = s.axial.block(d, length, geometric, self.per_time);
            add_block(values, s.block, &block);
        }
    }

    fn as_inelastic(&mut self) -> Option<&mut dyn InelasticElement> {
        (!self.creep.is_empty()).then_some(self as &mut dyn InelasticElement)
    }
}

impl InelasticElement for WallSprings {
    fn begin_step(&mut self, x: &Vectors, step: Option<&InelasticStep>) -> bool {
        self.is_in_step = step.is_some();
        for (s, c) in self.springs.iter_mut().zip(&mut self.creep) {
            let decay = step.and_then(|step| step.decay(&[s.mass as u32]));
            c.strain.begin(s.along(x).1 - s.expanded(), self.share, decay.as_ref());
            c.apply(s);
        }
        false
    }

    fn end_step(&mut self, x: &Vectors, step: &InelasticStep) {
        self.is_in_step = false;
        for (s, c) in self.springs.iter().zip(&mut self.creep) {
            if let Some(decay) = step.decay(&[s.mass as u32]) {
                c.strain.end(s.along(x).1 - s.expanded(), &decay);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::derivative_check;

    #[test]
    fn gradient_and_tangent_are_those_of_the_potential() {
        let x = derivative_check::bent_grid(3, 2, (0.1, 0.15));
        let ends = [(0, DVec3::new(-0.1, 0.0, 0.0), 0.2, 3.0), (4, DVec3::new(0.0, 0.3, 0.1), 0.1, 2.0)];
        let mut springs = WallSprings::new(ends.into_iter(), 1.0);
        springs.set_law(&derivative_check::law());
        derivative_check::derivatives(&mut springs, &x, 1e-6);
    }
}
