//! Which sheets and bodies may touch in a step, and the step of each such group.
//!
//! Two are of one group when the boxes that they may sweep meet, or when bodies that move freely touch one another. The
//! speed with which a thing may move is the largest of its group, since one may hit the other. Groups of one sheet with
//! nothing that gives way are stepped side by side, the others one after the other. A group in which one engine is explicit
//! is stepped as such engines are (`explicit`): its steps are as short as that one needs.

use glam::DVec3;
use rayon::prelude::*;

use crate::collision::constraint::Side;
use crate::contact::Group;
use crate::contact::adhesion::stick;
use crate::contact::solver_body::Mover;
use crate::contact::stage::Scratch;
use crate::contact::step_bodies::Surroundings;
use crate::islands::event::{EventKind, Recorder, Touches};
use crate::islands::implicit_step::{Part, advance};
use crate::islands::island_detection::{Near, NearWork, skin};
use crate::islands::{SLEEP_SPEED, Stage, give_up, instability, is_unstable, note_rest, size_work};
use crate::profiler::Phase;
use crate::rigid::{BodyContact, BodyState, RigidWorld};
use crate::sheet::{Crossing, Sheet, Status};

/// Room beyond what speeds say, m.
const ROOM: f64 = 1e-3;
/// Rounds of letting groups grow by their largest speed.
const GROWING: u32 = 4;

/// Steps on end in which contact is given up after which it is looked whether sheets have come to go through one another.
const STUCK: u32 = 20;

/// What a step did to a body of the world's own that moves freely.
pub(crate) struct Claim {
    pub body: usize,
    pub end: BodyState,
    /// Distance of its furthest point from its centre of mass, m.
    pub extent: f64,
    /// Whether it came to rest with its group.
    pub sleeps: bool,
}

/// Finds groups and steps them.
#[derive(Default)]
pub(crate) struct Groups {
    surroundings: Surroundings,
    /// Of every sheet and then of every body, another of its group; the first of a group itself.
    root: Vec<u32>,
    low: Vec<DVec3>,
    high: Vec<DVec3>,
    /// How far each may move in the step, m.
    reach: Vec<f64>,
    /// Whether each takes part: awake sheets, bodies that move freely; and the numbers of those that do, in order.
    takes_part: Vec<bool>,
    active: Vec<u32>,
    /// How many are of the group of each that is the first of one.
    sizes: Vec<u32>,
    members: Vec<u32>,
    pub claims: Vec<Claim>,
}

/// What all groups share in a step.
pub(crate) struct Shared<'a> {
    pub stage: &'a Stage<'a>,
    pub surroundings: &'a Surroundings,
    pub body_contacts: &'a [BodyContact],
}

impl Groups {
    /// Steps all sheets.
    pub fn step(
        &mut self,
        sheets: &mut [Sheet],
        touches: &mut [Touches],
        stage: &Stage,
        rigid: Option<&RigidWorld>,
        parallel: bool,
    ) {
        self.claims.clear();
        if is_still_life(sheets, stage, rigid) {
            return;
        }
        match stage.view {
            Some(view) => {
                stage.watch.within(Phase::Detection, || self.surroundings.update(view, rigid, stage.dt));
            }
            None => {
                self.surroundings.parts.clear();
                self.surroundings.bodies.clear();
            }
        }
        stop_broken(sheets, touches, stage);
        instability::begin(sheets, touches, stage);
        let body_contacts = rigid.map_or(&[][..], RigidWorld::body_contacts);
        stage.watch.within(Phase::Detection, || self.find(sheets, touches, stage, body_contacts));
        let shared = Shared { stage, surroundings: &self.surroundings, body_contacts };
        let (root, takes_part) = (&self.root, &self.takes_part);
        let (count, sizes) = (sheets.len(), &self.sizes);
        let alone = |i: usize| takes_part[i] && root[i] == i as u32 && sizes[i] == 1;
        let one = |(i, (sheet, touches)): (usize, (&mut Sheet, &mut Touches))| {
            if alone(i) {
                let sheets = std::slice::from_mut(sheet);
                shared.step(sheets, std::slice::from_mut(touches), &[0], i as u32, false, &mut Vec::new());
            }
        };
        if parallel && count > 1 {
            sheets.par_iter_mut().zip(touches.par_iter_mut()).enumerate().for_each(one);
        } else {
            sheets.iter_mut().zip(touches.iter_mut()).enumerate().for_each(one);
        }
        let mut members = std::mem::take(&mut self.members);
        for first in self.active.iter().map(|i| *i as usize).take_while(|i| *i < count) {
            if alone(first) {
                continue;
            }
            let with = |i: &usize| takes_part[*i] && root[*i] == root[first];
            if (0..first).any(|i| with(&i)) {
                continue;
            }
            members.clear();
            members.extend((first..count).filter(with).map(|i| i as u32));
            shared.step(sheets, touches, &members, 0, parallel, &mut self.claims);
        }
        self.members = members;
    }

