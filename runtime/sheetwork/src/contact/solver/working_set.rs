//! Working set of the dual solvers. For each pair of sheets or bodies, a few contacts are added at
//! a time: the deepest first, then deep ones far from those already chosen. A sheet at rest needs
//! about forty of several hundred contacts, and each costs as much as all before it. Gaps in m.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::gap::ContactGaps;
use crate::contact::settings::{ContactSettings, WorkingSetSettings};
use crate::contact::workspace::ContactWorkspace;

const SETTINGS: WorkingSetSettings = ContactSettings::DEFAULT.working_set;

/// Working set of contacts.
#[derive(Default)]
pub(crate) struct WorkingSet {
    /// Whether each contact is active or excluded.
    is_active: Vec<bool>,
    /// Contacts to be added, as indices into the detected contacts.
    pub new: Vec<u32>,
    /// Squared distance of each violated contact from the nearest chosen one, m².
    reach: Vec<f64>,
    /// Violated contacts, sorted by pair.
    violated: Vec<(u64, u32)>,
    /// Active contacts, sorted by pair.
    active: Vec<(u64, u32)>,
}

impl WorkingSet {
    /// Start with an empty working set for `count` contacts.
    pub fn begin(&mut self, count: usize) {
        self.is_active.clear();
        self.is_active.resize(count, false);
        self.new.clear();
    }

    /// Mark the new contacts as active.
    pub fn activate(&mut self) {
        self.new.iter().for_each(|i| self.is_active[*i as usize] = true);
    }

    /// Whether contact `i` is active or excluded.
    pub fn is_active(&self, i: usize) -> bool {
        self.is_active[i]
    }

    /// Exclude contact `i`.
    pub fn exclude(&mut self, i: usize) {
        self.is_active[i] = true;
    }

    /// Add attachments, and contacts that have a cached force and penetrate.
    pub fn add_cached(&mut self, workspace: &ContactWorkspace) {
        for (i, contact) in workspace.detected.contacts.iter().enumerate() {
            let had_force = || workspace.cached_forces(&contact.key).is_some_and(|r| r.position != DVec3::ZERO);
            let was = workspace.gaps.free[i] < 0.0 && had_force();
            if (workspace.is_bilateral(i) || was) && !self.is_active[i] {
                self.new.push(i as u32);
            }
        }
    }

    /// Add the contact with the smallest gap, so that the set is not empty.
    pub fn add_deepest(&mut self, gap: &[f64]) {
        let all = (0..gap.len()).filter(|i| !self.is_active[*i]);
        self.new.extend(all.min_by(|a, b| gap[*a].total_cmp(&gap[*b])).map(|i| i as u32));
    }

    /// Add inactive contacts that penetrate by more than `depth`: the deepest of each pair, then
    /// deep ones far from the added and the `active` ones.
    pub fn add_violated(
        &mut self,
        workspace: &ContactWorkspace,
        gap: &[f64],
        depth: f64,
        active: impl Iterator<Item = usize>,
    ) {
        let contacts = &workspace.detected.contacts;
        self.new.clear();
        self.violated.clear();
        for (i, contact) in contacts.iter().enumerate() {
            if gap[i] < -depth && !self.is_active[i] {
                self.violated.push((pair_of(contact), i as u32));
            }
        }
        if self.violated.is_empty() {
            return;
        }
        self.violated.sort_unstable();
        self.active.clear();
        self.active.extend(active.map(|i| (pair_of(&contacts[i]), i as u32)));
        self.active.sort_unstable();
        let (mut violated, mut held) = (self.violated.as_slice(), self.active.as_slice());
        while let Some((pair, _)) = violated.first().copied() {
            let here = violated.partition_point(|v| v.0 == pair);
            let passed = held.partition_point(|v| v.0 < pair);
            held = &held[passed..];
            let own = held.partition_point(|v| v.0 == pair);
            let of_pair = (&violated[..here], &held[..own]);
            add_from_pair(of_pair, gap, &workspace.gaps, (&mut self.reach, &mut self.new));
            violated = &violated[here..];
        }
        self.new.sort_unstable();
    }
}

/// Number that identifies the pair of sheets or bodies of a contact.
fn pair_of(contact: &ContactConstraint) -> u64 {
    let thing = |side: &ContactSide| match side {
        ContactSide::Sheet { sheet, .. } => u64::from(*sheet) << 1,
        ContactSide::Body { body, .. } => u64::from(*body) << 1 | 1,
    };
    let (a, b) = (thing(&contact.a), thing(&contact.b));
    a.min(b) << 32 | a.max(b)
}

