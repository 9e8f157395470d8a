//! Pairs in contact, for programs that play a sound, count hits or take damage: a sheet with a
//! body, with another sheet, or with itself.
//!
//! A pair begins with the first contact impulse, and ends when it has had none for a tenth of a
//! second; its last step is the time of that event. Impulses are those by which the contact solver
//! changes the velocities, so that a pair which the solver only looked at never begins. In a step
//! that the solver did not end, pairs persist.
//!
//! Place and normal of a pair are means over its contacts weighted by their impulses; speeds are
//! the largest of its contacts at the start of the step.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;

use crate::error::{InputError, check_range};
use crate::islands::settings::{StepSettings, TouchSettings};
use crate::rigid::RigidView;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::forces::PairImpulse;
use crate::sheet::{ForceKind, ForcePartner};
use crate::world::World;
use crate::world::ids::{BodyId, SheetId};

const SETTINGS: TouchSettings = StepSettings::DEFAULT.touch;

/// Object that a sheet touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ContactPartner {
    /// The sheet itself.
    Itself,
    /// Another sheet.
    Sheet(SheetId),
    /// A body of the world.
    Body(BodyId),
    /// A collider of the caller's rigid world.
    Collider {
        /// Handle of the collider, or of another one of its body.
        handle: ColliderHandle,
        /// User data of that collider. Some programs keep there which object it belongs to.
        user_data: u128,
    },
}

/// A sheet and an object that it touches, with the contact forces of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPair {
    /// The sheet that records its contacts; if both do, that which comes first in the world.
    pub sheet: SheetId,
    /// The object that it touches.
    pub partner: ContactPartner,
    /// Time at which the contact began, s.
    pub since: f64,
    /// Time of the last contact impulse, s.
    pub last: f64,
    /// Centre of the contact on the sheet, m; of the last step with an impulse.
    pub point: DVec3,
    /// Unit normal from the partner to the sheet, or zero where contacts on opposite sides cancel.
    pub normal: DVec3,
    /// Impulse on the sheet in the last step, friction included, N s.
    pub impulse: DVec3,
    /// Sum of the magnitudes of the contact forces in the last step, N.
    pub force: f64,
    /// Largest speed at which a point of the sheet came towards the partner at the start of that
    /// step, m/s.
    pub approach_speed: f64,
    /// Largest speed at which it slid, m/s; 0 between a body and a sheet of an explicit integrator.
    pub slip_speed: f64,
}

/// Kind of a [`ContactEvent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ContactEventKind {
    /// Begin of the contact.
    Began,
    /// The force has risen above the threshold of the sheet, in one step.
    ForceExceeded,
    /// End of the contact.
    Ended,
}

/// Begin or end of the contact of a pair, or a force above the threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactEvent {
    /// Simulated time, s.
    pub time: f64,
    /// Kind of the event.
    pub kind: ContactEventKind,
    /// The pair then.
    pub pair: ContactPair,
}

/// Contacts of the sheets that record them.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactRecords {
    /// Sheets that record contacts, with their thresholds, N.
    thresholds: Vec<(SheetId, f64)>,
    /// Pairs in contact, in the order in which they began.
    pairs: Vec<ContactPair>,
    events: Vec<ContactEvent>,
    /// Number of events taken by [`World::drain_contact_events`].
    drained: u64,
}

impl World {
    /// Record the contacts of the sheet `id` from the next step on: [`World::contacts`], and events
    /// for [`World::drain_contact_events`]. `threshold` is the force (N, at least 0; infinite for
    /// none) above which [`ContactEventKind::ForceExceeded`] is sent; of two sheets the lower one
    /// counts. `None` stops the records of the sheet. Results of the simulation do not depend on
    /// it; forces are recorded too.
    ///
    /// # Errors
    /// When there is no such sheet or the threshold is negative or not a number.
    pub fn record_contacts(&mut self, id: SheetId, threshold: Option<f64>) -> Result<(), InputError> {
        self.index_of_sheet(id)?;
        if let Some(force) = threshold.filter(|force| *force != f64::INFINITY) {
            check_range("threshold", force, 0.0, f64::MAX, "N")?;
        }
        let mut records = self.contacts.take().unwrap_or_default();
        records.thresholds.retain(|(sheet, _)| *sheet != id);
        records.thresholds.extend(threshold.map(|force| (id, force)));
        self.contacts = (!records.thresholds.is_empty()).then_some(records);
        self.discard_unused_forces();
        Ok(())
    }

    /// Pairs in contact of the sheets that record them, in the order in which they began. Two
    /// sheets make one pair.
    pub fn contacts(&self) -> &[ContactPair] {
        self.contacts.as_ref().map_or(&[], |records| &records.pairs)
    }

