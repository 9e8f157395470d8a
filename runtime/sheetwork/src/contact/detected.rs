//! Contacts of one outer iteration: those that detection found, and those added later. Added are
//! contacts that contact itself has closed, and sheet-sheet contacts whose sides passed through
//! each other in earlier iterations.
//!
//! Contacts of sheets come first, in ascending order of their keys; then contacts between bodies;
//! then attachments.

use glam::DVec3;

use crate::collision::constraint::{Contact, Key, Side};
use crate::collision::narrow_phase::is_of_ball;
use crate::contact::convergence;
use crate::contact::gap::{At, gap, moved, place};
use crate::contact::settings::{ContactSettings, PgsSettings};
use crate::contact::solver::delassus::Group;
use crate::contact::stage::Scratch;
use crate::contact::warm_start::Memory;

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;

/// Detected contacts of an island.
#[derive(Default)]
pub(crate) struct Found {
    pub contacts: Vec<Contact>,
    /// For each contact of a sheet, the index of the collider in the island, if the other side is a
    /// body.
    pub parts: Vec<u32>,
    /// Index of the first attachment.
    pub glue_from: usize,
    /// Whether the mid-surfaces of two sheets intersect, independent of the contacts.
    pub cut: bool,
}

impl Found {
    /// Clear the list before a step, which may be of another island. A step without detection has
    /// no contacts.
    pub fn forget(&mut self) {
        self.contacts.clear();
        self.parts.clear();
        self.glue_from = 0;
        self.cut = false;
    }

    /// Contacts of sheets. Only they are sorted by key and have a collider index.
    fn of_sheets(&self) -> &[Contact] {
        &self.contacts[..self.parts.len()]
    }

    /// Largest penetration between two bodies at the start of the stage, m, which the step will
    /// remove.
    pub fn parted(&self, group: &Group) -> f64 {
        let between = &self.contacts[self.parts.len()..self.glue_from];
        between.iter().map(|c| -gap(group, c, At::Start)).fold(0.0, f64::max)
    }

    /// Position of the sheet contact with this key in the list, or the position at which it would
    /// be inserted.
    fn place_of(&self, key: &Key) -> Result<usize, usize> {
        self.of_sheets().binary_search_by(|c| c.key.cmp(key))
    }

    /// Insert a contact of a sheet at position `at`, with its collider index.
    fn insert(&mut self, at: usize, contact: Contact, part: u32) {
        self.contacts.insert(at, contact);
        self.parts.insert(at, part);
        self.glue_from += 1;
    }

    /// Keep the contacts for which `keeps` is true; all contacts must be of sheets.
    fn retain(&mut self, keeps: impl Fn(&Contact) -> bool) {
        let Self { contacts, parts, .. } = self;
        let mut kept = 0;
        for i in 0..contacts.len() {
            if keeps(&contacts[i]) {
                (contacts[kept], parts[kept]) = (contacts[i], parts[i]);
                kept += 1;
            }
        }
        contacts.truncate(kept);
        parts.truncate(kept);
    }

    /// Remove penetrating contacts that no force can open: fixed nodes inside a static or kinematic
    /// body. A solve would not converge. Fixed nodes that only touch keep their contacts: they may
    /// stick, and carry load when the attachment is removed.
    pub fn leave_out_jammed(&mut self, group: &Group) {
        let fixed = |side: &Side| match side {
            Side::Sheet { sheet, point } => {
                let sheet = group.sheet(*sheet);
                point.terms().all(|(i, _)| sheet.is_held(i as usize))
            }
            Side::Body { body, .. } => !group.movers[*body as usize].gives(),
        };
        self.retain(|contact| {
            !(fixed(&contact.a) && fixed(&contact.b) && gap(group, contact, At::Free) < -PGS.tolerance)
        });
    }

    /// Remove contacts between nodes and the body to which they are attached. The attachment
    /// determines the position; contact and attachment would oppose each other. `is_glued` tells,
    /// for a sheet, a node and a body, whether they are attached.
    pub fn leave_out_glued(&mut self, is_glued: impl Fn(u32, u32, u32) -> bool) {
        let holds = |contact: &Contact| match (&contact.a, &contact.b) {
            (Side::Sheet { sheet, point }, Side::Body { body, .. }) => {
                point.terms().any(|(mass, _)| is_glued(*sheet, mass, *body))
            }
            _ => false,
        };
        self.retain(|contact| !holds(contact));
    }

