//! Contacts of one outer iteration: those that detection found, and those added later. Added are
//! contacts that contact itself has closed, and sheet-sheet contacts whose sides passed through
//! each other in earlier iterations.
//!
//! Contacts of sheets come first, in ascending order of their keys; then contacts between bodies;
//! then attachments.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactKey, ContactSide};
use crate::collision::narrow_phase::is_ball_contact;
use crate::contact::contact_cache::ContactCache;
use crate::contact::gap::{StagePose, contact_displacement, gap, position};
use crate::contact::settings::{ContactSettings, PgsSettings};
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{IslandView, convergence};

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;

/// Detected contacts of an island.
#[derive(Default)]
pub(crate) struct DetectedContacts {
    pub contacts: Vec<ContactConstraint>,
    /// For each contact of a sheet, the index of the collider in the island, if the other side is a
    /// body.
    pub colliders: Vec<u32>,
    /// Index of the first attachment.
    pub first_attachment: usize,
    /// Whether the mid-surfaces of two sheets intersect, independent of the contacts.
    pub sheets_intersect: bool,
}

impl DetectedContacts {
    /// Clear the list before a step, which may be of another island. A step without detection has
    /// no contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.colliders.clear();
        self.first_attachment = 0;
        self.sheets_intersect = false;
    }

    /// Contacts of sheets. Only they are sorted by key and have a collider index.
    fn of_sheets(&self) -> &[ContactConstraint] {
        &self.contacts[..self.colliders.len()]
    }

    /// Largest penetration between two bodies at the start of the stage, m, which the step will
    /// remove.
    pub fn largest_body_penetration(&self, island: &IslandView) -> f64 {
        let between = &self.contacts[self.colliders.len()..self.first_attachment];
        between.iter().map(|c| -gap(island, c, StagePose::Start)).fold(0.0, f64::max)
    }

    /// Position of the sheet contact with this key in the list, or the position at which it would
    /// be inserted.
    fn find_key(&self, key: &ContactKey) -> Result<usize, usize> {
        self.of_sheets().binary_search_by(|c| c.key.cmp(key))
    }

    /// Insert a contact of a sheet at position `at`, with its collider index.
    fn insert(&mut self, at: usize, contact: ContactConstraint, part: u32) {
        self.contacts.insert(at, contact);
        self.colliders.insert(at, part);
        self.first_attachment += 1;
    }

    /// Keep the contacts for which `keeps` is true; all contacts must be of sheets.
    fn retain(&mut self, keeps: impl Fn(&ContactConstraint) -> bool) {
        let Self { contacts, colliders: parts, .. } = self;
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
    pub fn remove_immovable(&mut self, island: &IslandView) {
        let fixed = |side: &ContactSide| match side {
            ContactSide::Sheet { sheet, point } => {
                let sheet = island.sheet(*sheet);
                point.terms().all(|(i, _)| sheet.is_held(i as usize))
            }
            ContactSide::Body { body, .. } => !island.solver_bodies[*body as usize].is_dynamic(),
        };
        let least = -PGS.tolerance * island.half_thickness();
        self.retain(|contact| {
            !(fixed(&contact.a) && fixed(&contact.b) && gap(island, contact, StagePose::Free) < least)
        });
    }

    /// Remove contacts between nodes and the body to which they are attached. The attachment
    /// determines the position; contact and attachment would oppose each other. `is_glued` tells,
    /// for a sheet, a node and a body, whether they are attached.
    pub fn remove_attached(&mut self, is_glued: impl Fn(u32, u32, u32) -> bool) {
        let holds = |contact: &ContactConstraint| match (&contact.a, &contact.b) {
            (ContactSide::Sheet { sheet, point }, ContactSide::Body { body, .. }) => {
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
    pub fn remove_opposed(&mut self, island: &IslandView, memory: &ContactCache) {
        // With several sheets an unconverged solution is accepted, and a search among thousands of
        // contacts is expensive.
        if island.sheets.len() > 1 {
            return;
        }
        let residual = SETTINGS.residual_penetration * island.half_thickness();
        let start = |c: &ContactConstraint| gap(island, c, StagePose::Start);
        let held = |c: &ContactConstraint| memory.of(&c.key).is_some_and(|known| known.position != DVec3::ZERO);
        let stands = |body: u32| !island.solver_bodies[body as usize].is_dynamic();
        let shares = |one: &ContactSide, other: &ContactSide| match (one, other) {
            (ContactSide::Sheet { sheet, point }, ContactSide::Sheet { sheet: also, point: there }) => {
                sheet == also && point.terms().any(|(i, _)| there.terms().any(|(j, _)| i == j))
            }
            // Two contacts of the same body lie on opposite sides of it; its motion opens one and
            // closes the other.
            (ContactSide::Body { body, .. }, ContactSide::Body { body: also, .. }) => {
                body == also || stands(*body) && stands(*also)
            }
            _ => false,
        };
        let opposes = |one: &ContactConstraint, other: &ContactConstraint| {
            let cosine = one.normal.dot(other.normal);
            cosine < SETTINGS.opposed_normal_cosine
                && shares(&one.a, &other.a)
                && shares(&one.b, &other.b)
                && !compress(island, [one, other], residual)
                || cosine > -SETTINGS.opposed_normal_cosine && shares(&one.a, &other.b) && shares(&one.b, &other.a)
        };
        for i in (0..self.colliders.len()).rev() {
            let contact = &self.contacts[i];
            let overlap = start(contact);
            // The contact with a ball is unique. A node that meets the ball during the stage starts
            // behind the tangent plane at the later contact point, but outside the ball.
            if overlap >= -residual || is_ball_contact(&contact.key) {
                continue;
            }
            let holds = |other: &ContactConstraint| {
                opposes(contact, other) && {
                    let apart = start(other);
                    let is_right = match (held(contact), held(other)) {
                        (true, false) => false,
                        (false, true) => true,
                        _ => apart > overlap,
                    };
                    is_right && apart + overlap < -residual
                }
            };
            if self.of_sheets().iter().any(holds) {
                self.contacts.remove(i);
                self.colliders.remove(i);
                self.first_attachment -= 1;
            }
        }
    }
}

impl ContactWorkspace {
    /// Replace the contacts by those of a detection with wider margins if a contact that was not in
    /// the list penetrates. Returns whether one does.
    pub(crate) fn adopt_wider_detection(&mut self, island: &IslandView) -> bool {
        let mut new = self.rechecked.of_sheets().iter().filter(|c| self.detected.find_key(&c.key).is_err());
        let overlaps = new.any(|contact| overlaps(island, contact));
        if overlaps {
            std::mem::swap(&mut self.detected, &mut self.rechecked);
        }
        overlaps
    }

    /// Add the contacts of the additional detection that penetrate after the displacement by
    /// contact. Returns whether any was added.
    pub(crate) fn add_displaced_contacts(&mut self, island: &IslandView) -> bool {
        let Self { detected: found, rechecked: seen, .. } = self;
        let before = found.contacts.len();
        for (contact, part) in seen.of_sheets().iter().zip(&seen.colliders) {
            if let (Err(at), true) = (found.find_key(&contact.key), overlaps(island, contact)) {
                found.insert(at, *contact, *part);
            }
        }
        found.contacts.len() > before
    }

    /// Store the sheet-sheet contacts of the additional detection whose sides have passed through
    /// each other.
    pub(crate) fn record_crossed_contacts(&mut self, island: &IslandView) {
        let crossed = self.rechecked.of_sheets().iter().filter(|c| convergence::has_crossed(island, c));
        let before = self.crossed_contacts.len();
        self.has_crossed = self.rechecked.sheets_intersect;
        for contact in crossed {
            self.has_crossed = true;
            if !self.crossed_contacts[..before].iter().any(|c| c.key == contact.key) {
                self.crossed_contacts.push(*contact);
            }
        }
    }

    /// Add the stored contacts of sheets that passed through each other, as they were detected
    /// before the passage.
    pub(crate) fn add_crossed_contacts(&mut self) {
        for crossed in &self.crossed_contacts {
            match self.detected.find_key(&crossed.key) {
                Ok(at) => self.detected.contacts[at] = *crossed,
                Err(at) => self.detected.insert(at, *crossed, u32::MAX),
            }
        }
    }
}

/// Whether a sheet between the two bodies of opposed contacts is compressed: their faces are at a
/// distance above `least` (m).
fn compress(island: &IslandView, both: [&ContactConstraint; 2], least: f64) -> bool {
    let [a, b] = both.map(|contact| position(island, &contact.b, StagePose::Free));
    let bodies = both.iter().all(|contact| matches!(contact.b, ContactSide::Body { .. }));
    bodies && (both[0].normal - both[1].normal).normalize_or_zero().dot(b - a) > least
}

/// Whether a contact penetrates after the displacement by contact.
fn overlaps(island: &IslandView, contact: &ContactConstraint) -> bool {
    let [a, b] = [&contact.a, &contact.b]
        .map(|side| position(island, side, StagePose::Free) + contact_displacement(island, side));
    contact.normal.dot(a - b) < contact.offset
}
