//! One stage of an implicit engine for sheets and bodies that touch.
//!
//! Rounds of: every sheet's free motion, linearised where it is; detection; a position solve, which puts everything that
//! would overlap just apart, with friction against the displacement; until the strain that comes of it is what the
//! linear solve predicted. Then a velocity solve on what is closed, with restitution as of the instant of impact.
//! Position and velocity need a solve each: by one alone a sheet that does not bounce leaves at two thirds of its speed.
//!
//! With α the part of the stage that a pair was apart, friction acts against 1-α of the tangential displacement, and the speed of
//! approach at the impact is (1-α) that at the start plus α the free one at the end. Contacts are made active a few at a
//! time, the deepest first and far from each other: a lying sheet needs some forty of its hundreds.

use glam::DVec3;

use super::coulomb::Law;
use super::delassus::{Delassus, Group};
use super::memory::{Memory, Remembered};
use super::mover::Mover;
use super::row::{Contact, SheetPoint, Side};
use crate::sheet::Field;

/// Violations up to this are let pass, m.
const DEPTH: f64 = 5e-6;
/// A contact this near is closed, m: its velocities are solved for.
const CLOSED: f64 = 1e-5;
/// Accuracy of the sweeps, m, and how many there may be.
const TOLERANCE: f64 = 1e-9;
const SWEEPS: u32 = 200;
/// Contacts made active at a time, at least.
const FEW: usize = 8;
/// Rounds of making more active.
const PASSES: u32 = 40;
/// Rounds of a stage.
pub(crate) const ROUNDS: u32 = 10;
/// Slower approaches do not bounce, m/s: what rests must not hop.
const BOUNCES_ABOVE: f64 = 0.2;

/// What contact has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactCounters {
    /// Rounds of stages that had contact.
    pub rounds: u64,
    /// Contacts made active, over all rounds.
    pub active: u64,
    /// The most at once.
    pub most: u64,
    /// Sweeps over contacts.
    pub sweeps: u64,
    /// Steps that were halved.
    pub halved: u64,
}

/// Arrays of a contact problem, kept from step to step.
#[derive(Default)]
pub(crate) struct Scratch {
    /// What may touch in this round.
    pub contacts: Vec<Contact>,
    /// Contacts from this number on are glue.
    pub glue_from: usize,
    delassus: Delassus,
    pub memory: Memory,
    /// Gap of each contact without contact forces and with those of the last solve, m.
    free_gap: Vec<f64>,
    gap: Vec<f64>,
    /// Gap at the start of the stage, along the normal of now, m.
    start_gap: Vec<f64>,
    is_active: Vec<bool>,
    new: Vec<u32>,
    b: Vec<DVec3>,
    reach: Vec<f64>,
    places: Vec<DVec3>,
    pub movers: Vec<Mover>,
    kept_memory: Memory,
    kept_movers: Vec<Mover>,
    pub counters: ContactCounters,
    /// Largest change in the last sweep of the last position solve, m.
    pub residual: f64,
}

/// Which positions of a group a point is wanted at.
#[derive(Clone, Copy)]
enum At {
    Start,
    Free,
}

fn place(group: &Group, side: &Side, at: At) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.of(if matches!(at, At::Start) { &sheet.x } else { &sheet.work.stage.free })
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            if matches!(at, At::Start) { mover.start.place(*local) } else { mover.free.place(*local) }
        }
    }
}

/// How far contact moves a side, m.
fn moved(group: &Group, side: &Side) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            if sheet.work.unit.is_touched() { point.of(&sheet.work.unit.jump.dx) } else { DVec3::ZERO }
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            mover.moved(mover.free.place(*local) - mover.centre[1])
        }
    }
}

/// Velocity of a side at the start of the stage, or at its end without contact, m/s.
fn velocity(group: &Group, side: &Side, at: At) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.of(if matches!(at, At::Start) { &sheet.v } else { &sheet.work.stage.velocity })
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            let i = usize::from(matches!(at, At::Free));
            let frame = if i == 0 { &mover.start } else { &mover.free };
            mover.linear[i] + mover.angular[i].cross(frame.place(*local) - mover.centre[i])
        }
    }
}

impl Scratch {
    /// Keeps what a step that is taken back must find again.
    pub fn keep(&mut self, movers: &[Mover]) {
        self.kept_memory.copy_from(&self.memory);
        self.kept_movers.clear();
        self.kept_movers.extend_from_slice(movers);
    }

    /// Comes back to what was kept.
    pub fn put_back(&mut self, movers: &mut Vec<Mover>) {
        self.memory.copy_from(&self.kept_memory);
        movers.clear();
        movers.extend_from_slice(&self.kept_movers);
    }

