//! Strain of one edge of a triangle mesh, along the arc of the bent sheet.
//!
//! With l (m) the rest length and a, b the nodes of the edge,
//!
//! ε = ½ (|d|² + |k|² - 1 - 2 ε_c),  d = (x_b - x_a)/l,  k = l/√12 x_tt,
//!
//! where ε_c is the creep strain. The curvature x_tt (1/m) along the edge is the mean over its
//! triangles, each weighted by the other's area. In a triangle, x_tt = sᵀ Q κ with the squared
//! direction s = (t_u², t_v², t_u t_v) of the edge, the curvatures κ of the triangle's group,
//! and the relaxation Q of free directions, which depends on the bending stiffness. d and k are
//! linear in the positions x (m), with weights in 1/m; clamp directions contribute a constant to k.

use glam::DVec3;

use crate::elements::curvature::relaxation;
use crate::elements::triangle_membrane::EdgeMembrane;
use crate::math::Vectors;
use crate::mesh::outline::{MeshEdge, NO_TRIANGLE, TriangleMesh};

/// Weight of the arc term below which it is rounding, in units of 1/l².
const WEIGHT_TOLERANCE: f64 = 1e-12;

/// Coefficients of the strain of one edge.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeStrain {
    /// Nodes of the edge.
    pub(super) ends: [u32; 2],
    /// 1/l, 1/m.
    pub(super) inverse_length: f64,
    /// Nodes and weights (1/m) of k = Σ weight x + offset = `l/√12 x_tt`.
    pub(super) arc: Vec<(u32, f64)>,
    /// Indices and weights of clamp directions in k.
    clamps: Vec<(u32, f64)>,
    /// Contribution of the clamp directions to k.
    pub(super) offset: DVec3,
    /// |d|² + |k|² without stress: 1 plus twice the creep strain.
    pub(super) unit: f64,
}

impl EdgeStrain {
    /// Strain of the chord of an edge of `length` (m), without arc and creep.
    pub(super) fn new(ends: [u32; 2], length: f64) -> Self {
        Self { ends, inverse_length: 1.0 / length, unit: 1.0, ..Self::default() }
    }

    #[inline]
    pub(super) fn chord(&self, x: &Vectors) -> DVec3 {
        (x.get(self.ends[1] as usize) - x.get(self.ends[0] as usize)) * self.inverse_length
    }

    #[inline]
    pub(super) fn bow(&self, x: &Vectors) -> DVec3 {
        self.arc.iter().fold(DVec3::ZERO, |sum, (v, w)| sum + x.get(*v as usize) * *w)
    }

    #[inline]
    pub(super) fn at(&self, x: &Vectors) -> f64 {
        let (d, k) = (self.chord(x), self.bow(x) + self.offset);
        0.5 * (d.length_squared() - self.unit + k.length_squared())
    }

    /// First-order change of the strain at `x` (m) for a displacement or velocity `v`.
    #[inline]
    pub(super) fn rate(&self, x: &Vectors, v: &Vectors) -> f64 {
        self.chord(x).dot(self.chord(v)) + (self.bow(x) + self.offset).dot(self.bow(v))
    }

    /// Adds `stress` times the gradient of the strain.
    #[inline]
    pub(super) fn scatter(&self, x: &Vectors, stress: f64, to: &mut Vectors) {
        let pull = self.chord(x) * (stress * self.inverse_length);
        let [a, b] = self.ends.map(|v| v as usize);
        to.set(a, to.get(a) - pull);
        to.add(b, pull);
        let bend = (self.bow(x) + self.offset) * stress;
        for (v, w) in &self.arc {
            to.add(*v as usize, bend * *w);
        }
    }

    /// Weights of node `v` in d and in k.
    pub(super) fn weights(&self, v: u32) -> [f64; 2] {
        let chord = if v == self.ends[1] { 1.0 } else { 0.0 } - if v == self.ends[0] { 1.0 } else { 0.0 };
        let arc = self.arc.iter().find(|a| a.0 == v).map_or(0.0, |a| a.1);
        [chord * self.inverse_length, arc]
    }
}

impl EdgeMembrane {
    /// Computes k of every edge for bending stiffness `bending` (N m). The sparsity pattern does
    /// not depend on it.
    pub(super) fn compute_arcs(&mut self, bending: &[[f64; 3]; 3]) {
        for ((strain, sources), (squares, length)) in self.strains.iter_mut().zip(&self.sources).zip(&self.directions) {
            strain.arc.clear();
            strain.clamps.clear();
            let scale = length / 12.0_f64.sqrt();
            for (group, share) in sources.iter().filter(|s| s.1 != 0.0) {
                let group = &self.groups[*group as usize];
                let q = relaxation(bending, &group.relaxed);
                // x_tt = sᵀ Q κ: the row of the relaxed curvature along the edge.
                let along: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| squares[i] * q[i][j]).sum());
                let keep = !group.relaxed.is_empty();
                for (i, along) in along.iter().enumerate() {
                    let times = along * share * scale;
                    let rows = group.rows[i].iter().map(|(v, w)| (*v, w * times));
                    gather(&mut strain.arc, rows);
                    gather(&mut strain.clamps, group.clamps[i].iter().map(|(v, w)| (*v, w * times)));
                }
                // With relaxed directions the weights depend on the stiffness: zero weights keep
                // their places.
                if keep {
                    for row in &group.rows {
                        gather(&mut strain.arc, row.iter().map(|(v, _)| (*v, 0.0)));
                    }
                }
            }
            if sources.iter().all(|s| s.1 == 0.0 || self.groups[s.0 as usize].relaxed.is_empty()) {
                strain.arc.retain(|(_, w)| w.abs() * length > WEIGHT_TOLERANCE);
            }
            strain.arc.sort_by_key(|a| a.0);
        }
    }

    /// Computes the contribution of the clamp directions to k of every edge.
    pub(super) fn compute_offsets(&mut self) {
        for strain in &mut self.strains {
            let tangent = |i: u32| self.tangents.get(i as usize).copied().unwrap_or(DVec3::ZERO);
            strain.offset = strain.clamps.iter().fold(DVec3::ZERO, |sum, (i, w)| sum + tangent(*i) * *w);
        }
    }
}

/// Groups whose curvature contributes to an edge, and their shares.
pub(super) type Sources = [(u32, f64); 2];

/// Sources of an edge of `mesh`.
pub(super) fn sources(mesh: &TriangleMesh, edge: &MeshEdge) -> Sources {
    let [first, second] = edge.triangles;
    if second == NO_TRIANGLE {
        return [(first, 1.0), (first, 0.0)];
    }
    let (a, b) = (mesh.areas[first as usize], mesh.areas[second as usize]);
    [(first, b / (a + b)), (second, a / (a + b))]
}

/// Those of the sources `whole` of an edge whose curvature is `known`; both if neither is.
pub(super) fn sources_of(whole: Sources, edge: &MeshEdge, known: impl Fn(u32) -> bool) -> Sources {
    let [first, second] = edge.triangles;
    if edge.is_boundary() || known(first) == known(second) {
        return whole;
    }
    let own = if known(first) { first } else { second };
    [(own, 1.0), (own, 0.0)]
}

/// Adds weights to a list with one entry per index.
fn gather(to: &mut Vec<(u32, f64)>, from: impl Iterator<Item = (u32, f64)>) {
    for (v, w) in from {
        match to.iter_mut().find(|t| t.0 == v) {
            Some(t) => t.1 += w,
            None => to.push((v, w)),
        }
    }
}
