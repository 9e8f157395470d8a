//! Bending of a shell: vector curvatures κ_a = Σ w x (1/m) and the energy ½ Σ S κᵀ D κ, with area S
//! (m²) and bending stiffness D (N m).
//!
//! The energy is quadratic in x, so its tangent is constant (Wardetzky, Bergou, Harmon, Zorin,
//! Grinspun, "Discrete quadratic curvature energies", CAGD 24, 2007, for hinges; here for central
//! differences and for the triangle of [`crate::elements::triangle_bending`]). For a nearly
//! inextensible sheet |x_uu| is the curvature for any rotation.
//!
//! With a retardation time τ, damping acts on the rate of the scalar curvature k = κ·n along the
//! normal: ½ (τ/h) S (k-k_w)ᵀ D (k-k_w). The vector κ rotates with the sheet, so damping of its
//! rate would brake a rotating bent sheet. The normal n is that of the iterate and is not
//! differentiated, because κ is nearly parallel to it.
//!
//! With thermal rest strain or a temperature gradient the sheet has rest curvatures κ₀ that rotate
//! with it: the energy is ½ Σ S (κ - κ₀)ᵀ D (κ - κ₀), with an equal tangent. κ₀ is stored in axes
//! of the sheet (first side of the frame, normal, and their cross product) and is nearly parallel
//! to the normal. A sheet without thermal history stores no κ₀.
//!
//! Initial curvature, plasticity and creep have their rest curvature along the normal in `rest`.

pub(crate) mod normal_rotation;
pub(crate) mod remap;
pub(crate) mod rest;
pub(crate) mod sums;
#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::elements::bending::rest::RestCurvature;
use crate::elements::creep::InelasticElement;
use crate::elements::curvature::{CurvatureGroup, dot};
use crate::elements::fracture::OpenCells;
use crate::elements::loss_factor::ArmStrains;
use crate::elements::remap::Remap;
use crate::elements::staggered::ClosedPart;
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK, ThermalFields, rest_strain_after_softening};
use crate::material::law::ElementLaw;
use crate::math::Vectors;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};

/// One curvature group: a point with up to three curvatures.
#[derive(Clone, Debug)]
struct BendingGroup {
    /// Range of its entries in `masses` and `weights`.
    entries: (u32, u32),
    /// Contribution of prescribed slopes to the curvatures, 1/m.
    prescribed: [DVec3; 3],
    frame: [u32; 4],
    /// S D at the present temperature, relaxed directions condensed out, N m³.
    stiffness: [[f64; 3]; 3],
    /// Remaining stiffness as a fraction of the law's.
    softness: f64,
    /// Reference curvature k_w, 1/m.
    anchor: [f64; 3],
    /// k̇ at the end of the last stage, 1/(m s).
    rate: [f64; 3],
    /// Range of its pairs.
    pairs: (u32, u32),
}

/// Two nodes of a group and their coupling.
#[derive(Clone, Copy, Debug)]
struct Pair {
    block: u32,
    /// Positions of the two nodes among the group's entries.
    of: (u32, u32),
    /// Σ w_a S D_ab w_b, N/m.
    value: f64,
}

/// The bending of a whole shell.
#[derive(Clone, Debug, Default)]
pub struct Bending {
    source: Vec<CurvatureGroup>,
    groups: Vec<BendingGroup>,
    /// κ₀ of each group in its axes, 1/m, and the thermal curvature along the normal, 1/m; empty
    /// before the first change of temperature.
    rest: Vec<[DVec3; 3]>,
    curl: Vec<f64>,
    masses: Vec<u32>,
    /// Weights of uu, vv, 2uv of each entry, 1/m².
    weights: Vec<[f64; 3]>,
    pairs: Vec<Pair>,
    /// Pairs with a block, sorted by block.
    order: Vec<u32>,
    /// Blocks of the constant tangent and their values, summed over groups, N/m.
    constant: Vec<(u32, f64)>,
    retardation: f64,
    viscous: f64,
    per_time: f64,
    /// Rest curvature along the normal; `None` for a sheet without initial curvature, plasticity
    /// and creep.
    rest_curvature: Option<Box<RestCurvature>>,
    /// Arms of a flat loss factor, on the scalar curvatures of each group.
    arms: ArmStrains,
    /// Each group without open cells; empty before the first cell opens.
    whole: Vec<ClosedPart>,
}

impl Bending {
    /// Bending from the curvatures of a grid or a mesh; `directions` are the prescribed slopes that
    /// they refer to, in world coordinates.
    pub fn new(source: Vec<CurvatureGroup>, directions: &[DVec3]) -> Self {
        let mut all = Self::default();
        for group in &source {
            all.push(group, directions);
        }
        all.source = source;
        all
    }

