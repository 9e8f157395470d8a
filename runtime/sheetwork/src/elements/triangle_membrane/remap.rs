//! Remapping of the membrane state between triangle meshes: thermal rest strain and creep. Thermal
//! expansion follows from the temperatures.
//!
//! The edges of the two meshes differ, so the state is transferred as the tensor (uu, vv, uv) of
//! the triangles. The file also has the edge strains and their derivatives, with which state
//! transfer places the nodes so that both meshes have equal strain.

use crate::elements::creep::CreepStrain;
use crate::elements::remap::Remap;
use crate::elements::triangle_membrane::{EdgeMembrane, MembraneTriangle, TriangleRestState, dot, product};
use crate::material::loss_factor::ARMS;
use crate::math::Vectors;

/// Three tensors per triangle: rest strain, and the strains of two creep arms.
const STATE_COMPONENTS: usize = 9;

impl EdgeMembrane {
    /// Transferable state of triangle `k`.
    fn stored_state(&self, k: usize) -> [f64; STATE_COMPONENTS] {
        let t = &self.triangles[k];
        let w = &self.rest_state[k];
        let of_edges: [[f64; 3]; 3] = match &self.creep {
            Some(creeping) => {
                let each = t.edges.map(|e| creeping.strains[e as usize].stored_state());
                std::array::from_fn(|n| each.map(|held| held[n]))
            }
            None => [std::array::from_fn(|c| w.rest[c] - w.expansion[c]), [0.0; 3], [0.0; 3]],
        };
        let tensors = of_edges.map(|e| product(&t.from_edges, &e));
        std::array::from_fn(|n| tensors[n / 3][n % 3])
    }

    /// Takes the arms of a flat loss factor of `old`, as tensors of the triangles.
    pub(crate) fn transfer_arms(&mut self, old: &Self, carry: &Remap) {
        if old.arms.is_empty() || self.arms.is_empty() {
            return;
        }
        let held = |t: &MembraneTriangle| -> [f64; 3 * ARMS] {
            let edges = t.edges.map(|e| old.arms.strains(e as usize));
            let tensors: [_; ARMS] = std::array::from_fn(|i| product(&t.from_edges, &edges.map(|arms| arms[i])));
            std::array::from_fn(|n| tensors[n / 3][n % 3])
        };
        let places = carry.gather(false, old.triangles.iter().enumerate().map(|(k, t)| (k as u32, held(t))));
        let mut sums = vec![([0.0; ARMS], 0.0); self.strains.len()];
        for (k, t) in self.triangles.iter().enumerate() {
            let Some(held) = carry.interpolate(&places, k as u32, false) else { continue };
            for e in t.edges.map(|e| e as usize) {
                let (sum, area) = &mut sums[e];
                *area += t.area;
                let tensors = held.as_chunks::<3>().0;
                sum.iter_mut().zip(tensors).for_each(|(s, held)| *s += t.area * dot(&self.directions[e].0, held));
            }
        }
        for (e, (sum, area)) in sums.into_iter().enumerate().filter(|(_, (_, area))| *area > 0.0) {
            self.arms.set_strains(e, sum.map(|s| s / area));
        }
    }

    /// Takes the state of `old`.
    pub(crate) fn transfer_strains(&mut self, old: &Self, carry: &Remap) {
        if old.rest_state.is_empty() {
            return;
        }
        self.rest_state.resize(self.triangles.len(), TriangleRestState::COLD);
        let places = carry.gather(false, (0..old.triangles.len()).map(|k| (k as u32, old.stored_state(k))));
        let mut creeping = self.creep.take();
        // Area-weighted sum over the triangles of each edge.
        let mut sums = vec![([0.0; STATE_COMPONENTS / 3], 0.0); self.strains.len()];
        for (k, t) in self.triangles.iter().enumerate() {
            let Some(held) = carry.interpolate(&places, k as u32, false) else { continue };
            for (c, e) in t.edges.iter().enumerate() {
                let squares = &self.directions[*e as usize].0;
                let along: [f64; 3] =
                    std::array::from_fn(|n| dot(squares, &[held[3 * n], held[3 * n + 1], held[3 * n + 2]]));
                let w = &mut self.rest_state[k];
                w.rest[c] = w.expansion[c] + if creeping.is_none() { along[0] } else { 0.0 };
                let (sum, area) = &mut sums[*e as usize];
                *area += t.area;
                sum.iter_mut().zip(along).for_each(|(s, x)| *s += t.area * x);
            }
        }
        if let Some(creeping) = &mut creeping {
            for (e, (sum, area)) in sums.into_iter().enumerate().filter(|(_, (_, area))| *area > 0.0) {
                creeping.strains[e] = CreepStrain::from_stored_state(sum.map(|s| s / area));
                self.apply_rest_strain(e, creeping);
            }
        }
        self.creep = creeping;
    }

    /// Green strain of every edge at `x` (m), along its arc.
    pub fn stretch(&self, x: &Vectors) -> Vec<f64> {
        self.strains.iter().map(|s| s.at(x) + 0.5 * (s.unit - 1.0)).collect()
    }

    /// First-order change of [`EdgeMembrane::stretch`] at `x` (m) for a displacement `d` (m).
    pub fn stretch_rates(&self, x: &Vectors, d: &Vectors) -> Vec<f64> {
        self.strains.iter().map(|s| s.rate(x, d)).collect()
    }

    /// Transpose of [`EdgeMembrane::stretch_rates`]: adds to each node the product of the gradients
    /// with `stress`.
    pub fn add_edge_forces(&self, x: &Vectors, stress: &[f64], to: &mut Vectors) {
        self.strains.iter().zip(stress).for_each(|(s, stress)| s.scatter(x, *stress, to));
    }

    /// The tensor (uu, vv, uv) of every triangle for the edge strains `edges`.
    pub fn tensors(&self, edges: &[f64]) -> Vec<[f64; 3]> {
        self.triangles.iter().map(|t| product(&t.from_edges, &t.edges.map(|e| edges[e as usize]))).collect()
    }

    /// The strain along every edge for tensors (uu, vv, uv) at the nodes.
    pub fn edge_strains(&self, masses: &[[f64; 3]]) -> Vec<f64> {
        let each = self.strains.iter().zip(&self.directions);
        each.map(|(s, (squares, _))| {
            let [a, b] = s.ends.map(|v| masses[v as usize]);
            0.5 * (dot(squares, &a) + dot(squares, &b))
        })
        .collect()
    }
}
