//! Membrane of the shell on a rectangular grid: strain along the four edges of every cell, shear at
//! its centre.
//!
//! A cell has nodes 0 (i, j), 1 (i+1, j), 2 (i, j+1), 3 (i+1, j+1), edges d₁ = x₁-x₀, d₂ = x₃-x₂
//! along u and d₃ = x₂-x₀, d₄ = x₃-x₁ along v, and rest spacings h_u, h_v (m). Its Green strains
//! are
//!
//! ε₁,₂ = ½(|d₁,₂|²/h_u² - 1), ε₃,₄ = ½(|d₃,₄|²/h_v² - 1), γ = a·b with a = (d₁+d₂)/2h_u,
//! b = (d₃+d₄)/2h_v,
//!
//! and its energy (J), with the plane-stress stiffness A (N/m) and the cell's area S (m²),
//!
//! ½ S [½ A₁₁ (ε₁² + ε₂²) + ½ A₂₂ (ε₃² + ε₄²) + ½ A₁₂ (ε₁+ε₂)(ε₃+ε₄) + A₆₆ γ²].
//!
//! Strains are evaluated where they have second-order accuracy (a staggered grid): an edge shared
//! by two cells has one strain in both, and cylindrical bending along the grid has no strain. A₁₆
//! and A₂₆ are zero: the grid is aligned with the material axes.
//!
//! After a change of temperature every cell has its own stiffness and rest strains, stored in
//! `PacketRestState`; the kernels are compiled with and without them. An open cell has zero
//! stiffness at any temperature.

pub(crate) mod creep;
pub(crate) mod kernels;
pub(crate) mod remap;
pub(crate) mod serialization;
#[cfg(test)]
mod tests;

use crate::elements::creep::InelasticElement;
use crate::elements::fracture::OpenCells;
use crate::elements::grid_membrane::creep::CellCreep;
use crate::elements::grid_membrane::kernels::{
    add_forces, add_gradient, add_tangent, arm_energy, begin, energy, potential, predict, settle,
};
use crate::elements::loss_factor::ArmStrains;
use crate::elements::remap::Remap;
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK, ThermalFields, rest_strain_after_softening};
use crate::material::law::ElementLaw;
use crate::math::Vectors;
use crate::math::lanes::{LANES, Pack, Pack3, Pack9};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};

/// Pairs of a cell's nodes with a matrix block, row by row of the lower triangle.
const PAIRS: [(usize, usize); 10] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (3, 3)];

/// Up to eight neighbouring cells in a row of the grid, one per vector lane.
#[derive(Clone, Debug)]
pub(crate) struct Packet {
    /// Node 0 of the first cell.
    first: usize,
    /// Number of cells.
    count: usize,
    blocks: [[u32; LANES]; 10],
    /// σ* S of ε₁ ε₂ ε₃ ε₄ γ, J.
    stress: [Pack; 5],
    /// ε_w.
    anchor: [Pack; 5],
    /// ε̇ at the end of the last stage, 1/s.
    rate: [Pack; 5],
}

/// Parameters common to all cells.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CellGeometry {
    /// Nodes in a row of the grid: offset from node 0 to node 2.
    row: usize,
    /// 1/h_u, 1/m.
    iu: f64,
    /// 1/h_v, 1/m.
    iv: f64,
    /// ½ A₁₁ S, ½ A₂₂ S, ¼ A₁₂ S, A₆₆ S, J.
    c: [f64; 4],
    /// τ, s.
    retardation: f64,
    /// τ/h and 1/h (1/s) of the stage.
    viscous: f64,
    per_time: f64,
}

/// Thermal rest state of the cells of a packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketRestState {
    /// Remaining stiffness as a fraction of the law's.
    softness: Pack,
    /// Rest strains.
    rest: [Pack; 5],
    /// Thermal part of the rest strains of the four edges.
    expansion: [Pack; 4],
}

impl PacketRestState {
    const COLD: Self =
        Self { softness: Pack([1.0; LANES]), rest: [Pack([0.0; LANES]); 5], expansion: [Pack([0.0; LANES]); 4] };
}

/// The membrane of all cells of a rectangular grid.
#[derive(Clone, Debug, Default)]
pub struct CellMembrane {
    cell: CellGeometry,
    packets: Vec<Packet>,
    /// One entry per packet; empty until the first change of temperature or fracture.
    rest_state: Vec<PacketRestState>,
    /// Creep state; `None` without creep.
    creep: Option<Box<CellCreep>>,
    /// Arms of a flat loss factor: strains by packet, then by lane.
    arms: ArmStrains,
    /// For each cell of a packet, `Some` with the remaining stiffness (fraction of the law's) that
    /// an open cell would have if closed; empty without open cells.
    open: Vec<[Option<f64>; LANES]>,
}

