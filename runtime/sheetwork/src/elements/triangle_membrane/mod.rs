//! Membrane of a triangle mesh: strain of the edges, measured along the arc of the bent sheet.
//!
//! An edge of rest length l from node a to node b has the Green strain of its chord plus, to second
//! order, of the arc of the sheet along it,
//!
//! ε_e = ½ (|x_b - x_a|²/l² - 1) + l²/24 |x_tt|²,
//!
//! with x_tt the curvature along the edge, the mean over its triangles (each weighted by the
//! other's area). Without the second term, bending at an angle to the edges would stretch them. The
//! strains (ε_uu, ε_vv, γ) of a triangle follow from its three edges with directions t = (t_u,
//! t_v),
//!
//! ε_e = t_u² ε_uu + t_v² ε_vv + t_u t_v γ, in short ε_e = S ε,
//!
//! and the energy is ½ ε_eᵀ G ε_e, G = A S⁻ᵀ C S⁻¹ (J), with the area A (m²) and the membrane
//! stiffness C (N/m), which may be orthotropic. Every strain is a quadratic of the positions, ½
//! (|d|² + |k|² - 1) with d and k linear.

pub(crate) mod creep;
mod edge_strain;
mod opening;
pub(crate) mod remap;
#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::elements::creep::InelasticElement;
use crate::elements::curvature::{CurvatureGroup, apply as product, dot};
use crate::elements::fracture::OpenCells;
use crate::elements::loss_factor::ArmStrains;
use crate::elements::remap::Remap;
use crate::elements::triangle_membrane::creep::EdgeCreep;
use crate::elements::triangle_membrane::edge_strain::{EdgeStrain, Sources, sources};
use crate::elements::triangle_membrane::opening::Opening;
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK, ThermalFields, add_block, rest_strain_after_softening};
use crate::material::law::ElementLaw;
use crate::math::Vectors;
use crate::mesh::outline::TriangleMesh;
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};

/// A triangle: three edges, and the nodes that their strains depend on.
#[derive(Clone, Debug, Default)]
struct MembraneTriangle {
    edges: [u32; 3],
    /// S⁻¹, and the area in m².
    from_edges: [[f64; 3]; 3],
    area: f64,
    /// Stiffness G at the present temperature, J.
    stiffness: [[f64; 3]; 3],
    /// Nodes in ascending order; every pair (p, q <= p) has a block.
    masses: Vec<u32>,
    /// Weights of each node in d and k of each edge.
    weights: Vec<[[f64; 2]; 3]>,
    /// Edges whose stress this triangle adds to the geometric part: one triangle per edge.
    owns: [bool; 3],
    blocks: Vec<u32>,
}

/// Thermal rest state of a triangle.
#[derive(Clone, Copy, Debug)]
struct TriangleRestState {
    /// Remaining stiffness as a fraction of the law's.
    softness: f64,
    /// Rest strains of the edges, and their thermal part.
    rest: [f64; 3],
    expansion: [f64; 3],
}

state!(TriangleRestState { softness, rest, expansion });

impl TriangleRestState {
    /// Rest state before any change of temperature.
    const COLD: Self = Self { softness: 1.0, rest: [0.0; 3], expansion: [0.0; 3] };
}

/// The membrane of all triangles of a mesh.
#[derive(Clone, Debug, Default)]
pub struct EdgeMembrane {
    strains: Vec<EdgeStrain>,
    triangles: Vec<MembraneTriangle>,
    /// One entry per triangle; empty until the first change of temperature.
    rest_state: Vec<TriangleRestState>,
    /// Curvature along each edge before relaxation: indices of groups and their shares.
    sources: Vec<Sources>,
    /// Squared direction (t_u², t_v², t_u t_v) and length (m) of each edge.
    directions: Vec<([f64; 3], f64)>,
    groups: Vec<CurvatureGroup>,
    /// Clamp directions in world coordinates.
    tangents: Vec<DVec3>,
    retardation: f64,
    /// τ/h and 1/h (1/s) of the stage.
    viscous: f64,
    per_time: f64,
    /// One value per edge: ε_w, ε̇ at the end of the last stage (1/s), σ* (J, sum over its
    /// triangles), and two buffers.
    anchor: Vec<f64>,
    rate: Vec<f64>,
    stress: Vec<f64>,
    work: Vec<f64>,
    spare: Vec<f64>,
    /// Buffer for the gradients of a triangle and their products with G.
    gradients: Vec<[DVec3; 3]>,
    /// Creep state; `None` without creep.
    creep: Option<Box<EdgeCreep>>,
    /// Arms of a flat loss factor, on the strains of the edges.
    arms: ArmStrains,
    /// Open triangles; `None` while all are closed.
    opening: Option<Box<Opening>>,
    /// Bending stiffness of the law, N m.
    bending: [[f64; 3]; 3],
}

