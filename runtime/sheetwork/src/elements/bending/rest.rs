//! Rest curvature of a shell, and its change by creep and plasticity.
//!
//! E = ½ S (κ - o n)ᵀ D (κ - o n) (J) with the sheet's normal n and the rest strain o, 1/m, of
//! (uu, vv, 2uv). The bending element has the part ½ S κᵀ D κ with its constant tangent; this
//! file adds -S oᵀ D (κ·n) + ½ S oᵀ D o. The gradient includes the change of the normal, so
//! the forces have a potential and no moment. With k = κ·n and the moments
//! m = S (D o + o' D (k - o)) taken from those of a flat sheet, the tangent has the change of m
//! and the term of the second derivative of n, kᵀ m ∂nᵀ ∂n for an inextensible sheet.
//!
//! The rest curvature k₀ consists of the initial curvature (creases, curl), plastic curvature and
//! creep (see [`crate::elements::creep`]). A crease is an angle: where a grid bends by the angle φ
//! between neighbouring cells, k₀ is 2 sin(φ/2)/h, and the yield condition uses angles as well.
//! The rest strain is k₀ in a creeping sheet. Otherwise it makes the stiffness of a crease that
//! of a flat cell, D/h: loads open it equally on any grid ([`CurvatureGroup::rest_strain`]).

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec3};

use crate::elements::bending::normal_rotation::NormalRotation;
use crate::elements::bending::{Bending, BendingGroup, along, normal, times, times_scalar};
use crate::elements::creep::{CreepStrain, InelasticElement, InelasticStep, YieldLaw};
use crate::elements::curvature::{CurvatureGroup, dot};
use crate::elements::{Geometric, NO_BLOCK, rest_strain_after_softening};
use crate::math::Vectors;
use crate::serialize::state;

/// Rest curvature of all groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct RestCurvature {
    /// k₀ of each group; during a step that of the step's elastic law.
    pub(crate) rest: Vec<[f64; 3]>,
    /// Initial rest curvature, as angles per length, 1/m.
    pub(crate) design_angles: Vec<[f64; 3]>,
    /// Instantaneous stiffness S D of each group, N m³.
    full: Vec<[[f64; 3]; 3]>,
    /// Stiffness of each group in the step, relative to the instantaneous one.
    scale: Vec<f64>,
    /// Nodes and pairs of each group and its frame.
    pub(crate) rotation: NormalRotation,
    /// Creep state of each group; empty without creep.
    pub(crate) strains: Vec<[CreepStrain; 3]>,
    /// Shares of the Maxwell arms.
    share: [f64; 2],
    /// Accumulated plastic curvature α of each group, 1/m; empty without plasticity.
    pub(crate) hardened: Vec<f64>,
    /// D along the sheet's length, N m.
    stiffness: f64,
    /// Whether a step is in progress.
    is_in_step: bool,
    /// Whether k₀ is zero everywhere: this file then contributes nothing and is skipped.
    is_flat: bool,
    /// Buffers for the derivatives of a group.
    rotation_derivatives: Vec<DMat3>,
    coupled: Vec<f64>,
}

/// Sides of a group's frame, its normal and the length of the sides' cross product.
struct NormalFrame {
    p: DVec3,
    q: DVec3,
    n: DVec3,
    length: f64,
}

impl NormalFrame {
    fn of(group: &BendingGroup, x: &Vectors) -> Option<Self> {
        let [a, b, c, d] = group.frame.map(|m| x.get(m as usize));
        let (p, q) = (b - a, d - c);
        let across = p.cross(q);
        let length = across.length();
        (length > 0.0).then(|| Self { p, q, n: across / length, length })
    }

    /// First-order change of n for changes of the sides.
    fn turn(&self, dp: DVec3, dq: DVec3) -> DVec3 {
        let change = dp.cross(self.q) + self.p.cross(dq);
        (change - self.n * self.n.dot(change)) / self.length
    }