impl CellMembrane {
    /// The cells of a grid of `columns` by `rows` nodes, columns contiguous in memory, with rest
    /// spacings (m).
    pub fn new(columns: usize, rows: usize, spacing: (f64, f64)) -> Self {
        let mut packets = Vec::new();
        for j in 0..rows - 1 {
            for i in (0..columns - 1).step_by(LANES) {
                let count = (columns - 1 - i).min(LANES);
                packets.push(Packet {
                    first: j * columns + i,
                    count,
                    blocks: [[NO_BLOCK; LANES]; 10],
                    stress: [Pack::default(); 5],
                    anchor: [Pack::default(); 5],
                    rate: [Pack::default(); 5],
                });
            }
        }
        let cell = CellGeometry { row: columns, iu: 1.0 / spacing.0, iv: 1.0 / spacing.1, ..CellGeometry::default() };
        Self { cell, packets, ..Self::default() }
    }

    /// Nodes of the edges of a cell, in the order of its strains.
    fn edges_of(m: [usize; 4]) -> [[u32; 2]; 4] {
        let m = m.map(|m| m as u32);
        [[m[0], m[1]], [m[2], m[3]], [m[0], m[2]], [m[1], m[3]]]
    }
}

impl CellGeometry {
    /// Nodes of a cell, from its node 0.
    #[inline(always)]
    fn masses(&self, first: usize) -> [usize; 4] {
        [first, first + 1, first + self.row, first + self.row + 1]
    }

    #[inline(always)]
    fn edges(&self, x: &Vectors, first: usize) -> [Pack3; 4] {
        let [m0, m1, m2, m3] = self.masses(first);
        let (p0, p1) = (Pack3::load(x, m0), Pack3::load(x, m1));
        let (p2, p3) = (Pack3::load(x, m2), Pack3::load(x, m3));
        [p1 - p0, p3 - p2, p2 - p0, p3 - p1]
    }

    /// a and b: derivatives at the centre along u and v.
    #[inline(always)]
    fn middle(&self, d: &[Pack3; 4]) -> (Pack3, Pack3) {
        ((d[0] + d[1]) * (0.5 * self.iu), (d[2] + d[3]) * (0.5 * self.iv))
    }

    #[inline(always)]
    fn strains(&self, d: &[Pack3; 4]) -> [Pack; 5] {
        let half = Pack::splat(0.5);
        let along = |d: Pack3, i: f64| d.dot(d) * (0.5 * i * i) - half;
        let (a, b) = self.middle(d);
        [along(d[0], self.iu), along(d[1], self.iu), along(d[2], self.iv), along(d[3], self.iv), a.dot(b)]
    }

    /// Strain rates for edge rates `r`; first-order strain increments for edge increments `r`.
    #[inline(always)]
    fn rates(&self, d: &[Pack3; 4], r: &[Pack3; 4]) -> [Pack; 5] {
        let along = |k: usize, i: f64| d[k].dot(r[k]) * (i * i);
        let ((a, b), (p, q)) = (self.middle(d), self.middle(r));
        [along(0, self.iu), along(1, self.iu), along(2, self.iv), along(3, self.iv), a.dot(q) + p.dot(b)]
    }

    #[inline(always)]
    fn stress(&self, e: &[Pack; 5]) -> [Pack; 5] {
        let [c11, c22, c12, c66] = self.c;
        let (u, v) = ((e[0] + e[1]) * c12, (e[2] + e[3]) * c12);
        [e[0] * c11 + v, e[1] * c11 + v, e[2] * c22 + u, e[3] * c22 + u, e[4] * c66]
    }

    /// Strain whose elastic stress is the stress of the stage: (1 + τ/h) ε - τ/h ε_w.
    #[inline(always)]
    fn staged(&self, mut e: [Pack; 5], anchor: &[Pack; 5]) -> [Pack; 5] {
        if self.viscous > 0.0 {
            for k in 0..5 {
                e[k] = e[k] * (1.0 + self.viscous) - anchor[k] * self.viscous;
            }
        }
        e
    }

    /// Stress of packet `index` at the strain `e` (of [`CellGeometry::staged`] within a stage).
    #[inline(always)]
    fn stress_of<const WARM: bool>(&self, mut e: [Pack; 5], warmed: &[PacketRestState], index: usize) -> [Pack; 5] {
        if !WARM {
            return self.stress(&e);
        }
        let w = &warmed[index];
        for k in 0..5 {
            e[k] = e[k] - w.rest[k];
        }
        scaled(self.stress(&e), w.softness)
    }

