//! Creep and plasticity: the strain that remains without stress.
//!
//! Creep is Burgers' model: a spring E, a dashpot E τ₁ and a Kelvin-Voigt element (E/r, τ₂) in
//! series. Under constant stress the strain is J(t) times the stress, E J(t) = 1 + t/τ₁ + r
//! (1 - e^(-t/τ₂)). Two parallel Maxwell arms give an equal stress:
//!
//! σ = E (s₁ + s₂), s_i⁺ = e^(-h/τ_i) s_i + a_i γ_i Δε, γ_i = (1 - e^(-h/τ_i)) τ_i/h,
//!
//! where s = -1/τ_i are the roots of τ₁τ₂ s² + (τ₁ (1+r) + τ₂) s + 1 = 0, and a₁ + a₂ = 1 (W. N.
//! Findley, J. S. Lai, K. Onaran, *Creep and Relaxation of Nonlinear Viscoelastic Materials*, 1976,
//! chapter 5; the recursion: R. L. Taylor, K. S. Pister, G. L. Goudreau, Int. J. Numer. Meth. Eng.
//! 2, 1970). The recursion is exact for a constant strain and for a constant strain rate over a
//! step h of any length, and it creeps at the exact rate under constant stress.
//!
//! Within a step the law is elastic, σ = g E (ε - ε*), g = Σ a_i γ_i, ε* = ε₀ - Σ e^(-h/τ_i) s_i /
//! g, so integrators need no special treatment. Since e^(-2h/τ) ≤ γ ≤ 1, no step gains energy. The
//! times are multiplied by the shift a_T of Williams, Landel and Ferry (J. Am. Chem. Soc. 77,
//! 1955).
//!
//! Plasticity acts on bending. Where |M| exceeds M_y + H α, the plastic curvature grows once per
//! step by Δα = (|M| - M_y - H α)/(D + H) in the direction of the elastic curvature. |M|² = D κ_eᵀ
//! D κ_e is the moment of a cylindrical bend of equal energy, and M_y = σ_y t²/4 the moment of a
//! fully plastic section.

use crate::math::Vectors;
use crate::scene::Material;
use crate::serialize::state;

/// Largest absolute power of ten of the shift a_T. Far below the glass transition creep is
/// negligible.
const MAXIMUM_SHIFT_DECADES: f64 = 30.0;
/// Relative relaxation of stress in a step below which creep is skipped.
const CREEP_THRESHOLD: f64 = 1e-8;

/// Two parallel Maxwell arms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxwellArms {
    /// Share a_i of each arm in the stiffness; their sum is 1.
    pub share: [f64; 2],
    /// Relaxation time τ_i of each arm, s.
    pub time: [f64; 2],
}

/// Coefficients of two arms for one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmDecay {
    /// Factor of the stored strain, e^(-h/τ_i).
    pub retention: [f64; 2],
    /// Factor of the strain increment, a_i γ_i.
    pub gain: [f64; 2],
}

impl MaxwellArms {
    /// Arms of Burgers' model: relaxation time τ₁ (s), retardation time τ₂ (s), and the ratio r of
    /// retarded to instantaneous strain.
    pub fn burgers(relaxation: f64, retardation: f64, retarded: f64) -> Self {
        if retarded <= 0.0 {
            return Self { share: [1.0, 0.0], time: [relaxation; 2] };
        }
        let product = relaxation * retardation;
        let sum = relaxation * (1.0 + retarded) + retardation;
        let slow = 0.5 * (sum + (sum * sum - 4.0 * product).sqrt());
        let fast = product / slow;
        let share = (relaxation - fast) / (slow - fast);
        Self { share: [share, 1.0 - share], time: [slow, fast] }
    }

    /// Coefficients of a step of `dt` s with the times multiplied by `shift`.
    pub fn decay(&self, dt: f64, shift: f64) -> ArmDecay {
        let x = self.time.map(|t| dt / (t * shift));
        let lost = x.map(|x| -(-x).exp_m1());
        let gamma = [0, 1].map(|i| if x[i] > 1e-12 { lost[i] / x[i] } else { 1.0 });
        ArmDecay { retention: lost.map(|l| 1.0 - l), gain: [self.share[0] * gamma[0], self.share[1] * gamma[1]] }
    }
}

impl ArmDecay {
    /// Stiffness g of the step, relative to the instantaneous stiffness.
    pub fn stiffness(&self) -> f64 {
        self.gain[0] + self.gain[1]
    }

    /// Whether creep in the step is negligible.
    pub fn is_idle(&self) -> bool {
        self.retention[0] >= 1.0 - CREEP_THRESHOLD && self.retention[1] >= 1.0 - CREEP_THRESHOLD
    }

