//! Contacts between sheets and with bodies that give way, solved by their forces.
//!
//! Contacts are made active a few at a time for each pair of things that touch, the deepest first and far from each other: a lying
//! sheet needs some forty of its hundreds.
//! The forces of those come from sweeps over the Delassus operator; then whatever is still violated joins.

use glam::DVec3;

use super::delassus::{Delassus, Group, frame_of};
use super::row::{Contact, Side};
use super::stage::{Gaps, Scratch};
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
/// Contacts of a pair made active at a time, at least.
const FEW: usize = 6;
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
    is_active: Vec<bool>,
    new: Vec<u32>,
    reach: Vec<f64>,
    /// Contacts that are violated, and active ones, by the pair they are of.
    violated: Vec<(u64, u32)>,
    held: Vec<(u64, u32)>,
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
        self.is_active.clear();
        self.is_active.resize(scratch.found.contacts.len(), false);
        self.new.clear();
        for (i, contact) in scratch.found.contacts.iter().enumerate() {
            let was = scratch.gaps.free[i] < 0.0 && scratch.remembered(&contact.key).is_some();
            if i >= scratch.found.glue_from || was {
                self.new.push(i as u32);
            }
        }
        self.activate(scratch, group, h);
        self.pick_violated(scratch);
        if self.delassus.problem.is_empty() && self.new.is_empty() {
            // Shallower than what is let pass, but a beginning: the deepest.
            let gap = &scratch.gaps.now;
            let deepest = (0..gap.len()).min_by(|a, b| gap[*a].total_cmp(&gap[*b]));
            self.new.extend(deepest.map(|i| i as u32));
        }
        self.activate(scratch, group, h);
    }

    /// Begins with all contacts that are closed, for their velocities.
    pub fn begin_closed(&mut self, scratch: &Scratch, group: &mut Group, h: f64) {
        self.passes = 0;
        self.delassus.clear_for_velocities(group);
        self.is_active.clear();
        self.is_active.resize(scratch.found.contacts.len(), false);
        self.new.clear();
        self.new.extend((0..scratch.found.contacts.len() as u32).filter(|i| scratch.gaps.now[*i as usize] < DEPTH));
        self.new.truncate(2 * most(group));
        self.activate(scratch, group, h);
    }

    /// Makes more contacts active, those still violated; false when there are none.
    pub fn grow(&mut self, scratch: &Scratch, group: &mut Group, h: f64) -> bool {
        self.passes += 1;
        self.pick_violated(scratch);
        if self.new.is_empty() || self.passes >= PASSES || self.delassus.problem.len() >= most(group) {
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
        for number in &self.new {
            let i = *number as usize;
            let contact = &scratch.found.contacts[i];
            self.is_active[i] = true;
            let force = scratch.remembered(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            self.delassus.problem.push(scratch.law(i), frame_of(contact.normal).transpose() * force);
        }
        self.delassus.add(group, &scratch.found.contacts, &self.new, h);
    }

    /// Picks contacts that are violated and not active: of every pair of things the deepest, then those deep and far from the ones
    /// picked.
    fn pick_violated(&mut self, scratch: &Scratch) {
        let (gap, contacts) = (&scratch.gaps.now, &scratch.found.contacts);
        self.new.clear();
        self.violated.clear();
        let depth = if scratch.short_steps { ACCURACY } else { DEPTH };
        for (i, contact) in contacts.iter().enumerate() {
            if gap[i] < -depth && !self.is_active[i] {
                self.violated.push((pair_of(contact), i as u32));
            }
        }
        if self.violated.is_empty() {
            return;
        }
        self.violated.sort_unstable();
        self.held.clear();
        self.held.extend(self.delassus.contacts().map(|i| (pair_of(&contacts[i]), i as u32)));
        self.held.sort_unstable();
        let (mut violated, mut held) = (self.violated.as_slice(), self.held.as_slice());
        while let Some((pair, _)) = violated.first().copied() {
            let here = violated.partition_point(|v| v.0 == pair);
            let passed = held.partition_point(|v| v.0 < pair);
            held = &held[passed..];
            let own = held.partition_point(|v| v.0 == pair);
            pick(&violated[..here], &held[..own], &scratch.gaps, (&mut self.reach, &mut self.new));
            violated = &violated[here..];
        }
        self.new.sort_unstable();
    }
}

/// A number for the two things that a contact joins.
fn pair_of(contact: &Contact) -> u64 {
    let thing = |side: &Side| match side {
        Side::Sheet { sheet, .. } => u64::from(*sheet) << 1,
        Side::Body { body, .. } => u64::from(*body) << 1 | 1,
    };
    let (a, b) = (thing(&contact.a), thing(&contact.b));
    a.min(b) << 32 | a.max(b)
}

/// Picks some of the `violated` contacts of a pair, of which those in `held` are active, and appends them to `picks`.
fn pick(violated: &[(u64, u32)], held: &[(u64, u32)], gaps: &Gaps, (reach, picks): (&mut Vec<f64>, &mut Vec<u32>)) {
    let most = FEW.max(held.len() / 2);
    let depth = |k: usize| -gaps.now[violated[k].1 as usize];
    let apart =
        |k: usize, other: u32| gaps.places[violated[k].1 as usize].distance_squared(gaps.places[other as usize]);
    reach.clear();
    reach.resize(violated.len(), f64::INFINITY);
    for (k, reach) in reach.iter_mut().enumerate() {
        *reach = held.iter().fold(*reach, |least, (_, other)| least.min(apart(k, *other)));
    }
    let deeper = |a: &usize, b: &usize| depth(*a).total_cmp(&depth(*b)).then(b.cmp(a));
    let mut next = (0..violated.len()).max_by(deeper);
    let first = picks.len();
    while let Some(picked) = next {
        let contact = violated[picked].1;
        picks.push(contact);
        if picks.len() - first >= most {
            break;
        }
        let mut best = (0.0, None);
        for (k, reach) in reach.iter_mut().enumerate() {
            *reach = reach.min(apart(k, contact));
            let score = *reach * depth(k);
            if score > best.0 {
                best = (score, Some(k));
            }
        }
        next = best.1;
    }
}