    /// Energy stored by packet `index` at strain `e`, J.
    #[inline(always)]
    fn stored_energy<const WARM: bool>(
        &self,
        mut e: [Pack; 5],
        warmed: &[PacketRestState],
        index: usize,
        count: usize,
    ) -> f64 {
        if WARM {
            for k in 0..5 {
                e[k] = e[k] - warmed[index].rest[k];
            }
        }
        half_dot(&self.softened::<WARM>(&e, warmed, index), &e, count)
    }

    /// Stress of a strain increment `e`, without rest strain.
    #[inline(always)]
    fn softened<const WARM: bool>(&self, e: &[Pack; 5], warmed: &[PacketRestState], index: usize) -> [Pack; 5] {
        let s = self.stress(e);
        if WARM { scaled(s, warmed[index].softness) } else { s }
    }

    /// Adds `scale` times the gradient for stress `s` on edges `d`, N.
    #[inline(always)]
    fn add_gradient(&self, d: &[Pack3; 4], s: &[Pack; 5], scale: f64, at: (usize, usize), to: &mut Vectors) {
        let (a, b) = self.middle(d);
        let (along, across) = (b.scaled(s[4] * (0.5 * self.iu)), a.scaled(s[4] * (0.5 * self.iv)));
        let (uu, vv) = (self.iu * self.iu, self.iv * self.iv);
        let g = [
            d[0].scaled(s[0] * uu) + along,
            d[1].scaled(s[1] * uu) + along,
            d[2].scaled(s[2] * vv) + across,
            d[3].scaled(s[3] * vv) + across,
        ];
        let (first, count) = at;
        let [m0, m1, m2, m3] = self.masses(first);
        ((g[0] + g[2]) * -scale).add_to(to, m0, count);
        ((g[0] - g[3]) * scale).add_to(to, m1, count);
        ((g[2] - g[1]) * scale).add_to(to, m2, count);
        ((g[1] + g[3]) * scale).add_to(to, m3, count);
    }

    /// The ten tangent blocks (N/m) in the order of [`PAIRS`]: second derivatives with respect to
    /// the edges, summed with the signs with which the nodes enter them. `softness` is the
    /// remaining stiffness; `s` already includes it.
    #[inline(always)]
    fn tangent(&self, d: &[Pack3; 4], s: &[Pack; 5], softness: Option<Pack>) -> [Pack9; 10] {
        let (uu, vv, uv) = (self.iu * self.iu, self.iv * self.iv, self.iu * self.iv);
        let scale = 1.0 + self.viscous;
        let mut c = self.c.map(|c| Pack::splat(c * scale));
        if let Some(left) = softness {
            for c in &mut c {
                *c = *c * left;
            }
        }
        let [c11, c22, c12, c66] = c;
        let (a, b) = self.middle(d);
        let (a, b) = (a * (0.5 * self.iv), b * (0.5 * self.iu));
        let [d1, d2, d3, d4] = [d[0] * uu, d[1] * uu, d[2] * vv, d[3] * vv];
        let shear = s[4] * (0.25 * uv);
        let (h12, h34) = (Pack9::outer(b, b, c66), Pack9::outer(a, a, c66));
        let h11 = (Pack9::outer(d1, d1, c11) + h12).plus_identity(s[0] * uu);
        let h22 = (Pack9::outer(d2, d2, c11) + h12).plus_identity(s[1] * uu);
        let h33 = (Pack9::outer(d3, d3, c22) + h34).plus_identity(s[2] * vv);
        let h44 = (Pack9::outer(d4, d4, c22) + h34).plus_identity(s[3] * vv);
        let mixed = Pack9::outer(b, a, c66).plus_identity(shear);
        let h13 = Pack9::outer(d1, d3, c12) + mixed;
        let h14 = Pack9::outer(d1, d4, c12) + mixed;
        let h23 = Pack9::outer(d2, d3, c12) + mixed;
        let h24 = Pack9::outer(d2, d4, c12) + mixed;
        let (t13, t14, t23, t24) = (h13.transposed(), h14.transposed(), h23.transposed(), h24.transposed());
        [
            h11 + h33 + h13 + t13,
            h34 - h11 - h13 + t14,
            h11 + h44 - h14 - t14,
            h12 - h33 + h23 - t13,
            t13 - h12 - h34 + h24,
            h22 + h33 - h23 - t23,
            (h12 + h34 + h23 + t14) * -1.0,
            h12 - h44 - h24 + t14,
            h34 - h22 + h23 - t24,
            h22 + h44 + h24 + t24,
        ]
    }
}

