//! Island manager: builds the islands of a step, steps them in parallel, and keeps their state.
//!
//! The sheets of an island are brought together in the list of sheets for the step, so that each
//! island works on a slice of its own, and put back afterwards. Islands share nothing that changes;
//! results do not depend on the number of threads.

use crate::collision::narrow_phase::DetectionCounters;
use crate::contact::step_bodies::StepBodies;
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{ContactCounters, SheetContact};
use crate::islands::contact_log::ContactLog;
use crate::islands::island_builder::{IslandBuilder, IslandRange};
use crate::islands::island_detection::DetectionCache;
use crate::islands::island_progress::IslandProgress;
use crate::islands::step_report::{StepOutcome, StepReport};
use crate::islands::unstable::stop_unstable;
use crate::islands::{StepContext, instability};
use crate::parallel::join;
use crate::profiler::Phase;
use crate::rigid::{BodyContact, BodyState, RigidWorld};
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::sheet::{Sheet, Status, node_contact, stage};

/// A dynamic body that sheets have moved.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum UpdatedBody {
    /// Body of the world, by its index.
    Own(u32),
    /// Lent body, by its index.
    Lent(u32),
}

/// State of a dynamic body after the step of its island.
pub(crate) struct BodyUpdate {
    pub body: UpdatedBody,
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
    /// Report of the last step, and what the next one takes from it.
    pub progress: IslandProgress,
    /// Caches of collision detection.
    pub detection: DetectionCache,
    /// New states of the island's dynamic bodies.
    pub body_updates: Vec<BodyUpdate>,
}

/// Sheets of a step, or of one island, with their contact states, event records and, at the first
/// sheet of an island, the island's state. The slices have equal lengths.
pub(crate) struct SteppedSheets<'a> {
    pub sheets: &'a mut [Sheet],
    pub contacts: &'a mut [SheetContact],
    pub touches: &'a mut [ContactLog],
    pub states: &'a mut [Option<Box<IslandState>>],
}

impl<'a> SteppedSheets<'a> {
    /// The first `count` sheets and the others.
    fn split_at(self, count: usize) -> (Self, Self) {
        let (sheets, other_sheets) = self.sheets.split_at_mut(count);
        let (contacts, other_contacts) = self.contacts.split_at_mut(count);
        let (touches, other_touches) = self.touches.split_at_mut(count);
        let (states, other_states) = self.states.split_at_mut(count);
        let first = Self { sheets, contacts, touches, states };
        let others =
            Self { sheets: other_sheets, contacts: other_contacts, touches: other_touches, states: other_states };
        (first, others)
    }

    fn reborrow(&mut self) -> SteppedSheets<'_> {
        SteppedSheets {
            sheets: &mut *self.sheets,
            contacts: &mut *self.contacts,
            touches: &mut *self.touches,
            states: &mut *self.states,
        }
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.sheets.swap(a, b);
        self.contacts.swap(a, b);
        self.touches.swap(a, b);
        self.states.swap(a, b);
    }
}

/// Builder, stepper and owner of islands.
#[derive(Default)]
pub(crate) struct IslandManager {
    surroundings: StepBodies,
    builder: IslandBuilder,
    /// Exchanges of sheets that bring the islands together.
    exchanges: Vec<(u32, u32)>,
    pub body_updates: Vec<BodyUpdate>,
    /// Report of the last step.
    pub report: StepReport,
    /// State of the islands of the last steps, by the index of their first sheet.
    states: Vec<Option<Box<IslandState>>>,
}

/// Inputs that all islands share in a step.
pub(crate) struct IslandContext<'a> {
    pub context: &'a StepContext<'a>,
    pub surroundings: &'a StepBodies,
    pub body_contacts: &'a [BodyContact],
    /// Index in the world of each sheet, by its place in the step.
    order: &'a [u32],
    /// Whether islands are stepped in parallel.
    parallel: bool,
}

impl IslandManager {
    /// Step all sheets.
    pub fn step(
        &mut self,
        (sheets, contacts, touches): (&mut [Sheet], &mut [SheetContact], &mut [ContactLog]),
        context: &StepContext,
        rigid: Option<&RigidWorld>,
        parallel: bool,
    ) {
        self.states.resize_with(sheets.len(), || None);
        self.body_updates.clear();
        self.report = StepReport::default();
        if is_everything_resting(sheets, context, rigid) {
            return;
        }
        match context.view {
            Some(view) => {
                let (bodies, span) = ((rigid, context.lent), (context.dt, context.field.gravity));
                context.profiler.measure(Phase::Islands, || self.surroundings.update(view, bodies, span));
            }
            None => {
                self.surroundings.colliders.clear();
                self.surroundings.bodies.clear();
            }
        }
        stop_non_finite(sheets, touches, context);
        instability::update_policies(sheets, touches, context);
        let body_contacts = rigid.map_or(&[][..], RigidWorld::body_contacts);
        let Self { surroundings, builder, exchanges, body_updates, report, states } = self;
        context.profiler.measure(Phase::Islands, || builder.build(sheets, context, surroundings, body_contacts));
        let mut all = SteppedSheets { sheets, contacts, touches, states };
        exchanges_to(&builder.order, exchanges);
        exchanges.iter().for_each(|(a, b)| all.swap(*a as usize, *b as usize));
        let context = IslandContext { context, surroundings, body_contacts, order: &builder.order, parallel };
        context.step_islands(&builder.islands, 0, all.reborrow());
        for island in &builder.islands {
            if let Some(state) = &mut all.states[island.start as usize] {
                body_updates.append(&mut state.body_updates);
                report.add(&state.progress.report);
                let is_uncertain =
                    state.progress.report.outcome() > StepOutcome::Bisected || state.progress.starts_in_something;
                let range = island.start as usize..island.end as usize;
                all.sheets[range].iter_mut().for_each(|sheet| sheet.work.is_contact_uncertain = is_uncertain);
            }
        }
        exchanges.drain(..).rev().for_each(|(a, b)| all.swap(a as usize, b as usize));
    }

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

