//! Masses that do not move freely: held where they are, or led along a path.

use glam::DVec3;

use super::Vectors;
use crate::scene::{PathKey, path_at};

/// The pins of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pins {
    groups: Vec<Group>,
}

#[derive(Clone, Debug, PartialEq)]
struct Group {
    masses: Vec<u32>,
    start: Vec<DVec3>,
    path: Vec<PathKey>,
}

impl Pins {
    /// Pins `masses`, now at `start` (m), led along `path` (empty: held).
    pub fn add(&mut self, masses: Vec<u32>, start: Vec<DVec3>, path: Vec<PathKey>) {
        self.groups.push(Group { masses, start, path });
    }

    /// Whether nothing is pinned.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// All pinned masses.
    pub fn masses(&self) -> impl Iterator<Item = u32> + '_ {
        self.groups.iter().flat_map(|g| g.masses.iter().copied())
    }

    /// Whether any pin moves between the times `from` and `to`, s.
    pub fn moving(&self, from: f64, to: f64) -> bool {
        self.groups.iter().any(|g| path_at(&g.path, from).0 != path_at(&g.path, to).0)
    }

    /// Gives every pinned mass the constant velocity that takes it to its place at `t + dt`.
    pub(crate) fn lead(&self, t: f64, dt: f64, x: &Vectors, v: &mut Vectors) {
        for group in &self.groups {
            let offset = path_at(&group.path, t + dt).0;
            for (i, start) in group.masses.iter().zip(&group.start) {
                let i = *i as usize;
                v.set(i, (*start + offset - x.get(i)) / dt);
            }
        }
    }

    /// Puts every pinned mass exactly where it belongs at `t`: what an engine rounds must not add up.
    pub(crate) fn place(&self, t: f64, x: &mut Vectors) {
        for group in &self.groups {
            let offset = path_at(&group.path, t).0;
            for (i, start) in group.masses.iter().zip(&group.start) {
                x.set(*i as usize, *start + offset);
            }
        }
    }
}