    /// Puts apart what would overlap after the free motion, with weight `h` (s) of the stage: leaves displacements in the
    /// units of the sheets and in the movers. False when nothing overlaps.
    pub fn solve_positions(&mut self, group: &mut Group, h: f64) -> bool {
        self.measure(group);
        if !self.begin_positions(group, h) {
            return false;
        }
        let mut swept = Default::default();
        for _ in 0..PASSES {
            swept = self.sweep_positions(group);
            self.delassus.displace(group, &self.contacts, h);
            self.update_gaps(group);
            self.pick_violated();
            if self.new.is_empty() {
                break;
            }
            self.activate(group, h);
        }
        self.residual = swept.change;
        let (active, count) = (&self.delassus, self.delassus.problem.len() as u64);
        let forces = active.contacts().enumerate().map(|(i, c)| {
            let key = self.contacts[c].key;
            let velocity = self.memory.of(&key).unwrap_or_default().velocity;
            (key, Remembered { position: active.frame(i) * active.problem.force[i], velocity })
        });
        let forces: Vec<_> = forces.filter(|(_, f)| f.position != DVec3::ZERO).collect();
        self.memory.replace(forces.into_iter());
        self.counters.rounds += 1;
        self.counters.active += count;
        self.counters.most = self.counters.most.max(count);
        true
    }

    /// Gaps of all contacts at the start of the stage and after the free motion.
    fn measure(&mut self, group: &Group) {
        self.free_gap.clear();
        self.start_gap.clear();
        self.places.clear();
        for contact in &self.contacts {
            let (a, b) = (place(group, &contact.a, At::Free), place(group, &contact.b, At::Free));
            self.free_gap.push(contact.normal.dot(a - b) - contact.offset);
            let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
            self.start_gap.push(contact.normal.dot(start) - contact.offset);
            self.places.push(a);
        }
        self.gap.clone_from(&self.free_gap);
        self.is_active.clear();
        self.is_active.resize(self.contacts.len(), false);
    }

    /// Begins with what was active before and still is, and with glue; else with the deepest few.
    fn begin_positions(&mut self, group: &mut Group, h: f64) -> bool {
        let glued = self.glue_from < self.contacts.len();
        if !glued && self.free_gap.iter().all(|g| *g >= 0.0) {
            return false;
        }
        self.delassus.clear(group);
        self.new.clear();
        for (i, contact) in self.contacts.iter().enumerate() {
            let was = self.free_gap[i] < 0.0 && self.memory.of(&contact.key).is_some();
            if i >= self.glue_from || was {
                self.new.push(i as u32);
            }
        }
        if self.new.is_empty() {
            self.pick_violated();
            if self.new.is_empty() {
                // Shallower than what is let pass, but a beginning: the deepest.
                let deepest = (0..self.gap.len()).min_by(|a, b| self.gap[*a].total_cmp(&self.gap[*b]));
                self.new.extend(deepest.map(|i| i as u32));
            }
        }
        self.activate(group, h);
        true
    }

