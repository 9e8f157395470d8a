//! Forces of contacts from one solve to the next, by the names of the contacts: where a solver begins.

use glam::DVec3;

use super::find::thing;
use super::row::Key;
use crate::kept::{Keeper, Taken, Taker};

/// Forces of one contact in the world, N: that of the position solve and that of the velocity solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Remembered {
    pub position: DVec3,
    pub velocity: DVec3,
    /// Whether it slid in the one and in the other: a force at the limit of friction does not say.
    pub slides: [bool; 2],
}

/// What is remembered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    entries: Vec<(Key, Remembered)>,
    next: Vec<(Key, Remembered)>,
}

impl Memory {
    /// What is remembered of `key`.
    pub fn of(&self, key: &Key) -> Option<Remembered> {
        let found = self.entries.binary_search_by(|(k, _)| k.cmp(key));
        found.ok().map(|i| self.entries[i].1)
    }

    /// What is remembered of `key`, or where there is nothing, of the contact that the same feature had with another place of the
    /// same thing: what slides or trembles goes from triangle to triangle.
    pub fn near(&self, key: &Key) -> Option<Remembered> {
        let other = |key: &Key| thing(key[1]);
        self.of(key).or_else(|| {
            let from = self.entries.partition_point(|(k, _)| k[0] < key[0]);
            let same = self.entries[from..].iter().take_while(|(k, _)| k[0] == key[0]);
            same.filter(|(k, _)| other(k) == other(key)).map(|(_, f)| *f).next()
        })
    }

    /// Replaces everything: contacts without a force are forgotten.
    pub fn replace(&mut self, mut entries: impl FnMut(&Self, &mut Vec<(Key, Remembered)>)) {
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        entries(self, &mut next);
        next.retain(|(_, f)| f.position != DVec3::ZERO || f.velocity != DVec3::ZERO);
        next.sort_by_key(|(key, _)| *key);
        self.next = std::mem::replace(&mut self.entries, next);
    }

    /// Copies from `other`, keeping the memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.entries.clone_from(&other.entries);
    }

    /// Keeps it for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        to.count(self.entries.len() as u64);
        for (key, of) in &self.entries {
            key.iter().for_each(|name| to.count(name.rotate_left(8)));
            let (p, v) = (of.position, of.velocity);
            to.sparse(&[p.x, p.y, p.z, v.x, v.y, v.z]);
            to.byte(u8::from(of.slides[0]) | u8::from(of.slides[1]) << 1);
        }
    }

    /// Takes it back.
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        self.entries.clear();
        for _ in 0..from.length(4)? {
            let key = [from.count()?.rotate_right(8), from.count()?.rotate_right(8)];
            let mut both = [0.0; 6];
            from.sparse(&mut both)?;
            let slides = from.byte()?;
            let (position, velocity) = (DVec3::from_slice(&both), DVec3::from_slice(&both[3..]));
            self.entries.push((key, Remembered { position, velocity, slides: [slides & 1 == 1, slides & 2 == 2] }));
        }
        Ok(())
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}