    /// ∂n with respect to the frame's nodes a, b, c, d.
    fn derivatives(&self) -> [DMat3; 4] {
        let cross = |v: DVec3| DMat3::from_cols(v.cross(DVec3::X), v.cross(DVec3::Y), v.cross(DVec3::Z));
        let n = self.n;
        let project = (DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z)) * (1.0 / self.length);
        let (by_p, by_q) = (project * cross(-self.q), project * cross(self.p));
        [by_p * -1.0, by_p, by_q * -1.0, by_q]
    }
}

impl RestCurvature {
    /// Applies temperature to group `i`: the thermal curvature changes by `curled` (1/m) and the
    /// remaining stiffness from `softness.0` to `softness.1` at curvatures `k` (1/m) along the
    /// normal. Stiffening keeps the moment.
    pub fn apply_temperature(&mut self, i: usize, curled: f64, k: [f64; 3], softness: (f64, f64)) {
        let kept = (softness.0 / softness.1).min(1.0);
        for a in 0..3 {
            let curl = if a < 2 { curled } else { 0.0 };
            self.rest[i][a] += curl;
            if let Some(strain) = self.strains.get_mut(i).map(|s| &mut s[a]) {
                strain.move_rest(curl, self.share);
                strain.scale_stress(k[a], kept, self.share);
                self.rest[i][a] = strain.stress_free();
            } else {
                self.rest[i][a] = rest_strain_after_softening(k[a], self.rest[i][a], softness.0, softness.1);
            }
        }
        let change = softness.1 / softness.0;
        self.full[i].iter_mut().flatten().for_each(|d| *d *= change);
    }

    /// Curvatures (1/m) at which group `i` has no moment.
    pub fn stress_free(&self, i: usize) -> [f64; 3] {
        self.strains.get(i).map_or(self.rest[i], |strains| strains.map(|s| s.stress_free()))
    }

    /// Recomputes whether the rest curvature is zero, after each change of k₀.
    pub fn update_is_flat(&mut self) {
        self.is_flat = self.rest.iter().all(is_flat);
    }

    /// Upper bound of the squared moment (N²) of group `i` with zero rest curvature at `curvature`
    /// (1/m): asin s ≤ π/2 s, and no eigenvalue of a positive semi-definite matrix exceeds its
    /// trace.
    fn moment_squared_bound(&self, i: usize, g: &BendingGroup, source: &CurvatureGroup, curvature: &[DVec3; 3]) -> f64 {
        let bent = |a: usize| curvature[a].length_squared() / (source.gain[a] * source.gain[a]);
        let full = &self.full[i];
        let largest = (full[0][0] + full[1][1] + full[2][2]) / (g.softness * source.area);
        FRAC_PI_2 * FRAC_PI_2 * self.stiffness * largest * (bent(0) + bent(1) + bent(2))
    }

    /// Whether the energy is that of a flat elastic sheet: no rest curvature and no creep arms.
    pub fn is_elastic(&self) -> bool {
        self.is_flat && self.strains.is_empty()
    }
}

state!(RestCurvature: rest, full, scale, strains, hardened, is_in_step; then update_is_flat);

fn is_flat(rest: &[f64; 3]) -> bool {
    *rest == [0.0; 3]
}

/// Moment and its derivative with respect to the curvature.
type MomentAndChange = ([f64; 3], [[f64; 3]; 3]);

impl Bending {
    /// As [`Bending::new`], with rest curvature: `angles` of each group (uu, vv, 2uv) are angles
    /// per length (1/m) towards the sheet's upper side. `creeps` are the shares of the Maxwell
    /// arms; `yields` enables plasticity.
    pub fn with_rest(
        source: Vec<CurvatureGroup>,
        directions: &[DVec3],
        angles: &[[f64; 3]],
        creeps: Option<[f64; 2]>,
        yields: bool,
    ) -> Self {
        let mut all = Self::new(source, directions);
        let n = all.groups.len();
        let mut rests = RestCurvature { scale: vec![1.0; n], full: vec![[[0.0; 3]; 3]; n], ..RestCurvature::default() };
        rests.rest =
            all.source.iter().zip(angles).map(|(g, k)| [0, 1, 2].map(|a| g.curvature_from_angle(a, k[a]))).collect();
        rests.rest.resize(n, [0.0; 3]);
        rests.design_angles = angles.to_vec();
        rests.design_angles.resize(n, [0.0; 3]);
        rests.rotation = NormalRotation::new(&all);
        let most = rests.rotation.largest_group();
        rests.rotation_derivatives = vec![DMat3::ZERO; most];
        rests.coupled = vec![0.0; most];
        if let Some(share) = creeps {
            rests.share = share;
            let begun = |k: &[f64; 3]| k.map(|start| CreepStrain { start, rest: start, ..CreepStrain::default() });
            rests.strains = rests.rest.iter().map(begun).collect();
        }
        if yields {
            rests.hardened = vec![0.0; n];
        }
        rests.update_is_flat();
        all.rest_curvature = Some(Box::new(rests));
        all
    }

