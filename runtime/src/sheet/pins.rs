//! Masses that do not move freely: held where they are, led along a path, or held in some directions only.

use glam::DVec3;

use super::Vectors;
use crate::scene::{PathKey, path_at};

/// The pins of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pins {
    groups: Vec<Group>,
    rails: Vec<Rail>,
}

#[derive(Clone, Debug, PartialEq)]
struct Group {
    masses: Vec<u32>,
    start: Vec<DVec3>,
    path: Vec<PathKey>,
}

/// A mass held along some of the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rail {
    mass: u32,
    held: [bool; 3],
    start: DVec3,
}

impl Pins {
    /// Pins `masses`, now at `start` (m), led along `path` (empty: held).
    pub fn add(&mut self, masses: Vec<u32>, start: Vec<DVec3>, path: Vec<PathKey>) {
        self.groups.push(Group { masses, start, path });
    }

    /// Holds `mass`, now at `start` (m), along the axes (x, y, z) that `held` names.
    pub fn add_rail(&mut self, mass: u32, start: DVec3, held: [bool; 3]) {
        self.rails.push(Rail { mass, held, start });
    }

    /// Whether nothing is pinned.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.rails.is_empty()
    }

    /// All masses that are pinned in every direction.
    pub fn masses(&self) -> impl Iterator<Item = u32> + '_ {
        self.groups.iter().flat_map(|g| g.masses.iter().copied())
    }

    /// Masses held along some axes only, and along which.
    pub fn rails(&self) -> impl Iterator<Item = (u32, [bool; 3])> + '_ {
        self.rails.iter().map(|r| (r.mass, r.held))
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
        self.hold_rails(v);
    }

    /// Puts every pinned mass exactly where it belongs at `t`: what an engine rounds must not add up.
    pub(crate) fn place(&self, t: f64, x: &mut Vectors) {
        for group in &self.groups {
            let offset = path_at(&group.path, t).0;
            for (i, start) in group.masses.iter().zip(&group.start) {
                x.set(*i as usize, *start + offset);
            }
        }
        for rail in &self.rails {
            let i = rail.mass as usize;
            x.set(i, rail.replaced(x.get(i), rail.start));
        }
    }

    /// Sets the held components of velocities, accelerations or forces to zero.
    pub(crate) fn hold_rails(&self, a: &mut Vectors) {
        for rail in &self.rails {
            let i = rail.mass as usize;
            a.set(i, rail.replaced(a.get(i), DVec3::ZERO));
        }
    }

    /// Copies the held components of `x` to `to`.
    pub(crate) fn follow_rails(&self, x: &Vectors, to: &mut Vectors) {
        for rail in &self.rails {
            let i = rail.mass as usize;
            to.set(i, rail.replaced(to.get(i), x.get(i)));
        }
    }
}

impl Rail {
    /// `p` with the held components of `q`.
    fn replaced(&self, p: DVec3, q: DVec3) -> DVec3 {
        let pick = |axis: usize| if self.held[axis] { q[axis] } else { p[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    }
}