    /// Take the contact events since the last call, in the order of the steps. They are kept until
    /// then.
    pub fn drain_contact_events(&mut self) -> Vec<ContactEvent> {
        let Some(records) = &mut self.contacts else { return Vec::new() };
        records.drained += records.events.len() as u64;
        std::mem::take(&mut records.events)
    }

    /// Update the pairs after a step. `lent` is the caller's rigid world, if there is one.
    pub(super) fn update_contacts(&mut self, lent: Option<&RigidView>) {
        let Some(mut records) = self.contacts.take() else { return };
        records.thresholds.retain(|(sheet, _)| self.sheet_ids.exists(sheet.0));
        for index in 0..self.sheets.len() {
            let Some(forces) = &self.sheets[index].work.forces else { continue };
            let contacts = forces.pairs.iter().filter(|pair| pair.kind == ForceKind::Contact && pair.magnitude > 0.0);
            contacts.for_each(|entry| self.update_pair(&mut records, (index, forces.dt), entry, lent));
        }
        self.end_pairs(&mut records);
        self.contacts = Some(records);
    }

    /// Threshold of the sheet at `index`, N; `None` unless its contacts are recorded.
    fn contact_threshold(&self, records: &ContactRecords, index: usize) -> Option<f64> {
        let id = SheetId(self.sheet_ids.at(index)?);
        records.thresholds.iter().find(|(sheet, _)| *sheet == id).map(|(_, force)| *force)
    }

    /// Update the pair of one entry of the forces of the sheet at `index` in a step of `dt` (s).
    fn update_pair(
        &self,
        records: &mut ContactRecords,
        (index, dt): (usize, f64),
        entry: &PairImpulse,
        lent: Option<&RigidView>,
    ) {
        let Some(own) = self.contact_threshold(records, index) else { return };
        let other = match entry.partner {
            ForcePartner::Sheet(other) => self.contact_threshold(records, other).map(|force| (other, force)),
            _ => None,
        };
        // Where both sheets record contacts, the first has the pair.
        if other.is_some_and(|(other, _)| other < index) {
            return;
        }
        let threshold = own.min(other.map_or(f64::INFINITY, |(_, force)| force));
        let Some((sheet, partner)) = self.objects_of(index, entry.partner, lent) else { return };
        let (time, force) = (self.time, entry.magnitude / dt);
        let found = records.pairs.iter().position(|pair| pair.sheet == sheet && pair.partner == partner);
        let (since, before) = found.map_or((time, 0.0), |at| (records.pairs[at].since, records.pairs[at].force));
        let pair = ContactPair {
            sheet,
            partner,
            since,
            last: time,
            point: entry.centre / entry.magnitude,
            normal: entry.normal.normalize_or_zero(),
            impulse: entry.impulse,
            force,
            approach_speed: entry.speeds.0,
            slip_speed: entry.speeds.1,
        };
        match found {
            Some(at) => records.pairs[at] = pair,
            None => {
                records.pairs.push(pair);
                records.events.push(ContactEvent { time, kind: ContactEventKind::Began, pair });
            }
        }
        if force > threshold && before <= threshold {
            records.events.push(ContactEvent { time, kind: ContactEventKind::ForceExceeded, pair });
        }
    }

    /// Ids of the objects of a pair.
    fn objects_of(
        &self,
        index: usize,
        partner: ForcePartner,
        lent: Option<&RigidView>,
    ) -> Option<(SheetId, ContactPartner)> {
        let partner = match partner {
            ForcePartner::Itself => ContactPartner::Itself,
            ForcePartner::Sheet(other) => ContactPartner::Sheet(SheetId(self.sheet_ids.at(other)?)),
            ForcePartner::Body(body) => ContactPartner::Body(BodyId(self.body_ids.at(body)?)),
            ForcePartner::Collider(handle) => {
                ContactPartner::Collider { handle, user_data: lent?.colliders.get(handle)?.user_data }
            }
            ForcePartner::None | ForcePartner::Pin(_) => return None,
        };
        Some((SheetId(self.sheet_ids.at(index)?), partner))
    }

    /// Clear the forces of the pairs without impulse in this step, and end those that have had none
    /// for the separation delay or whose objects are gone.
    fn end_pairs(&self, records: &mut ContactRecords) {
        let ContactRecords { thresholds, pairs, events, .. } = records;
        let time = self.time;
        pairs.retain_mut(|pair| {
            let sheets = [Some(pair.sheet), pair.partner.sheet()];
            let places = sheets.map(|sheet| sheet.map(|sheet| self.sheet_ids.position(sheet.0)));
            let is_there = !places.contains(&Some(None)) && pair.partner.body().is_none_or(|b| self.has_body(b));
            let is_recorded = sheets.into_iter().flatten().any(|id| thresholds.iter().any(|(sheet, _)| *sheet == id));
            let is_uncertain = |place: &Option<Option<usize>>| {
                place.flatten().is_some_and(|i| self.sheets[i].work.is_contact_uncertain)
            };
            if pair.last < time {
                (pair.impulse, pair.force, pair.approach_speed, pair.slip_speed) = (DVec3::ZERO, 0.0, 0.0, 0.0);
                if places.iter().any(is_uncertain) {
                    pair.last = time;
                }
            }
            let ends = !is_there || time - pair.last > SETTINGS.separation_delay;
            if ends {
                events.push(ContactEvent { time: pair.last, kind: ContactEventKind::Ended, pair: *pair });
            }
            !ends && is_recorded
        });
    }

