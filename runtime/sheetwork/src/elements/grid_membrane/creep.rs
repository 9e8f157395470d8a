//! Creep of the membrane of a grid. [`PacketRestState`] holds the elastic law of the step; the
//! strains of the creep arms are here. [`crate::elements::creep`] has the equations.

use crate::elements::ThermalFields;
use crate::elements::creep::{ArmDecay, CreepStrain, InelasticElement, InelasticStep};
use crate::elements::grid_membrane::{CellGeometry, CellMembrane, LANES, Pack, PacketRestState, half_dot, open_cell};
use crate::math::Vectors;
use crate::serialize::state;

/// Creep state of the cells of a packet; strains without thermal expansion.
#[derive(Clone, Debug)]
struct PacketCreep {
    strains: [[CreepStrain; LANES]; 5],
    /// Remaining stiffness as a fraction of the law's.
    softness: Pack,
}

/// Creep state of all cells.
#[derive(Clone, Debug)]
pub(crate) struct CellCreep {
    parts: Vec<PacketCreep>,
    share: [f64; 2],
    /// Whether a step is in progress.
    is_in_step: bool,
}

impl CellCreep {
    fn new(packets: usize, share: [f64; 2]) -> Self {
        let part = PacketCreep { strains: [[CreepStrain::default(); LANES]; 5], softness: Pack::splat(1.0) };
        Self { parts: vec![part; packets], share, is_in_step: false }
    }

    /// Creep states of lane `l` of packet `index`.
    pub fn strains(&mut self, index: usize, l: usize) -> impl Iterator<Item = &mut CreepStrain> {
        self.parts[index].strains.iter_mut().map(move |s| &mut s[l])
    }

    /// Strain without stress and arms of each strain of a cell.
    pub fn stored_state(&self, index: usize, l: usize) -> [[f64; 3]; 5] {
        std::array::from_fn(|k| self.parts[index].strains[k][l].stored_state())
    }

    /// Remaining stiffness of cell `l` of packet `index`, as a fraction of the law's.
    pub fn softness(&mut self, index: usize, l: usize) -> &mut f64 {
        &mut self.parts[index].softness.0[l]
    }
}

state!(PacketCreep: strains, softness.0);
state!(CellCreep: is_in_step, parts);

/// Thermal expansion of strain `k` in lane `l`; the shear has none.
fn expansion(w: &PacketRestState, k: usize, l: usize) -> f64 {
    w.expansion.get(k).map_or(0.0, |e| e.0[l])
}

impl CellMembrane {
    /// Adds creep with Maxwell arms of the shares `share`, if any.
    pub fn with_creep(mut self, share: Option<[f64; 2]>) -> Self {
        let Some(share) = share else { return self };
        self.creep = Some(Box::new(CellCreep::new(self.packets.len(), share)));
        self.rest_state = vec![PacketRestState::COLD; self.packets.len()];
        self
    }

    /// Energy stored in the arms, J; `None` during a step and without creep.
    pub(crate) fn creep_energy(&self, x: &Vectors) -> Option<f64> {
        let creeping = self.creep.as_ref().filter(|c| !c.is_in_step)?;
        let (cell, share) = (&self.cell, creeping.share);
        let mut sum = 0.0;
        for ((p, part), w) in self.packets.iter().zip(&creeping.parts).zip(&self.rest_state) {
            let e = cell.strains(&cell.edges(x, p.first));
            for i in (0..2).filter(|i| share[*i] > 0.0) {
                let mut arm = e;
                for (k, strains) in part.strains.iter().enumerate() {
                    for (l, strain) in strains.iter().enumerate() {
                        arm[k].0[l] = strain.arms_at(e[k].0[l] - expansion(w, k, l), share)[i];
                    }
                }
                let stress = cell.stress(&arm).map(|s| s * part.softness);
                sum += half_dot(&stress, &arm, p.count) / share[i];
            }
        }
        Some(sum)
    }

    /// Applies temperature, as [`crate::elements::Element::apply_temperature`]; returns false
    /// without creep.
    pub(crate) fn apply_temperature_to_creep(&mut self, x: &Vectors, warmth: &ThermalFields) -> bool {
        let Some(creeping) = &mut self.creep else { return false };
        let (cell, share) = (self.cell, creeping.share);
        let parts = self.packets.iter().zip(&mut creeping.parts).zip(&mut self.rest_state);
        for (index, ((p, part), w)) in parts.enumerate() {
            let e = cell.strains(&cell.edges(x, p.first));
            for l in 0..p.count {
                let m = cell.masses(p.first + l);
                for (k, edge) in Self::edges_of(m).iter().enumerate() {
                    w.expansion[k].0[l] = warmth.mean_expansion(edge);
                }
                let after = warmth.stiffness(&m.map(|m| m as u32));
                if let Some(kept) = open_cell(&mut self.open, index, l) {
                    *kept = after;
                    continue;
                }
                let kept = (part.softness.0[l] / after).min(1.0);
                for k in 0..5 {
                    let grown = expansion(w, k, l);
                    self.arms.scale((5 * index + k) * LANES + l, kept);
                    part.strains[k][l].scale_stress(e[k].0[l] - grown, kept, share);
                    w.rest[k].0[l] = grown + part.strains[k][l].stress_free();
                }
                part.softness.0[l] = after;
                w.softness.0[l] = after;
            }
        }
        true
    }
}

impl InelasticElement for CellMembrane {
    fn begin_step(&mut self, x: &Vectors, step: Option<&InelasticStep>) -> bool {
        let Some(creeping) = &mut self.creep else { return false };
        let (cell, share) = (self.cell, creeping.share);
        creeping.is_in_step = step.is_some();
        for ((p, part), w) in self.packets.iter().zip(&mut creeping.parts).zip(&mut self.rest_state) {
            let e = cell.strains(&cell.edges(x, p.first));
            for l in 0..p.count {
                let decay = step.and_then(|step| decay(&cell, p.first + l, step));
                w.softness.0[l] = part.softness.0[l] * decay.map_or(1.0, |d| d.stiffness());
                for k in 0..5 {
                    let (strain, grown) = (&mut part.strains[k][l], expansion(w, k, l));
                    strain.begin(e[k].0[l] - grown, share, decay.as_ref());
                    w.rest[k].0[l] = grown + strain.rest;
                }
            }
        }
        false
    }

    fn end_step(&mut self, x: &Vectors, step: &InelasticStep) {
        let Some(creeping) = &mut self.creep else { return };
        let cell = self.cell;
        creeping.is_in_step = false;
        for ((p, part), w) in self.packets.iter().zip(&mut creeping.parts).zip(&self.rest_state) {
            let e = cell.strains(&cell.edges(x, p.first));
            for l in 0..p.count {
                let Some(decay) = decay(&cell, p.first + l, step) else { continue };
                (0..5).for_each(|k| part.strains[k][l].end(e[k].0[l] - expansion(w, k, l), &decay));
            }
        }
    }
}

fn decay(cell: &CellGeometry, first: usize, step: &InelasticStep) -> Option<ArmDecay> {
    step.decay(&cell.masses(first).map(|m| m as u32))
}
