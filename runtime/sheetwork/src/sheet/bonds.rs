//! Adhesive bonds of a sheet: the forces that hold it to other sheets and to bodies.
//!
//! [`crate::contact::adhesion`] decides which contacts become bonds.

use glam::DVec3;

use crate::math::Vectors;
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::Sheet;
use crate::units::temperature::REFERENCE;

/// Bonds of a sheet and their forces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stuck {
    /// Bond force on each node in the next step, N.
    pub pull: Vectors,
    /// Bond force on each node in the last step, N.
    pub was_pull: Vectors,
    /// Bond forces on dynamic bodies: index in the bodies of the step, force (N), point in the
    /// body's frame (m).
    pub on_bodies: Vec<(u32, DVec3, DVec3)>,
    /// Whether each node has a bond.
    pub held: Vec<bool>,
    /// Whether each node had a bond in the last step.
    pub was_held: Vec<bool>,
    /// Direction from each node to its first contact.
    pub towards: Vec<DVec3>,
    /// Number of contacts of each node on the side of its first contact and on the other one.
    pub count: Vec<[u32; 2]>,
    /// Applied forces without the bond forces, to restore them after the step.
    pub applied: Vectors,
    /// Number of nodes with a bond.
    pub bonds: usize,
}

impl Stuck {
    /// Serialise the bonds.
    pub fn keep(&self, to: &mut Keeper) {
        to.vector_list(&self.pull);
        to.vector_list(&self.was_pull);
        to.count(self.on_bodies.len() as u64);
        for (body, force, at) in &self.on_bodies {
            to.count(u64::from(*body));
            to.vector(*force);
            to.vector(*at);
        }
        to.flags(&self.held);
        to.flags(&self.was_held);
        to.count(self.bonds as u64);
    }

    /// Deserialise the bonds of a sheet with `masses` nodes.
    pub fn taken(from: &mut Taker, masses: usize) -> Taken<Self> {
        let mut stuck = Self::default();
        from.vector_list(&mut stuck.pull, masses)?;
        from.vector_list(&mut stuck.was_pull, masses)?;
        for _ in 0..from.length(49)? {
            stuck.on_bodies.push((from.small()?, from.vector()?, from.vector()?));
        }
        from.flags(&mut stuck.held)?;
        from.flags(&mut stuck.was_held)?;
        stuck.bonds = from.length(0)?;
        if [stuck.pull.len(), stuck.was_pull.len(), stuck.held.len(), stuck.was_held.len()] != [masses; 4] {
            return Err(Cut);
        }
        (stuck.count, stuck.towards) = (vec![[0; 2]; masses], vec![DVec3::ZERO; masses]);
        stuck.applied = Vectors::zeros(masses);
        Ok(stuck)
    }

    /// Begin a new step: the present bonds become those of the last step.
    pub(crate) fn begin(&mut self, masses: usize) {
        if self.held.len() != masses {
            *self = Self { pull: Vectors::zeros(masses), held: vec![false; masses], ..Self::default() };
            (self.was_held, self.count) = (vec![false; masses], vec![[0; 2]; masses]);
            self.towards = vec![DVec3::ZERO; masses];
            (self.applied, self.was_pull) = (Vectors::zeros(masses), Vectors::zeros(masses));
        }
        std::mem::swap(&mut self.held, &mut self.was_held);
        std::mem::swap(&mut self.pull, &mut self.was_pull);
        self.held.fill(false);
        self.count.fill([0; 2]);
        self.pull.clear();
        self.on_bodies.clear();
        self.bonds = 0;
    }

    /// Count a contact of node `i` in direction `towards`.
    pub(crate) fn has_contact(&mut self, i: u32, towards: DVec3) {
        let i = i as usize;
        if self.count[i] == [0; 2] {
            self.towards[i] = towards;
        }
        self.count[i][usize::from(self.towards[i].dot(towards) < 0.0)] += 1;
    }

    /// Number of contacts of node `i` on the side of direction `towards`.
    pub(crate) fn contacts(&self, i: u32, towards: DVec3) -> u32 {
        let i = i as usize;
        self.count[i][usize::from(self.count[i] != [0; 2] && self.towards[i].dot(towards) < 0.0)]
    }
}

impl Sheet {
    /// Number of nodes of the sheet with a bond.
    pub fn bonds(&self) -> usize {
        self.work.stuck.as_ref().map_or(0, |s| s.bonds)
    }

    /// Add the bond forces to the applied forces.
    pub(crate) fn hold_on(&mut self) {
        if let Some(stuck) = &mut self.work.stuck {
            stuck.applied.copy_from(&self.applied);
            self.applied.add_scaled(1.0, &stuck.pull);
        }
    }

    /// Restore the applied forces without the bond forces.
    pub(crate) fn hold_no_more(&mut self) {
        if let Some(stuck) = &self.work.stuck {
            self.applied.copy_from(&stuck.applied);
        }
    }

    /// Remove all bonds.
    pub(crate) fn unstick(&mut self) {
        let masses = self.masses();
        if let Some(stuck) = &mut self.work.stuck {
            stuck.begin(masses);
        }
    }

    /// Temperature of node `i`, °C.
    pub(crate) fn celsius(&self, i: u32) -> f64 {
        let of_mass = self.temperatures().and_then(|t| t.get(i as usize).copied());
        of_mass.or_else(|| self.temperature()).unwrap_or(REFERENCE)
    }
}