    /// Adds a group.
    fn push(&mut self, source: &CurvatureGroup, directions: &[DVec3]) {
        let first = self.masses.len();
        let mut entries: Vec<(u32, [f64; 3])> = Vec::new();
        for (a, row) in source.rows.iter().enumerate() {
            for (mass, weight) in row {
                match entries.iter_mut().find(|(m, _)| m == mass) {
                    Some((_, w)) => w[a] += weight,
                    None => {
                        let mut w = [0.0; 3];
                        w[a] = *weight;
                        entries.push((*mass, w));
                    }
                }
            }
        }
        // Sorted by node, so that pairs lie in the lower triangle.
        entries.sort_by_key(|(m, _)| *m);
        let pairs = self.pairs.len();
        for p in 0..entries.len() {
            for q in 0..=p {
                self.pairs.push(Pair { block: NO_BLOCK, of: (p as u32, q as u32), value: 0.0 });
            }
        }
        for (mass, weight) in entries {
            self.masses.push(mass);
            self.weights.push(weight);
        }
        let prescribed = [0, 1, 2].map(|a| {
            let each = source.clamps[a].iter().filter_map(|(d, w)| directions.get(*d as usize).map(|t| *t * *w));
            each.sum::<DVec3>()
        });
        self.groups.push(BendingGroup {
            entries: (first as u32, self.masses.len() as u32),
            prescribed,
            frame: source.frame,
            stiffness: [[0.0; 3]; 3],
            softness: 1.0,
            anchor: [0.0; 3],
            rate: [0.0; 3],
            pairs: (pairs as u32, self.pairs.len() as u32),
        });
    }

    fn entries(&self, group: &BendingGroup) -> impl Iterator<Item = (usize, &[f64; 3])> {
        let range = group.entries.0 as usize..group.entries.1 as usize;
        self.masses[range.clone()].iter().map(|m| *m as usize).zip(&self.weights[range])
    }

    /// Computes the couplings from the stiffness of the groups, and the constant tangent.
    fn update_pairs(&mut self) {
        for group in &self.groups {
            let weight = |entry: u32| &self.weights[(group.entries.0 + entry) as usize];
            for pair in &mut self.pairs[group.pairs.0 as usize..group.pairs.1 as usize] {
                pair.value = dot(weight(pair.of.0), &times_scalar(&group.stiffness, weight(pair.of.1)));
            }
        }
        self.sum_constant();
    }

    /// κ of a group at positions `x`; its rate for velocities `x` and zero `prescribed`.
    #[inline(always)]
    fn curvature(&self, group: &BendingGroup, x: &Vectors, prescribed: &[DVec3; 3]) -> [DVec3; 3] {
        let mut k = *prescribed;
        for (mass, w) in self.entries(group) {
            let p = x.get(mass);
            for a in 0..3 {
                k[a] += p * w[a];
            }
        }
        k
    }

    /// Adds `scale` Σ wᵀ m to `to`, with the moments m (N m²) of a group.
    #[inline(always)]
    fn add_moments(&self, group: &BendingGroup, moments: &[DVec3; 3], scale: f64, to: &mut Vectors) {
        for (mass, w) in self.entries(group) {
            let f = (moments[0] * w[0] + moments[1] * w[1] + moments[2] * w[2]) * scale;
            to.add(mass, f);
        }
    }
}

/// The unit normal of a group's frame; zero for a degenerate frame.
#[inline(always)]
fn normal(group: &BendingGroup, x: &Vectors) -> DVec3 {
    let [a, b, c, d] = group.frame;
    let n = (x.get(b as usize) - x.get(a as usize)).cross(x.get(d as usize) - x.get(c as usize));
    let squared = n.length_squared();
    if squared > 0.0 { n / squared.sqrt() } else { DVec3::ZERO }
}

/// Axes that rotate with a group: first side of its frame, normal, and their cross product.
#[inline(always)]
fn axes(group: &BendingGroup, x: &Vectors) -> [DVec3; 3] {
    let n = normal(group, x);
    let [a, b, ..] = group.frame;
    let p = (x.get(b as usize) - x.get(a as usize)).normalize_or_zero();
    [p, n, n.cross(p)]
}

