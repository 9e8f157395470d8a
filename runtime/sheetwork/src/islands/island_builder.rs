//! Islands of a step: the sets of awake sheets and dynamic bodies that may meet.
//!
//! Two objects belong to one island when their swept boxes overlap, when one is attached to the
//! other, or when they are dynamic bodies in contact. The speed that bounds the sweep is the
//! largest of the island, since one object can hit another: islands grow until their reach
//! suffices. A sleeping sheet wakes when a moving object may meet it.
//!
//! Objects are numbered: all sheets, then all bodies. The islands are the same whatever the order
//! in which pairs are found.

use crate::contact::step_bodies::StepBodies;
use crate::islands::StepContext;
use crate::islands::broad_phase::{SweepAndPrune, SweptBox};
use crate::islands::settings::{IslandSettings, StepSettings};
use crate::islands::union_find::UnionFind;
use crate::rigid::BodyContact;
use crate::sheet::{Sheet, Status, node_contact};

use glam::DVec3;

const SETTINGS: IslandSettings = StepSettings::DEFAULT.islands;

/// Range of [`IslandBuilder::order`] that one island of awake sheets occupies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IslandRange {
    pub start: u32,
    pub end: u32,
    /// Whether the island consists of one sheet and no dynamic body.
    pub is_lone_sheet: bool,
}

/// Builder of islands, with its memory.
#[derive(Default)]
pub(crate) struct IslandBuilder {
    boxes: Vec<SweptBox>,
    /// Whether each object is an awake sheet or a dynamic body.
    is_active: Vec<bool>,
    sets: UnionFind,
    /// Number of objects in the set of each representative.
    sizes: Vec<u32>,
    sweep: SweepAndPrune,
    pairs: Vec<(u32, u32)>,
    /// Indices of all sheets: those of an island are adjacent and ascending, islands are in the
    /// order of their first sheets.
    pub order: Vec<u32>,
    /// Islands of awake sheets.
    pub islands: Vec<IslandRange>,
}

/// Margin of the broad phase around a sheet beyond the distance from speeds, m.
pub(crate) fn broad_phase_margin(sheet: &Sheet) -> f64 {
    SETTINGS.broad_phase_margin * node_contact::half_thickness(sheet)
}

impl IslandBuilder {
    /// Wake sheets near moving objects, and build the islands.
    pub fn build(
        &mut self,
        sheets: &mut [Sheet],
        context: &StepContext,
        surroundings: &StepBodies,
        body_contacts: &[BodyContact],
    ) {
        let fall = context.field.gravity.length() * context.dt * context.dt;
        self.boxes.clear();
        self.is_active.clear();
        for sheet in sheets.iter_mut() {
            let is_awake = sheet.state.status == Status::Awake;
            let (low, high) = if is_awake { node_contact::moving_box(sheet) } else { node_contact::resting_box(sheet) };
            let reach = if is_awake { sheet.max_speed() * context.dt + fall + broad_phase_margin(sheet) } else { 0.0 };
            self.boxes.push(SweptBox { low, high, reach });
            self.is_active.push(is_awake);
        }
        for body in &surroundings.bodies {
            let speed = body.start.velocity().length().max(body.end.velocity().length());
            let reach = if body.asleep { 0.0 } else { speed * context.dt + fall };
            self.boxes.push(SweptBox { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, reach });
            self.is_active.push(body.start.is_dynamic());
        }
        for part in &surroundings.colliders {
            let whole = &mut self.boxes[sheets.len() + part.body as usize];
            (whole.low, whole.high) = (whole.low.min(part.low), whole.high.max(part.high));
        }
        self.wake_sheets(sheets, context, surroundings);
        self.unite_objects(sheets, body_contacts, context.sheets_meet);
        self.order_sheets(sheets.len());
    }