    /// Finds groups, and wakes the sheets that something comes near.
    fn find(&mut self, sheets: &mut [Sheet], touches: &mut [Touches], stage: &Stage, body_contacts: &[BodyContact]) {
        let fall = stage.field.gravity.length() * stage.dt * stage.dt;
        self.low.clear();
        self.high.clear();
        self.reach.clear();
        self.takes_part.clear();
        self.active.clear();
        for (index, sheet) in sheets.iter_mut().enumerate() {
            let moves = sheet.status == Status::Awake;
            let (low, high) = if moves { sheet.surroundings() } else { sheet.resting_box() };
            self.low.push(low);
            self.high.push(high);
            self.takes_part.push(moves);
            if moves {
                self.active.push(index as u32);
            }
            self.reach.push(if moves { sheet.max_speed() * stage.dt + fall + ROOM } else { 0.0 });
        }
        for (index, over) in self.surroundings.bodies.iter().enumerate() {
            let parts = self.surroundings.parts.iter().filter(|p| p.body == index as u32);
            let (low, high) =
                parts.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p.low), high.max(p.high)));
            self.low.push(low);
            self.high.push(high);
            let speed = over.start.velocity().length().max(over.end.velocity().length());
            self.takes_part.push(over.start.gives());
            if over.start.gives() {
                self.active.push((sheets.len() + index) as u32);
            }
            self.reach.push(if over.asleep { 0.0 } else { speed * stage.dt + fall });
        }
        self.wake(sheets, touches, stage);
        self.join(sheets, body_contacts, stage.sheets_meet);
    }

    fn meet(&self, a: usize, b: usize) -> bool {
        let room = self.reach[a] + self.reach[b];
        (self.low[a] - room).cmple(self.high[b]).all() && (self.low[b] - room).cmple(self.high[a]).all()
    }

    /// Wakes sleeping sheets that a led pin moves or a body that they are glued to, or near which something moves.
    fn wake(&mut self, sheets: &mut [Sheet], touches: &mut [Touches], stage: &Stage) {
        let count = sheets.len();
        let mut woken = true;
        while woken {
            woken = false;
            for i in 0..count {
                if sheets[i].status != Status::Asleep {
                    continue;
                }
                let led = sheets[i].pins.moving(stage.time, stage.time + stage.dt);
                let moving = self.active.iter().map(|j| *j as usize).take_while(|j| *j < count);
                let by_sheet = || moving.clone().any(|j| self.meet(i, j));
                let body = |b: usize| self.surroundings.bodies[b].moves() && self.meet(i, count + b);
                let held = || sheets[i].pins.glued().any(|(_, b, _)| self.surroundings.bodies[b].moves());
                if led || held() || by_sheet() || (0..self.surroundings.bodies.len()).any(body) {
                    sheets[i].wake();
                    touches[i].events.push((stage.time, EventKind::Woke, None));
                    self.takes_part[i] = true;
                    let at = self.active.partition_point(|j| (*j as usize) < i);
                    self.active.insert(at, i as u32);
                    self.reach[i] = stage.field.gravity.length() * stage.dt * stage.dt + ROOM;
                    woken = true;
                }
            }
        }
    }

    /// Joins what may touch, and what is glued together.
    fn join(&mut self, all: &[Sheet], body_contacts: &[BodyContact], sheets_meet: bool) {
        let (sheets, count) = (all.len(), self.low.len());
        self.root.clear();
        self.root.extend(0..count as u32);
        self.sizes.clear();
        self.sizes.resize(count, 1);
        if self.active.len() < 2 {
            return;
        }
        for c in body_contacts {
            if self.takes_part[sheets + c.a] && self.takes_part[sheets + c.b] {
                unite(&mut self.root, sheets + c.a, sheets + c.b);
            }
        }
        let active = std::mem::take(&mut self.active);
        for i in active.iter().map(|i| *i as usize).take_while(|i| *i < sheets) {
            for (_, body, _) in all[i].pins.glued() {
                unite(&mut self.root, i, sheets + body);
            }
        }
        for _ in 0..GROWING {
            let mut grown = false;
            for (k, a) in active.iter().map(|a| *a as usize).enumerate() {
                // Which bodies touch one another is known already.
                let others = if a < sheets { &active[k + 1..] } else { &[] };
                for b in others.iter().map(|b| *b as usize) {
                    let new = self.root[a] != self.root[b];
                    if new && (sheets_meet || b >= sheets) && self.meet(a, b) {
                        grown |= unite(&mut self.root, a, b);
                    }
                }
            }
            if !grown {
                break;
            }
            for i in active.iter().map(|i| *i as usize) {
                let root = self.root[i] as usize;
                self.reach[root] = self.reach[root].max(self.reach[i]);
            }
            for i in active.iter().map(|i| *i as usize) {
                self.reach[i] = self.reach[self.root[i] as usize];
            }
        }
        for i in active.iter().map(|i| *i as usize).filter(|i| self.root[*i] as usize != *i) {
            self.sizes[self.root[i] as usize] += 1;
        }
        self.active = active;
    }
}

