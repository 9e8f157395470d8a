//! Clearance cache: nodes that cannot have reached a body since their last distance test are
//! skipped.
//!
//! A node at c that is at least d away from every body cannot meet one while it stays within d of
//! c, minus the distance that bodies have moved since. The test compares only positions, so that it
//! holds for any cause of motion (integrator, attachment, user code). Steps with and without the
//! cache give the same result.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;

use crate::contact::node::response::{NodeContactSurface, NodePath};
use crate::contact::node::target::NO_FACE;
use crate::math::Vectors;
use crate::serialize::{ReadResult, StateReader, StateWriter};

/// Clearances of the nodes of a sheet.
#[derive(Default)]
pub(crate) struct Clearance {
    /// Position of each node at its last distance test, m.
    tested_at: Vectors,
    /// Value of `moved` (m) up to which the clearance of an unmoved node holds; -∞ without a test.
    valid_until: Vec<f64>,
    /// Accumulated displacement bound of the fastest body, m.
    moved: f64,
    /// Distance of each node to the nearest body in this step, m; negative for skipped nodes.
    pub nearest: Vec<f64>,
    /// Collider and face nearest to each node at its last test.
    pub nearest_face: Vec<(ColliderHandle, u32)>,
    /// Nodes with contacts on two bodies in this step, whose response to one may have moved them
    /// into the other.
    pub between_bodies: Vec<u32>,
    /// Nodes with contact in this step.
    pub hits: Vec<u32>,
    /// First hit of each node in this step.
    pub first_hit: Vec<Option<FirstHit>>,
    /// Nodes with contact in this step and their surfaces, for sheets whose drawn surface meets
    /// bodies.
    pub node_surfaces: Vec<(u32, NodeContactSurface)>,
    /// Remaining paths of nodes after their contact.
    pub remaining_paths: Vec<RemainingPath>,
    /// Remaining paths of the previous iteration.
    pub previous_remaining_paths: Vec<RemainingPath>,
}

/// First hit of a node in a step.
#[derive(Clone, Copy)]
pub(crate) struct FirstHit {
    pub collider: ColliderHandle,
    pub face: u32,
    pub surface: NodeContactSurface,
    /// Time of impact as a fraction of the step.
    pub tau: f64,
    /// Whether the path also meets another collider.
    pub another: bool,
}

/// Path of a node from its contact to the end of the step.
#[derive(Clone, Copy)]
pub(crate) struct RemainingPath {
    pub node: u32,
    /// Collider of the contact.
    pub from: ColliderHandle,
    /// Normal at the contact.
    pub normal: DVec3,
    pub flight: NodePath,
}

impl Clearance {
    /// Clear the cache: every node is tested in the next step.
    pub fn clear(&mut self) {
        self.valid_until.fill(f64::NEG_INFINITY);
    }

    /// Serialise the clearances; `forgotten` states that the cache is to be cleared.
    pub fn serialise(&self, to: &mut StateWriter, forgotten: bool) {
        to.vector_list(&self.tested_at);
        if forgotten {
            to.numbers(&vec![f64::NEG_INFINITY; self.valid_until.len()]);
        } else {
            to.numbers(&self.valid_until);
        }
        to.number(self.moved);
        for (collider, face) in &self.nearest_face {
            let (index, generation) = collider.into_raw_parts();
            [index, generation, *face].into_iter().for_each(|v| to.count(u64::from(v)));
        }
    }

    /// Deserialise the clearances of a sheet with `masses` nodes.
    pub fn deserialise(&mut self, from: &mut StateReader, masses: usize) -> ReadResult {
        *self = Self::default();
        let mut checked = Vectors::default();
        from.vector_list(&mut checked, masses)?;
        if !checked.is_empty() {
            self.size(masses);
        }
        self.tested_at = checked;
        from.numbers(&mut self.valid_until)?;
        self.moved = from.number()?;
        for face in &mut self.nearest_face {
            *face = (ColliderHandle::from_raw_parts(from.count_u32()?, from.count_u32()?), from.count_u32()?);
        }
        Ok(())
    }

    fn size(&mut self, masses: usize) {
        self.tested_at = Vectors::zeros(masses);
        self.valid_until = vec![f64::NEG_INFINITY; masses];
        self.nearest = vec![0.0; masses];
        self.nearest_face = vec![(ColliderHandle::invalid(), NO_FACE); masses];
        self.between_bodies = Vec::with_capacity(masses);
        self.hits = Vec::with_capacity(masses);
        self.first_hit = vec![None; masses];
        self.remaining_paths = Vec::with_capacity(masses);
        self.previous_remaining_paths = Vec::with_capacity(masses);
    }

    /// Whether node `i` was never tested; its depth inside a body is then unbounded.
    pub fn is_new(&self, i: usize) -> bool {
        self.valid_until[i] == f64::NEG_INFINITY
    }

    /// Begin a step in which bodies move by at most `reach` (m). Sets `nearest` to `margin` (m) for
    /// nodes that must be tested, given positions `x` (m), dynamic nodes `free` and the contact
    /// offset `offset` (m), and to -1 for all others. Returns false if there are none.
    pub fn begin(&mut self, x: &Vectors, free: impl Fn(usize) -> bool, reach: f64, margin: f64, offset: f64) -> bool {
        if self.valid_until.len() != x.len() {
            self.size(x.len());
        }
        self.between_bodies.clear();
        self.remaining_paths.clear();
        self.hits.clear();
        self.node_surfaces.clear();
        self.moved += reach;
        let mut any = false;
        for i in 0..x.len() {
            let slack = self.valid_until[i] - self.moved - 2.0 * offset;
            let clear = slack > 0.0 && x.get(i).distance_squared(self.tested_at.get(i)) < slack * slack;
            let mode = !clear && free(i);
            self.nearest[i] = if mode { margin } else { -1.0 };
            any |= mode;
        }
        any
    }

    /// Whether node `i` at `end` (m) is clear of every body, contact offset `offset` (m) included,
    /// given its position `tested` (m) if this step tested it.
    pub fn is_clear(&self, i: usize, end: DVec3, tested: DVec3, offset: f64) -> bool {
        let Some(near) = self.nearest.get(i) else { return true };
        let (distance, from) =
            if *near < 0.0 { (self.valid_until[i] - self.moved, self.tested_at.get(i)) } else { (*near, tested) };
        let slack = distance - 2.0 * offset;
        slack > 0.0 && end.distance_squared(from) < slack * slack
    }

    /// End the step: store positions and distances of the nodes that were tested.
    pub fn end(&mut self, x: &Vectors) {
        for i in (0..x.len()).filter(|i| self.nearest[*i] >= 0.0) {
            self.tested_at.set(i, x.get(i));
            self.valid_until[i] = self.nearest[i] + self.moved;
        }
    }
}