impl EdgeMembrane {
    /// The membrane of `mesh`; `groups` are the curvatures of its triangles in their order.
    /// [`Element::set_law`] must set the stiffness.
    pub fn new(mesh: &TriangleMesh, groups: &[CurvatureGroup]) -> Self {
        let edges = mesh.edges.len();
        let mut membrane = Self {
            groups: groups.to_vec(),
            anchor: vec![0.0; edges],
            stress: vec![0.0; edges],
            work: vec![0.0; edges],
            spare: vec![0.0; edges],
            rate: vec![0.0; edges],
            ..Self::default()
        };
        for edge in &mesh.edges {
            let (length, [u, v]) = mesh.direction(edge);
            membrane.directions.push(([u * u, v * v, u * v], length));
            membrane.sources.push(sources(mesh, edge));
            membrane.strains.push(EdgeStrain::new(edge.nodes, length));
        }
        membrane.compute_arcs(&[[0.0; 3]; 3]);
        for (k, own) in mesh.triangle_edges.iter().enumerate() {
            let s = own.map(|e| membrane.directions[e as usize].0);
            let owns = own.map(|e| mesh.edges[e as usize].triangles[0] == k as u32);
            let from_edges = inverse(&s);
            let triangle =
                MembraneTriangle { edges: *own, from_edges, area: mesh.areas[k], owns, ..MembraneTriangle::default() };
            membrane.triangles.push(triangle);
        }
        membrane.gather_nodes();
        membrane.compute_weights();
        membrane
    }

    /// Adds creep with Maxwell arms of the shares `share`, if any.
    pub fn with_creep(mut self, share: Option<[f64; 2]>) -> Self {
        self.creep = share.map(|share| Box::new(EdgeCreep::new(self.strains.len(), self.triangles.len(), share)));
        self
    }

    /// Sets the clamp directions (unit vectors in world coordinates) that the groups refer to.
    pub fn set_clamps(&mut self, tangents: &[DVec3]) {
        self.tangents = tangents.to_vec();
        self.compute_offsets();
    }

    fn compute_weights(&mut self) {
        for triangle in &mut self.triangles {
            let strains = triangle.edges.map(|e| &self.strains[e as usize]);
            triangle.weights = triangle.masses.iter().map(|v| strains.map(|s| s.weights(*v))).collect();
        }
    }

    /// ½ eᵀ G e, sum over all triangles (J), for strain increments e.
    fn stored_energy(&self, strain: impl Fn(usize) -> f64) -> f64 {
        let one = |t: &MembraneTriangle| {
            let e = t.edges.map(|i| strain(i as usize));
            0.5 * dot(&e, &product(&t.stiffness, &e))
        };
        self.triangles.iter().map(one).sum()
    }

    /// Energy without that of the arms, J.
    fn elastic_energy(&self, x: &Vectors) -> f64 {
        if let Some(creeping) = self.creep.as_ref().filter(|c| !c.is_running()) {
            return self.creep_energy(creeping, x);
        }
        let one = |(k, t): (usize, &MembraneTriangle)| {
            let e = self.less_rest(k, t.edges.map(|e| self.strains[e as usize].at(x)));
            0.5 * dot(&e, &product(&t.stiffness, &e))
        };
        self.triangles.iter().enumerate().map(one).sum()
    }

    /// The strains `e` of triangle `k` minus its rest strains.
    #[inline]
    fn less_rest(&self, k: usize, e: [f64; 3]) -> [f64; 3] {
        match self.rest_state.get(k) {
            Some(w) => [e[0] - w.rest[0], e[1] - w.rest[1], e[2] - w.rest[2]],
            None => e,
        }
    }

