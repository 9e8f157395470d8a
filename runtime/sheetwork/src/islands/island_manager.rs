//! Islands of sheets and bodies that may touch in a step, and their steps.
//!
//! Two objects belong to one island when their swept boxes overlap, or when they are dynamic bodies
//! in contact. The speed that bounds the sweep is the largest of the island, since one object can
//! hit another. Islands of one sheet without dynamic bodies are stepped in parallel, the others in
//! sequence. An island with a sheet of an explicit integrator is stepped by `explicit`: its time
//! steps are as short as that integrator requires.

use crate::parallel::*;
use glam::DVec3;

use crate::collision::constraint::ContactSide;
use crate::collision::narrow_phase::DetectionCounters;
use crate::contact::ContactCounters;
use crate::contact::adhesion::update_bonds;
use crate::contact::solver_body::SolverBody;
use crate::contact::step_bodies::StepBodies;
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{IslandView, SheetContact};
use crate::islands::event::{ContactLog, ContactRecorder, EventKind};
use crate::islands::implicit_step::{Substep, advance};
use crate::islands::island_detection::{DetectionCache, IslandDetection};
use crate::islands::settings::{IslandSettings, StepSettings};
use crate::islands::{StepContext, instability, is_unstable, stop_unstable, update_rest_time};
use crate::profiler::Phase;
use crate::rigid::{BodyContact, BodyState, RigidWorld};
use crate::scene::sleep::SLEEP;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::{Interpenetration, Sheet, Status};

const SETTINGS: IslandSettings = StepSettings::DEFAULT.islands;

/// State of a dynamic body of the world after the step of its island.
pub(crate) struct BodyUpdate {
    pub body: usize,
    pub end: BodyState,
    /// Distance of the furthest point from the centre of mass, m.
    pub extent: f64,
    /// Whether the body sleeps with its island.
    pub sleeps: bool,
}

/// Contact state that an island takes from step to step, kept under its first sheet.
#[derive(Default)]
pub(crate) struct IslandState {
    /// Workspace and caches of the contact solver.
    pub contact: ContactWorkspace,
    /// Caches of collision detection.
    pub detection: DetectionCache,
}

/// Sheets of a step with their contact states and event records.
pub(crate) struct SteppedSheets<'a> {
    pub sheets: &'a mut [Sheet],
    pub contacts: &'a mut [SheetContact],
    pub touches: &'a mut [ContactLog],
}

/// Builder and stepper of islands.
#[derive(Default)]
pub(crate) struct IslandManager {
    surroundings: StepBodies,
    /// Parent of each sheet, then of each body, in the union-find forest; a root is its own parent.
    root: Vec<u32>,
    low: Vec<DVec3>,
    high: Vec<DVec3>,
    /// Distance that each object may move in the step, m.
    reach: Vec<f64>,
    /// Whether each object is awake and dynamic; and the indices of those that are, ascending.
    takes_part: Vec<bool>,
    active: Vec<u32>,
    /// Number of objects in the island of each root.
    sizes: Vec<u32>,
    members: Vec<u32>,
    pub body_updates: Vec<BodyUpdate>,
    /// State of the islands of the last steps, by the index of their first sheet.
    states: Vec<Option<Box<IslandState>>>,
}

/// Inputs that all islands share in a step.
pub(crate) struct IslandContext<'a> {
    pub stage: &'a StepContext<'a>,
    pub surroundings: &'a StepBodies,
    pub body_contacts: &'a [BodyContact],
}

