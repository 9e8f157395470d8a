//! One stage of an implicit engine for sheets and bodies that touch.
//!
//! Rounds of: every sheet's free motion, linearised where it is; detection; a position solve, which puts everything that
//! would overlap just apart, with friction against the displacement; until the strain that comes of it is what the
//! linear solve predicted. Then a velocity solve on what is closed, with restitution as of the instant of impact.
//! Position and velocity need a solve each: by one alone a sheet that does not bounce leaves at two thirds of its speed.
//!
//! With α the part of the stage that a pair was apart, friction acts against 1-α of the tangential displacement, and the
//! speed of approach at the impact is (1-α) that at the start plus α the free one at the end.

use glam::{DMat3, DVec3};

use super::coulomb::Law;
use super::delassus::{Group, frame_of};
use super::dual::{ACCURACY, Dual};
use super::memory::{Memory, Remembered};
use super::mover::Mover;
use super::primal::{Primal, Row, UPDATES};
use super::row::{Contact, Key, SheetPoint, Side};
use super::settled::{self, LOOK};
use crate::sheet::Field;

/// A contact this near is closed, m: its velocities are solved for.
const CLOSED: f64 = 1e-5;
/// Accuracy of gaps on one sheet, m: at the end, and while the sheet itself is still far from where it will be.
const SETTLED: f64 = 2e-8;
const ROUGH: f64 = 1e-5;
/// What comes from further apart than this to overlap by more is an impact, m: gravity alone does less in a stage.
const IMPACT: f64 = 2e-3;
/// What was further apart than this has not been met in the stages before, m.
const FAR: f64 = 1e-3;
/// Weight of a mass in a contact, and cosine between normals, above which two contacts are one.
const ALIKE: f64 = 0.98;
/// Rounds of a stage, and how many more there may be to end with one that touches what others touched.
const ROUNDS: u32 = 10;
const LAST: u32 = 3;
/// Slower approaches do not bounce, m/s: what rests must not hop.
const BOUNCES_ABOVE: f64 = 0.2;

/// What contact has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ContactCounters {
    /// Rounds of stages that had contact.
    pub rounds: u64,
    /// Contacts there were, over all rounds.
    pub contacts: u64,
    /// The most at once.
    pub most: u64,
    /// Solves that did not settle.
    pub unsettled: u64,
    /// Sweeps over contacts.
    pub sweeps: u64,
    /// Newton steps on contacts, and factors they took.
    pub newton: u64,
    /// See `newton`.
    pub factors: u64,
    /// Steps that were halved.
    pub halved: u64,
}

/// What detection found.
#[derive(Default)]
pub(crate) struct Found {
    pub contacts: Vec<Contact>,
    /// Of the contacts with bodies, the part of the group they are with; for as many as there are.
    pub parts: Vec<u32>,
    /// Contacts from this number on are glue.
    pub glue_from: usize,
}

/// Arrays of a contact problem, kept from step to step.
#[derive(Default)]
pub(crate) struct Scratch {
    /// What may touch in this round, and what does where it has come to.
    pub found: Found,
    seen: Found,
    pub memory: Memory,
    pub movers: Vec<Mover>,
    /// Memory of the other stage of a step: forces differ from stage to stage more than from step to step.
    other: Memory,
    stage: usize,
    kept_memory: [Memory; 2],
    kept_movers: Vec<Mover>,
    pub counters: ContactCounters,
    pub(super) gaps: Gaps,
    dual: Dual,
    primal: Primal,
    on_sheet: bool,
    normals: Vec<DVec3>,
    /// Whether a solve did not settle, and whether there is no shorter step to try then.
    pub failed: bool,
    pub last_resort: bool,
    /// Whether the group is of explicit engines.
    pub(super) short_steps: bool,
}

/// How far apart the contacts of a round are.
#[derive(Default)]
pub(super) struct Gaps {
    /// After the free motion, and with the forces of the last solve, m.
    pub free: Vec<f64>,
    pub now: Vec<f64>,
    /// At the start of the stage, along the normal of now, m.
    start: Vec<f64>,
    /// Where side a is after the free motion, m.
    pub places: Vec<DVec3>,
}