    /// Sets `stress` to G e for the strains in `work`.
    fn stress_of_work(&mut self) {
        self.stress.fill(0.0);
        for (k, t) in self.triangles.iter().enumerate() {
            let s = product(&t.stiffness, &self.less_rest(k, t.edges.map(|e| self.work[e as usize])));
            t.edges.iter().zip(s).for_each(|(e, s)| self.stress[*e as usize] += s);
        }
    }

    fn scatter(&self, x: &Vectors, to: &mut Vectors) {
        for (strain, stress) in self.strains.iter().zip(&self.stress) {
            strain.scatter(x, *stress, to);
        }
    }

    /// Effective strain of the stage: the elastic stress of it includes the viscous stress at
    /// strain `e`.
    #[inline]
    fn effective(viscous: f64, e: f64, anchor: f64) -> f64 {
        e + viscous * (e - anchor)
    }

    /// Sets `work` to the effective strains at `x` (m).
    fn strain_stage(&mut self, x: &Vectors) {
        for ((work, strain), anchor) in self.work.iter_mut().zip(&self.strains).zip(&self.anchor) {
            *work = Self::effective(self.viscous, strain.at(x), *anchor);
        }
    }

    /// Adds the tangent of triangle `t`.
    fn triangle_tangent(
        t: &MembraneTriangle,
        strains: [(DVec3, DVec3); 3],
        stress: [f64; 3],
        factor: f64,
        room: &mut [[DVec3; 3]],
        values: &mut [f64],
    ) {
        let n = t.masses.len();
        let (gradient, scaled) = room.split_at_mut(n);
        for (i, w) in t.weights.iter().enumerate() {
            let g: [DVec3; 3] = std::array::from_fn(|e| strains[e].0 * w[e][0] + strains[e].1 * w[e][1]);
            gradient[i] = g;
            scaled[i] = std::array::from_fn(|e| {
                (g[0] * t.stiffness[e][0] + g[1] * t.stiffness[e][1] + g[2] * t.stiffness[e][2]) * factor
            });
        }
        let mut slot = t.blocks.iter();
        for p in 0..n {
            let (a, wp) = (&gradient[p], &t.weights[p]);
            for q in 0..=p {
                let Some(block) = slot.next().filter(|b| **b != NO_BLOCK) else { continue };
                let (b, wq) = (&scaled[q], &t.weights[q]);
                let geometric: f64 = (0..3).map(|e| stress[e] * (wp[e][0] * wq[e][0] + wp[e][1] * wq[e][1])).sum();
                let row = |x: [f64; 3]| b[0] * x[0] + b[1] * x[1] + b[2] * x[2];
                let (x, y, z) = (row(a.map(|a| a.x)), row(a.map(|a| a.y)), row(a.map(|a| a.z)));
                let sum = [x.x + geometric, x.y, x.z, y.x, y.y + geometric, y.z, z.x, z.y, z.z + geometric];
                add_block(values, *block, &sum);
            }
        }
    }
}