    /// Wake sleeping sheets that are moved by a prescribed attachment or an attached body, or may
    /// meet a moving object, until no further one does.
    fn wake_sheets(&mut self, sheets: &mut [Sheet], context: &StepContext, surroundings: &StepBodies) {
        let count = sheets.len();
        if sheets.iter().all(|s| s.state.status != Status::Asleep) {
            return;
        }
        let moves = |body: usize| surroundings.bodies[body].moves();
        let end = context.time + context.dt;
        let mut woken: Vec<u32> = Vec::new();
        for (i, sheet) in sheets.iter().enumerate().filter(|(_, s)| s.state.status == Status::Asleep) {
            let is_led = sheet.pins.moves_between(context.time, end);
            if is_led || sheet.pins.dynamic_attachments().any(|(_, body, _)| moves(body)) {
                woken.push(i as u32);
            }
        }
        loop {
            for i in woken.drain(..).map(|i| i as usize) {
                sheets[i].wake();
                self.is_active[i] = true;
                let fall = context.field.gravity.length() * context.dt * context.dt;
                self.boxes[i].reach = fall + broad_phase_margin(&sheets[i]);
            }
            self.sweep.clear();
            for (i, sheet) in sheets.iter().enumerate() {
                if self.is_active[i] || sheet.state.status == Status::Asleep {
                    self.sweep.push(i, &self.boxes[i], self.is_active[i]);
                }
            }
            for body in (0..surroundings.bodies.len()).filter(|body| moves(*body)) {
                self.sweep.push(count + body, &self.boxes[count + body], true);
            }
            let (boxes, is_active) = (&self.boxes, &self.is_active);
            self.sweep.for_each_pair(|a, b| {
                // The smaller index is a sheet's if one of the two is asleep.
                for (sleeper, other) in [(a, b), (b, a)] {
                    let is_asleep = sleeper < count && !is_active[sleeper];
                    if is_asleep && (other >= count || is_active[other]) && boxes[sleeper].may_meet(&boxes[other]) {
                        woken.push(sleeper as u32);
                    }
                }
            });
            woken.sort_unstable();
            woken.dedup();
            if woken.is_empty() {
                return;
            }
        }
    }

    /// Unite objects that may meet or are attached.
    fn unite_objects(&mut self, sheets: &[Sheet], body_contacts: &[BodyContact], sheets_meet: bool) {
        let (count, all) = (sheets.len(), self.boxes.len());
        self.sets.reset(all);
        for c in body_contacts {
            if self.is_active[count + c.a] && self.is_active[count + c.b] {
                self.sets.unite(count + c.a, count + c.b);
            }
        }
        for i in (0..count).filter(|i| self.is_active[*i]) {
            for (_, body, _) in sheets[i].pins.dynamic_attachments() {
                self.sets.unite(i, count + body);
            }
        }
        for _ in 0..SETTINGS.maximum_growth_iterations {
            if !self.unite_meeting_pairs(count, sheets_meet) {
                break;
            }
            for i in (0..all).filter(|i| self.is_active[*i]) {
                let root = self.sets.find(i);
                self.boxes[root].reach = self.boxes[root].reach.max(self.boxes[i].reach);
            }
            for i in (0..all).filter(|i| self.is_active[*i]) {
                self.boxes[i].reach = self.boxes[self.sets.find(i)].reach;
            }
        }
        self.sizes.clear();
        self.sizes.resize(all, 0);
        for i in (0..all).filter(|i| self.is_active[*i]) {
            let root = self.sets.find(i);
            self.sizes[root] += 1;
        }
    }

    /// Unite the pairs that may meet with their present reach. Returns whether an island grew.
    fn unite_meeting_pairs(&mut self, count: usize, sheets_meet: bool) -> bool {
        self.sweep.clear();
        for i in (0..self.boxes.len()).filter(|i| self.is_active[*i]) {
            // Contacts between bodies are known from Rapier.
            self.sweep.push(i, &self.boxes[i], i < count);
        }
        let (boxes, pairs) = (&self.boxes, &mut self.pairs);
        pairs.clear();
        self.sweep.for_each_pair(|a, b| {
            if (sheets_meet || b >= count) && boxes[a].may_meet(&boxes[b]) {
                pairs.push((a as u32, b as u32));
            }
        });
        let mut has_grown = false;
        for (a, b) in &self.pairs {
            has_grown |= self.sets.unite(*a as usize, *b as usize);
        }
        has_grown
    }

    /// List the sheets island by island.
    fn order_sheets(&mut self, count: usize) {
        self.order.clear();
        self.order.extend(0..count as u32);
        let sets = &mut self.sets;
        self.order.sort_unstable_by_key(|i| (sets.find(*i as usize), *i));
        self.islands.clear();
        let mut start = 0;
        while start < count {
            let root = self.sets.find(self.order[start] as usize);
            let mut end = start + 1;
            while end < count && self.sets.find(self.order[end] as usize) == root {
                end += 1;
            }
            if self.is_active[self.order[start] as usize] {
                let is_lone_sheet = self.sizes[root] == 1;
                self.islands.push(IslandRange { start: start as u32, end: end as u32, is_lone_sheet });
            }
            start = end;
        }
    }
}