impl IslandManager {
    /// Step all sheets.
    pub fn step(&mut self, all: SteppedSheets, stage: &StepContext, rigid: Option<&RigidWorld>, parallel: bool) {
        let SteppedSheets { sheets, contacts, touches } = all;
        self.states.resize_with(sheets.len(), || None);
        self.body_updates.clear();
        if is_everything_resting(sheets, stage, rigid) {
            return;
        }
        match stage.view {
            Some(view) => {
                stage.watch.measure(Phase::Detection, || self.surroundings.update(view, rigid, stage.dt));
            }
            None => {
                self.surroundings.colliders.clear();
                self.surroundings.bodies.clear();
            }
        }
        stop_non_finite(sheets, touches, stage);
        instability::update_policies(sheets, touches, stage);
        let body_contacts = rigid.map_or(&[][..], RigidWorld::body_contacts);
        stage.watch.measure(Phase::Detection, || self.build_islands(sheets, touches, stage, body_contacts));
        let shared = IslandContext { stage, surroundings: &self.surroundings, body_contacts };
        let (root, takes_part) = (&self.root, &self.takes_part);
        let (count, sizes) = (sheets.len(), &self.sizes);
        let alone = |i: usize| takes_part[i] && root[i] == i as u32 && sizes[i] == 1;
        let states = &mut self.states;
        type LoneSheet<'a> =
            (((&'a mut Sheet, &'a mut SheetContact), &'a mut ContactLog), &'a mut Option<Box<IslandState>>);
        let one = |(i, (((sheet, contact), touches), state)): (usize, LoneSheet)| {
            if alone(i) {
                let all = SteppedSheets {
                    sheets: std::slice::from_mut(sheet),
                    contacts: std::slice::from_mut(contact),
                    touches: std::slice::from_mut(touches),
                };
                shared.step(all, state, (&[0], i as u32), false, &mut Vec::new());
            }
        };
        if parallel && count > 1 {
            let all = sheets.par_iter_mut().zip(contacts.par_iter_mut()).zip(touches.par_iter_mut());
            all.zip(states.par_iter_mut()).enumerate().for_each(one);
        } else {
            let all = sheets.iter_mut().zip(contacts.iter_mut()).zip(touches.iter_mut());
            all.zip(states.iter_mut()).enumerate().for_each(one);
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
            let all = SteppedSheets { sheets: &mut *sheets, contacts: &mut *contacts, touches: &mut *touches };
            shared.step(all, &mut states[first], (&members, 0), parallel, &mut self.body_updates);
        }
        self.members = members;
    }

    /// Build the islands, and wake sheets near moving objects.
    fn build_islands(
        &mut self,
        sheets: &mut [Sheet],
        touches: &mut [ContactLog],
        stage: &StepContext,
        body_contacts: &[BodyContact],
    ) {
        let fall = stage.field.gravity.length() * stage.dt * stage.dt;
        self.low.clear();
        self.high.clear();
        self.reach.clear();
        self.takes_part.clear();
        self.active.clear();
        for (index, sheet) in sheets.iter_mut().enumerate() {
            let moves = sheet.status == Status::Awake;
            let (low, high) = if moves { sheet.moving_box() } else { sheet.resting_box() };
            self.low.push(low);
            self.high.push(high);
            self.takes_part.push(moves);
            if moves {
                self.active.push(index as u32);
            }
            self.reach.push(if moves {
                sheet.max_speed() * stage.dt + fall + SETTINGS.broad_phase_margin
            } else {
                0.0
            });
        }
        for (index, over) in self.surroundings.bodies.iter().enumerate() {
            let parts = self.surroundings.colliders.iter().filter(|p| p.body == index as u32);
            let (low, high) =
                parts.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p.low), high.max(p.high)));
            self.low.push(low);
            self.high.push(high);
            let speed = over.start.velocity().length().max(over.end.velocity().length());
            self.takes_part.push(over.start.is_dynamic());
            if over.start.is_dynamic() {
                self.active.push((sheets.len() + index) as u32);
            }
            self.reach.push(if over.asleep { 0.0 } else { speed * stage.dt + fall });
        }
        self.wake_islands(sheets, touches, stage);
        self.unite_islands(sheets, body_contacts, stage.sheets_meet);
    }

    fn boxes_overlap(&self, a: usize, b: usize) -> bool {
        let room = self.reach[a] + self.reach[b];
        (self.low[a] - room).cmple(self.high[b]).all() && (self.low[b] - room).cmple(self.high[a]).all()
    }

    /// Wake sleeping sheets that are moved by a prescribed pin or an attached body, or are near a
    /// moving object.
    fn wake_islands(&mut self, sheets: &mut [Sheet], touches: &mut [ContactLog], stage: &StepContext) {
        let count = sheets.len();
        let mut woken = true;
        while woken {
            woken = false;
            for i in 0..count {
                if sheets[i].status != Status::Asleep {
                    continue;
                }
                let led = sheets[i].pins.moves_between(stage.time, stage.time + stage.dt);
                let moving = self.active.iter().map(|j| *j as usize).take_while(|j| *j < count);
                let by_sheet = || moving.clone().any(|j| self.boxes_overlap(i, j));
                let body = |b: usize| self.surroundings.bodies[b].moves() && self.boxes_overlap(i, count + b);
                let held = || sheets[i].pins.dynamic_attachments().any(|(_, b, _)| self.surroundings.bodies[b].moves());
                if led || held() || by_sheet() || (0..self.surroundings.bodies.len()).any(body) {
                    sheets[i].wake();
                    touches[i].events.push((stage.time, EventKind::Woke, None));
                    self.takes_part[i] = true;
                    let at = self.active.partition_point(|j| (*j as usize) < i);
                    self.active.insert(at, i as u32);
                    self.reach[i] = stage.field.gravity.length() * stage.dt * stage.dt + SETTINGS.broad_phase_margin;
                    woken = true;
                }
            }
        }
    }

    /// Unite objects that may touch or are attached.
    fn unite_islands(&mut self, all: &[Sheet], body_contacts: &[BodyContact], sheets_meet: bool) {
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
            for (_, body, _) in all[i].pins.dynamic_attachments() {
                unite(&mut self.root, i, sheets + body);
            }
        }
        for _ in 0..SETTINGS.maximum_growth_iterations {
            let mut grown = false;
            for (k, a) in active.iter().map(|a| *a as usize).enumerate() {
                // Contacts between bodies are known from Rapier.
                let others = if a < sheets { &active[k + 1..] } else { &[] };
                for b in others.iter().map(|b| *b as usize) {
                    let new = self.root[a] != self.root[b];
                    if new && (sheets_meet || b >= sheets) && self.boxes_overlap(a, b) {
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

impl IslandManager {
    /// Counters of collision detection of the island whose first sheet is `index`.
    pub fn detection_counters(&self, index: usize) -> DetectionCounters {
        self.state(index).map(|state| state.detection.counters()).unwrap_or_default()
    }

    /// Counters of the contact solver of the island whose first sheet is `index`.
    pub fn contact_counters(&self, index: usize) -> ContactCounters {
        self.state(index).map(|state| state.contact.counters).unwrap_or_default()
    }

    fn state(&self, index: usize) -> Option<&IslandState> {
        self.states.get(index)?.as_deref()
    }

    /// Remove the sheet `index`: the sheets behind it move up.
    pub fn remove_sheet(&mut self, index: usize) {
        if index < self.states.len() {
            self.states.remove(index);
        }
    }

    /// Discard the states in which the sheet `index` occurs, and the contacts of their first
    /// sheets.
    pub fn forget_sheet(&mut self, index: usize, contacts: &mut [SheetContact]) {
        for (i, contact) in contacts.iter_mut().enumerate() {
            let knows = self.state(i).is_some_and(|state| state.detection.has_cache_for(index as u32));
            if i == index || knows {
                self.states.get_mut(i).iter_mut().for_each(|state| **state = None);
                contact.work.remove_contacts();
            }
        }
    }

    /// Serialise the states of the islands of `count` sheets.
    pub fn serialise(&self, count: usize, to: &mut StateWriter) {
        for index in 0..count {
            let state = self.state(index);
            to.flag(state.is_some());
            state.iter().for_each(|state| state.contact.serialise(to));
            to.flag(state.is_some());
            state.iter().for_each(|state| state.detection.serialise(to));
        }
    }

    /// Deserialise the output of [`IslandManager::serialise`]; the contact states `contacts` have
    /// their collision surfaces.
    pub fn deserialise(&mut self, contacts: &mut [SheetContact], from: &mut StateReader) -> ReadResult {
        self.states.resize_with(contacts.len(), || None);
        for (index, state) in self.states.iter_mut().enumerate() {
            contacts[index].work.remove_contacts();
            if from.flag()? {
                state.get_or_insert_default().contact.deserialise(from)?;
            } else {
                *state = None;
            }
            if from.flag()? != state.is_some() {
                return Err(CorruptState);
            }
            if let Some(state) = state {
                let surface = |id: u32| contacts.get(id as usize).and_then(|c| c.surface.as_deref());
                state.detection = DetectionCache::deserialise(from, surface)?;
            }
        }
        Ok(())
    }
}

/// Whether no sheet is awake and nothing moves that could wake one.
fn is_everything_resting(sheets: &[Sheet], stage: &StepContext, rigid: Option<&RigidWorld>) -> bool {
    let led = |s: &Sheet| !s.pins.is_empty() && s.pins.moves_between(stage.time, stage.time + stage.dt);
    let quiet = stage.view.is_none() || rigid.is_some_and(|r| r.all_asleep() && !r.has_kinematic());
    quiet && sheets.iter().all(|s| s.status != Status::Awake && !led(s))
}

/// Apply the flexion and thickness limits after a step of `dt` (s).
fn apply_limits(sheet: &mut Sheet, dt: f64) {
    if let Some(limit) = &sheet.flexion.limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, dt);
    }
    if let Some(limit) = &sheet.thickness_limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, &sheet.work.touching, dt);
    }
}

