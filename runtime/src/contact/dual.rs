//! Contacts between sheets and with bodies that give way, solved by their forces.
//!
//! Contacts are made active a few at a time, the deepest first and far from each other: a lying sheet needs some forty of its hundreds.
//! The forces of those come from sweeps over the Delassus operator; then whatever is still violated joins.

use glam::DVec3;

use super::delassus::{Delassus, Group, frame_of};
use super::stage::{Scratch, TOLERANCE};
use super::sweeps::Swept;

/// Violations up to this are let pass, m; where masses answer each for itself, up to the accuracy of a solve: their steps are
/// short, and what a step lets pass would add up.
const DEPTH: f64 = 1e-5;
/// Sweeps of a solve, at most.
const SWEEPS: u32 = 200;
/// Contacts made active at a time, at least.
const FEW: usize = 8;
/// Times that more are made active.
const PASSES: u32 = 40;

/// The solver with its arrays.
#[derive(Default)]
pub(super) struct Dual {
    pub delassus: Delassus,
    pub b: Vec<DVec3>,
    is_active: Vec<bool>,
    new: Vec<u32>,
    reach: Vec<f64>,
    passes: u32,
}

impl Dual {
    /// Begins with what was active before and still would overlap, and with glue; else with the deepest few.
    pub fn begin(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        self.passes = 0;
        self.delassus.clear(group);
        self.is_active.clear();
        self.is_active.resize(scratch.found.contacts.len(), false);
        self.new.clear();
        for (i, contact) in scratch.found.contacts.iter().enumerate() {
            let was = scratch.gaps.free[i] < 0.0 && scratch.memory.of(&contact.key).is_some();
            if i >= scratch.found.glue_from || was {
                self.new.push(i as u32);
            }
        }
        if self.new.is_empty() {
            self.pick_violated(scratch);
        }
        if self.new.is_empty() {
            // Shallower than what is let pass, but a beginning: the deepest.
            let gap = &scratch.gaps.now;
            let deepest = (0..gap.len()).min_by(|a, b| gap[*a].total_cmp(&gap[*b]));
            self.new.extend(deepest.map(|i| i as u32));
        }
        self.activate(scratch, group, h);
    }

    /// Makes more contacts active, those still violated; false when there are none.
    pub fn grow(&mut self, scratch: &Scratch, group: &mut Group, h: f64) -> bool {
        self.passes += 1;
        self.pick_violated(scratch);
        if self.new.is_empty() || self.passes >= PASSES {
            return false;
        }
        self.activate(scratch, group, h);
        true
    }

    /// Solves for the forces with the u in `b`.
    pub fn sweep(&mut self) -> Swept {
        self.delassus.problem.solve(&self.b, TOLERANCE, SWEEPS)
    }

    /// Active contacts, by number in the scratch's list, and the forces on them in the world, N.
    pub fn forces(&self) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let all = self.delassus.contacts().enumerate();
        all.map(|(k, i)| (i, self.delassus.frame(k) * self.delassus.problem.force[k]))
    }

    /// Makes the contacts in `new` active.
    fn activate(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        for number in &self.new {
            let i = *number as usize;
            let contact = &scratch.found.contacts[i];
            self.is_active[i] = true;
            let force = scratch.memory.of(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            self.delassus.problem.push(scratch.law(i), frame_of(contact.normal).transpose() * force);
        }
        self.delassus.add(group, &scratch.found.contacts, &self.new, h);
    }

    /// Picks contacts that are violated and not active: the deepest, then those deep and far from the ones picked.
    fn pick_violated(&mut self, scratch: &Scratch) {
        let (gap, places, contacts) = (&scratch.gaps.now, &scratch.gaps.places, &scratch.found.contacts);
        self.new.clear();
        let count = contacts.len();
        let most = FEW.max(self.delassus.problem.len() / 3);
        let active = &self.is_active;
        let depth = if scratch.short_steps { TOLERANCE } else { DEPTH };
        let violated = |i: &usize| gap[*i] < -depth && !active[*i];
        let deeper = |a: &usize, b: &usize| gap[*a].total_cmp(&gap[*b]).then(contacts[*a].key.cmp(&contacts[*b].key));
        let mut next = (0..count).filter(violated).min_by(deeper);
        if next.is_none() {
            return;
        }
        self.reach.clear();
        self.reach.resize(count, f64::INFINITY);
        for other in self.delassus.contacts() {
            for (reach, place) in self.reach.iter_mut().zip(places) {
                *reach = reach.min(place.distance_squared(places[other]));
            }
        }
        while let Some(pick) = next {
            self.new.push(pick as u32);
            if self.new.len() >= most {
                break;
            }
            let mut best = (0.0, None);
            for i in 0..count {
                self.reach[i] = self.reach[i].min(places[i].distance_squared(places[pick]));
                let score = self.reach[i] * -gap[i];
                if violated(&i) && score > best.0 {
                    best = (score, Some(i));
                }
            }
            next = best.1;
        }
        self.new.sort_unstable();
    }
}