impl Gaps {
    fn measure(&mut self, contacts: &[Contact], group: &Group) {
        self.free.clear();
        self.start.clear();
        self.places.clear();
        for contact in contacts {
            let (a, b) = (place(group, &contact.a, At::Free), place(group, &contact.b, At::Free));
            self.free.push(contact.normal.dot(a - b) - contact.offset);
            let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
            self.start.push(contact.normal.dot(start) - contact.offset);
            self.places.push(a);
        }
        self.now.clone_from(&self.free);
    }

    /// Brings `now` up to date with what contact does.
    pub fn update(&mut self, contacts: &[Contact], group: &Group) {
        for (i, contact) in contacts.iter().enumerate() {
            let by = moved(group, &contact.a) - moved(group, &contact.b);
            self.now[i] = self.free[i] + contact.normal.dot(by);
        }
    }

    /// Part of the stage that contact `i` was apart.
    fn airborne(&self, i: usize) -> f64 {
        let (start, end) = (self.start[i], self.free[i]);
        if start > 1e-7 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }
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
            mover.moved(mover.free.place(*local) - mover.free.centre())
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
            let state = if matches!(at, At::Start) { &mover.start } else { &mover.free };
            state.velocity_at(state.place(*local))
        }
    }
}

impl Scratch {
    /// Keeps what a step that is taken back must find again.
    pub fn keep(&mut self, movers: &[Mover]) {
        self.begin_stage(0);
        self.kept_memory[0].copy_from(&self.memory);
        self.kept_memory[1].copy_from(&self.other);
        self.kept_movers.clear();
        self.kept_movers.extend_from_slice(movers);
    }

    /// After a step in which nothing could touch.
    pub fn rest(&mut self) {
        self.found.contacts.clear();
        self.found.parts.clear();
        self.memory.clear();
        self.other.clear();
    }

    /// Begins stage number `k` of a step.
    pub fn begin_stage(&mut self, k: usize) {
        if k.min(1) != self.stage {
            std::mem::swap(&mut self.memory, &mut self.other);
            self.stage = k.min(1);
        }
    }

    /// What is remembered of a contact: of this stage, or of the other one where it is new.
    pub(super) fn remembered(&self, key: &Key) -> Option<Remembered> {
        self.memory.of(key).or_else(|| self.other.of(key))
    }

    /// Comes back to what was kept.
    pub fn put_back(&mut self, movers: &mut Vec<Mover>) {
        self.stage = 0;
        self.memory.copy_from(&self.kept_memory[0]);
        self.other.copy_from(&self.kept_memory[1]);
        movers.clear();
        movers.extend_from_slice(&self.kept_movers);
    }

    /// Puts apart what would overlap after the free motion, with weight `h` (s) of the stage: leaves displacements in the
    /// units of the sheets and in the movers. False when nothing overlaps.
    fn solve_positions(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        self.gaps.measure(&self.found.contacts, group);
        if self.found.glue_from >= self.found.contacts.len() && self.gaps.free.iter().all(|g| *g >= 0.0) {
            return false;
        }
        self.on_sheet = self.fits_one_sheet(group);
        let mut count = self.found.contacts.len();
        if !(self.on_sheet && self.positions_on_sheet(group, rough)) {
            if std::mem::take(&mut self.on_sheet) {
                if !self.last_resort {
                    self.failed = true;
                    return true;
                }
                // Contact stands in the factor.
                group.sheet_mut(0).factorize_with(|_, _| {});
            }
            count = self.positions_between(group, h);
        }
        self.gaps.update(&self.found.contacts, group);
        self.counters.rounds += 1;
        self.counters.contacts += count as u64;
        self.counters.most = self.counters.most.max(count as u64);
        true
    }

    /// Notes along which normal each mass is itself in contact.
    fn note_masses(&mut self, group: &Group) {
        self.normals.clear();
        self.normals.resize(group.sheet(0).masses(), DVec3::ZERO);
        for contact in &self.found.contacts {
            if let Side::Sheet { point, .. } = contact.a
                && point.weights[0] == 1.0
            {
                self.normals[point.masses[0] as usize] = contact.normal;
            }
        }
    }

    /// Whether a contact at `point` only says again what one of its masses says: two such rows would share a force in no
    /// certain way.
    fn is_doubled(&self, point: &SheetPoint, normal: DVec3) -> bool {
        let doubles = |(mass, weight): (u32, f64)| weight > ALIKE && self.normals[mass as usize].dot(normal) > ALIKE;
        point.weights[0] != 1.0 && point.terms().any(doubles)
    }

