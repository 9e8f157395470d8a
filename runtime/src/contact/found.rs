//! What detection found for a round, and what is added to it: what contact has moved into something else, and what of sheets has
//! crossed in earlier rounds. Contacts of sheets come first, in the order of their keys, then those between bodies, then glue.

use glam::DVec3;

use super::delassus::Group;
use super::dual::ACCURACY;
use super::find::is_of_ball;
use super::memory::Memory;
use super::places::{At, gap, moved, place};
use super::row::{Contact, Key, Side};
use super::settled;
use super::stage::Scratch;

/// Overlap at the start of a stage that no stage before has left, m.
const BEGUN: f64 = 2e-5;
/// Cosine between normals below which two contacts oppose each other.
const OPPOSED: f64 = -0.9;

/// What detection found.
#[derive(Default)]
pub(crate) struct Found {
    pub contacts: Vec<Contact>,
    /// Of each contact of a sheet the part of the group it is with, if that is a body's.
    pub parts: Vec<u32>,
    /// Contacts from this number on are glue.
    pub glue_from: usize,
    /// Whether two sheets go through one another, whatever the contacts say.
    pub cut: bool,
}

impl Found {
    /// Forgets what was found in another step, for what may have been another group: a step in which nothing is looked for has found nothing.
    pub fn forget(&mut self) {
        self.contacts.clear();
        self.parts.clear();
        self.glue_from = 0;
        self.cut = false;
    }

    /// The contacts of sheets, which alone are in the order of their keys, and have parts.
    fn of_sheets(&self) -> &[Contact] {
        &self.contacts[..self.parts.len()]
    }

    /// By how much bodies that overlap are to be parted from where the stage began, m.
    pub fn parted(&self, group: &Group) -> f64 {
        let between = &self.contacts[self.parts.len()..self.glue_from];
        between.iter().map(|c| -gap(group, c, At::Start)).fold(0.0, f64::max)
    }

    /// Where the contact of a sheet with this key is, or would be put.
    fn place_of(&self, key: &Key) -> Result<usize, usize> {
        self.of_sheets().binary_search_by(|c| c.key.cmp(key))
    }

    /// Puts a contact of a sheet `at` its place, with its part of the group.
    fn insert(&mut self, at: usize, contact: Contact, part: u32) {
        self.contacts.insert(at, contact);
        self.parts.insert(at, part);
        self.glue_from += 1;
    }

    /// Keeps the contacts, all of them of sheets, of which `keeps` says so.
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

    /// Leaves out what overlaps and cannot give: masses that are held inside a body that is held, too. No force parts them, and a
    /// solve that tried would not end. Those that only touch stay: they may stick, and hold when their pins are taken away.
    pub fn leave_out_jammed(&mut self, group: &Group) {
        let fixed = |side: &Side| match side {
            Side::Sheet { sheet, point } => {
                let sheet = group.sheet(*sheet);
                point.terms().all(|(i, _)| sheet.is_held(i as usize))
            }
            Side::Body { body, .. } => !group.movers[*body as usize].gives(),
        };
        self.retain(|contact| !(fixed(&contact.a) && fixed(&contact.b) && gap(group, contact, At::Free) < -ACCURACY));
    }

    /// Leaves out contacts of masses with the body that they are glued to, as `is_glued` says of a sheet's mass and a body: the glue says where
    /// they are, and what holds and what pushes there would go on against each other for ever.
    pub fn leave_out_glued(&mut self, is_glued: impl Fn(u32, u32, u32) -> bool) {
        let holds = |contact: &Contact| match (&contact.a, &contact.b) {
            (Side::Sheet { sheet, point }, Side::Body { body, .. }) => {
                point.terms().any(|(mass, _)| is_glued(*sheet, mass, *body))
            }
            _ => false,
        };
        self.retain(|contact| !holds(contact));
    }

    /// Leaves out of two contacts that push the same places against each other, where no place is right for both, the one that overlapped by more
    /// at the start: a needle that is touched from within, the underside of a body on a floor, an edge of a fold that is seen from behind. No
    /// force puts both apart. One that has held before is right, whatever a sheet that turns in a stage says of its start.
    pub fn leave_out_opposed(&mut self, group: &Group, memory: &Memory) {
        // Several sheets go on from what does not settle, and have thousands of contacts to look through.
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
            // Of one body the two are of its two sides, and no motion of it helps either.
            (Side::Body { body, .. }, Side::Body { body: also, .. }) => body == also || stands(*body) && stands(*also),
            _ => false,
        };
        let opposes = |one: &Contact, other: &Contact| {
            let cosine = one.normal.dot(other.normal);
            cosine < OPPOSED && shares(&one.a, &other.a) && shares(&one.b, &other.b)
                || cosine > -OPPOSED && shares(&one.a, &other.b) && shares(&one.b, &other.a)
        };
        for i in (0..self.parts.len()).rev() {
            let contact = &self.contacts[i];
            let overlap = start(contact);
            // A ball is touched from where it is met alone; what comes in beside it was behind the normal that it meets later, and apart.
            if overlap >= -BEGUN || is_of_ball(&contact.key) {
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
                    is_right && apart + overlap < -BEGUN
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
    /// Takes up what was found in a wider search if some of that now overlaps which was not found before; false if none does.
    pub(super) fn take_up_wide(&mut self, group: &Group) -> bool {
        let mut new = self.seen.of_sheets().iter().filter(|c| self.found.place_of(&c.key).is_err());
        let overlaps = new.any(|contact| overlaps(group, contact));
        if overlaps {
            std::mem::swap(&mut self.found, &mut self.seen);
        }
        overlaps
    }

    /// Adds to what was found what else overlaps where contact has moved it, among what was seen there; whether there is any.
    pub(super) fn take_up_more(&mut self, group: &Group) -> bool {
        let Self { found, seen, .. } = self;
        let before = found.contacts.len();
        for (contact, part) in seen.of_sheets().iter().zip(&seen.parts) {
            if let (Err(at), true) = (found.place_of(&contact.key), overlaps(group, contact)) {
                found.insert(at, *contact, *part);
            }
        }
        found.contacts.len() > before
    }

    /// Notes what of sheets has crossed, among what was seen.
    pub(super) fn note_crossed(&mut self, group: &Group) {
        let crossed = self.seen.of_sheets().iter().filter(|c| settled::has_crossed(group, c));
        let before = self.crossing.len();
        self.crossed = self.seen.cut;
        for contact in crossed {
            self.crossed = true;
            if !self.crossing[..before].iter().any(|c| c.key == contact.key) {
                self.crossing.push(*contact);
            }
        }
    }

    /// Adds to what was found what has crossed in earlier rounds: as it was seen before that.
    pub(super) fn take_up_crossed(&mut self) {
        for crossed in &self.crossing {
            match self.found.place_of(&crossed.key) {
                Ok(at) => self.found.contacts[at] = *crossed,
                Err(at) => self.found.insert(at, *crossed, u32::MAX),
            }
        }
    }
}

/// Whether a contact overlaps where contact moves its sides.
fn overlaps(group: &Group, contact: &Contact) -> bool {
    let [a, b] = [&contact.a, &contact.b].map(|side| place(group, side, At::Free) + moved(group, side));
    contact.normal.dot(a - b) < contact.offset
}
