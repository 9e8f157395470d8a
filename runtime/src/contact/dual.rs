//! Contacts solved by sweeps over their forces: masses of explicit engines, and what else is left where nothing settles.
//!
//! A few contacts are picked at a time (`pick`); their forces come from sweeps over the Delassus operator (`sweeps`); then whatever is
//! still violated joins.

use glam::DVec3;

use super::delassus::{Delassus, Group, frame_of};
use super::pick::Picker;
use super::stage::Scratch;
use super::sweeps::Swept;

/// Violations up to this are let pass, m; where masses answer each for itself, up to the accuracy of a solve: their steps are
/// short, and what a step lets pass would add up.
const DEPTH: f64 = 1e-5;
/// Accuracy of position solves, m, and of velocity solves, m per weight of the stage.
pub(super) const ACCURACY: f64 = 1e-8;
/// Sweeps of a solve, at most.
const SWEEPS: u32 = 200;
/// The same where more contacts may join.
const ROUGH_SWEEPS: u32 = 20;
/// Contacts made active at most: so many for each sheet and body, and these. What is beyond is left to the next stage, since the
/// cost grows with the cube.
const MOST: usize = 60;
const MOST_FOR_EACH: usize = 40;
/// Times that more are made active.
const PASSES: u32 = 40;

/// The solver with its arrays.
#[derive(Default)]
pub(super) struct Dual {
    pub delassus: Delassus,
    pub b: Vec<DVec3>,
    picker: Picker,
    passes: u32,
}

/// How many contacts may be active in `group`.
fn most(group: &Group) -> usize {
    MOST + MOST_FOR_EACH * (group.members.len() + group.movers.len())
}

impl Dual {
    /// Begins with what was active before and still would overlap, and with glue; else with the deepest few.
    pub fn begin(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        self.passes = 0;
        self.delassus.clear(group);
        self.picker.begin(scratch.found.contacts.len());
        self.picker.pick_known(scratch);
        self.activate(scratch, group, h);
        self.pick_violated(scratch);
        if self.delassus.problem.is_empty() && self.picker.new.is_empty() {
            self.picker.pick_deepest(&scratch.gaps.now);
        }
        self.activate(scratch, group, h);
    }

    /// Begins with all contacts that are closed, for their velocities.
    pub fn begin_closed(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        self.passes = 0;
        self.delassus.clear_for_velocities(group);
        self.picker.begin(scratch.found.contacts.len());
        self.picker
            .new
            .extend((0..scratch.found.contacts.len() as u32).filter(|i| scratch.gaps.now[*i as usize] < DEPTH));
        self.picker.new.truncate(2 * most(group));
        self.activate(scratch, group, h);
    }

    /// Makes more contacts active, those still violated; false when there are none.
    pub fn grow(&mut self, scratch: &Scratch, group: &mut Group, h: f64) -> bool {
        self.passes += 1;
        self.pick_violated(scratch);
        if self.picker.new.is_empty() || self.passes >= PASSES || self.delassus.problem.len() >= most(group) {
            return false;
        }
        self.activate(scratch, group, h);
        true
    }

    /// Solves for the forces with the u in `b`.
    pub fn sweep(&mut self) -> Swept {
        self.delassus.problem.solve(&self.b, ACCURACY, SWEEPS)
    }

    /// The same, to what is let pass.
    pub fn sweep_roughly(&mut self) -> Swept {
        self.delassus.problem.solve(&self.b, 0.1 * DEPTH, ROUGH_SWEEPS)
    }

    /// Active contacts, by number in the scratch's list, and the forces on them in the world, N.
    pub fn forces(&self) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let all = self.delassus.contacts().enumerate();
        all.map(|(k, i)| (i, self.delassus.frame(k) * self.delassus.problem.force[k]))
    }

    /// Makes the contacts in `new` active.
    fn activate(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        for number in &self.picker.new {
            let i = *number as usize;
            let contact = &scratch.found.contacts[i];
            let force = scratch.remembered(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            self.delassus.problem.push(scratch.law(i), frame_of(contact.normal).transpose() * force);
        }
        self.delassus.add(group, &scratch.found.contacts, &self.picker.new, h);
        self.picker.activate();
    }

    fn pick_violated(&mut self, scratch: &Scratch) {
        let depth = if scratch.short_steps { ACCURACY } else { DEPTH };
        self.picker.pick_violated(scratch, &scratch.gaps.now, depth, self.delassus.contacts());
    }
}