    /// Whether something that was apart would come to overlap by much, so that the sheet will not be where this round leaves it.
    fn is_impact(&self, group: &Group) -> bool {
        let gap = |c: &Contact, at: At| c.normal.dot(place(group, &c.a, at) - place(group, &c.b, at)) - c.offset;
        self.found.contacts.iter().any(|c| gap(c, At::Free) < -IMPACT && gap(c, At::Start) > IMPACT)
    }

    /// Whether all contacts are of one sheet with bodies that do not give way.
    fn fits_one_sheet(&self, group: &Group) -> bool {
        let Some(tangent) = group.sheet(0).tangent() else { return false };
        let sheet = group.sheet(0);
        let row = |mass: u32| sheet.free_row(mass).map(|(row, _)| row);
        let fits = |contact: &Contact| match (contact.a, contact.b) {
            (Side::Sheet { point, .. }, Side::Body { body, .. }) => {
                let [a, b, c] = point.masses.map(row);
                let joined = |a: Option<u32>, b: Option<u32>| a.zip(b).is_none_or(|(a, b)| tangent.couples(a, b));
                !group.movers[body as usize].gives() && joined(a, b) && joined(b, c) && joined(a, c)
            }
            _ => false,
        };
        group.members.len() == 1 && self.found.contacts.iter().all(fits)
    }

    pub(super) fn law(&self, i: usize) -> Law {
        if i >= self.found.glue_from { Law::Glue } else { Law::Coulomb(self.found.contacts[i].friction) }
    }

    /// u of contact `i` in `frame` after the free motion: its gap, and the displacement that friction acts against, m.
    fn position_of(&self, group: &Group, i: usize, frame: &DMat3) -> DVec3 {
        let contact = &self.found.contacts[i];
        let end = place(group, &contact.a, At::Free) - place(group, &contact.b, At::Free);
        if i >= self.found.glue_from {
            return frame.transpose() * end;
        }
        let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
        let along = frame.transpose() * (end - start) * (1.0 - self.gaps.airborne(i));
        DVec3::new(self.gaps.free[i], along.y, along.z)
    }

    /// u of contact `i` in `frame` after the free motion: its velocity, with what it must bounce, m/s; `None` where it is not closed.
    fn velocity_of(&self, group: &Group, i: usize, frame: &DMat3) -> Option<DVec3> {
        let contact = &self.found.contacts[i];
        let free = velocity(group, &contact.a, At::Free) - velocity(group, &contact.b, At::Free);
        let mut u = frame.transpose() * free;
        if i < self.found.glue_from {
            if self.gaps.now[i] > CLOSED {
                return None;
            }
            let start = velocity(group, &contact.a, At::Start) - velocity(group, &contact.b, At::Start);
            let airborne = self.gaps.airborne(i);
            let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * u.x;
            if approach < -BOUNCES_ABOVE {
                u.x += contact.restitution * approach;
            }
        }
        Some(u)
    }

