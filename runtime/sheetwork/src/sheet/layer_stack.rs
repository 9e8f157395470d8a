//! Layers of a lattice: connections of every node to the layers below and above, and impacts that
//! layers share.

use glam::DVec3;

use crate::elements::spring::Springs;
use crate::mesh::spring_class::SpringClass;

/// Impact on a node in this step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerImpact {
    /// Share of the impact, 0 (none) to 1.
    pub share: f64,
    /// Outward unit normal of the body.
    pub normal: DVec3,
    /// Velocity of the body at the contact, m/s.
    pub body: DVec3,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Remaining time of the step after the impact, s.
    pub rest: f64,
}

/// Connections of every node to the layers below and above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerStack {
    pub(crate) layers: u32,
    pub(crate) layer_of: Vec<u32>,
    pub(crate) below: NeighbourLists,
    pub(crate) above: NeighbourLists,
}

/// Lists of connected nodes, one per node, stored in one array.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct NeighbourLists {
    first: Vec<u32>,
    list: Vec<u32>,
}

impl NeighbourLists {
    fn new(lists: &[Vec<u32>]) -> Self {
        let mut all = Self { first: vec![0], list: Vec::new() };
        for list in lists {
            all.list.extend_from_slice(list);
            all.first.push(all.list.len() as u32);
        }
        all
    }

    pub(crate) fn of(&self, i: usize) -> &[u32] {
        &self.list[self.first[i] as usize..self.first[i + 1] as usize]
    }
}

impl LayerStack {
    /// Build the connections from the inter-layer springs of a lattice and the layer of every node.
    pub fn new(springs: &Springs, layer_of: &[u32]) -> Self {
        let mut below = vec![Vec::new(); layer_of.len()];
        let mut above = vec![Vec::new(); layer_of.len()];
        for i in (0..springs.len()).filter(|i| springs.class[*i] == SpringClass::Inter) {
            let (a, b) = (springs.a[i], springs.b[i]);
            let (low, high) = if layer_of[a as usize] < layer_of[b as usize] { (a, b) } else { (b, a) };
            below[high as usize].push(low);
            above[low as usize].push(high);
        }
        Self {
            layers: layer_of.iter().max().map_or(0, |l| l + 1),
            layer_of: layer_of.to_vec(),
            below: NeighbourLists::new(&below),
            above: NeighbourLists::new(&above),
        }
    }

    /// Nodes of the smaller (odd) layers, each with its connected nodes in the layer below and,
    /// separately, in the layer above.
    pub fn cells(&self) -> impl Iterator<Item = (u32, &[u32])> {
        let small = |i: &usize| self.layer_of[*i] % 2 == 1;
        let masses = (0..self.layer_of.len()).filter(small);
        masses.flat_map(|i| [(i as u32, self.below.of(i)), (i as u32, self.above.of(i))])
    }

    /// Whether the sheet has more than one layer.
    pub fn is_layered(&self) -> bool {
        self.layers > 1
    }
}
