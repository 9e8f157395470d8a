//! Contacts of a sheet with bodies, counted in each step and turned into events: first contact,
//! lying flat, end of contact.

use rapier3d::prelude::{ColliderHandle, RigidBodyHandle};

use crate::islands::event::{EventKind, InstabilityReport};
use crate::islands::settings::{StepSettings, TouchSettings};
use crate::rigid::RigidView;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::sheet::{Sheet, Status};

const SETTINGS: TouchSettings = StepSettings::DEFAULT.touch;

/// Whether the bottom layer is plane: every node near the plane through three corners.
fn is_flat(sheet: &Sheet) -> bool {
    let Some(layer) = sheet.model.layers.first() else { return false };
    let (i, j) = (layer.nx.saturating_sub(1), layer.nz.saturating_sub(1));
    let corners = match &sheet.model.triangles {
        Some(list) => list.first().copied().unwrap_or_default(),
        None => [layer.at(0, 0), layer.at(i, 0), layer.at(0, j)],
    };
    let [origin, a, b] = corners.map(|m| sheet.state.x.get(m as usize));
    let normal = (a - origin).cross(b - origin).normalize_or_zero();
    let bound = SETTINGS.flatness * sheet.model.initial_diagonal;
    layer.range().all(|m| (sheet.state.x.get(m) - origin).dot(normal).abs() < bound)
}

/// Touched body, with the number of nodes in contact in this step.
#[derive(Clone, Debug)]
struct BodyTouch {
    collider: ColliderHandle,
    body: Option<RigidBodyHandle>,
    masses: u32,
    last: f64,
    off: bool,
    flat: bool,
    known: bool,
}

/// Record of the bodies that a sheet has touched; one per sheet, updated every step.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactLog {
    list: Vec<BodyTouch>,
    /// Events of the step; drained by the world.
    pub events: Vec<(f64, EventKind, Option<ColliderHandle>)>,
    /// Data of those events that carry an alarm, in their order.
    pub alarms: Vec<InstabilityReport>,
    /// Whether the last report of [`ContactLog::report_sleep`] was of sleep.
    is_asleep: bool,
}

/// Writer of contacts to a sheet's record, which maps colliders to bodies.
pub(crate) struct ContactRecorder<'a> {
    pub touches: &'a mut ContactLog,
    pub view: &'a RigidView<'a>,
}

impl ContactRecorder<'_> {
    /// Count a node that touches `collider` in this step.
    pub fn touched(&mut self, collider: ColliderHandle) {
        let body = self.view.colliders.get(collider).and_then(|c| c.parent());
        let same = |t: &BodyTouch| t.collider == collider || (body.is_some() && t.body == body);
        let found = self.touches.list.iter().position(same);
        if found.is_none() {
            self.touches.drop_removed(self.view);
        }
        let list = &mut self.touches.list;
        let index = found.unwrap_or_else(|| {
            let new = BodyTouch { collider, body, masses: 0, last: 0.0, off: false, flat: false, known: false };
            list.push(new);
            list.len() - 1
        });
        list[index].masses += 1;
    }
}

impl ContactLog {
    /// Record an event with its alarm data.
    pub fn report_instability(&mut self, time: f64, kind: EventKind, alarm: InstabilityReport) {
        self.events.push((time, kind, None));
        self.alarms.push(alarm);
    }

    /// Record the begin or end of sleep in a step from `start` to `end` (s), at whose end the sheet
    /// has `status`. The two alternate: sleep of no length is not recorded, nor is an instability.
    pub fn report_sleep(&mut self, status: Status, start: f64, end: f64) {
        match (self.is_asleep, status) {
            (false, Status::Asleep) => self.events.push((end, EventKind::AtRest, None)),
            (true, Status::Awake) => self.events.insert(0, (start, EventKind::Woke, None)),
            _ => return,
        }
        self.is_asleep = !self.is_asleep;
    }

    /// Reset the counts of the last step before a step that begins at `time` (s). A contact of the
    /// last step lasts up to `time`, sleep included.
    pub fn begin(&mut self, time: f64) {
        for t in &mut self.list {
            if std::mem::take(&mut t.masses) > 0 {
                t.last = t.last.max(time);
            }
        }
    }

    /// Drop the records of removed colliders and bodies whose end of contact has been reported.
    /// Handles are not reused, so that no later contact refers to these records.
    fn drop_removed(&mut self, view: &RigidView) {
        let exists = |t: &BodyTouch| {
            view.colliders.contains(t.collider) || t.body.is_some_and(|body| view.bodies.contains(body))
        };
        self.list.retain(|t| !t.off || exists(t));
    }