impl std::ops::Mul<f64> for Pack9 {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, s: f64) -> Self {
        for p in &mut self.0 {
            *p = *p * s;
        }
        self
    }
}

/// Each of `s` times `by`. A loop, because a closure is not compiled for the kernel's vector width.
#[inline(always)]
fn scaled(mut s: [Pack; 5], by: Pack) -> [Pack; 5] {
    for k in 0..5 {
        s[k] = s[k] * by;
    }
    s
}

#[inline(always)]
fn half_dot(s: &[Pack; 5], e: &[Pack; 5], count: usize) -> f64 {
    let mut sum = Pack::default();
    for k in 0..5 {
        sum = sum + s[k] * e[k];
    }
    0.5 * sum.sum(count)
}

/// Calls the kernel `$name` compiled with or without a thermal rest state.
macro_rules! kernel {
    ($name:ident, $self:ident, $($argument:expr),*) => {
        if $self.rest_state.is_empty() {
            $name::<false>($($argument),*)
        } else {
            $name::<true>($($argument),*)
        }
    };
}

impl Element for CellMembrane {
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        for packet in &self.packets {
            for l in 0..packet.count {
                let m = self.cell.masses(packet.first + l);
                PAIRS.iter().filter(|(a, b)| a != b).for_each(|(a, b)| visit(m[*a] as u32, m[*b] as u32));
            }
        }
    }

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for packet in &mut self.packets {
            for l in 0..packet.count {
                let m = self.cell.masses(packet.first + l);
                for (k, (a, b)) in PAIRS.iter().enumerate() {
                    packet.blocks[k][l] = block(m[*a] as u32, m[*b] as u32);
                }
            }
        }
    }

    fn set_law(&mut self, law: &ElementLaw) {
        let area = 1.0 / (self.cell.iu * self.cell.iv);
        let a = &law.membrane;
        self.cell.c = [0.5 * a[0][0] * area, 0.5 * a[1][1] * area, 0.25 * a[0][1] * area, a[2][2] * area];
        self.cell.retardation = law.membrane_retardation;
        self.arms.set_law(law, 5 * LANES * self.packets.len());
        if !self.arms.is_empty() {
            self.reset_rates();
        }
    }

    fn apply_temperature(&mut self, x: &Vectors, warmth: &ThermalFields) {
        if self.apply_temperature_to_creep(x, warmth) {
            return;
        }
        if self.rest_state.is_empty() {
            self.rest_state = vec![PacketRestState::COLD; self.packets.len()];
        }
        let cell = self.cell;
        for (index, (w, p)) in self.rest_state.iter_mut().zip(&self.packets).enumerate() {
            let e = cell.strains(&cell.edges(x, p.first));
            for l in 0..p.count {
                let m = cell.masses(p.first + l);
                for (k, edge) in Self::edges_of(m).iter().enumerate() {
                    let expansion = warmth.mean_expansion(edge);
                    w.rest[k].0[l] += expansion - w.expansion[k].0[l];
                    w.expansion[k].0[l] = expansion;
                }
                let after = warmth.stiffness(&m.map(|m| m as u32));
                if let Some(kept) = open_cell(&mut self.open, index, l) {
                    *kept = after;
                    continue;
                }
                let before = w.softness.0[l];
                for k in 0..5 {
                    self.arms.scale((5 * index + k) * LANES + l, before / after);
                    w.rest[k].0[l] = rest_strain_after_softening(e[k].0[l], w.rest[k].0[l], before, after);
                }
                w.softness.0[l] = after;
            }
        }
    }

    fn energy(&self, x: &Vectors) -> f64 {
        let stored = self.creep_energy(x);
        stored.unwrap_or_else(|| kernel!(energy, self, &self.cell, &self.packets, &self.rest_state, x))
            + self.arms.energy(|strain| kernel!(arm_energy, self, &self.cell, &self.packets, &self.rest_state, strain))
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        kernel!(add_forces, self, &self.cell, &self.packets, (&self.rest_state, &self.arms), x, v, force);
    }

    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.cell.viscous = self.cell.retardation * per_time + self.arms.begin_stage(per_time, anchors, follow);
        self.cell.per_time = per_time;
        if self.cell.viscous > 0.0 {
            begin(&self.cell, &mut self.packets, &self.arms, anchors, follow);
        }
    }

    fn finish_stage(&mut self, x: &Vectors) {
        if self.cell.viscous > 0.0 {
            let cell = self.cell;
            for (i, p) in self.packets.iter_mut().enumerate() {
                let e = cell.strains(&cell.edges(x, p.first));
                for k in 0..5 {
                    let mut change = e[k] - p.anchor[k];
                    if self.arms.is_empty() {
                        p.rate[k] = change * cell.per_time;
                    } else {
                        self.arms.finish((5 * i + k) * LANES, &mut change.0);
                    }
                }
            }
        }
    }

    fn reset_rates(&mut self) {
        self.packets.iter_mut().for_each(|p| p.rate = [Pack::default(); 5]);
    }

    fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        for packet in &mut self.packets {
            packet.rate.iter_mut().chain(&mut packet.stress).for_each(|pack| visit(&mut pack.0));
        }
    }

    fn serialise_history(&self, to: &mut StateWriter) {
        self.serialise_rates(to);
        for p in &self.packets {
            p.stress.iter().for_each(|pack| to.sparse(&pack.0[..p.count]));
        }
    }

    fn deserialise_history(&mut self, from: &mut StateReader) -> ReadResult {
        self.deserialise_rates(from)?;
        for p in &mut self.packets {
            p.stress.iter_mut().try_for_each(|pack| from.sparse(&mut pack.0[..p.count]))?;
        }
        Ok(())
    }

    fn serialise_changes(&self, to: &mut StateWriter) {
        to.flag(!self.rest_state.is_empty());
        for (w, p) in self.rest_state.iter().zip(&self.packets) {
            let packs = std::iter::once(&w.softness).chain(&w.rest).chain(&w.expansion);
            packs.for_each(|pack| to.sparse(&pack.0[..p.count]));
        }
        self.creep.iter().for_each(|creep| creep.serialise(to));
        to.flag(!self.open.is_empty());
        self.open.serialise(to);
    }

    fn deserialise_changes(&mut self, from: &mut StateReader) -> ReadResult {
        let is_warm = from.flag()?;
        self.rest_state.clear();
        if is_warm {
            self.rest_state.resize(self.packets.len(), PacketRestState::COLD);
        } else if self.creep.is_some() {
            return Err(CorruptState);
        }
        for (w, p) in self.rest_state.iter_mut().zip(&self.packets) {
            let packs = std::iter::once(&mut w.softness).chain(&mut w.rest).chain(&mut w.expansion);
            packs.into_iter().try_for_each(|pack| from.sparse(&mut pack.0[..p.count]))?;
        }
        self.creep.iter_mut().try_for_each(|creep| creep.deserialise(from))?;
        let count = if from.flag()? { self.packets.len() } else { 0 };
        self.open.clear();
        self.open.resize(count, [None; LANES]);
        self.open.deserialise(from)
    }

    fn potential(&self, x: &Vectors) -> f64 {
        kernel!(potential, self, &self.cell, &self.packets, &self.rest_state, x)
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        kernel!(add_gradient, self, &self.cell, &self.packets, &self.rest_state, x, gradient);
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        kernel!(add_tangent, self, &self.cell, &self.packets, &self.rest_state, x, geometric, values);
    }

    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        kernel!(predict, self, &self.cell, &mut self.packets, &self.rest_state, x, d)
    }

    fn update_stress(&mut self, x: &Vectors) {
        kernel!(settle, self, &self.cell, &mut self.packets, &self.rest_state, x);
    }

    fn open(&mut self, _x: &Vectors, open: &OpenCells, _gone: &[bool]) {
        if self.rest_state.is_empty() {
            self.rest_state = vec![PacketRestState::COLD; self.packets.len()];
        }
        self.open.resize(self.packets.len(), [None; LANES]);
        for index in 0..self.packets.len() {
            let p = &self.packets[index];
            for l in 0..p.count {
                let mass = p.first + l;
                let closed = open.is_closed((mass % self.cell.row) as i64, (mass / self.cell.row) as i64);
                let creeps = self.creep.as_mut();
                let of_step = &mut self.rest_state[index].softness.0[l];
                let softness = creeps.map_or(&mut *of_step, |creeping| creeping.softness(index, l));
                let was = &mut self.open[index][l];
                if !closed && was.is_none() {
                    *was = Some(std::mem::replace(softness, 0.0));
                } else if let Some(kept) = was.take_if(|_| closed) {
                    *softness = kept;
                }
                let now = *softness;
                *of_step = now;
            }
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

/// Remaining stiffness stored for an open cell; `None` for a closed cell.
fn open_cell(open: &mut [[Option<f64>; LANES]], packet: usize, lane: usize) -> Option<&mut f64> {
    open.get_mut(packet).and_then(|p| p[lane].as_mut())
}