    /// Remove the sheet `index`: the sheets behind it move up, also in the caches that name sheets
    /// by their index.
    pub fn remove_sheet(&mut self, index: usize) {
        if index < self.states.len() {
            self.states.remove(index);
        }
        for state in self.states.iter_mut().flatten() {
            state.detection.finder.remove_sheet(index as u32);
            state.contact.remove_sheet(index as u32);
        }
    }

    /// Discard the states in which the sheet `index` occurs, and the contacts of their first
    /// sheets.
    pub fn forget_sheet(&mut self, index: usize, contacts: &mut [SheetContact]) {
        for (i, contact) in contacts.iter_mut().enumerate() {
            let knows = self.state(i).is_some_and(|state| state.detection.finder.has_sheet(index as u32));
            if i == index || knows {
                self.states.get_mut(i).iter_mut().for_each(|state| **state = None);
                contact.response.remove_contacts();
            }
        }
    }

    /// Serialise the states of the islands of `count` sheets.
    pub fn serialise(&self, count: usize, to: &mut StateWriter) {
        for index in 0..count {
            let state = self.state(index);
            to.flag(state.is_some());
            state.iter().for_each(|state| {
                state.contact.serialise(to);
                state.progress.serialise(to);
            });
            state.iter().for_each(|state| state.detection.serialise(to));
        }
    }

    /// Deserialise the output of [`IslandManager::serialise`]; the contact states `contacts` have
    /// their collision surfaces.
    pub fn deserialise(&mut self, contacts: &mut [SheetContact], from: &mut StateReader) -> ReadResult {
        self.states.resize_with(contacts.len(), || None);
        for (index, state) in self.states.iter_mut().enumerate() {
            contacts[index].response.remove_contacts();
            if from.flag()? {
                let state = state.get_or_insert_default();
                state.contact.deserialise(from)?;
                state.progress.deserialise(from)?;
            } else {
                *state = None;
            }
            if let Some(state) = state {
                let surface = |id: u32| contacts.get(id as usize).and_then(|c| c.surface.as_deref());
                state.detection = DetectionCache::deserialise(from, surface)?;
            }
        }
        Ok(())
    }
}

/// Exchanges that move every sheet to its place in `order`.
fn exchanges_to(order: &[u32], exchanges: &mut Vec<(u32, u32)>) {
    exchanges.clear();
    for place in 0..order.len() {
        // Places before this one are final: a sheet that stood there went where its own exchange
        // sent it.
        let mut from = order[place] as usize;
        while from < place {
            from = order[from] as usize;
        }
        if from != place {
            exchanges.push((place as u32, from as u32));
        }
    }
}

/// Whether no sheet is awake and nothing moves that could wake one.
fn is_everything_resting(sheets: &[Sheet], context: &StepContext, rigid: Option<&RigidWorld>) -> bool {
    let led = |s: &Sheet| !s.pins.is_empty() && s.pins.moves_between(context.time, context.time + context.dt);
    let quiet = context.view.is_none() || rigid.is_some_and(|r| r.all_asleep() && !r.has_kinematic());
    quiet && sheets.iter().all(|s| s.state.status != Status::Awake && !led(s))
}

/// Stop sheets of implicit integrators with non-finite velocities.
fn stop_non_finite(sheets: &mut [Sheet], touches: &mut [ContactLog], context: &StepContext) {
    for (sheet, touches) in sheets.iter_mut().zip(touches) {
        if sheet.state.status == Status::Awake && stage::stages(sheet) > 0 && !sheet.state.v.max_squared().is_finite() {
            node_contact::resize_workspace(sheet);
            sheet.work.x_before.copy_from(&sheet.state.x);
            stop_unstable(sheet, touches, context, context.dt);
        }
    }
}

impl IslandContext<'_> {
    /// Step `islands`, whose sheets are in `all` from place `offset` on; in parallel if enabled.
    fn step_islands(&self, islands: &[IslandRange], offset: usize, all: SteppedSheets) {
        match islands {
            [] => {}
            [island] => {
                let (start, end) = (island.start as usize, island.end as usize);
                let (_, from_start) = all.split_at(start - offset);
                let (own, _) = from_start.split_at(end - start);
                self.step(own, &self.order[start..end], self.parallel && !island.is_lone_sheet);
            }
            _ => {
                let (first, others) = islands.split_at(islands.len() / 2);
                let cut = others[0].start as usize;
                let (low, high) = all.split_at(cut - offset);
                if self.parallel {
                    join(|| self.step_islands(first, offset, low), || self.step_islands(others, cut, high));
                } else {
                    self.step_islands(first, offset, low);
                    self.step_islands(others, cut, high);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exchanges_put_every_sheet_in_its_place() {
        for order in
            [vec![0, 1, 2], vec![2, 0, 1], vec![0, 3, 1, 4, 2, 5], vec![5, 4, 3, 2, 1, 0], vec![0, 5, 1, 2, 3, 4]]
        {
            let mut exchanges = Vec::new();
            exchanges_to(&order, &mut exchanges);
            let mut list: Vec<u32> = (0..order.len() as u32).collect();
            exchanges.iter().for_each(|(a, b)| list.swap(*a as usize, *b as usize));
            assert_eq!(list, order);
        }
    }
}