    /// Rest strain ε* of a step that begins at `strain` with the arms at `s`.
    #[inline]
    pub fn rest(&self, strain: f64, s: [f64; 2]) -> f64 {
        strain - (self.retention[0] * s[0] + self.retention[1] * s[1]) / self.stiffness()
    }

    /// The arms after a step with the strain increment `change`.
    #[inline]
    pub fn advance(&self, s: [f64; 2], change: f64) -> [f64; 2] {
        [0, 1].map(|i| self.retention[i] * s[i] + self.gain[i] * change)
    }
}

/// Dependence of the creep times on temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeShift {
    /// Glass transition Tg, °C; `None` for times independent of temperature.
    pub glass_transition: Option<f64>,
    /// WLF constants C1 and C2 (K).
    pub wlf: (f64, f64),
}

impl TimeShift {
    /// Shift a_T at `celsius`.
    pub fn at(&self, celsius: f64) -> f64 {
        let Some(glass) = self.glass_transition else { return 1.0 };
        let above = celsius - glass;
        let (c1, c2) = self.wlf;
        let decades = if above <= -c2 { MAXIMUM_SHIFT_DECADES } else { -c1 * above / (c2 + above) };
        10.0_f64.powf(decades.clamp(-MAXIMUM_SHIFT_DECADES, MAXIMUM_SHIFT_DECADES))
    }
}

/// Creep law of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Creep {
    /// Maxwell arms, at the glass transition where there is one.
    pub arms: MaxwellArms,
    /// Dependence of their times on temperature.
    pub shift: TimeShift,
}

/// Yield condition of bending.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldLaw {
    /// Yield moment M_y, N m/m.
    pub moment: f64,
    /// Hardening modulus of bending H, N m.
    pub hardening: f64,
}

impl YieldLaw {
    /// Plastic curvature increment Δα (1/m) of a cell of length `span` (m; 0 for a continuum)
    /// whose elastic angle per length times the bending stiffness `stiffness` (N m) is `moment`
    /// (N), at the accumulated plastic curvature `before` (1/m). A cell bent by the elastic angle
    /// ψ has the moment D sin(ψ)/l.
    pub fn plastic_increment(&self, moment: f64, stiffness: f64, before: f64, span: f64) -> f64 {
        let (limit, r) = (self.moment + self.hardening * before, span / stiffness);
        let limit = if r > 0.0 { (limit * r).min(1.0).asin() / r } else { limit };
        (moment - limit).max(0.0) / (stiffness + self.hardening)
    }
}

/// Inelastic law of a sheet: creep and plasticity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InelasticLaw {
    /// Creep; `None` if disabled.
    pub creep: Option<Creep>,
    /// Plasticity; `None` if disabled.
    pub plastic: Option<YieldLaw>,
}

impl InelasticLaw {
    /// Law of a sheet of `material`, with creep and plasticity as enabled.
    pub fn new(material: &Material, creeps: bool, is_plastic: bool) -> Self {
        let t = material.thickness;
        let shift = TimeShift { glass_transition: material.glass_transition, wlf: material.wlf };
        let arms =
            |b: &crate::scene::BurgersCreep| MaxwellArms::burgers(b.relaxation_time, b.retardation_time, b.retarded);
        let creep = material.burgers.as_ref().filter(|_| creeps).map(|b| Creep { arms: arms(b), shift });
        let hardening = material.hardening * t * t * t / 12.0;
        let plastic = material.yield_stress.filter(|_| is_plastic);
        Self { creep, plastic: plastic.map(|stress| YieldLaw { moment: 0.25 * stress * t * t, hardening }) }
    }

    /// Step of `dt` s at the uniform temperature `celsius`.
    pub fn step(&self, dt: f64, celsius: f64) -> InelasticStep<'_> {
        let decay = self.creep.map(|c| c.arms.decay(dt, c.shift.at(celsius)));
        InelasticStep { law: self, dt, decay, each: None }
    }
}

/// One time step of a sheet with creep or plasticity.
#[derive(Clone, Copy, Debug)]
pub struct InelasticStep<'a> {
    /// Law of the sheet.
    pub law: &'a InelasticLaw,
    /// Time step, s.
    dt: f64,
    /// Coefficients at uniform temperature.
    decay: Option<ArmDecay>,
    /// Temperature of each node, °C; `None` at uniform temperature.
    each: Option<&'a [f64]>,
}

