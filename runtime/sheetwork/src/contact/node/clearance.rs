//! Clearance cache: nodes that cannot have reached a body since their last distance test are
//! skipped.
//!
//! A node at c that is at least d away from every body cannot meet one while it stays within d of
//! c, minus the distance that bodies have moved since. The test compares only positions, so that it
//! holds for any cause of motion (integrator, attachment, user code). Steps with and without the
//! cache give the same result.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;

use crate::contact::node::response::{Flight, Surface};
use crate::contact::node::target::NO_FACE;
use crate::math::Vectors;
use crate::serialize::{Keeper, Taken, Taker};

/// Clearances of the nodes of a sheet.
#[derive(Default)]
pub(crate) struct Clearance {
    /// Position of each node at its last distance test, m.
    checked: Vectors,
    /// Value of `moved` (m) up to which the clearance of an unmoved node holds; -∞ without a test.
    until: Vec<f64>,
    /// Accumulated displacement bound of the fastest body, m.
    moved: f64,
    /// Distance of each node to the nearest body in this step, m; negative for skipped nodes.
    pub nearest: Vec<f64>,
    /// Collider and face nearest to each node at its last test.
    pub face: Vec<(ColliderHandle, u32)>,
    /// Nodes with contacts on two bodies in this step, whose response to one may have moved them
    /// into the other.
    pub cornered: Vec<u32>,
    /// Nodes with contact in this step.
    pub met: Vec<u32>,
    /// First hit of each node in this step.
    pub first: Vec<Option<First>>,
    /// Remaining paths of nodes after their contact.
    pub legs: Vec<Leg>,
    /// Remaining paths of the previous iteration.
    pub last_legs: Vec<Leg>,
}

/// First hit of a node in a step.
#[derive(Clone, Copy)]
pub(crate) struct First {
    pub collider: ColliderHandle,
    pub face: u32,
    pub surface: Surface,
    /// Time of impact as a fraction of the step.
    pub tau: f64,
    /// Whether the path also meets another collider.
    pub another: bool,
}

/// Path of a node from its contact to the end of the step.
#[derive(Clone, Copy)]
pub(crate) struct Leg {
    pub mass: u32,
    /// Collider of the contact.
    pub from: ColliderHandle,
    /// Normal at the contact.
    pub normal: DVec3,
    pub flight: Flight,
}

impl Clearance {
    /// Clear the cache: every node is tested in the next step.
    pub fn forget(&mut self) {
        self.until.fill(f64::NEG_INFINITY);
    }

    /// Serialise the clearances; `forgotten` states that the cache is to be cleared.
    pub fn keep(&self, to: &mut Keeper, forgotten: bool) {
        to.vector_list(&self.checked);
        if forgotten {
            to.numbers(&vec![f64::NEG_INFINITY; self.until.len()]);
        } else {
            to.numbers(&self.until);
        }
        to.number(self.moved);
        for (collider, face) in &self.face {
            let (index, generation) = collider.into_raw_parts();
            [index, generation, *face].into_iter().for_each(|v| to.count(u64::from(v)));
        }
    }

    /// Deserialise the clearances of a sheet with `masses` nodes.
    pub fn take(&mut self, from: &mut Taker, masses: usize) -> Taken {
        *self = Self::default();
        let mut checked = Vectors::default();
        from.vector_list(&mut checked, masses)?;
        if !checked.is_empty() {
            self.size(masses);
        }
        self.checked = checked;
        from.numbers(&mut self.until)?;
        self.moved = from.number()?;
        for face in &mut self.face {
            *face = (ColliderHandle::from_raw_parts(from.small()?, from.small()?), from.small()?);
        }
        Ok(())
    }

    fn size(&mut self, masses: usize) {
        self.checked = Vectors::zeros(masses);
        self.until = vec![f64::NEG_INFINITY; masses];
        self.nearest = vec![0.0; masses];
        self.face = vec![(ColliderHandle::invalid(), NO_FACE); masses];
        self.cornered = Vec::with_capacity(masses);
        self.met = Vec::with_capacity(masses);
        self.first = vec![None; masses];
        self.legs = Vec::with_capacity(masses);
        self.last_legs = Vec::with_capacity(masses);
    }

    /// Whether node `i` was never tested; its depth inside a body is then unbounded.
    pub fn is_new(&self, i: usize) -> bool {
        self.until[i] == f64::NEG_INFINITY
    }

    /// Begin a step in which bodies move by at most `reach` (m). Sets `nearest` to `margin` (m) for
    /// nodes that must be tested, given positions `x` (m), dynamic nodes `free` and the contact
    /// offset `offset` (m), and to -1 for all others. Returns false if there are none.
    pub fn begin(&mut self, x: &Vectors, free: impl Fn(usize) -> bool, reach: f64, margin: f64, offset: f64) -> bool {
        if self.until.len() != x.len() {
            self.size(x.len());
        }
        self.cornered.clear();
        self.legs.clear();
        self.met.clear();
        self.moved += reach;
        let mut any = false;
        for i in 0..x.len() {
            let slack = self.until[i] - self.moved - 2.0 * offset;
            let clear = slack > 0.0 && x.get(i).distance_squared(self.checked.get(i)) < slack * slack;
            let look = !clear && free(i);
            self.nearest[i] = if look { margin } else { -1.0 };
            any |= look;
        }
        any
    }

    /// End the step: store positions and distances of the nodes that were tested.
    pub fn end(&mut self, x: &Vectors) {
        for i in (0..x.len()).filter(|i| self.nearest[*i] >= 0.0) {
            self.checked.set(i, x.get(i));
            self.until[i] = self.nearest[i] + self.moved;
        }
    }
}
