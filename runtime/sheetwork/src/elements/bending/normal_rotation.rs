//! Couplings through the rotation of a group's normal: the nodes of the group and of its frame,
//! whose matrix blocks the tangent of rest curvature fills. Groups without rest curvature do not
//! use them.

use crate::elements::bending::{Bending, NO_BLOCK};

/// Two nodes of a group or its frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodePair {
    pub block: u32,
    /// Positions of the two nodes among the group's nodes.
    pub of: (u32, u32),
}

/// The nodes of all groups and of their frames, group by group.
#[derive(Clone, Debug, Default)]
pub(crate) struct NormalRotation {
    /// Ascending in each group, so that pairs lie in the lower triangle.
    masses: Vec<u32>,
    /// Weights of each node in its group, 1/m²; zero for a node of the frame alone.
    weights: Vec<[f64; 3]>,
    couples: Vec<NodePair>,
    /// Ends of the nodes and the pairs of each group.
    ends: Vec<(u32, u32)>,
    /// Positions of the frame's nodes among the group's nodes.
    pub frame: Vec<[u32; 4]>,
}

impl NormalRotation {
    pub fn new(bending: &Bending) -> Self {
        let mut all = Self::default();
        for group in &bending.groups {
            let mut own: Vec<(u32, [f64; 3])> = bending.entries(group).map(|(m, w)| (m as u32, *w)).collect();
            for mass in group.frame {
                if own.iter().all(|(m, _)| *m != mass) {
                    own.push((mass, [0.0; 3]));
                }
            }
            own.sort_by_key(|(m, _)| *m);
            for p in 0..own.len() as u32 {
                all.couples.extend((0..=p).map(|q| NodePair { block: NO_BLOCK, of: (p, q) }));
            }
            all.masses.extend(own.iter().map(|(m, _)| m));
            all.weights.extend(own.iter().map(|(_, w)| w));
            all.ends.push((all.masses.len() as u32, all.couples.len() as u32));
        }
        all.find_frames(bending);
        all
    }

    /// Finds the positions of the frames' nodes, which open cells change.
    pub fn find_frames(&mut self, bending: &Bending) {
        let place = |i: usize, mass: u32| self.masses_of(i).iter().position(|m| *m == mass).unwrap_or(0) as u32;
        self.frame = bending.groups.iter().enumerate().map(|(i, g)| g.frame.map(|m| place(i, m))).collect();
    }

    fn first(&self, i: usize) -> (usize, usize) {
        i.checked_sub(1).map_or((0, 0), |before| (self.ends[before].0 as usize, self.ends[before].1 as usize))
    }

    /// Nodes of group `i` and of its frame.
    pub fn masses_of(&self, i: usize) -> &[u32] {
        &self.masses[self.first(i).0..self.ends[i].0 as usize]
    }

    /// Pairs of nodes of group `i`.
    pub fn pairs_of(&self, i: usize) -> &[NodePair] {
        &self.couples[self.first(i).1..self.ends[i].1 as usize]
    }

    /// Weights of the nodes of group `i`, 1/m².
    pub fn weights_of(&self, i: usize) -> &[[f64; 3]] {
        &self.weights[self.first(i).0..self.ends[i].0 as usize]
    }

    /// Largest number of nodes of a group.
    pub fn largest_group(&self) -> usize {
        (0..self.ends.len()).map(|i| self.masses_of(i).len()).max().unwrap_or(0)
    }

    /// Visits every pair of nodes with a common block.
    pub fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        for i in 0..self.ends.len() {
            let masses = self.masses_of(i);
            for (p, a) in masses.iter().enumerate() {
                masses[..p].iter().for_each(|b| visit(*a, *b));
            }
        }
    }

    /// Stores the indices of the matrix blocks.
    pub fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for i in 0..self.ends.len() {
            let (masses, couples) = self.first(i);
            for couple in &mut self.couples[couples..self.ends[i].1 as usize] {
                let [a, b] = [couple.of.0, couple.of.1].map(|place| self.masses[masses + place as usize]);
                couple.block = block(a, b);
            }
        }
    }
}