    /// Finds the positions of the frames' nodes in their groups.
    pub(crate) fn find_frames(&mut self) {
        if let Some(mut rests) = self.rest_curvature.take() {
            rests.rotation.find_frames(self);
            self.rest_curvature = Some(rests);
        }
    }

    /// Sets the stiffness of the groups; see [`crate::elements::Element::set_law`].
    pub(crate) fn set_rest_law(&mut self, stiffness: f64) {
        let Some(rests) = &mut self.rest_curvature else { return };
        rests.stiffness = stiffness;
        for (full, g) in rests.full.iter_mut().zip(&self.groups) {
            *full = g.stiffness;
        }
        self.rescale();
    }

    /// Applies the scale of the step to stiffnesses and the constant tangent.
    fn rescale(&mut self) {
        let Some(rests) = &self.rest_curvature else { return };
        for ((group, full), scale) in self.groups.iter_mut().zip(&rests.full).zip(&rests.scale) {
            group.stiffness = full.map(|row| row.map(|d| d * scale));
        }
        self.update_pairs();
    }

    /// Stored energy with rest curvature, J; between steps it includes the energy of the creep
    /// arms.
    pub(crate) fn rest_energy(&self, x: &Vectors, rests: &RestCurvature) -> f64 {
        if rests.is_in_step || rests.strains.is_empty() {
            return (0..self.groups.len()).map(|i| self.stored_at(i, rests, x)).sum();
        }
        let share = rests.share;
        let one = |i: usize| {
            let (full, strains) = (&rests.full[i], &rests.strains[i]);
            let (k, n) = self.bent(i, x);
            let scalar = along(&k, n);
            let arms = [0, 1, 2].map(|a| strains[a].arms_at(scalar[a], share));
            let mut sum = 0.0;
            for i in (0..2).filter(|i| share[*i] > 0.0) {
                let s = arms.map(|s| s[i]);
                sum += 0.5 * dot(&s, &times_scalar(full, &s)) / share[i];
            }
            // The part of κ across the normal has no arms.
            let across = [0, 1, 2].map(|a| k[a] - n * scalar[a]);
            let m = times(full, &across);
            sum + 0.5 * (across[0].dot(m[0]) + across[1].dot(m[1]) + across[2].dot(m[2]))
        };
        (0..self.groups.len()).map(one).sum()
    }

    /// The curvatures of group `i` minus the thermal ones across the normal, and the normal.
    fn bent(&self, i: usize, x: &Vectors) -> ([DVec3; 3], DVec3) {
        let g = &self.groups[i];
        let mut k = self.curvature(g, x, &g.prescribed);
        if !self.rest.is_empty() {
            self.less_rest::<true>(i, &mut k, x);
        }
        (k, normal(g, x))
    }

    /// Rest strains of group `i` at curvatures `k` (1/m) along the normal, 1/m, and their first and
    /// second derivatives. The law of a creeping sheet is linear in the curvature.
    fn rest_strains(&self, i: usize, k: &[f64; 3], rests: &RestCurvature) -> [[f64; 3]; 3] {
        let source = &self.source[i];
        let one = |a: usize, rest: f64| {
            if rests.strains.is_empty() { source.rest_strain(a, k[a], rest) } else { [rest, 0.0, 0.0] }
        };
        let each = [0, 1, 2].map(|a| one(a, rests.rest[i][a]));
        [0, 1, 2].map(|d| each.map(|o| o[d]))
    }