    /// Resolve pairs of opposite contacts at the same place that cannot both open: the one with the
    /// deeper penetration at the start of the stage is removed. Examples are a needle touched from
    /// within, the underside of a body on a floor, and an edge of a fold seen from behind. If only
    /// one of them has a cached force, the other is removed, because rotation of the sheet makes
    /// the depth at the start unreliable.
    pub fn leave_out_opposed(&mut self, group: &Group, memory: &Memory) {
        // With several sheets an unconverged solution is accepted, and a search among thousands of
        // contacts is expensive.
        if group.members.len() > 1 {
            return;
        }
        let start = |c: &Contact| gap(group, c, At::Start);
        let held = |c: &Contact| memory.of(&c.key).is_some_and(|known| known.position != DVec3::ZERO);
        let stands = |body: u32| !group.movers[body as usize].gives();
        let shares = |one: &Side, other: &Side| match (one, other) {
            (Side::Sheet { sheet, point }, Side::Sheet { sheet: also, point: there }) => {
                sheet == also && point.terms().any(|(i, _)| there.terms().any(|(j, _)| i == j))
            }
            // Two contacts of the same body lie on opposite sides of it; its motion opens one and
            // closes the other.
            (Side::Body { body, .. }, Side::Body { body: also, .. }) => body == also || stands(*body) && stands(*also),
            _ => false,
        };
        let opposes = |one: &Contact, other: &Contact| {
            let cosine = one.normal.dot(other.normal);
            cosine < SETTINGS.opposed_normal_cosine && shares(&one.a, &other.a) && shares(&one.b, &other.b)
                || cosine > -SETTINGS.opposed_normal_cosine && shares(&one.a, &other.b) && shares(&one.b, &other.a)
        };
        for i in (0..self.parts.len()).rev() {
            let contact = &self.contacts[i];
            let overlap = start(contact);
            // The contact with a ball is unique. A node that meets the ball during the stage starts
            // behind the tangent plane at the later contact point, but outside the ball.
            if overlap >= -SETTINGS.residual_penetration || is_of_ball(&contact.key) {
                continue;
            }
            let holds = |other: &Contact| {
                opposes(contact, other) && {
                    let apart = start(other);
                    let is_right = match (held(contact), held(other)) {
                        (true, false) => false,
                        (false, true) => true,
                        _ => apart > overlap,
                    };
                    is_right && apart + overlap < -SETTINGS.residual_penetration
                }
            };
            if self.of_sheets().iter().any(holds) {
                self.contacts.remove(i);
                self.parts.remove(i);
                self.glue_from -= 1;
            }
        }
    }
}

impl Scratch {
    /// Replace the contacts by those of a detection with wider margins if a contact that was not in
    /// the list penetrates. Returns whether one does.
    pub(crate) fn take_up_wide(&mut self, group: &Group) -> bool {
        let mut new = self.seen.of_sheets().iter().filter(|c| self.found.place_of(&c.key).is_err());
        let overlaps = new.any(|contact| overlaps(group, contact));
        if overlaps {
            std::mem::swap(&mut self.found, &mut self.seen);
        }
        overlaps
    }

    /// Add the contacts of the additional detection that penetrate after the displacement by
    /// contact. Returns whether any was added.
    pub(crate) fn take_up_more(&mut self, group: &Group) -> bool {
        let Self { found, seen, .. } = self;
        let before = found.contacts.len();
        for (contact, part) in seen.of_sheets().iter().zip(&seen.parts) {
            if let (Err(at), true) = (found.place_of(&contact.key), overlaps(group, contact)) {
                found.insert(at, *contact, *part);
            }
        }
        found.contacts.len() > before
    }

    /// Store the sheet-sheet contacts of the additional detection whose sides have passed through
    /// each other.
    pub(crate) fn note_crossed(&mut self, group: &Group) {
        let crossed = self.seen.of_sheets().iter().filter(|c| convergence::has_crossed(group, c));
        let before = self.crossing.len();
        self.crossed = self.seen.cut;
        for contact in crossed {
            self.crossed = true;
            if !self.crossing[..before].iter().any(|c| c.key == contact.key) {
                self.crossing.push(*contact);
            }
        }
    }

    /// Add the stored contacts of sheets that passed through each other, as they were detected
    /// before the passage.
    pub(crate) fn take_up_crossed(&mut self) {
        for crossed in &self.crossing {
            match self.found.place_of(&crossed.key) {
                Ok(at) => self.found.contacts[at] = *crossed,
                Err(at) => self.found.insert(at, *crossed, u32::MAX),
            }
        }
    }
}

/// Whether a contact penetrates after the displacement by contact.
fn overlaps(group: &Group, contact: &Contact) -> bool {
    let [a, b] = [&contact.a, &contact.b].map(|side| place(group, side, At::Free) + moved(group, side));
    contact.normal.dot(a - b) < contact.offset
}