/// The unit normal and its rate, 1/s.
fn normal_and_rate(group: &BendingGroup, x: &Vectors, v: &Vectors) -> (DVec3, DVec3) {
    let sides = |of: &Vectors| {
        let [a, b, c, d] = group.frame.map(|m| of.get(m as usize));
        (b - a, d - c)
    };
    let ((p, q), (p_rate, q_rate)) = (sides(x), sides(v));
    let across = p.cross(q);
    let length = across.length();
    if length <= 0.0 {
        return (DVec3::ZERO, DVec3::ZERO);
    }
    let n = across / length;
    let rate = (p_rate.cross(q) + p.cross(q_rate)) / length;
    (n, rate - n * rate.dot(n))
}

/// Remaining stiffness and thermal curvature (1/m) of a group: means over its nodes, weighted with
/// the absolute stencil weights.
fn softness_and_curl(warmth: &ThermalFields, masses: &[u32], weights: &[[f64; 3]]) -> (f64, f64) {
    let (mut compliance, mut curl, mut sum) = (0.0, 0.0, 0.0);
    for (mass, w) in masses.iter().zip(weights) {
        let weight = w[0].abs() + w[1].abs() + w[2].abs();
        compliance += weight * warmth.compliance[*mass as usize];
        curl += weight * warmth.curl.get(*mass as usize).copied().unwrap_or(0.0);
        sum += weight;
    }
    (sum / compliance, curl / sum)
}

// Written out: closures over arrays are not inlined into the loops over groups.
#[inline(always)]
fn along(k: &[DVec3; 3], n: DVec3) -> [f64; 3] {
    [k[0].dot(n), k[1].dot(n), k[2].dot(n)]
}

#[inline(always)]
fn times(d: &[[f64; 3]; 3], k: &[DVec3; 3]) -> [DVec3; 3] {
    [
        k[0] * d[0][0] + k[1] * d[0][1] + k[2] * d[0][2],
        k[0] * d[1][0] + k[1] * d[1][1] + k[2] * d[1][2],
        k[0] * d[2][0] + k[1] * d[2][1] + k[2] * d[2][2],
    ]
}

#[inline(always)]
fn times_scalar(d: &[[f64; 3]; 3], k: &[f64; 3]) -> [f64; 3] {
    [
        k[0] * d[0][0] + k[1] * d[0][1] + k[2] * d[0][2],
        k[0] * d[1][0] + k[1] * d[1][1] + k[2] * d[1][2],
        k[0] * d[2][0] + k[1] * d[2][1] + k[2] * d[2][2],
    ]
}

/// D with the directions `relaxed` condensed out: D - D B (Bᵀ D B)⁻¹ Bᵀ D, one direction after
/// another, each made D-orthogonal to the earlier ones.
pub fn condensed(mut d: [[f64; 3]; 3], relaxed: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let largest = d[0][0].max(d[1][1]).max(d[2][2]);
    for b in relaxed {
        let db = [0, 1, 2].map(|i: usize| d[i][0] * b[0] + d[i][1] * b[1] + d[i][2] * b[2]);
        let bdb = b[0] * db[0] + b[1] * db[1] + b[2] * db[2];
        let size = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
        if bdb <= 1e-12 * largest * size {
            continue;
        }
        for i in 0..3 {
            for j in 0..3 {
                d[i][j] -= db[i] * db[j] / bdb;
            }
        }
    }
    d
}