    /// Moments of group `i` (N m²) along the normal at curvatures `k` (1/m), subtracted from those
    /// of a flat sheet, and the change of the stiffness by the rest strains, N m³; `geometric`
    /// chooses whether the part of the stress may be negative.
    fn rest_moments(&self, i: usize, k: &[f64; 3], rests: &RestCurvature, geometric: Geometric) -> MomentAndChange {
        let d = &self.groups[i].stiffness;
        let [o, slope, bend] = self.rest_strains(i, k, rests);
        let stress = times_scalar(d, &[k[0] - o[0], k[1] - o[1], k[2] - o[2]]);
        let rest = times_scalar(d, &o);
        let least = if geometric == Geometric::Clipped { 0.0 } else { f64::NEG_INFINITY };
        let change = |a: usize, b: usize| {
            let own = if a == b { (-bend[a] * stress[a]).max(least) } else { 0.0 };
            d[a][b] * ((1.0 - slope[a]) * (1.0 - slope[b]) - 1.0) + own
        };
        ([0, 1, 2].map(|a| rest[a] + slope[a] * stress[a]), [0, 1, 2].map(|a| [0, 1, 2].map(|b| change(a, b))))
    }

    /// Stored energy of group `i`, J.
    fn stored_at(&self, i: usize, rests: &RestCurvature, x: &Vectors) -> f64 {
        let (k, n) = self.bent(i, x);
        let [rest, ..] = self.rest_strains(i, &along(&k, n), rests);
        let e = [0, 1, 2].map(|a| k[a] - n * rest[a]);
        let m = times(&self.groups[i].stiffness, &e);
        0.5 * (e[0].dot(m[0]) + e[1].dot(m[1]) + e[2].dot(m[2]))
    }

    /// Contribution of rest curvature to the potential of the stage, J.
    pub(crate) fn rest_potential(&self, x: &Vectors) -> f64 {
        let Some(rests) = self.rest_curvature.as_deref().filter(|r| !r.is_flat) else { return 0.0 };
        let bent = self.groups.iter().enumerate().filter(|(i, _)| !is_flat(&rests.rest[*i]));
        let one = |(i, g): (usize, &BendingGroup)| {
            let k = along(&self.curvature(g, x, &g.prescribed), normal(g, x));
            let [rest, ..] = self.rest_strains(i, &k, rests);
            let m = times_scalar(&g.stiffness, &rest);
            0.5 * dot(&rest, &m) - dot(&k, &m)
        };
        bent.map(one).sum()
    }

    /// Adds `scale` times the gradient of [`Bending::rest_potential`], N.
    pub(crate) fn add_rest_gradient(&self, x: &Vectors, scale: f64, to: &mut Vectors) {
        let Some(rests) = self.rest_curvature.as_deref().filter(|r| !r.is_flat) else { return };
        for (i, g) in self.groups.iter().enumerate().filter(|(i, _)| !is_flat(&rests.rest[*i])) {
            let Some(frame) = NormalFrame::of(g, x) else { continue };
            let k = self.curvature(g, x, &g.prescribed);
            let n = frame.n;
            let (m, _) = self.rest_moments(i, &along(&k, n), rests, Geometric::Mixed);
            self.add_moments(g, &[n * m[0], n * m[1], n * m[2]], -scale, to);
            let pull = k[0] * m[0] + k[1] * m[1] + k[2] * m[2];
            let t = (pull - n * n.dot(pull)) * (scale / frame.length);
            let (by_p, by_q) = (frame.q.cross(t), t.cross(frame.p));
            for (mass, f) in g.frame.into_iter().zip([by_p, -by_p, by_q, -by_q]) {
                to.add(mass as usize, f);
            }
        }
    }