impl Element for EdgeMembrane {
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        for t in &self.triangles {
            for (p, a) in t.masses.iter().enumerate() {
                t.masses[..p].iter().for_each(|b| visit(*a, *b));
            }
        }
    }

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for t in &mut self.triangles {
            let pairs = t.masses.iter().enumerate().flat_map(|(p, a)| t.masses[..=p].iter().map(move |b| (*a, *b)));
            t.blocks.iter_mut().zip(pairs).for_each(|(slot, (a, b))| *slot = block(a, b));
        }
    }

    fn set_law(&mut self, law: &ElementLaw) {
        self.retardation = law.membrane_retardation;
        self.arms.set_law(law, self.strains.len());
        if !self.arms.is_empty() {
            self.reset_rates();
        }
        self.bending = law.bending;
        let is_open = |k: usize| self.opening.as_ref().is_some_and(|o| o.open[k]);
        for (k, t) in self.triangles.iter_mut().enumerate() {
            let softness = self.rest_state.get(k).map_or(1.0, |w| w.softness);
            let area = if is_open(k) { 0.0 } else { t.area * softness };
            let s = &t.from_edges;
            // S⁻¹ maps edge strains to (uu, vv, uv): G = A S⁻ᵀ C S⁻¹.
            let cs: [[f64; 3]; 3] = std::array::from_fn(|j| product(&law.membrane, &[s[0][j], s[1][j], s[2][j]]));
            for i in 0..3 {
                for j in 0..3 {
                    t.stiffness[i][j] = area * dot(&[s[0][i], s[1][i], s[2][i]], &cs[j]);
                }
            }
        }
        self.store_full_stiffness();
        self.compute_arcs(&law.bending);
        self.compute_weights();
        self.compute_offsets();
    }

    fn apply_temperature(&mut self, x: &Vectors, warmth: &ThermalFields) {
        let creeps = self.apply_temperature_to_creep(x, warmth);
        self.rest_state.resize(self.triangles.len(), TriangleRestState::COLD);
        for (t, w) in self.triangles.iter_mut().zip(&mut self.rest_state) {
            let strains = t.edges.map(|e| &self.strains[e as usize]);
            let mut corners = [0.0; 2];
            for (k, strain) in strains.iter().enumerate() {
                let expansion = warmth.mean_expansion(&strain.ends);
                if !creeps {
                    w.rest[k] += expansion - w.expansion[k];
                }
                w.expansion[k] = expansion;
                // Each corner is an end of two edges.
                corners[0] += strain.ends.iter().map(|m| warmth.compliance[*m as usize]).sum::<f64>();
                corners[1] += 2.0;
            }
            let (before, after) = (w.softness, corners[1] / corners[0]);
            // With creep the edges hold the rest strain.
            for (rest, strain) in w.rest.iter_mut().zip(strains).filter(|_| !creeps) {
                *rest = rest_strain_after_softening(strain.at(x), *rest, before, after);
            }
            for (edge, _) in t.edges.iter().zip(t.owns).filter(|(_, owns)| *owns) {
                self.arms.scale(*edge as usize, before / after);
            }
            t.stiffness.iter_mut().flatten().for_each(|g| *g *= after / before);
            w.softness = after;
        }
        self.store_full_stiffness();
    }

    fn energy(&self, x: &Vectors) -> f64 {
        self.elastic_energy(x) + self.arms.energy(|strain| self.stored_energy(strain))
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        for (k, t) in self.triangles.iter().enumerate() {
            let strain = t.edges.map(|e| {
                let strain = &self.strains[e as usize];
                let rate = if self.retardation > 0.0 { self.retardation * strain.rate(x, v) } else { 0.0 };
                let mut sum = [strain.at(x) + rate];
                self.arms.add_strain(e as usize, &mut sum);
                sum[0]
            });
            let strain = self.less_rest(k, strain);
            for (e, stress) in t.edges.iter().zip(product(&t.stiffness, &strain)) {
                self.strains[*e as usize].scatter(x, -stress, force);
            }
        }
    }

    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.viscous = self.retardation * per_time + self.arms.begin_stage(per_time, anchors, follow);
        self.per_time = per_time;
        if self.viscous == 0.0 {
            return;
        }
        for ((sum, rate), strain) in self.anchor.iter_mut().zip(&self.rate).zip(&self.strains) {
            *sum = follow * rate + anchors.iter().map(|a| a.weight * strain.at(a.x)).sum::<f64>();
        }
        self.arms.shift(0, &mut self.anchor);
    }

    fn finish_stage(&mut self, x: &Vectors) {
        if self.viscous == 0.0 {
            return;
        }
        for ((change, anchor), strain) in self.work.iter_mut().zip(&self.anchor).zip(&self.strains) {
            *change = strain.at(x) - anchor;
        }
        if self.arms.is_empty() {
            self.rate.iter_mut().zip(&self.work).for_each(|(rate, change)| *rate = change * self.per_time);
        } else {
            self.arms.finish(0, &mut self.work);
        }
    }

    fn reset_rates(&mut self) {
        self.rate.fill(0.0);
    }

    fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        visit(&mut self.rate);
        visit(&mut self.stress);
    }

    fn serialise_history(&self, to: &mut StateWriter) {
        to.sparse(&self.rate);
        to.sparse(&self.stress);
    }

    fn deserialise_history(&mut self, from: &mut StateReader) -> ReadResult {
        from.sparse(&mut self.rate)?;
        from.sparse(&mut self.stress)
    }

    fn serialise_changes(&self, to: &mut StateWriter) {
        self.strains.iter().for_each(|s| to.number(s.unit));
        self.triangles.iter().for_each(|t| t.stiffness.serialise(to));
        to.flag(!self.rest_state.is_empty());
        self.rest_state.serialise(to);
        self.creep.iter().for_each(|creep| creep.serialise(to));
        self.opening.iter().for_each(|opening| to.sparse(&opening.arc_change));
    }

    fn deserialise_changes(&mut self, from: &mut StateReader) -> ReadResult {
        self.strains.iter_mut().try_for_each(|s| s.unit.deserialise(from))?;
        self.triangles.iter_mut().try_for_each(|t| t.stiffness.deserialise(from))?;
        self.rest_state.clear();
        if from.flag()? {
            self.rest_state.resize(self.triangles.len(), TriangleRestState::COLD);
        }
        self.rest_state.deserialise(from)?;
        self.creep.iter_mut().try_for_each(|creep| creep.deserialise(from))?;
        self.opening.iter_mut().try_for_each(|opening| from.sparse(&mut opening.arc_change))
    }

    fn potential(&self, x: &Vectors) -> f64 {
        let viscous = if self.viscous > 0.0 {
            self.viscous * self.stored_energy(|e| self.strains[e].at(x) - self.anchor[e])
        } else {
            0.0
        };
        self.elastic_energy(x) + viscous
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        // σ* must remain the prediction of the last linear solution, so the iterate's stress uses a
        // buffer.
        self.strain_stage(x);
        std::mem::swap(&mut self.stress, &mut self.spare);
        self.stress_of_work();
        self.scatter(x, gradient);
        std::mem::swap(&mut self.stress, &mut self.spare);
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        let factor = 1.0 + self.viscous;
        for t in &self.triangles {
            let strains = t.edges.map(|e| {
                let strain = &self.strains[e as usize];
                (strain.chord(x), strain.bow(x) + strain.offset)
            });
            let stress = std::array::from_fn(|c| {
                let s = if t.owns[c] { self.stress[t.edges[c] as usize] } else { 0.0 };
                if geometric == Geometric::Clipped { s.max(0.0) } else { s }
            });
            Self::triangle_tangent(t, strains, stress, factor, &mut self.gradients, values);
        }
    }

    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        for (e, strain) in self.strains.iter().enumerate() {
            let linear = strain.at(x) + strain.rate(x, d);
            self.work[e] = Self::effective(self.viscous, linear, self.anchor[e]);
            self.spare[e] = 0.5 * (strain.chord(d).length_squared() + strain.bow(d).length_squared());
        }
        self.stress_of_work();
        self.stored_energy(|e| self.spare[e])
    }

    fn update_stress(&mut self, x: &Vectors) {
        self.strain_stage(x);
        self.stress_of_work();
    }

    fn open(&mut self, x: &Vectors, open: &OpenCells, _gone: &[bool]) {
        if let Some(cells) = open.triangles() {
            self.open_triangles(x, cells, open);
        }
    }

    fn arms(&self) -> Option<&ArmStrains> {
        Some(&self.arms)
    }

    fn arms_mut(&mut self) -> Option<&mut ArmStrains> {
        Some(&mut self.arms)
    }

    fn transfer_state(&mut self, old: &(dyn Element + 'static), carry: &Remap) {
        if let Some(old) = (old as &dyn std::any::Any).downcast_ref::<Self>() {
            self.transfer_arms(old, carry);
            self.transfer_strains(old, carry);
        }
    }

    fn as_inelastic(&mut self) -> Option<&mut dyn InelasticElement> {
        self.creep.is_some().then_some(self as &mut dyn InelasticElement)
    }
}

/// Inverse matrix; the directions of the three edges are always linearly independent.
fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let [a, b, c] = m.map(DVec3::from_array);
    let columns = glam::DMat3::from_cols(a, b, c).transpose().inverse();
    columns.transpose().to_cols_array_2d()
}
