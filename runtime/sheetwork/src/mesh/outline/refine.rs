//! Local refinement of a triangle mesh: every base triangle has a level, the number of times that
//! it is divided into four similar triangles.
//!
//! Red-green refinement (Bank, Sherman, Weiser, "Refinement algorithms and data structures for
//! regular local mesh refinement", 1983). A triangle is divided into four at the middles of its
//! edges
//!
//! - while its level is below that of its base triangle;
//! - where two or three of its edges are divided by neighbours;
//! - where half of one of its edges is divided again.
//!
//! Afterwards a triangle with one divided edge is halved at its middle. Halves are not divided
//! further: each mesh is built from the base mesh anew, so that the quality of a triangle is at
//! least 0.4 of that of its base triangle. The result is the smallest such mesh and depends on the
//! levels only.
//!
//! Nodes of the base mesh keep their indices and new nodes follow. A node is a fixed combination
//! of the corners of its base triangle ([`NodeKey`]), by which two refinements of a base mesh find
//! the nodes that they share. New nodes of a curved boundary lie on the chords of the base mesh, so
//! that area and mass are those of the base mesh. Positions in m.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::error::{InputError, reject_if};
use crate::mesh::outline::mesh::TriangleMesh;

/// Corners of a base triangle and their weights, by corner; unused entries have the weight 0. The
/// sum of the weights is 256.
pub type NodeKey = [(u32, u32); 3];

/// Sum of the weights of a key. It can be halved once for every level, and once more.
pub const KEY_WEIGHT: u32 = 256;

/// Refinement of a base mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// Mesh without refinement.
    pub base: Arc<TriangleMesh>,
    /// Level of each triangle of the base mesh.
    pub levels: Arc<[u8]>,
    /// Key of each node.
    pub keys: Vec<NodeKey>,
    /// Base triangle of each triangle.
    pub parents: Vec<u32>,
}

/// Triangle that has not been divided.
struct Leaf {
    nodes: [u32; 3],
    parent: u32,
    level: u8,
}

/// Refinement in progress.
struct Builder {
    keys: Vec<NodeKey>,
    /// Node in the middle of each divided edge.
    middles: BTreeMap<(u32, u32), u32>,
}

impl Refinement {
    /// Refine `base` to `levels`, one per triangle.
    ///
    /// # Errors
    /// When there are more or fewer levels than triangles, or a level is above 3.
    pub fn new(base: Arc<TriangleMesh>, levels: Arc<[u8]>) -> Result<(TriangleMesh, Self), InputError> {
        let (given, count) = (levels.len(), base.triangles.len());
        let is_wrong = given != count || levels.iter().any(|l| *l > 3);
        reject_if!(is_wrong, "refine", "has {given} levels of 0 to 3, for {count} triangles");
        let key = |i: u32| [(i, KEY_WEIGHT), (0, 0), (0, 0)];
        let mut builder =
            Builder { keys: (0..base.positions.len() as u32).map(key).collect(), middles: BTreeMap::new() };
        let first = |(k, t): (usize, &[u32; 3])| Leaf { nodes: *t, parent: k as u32, level: 0 };
        let mut leaves: Vec<Leaf> = base.triangles.iter().enumerate().map(first).collect();
        loop {
            let count = leaves.len();
            let mut next = Vec::with_capacity(count);
            for leaf in leaves {
                if builder.must_divide(&leaf, levels[leaf.parent as usize]) {
                    next.extend(builder.divide(&leaf));
                } else {
                    next.push(leaf);
                }
            }
            leaves = next;
            if leaves.len() == count {
                break;
            }
        }
        let parts: Vec<Leaf> = leaves.into_iter().flat_map(|leaf| builder.halve(leaf)).collect();
        let positions = builder.keys.iter().map(|key| position(&base, key)).collect();
        let parents = parts.iter().map(|leaf| leaf.parent).collect();
        let mesh = TriangleMesh::new(positions, parts.iter().map(|leaf| leaf.nodes).collect())?;
        Ok((mesh, Self { base, levels, keys: builder.keys, parents }))
    }

    /// Index in `other`, a refinement of the same base mesh, of each node that it has.
    pub fn shared(&self, other: &Self) -> Vec<Option<u32>> {
        let there: BTreeMap<&NodeKey, u32> = other.keys.iter().zip(0..).collect();
        self.keys.iter().map(|key| there.get(key).copied()).collect()
    }
}

fn position(base: &TriangleMesh, key: &NodeKey) -> [f64; 2] {
    let part = |a: usize| {
        let each = key.iter().filter(|(_, w)| *w > 0);
        each.map(|(v, w)| f64::from(*w) / f64::from(KEY_WEIGHT) * base.positions[*v as usize][a]).sum::<f64>()
    };
    [part(0), part(1)]
}

fn middle_key(a: &NodeKey, b: &NodeKey) -> NodeKey {
    let mut sum: BTreeMap<u32, u32> = BTreeMap::new();
    for (v, w) in a.iter().chain(b).filter(|(_, w)| *w > 0) {
        *sum.entry(*v).or_default() += w / 2;
    }
    let mut key = [(0, 0); 3];
    key.iter_mut().zip(sum).for_each(|(to, from)| *to = from);
    key
}

