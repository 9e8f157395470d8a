//! Events of the sheets of a world, with their times.

use glam::DVec3;
use rapier3d::prelude::{ColliderHandle, RigidBodyHandle};
use serde::Serialize;

use crate::islands::settings::{StepSettings, TouchSettings};
use crate::rigid::RigidView;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::sheet::{FractureOpening, Sheet, instability, node_contact};

const SETTINGS: TouchSettings = StepSettings::DEFAULT.touch;

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// First contact of a sheet with a body.
    FirstContact,
    /// End of contact with a body for a tenth of a second; the time is that of the last contact.
    SlidOff,
    /// First time that a sheet lies flat on one body: it touches no other body, the number of nodes
    /// in contact is at least 95 % of those of the bottom layer, and the layer is plane to 2 % of
    /// the sheet's diagonal.
    Flat,
    /// Start of sleeping: every node was slower than 1 mm/s for half a second.
    AtRest,
    /// End of sleeping.
    Woke,
    /// Instability; the sheet is stopped.
    Unstable,
    /// Detected instability, with the recovery action of `when_unstable`.
    Contained,
    /// The contact solver did not converge in a substep. The island moved rigidly or was frozen for
    /// that substep. Sent once per episode.
    GivenUp,
    /// Interpenetration with another sheet, as from initial positions. Contact between the two is
    /// disabled until they are apart.
    Crossing,
    /// Return to normal stepping after a time without detected instability.
    Recovered,
    /// Buckling, snap-through or crumpling ([`crate::sheet::Buckling`]). Sent only when
    /// [`crate::world::World::set_buckling_detection`] enables it.
    Buckled,
    /// First fracture or melting of a sheet.
    Torn,
    /// Change to another grid ([`crate::world::World::remap`], or a level of detail).
    Resampled,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Simulated time, s.
    pub time_s: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// Name of the sheet.
    pub sheet: String,
    /// Name of the body, where one is involved.
    pub body: Option<String>,
    /// Place of a local event, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place_m: Option<[f64; 3]>,
    /// Released energy of a buckling event, J.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
    /// Data of a fracture event.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opening: Option<FractureOpening>,
    /// Numbers of nodes along length and width after a change of the grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<(u32, u32)>,
    /// Data of an instability event and its recovery action.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<InstabilityReport>,
}

/// Recovery action for an unstable sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RecoveryAction {
    /// The sheet was stopped.
    Stopped,
    /// The sheet was frozen.
    Frozen,
    /// The integrator takes a step in several substeps.
    StepReduced {
        /// Number of substeps.
        parts: u32,
    },
    /// The implicit integrator takes over.
    Implicit,
    /// The strain of springs is limited.
    Limited {
        /// Strain limit.
        strain: f64,
    },
}

/// Data of the rejected step in which a sheet was detected as unstable. Infinity replaces NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InstabilityReport {
    /// Energy at the start of the step, J; `None` when an implicit integrator did not store it.
    pub energy_before_j: Option<f64>,
    /// Energy at the end of the step, J.
    pub energy_after_j: f64,
    /// Index of the fastest node.
    pub mass: u32,
    /// Speed of the fastest node, m/s.
    pub speed_m_s: f64,
    /// Position of the fastest node at the start of the step, m.
    pub place_m: [f64; 3],
    /// Largest strain of a spring, or between neighbours of a shell, at the end of the step.
    pub strain: f64,
    /// Length of the step, s.
    pub step_s: f64,
    /// Recovery action.
    pub handled: RecoveryAction,
}

impl InstabilityReport {
    /// Data of `sheet` at the end of a step of `step_s` (s) from `work.x_before`, under `gravity`
    /// (m/s²).
    pub(crate) fn new(sheet: &mut Sheet, gravity: DVec3, step_s: f64) -> Self {
        let number = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        let squared = |i: usize| number(sheet.state.v.get(i).length_squared());
        let mass = (0..sheet.node_count()).max_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(0);
        let speed_m_s = squared(mass).sqrt();
        let energy_after_j = number(sheet.energy(gravity).total);
        let strain = instability::largest_strain(sheet);
        // Implicit integrators store their initial state only with an instability policy.
        let known = node_contact::is_explicit(sheet) || sheet.recovery.is_some();
        let energy_before_j = (known && sheet.work.v_before.len() == sheet.node_count()).then(|| {
            node_contact::swap_with_step_start(sheet);
            let energy = sheet.energy(gravity).total;
            node_contact::swap_with_step_start(sheet);
            number(energy)
        });
        let place_m = sheet.work.x_before.get(mass).to_array();
        Self {
            energy_before_j,
            energy_after_j,
            mass: mass as u32,
            speed_m_s,
            place_m,
            strain,
            step_s,
            handled: RecoveryAction::Stopped,
        }
    }
}

impl Event {
    /// Event of `sheet` without a place.
    pub(crate) fn new(time_s: f64, kind: EventKind, sheet: &str, body: Option<String>) -> Self {
        let sheet = sheet.to_owned();
        Self { time_s, kind, sheet, body, place_m: None, energy_j: None, opening: None, grid: None, alarm: None }
    }
}

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

impl EventKind {
    /// Whether events of this kind carry an [`InstabilityReport`].
    pub(crate) fn has_alarm(self) -> bool {
        matches!(self, Self::Unstable | Self::Contained)
    }
}

impl ContactLog {
    /// Record an event with its alarm data.
    pub fn report_instability(&mut self, time: f64, kind: EventKind, alarm: InstabilityReport) {
        self.events.push((time, kind, None));
        self.alarms.push(alarm);
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