    /// Adds the tangent of [`Bending::rest_potential`], N/m.
    pub(crate) fn add_rest_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]) {
        let Some(mut rests) = self.rest_curvature.take_if(|r| !r.is_flat) else { return };
        let (mut turns, mut coupled) =
            (std::mem::take(&mut rests.rotation_derivatives), std::mem::take(&mut rests.coupled));
        let turning = &rests.rotation;
        for (i, g) in self.groups.iter().enumerate().filter(|(i, _)| !is_flat(&rests.rest[*i])) {
            let Some(frame) = NormalFrame::of(g, x) else { continue };
            let k = along(&self.curvature(g, x, &g.prescribed), frame.n);
            let (m, change) = self.rest_moments(i, &k, &rests, geometric);
            turns[..turning.masses_of(i).len()].fill(DMat3::ZERO);
            let weights = turning.weights_of(i);
            coupled.iter_mut().zip(weights).for_each(|(to, w)| *to = dot(w, &m));
            for (place, by) in turning.frame[i].iter().zip(frame.derivatives()) {
                turns[*place as usize] += by;
            }
            let now = dot(&k, &m);
            let square = if geometric == Geometric::Clipped { now.max(dot(&rests.rest[i], &m)) } else { now };
            let along = DMat3::from_cols(frame.n * frame.n.x, frame.n * frame.n.y, frame.n * frame.n.z);
            for couple in turning.pairs_of(i).iter().filter(|c| c.block != NO_BLOCK) {
                let (p, q) = (couple.of.0 as usize, couple.of.1 as usize);
                let (tp, tq) = (turns[p].transpose(), turns[q]);
                let stiffer = dot(&weights[p], &times_scalar(&change, &weights[q]));
                let block = tp * tq * square - tq * coupled[p] - tp * coupled[q] + along * stiffer;
                let at = couple.block as usize * 9;
                let by_rows = block.transpose().to_cols_array();
                values[at..at + 9].iter_mut().zip(by_rows).for_each(|(to, from)| *to += from);
            }
        }
        (rests.rotation_derivatives, rests.coupled) = (turns, coupled);
        self.rest_curvature = Some(rests);
    }

    /// Energy (J) of the second-order rotation of the normal for a displacement `d` from `x` (m).
    pub(crate) fn normal_prediction_error(&self, x: &Vectors, d: &Vectors) -> f64 {
        let Some(rests) = self.rest_curvature.as_deref().filter(|r| !r.is_flat) else { return 0.0 };
        let mut missed = 0.0;
        for (g, rest) in self.groups.iter().zip(&rests.rest).filter(|(_, rest)| !is_flat(rest)) {
            let Some(frame) = NormalFrame::of(g, x) else { continue };
            let [a, b, c, e] = g.frame.map(|m| d.get(m as usize));
            let (dp, dq) = (b - a, e - c);
            let across = (frame.p + dp).cross(frame.q + dq).normalize_or_zero();
            let miss = across - frame.n - frame.turn(dp, dq);
            missed += 0.5 * dot(rest, &times_scalar(&g.stiffness, rest)) * miss.length_squared();
        }
        missed
    }

    /// Applies the yield condition to all groups at `x` (m).
    fn apply_yield(&self, x: &Vectors, law: &YieldLaw, rests: &mut RestCurvature) {
        let within = law.moment * law.moment;
        for (i, g) in self.groups.iter().enumerate() {
            let source = &self.source[i];
            let curvature = self.curvature(g, x, &g.prescribed);
            if source.area <= 0.0 || (rests.is_flat && rests.moment_squared_bound(i, g, source, &curvature) <= within) {
                continue;
            }
            let n = normal(g, x);
            if n == DVec3::ZERO {
                continue;
            }
            let k = along(&curvature, n);
            let rest = rests.stress_free(i);
            let bent = [0, 1, 2].map(|a| source.angle_from_curvature(a, k[a]));
            let made = [0, 1, 2].map(|a| source.angle_from_curvature(a, rest[a]));
            let elastic = [bent[0] - made[0], bent[1] - made[1], bent[2] - made[2]];
            // The yield condition uses the stiffness at 20 °C: yield strain does not depend on
            // temperature.
            let full = &rests.full[i].map(|row| row.map(|d| d / g.softness));
            let moment = (rests.stiffness * dot(&elastic, &times_scalar(full, &elastic)) / source.area).max(0.0).sqrt();
            let main = usize::from(elastic[1].abs() > elastic[0].abs());
            let flow = law.plastic_increment(moment, rests.stiffness, rests.hardened[i], source.span[main]);
            if flow <= 0.0 {
                continue;
            }
            rests.hardened[i] += flow;
            let part = flow * rests.stiffness / moment;
            let next = [0, 1, 2].map(|a| source.curvature_from_angle(a, made[a] + part * elastic[a]));
            if let Some(strains) = rests.strains.get_mut(i) {
                (0..3).for_each(|a| strains[a].move_rest(next[a] - rest[a], rests.share));
            }
            rests.rest[i] = next;
            rests.is_flat = false;
        }
    }

    /// Angles per length (1/m) towards the upper side at which each group has no moment.
    pub(crate) fn stress_free_angles(&self) -> Vec<[f64; 3]> {
        let each = self.rest_curvature.iter().flat_map(|r| (0..r.rest.len()).map(|i| (i, r.stress_free(i))));
        each.map(|(i, rest)| [0, 1, 2].map(|a| self.source[i].angle_from_curvature(a, rest[a]))).collect()
    }
}