    /// Makes the contacts in `new` active.
    fn activate(&mut self, group: &mut Group, h: f64) {
        for number in &self.new {
            let i = *number as usize;
            let contact = &self.contacts[i];
            self.is_active[i] = true;
            let glue = i >= self.glue_from;
            let law = if glue { Law::Glue } else { Law::Coulomb(contact.friction) };
            let force = self.memory.of(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            self.delassus.problem.push(law, super::delassus::frame_of(contact.normal).transpose() * force);
        }
        let new = std::mem::take(&mut self.new);
        self.delassus.add(group, &self.contacts, &new, h);
        self.new = new;
    }

    /// Part of the stage that contact `i` was apart.
    fn airborne(&self, i: usize) -> f64 {
        let (start, end) = (self.start_gap[i], self.free_gap[i]);
        if start > 1e-7 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn sweep_positions(&mut self, group: &Group) -> super::sweeps::Swept {
        self.b.clear();
        for (k, i) in self.delassus.contacts().enumerate() {
            let contact = &self.contacts[i];
            let frame = self.delassus.frame(k);
            let end = place(group, &contact.a, At::Free) - place(group, &contact.b, At::Free);
            if i >= self.glue_from {
                self.b.push(frame.transpose() * end);
                continue;
            }
            let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
            let along = frame.transpose() * (end - start) * (1.0 - self.airborne(i));
            self.b.push(DVec3::new(self.free_gap[i], along.y, along.z));
        }
        let swept = self.delassus.problem.solve(&self.b, TOLERANCE, SWEEPS);
        self.counters.sweeps += u64::from(swept.sweeps);
        swept
    }

    fn update_gaps(&mut self, group: &Group) {
        for (i, contact) in self.contacts.iter().enumerate() {
            let by = moved(group, &contact.a) - moved(group, &contact.b);
            self.gap[i] = self.free_gap[i] + contact.normal.dot(by);
        }
    }

    /// Picks contacts that are violated and not active: the deepest, then those deep and far from the ones picked.
    fn pick_violated(&mut self) {
        self.new.clear();
        self.reach.clear();
        let violated = |i: usize, gap: &[f64], active: &[bool]| gap[i] < -DEPTH && !active[i];
        let count = self.contacts.len();
        let most = FEW.max(self.delassus.problem.len() / 3);
        let mut next = (0..count).filter(|i| violated(*i, &self.gap, &self.is_active)).min_by(|a, b| {
            self.gap[*a].total_cmp(&self.gap[*b]).then(self.contacts[*a].key.cmp(&self.contacts[*b].key))
        });
        if next.is_none() {
            return;
        }
        self.reach.resize(count, f64::INFINITY);
        for other in self.delassus.contacts() {
            for i in 0..count {
                self.reach[i] = self.reach[i].min(self.places[i].distance_squared(self.places[other]));
            }
        }
        while let Some(pick) = next {
            self.new.push(pick as u32);
            if self.new.len() >= most {
                break;
            }
            let mut best = (0.0, None);
            for i in 0..count {
                self.reach[i] = self.reach[i].min(self.places[i].distance_squared(self.places[pick]));
                if violated(i, &self.gap, &self.is_active) {
                    let score = self.reach[i] * -self.gap[i];
                    if score > best.0 {
                        best = (score, Some(i));
                    }
                }
            }
            next = best.1;
        }
        self.new.sort_unstable();
    }

    /// Solves for the velocities of what is closed after the last position solve; leaves jumps in the units and movers.
    pub fn solve_velocities(&mut self, group: &mut Group, h: f64) {
        self.b.clear();
        for k in 0..self.delassus.problem.len() {
            let i = self.delassus.contact(k);
            let contact = &self.contacts[i];
            let frame = self.delassus.frame(k);
            let free = velocity(group, &contact.a, At::Free) - velocity(group, &contact.b, At::Free);
            let mut b = frame.transpose() * free;
            if i < self.glue_from {
                let start = velocity(group, &contact.a, At::Start) - velocity(group, &contact.b, At::Start);
                let airborne = self.airborne(i);
                let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * b.x;
                if approach < -BOUNCES_ABOVE {
                    b.x += contact.restitution * approach;
                }
                if self.gap[i] > CLOSED {
                    b.x = f64::INFINITY;
                }
            }
            let force = self.memory.of(&contact.key).map_or(DVec3::ZERO, |f| f.velocity);
            self.delassus.problem.force[k] = if b.x == f64::INFINITY { DVec3::ZERO } else { frame.transpose() * force };
            self.b.push(b * h);
        }
        let swept = self.delassus.problem.solve(&self.b, TOLERANCE, SWEEPS);
        self.counters.sweeps += u64::from(swept.sweeps);
        self.delassus.kick(group, &self.contacts, h);
        let entries: Vec<_> = self
            .delassus
            .contacts()
            .enumerate()
            .map(|(k, i)| {
                let key = self.contacts[i].key;
                let position = self.memory.of(&key).unwrap_or_default().position;
                (key, Remembered { position, velocity: self.delassus.frame(k) * self.delassus.problem.force[k] })
            })
            .filter(|(_, f)| f.position != DVec3::ZERO)
            .collect();
        self.memory.replace(entries.into_iter());
    }

    /// Calls `touched` for every contact that is closed: on which sheets and masses, and with which body.
    pub fn closed(&self, mut touched: impl FnMut(&Contact)) {
        for (contact, _) in self.contacts.iter().zip(&self.gap).filter(|(_, gap)| **gap < 2.0 * CLOSED) {
            touched(contact);
        }
    }
}

/// Takes every sheet of `group` through its stage's rounds: `find` writes what may touch, given the group with the free motions in
/// it. False when a sheet could not be solved for, or the rounds did not come together.
pub(crate) fn solve_rounds(
    group: &mut Group,
    scratch: &mut Scratch,
    field: Field,
    h: f64,
    mut find: impl FnMut(&Group, u32, &mut Vec<Contact>),
) -> Rounds {
    let mut touched = false;
    for round in 0..ROUNDS {
        group.each(|sheet| {
            if !sheet.work.stage.done && !sheet.free_motion(field) {
                sheet.work.stage.failed = true;
            }
        });
        if group.members.iter().any(|i| group.sheets[*i as usize].work.stage.failed) {
            return Rounds::Failed;
        }
        find(group, round, &mut scratch.contacts);
        scratch.glue_from = scratch.contacts.len();
        touched = scratch.solve_positions(group, h);
        group.each(|sheet| {
            let unit = std::mem::take(&mut sheet.work.unit);
            let contact = (touched && unit.is_touched()).then_some(&unit.jump.dx);
            sheet.accept(field, contact);
            sheet.work.unit = unit;
        });
        if group.members.iter().all(|i| group.sheets[*i as usize].work.stage.done) {
            return if touched { Rounds::Touched } else { Rounds::Free };
        }
    }
    if touched { Rounds::Failed } else { Rounds::Unsettled }
}

/// How the rounds of a stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounds {
    /// Settled, nothing touched.
    Free,
    /// Settled, with contact.
    Touched,
    /// Nothing touched, and not settled.
    Unsettled,
    /// Not settled, with contact.
    Failed,
}

/// The point of a sheet that is mass `i`.
pub(crate) fn mass_point(sheet: u32, i: u32) -> Side {
    Side::Sheet { sheet, point: SheetPoint::mass(i) }
}
