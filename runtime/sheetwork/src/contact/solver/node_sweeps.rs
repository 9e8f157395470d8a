//! PGS contact solver with a working set, for explicit integrators and as the last fallback of a
//! single sheet.
//!
//! A few contacts are added at a time (`working_set`); PGS sweeps over the Delassus operator find
//! their forces (`pgs`); then the contacts that are still violated join.

use glam::DVec3;

use crate::contact::settings::{ContactSettings, NodeSweepSettings, PgsSettings, WorkingSetSettings};
use crate::contact::solver::delassus::{Delassus, Group, frame_of};
use crate::contact::solver::pgs::Swept;
use crate::contact::solver::working_set::Picker;
use crate::contact::stage::Scratch;

const SETTINGS: NodeSweepSettings = ContactSettings::DEFAULT.node_sweeps;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;
const WORKING_SET: WorkingSetSettings = ContactSettings::DEFAULT.working_set;

/// PGS solver with its working set.
#[derive(Default)]
pub(crate) struct Dual {
    pub delassus: Delassus,
    /// Relative position or velocity without contact, of every contact in the problem.
    pub b: Vec<DVec3>,
    picker: Picker,
    passes: u32,
}

/// Maximum size of the working set of `group`.
fn most(group: &Group) -> usize {
    SETTINGS.maximum_contacts + SETTINGS.maximum_contacts_per_object * (group.members.len() + group.movers.len())
}

impl Dual {
    /// Start with attachments and with contacts that have a cached force and penetrate, or else
    /// with the deepest ones.
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

    /// Start with all closed contacts, for the velocity solve.
    pub fn begin_closed(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        self.passes = 0;
        self.delassus.clear_for_velocities(group);
        self.picker.begin(scratch.found.contacts.len());
        self.picker.new.extend(
            (0..scratch.found.contacts.len() as u32).filter(|i| scratch.gaps.now[*i as usize] < SETTINGS.penetration),
        );
        self.picker.new.truncate(2 * most(group));
        self.activate(scratch, group, h);
    }

    /// Add contacts that are still violated. Returns false if there are none or a limit is reached.
    pub fn grow(&mut self, scratch: &Scratch, group: &mut Group, h: f64) -> bool {
        self.passes += 1;
        self.pick_violated(scratch);
        if self.picker.new.is_empty()
            || self.passes >= WORKING_SET.maximum_extensions
            || self.delassus.problem.len() >= most(group)
        {
            return false;
        }
        self.activate(scratch, group, h);
        true
    }

    /// Solve the forces for the right-hand side `b`.
    pub fn sweep(&mut self) -> Swept {
        self.delassus.problem.solve(&self.b, PGS.tolerance, PGS.maximum_sweeps)
    }

    /// Solve the forces for the right-hand side `b` to a tenth of the penetration tolerance.
    pub fn sweep_roughly(&mut self) -> Swept {
        self.delassus.problem.solve(&self.b, 0.1 * SETTINGS.penetration, SETTINGS.rough_sweeps)
    }

    /// Active contacts, as indices into the detected contacts, and their forces in world axes, N.
    pub fn forces(&self) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let all = self.delassus.contacts().enumerate();
        all.map(|(k, i)| (i, self.delassus.frame(k) * self.delassus.problem.force[k]))
    }

    /// Add the new contacts of the working set to the problem.
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

    /// Select contacts outside the problem that penetrate by more than the tolerance.
    fn pick_violated(&mut self, scratch: &Scratch) {
        let depth = if scratch.short_steps { PGS.tolerance } else { SETTINGS.penetration };
        self.picker.pick_violated(scratch, &scratch.gaps.now, depth, self.delassus.contacts());
    }
}