/// Whether nothing is awake and nothing moves that could wake it.
fn is_still_life(sheets: &[Sheet], stage: &Stage, rigid: Option<&RigidWorld>) -> bool {
    let led = |s: &Sheet| !s.pins.is_empty() && s.pins.moving(stage.time, stage.time + stage.dt);
    let quiet = stage.view.is_none() || rigid.is_some_and(|r| r.is_quiet() && !r.moving());
    quiet && sheets.iter().all(|s| s.status != Status::Awake && !led(s))
}

/// Applies the limits of angles and thickness after a step of `dt` s.
fn limit(sheet: &mut Sheet, dt: f64) {
    if let Some(limit) = &sheet.flexion_limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, dt);
    }
    if let Some(limit) = &sheet.thickness_limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, &sheet.work.touching, dt);
    }
}

/// Stops the sheets of implicit engines into which somebody has put what is no number.
fn stop_broken(sheets: &mut [Sheet], touches: &mut [Touches], stage: &Stage) {
    for (sheet, touches) in sheets.iter_mut().zip(touches) {
        if sheet.status == Status::Awake && sheet.stages() > 0 && !sheet.v.max_squared().is_finite() {
            size_work(sheet);
            sheet.work.x_before.copy_from(&sheet.x);
            give_up(sheet, touches, stage, stage.dt);
        }
    }
}

/// Joins the groups of `a` and `b`; false when they are one.
fn unite(root: &mut [u32], a: usize, b: usize) -> bool {
    let (a, b) = (root[a].min(root[b]), root[a].max(root[b]));
    root.iter_mut().filter(|r| **r == b).for_each(|r| *r = a);
    a != b
}