impl Element for Bending {
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32)) {
        for group in &self.groups {
            let masses = &self.masses[group.entries.0 as usize..group.entries.1 as usize];
            for (p, a) in masses.iter().enumerate() {
                masses[..p].iter().for_each(|b| visit(*a, *b));
            }
        }
        if let Some(rests) = &self.rest_curvature {
            rests.rotation.visit_coupled_nodes(visit);
        }
    }

    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32) {
        for group in &self.groups {
            let first = group.entries.0;
            for pair in &mut self.pairs[group.pairs.0 as usize..group.pairs.1 as usize] {
                let (a, b) = (self.masses[(first + pair.of.0) as usize], self.masses[(first + pair.of.1) as usize]);
                pair.block = block(a, b);
            }
        }
        self.order.clear();
        self.order.extend((0..self.pairs.len() as u32).filter(|i| self.pairs[*i as usize].block != NO_BLOCK));
        self.order.sort_by_key(|i| self.pairs[*i as usize].block);
        self.sum_constant();
        if let Some(rests) = &mut self.rest_curvature {
            rests.rotation.bind_blocks(block);
        }
    }

    fn set_law(&mut self, law: &ElementLaw) {
        self.retardation = law.retardation;
        self.arms.set_weights(law.bending_arms, 3 * self.groups.len());
        if !self.arms.is_empty() {
            self.reset_rates();
        }
        for (group, source) in self.groups.iter_mut().zip(&self.source) {
            let soft = source.area * group.softness;
            group.stiffness = condensed(law.bending, &source.relaxed).map(|row| row.map(|d| d * soft));
        }
        if self.rest_curvature.is_some() {
            return self.set_rest_law(law.bending[0][0]);
        }
        self.update_pairs();
    }

    fn apply_temperature(&mut self, x: &Vectors, warmth: &ThermalFields) {
        if self.rest.is_empty() {
            self.rest = vec![[DVec3::ZERO; 3]; self.groups.len()];
            self.curl = vec![0.0; self.groups.len()];
        }
        for i in 0..self.groups.len() {
            let group = &self.groups[i];
            let range = group.entries.0 as usize..group.entries.1 as usize;
            let (softness, curl) = softness_and_curl(warmth, &self.masses[range.clone()], &self.weights[range]);
            let (k, axes) = (self.curvature(group, x, &group.prescribed), axes(group, x));
            let rest = &mut self.rest[i];
            // A group with twist alone has no thermal curvature.
            let rows = &self.source[i].rows;
            let bends = !(rows[0].is_empty() && rows[1].is_empty());
            let curled = if bends { curl - self.curl[i] } else { 0.0 };
            let mut along_normal = self.rest_curvature.as_deref_mut();
            if let Some(rests) = &mut along_normal {
                rests.apply_temperature(i, curled, k.map(|k| k.dot(axes[1])), (group.softness, softness));
            } else {
                (0..2).for_each(|a| rest[a].y += curled);
            }
            for a in 0..3 {
                for (part, axis) in axes.iter().enumerate().filter(|(part, _)| *part != 1 || along_normal.is_none()) {
                    rest[a][part] =
                        rest_strain_after_softening(k[a].dot(*axis), rest[a][part], group.softness, softness);
                }
            }
            self.curl[i] = curl;
            let group = &mut self.groups[i];
            let change = softness / group.softness;
            (0..3).for_each(|a| self.arms.scale(3 * i + a, 1.0 / change));
            group.softness = softness;
            group.stiffness.iter_mut().flatten().for_each(|s| *s *= change);
            let pairs = group.pairs.0 as usize..group.pairs.1 as usize;
            self.pairs[pairs].iter_mut().for_each(|p| p.value *= change);
        }
        if let Some(rests) = &mut self.rest_curvature {
            rests.update_is_flat();
        }
        self.sum_constant();
    }

    fn open(&mut self, _x: &Vectors, open: &OpenCells, _gone: &[bool]) {
        if self.whole.is_empty() {
            self.whole = self.source.iter().map(ClosedPart::from_group).collect();
        }
        let columns = open.size().0 + 1;
        for ((source, group), whole) in self.source.iter_mut().zip(&mut self.groups).zip(&self.whole) {
            let left = match open.triangles() {
                None => whole.closed_part(source, columns, open),
                Some(cells) => whole.closed_triangle(source.home as usize, cells, open.cells()),
            };
            (source.area, source.relaxed, source.frame, group.frame) =
                (left.area, left.relaxed, left.frame, left.frame);
        }
        self.find_frames();
    }

    fn energy(&self, x: &Vectors) -> f64 {
        if let Some(rests) = self.rest_curvature.as_deref().filter(|r| !r.is_elastic()) {
            return self.rest_energy(x, rests) + self.arm_energy();
        }
        let stored = if self.rest.is_empty() { self.stored_energy::<false>(x) } else { self.stored_energy::<true>(x) };
        stored + self.arm_energy()
    }

    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        if self.rest.is_empty() {
            self.forces::<false>(x, v, force)
        } else {
            self.forces::<true>(x, v, force)
        }
        self.add_rest_gradient(x, -1.0, force);
    }

    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64) {
        self.viscous = self.retardation * per_time + self.arms.begin_stage(per_time, anchors, follow);
        self.per_time = per_time;
        if self.viscous == 0.0 {
            return;
        }
        for i in 0..self.groups.len() {
            let g = &self.groups[i];
            let mut sum = g.rate.map(|r| r * follow);
            for anchor in anchors {
                let k = along(&self.curvature(g, anchor.x, &g.prescribed), normal(g, anchor.x));
                for a in 0..3 {
                    sum[a] += anchor.weight * k[a];
                }
            }
            self.arms.shift(3 * i, &mut sum);
            self.groups[i].anchor = sum;
        }
    }

    fn finish_stage(&mut self, x: &Vectors) {
        if self.viscous == 0.0 {
            return;
        }
        for i in 0..self.groups.len() {
            let g = &self.groups[i];
            let k = along(&self.curvature(g, x, &g.prescribed), normal(g, x));
            let mut change = [0, 1, 2].map(|a| k[a] - g.anchor[a]);
            if self.arms.is_empty() {
                self.groups[i].rate = change.map(|c| c * self.per_time);
            } else {
                self.arms.finish(3 * i, &mut change);
            }
        }
    }

    fn reset_rates(&mut self) {
        self.groups.iter_mut().for_each(|g| g.rate = [0.0; 3]);
    }

    fn visit_history(&mut self, visit: &mut dyn FnMut(&mut [f64])) {
        self.groups.iter_mut().for_each(|g| visit(&mut g.rate));
    }

    fn serialise_history(&self, to: &mut StateWriter) {
        // One sparse list: a group of a grid has one or two of the three rates.
        to.sparse(self.groups.iter().map(|g| g.rate).collect::<Vec<_>>().as_flattened());
    }

    fn deserialise_history(&mut self, from: &mut StateReader) -> ReadResult {
        let mut rates = vec![[0.0; 3]; self.groups.len()];
        from.sparse(rates.as_flattened_mut())?;
        self.groups.iter_mut().zip(rates).for_each(|(g, rate)| g.rate = rate);
        Ok(())
    }

    /// Serialises stiffness and rest state. The values of the pairs are included, because each
    /// change of temperature or creep scale rounds them.
    fn serialise_changes(&self, to: &mut StateWriter) {
        self.groups.iter().for_each(|g| to.number(g.softness));
        self.groups.iter().for_each(|g| g.stiffness.serialise(to));
        self.pairs.iter().for_each(|p| to.number(p.value));
        to.flag(!self.rest.is_empty());
        for (rest, curl) in self.rest.iter().zip(&self.curl) {
            rest.iter().for_each(|r| to.sparse(&r.to_array()));
            to.number(*curl);
        }
        self.rest_curvature.iter().for_each(|rests| rests.serialise(to));
    }

    fn deserialise_changes(&mut self, from: &mut StateReader) -> ReadResult {
        self.groups.iter_mut().try_for_each(|g| g.softness.deserialise(from))?;
        self.groups.iter_mut().try_for_each(|g| g.stiffness.deserialise(from))?;
        self.pairs.iter_mut().try_for_each(|p| p.value.deserialise(from))?;
        let count = if from.flag()? { self.groups.len() } else { 0 };
        self.rest.resize(count, [DVec3::ZERO; 3]);
        self.curl.resize(count, 0.0);
        for (rest, curl) in self.rest.iter_mut().zip(&mut self.curl) {
            for r in rest {
                *r = DVec3::from_array(from.sparse_array()?);
            }
            curl.deserialise(from)?;
        }
        self.rest_curvature.iter_mut().try_for_each(|rests| rests.deserialise(from))?;
        self.sum_constant();
        Ok(())
    }

    fn potential(&self, x: &Vectors) -> f64 {
        let stored = if self.rest.is_empty() { self.staged::<false>(x) } else { self.staged::<true>(x) };
        stored + self.rest_potential(x)
    }

    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors) {
        if self.rest.is_empty() {
            self.gradient::<false>(x, gradient)
        } else {
            self.gradient::<true>(x, gradient)
        }
        self.add_rest_gradient(x, 1.0, gradient);
    }

    fn add_constant_tangent(&self, _per_time: f64, values: &mut [f64]) {
        for (block, value) in &self.constant {
            let at = *block as usize * 9;
            for diagonal in [at, at + 4, at + 8] {
                values[diagonal] += value;
            }
        }
    }

    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        self.add_rest_tangent(x, geometric, values);
        if self.viscous == 0.0 {
            return;
        }
        for g in &self.groups {
            let n = normal(g, x).to_array();
            for pair in &self.pairs[g.pairs.0 as usize..g.pairs.1 as usize] {
                if pair.block != NO_BLOCK && pair.value != 0.0 {
                    let at = pair.block as usize * 9;
                    let scale = pair.value * self.viscous;
                    for (row, a) in values[at..at + 9].chunks_exact_mut(3).zip(n) {
                        for (to, b) in row.iter_mut().zip(n) {
                            *to += scale * a * b;
                        }
                    }
                }
            }
        }
    }

    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        self.normal_prediction_error(x, d)
    }

    fn rest_angles(&self) -> Option<Vec<[f64; 3]>> {
        self.rest_curvature.is_some().then(|| self.stress_free_angles())
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
            self.transfer_rest_curvature(old, carry);
        }
    }

    fn as_inelastic(&mut self) -> Option<&mut dyn InelasticElement> {
        self.rest_curvature.is_some().then_some(self as &mut dyn InelasticElement)
    }
}