impl<'a> InelasticStep<'a> {
    /// Sets the temperature of each node, °C.
    pub fn with_temperatures(self, each: &'a [f64]) -> Self {
        let Some(creep) = self.law.creep else { return self };
        let (low, high) = each.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(*t), h.max(*t)));
        let decay = Some(creep.arms.decay(self.dt, creep.shift.at(high)));
        // If creep is negligible at the highest temperature, it is negligible everywhere.
        let differ = high > low && !decay.is_none_or(|d| d.is_idle());
        Self { each: differ.then_some(each), decay, ..self }
    }

    /// Coefficients at the mean temperature of `masses`; `None` without creep.
    pub fn decay(&self, masses: &[u32]) -> Option<ArmDecay> {
        let (Some(each), Some(creep)) = (self.each, self.law.creep) else { return self.decay };
        let sum: f64 = masses.iter().filter_map(|m| each.get(*m as usize)).sum();
        Some(creep.arms.decay(self.dt, creep.shift.at(sum / masses.len().max(1) as f64)))
    }

    /// Whether creep is negligible in the step.
    pub fn is_idle(&self) -> bool {
        self.each.is_none() && self.decay.is_none_or(|d| d.is_idle())
    }
}

/// Creep state of one strain component and its elastic law within a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CreepStrain {
    /// Strains s_i of the arms.
    pub arms: [f64; 2],
    /// Strain at the start of the step.
    pub start: f64,
    /// Rest strain ε* of the step.
    pub rest: f64,
    /// Relative stiffness g of the step.
    pub stiffness: f64,
}

impl Default for CreepStrain {
    fn default() -> Self {
        Self { arms: [0.0; 2], start: 0.0, rest: 0.0, stiffness: 1.0 }
    }
}

state!(CreepStrain { arms, start, rest, stiffness });

impl CreepStrain {
    /// Begins a step at `strain`; without `decay` sets the instantaneous elastic law.
    #[inline]
    pub fn begin(&mut self, strain: f64, share: [f64; 2], decay: Option<&ArmDecay>) {
        self.advance_elastically(strain, share);
        let instantaneous = (self.stress_free(), 1.0);
        (self.rest, self.stiffness) = decay.map_or(instantaneous, |d| (d.rest(strain, self.arms), d.stiffness()));
    }

    /// Ends the step at `strain`.
    #[inline]
    pub fn end(&mut self, strain: f64, decay: &ArmDecay) {
        self.arms = decay.advance(self.arms, strain - self.start);
        self.start = strain;
    }

    /// The strain without stress.
    pub fn stress_free(&self) -> f64 {
        self.start - self.arms[0] - self.arms[1]
    }

    /// Strain without stress and arms, for transfer to another grid.
    pub fn stored_state(&self) -> [f64; 3] {
        [self.stress_free(), self.arms[0], self.arms[1]]
    }

    /// State at rest with this stored state.
    pub fn from_stored_state([left, first, second]: [f64; 3]) -> Self {
        Self { arms: [first, second], start: left + first + second, rest: left, stiffness: 1.0 }
    }

    /// Multiplies the arms at `strain` by `kept`: a stiffer element keeps its stress.
    pub fn scale_stress(&mut self, strain: f64, kept: f64, share: [f64; 2]) {
        self.advance_elastically(strain, share);
        self.arms = self.arms.map(|s| s * kept);
    }

    /// Moves the strain without stress by `change`.
    pub fn move_rest(&mut self, change: f64, share: [f64; 2]) {
        self.arms = [self.arms[0] - share[0] * change, self.arms[1] - share[1] * change];
    }

    fn advance_elastically(&mut self, strain: f64, share: [f64; 2]) {
        self.arms = self.arms_at(strain, share);
        self.start = strain;
    }

    /// Stored energy per stiffness at `strain`: ½ Σ s_i²/a_i.
    pub fn stored_energy(&self, strain: f64, share: [f64; 2]) -> f64 {
        let arms = self.arms_at(strain, share);
        (0..2).filter(|i| share[*i] > 0.0).map(|i| 0.5 * arms[i] * arms[i] / share[i]).sum()
    }

    /// The arms at `strain`, after an elastic change since the last step.
    #[inline]
    pub fn arms_at(&self, strain: f64, share: [f64; 2]) -> [f64; 2] {
        let change = strain - self.start;
        [self.arms[0] + share[0] * change, self.arms[1] + share[1] * change]
    }
}

/// Element with creep or plasticity; see [`crate::elements::Element`].
pub trait InelasticElement {
    /// Begins a step at positions `x` (m): sets the elastic law of `step`, or the instantaneous one
    /// for the search of an equilibrium. Returns whether the constant part of the tangent changed.
    fn begin_step(&mut self, x: &Vectors, step: Option<&InelasticStep>) -> bool;