    fn positions_between(&mut self, group: &mut Group, h: f64) -> usize {
        let mut dual = std::mem::take(&mut self.dual);
        dual.begin(self, group, h);
        let mut rough = true;
        let settled = loop {
            dual.b.clear();
            for k in 0..dual.delassus.problem.len() {
                let u = self.position_of(group, dual.delassus.contact(k), &dual.delassus.frame(k));
                dual.b.push(u);
            }
            // Which contacts there are can be told from forces that are nearly right.
            let swept = if rough { dual.sweep_roughly() } else { dual.sweep() };
            self.counters.sweeps += u64::from(swept.sweeps);
            dual.delassus.displace(group, &self.found.contacts, h);
            self.gaps.update(&self.found.contacts, group);
            if !dual.grow(self, group, h) {
                if !rough || swept.change <= ACCURACY {
                    break swept.change <= ACCURACY;
                }
                rough = false;
            }
        };
        self.counters.unsettled += u64::from(!settled);
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            new.extend(dual.forces().map(|(c, position)| {
                let key = contacts[c].key;
                (key, Remembered { position, velocity: old.of(&key).unwrap_or_default().velocity })
            }));
        });
        self.dual = dual;
        self.dual.delassus.problem.len()
    }

    /// Active contacts of [`Scratch::positions_between`] as they were, solved for velocities.
    fn velocities_between(&mut self, group: &mut Group, h: f64) {
        let mut dual = std::mem::take(&mut self.dual);
        dual.b.clear();
        for k in 0..dual.delassus.problem.len() {
            let i = dual.delassus.contact(k);
            let frame = dual.delassus.frame(k);
            let u = self.velocity_of(group, i, &frame);
            let force = self.remembered(&self.found.contacts[i].key).map_or(DVec3::ZERO, |f| f.velocity);
            dual.delassus.problem.force[k] = if u.is_some() { frame.transpose() * force } else { DVec3::ZERO };
            dual.b.push(u.map_or(DVec3::new(f64::INFINITY, 0.0, 0.0), |u| u * h));
        }
        let swept = dual.sweep();
        self.counters.sweeps += u64::from(swept.sweeps);
        self.counters.unsettled += u64::from(swept.change > ACCURACY);
        dual.delassus.kick(group, &self.found.contacts, h);
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            new.extend(dual.forces().map(|(c, velocity)| {
                let key = contacts[c].key;
                (key, Remembered { position: old.of(&key).unwrap_or_default().position, velocity })
            }));
        });
        self.dual = dual;
    }

    fn positions_on_sheet(&mut self, group: &mut Group, rough: bool) -> bool {
        let mut primal = std::mem::take(&mut self.primal);
        primal.clear();
        self.note_masses(group);
        for (i, contact) in self.found.contacts.iter().enumerate() {
            let Side::Sheet { point, .. } = contact.a else { continue };
            let frame = frame_of(contact.normal);
            let mut row = Row::new(frame, self.law(i));
            for k in 0..3 {
                if let Some((block, free)) = group.sheet(0).free_row(point.masses[k]) {
                    (row.rows[k], row.weights[k], row.free[k]) = (block, point.weights[k], free);
                }
            }
            row.b = self.position_of(group, i, &frame);
            row.new = self.memory.is_empty() || self.gaps.start[i] > FAR;
            row.idle = self.is_doubled(&point, contact.normal);
            let force = self.memory.of(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            primal.rows.push(row);
            primal.force.push(frame.transpose() * force);
        }
        if let Some(tangent) = group.sheet(0).tangent() {
            primal.weigh(&tangent);
        }
        if !self.solve_on_sheet(&mut primal, group, rough) {
            self.primal = primal;
            return false;
        }
        let sheet = group.sheet_mut(0);
        let mut unit = std::mem::take(&mut sheet.work.unit);
        unit.touch(sheet.masses());
        sheet.spread_rows(primal.displacement(), &mut unit.jump.dx);
        for (contact, (row, p)) in self.found.contacts.iter().zip(primal.rows.iter().zip(&primal.force)) {
            if let Side::Sheet { point, .. } = contact.a {
                unit.push(&point, row.frame * *p);
            }
        }
        unit.accelerate(&sheet.inverse_mass);
        sheet.work.unit = unit;
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            for (contact, (row, p)) in contacts.iter().zip(primal.rows.iter().zip(&primal.force)) {
                // What is new pushes in the velocity solve as it does here, for a beginning.
                let position = row.frame * *p;
                let velocity = old.of(&contact.key).map_or(position, |f| f.velocity);
                new.push((contact.key, Remembered { position, velocity }));
            }
        });
        self.primal = primal;
        true
    }

    fn velocities_on_sheet(&mut self, group: &mut Group, h: f64) -> bool {
        let mut primal = std::mem::take(&mut self.primal);
        for (i, contact) in self.found.contacts.iter().enumerate() {
            let frame = primal.rows[i].frame;
            let u = self.velocity_of(group, i, &frame);
            let force = self.memory.of(&contact.key).map_or(DVec3::ZERO, |f| f.velocity);
            primal.force[i] = if u.is_some() { frame.transpose() * force } else { DVec3::ZERO };
            primal.rows[i].b = u.map_or(DVec3::X, |u| u * h);
            primal.rows[i].new = false;
        }
        if !self.solve_on_sheet(&mut primal, group, false) {
            self.primal = primal;
            return false;
        }
        let sheet = group.sheet_mut(0);
        let mut unit = std::mem::take(&mut sheet.work.unit);
        sheet.spread_rows(primal.displacement(), &mut unit.jump.dv);
        unit.jump.dv.axes_mut().into_iter().flatten().for_each(|v| *v /= h);
        sheet.work.unit = unit;
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            for (contact, (row, p)) in contacts.iter().zip(primal.rows.iter().zip(&primal.force)) {
                let position = old.of(&contact.key).unwrap_or_default().position;
                new.push((contact.key, Remembered { position, velocity: row.frame * *p }));
            }
        });
        self.primal = primal;
        true
    }

    fn solve_on_sheet(&mut self, primal: &mut Primal, group: &mut Group, rough: bool) -> bool {
        let before = (primal.steps, primal.factors);
        let (tolerance, updates) = if rough { (ROUGH, 1) } else { (SETTLED, UPDATES) };
        let settled = primal.solve(group.sheet_mut(0), tolerance, updates);
        self.counters.unsettled += u64::from(!settled);
        self.counters.newton += primal.steps - before.0;
        self.counters.factors += primal.factors - before.1;
        settled
    }

    /// Solves for the velocities of what is closed after the last position solve; leaves jumps in the units and movers.
    pub fn solve_velocities(&mut self, group: &mut Group, h: f64) {
        if self.on_sheet && self.velocities_on_sheet(group, h) {
            return;
        }
        if self.on_sheet {
            if !self.last_resort {
                self.failed = true;
                return;
            }
            group.sheet_mut(0).factorize_with(|_, _| {});
            let mut dual = std::mem::take(&mut self.dual);
            dual.begin_closed(self, group, h);
            self.dual = dual;
        }
        self.velocities_between(group, h);
    }

    /// Calls `touched` for every contact that is closed, with the part of the group it is with.
    pub fn closed(&self, mut touched: impl FnMut(&Contact, u32)) {
        let all = self.found.contacts.iter().zip(&self.gaps.now).zip(&self.found.parts);
        for ((contact, _), part) in all.filter(|((_, gap), _)| **gap < 2.0 * CLOSED) {
            touched(contact, *part);
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
    mut find: impl FnMut(&Group, u32, &mut Found),
) -> Rounds {
    // What has touched in any round may be met again: without contact it would go through.
    let mut met = false;
    scratch.short_steps = false;
    for round in 0..ROUNDS + LAST {
        group.each(|sheet| {
            if !sheet.work.stage.done && !sheet.free_motion(field) {
                sheet.work.stage.failed = true;
            }
        });
        if group.members.iter().any(|i| group.sheets[*i as usize].work.stage.failed) {
            return Rounds::Failed;
        }
        find(group, round, &mut scratch.found);
        let rough = round == 0 && scratch.is_impact(group);
        let touched = scratch.solve_positions(group, h, rough);
        met |= touched;
        if scratch.failed {
            return Rounds::Failed;
        }
        group.each(|sheet| {
            let unit = std::mem::take(&mut sheet.work.unit);
            let contact = (touched && unit.is_touched()).then_some(&unit.jump.dx);
            sheet.accept(field, contact);
            sheet.work.unit = unit;
        });
        let mut done = !rough && group.members.iter().all(|i| group.sheets[*i as usize].work.stage.done);
        if done && met && settled::has_moved(group) {
            find(group, LOOK, &mut scratch.seen);
            let contacts = &scratch.seen.contacts;
            done = settled::deepest(group, &contacts[..scratch.seen.glue_from]) <= settled::allowed(round);
            if !done {
                group.each(|sheet| sheet.work.stage.done = false);
            }
        }
        if done {
            return if touched { Rounds::Touched } else { Rounds::Free };
        }
        if round + 1 >= ROUNDS && touched == met {
            return if met { Rounds::Failed } else { Rounds::Unsettled };
        }
    }
    Rounds::Open
}

/// Takes a group of explicit engines, whose free motions are known, through its contact in a step of `h` s: `find` writes what
/// may touch. False when nothing did; else displacements and jumps of velocity are left in the units and movers.
pub(crate) fn solve_masses(
    group: &mut Group,
    scratch: &mut Scratch,
    h: f64,
    find: impl FnOnce(&Group, &mut Found),
) -> bool {
    scratch.short_steps = true;
    find(group, &mut scratch.found);
    let touched = scratch.solve_positions(group, h, false);
    if touched {
        scratch.solve_velocities(group, h);
    }
    touched
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
    /// Not settled, with contact in some round, but not in the last.
    Open,
}

/// The point of a sheet that is mass `i`.
pub(crate) fn mass_point(sheet: u32, i: u32) -> Side {
    Side::Sheet { sheet, point: SheetPoint::mass(i) }
}