    /// Number of bodies touched in this step.
    pub fn count(&self) -> usize {
        self.list.iter().filter(|t| t.masses > 0).count()
    }

    /// Serialise the record, after a step.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.flag(self.is_asleep);
        to.count(self.list.len() as u64);
        for t in &self.list {
            let (collider, body) = (t.collider.into_raw_parts(), t.body.map(RigidBodyHandle::into_raw_parts));
            to.flag(body.is_some());
            for v in [collider.0, collider.1].into_iter().chain(body.into_iter().flat_map(|b| [b.0, b.1])) {
                to.count(u64::from(v));
            }
            (t.masses, t.last).serialise(to);
            [t.off, t.flat, t.known].serialise(to);
        }
    }

    /// Deserialise the record.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.events.clear();
        self.alarms.clear();
        self.list.clear();
        self.is_asleep = from.flag()?;
        for _ in 0..from.length(14)? {
            let has_body = from.flag()?;
            let collider = ColliderHandle::from_raw_parts(from.count_u32()?, from.count_u32()?);
            let body = if has_body {
                Some(RigidBodyHandle::from_raw_parts(from.count_u32()?, from.count_u32()?))
            } else {
                None
            };
            let (masses, last) = from.read()?;
            let [off, flat, known] = from.read()?;
            self.list.push(BodyTouch { collider, body, masses, last, off, flat, known });
        }
        Ok(())
    }

    /// Turn the counts of this step into events.
    pub fn end(&mut self, time: f64, sheet: &Sheet) {
        let layer = sheet.model.layers.first().map_or(0, |l| l.len());
        let here = |t: &BodyTouch| t.known && time - t.last <= SETTINGS.separation_delay;
        let alone = self.list.iter().filter(|t| here(t) || t.masses > 0).count() == 1;
        for t in &mut self.list {
            if t.masses > 0 {
                if !t.known {
                    t.known = true;
                    self.events.push((time, EventKind::FirstContact, Some(t.collider)));
                }
                t.last = time;
                t.off = false;
                if !t.flat
                    && alone
                    && f64::from(t.masses) >= SETTINGS.flat_node_fraction * f64::from(layer)
                    && is_flat(sheet)
                {
                    t.flat = true;
                    self.events.push((time, EventKind::Flat, Some(t.collider)));
                }
            } else if !t.off && time - t.last > SETTINGS.separation_delay {
                t.off = true;
                self.events.push((t.last, EventKind::SlidOff, Some(t.collider)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rapier3d::prelude::{BroadPhaseBvh, ColliderBuilder, ColliderSet, IslandManager, NarrowPhase, RigidBodySet};

    use super::*;
    use crate::scene::{Scene, SheetSpec};

    /// Contact with each of `count` colliders in turn, each of which is removed after the contact.
    /// Returns the number of records at the end and the kinds of the events.
    fn touch_in_turn(count: usize, permanent: bool) -> (usize, Vec<EventKind>) {
        let scene = Scene { sheets: vec![SheetSpec::default()], ..Scene::default() };
        let sheet = Sheet::build(&scene, 0).expect("valid");
        let (broad_phase, narrow_phase) = (BroadPhaseBvh::new(), NarrowPhase::new());
        let (mut bodies, mut colliders, mut islands) = (RigidBodySet::new(), ColliderSet::new(), IslandManager::new());
        let mut log = ContactLog::default();
        let mut time = 0.0;
        for _ in 0..count {
            let collider = colliders.insert(ColliderBuilder::ball(0.1));
            for step in 0..20 {
                log.begin(time);
                if step < 2 {
                    let view = RigidView::new(&broad_phase, &narrow_phase, &bodies, &colliders);
                    ContactRecorder { touches: &mut log, view: &view }.touched(collider);
                }
                time += 0.01;
                log.end(time, &sheet);
                if step == 2 && !permanent {
                    colliders.remove(collider, &mut islands, &mut bodies, false);
                }
            }
        }
        (log.list.len(), log.events.iter().map(|e| e.1).collect())
    }

    #[test]
    fn records_of_removed_colliders_are_dropped_without_a_change_of_events() {
        let (records, events) = touch_in_turn(40, false);
        assert_eq!(records, 1, "the record of the last collider stays until the next new contact");
        assert_eq!(events, [EventKind::FirstContact, EventKind::SlidOff].repeat(40));
        let (records, same) = touch_in_turn(40, true);
        assert_eq!((records, same), (40, events), "a body that exists may be touched again");
    }
}