/// Stop sheets of implicit integrators with non-finite velocities.
fn stop_non_finite(sheets: &mut [Sheet], touches: &mut [ContactLog], stage: &StepContext) {
    for (sheet, touches) in sheets.iter_mut().zip(touches) {
        if sheet.status == Status::Awake && sheet.stages() > 0 && !sheet.v.max_squared().is_finite() {
            sheet.resize_workspace();
            sheet.work.x_before.copy_from(&sheet.x);
            stop_unstable(sheet, touches, stage, stage.dt);
        }
    }
}

/// Unite the islands of `a` and `b`. Returns `false` when they are the same island.
fn unite(root: &mut [u32], a: usize, b: usize) -> bool {
    let (a, b) = (root[a].min(root[b]), root[a].max(root[b]));
    root.iter_mut().filter(|r| **r == b).for_each(|r| *r = a);
    a != b
}

impl IslandContext<'_> {
    /// Step the island of `members` of `sheets`; the first of `sheets` has index `first` in the
    /// world.
    fn step(
        &self,
        all: SteppedSheets,
        state: &mut Option<Box<IslandState>>,
        (members, first): (&[u32], u32),
        parallel: bool,
        claims: &mut Vec<BodyUpdate>,
    ) {
        let stage = self.stage;
        let SteppedSheets { sheets, contacts, touches } = all;
        // The collision surface is built from the state before the first motion.
        members.iter().for_each(|i| contacts[*i as usize].prepare_surface(&sheets[*i as usize]));
        if members.iter().any(|i| sheets[*i as usize].is_explicit()) {
            let all = SteppedSheets { sheets, contacts, touches };
            self.step_explicit(all, state, (members, first), parallel, claims);
            return;
        }
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            sheet.resize_workspace();
            touches[i].begin(stage.time);
            sheet.work.touching.fill(false);
            sheet.work.touched_colliders.clear();
            sheet.work.x_before.copy_from(&sheet.x);
            if sheet.recovery.is_some() {
                sheet.work.v_before.copy_from(&sheet.v);
            }
        }
        if members.is_empty() {
            return;
        }
        members.iter().for_each(|i| sheets[*i as usize].apply_bond_forces());
        let IslandState { contact: scratch, detection: work } = &mut **state.get_or_insert_default();
        let movers = std::mem::take(&mut scratch.solver_bodies);
        scratch.profiler.clone_from(stage.watch);
        let (around, reach) = self.extent(sheets, members);
        let mut group = IslandView {
            sheets,
            contacts,
            members,
            solver_bodies: movers,
            parallel,
            body_penetration: 0.0,
            stacked_bodies: 0,
        };
        let mut near = IslandDetection {
            view: stage.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: stage.field.gravity,
            sheets_meet: stage.sheets_meet,
            first,
            work: &mut *work,
            watch: stage.watch,
        };
        near.begin(&mut group, around, reach);
        let part = Substep { field: stage.field, time: stage.time, done: 0.0, dt: stage.dt, bisections: 0 };
        let is_idle = near.is_idle(&group);
        if is_idle {
            group.for_each_sheet(|sheet| {
                if !sheet.pins.is_empty() {
                    sheet.pins.prescribe_velocities(stage.time, stage.dt, &sheet.x, &mut sheet.v);
                }
                sheet.advance(stage.field, stage.time, stage.dt);
            });
            scratch.reset();
        } else {
            advance(&mut group, scratch, &mut near, part);
            if scratch.used_fallback && !scratch.used_fallback_before {
                members
                    .iter()
                    .for_each(|i| touches[*i as usize].events.push((stage.time + stage.dt, EventKind::GivenUp, None)));
            }
        }
        scratch.consecutive_fallbacks = if scratch.used_fallback { scratch.consecutive_fallbacks + 1 } else { 0 };
        if scratch.consecutive_fallbacks >= SETTINGS.fallbacks_before_overlap_test {
            scratch.consecutive_fallbacks = 0;
            group.for_each_sheet(Sheet::invalidate_interpenetration);
        }
        group.for_each_sheet(|sheet| apply_limits(sheet, stage.dt));
        let IslandView { sheets, solver_bodies: movers, .. } = group;
        self.record_contacts(sheets, members, scratch, work);
        scratch.closed_in_step.clear();
        update_bonds(sheets, members, scratch, self.surroundings, work.bodies());
        members.iter().for_each(|i| sheets[*i as usize].remove_bond_forces());
        self.finish_sheets(sheets, touches, members);
        let first_claim = claims.len();
        // Bodies that cannot have met a sheet move as Rapier computes.
        if !is_idle {
            self.update_bodies(&movers, work, scratch, claims);
        }
        if stage.sleep {
            self.sleep_if_resting(sheets, touches, members, &mut claims[first_claim..]);
        }
        scratch.solver_bodies = movers;
    }

    /// Record the contacts at the end of the step and the contacts with restitution during the
    /// step: touching nodes and touched bodies.
    pub fn record_contacts(
        &self,
        sheets: &mut [Sheet],
        members: &[u32],
        scratch: &ContactWorkspace,
        work: &DetectionCache,
    ) {
        let handle_of =
            |part: u32| work.part(part).and_then(|p| self.surroundings.colliders.get(p as usize)).map(|p| p.handle);
        scratch.for_each_closed(|contact, part| {
            let handle = handle_of(part);
            for side in [contact.a, contact.b] {
                if let ContactSide::Sheet { sheet, point } = side {
                    let sheet = &mut sheets[members[sheet as usize] as usize];
                    for (mass, _) in point.terms() {
                        let noted = std::mem::replace(&mut sheet.work.touching[mass as usize], true);
                        // Contacts of nodes with static bodies were recorded during free flight.
                        if let Some(handle) = handle.filter(|_| !noted || !sheet.solves_node_by_node()) {
                            sheet.work.touched_colliders.push((handle, mass));
                        }
                    }
                }
            }
        });
        for i in members {
            let work = &mut sheets[*i as usize].work;
            work.touched_at_end = work.touched_colliders.len();
        }
        for [sheet, mass, part] in scratch.closed_in_step.iter().copied() {
            let work = &mut sheets[members[sheet as usize] as usize].work;
            let noted = std::mem::replace(&mut work.touching[mass as usize], true);
            let Some(handle) = handle_of(part) else { continue };
            // The list at the end of the step can lack a body from which the node rebounded.
            let (at_end, added) = work.touched_colliders.split_at(work.touched_at_end);
            let is_new = || !at_end.iter().any(|(known, _)| *known == handle) && !added.contains(&(handle, mass));
            if !noted || is_new() {
                work.touched_colliders.push((handle, mass));
            }
        }
    }

    /// Append the new states of the dynamic bodies to `claims`.
    pub fn update_bodies(
        &self,
        movers: &[SolverBody],
        work: &DetectionCache,
        scratch: &ContactWorkspace,
        claims: &mut Vec<BodyUpdate>,
    ) {
        for (number, (mover, index)) in movers.iter().zip(work.bodies()).enumerate() {
            let over = &self.surroundings.bodies[*index as usize];
            if let Some(own) = over.world_index.filter(|_| mover.is_dynamic()) {
                let pull = self.stage.field.gravity * self.stage.dt;
                let resist = |radius| scratch.support_of(number as u32, movers).resist(&mover.start, radius, pull);
                let end = over.ball.map_or(mover.start, resist);
                claims.push(BodyUpdate { body: own as usize, end, extent: over.extent, sleeps: false });
            }
        }
    }

    /// Bounding box of the island, thickness included, and the maximum displacement of its objects,
    /// m.
    fn extent(&self, sheets: &[Sheet], members: &[u32]) -> ((DVec3, DVec3), f64) {
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut speed = 0.0_f64;
        for sheet in members.iter().map(|i| &sheets[*i as usize]) {
            let (low, high) = sheet.bounding_box();
            around = (around.0.min(low), around.1.max(high));
            speed = speed.max(sheet.max_speed());
        }
        // A moving body in reach may hit a sheet and set its speed.
        for over in self.surroundings.bodies.iter().filter(|b| b.moves()) {
            speed = speed.max(over.start.velocity().length()).max(over.end.velocity().length());
        }
        let (dt, gravity) = (self.stage.dt, self.stage.field.gravity.length());
        (around, speed * dt + gravity * dt * dt + SETTINGS.broad_phase_margin)
    }

    /// Stop unstable sheets, place pins, and record touches and events.
    pub fn finish_sheets(&self, sheets: &mut [Sheet], touches: &mut [ContactLog], members: &[u32]) {
        let stage = self.stage;
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            if is_unstable(sheet) || std::mem::take(&mut sheet.work.stage.has_failed) {
                stop_unstable(sheet, &mut touches[i], stage, stage.dt);
                continue;
            }
            if sheet.interpenetration == Interpenetration::Detected {
                sheet.interpenetration = Interpenetration::Reported;
                touches[i].events.push((stage.time, EventKind::Crossing, None));
            }
            if !sheet.pins.is_empty() {
                sheet.pins.prescribe_positions(stage.time + stage.dt, &mut sheet.x);
            }
            sheet.counters.contacts += sheet.work.touched_colliders.len() as u64;
            if let Some(view) = stage.view {
                let mut recorder = ContactRecorder { touches: &mut touches[i], view };
                for (handle, mass) in &sheet.work.touched_colliders {
                    crate::contact::node::detection::TouchListener::touched(&mut recorder, *handle, *mass as usize);
                }
            }
            touches[i].end(stage.time + stage.dt, sheet);
        }
    }

    /// Put the island to sleep when all its objects have been resting for the sleep delay.
    pub fn sleep_if_resting(
        &self,
        sheets: &mut [Sheet],
        touches: &mut [ContactLog],
        members: &[u32],
        claims: &mut [BodyUpdate],
    ) {
        let dt = self.stage.dt;
        let mut all = true;
        for i in members.iter().map(|i| *i as usize) {
            let sheet = &mut sheets[i];
            if sheet.status != Status::Awake {
                continue;
            }
            // Sleeping requires a pin or a contact: a free sheet can drift slowly.
            let touched = !sheet.pins.is_empty() || sheet.work.touching.contains(&true);
            let held = touched && !sheet.is_creeping();
            all &= update_rest_time(sheet, held, (dt, dt));
        }
        let slow = |c: &BodyUpdate| c.end.velocity().length() + c.end.spin().length() * c.extent < SLEEP.speed;
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
