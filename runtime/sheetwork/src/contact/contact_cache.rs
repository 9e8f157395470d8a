//! Contact cache: contact forces from one solve to the next, by contact key, for the warm start of
//! the solvers.

use glam::DVec3;

use crate::collision::constraint::ContactKey;
use crate::collision::narrow_phase::{feature_owner, without_sheet};
use crate::serialize::{ReadResult, StateReader, StateWriter};

/// Cached forces of one contact, in world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CachedForces {
    /// Force of the position solve, N.
    pub position: DVec3,
    /// Force of the velocity solve, N.
    pub velocity: DVec3,
    /// Whether the contact slipped in the position solve and in the velocity solve. A force on the
    /// friction bound alone does not tell.
    pub slipped: [bool; 2],
}

/// Contact cache, sorted by key.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactCache {
    entries: Vec<(ContactKey, CachedForces)>,
    next: Vec<(ContactKey, CachedForces)>,
}

impl ContactCache {
    /// Cached forces of the contact `key`.
    pub fn of(&self, key: &ContactKey) -> Option<CachedForces> {
        let found = self.entries.binary_search_by(|(k, _)| k.cmp(key));
        found.ok().map(|i| self.entries[i].1)
    }

    /// Cached forces of the contact `key`, or, if absent, of a contact between the same feature and
    /// another place of the same sheet or body. A contact that slips or oscillates moves from
    /// triangle to triangle.
    pub fn of_feature(&self, key: &ContactKey) -> Option<CachedForces> {
        let other = |key: &ContactKey| feature_owner(key[1]);
        self.of(key).or_else(|| {
            let from = self.entries.partition_point(|(k, _)| k[0] < key[0]);
            let same = self.entries[from..].iter().take_while(|(k, _)| k[0] == key[0]);
            same.filter(|(k, _)| other(k) == other(key)).map(|(_, f)| *f).next()
        })
    }

    /// Replace all entries; contacts without force are dropped.
    pub fn replace(&mut self, mut entries: impl FnMut(&Self, &mut Vec<(ContactKey, CachedForces)>)) {
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        entries(self, &mut next);
        next.retain(|(_, f)| f.position != DVec3::ZERO || f.velocity != DVec3::ZERO);
        next.sort_by_key(|(key, _)| *key);
        self.next = std::mem::replace(&mut self.entries, next);
    }

    /// Copy from `other`, reusing the allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.entries.clone_from(&other.entries);
    }

    /// Serialise the cache.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.count(self.entries.len() as u64);
        for (key, of) in &self.entries {
            key.iter().for_each(|name| to.count(name.rotate_left(8)));
            let (p, v) = (of.position, of.velocity);
            to.sparse(&[p.x, p.y, p.z, v.x, v.y, v.z]);
            to.byte(u8::from(of.slipped[0]) | u8::from(of.slipped[1]) << 1);
        }
    }

    /// Deserialise the cache.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.entries.clear();
        for _ in 0..from.length(4)? {
            let key = [from.count()?.rotate_right(8), from.count()?.rotate_right(8)];
            let both: [f64; 6] = from.sparse_array()?;
            let slides = from.byte()?;
            let (position, velocity) = (DVec3::from_slice(&both), DVec3::from_slice(&both[3..]));
            self.entries.push((key, CachedForces { position, velocity, slipped: [slides & 1 == 1, slides & 2 == 2] }));
        }
        Ok(())
    }

    /// Remove the contacts of the sheet `id`, whose removal lowers higher identifiers by one.
    pub fn remove_sheet(&mut self, id: u32) {
        self.entries.retain_mut(|(key, _)| without_sheet(key, id).map(|moved| *key = moved).is_some());
    }

    /// Whether the cache is empty.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Remove all entries.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::narrow_phase::feature_keys::{FeatureKind, feature_key};

    /// Key of node `node` of sheet 0 on face `face` of body `body`.
    fn key(node: u32, body: u32, face: u32) -> ContactKey {
        [feature_key(FeatureKind::Node, 0, node), feature_key(FeatureKind::Face, body, face)]
    }

    fn forces(position: f64) -> CachedForces {
        let position = DVec3::new(0.1, position, -0.3);
        CachedForces { position, velocity: position * 0.5, slipped: [true, false] }
    }

    fn filled(entries: &[(ContactKey, CachedForces)]) -> ContactCache {
        let mut cache = ContactCache::default();
        cache.replace(|_, new| new.extend_from_slice(entries));
        cache
    }

    #[test]
    fn forces_are_found_by_key_in_any_order_of_insertion() {
        let cache = filled(&[(key(5, 0, 0), forces(5.0)), (key(1, 0, 0), forces(1.0)), (key(3, 2, 0), forces(3.0))]);
        for (node, body) in [(1, 0), (3, 2), (5, 0)] {
            assert_eq!(cache.of(&key(node, body, 0)), Some(forces(f64::from(node))));
        }
        assert_eq!(cache.of(&key(1, 2, 0)), None);
    }

    #[test]
    fn force_follows_a_node_to_another_face_of_the_same_body_only() {
        let cache = filled(&[(key(1, 0, 4), forces(1.0)), (key(1, 2, 0), forces(2.0))]);
        assert_eq!(cache.of_feature(&key(1, 0, 7)), Some(forces(1.0)));
        assert_eq!(cache.of_feature(&key(1, 2, 7)), Some(forces(2.0)));
        assert_eq!(cache.of_feature(&key(1, 3, 4)), None, "another body");
        assert_eq!(cache.of_feature(&key(2, 0, 4)), None, "another node");
    }

    #[test]
    fn contacts_without_force_are_dropped() {
        let cache = filled(&[(key(1, 0, 0), CachedForces { slipped: [true; 2], ..CachedForces::default() })]);
        assert!(cache.is_empty());
    }

    #[test]
    fn deserialised_cache_returns_the_same_forces() {
        let cache = filled(&[(key(1, 0, 0), forces(1.0 / 3.0)), (key(9, 1, 3), forces(-0.0))]);
        let mut writer = StateWriter::default();
        cache.serialise(&mut writer);
        let mut restored = filled(&[(key(4, 0, 0), forces(4.0))]);
        let mut reader = StateReader::new(&writer.bytes);
        restored.deserialise(&mut reader).expect("what was written");
        assert!(reader.is_empty());
        assert_eq!(restored.entries, cache.entries);
    }

    #[test]
    fn truncated_cache_is_an_error() {
        let mut writer = StateWriter::default();
        filled(&[(key(1, 0, 0), forces(1.0))]).serialise(&mut writer);
        for length in 0..writer.bytes.len() {
            let read = ContactCache::default().deserialise(&mut StateReader::new(&writer.bytes[..length]));
            assert!(read.is_err(), "{length} of {} bytes", writer.bytes.len());
        }
    }
}
