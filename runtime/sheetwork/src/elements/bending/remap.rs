//! Remapping of the bending state of a shell to another grid: plastic and creep curvature beyond
//! the initial curvature, hardening, and thermal rest curvature. Creases and curl are generated on
//! each grid and keep the sharpness of that grid.

use glam::DVec3;

use crate::elements::bending::Bending;
use crate::elements::remap::Remap;

/// State per curvature: thermal κ₀ (3), angle beyond the initial one, hardening, two creep arms.
const STATE_COMPONENTS: usize = 7;

impl Bending {
    /// Thermal curvature of component `a` of group `i`, 1/m.
    fn thermal_curl(&self, i: usize, a: usize) -> f64 {
        let rows = &self.source[i].rows;
        let bends = !(rows[0].is_empty() && rows[1].is_empty());
        if a < 2 && bends { self.curl.get(i).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// Transferable state of component `a` of group `i`.
    fn stored_state(&self, i: usize, a: usize) -> [f64; STATE_COMPONENTS] {
        let source = &self.source[i];
        let curl = self.thermal_curl(i, a);
        let mut set = self.rest.get(i).map_or(DVec3::ZERO, |r| r[a]);
        let Some(rests) = &self.rest_curvature else {
            set.y -= curl;
            return [set.x, set.y, set.z, 0.0, 0.0, 0.0, 0.0];
        };
        let strain = rests.strains.get(i).map(|s| s[a]);
        let angle = source.angle_from_curvature(a, rests.stress_free(i)[a] - curl) - rests.design_angles[i][a];
        let arms = strain.map_or([0.0; 2], |s| s.arms.map(|arm| arm / source.gain[a]));
        let hardened = rests.hardened.get(i).copied().unwrap_or(0.0);
        [set.x, set.y, set.z, angle, hardened, arms[0], arms[1]]
    }

    fn set_stored_state(&mut self, i: usize, a: usize, held: [f64; STATE_COMPONENTS]) {
        let [x, y, z, angle, hardened, first, second] = held;
        let curl = self.thermal_curl(i, a);
        let source = &self.source[i];
        let own = if self.rest_curvature.is_some() { 0.0 } else { curl };
        if let Some(rest) = self.rest.get_mut(i) {
            rest[a] = DVec3::new(x, y + own, z);
        }
        let Some(rests) = &mut self.rest_curvature else { return };
        let left = source.curvature_from_angle(a, rests.design_angles[i][a] + angle) + curl;
        rests.rest[i][a] = left;
        if let Some(strain) = rests.strains.get_mut(i).map(|s| &mut s[a]) {
            strain.arms = [first * source.gain[a], second * source.gain[a]];
            (strain.start, strain.rest, strain.stiffness) = (left + strain.arms[0] + strain.arms[1], left, 1.0);
        }
        if let Some(own) = rests.hardened.get_mut(i) {
            *own = hardened;
        }
    }

    /// Takes the arms of a flat loss factor of `old`.
    pub(crate) fn transfer_arms(&mut self, old: &Self, carry: &Remap) {
        if old.arms.is_empty() || self.arms.is_empty() {
            return;
        }
        for a in 0..3 {
            let known = old.source.iter().enumerate().filter(|(_, s)| !s.rows[a].is_empty());
            let each = known.map(|(i, s)| (s.home, old.arms.strains(3 * i + a).map(|arm| arm / s.gain[a])));
            let places = carry.gather(a == 2, each);
            for (i, s) in self.source.iter().enumerate().filter(|(_, s)| !s.rows[a].is_empty()) {
                if let Some(held) = carry.interpolate(&places, s.home, a == 2) {
                    self.arms.set_strains(3 * i + a, held.map(|arm| arm * s.gain[a]));
                }
            }
        }
    }

    /// Takes the state of `old`.
    pub(crate) fn transfer_rest_curvature(&mut self, old: &Self, carry: &Remap) {
        if old.rest_curvature.is_none() && old.rest.is_empty() {
            return;
        }
        for a in 0..3 {
            let known = old.source.iter().enumerate().filter(|(_, s)| !s.rows[a].is_empty());
            let places = carry.gather(a == 2, known.map(|(i, s)| (s.home, old.stored_state(i, a))));
            for i in 0..self.groups.len() {
                let source = &self.source[i];
                let known = !source.rows[a].is_empty();
                let home = source.home;
                if let Some(held) = known.then(|| carry.interpolate(&places, home, a == 2)).flatten() {
                    self.set_stored_state(i, a, held);
                }
            }
        }
        if let Some(rests) = &mut self.rest_curvature {
            rests.update_is_flat();
        }
    }
}