impl Shared<'_> {
    /// Steps the group of `members` of `sheets`; the first of `sheets` is number `first` of the world's.
    fn step(
        &self,
        sheets: &mut [Sheet],
        touches: &mut [Touches],
        members: &[u32],
        first: u32,
        parallel: bool,
        claims: &mut Vec<Claim>,
    ) {
        let stage = self.stage;
        // Of how a sheet lies before it moves for the first time.
        members.iter().for_each(|i| skin(&mut sheets[*i as usize]));
        if members.iter().any(|i| sheets[*i as usize].is_explicit()) {
            self.step_explicit(sheets, touches, members, first, parallel, claims);
            return;
        }
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            size_work(sheet);
            touches[i].begin(stage.time);
            sheet.work.touching.fill(false);
            sheet.work.met.clear();
            sheet.work.x_before.copy_from(&sheet.x);
            if sheet.guard.is_some() {
                sheet.work.v_before.copy_from(&sheet.v);
            }
        }
        let Some(lead) = members.first().map(|i| *i as usize) else { return };
        members.iter().for_each(|i| sheets[*i as usize].hold_on());
        let mut scratch = sheets[lead].work.contact.take().unwrap_or_default();
        let mut work = sheets[lead].work.near.take().unwrap_or_default();
        let movers = std::mem::take(&mut scratch.movers);
        scratch.watch.clone_from(stage.watch);
        let (around, reach) = self.extent(sheets, members);
        let mut group = Group { sheets, members, movers, parallel, lift: 0.0, leaning: 0 };
        let mut near = Near {
            view: stage.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: stage.field.gravity,
            sheets_meet: stage.sheets_meet,
            first,
            work: &mut work,
            watch: stage.watch,
        };
        near.begin(&mut group, around, reach);
        let part = Part { field: stage.field, time: stage.time, done: 0.0, dt: stage.dt, halvings: 0 };
        let is_idle = near.is_idle(&group);
        if is_idle {
            group.each(|sheet| {
                if !sheet.pins.is_empty() {
                    sheet.pins.lead(stage.time, stage.dt, &sheet.x, &mut sheet.v);
                }
                sheet.advance(stage.field, stage.time, stage.dt);
            });
            scratch.rest();
        } else {
            advance(&mut group, &mut scratch, &mut near, part);
            if scratch.gave_up && !scratch.told {
                members
                    .iter()
                    .for_each(|i| touches[*i as usize].events.push((stage.time + stage.dt, EventKind::GivenUp, None)));
            }
        }
        scratch.stuck = if scratch.gave_up { scratch.stuck + 1 } else { 0 };
        if scratch.stuck >= STUCK {
            scratch.stuck = 0;
            group.each(Sheet::doubt_apart);
        }
        group.each(|sheet| limit(sheet, stage.dt));
        let Group { sheets, movers, .. } = group;
        self.note(sheets, members, &scratch, &work);
        scratch.met.clear();
        stick(sheets, members, &scratch, self.surroundings, work.bodies());
        members.iter().for_each(|i| sheets[*i as usize].hold_no_more());
        self.finish(sheets, touches, members);
        let first_claim = claims.len();
        // Bodies that no sheet can have met go where Rapier takes them.
        if !is_idle {
            self.claim(&movers, &work, &scratch, claims);
        }
        if stage.sleep {
            self.fall_asleep(sheets, touches, members, &mut claims[first_claim..]);
        }
        scratch.movers = movers;
        sheets[lead].work.contact = Some(scratch);
        sheets[lead].work.near = Some(work);
    }

    /// Notes which masses touch, and what; and which have in the step, and bounced.
    pub fn note(&self, sheets: &mut [Sheet], members: &[u32], scratch: &Scratch, work: &NearWork) {
        let handle_of =
            |part: u32| work.part(part).and_then(|p| self.surroundings.parts.get(p as usize)).map(|p| p.handle);
        scratch.closed(|contact, part| {
            let handle = handle_of(part);
            for side in [contact.a, contact.b] {
                if let Side::Sheet { sheet, point } = side {
                    let sheet = &mut sheets[members[sheet as usize] as usize];
                    for (mass, _) in point.terms() {
                        let noted = std::mem::replace(&mut sheet.work.touching[mass as usize], true);
                        // What a sheet met in its own flight is known already.
                        if let Some(handle) = handle.filter(|_| !noted || !sheet.answers_by_mass()) {
                            sheet.work.met.push((handle, mass));
                        }
                    }
                }
            }
        });
        for i in members {
            let work = &mut sheets[*i as usize].work;
            work.met_at_end = work.met.len();
        }
        for [sheet, mass, part] in scratch.met.iter().copied() {
            let work = &mut sheets[members[sheet as usize] as usize].work;
            let noted = std::mem::replace(&mut work.touching[mass as usize], true);
            let Some(handle) = handle_of(part) else { continue };
            // What lies on a floor may have met something else that has gone again.
            let (at_end, added) = work.met.split_at(work.met_at_end);
            let is_new = || !at_end.iter().any(|(known, _)| *known == handle) && !added.contains(&(handle, mass));
            if !noted || is_new() {
                work.met.push((handle, mass));
            }
        }
    }

    /// Says where the bodies that give way have come to.
    pub fn claim(&self, movers: &[Mover], work: &NearWork, scratch: &Scratch, claims: &mut Vec<Claim>) {
        for (number, (mover, index)) in movers.iter().zip(work.bodies()).enumerate() {
            let over = &self.surroundings.bodies[*index as usize];
            if let Some(own) = over.own.filter(|_| mover.gives()) {
                let pull = self.stage.field.gravity * self.stage.dt;
                let resist = |radius| scratch.support_of(number as u32, movers).resist(&mover.start, radius, pull);
                let end = over.ball.map_or(mover.start, resist);
                claims.push(Claim { body: own as usize, end, extent: over.extent, sleeps: false });
            }
        }
    }

    /// Box around the group, thickness included, and how far anything in it may go.
    fn extent(&self, sheets: &[Sheet], members: &[u32]) -> ((DVec3, DVec3), f64) {
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut speed = 0.0_f64;
        for sheet in members.iter().map(|i| &sheets[*i as usize]) {
            let (low, high) = sheet.box_around();
            around = (around.0.min(low), around.1.max(high));
            speed = speed.max(sheet.max_speed());
        }
        // A body in reach may hit the sheets and so set their speed.
        for over in self.surroundings.bodies.iter().filter(|b| b.moves()) {
            speed = speed.max(over.start.velocity().length()).max(over.end.velocity().length());
        }
        let (dt, gravity) = (self.stage.dt, self.stage.field.gravity.length());
        (around, speed * dt + gravity * dt * dt + ROOM)
    }

    /// Looks for sheets that went unstable, puts pins where they belong, and notes what was touched.
    pub fn finish(&self, sheets: &mut [Sheet], touches: &mut [Touches], members: &[u32]) {
        let stage = self.stage;
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            if is_unstable(sheet) || std::mem::take(&mut sheet.work.stage.failed) {
                give_up(sheet, &mut touches[i], stage, stage.dt);
                continue;
            }
            if sheet.crossing == Crossing::Seen {
                sheet.crossing = Crossing::Told;
                touches[i].events.push((stage.time, EventKind::Crossing, None));
            }
            if !sheet.pins.is_empty() {
                sheet.pins.place(stage.time + stage.dt, &mut sheet.x);
            }
            sheet.counters.contacts += sheet.work.met.len() as u64;
            if let Some(view) = stage.view {
                let mut recorder = Recorder { touches: &mut touches[i], view };
                for (handle, mass) in &sheet.work.met {
                    crate::contact::node::detection::Touch::touched(&mut recorder, *handle, *mass as usize);
                }
            }
            touches[i].end(stage.time + stage.dt, sheet);
        }
    }

    /// Puts the group to sleep when all of it has been still for a while.
    pub fn fall_asleep(&self, sheets: &mut [Sheet], touches: &mut [Touches], members: &[u32], claims: &mut [Claim]) {
        let dt = self.stage.dt;
        let mut all = true;
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            if sheet.status != Status::Awake {
                continue;
            }
            // A sheet adrift is not at rest, however slow: something must hold it.
            let touched = !sheet.pins.is_empty() || sheet.work.touching.contains(&true);
            let held = touched && !sheet.is_creeping();
            all &= note_rest(sheet, held, (dt, dt));
        }
        let slow = |c: &Claim| c.end.velocity().length() + c.end.spin().length() * c.extent < SLEEP_SPEED;
        if !all || !claims.iter().all(slow) {
            return;
        }
        for i in members.iter().map(|i| *i as usize) {
            if sheets[i].status != Status::Awake {
                continue;
            }
            sheets[i].status = Status::Asleep;
            sheets[i].v.clear();
            sheets[i].restart_engine();
            touches[i].events.push((self.stage.time + dt, EventKind::AtRest, None));
        }
        claims.iter_mut().for_each(|c| c.sleeps = true);
    }
}
