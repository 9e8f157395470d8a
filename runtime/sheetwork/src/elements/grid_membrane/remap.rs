//! Remapping of the membrane state of a grid to another grid: thermal rest strain, creep and
//! the arms of a flat loss factor.
//! Thermal expansion follows from the temperatures.

use crate::elements::creep::CreepStrain;
use crate::elements::grid_membrane::{CellMembrane, LANES, PacketRestState};
use crate::elements::remap::Remap;
use crate::material::loss_factor::ARMS;

/// State per cell: rest strain and two creep arms for each of the four edges and the shear.
const STATE_COMPONENTS: usize = 15;

impl CellMembrane {
    /// Calls `visit` with packet, lane and first node of every cell.
    fn for_each_cell(&self, mut visit: impl FnMut(usize, usize, u32)) {
        for (index, p) in self.packets.iter().enumerate() {
            for l in 0..p.count {
                visit(index, l, (p.first + l) as u32);
            }
        }
    }

    /// Takes the arms of a flat loss factor of `old`.
    pub(crate) fn transfer_arms(&mut self, old: &Self, carry: &Remap) {
        if old.arms.is_empty() || self.arms.is_empty() {
            return;
        }
        let component = |index: usize, k: usize, l: usize| (5 * index + k) * LANES + l;
        let mut cells = Vec::new();
        old.for_each_cell(|index, l, home| {
            let held: [[f64; ARMS]; 5] = std::array::from_fn(|k| old.arms.strains(component(index, k, l)));
            cells.push((home, std::array::from_fn::<_, { 5 * ARMS }, _>(|n| held[n / ARMS][n % ARMS])));
        });
        let places = carry.gather(true, cells.into_iter());
        let mut all = Vec::new();
        self.for_each_cell(|index, l, home| {
            all.extend(carry.interpolate(&places, home, true).map(|held| (index, l, held)));
        });
        for (index, l, held) in all {
            for (k, arms) in held.as_chunks::<ARMS>().0.iter().enumerate() {
                self.arms.set_strains(component(index, k, l), *arms);
            }
        }
    }

    /// Takes the state of `old`.
    pub(crate) fn transfer_strains(&mut self, old: &Self, carry: &Remap) {
        if old.rest_state.is_empty() {
            return;
        }
        if self.rest_state.is_empty() {
            self.rest_state = vec![PacketRestState::COLD; self.packets.len()];
        }
        let mut cells = Vec::new();
        old.for_each_cell(|index, l, home| {
            let w = &old.rest_state[index];
            let mut held = [0.0; STATE_COMPONENTS];
            for k in 0..5 {
                let grown = w.expansion.get(k).map_or(0.0, |e| e.0[l]);
                held[3 * k] = w.rest[k].0[l] - grown;
            }
            if let Some(creeping) = &old.creep {
                held = std::array::from_fn(|n| creeping.stored_state(index, l)[n / 3][n % 3]);
            }
            cells.push((home, held));
        });
        let places = carry.gather(true, cells.into_iter());
        let mut all = Vec::new();
        self.for_each_cell(|index, l, home| {
            all.extend(carry.interpolate(&places, home, true).map(|held| (index, l, held)));
        });
        for (index, l, held) in all {
            let w = &mut self.rest_state[index];
            for k in 0..5 {
                let grown = w.expansion.get(k).map_or(0.0, |e| e.0[l]);
                w.rest[k].0[l] = grown + held[3 * k];
            }
            let Some(creeping) = &mut self.creep else { continue };
            for (k, strain) in creeping.strains(index, l).enumerate() {
                *strain = CreepStrain::from_stored_state([held[3 * k], held[3 * k + 1], held[3 * k + 2]]);
            }
        }
    }
}