impl InelasticElement for Bending {
    fn begin_step(&mut self, x: &Vectors, step: Option<&InelasticStep>) -> bool {
        let Some(mut rests) = self.rest_curvature.take() else { return false };
        let mut changed = false;
        let RestCurvature { strains, rest, scale, share, is_in_step: running, .. } = &mut *rests;
        *running = step.is_some();
        for (i, strains) in strains.iter_mut().enumerate() {
            let g = &self.groups[i];
            let decay = step.and_then(|step| step.decay(&g.frame));
            let k = along(&self.curvature(g, x, &g.prescribed), normal(g, x));
            (0..3).for_each(|a| strains[a].begin(k[a], *share, decay.as_ref()));
            rest[i] = strains.map(|s| s.rest);
            let stiffness = decay.map_or(1.0, |d| d.stiffness());
            changed |= std::mem::replace(&mut scale[i], stiffness) != stiffness;
        }
        if !rests.strains.is_empty() {
            rests.update_is_flat();
        }
        self.rest_curvature = Some(rests);
        if changed {
            self.rescale();
        }
        changed
    }

    fn end_step(&mut self, x: &Vectors, step: &InelasticStep) {
        let Some(mut rests) = self.rest_curvature.take() else { return };
        rests.is_in_step = false;
        for (i, strains) in rests.strains.iter_mut().enumerate() {
            let g = &self.groups[i];
            let Some(decay) = step.decay(&g.frame) else { continue };
            let k = along(&self.curvature(g, x, &g.prescribed), normal(g, x));
            (0..3).for_each(|a| strains[a].end(k[a], &decay));
        }
        if let Some(law) = step.law.plastic.filter(|_| !rests.hardened.is_empty()) {
            self.apply_yield(x, &law, &mut rests);
        }
        self.rest_curvature = Some(rests);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::Element;
    use crate::elements::derivative_check;
    use crate::elements::staggered::{StaggeredGrid, curvatures};
    use crate::elements::triangle_bending::triangle_curvatures;
    use crate::material::law::ElementLaw;

    fn law() -> ElementLaw {
        ElementLaw { retardation: 0.0, ..derivative_check::law() }
    }

    fn creased(clamped: &[bool], angle: f64) -> Bending {
        let grid = StaggeredGrid { columns: 7, rows: 5, spacing: (0.1, 0.15), clamped };
        let source = curvatures(&grid);
        let angles: Vec<[f64; 3]> = source.iter().map(|_| [angle, 0.4 * angle, -0.3 * angle]).collect();
        let mut bending = Bending::with_rest(source, &[DVec3::X, DVec3::Z], &angles, None, false);
        bending.set_law(&law());
        bending
    }

    #[test]
    fn the_gradient_is_that_of_the_potential() {
        let mut bending = creased(&[false; 35], 1.3);
        let x = derivative_check::bent_grid(7, 5, (0.1, 0.15));
        bending.begin_stage(0.0, &[], 0.0);
        let mut gradient = Vectors::zeros(35);
        bending.add_gradient(&x, &mut gradient);
        let largest = gradient.max_squared().sqrt();
        for dof in 0..105 {
            let at = |by: f64| {
                let mut y = x.clone();
                let mut p = y.get(dof / 3);
                p[dof % 3] += by;
                y.set(dof / 3, p);
                bending.potential(&y)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - gradient.get(dof / 3)[dof % 3]).abs() < 1e-7 * largest, "{dof}");
        }
        let mut force = Vectors::zeros(35);
        bending.add_forces(&x, &Vectors::zeros(35), &mut force);
        assert!((0..35).all(|i| (force.get(i) + gradient.get(i)).length() < 1e-12 * largest));
        assert!((bending.energy(&x) - bending.potential(&x)).abs() < 1e-12 * bending.energy(&x));
    }