/// Append some of the `violated` contacts of a pair to `picks`; `held` are its active contacts. The
/// score of a contact is its depth times the square of its distance from the chosen ones.
fn add_from_pair(
    (violated, held): (&[(u64, u32)], &[(u64, u32)]),
    gap: &[f64],
    gaps: &ContactGaps,
    (reach, picks): (&mut Vec<f64>, &mut Vec<u32>),
) {
    let most = SETTINGS.minimum_addition.max(held.len() / 2);
    let depth = |k: usize| -gap[violated[k].1 as usize];
    let apart = |k: usize, other: u32| {
        gaps.positions_a[violated[k].1 as usize].distance_squared(gaps.positions_a[other as usize])
    };
    reach.clear();
    reach.resize(violated.len(), f64::INFINITY);
    for (k, reach) in reach.iter_mut().enumerate() {
        *reach = held.iter().fold(*reach, |least, (_, other)| least.min(apart(k, *other)));
    }
    let deeper = |a: &usize, b: &usize| depth(*a).total_cmp(&depth(*b)).then(b.cmp(a));
    let mut next = (0..violated.len()).max_by(deeper);
    let first = picks.len();
    while let Some(picked) = next {
        let contact = violated[picked].1;
        picks.push(contact);
        if picks.len() - first >= most {
            break;
        }
        let mut best = (0.0, None);
        for (k, reach) in reach.iter_mut().enumerate() {
            *reach = reach.min(apart(k, contact));
            let score = *reach * depth(k);
            if score > best.0 {
                best = (score, Some(k));
            }
        }
        next = best.1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::contact_cache::CachedForces;
    use crate::contact::gap::node_side;
    use crate::contact::test_island::{body_side, contact, list, on_plane};

    /// A workspace with one contact per entry of `depths` (m) at x = 0, 1, 2, ... m, on body 0.
    fn row_of_contacts(depths: &[f64]) -> ContactWorkspace {
        let contacts: Vec<ContactConstraint> = (0..depths.len() as u32).map(|i| on_plane(i, DVec3::Y)).collect();
        let mut workspace = ContactWorkspace::default();
        list(&contacts, &mut workspace.detected);
        workspace.gaps.free = depths.iter().map(|depth| -depth).collect();
        workspace.gaps.positions_a = (0..depths.len()).map(|i| DVec3::new(i as f64, 0.0, 0.0)).collect();
        workspace
    }

    fn begun(workspace: &ContactWorkspace) -> WorkingSet {
        let mut set = WorkingSet::default();
        set.begin(workspace.detected.contacts.len());
        set
    }

    fn add_violated(set: &mut WorkingSet, workspace: &ContactWorkspace, active: &[usize]) {
        set.add_violated(workspace, &workspace.gaps.free, 1e-6, active.iter().copied());
    }

    #[test]
    fn deepest_contact_is_followed_by_distant_ones() {
        // The first contact is the deepest, 0. Each further one has the largest depth times squared
        // distance from the chosen ones: 7; 3 (3 m from 0; 4 is as far from 7); 5; 1 and 2, the
        // first of those at 1 m.
        let workspace = row_of_contacts(&[2e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3]);
        let mut set = begun(&workspace);
        add_violated(&mut set, &workspace, &[]);
        assert_eq!(set.new, [0, 1, 2, 3, 5, 7]);
    }

    #[test]
    fn contacts_that_are_open_or_active_are_not_added() {
        let workspace = row_of_contacts(&[1e-3, -1e-3, 1e-7, 1e-3]);
        let mut set = begun(&workspace);
        add_violated(&mut set, &workspace, &[]);
        assert_eq!(set.new, [0, 3], "contact 1 is open, and contact 2 within the tolerance");
        set.activate();
        assert!(set.is_active(0) && !set.is_active(1));
        add_violated(&mut set, &workspace, &[0, 3]);
        assert!(set.new.is_empty());
    }

    #[test]
    fn excluded_contacts_are_not_added() {
        let workspace = row_of_contacts(&[1e-3, 1e-3]);
        let mut set = begun(&workspace);
        set.exclude(0);
        add_violated(&mut set, &workspace, &[]);
        assert_eq!(set.new, [1]);
    }

    #[test]
    fn every_pair_adds_up_to_six_contacts() {
        // Two contacts of the sheet with body 0 and eight with body 1, which adds six.
        let mut workspace = row_of_contacts(&[1e-3; 10]);
        for (i, constraint) in workspace.detected.contacts.iter_mut().enumerate() {
            let body = u32::from(i >= 2);
            *constraint = contact(i as u32, node_side(0, i as u32), body_side(body, DVec3::ZERO), DVec3::Y);
        }
        let mut set = begun(&workspace);
        add_violated(&mut set, &workspace, &[]);
        let of_first = set.new.iter().filter(|i| **i < 2).count();
        assert_eq!((of_first, set.new.len()), (2, 8));
    }

    #[test]
    fn cached_contacts_join_if_they_penetrate_and_attachments_always() {
        let mut workspace = row_of_contacts(&[1e-3, 1e-3, -1e-3, -1e-3]);
        workspace.detected.first_attachment = 3;
        let keys = [1, 2].map(|i| workspace.detected.contacts[i].key);
        workspace.cache.replace(|_, new| {
            new.extend(keys.map(|key| (key, CachedForces { position: DVec3::Y, ..CachedForces::default() })));
        });
        let mut set = begun(&workspace);
        set.add_cached(&workspace);
        assert_eq!(set.new, [1, 3], "contact 0 has no cached force, and contact 2 is open");
    }

    #[test]
    fn smallest_gap_is_added_where_nothing_penetrates() {
        let workspace = row_of_contacts(&[-3e-3, -1e-3, -2e-3]);
        let mut set = begun(&workspace);
        set.add_deepest(&workspace.gaps.free);
        assert_eq!(set.new, [1]);
    }
}