    /// Ends the step at `x` (m): stores the creep and plastic strains.
    fn end_step(&mut self, x: &Vectors, step: &InelasticStep);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_relax_as_burgers_model_does() {
        // The compliance E J(t) = 1 + t/τ₁ + r (1 - e^(-t/τ₂)) and the relaxation modulus G of the
        // two arms satisfy ∫ G(t-s) J'(s) ds + G(t) J(0) = 1 at every time.
        let (t1, t2, r) = (3.0, 0.4, 1.7);
        let arms = MaxwellArms::burgers(t1, t2, r);
        assert!((arms.share[0] + arms.share[1] - 1.0).abs() < 1e-15);
        let modulus = |t: f64| arms.share[0] * (-t / arms.time[0]).exp() + arms.share[1] * (-t / arms.time[1]).exp();
        let rate = |t: f64| 1.0 / t1 + r / t2 * (-t / t2).exp();
        for t in [0.1, 0.7, 2.5, 9.0] {
            let n = 20_000;
            let h = t / f64::from(n);
            // Simpson's rule.
            let at = |k: i32| {
                let s = h * f64::from(k);
                let weight = if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
                weight * modulus(t - s) * rate(s)
            };
            let integral = h / 3.0 * (0..=n).map(at).sum::<f64>();
            assert!((modulus(t) + integral - 1.0).abs() < 1e-10, "{t}");
        }
    }

    #[test]
    fn a_step_is_exact_for_constant_strain_and_constant_rate() {
        let arms = MaxwellArms::burgers(2.0, 0.3, 0.8);
        for h in [1e-6, 0.05, 1.0, 40.0] {
            let decay = arms.decay(h, 1.0);
            // Constant strain: s_i = a_i e^(-t/τ_i).
            let after = decay.advance(arms.share, 0.0);
            // Strain rate 1 from zero: s_i = a_i τ_i (1 - e^(-t/τ_i)).
            let moving = decay.advance([0.0; 2], h);
            for i in 0..2 {
                let left = (-h / arms.time[i]).exp();
                assert!((after[i] - arms.share[i] * left).abs() < 1e-15);
                let wanted = -arms.share[i] * arms.time[i] * (-h / arms.time[i]).exp_m1();
                assert!((moving[i] - wanted).abs() < 1e-14 * h.max(wanted), "{h}");
            }
        }
    }

    #[test]
    fn a_dashpot_creeps_at_the_exact_rate_for_any_step() {
        // Constant stress 1: the strain grows by h/τ₁ per step.
        let arms = MaxwellArms::burgers(2.0, 1.0, 0.0);
        for h in [1e-3, 1.0, 100.0] {
            let decay = arms.decay(h, 1.0);
            let mut strain = CreepStrain { arms: [1.0, 0.0], ..CreepStrain::default() };
            for _ in 0..5 {
                let before = strain.start;
                strain.begin(before, arms.share, Some(&decay));
                let next = strain.rest + 1.0 / strain.stiffness;
                strain.end(next, &decay);
                assert!(((next - before) / (h / 2.0) - 1.0).abs() < 1e-9, "{h}: {}", next - before);
                assert!((strain.arms[0] - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn burgers_creep_converges_with_second_order() {
        let (t1, t2, r) = (5.0, 0.5, 2.0);
        let arms = MaxwellArms::burgers(t1, t2, r);
        let error = |h: f64| {
            let decay = arms.decay(h, 1.0);
            // Sudden stress of 1.
            let mut strain = CreepStrain { arms: arms.share, ..CreepStrain::default() };
            strain.start = 1.0;
            for _ in 0..(1.0 / h).round() as u32 {
                strain.begin(strain.start, arms.share, Some(&decay));
                strain.end(strain.rest + 1.0 / strain.stiffness, &decay);
            }
            strain.start / (1.0 + 1.0 / t1 + r * (1.0 - (-1.0_f64 / t2).exp())) - 1.0
        };
        let (coarse, fine) = (error(0.1), error(0.05));
        assert!(coarse.abs() < 5e-3 && (coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
    }

    #[test]
    fn no_step_gains_energy() {
        // The condition is e^(-2x) ≤ γ ≤ 1.
        let arms = MaxwellArms::burgers(1.0, 1.0, 1.0);
        for k in -60..=60 {
            let decay = arms.decay(1.0, 10.0_f64.powf(0.1 * f64::from(k)));
            for i in 0..2 {
                let gamma = decay.gain[i] / arms.share[i];
                assert!(decay.retention[i] * decay.retention[i] <= gamma * (1.0 + 1e-15) && gamma <= 1.0);
            }
        }
    }

    #[test]
    fn times_shift_by_the_equation_of_williams_landel_and_ferry() {
        let shift = TimeShift { glass_transition: Some(100.0), wlf: (17.44, 51.6) };
        assert_eq!(shift.at(100.0), 1.0);
        // -17.44 · 40/91.6 = -7.6157 decades.
        assert!((shift.at(140.0).log10() + 7.615_720).abs() < 1e-5);
        assert_eq!(shift.at(20.0), 1e30);
        assert_eq!(TimeShift { glass_transition: None, wlf: (17.44, 51.6) }.at(500.0), 1.0);
    }
}