    fn has_body(&self, id: BodyId) -> bool {
        self.body_ids.position(id.0).is_some()
    }

    /// Serialise the pairs in contact, if any sheet records them.
    pub(super) fn serialise_contacts(&self, to: &mut StateWriter) {
        let place = |id: SheetId| self.sheet_ids.position(id.0).unwrap_or_default() as u64;
        to.count(self.contacts.as_ref().map_or(0, |records| records.drained + records.events.len() as u64));
        to.count(self.contacts().len() as u64);
        for pair in self.contacts() {
            to.count(place(pair.sheet));
            let (kind, values) = match pair.partner {
                ContactPartner::Itself => (0, [0; 4]),
                ContactPartner::Sheet(id) => (1, [place(id), 0, 0, 0]),
                ContactPartner::Body(id) => (2, [self.body_ids.position(id.0).unwrap_or_default() as u64, 0, 0, 0]),
                ContactPartner::Collider { handle, user_data } => {
                    let (index, generation) = handle.into_raw_parts();
                    (3, [index.into(), generation.into(), user_data as u64, (user_data >> 64) as u64])
                }
            };
            to.byte(kind);
            values.into_iter().for_each(|value| to.count(value));
            to.numbers(&[pair.since, pair.last, pair.force, pair.approach_speed, pair.slip_speed]);
            [pair.point, pair.normal, pair.impulse].into_iter().for_each(|vector| to.vector(vector));
        }
    }

    /// Deserialise the output of [`World::serialise_contacts`]; kept only while contacts are
    /// recorded.
    pub(super) fn deserialise_contacts(&mut self, from: &mut StateReader) -> ReadResult {
        let told = from.count()?;
        let mut pairs = Vec::new();
        for _ in 0..from.length(1)? {
            let sheet = self.sheet_at(from.count()?)?;
            let kind = from.byte()?;
            let [a, b, c, d] = [from.count()?, from.count()?, from.count()?, from.count()?];
            let partner = match kind {
                0 => ContactPartner::Itself,
                1 => ContactPartner::Sheet(self.sheet_at(a)?),
                2 => ContactPartner::Body(BodyId(self.body_ids.at(a as usize).ok_or(CorruptState)?)),
                3 => {
                    let part = |value| u32::try_from(value).map_err(|_| CorruptState);
                    let handle = ColliderHandle::from_raw_parts(part(a)?, part(b)?);
                    ContactPartner::Collider { handle, user_data: u128::from(c) | (u128::from(d) << 64) }
                }
                _ => return Err(CorruptState),
            };
            let mut numbers = [0.0; 5];
            from.numbers(&mut numbers)?;
            let [since, last, force, approach_speed, slip_speed] = numbers;
            let [point, normal, impulse] = [from.vector()?, from.vector()?, from.vector()?];
            pairs.push(ContactPair {
                sheet,
                partner,
                since,
                last,
                point,
                normal,
                impulse,
                force,
                approach_speed,
                slip_speed,
            });
        }
        if let Some(records) = &mut self.contacts {
            records.events.truncate(usize::try_from(told.saturating_sub(records.drained)).unwrap_or(usize::MAX));
            records.drained = told.saturating_sub(records.events.len() as u64);
            records.pairs = pairs;
        }
        Ok(())
    }

    fn sheet_at(&self, place: u64) -> ReadResult<SheetId> {
        self.sheet_ids.at(place as usize).map(SheetId).ok_or(CorruptState)
    }
}

impl ContactRecords {
    /// Sheets that record contacts, with their thresholds, N.
    pub(super) fn thresholds(&self) -> &[(SheetId, f64)] {
        &self.thresholds
    }

    /// Whether the contacts of the sheet are recorded.
    pub(super) fn has(&self, id: SheetId) -> bool {
        self.thresholds.iter().any(|(sheet, _)| *sheet == id)
    }

    /// Records of the same sheets before the first contact.
    pub(super) fn restarted(self) -> Self {
        Self { thresholds: self.thresholds, ..Self::default() }
    }
}

impl ContactPartner {
    /// The other sheet.
    fn sheet(&self) -> Option<SheetId> {
        if let Self::Sheet(id) = self { Some(*id) } else { None }
    }

    /// The body of the world.
    fn body(&self) -> Option<BodyId> {
        if let Self::Body(id) = self { Some(*id) } else { None }
    }
}