    #[test]
    fn the_tangent_is_that_of_the_gradient_where_the_sheet_does_not_stretch() {
        // A roll about the v axis with radius 0.5 whose edges are not stretched; the rest curvature
        // is equal to it, or smaller.
        let clamped = [false; 35];
        let grid = StaggeredGrid { columns: 7, rows: 5, spacing: (0.1, 0.15), clamped: &clamped };
        let source = curvatures(&grid);
        let turn = 2.0 * (0.1_f64).asin();
        let made = |part: f64| {
            let known = |g: &CurvatureGroup| if g.rows[0].is_empty() { 0.0 } else { part * turn / 0.1 };
            let angles: Vec<[f64; 3]> = source.iter().map(|g| [known(g), 0.0, 0.0]).collect();
            let mut bending = Bending::with_rest(source.clone(), &[DVec3::X, DVec3::Z], &angles, None, false);
            bending.set_law(&law());
            bending
        };
        let mut x = Vectors::default();
        for j in 0..5 {
            let mut p = DVec3::new(0.0, 0.0, 0.15 * f64::from(j));
            for i in 0..7 {
                x.push(p);
                let angle = turn * f64::from(i);
                p += DVec3::new(angle.cos(), angle.sin(), 0.0) * 0.1;
            }
        }
        assert!(made(1.0).energy(&x) < 1e-20, "{}", made(1.0).energy(&x));
        derivative_check::derivatives(&mut made(0.7), &x, 1e-6);
    }

    #[test]
    fn forces_of_a_creased_sheet_have_no_resultant_and_no_moment() {
        let bending = creased(&[false; 35], 0.9);
        let x = derivative_check::bent_grid(7, 5, (0.1, 0.15));
        let mut force = Vectors::zeros(35);
        bending.add_forces(&x, &Vectors::zeros(35), &mut force);
        let largest = force.max_squared().sqrt();
        let total: DVec3 = force.iter().sum();
        let moment: DVec3 = force.iter().zip(x.iter()).map(|(f, p)| p.cross(f)).sum();
        assert!(total.length() < 1e-11 * largest && moment.length() < 1e-11 * largest, "{total} {moment}");
    }

    #[test]
    fn triangles_bend_to_the_upper_side_too() {
        use crate::mesh::outline::{Outline, OutlineSpec, mesh};
        let spec = OutlineSpec::Polygon(vec![(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)]);
        let outline = Outline::new(Some(&spec), &[], &[], (0.6, 0.6), std::path::Path::new("")).expect("valid");
        let mesh = mesh(&outline, (7, 7)).expect("valid");
        let (source, _) = triangle_curvatures(&mesh, &|_| false);
        let curvature = 0.02;
        let angles: Vec<[f64; 3]> = source.iter().map(|_| [curvature, curvature, 0.0]).collect();
        let mut bending = Bending::with_rest(source, &[], &angles, None, false);
        bending.set_law(&law());
        let dished = |sign: f64| {
            let mut x = Vectors::default();
            for [u, v] in &mesh.positions {
                x.push(DVec3::new(*u, 0.5 * sign * curvature * (u * u + v * v), *v));
            }
            bending.energy(&x)
        };
        assert!(
            dished(1.0) < 1e-3 * dished(0.0) && dished(-1.0) > 3.0 * dished(0.0),
            "{} {}",
            dished(1.0),
            dished(0.0)
        );
    }
}
