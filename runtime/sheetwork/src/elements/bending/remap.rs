//! What a shell's bending holds, to another grid: what yield and creep have left beyond the creases it was made with, how far it has
//! hardened, and where heat has let it set. Creases and curl are made on each grid anew, and stay as sharp as that has them.

use glam::DVec3;

use crate::elements::bending::Bending;
use crate::elements::remap::Carry;

/// Of one curvature: κ₀ that heat has set, its angle beyond that it was made with, hardening, arms.
const HELD: usize = 7;

impl Bending {
    /// What warmth alone curls component `a` of group `i` by, 1/m.
    fn curl_of(&self, i: usize, a: usize) -> f64 {
        let rows = &self.source[i].rows;
        let bends = !(rows[0].is_empty() && rows[1].is_empty());
        if a < 2 && bends { self.curl.get(i).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// What component `a` of group `i` holds.
    fn held(&self, i: usize, a: usize) -> [f64; HELD] {
        let source = &self.source[i];
        let curl = self.curl_of(i, a);
        let mut set = self.rest.get(i).map_or(DVec3::ZERO, |r| r[a]);
        let Some(rests) = &self.rests else {
            set.y -= curl;
            return [set.x, set.y, set.z, 0.0, 0.0, 0.0, 0.0];
        };
        let strain = rests.strains.get(i).map(|s| s[a]);
        let left = strain.map_or(rests.rest[i][a], |s| s.left());
        let angle = source.angle_of(a, left - curl) - rests.made[i][a];
        let arms = strain.map_or([0.0; 2], |s| s.arms.map(|arm| arm / source.gain[a]));
        let hardened = rests.hardened.get(i).copied().unwrap_or(0.0);
        [set.x, set.y, set.z, angle, hardened, arms[0], arms[1]]
    }

    fn put(&mut self, i: usize, a: usize, held: [f64; HELD]) {
        let [x, y, z, angle, hardened, first, second] = held;
        let curl = self.curl_of(i, a);
        let source = &self.source[i];
        let own = if self.rests.is_some() { 0.0 } else { curl };
        if let Some(rest) = self.rest.get_mut(i) {
            rest[a] = DVec3::new(x, y + own, z);
        }
        let Some(rests) = &mut self.rests else { return };
        let left = source.of_angle(a, rests.made[i][a] + angle) + curl;
        rests.rest[i][a] = left;
        if let Some(strain) = rests.strains.get_mut(i).map(|s| &mut s[a]) {
            strain.arms = [first * source.gain[a], second * source.gain[a]];
            (strain.start, strain.rest, strain.stiffness) = (left + strain.arms[0] + strain.arms[1], left, 1.0);
        }
        if let Some(own) = rests.hardened.get_mut(i) {
            *own = hardened;
        }
    }

    /// Takes up what `old` holds.
    pub(crate) fn carry_rests(&mut self, old: &Self, carry: &Carry) {
        if old.rests.is_none() && old.rest.is_empty() {
            return;
        }
        for a in 0..3 {
            let known = old.source.iter().enumerate().filter(|(_, s)| !s.rows[a].is_empty());
            let places = carry.gather(a == 2, known.map(|(i, s)| (s.home, old.held(i, a))));
            for i in 0..self.groups.len() {
                let source = &self.source[i];
                let known = !source.rows[a].is_empty();
                let home = source.home;
                if let Some(held) = known.then(|| carry.read(&places, home, a == 2)).flatten() {
                    self.put(i, a, held);
                }
            }
        }
        if let Some(rests) = &mut self.rests {
            rests.look();
        }
    }
}