impl Builder {
    /// Node in the middle of an edge that is divided.
    fn found(&self, a: u32, b: u32) -> Option<u32> {
        self.middles.get(&(a.min(b), a.max(b))).copied()
    }

    fn must_divide(&self, leaf: &Leaf, wanted: u8) -> bool {
        let edges = [0, 1, 2].map(|c| (leaf.nodes[c], leaf.nodes[(c + 1) % 3]));
        let divided = |(a, b): &(u32, u32)| self.found(*a, *b);
        let twice =
            |(a, b): &(u32, u32)| divided(&(*a, *b)).is_some_and(|m| self.found(*a, m).or(self.found(m, *b)).is_some());
        leaf.level < wanted || edges.iter().filter_map(divided).count() > 1 || edges.iter().any(twice)
    }

    fn middle(&mut self, a: u32, b: u32) -> u32 {
        if let Some(m) = self.found(a, b) {
            return m;
        }
        let m = self.keys.len() as u32;
        self.keys.push(middle_key(&self.keys[a as usize], &self.keys[b as usize]));
        self.middles.insert((a.min(b), a.max(b)), m);
        m
    }

    /// The four similar parts of a triangle.
    fn divide(&mut self, leaf: &Leaf) -> [Leaf; 4] {
        let [a, b, c] = leaf.nodes;
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| self.middle(p, q));
        let part = |nodes| Leaf { nodes, parent: leaf.parent, level: leaf.level + 1 };
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(part)
    }

    /// The halves of a triangle with a divided edge, or the triangle.
    fn halve(&self, leaf: Leaf) -> Vec<Leaf> {
        let Leaf { nodes: [a, b, c], parent, level } = leaf;
        for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
            if let Some(m) = self.found(a, b) {
                return [[a, m, c], [m, b, c]].map(|nodes| Leaf { nodes, parent, level }).into();
            }
        }
        vec![leaf]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::triangulate::quality;
    use crate::mesh::outline::{Outline, OutlineSpec, mesh};
    use glam::DVec2;
    use std::path::Path;

    fn base(cut: bool) -> Arc<TriangleMesh> {
        let spec = OutlineSpec::Disc { radius: 0.1 };
        let cuts = if cut { vec![vec![(0.0, 0.0), (0.2, 0.0)]] } else { Vec::new() };
        let outline = Outline::new(Some(&spec), &[], &cuts, (0.2, 0.2), Path::new(".")).expect("an outline");
        Arc::new(mesh(&outline, (11, 11)).expect("a mesh"))
    }

    fn worst(mesh: &TriangleMesh) -> f64 {
        let corners = |t: &[u32; 3]| t.map(|v| DVec2::from(mesh.positions[v as usize]));
        mesh.triangles.iter().map(|t| quality(corners(t))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn any_levels_give_a_conforming_mesh_of_the_same_area_with_bounded_angles() {
        let mut state = 7_u64;
        for cut in [false, true] {
            let base = base(cut);
            let plain = Refinement::new(base.clone(), vec![0; base.triangles.len()].into()).expect("levels");
            assert_eq!(plain.0, *base);
            for share in [3, 10, 40, 100] {
                let mut level = |_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    if (state >> 33) % 100 < share { 1 + (state >> 50) as u8 % 3 } else { 0 }
                };
                let levels: Arc<[u8]> = (0..base.triangles.len()).map(&mut level).collect();
                let (fine, refinement) = Refinement::new(base.clone(), levels.clone()).expect("conforming");
                assert!((fine.total_area() / base.total_area() - 1.0).abs() < 1e-12);
                // Without hanging nodes the boundary is as long as that of the base mesh.
                let rim = |mesh: &TriangleMesh| -> f64 {
                    mesh.edges.iter().filter(|e| e.is_boundary()).map(|e| mesh.direction(e).0).sum()
                };
                assert!((rim(&fine) / rim(&base) - 1.0).abs() < 1e-12, "{share}");
                assert!(worst(&fine) > 0.4 * worst(&base), "{share}: {} of {}", worst(&fine), worst(&base));
                for (k, parent) in refinement.parents.iter().enumerate() {
                    let finer = base.areas[*parent as usize] / fine.areas[k];
                    assert!(finer > 0.999 * 4.0_f64.powi(levels[*parent as usize].into()), "{share}");
                }
                let again = Refinement::new(base.clone(), levels).expect("conforming");
                assert_eq!((&fine, &refinement), (&again.0, &again.1));
            }
        }
    }

    #[test]
    fn refinements_share_nodes_by_their_place_in_the_base_mesh() {
        let base = base(true);
        let some: Arc<[u8]> = (0..base.triangles.len()).map(|k| if k % 5 == 0 { 2 } else { 0 }).collect();
        let (coarse, a) = Refinement::new(base.clone(), some).expect("levels");
        let (fine, b) = Refinement::new(base.clone(), vec![3; base.triangles.len()].into()).expect("levels");
        for (i, there) in a.shared(&b).into_iter().enumerate() {
            assert_eq!(coarse.positions[i], fine.positions[there.expect("nested") as usize]);
        }
        let found = b.shared(&a).into_iter().flatten().count();
        assert_eq!(found, coarse.positions.len());
    }
}
