//! Creep and plasticity of a sheet: update of the material law at the start and the end of a step.
//!
//! Integrators use a constant law (see [`crate::elements::creep`]). [`begin_inelastic_step`]
//! sets the law of a step, and [`end_inelastic_step`] stores the inelastic strain. An
//! elastic sheet has none of this state.

use crate::elements::creep::{CreepStrain, InelasticLaw, InelasticStep};
use crate::elements::spring::Springs;
use crate::error::InputError;
use crate::math::Vectors;
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::sheet::Sheet;
use crate::units::parameters::ParameterId as Id;

/// State of creep and plasticity of a sheet, beyond that of its elements.
#[derive(Clone)]
pub(crate) struct InelasticState {
    pub law: InelasticLaw,
    /// Temperature of a sheet without a thermal network, °C.
    temperature: f64,
    /// Ratio of thermal time to mechanical time, for creep and for heat.
    time_lapse: f64,
    springs: LatticeCreep,
    /// Whether anything crept in the last step.
    creeps: bool,
    /// Whether elements have the law of a step; otherwise they have the instantaneous law.
    in_step: bool,
    /// Length of the current step in thermal time, s.
    dt: f64,
}

/// Springs of a creeping lattice, with strains as stretch (m).
#[derive(Clone, Default)]
struct LatticeCreep {
    strains: Vec<CreepStrain>,
    /// Instantaneous stiffness (N/m), and length without inelastic strain (m).
    instantaneous: Vec<(f64, f64)>,
    share: [f64; 2],
    running: bool,
}

impl InelasticState {
    /// Create the state of a sheet with `springs`, at `celsius` (°C) without a thermal network,
    /// with thermal time `lapse` times faster than mechanical time.
    pub fn new(law: InelasticLaw, celsius: f64, lapse: f64, springs: &Springs) -> Self {
        let made = |i: usize| (springs.stiffness[i], springs.rest[i]);
        let creeping = |share: [f64; 2]| LatticeCreep {
            strains: vec![CreepStrain::default(); springs.len()],
            instantaneous: (0..springs.len()).map(made).collect(),
            share,
            running: false,
        };
        let springs = law.creep.map(|c| creeping(c.arms.share)).unwrap_or_default();
        Self { law, temperature: celsius, time_lapse: lapse, springs, creeps: false, in_step: false, dt: 0.0 }
    }

    /// Elastic energy of the creeping springs at `x` (J); `None` while the springs hold the law of
    /// a step.
    pub fn spring_energy(&self, springs: &Springs, x: &Vectors) -> Option<f64> {
        let own = &self.springs;
        let energy =
            |i: usize| own.instantaneous[i].0 * own.strains[i].stored_energy(own.stretch(springs, i, x), own.share);
        (!own.running && !own.strains.is_empty()).then(|| (0..own.strains.len()).map(energy).sum())
    }

    /// Serialise the state.
    pub fn serialise(&self, to: &mut StateWriter) {
        [self.creeps, self.in_step, self.springs.running].serialise(to);
        to.number(self.dt);
        for (strain, made) in self.springs.strains.iter().zip(&self.springs.instantaneous) {
            strain.serialise(to);
            made.serialise(to);
        }
    }

    /// Deserialise the state.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        [self.creeps, self.in_step, self.springs.running] = from.read()?;
        self.dt = from.number()?;
        for (strain, made) in self.springs.strains.iter_mut().zip(&mut self.springs.instantaneous) {
            strain.deserialise(from)?;
            made.deserialise(from)?;
        }
        Ok(())
    }

    /// Strain without load of spring `i` and the strains of its arms, per initial length; `None`
    /// where the spring does not creep.
    pub fn spring_held(&self, i: usize) -> Option<[f64; 3]> {
        let (strain, made) = (self.springs.strains.get(i)?, self.springs.instantaneous.get(i)?);
        Some(strain.stored_state().map(|s| s / made.1))
    }

    /// Set the strains of spring `i`, as [`InelasticState::spring_held`] returns them.
    pub fn put_spring(&mut self, i: usize, held: [f64; 3], springs: &mut Springs) {
        let own = &mut self.springs;
        let [left, first, second] = held.map(|h| h * own.instantaneous[i].1);
        let strain = &mut own.strains[i];
        strain.arms = [first, second];
        (strain.start, strain.rest, strain.stiffness) = (left + first + second, left, 1.0);
        own.apply(i, springs);
    }

    /// Temperature of a sheet without a thermal network, °C.
    pub fn celsius(&self) -> f64 {
        self.temperature
    }

    /// Set the temperature of a sheet without a thermal network, °C.
    pub fn set_celsius(&mut self, celsius: f64) {
        self.temperature = celsius;
    }
}

impl LatticeCreep {
    fn stretch(&self, springs: &Springs, i: usize, x: &Vectors) -> f64 {
        x.get(springs.b[i] as usize).distance(x.get(springs.a[i] as usize)) - self.instantaneous[i].1
    }

    fn apply(&self, i: usize, springs: &mut Springs) {
        let (stiffness, length) = self.instantaneous[i];
        let strain = &self.strains[i];
        springs.set_stiffness(i, stiffness * strain.stiffness);
        springs.set_rest(i, length + strain.rest);
    }

    fn begin(&mut self, springs: &mut Springs, x: &Vectors, step: Option<&InelasticStep>) {
        self.running = step.is_some();
        for i in 0..self.strains.len() {
            let decay = step.and_then(|step| step.decay(&[springs.a[i], springs.b[i]]));
            let stretch = self.stretch(springs, i, x);
            self.strains[i].begin(stretch, self.share, decay.as_ref());
            self.apply(i, springs);
        }
    }

    fn end(&mut self, springs: &Springs, x: &Vectors, step: &InelasticStep) {
        self.running = false;
        for i in 0..self.strains.len() {
            if let Some(decay) = step.decay(&[springs.a[i], springs.b[i]]) {
                let stretch = self.stretch(springs, i, x);
                self.strains[i].end(stretch, &decay);
            }
        }
    }
}

impl Sheet {
    /// Rest curvatures (uu, vv, 2uv; 1/m, positive towards the upper side) of a sheet with creases,
    /// curl, creep or plasticity, one per curvature group, in unspecified order.
    pub fn rest_angles(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.elements.iter().filter_map(|e| e.rest_angles()).flatten()
    }

    /// Temperature of a creeping or plastic sheet, °C: the mean of the thermal network where there
    /// is one. `None` for an elastic sheet.
    pub fn temperature(&self) -> Option<f64> {
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
        self.state.inelastic.as_ref().map(|f| self.temperatures().map_or(f.temperature, mean))
    }

    /// Change the temperature of a creeping or plastic sheet, °C, -273.15 to 5000.
    ///
    /// # Errors
    /// When out of range, or the sheet neither creeps nor yields; nothing is changed then.
    pub fn set_temperature(&mut self, celsius: f64) -> Result<(), InputError> {
        Id::Temperature.check("temperature", celsius)?;
        let Some(flow) = &mut self.state.inelastic else {
            return Err(InputError::new("temperature", "does nothing to a sheet without creep"));
        };
        flow.temperature = celsius;
        if self.state.heat.is_some() {
            self.set_temperatures(|_| celsius)?;
        }
        self.wake();
        Ok(())
    }
}

/// Whether the sheet creeps at its temperature, so that it moves on, however slowly.
pub(crate) fn is_creeping(sheet: &Sheet) -> bool {
    sheet.state.inelastic.as_ref().is_some_and(|f| f.creeps)
}

/// Begin a step of `dt` (s): set the law of the step.
pub(crate) fn begin_inelastic_step(sheet: &mut Sheet, dt: f64) {
    let Some(mut flow) = sheet.state.inelastic.take() else { return };
    flow.dt = dt * flow.time_lapse;
    let (law, heat) = (flow.law, sheet.state.heat.take());
    let step = law.step(flow.dt, flow.temperature);
    let step = heat.as_ref().map_or(step, |h| step.with_temperatures(h.celsius()));
    flow.creeps = !step.is_idle();
    if flow.creeps {
        set_law(sheet, &mut flow, Some(&step));
    } else if flow.in_step {
        set_law(sheet, &mut flow, None);
    }
    sheet.state.heat = heat;
    sheet.state.inelastic = Some(flow);
}

/// End the step: store the inelastic strain at the present positions.
pub(crate) fn end_inelastic_step(sheet: &mut Sheet) {
    let Some(mut flow) = sheet.state.inelastic.take() else { return };
    if !flow.creeps && flow.law.plastic.is_none() {
        sheet.state.inelastic = Some(flow);
        return;
    }
    let (law, heat) = (flow.law, sheet.state.heat.take());
    let step = law.step(flow.dt, flow.temperature);
    let step = heat.as_ref().map_or(step, |h| step.with_temperatures(h.celsius()));
    for element in sheet.elements.iter_mut().filter_map(|e| e.as_inelastic()) {
        element.end_step(&sheet.state.x, &step);
    }
    flow.springs.end(&sheet.springs, &sheet.state.x, &step);
    sheet.state.heat = heat;
    sheet.state.inelastic = Some(flow);
}

/// Set the instantaneous law, as for an equilibrium.
pub(crate) fn use_instantaneous_law(sheet: &mut Sheet) {
    if let Some(mut flow) = sheet.state.inelastic.take() {
        set_law(sheet, &mut flow, None);
        sheet.state.inelastic = Some(flow);
    }
}

/// Apply thermal expansion and softening to creeping spring `i` of present `length` (m): its
/// length without load grows by `grown` (m), and the softening factor changes from `softness.0`
/// to `softness.1`. Return false, without a change, for a spring that does not creep.
pub(crate) fn heat_creeping_spring(sheet: &mut Sheet, i: usize, length: f64, grown: f64, softness: (f64, f64)) -> bool {
    let Some(springs) = sheet.state.inelastic.as_mut().map(|f| &mut f.springs) else { return false };
    let (Some(strain), Some(made)) = (springs.strains.get_mut(i), springs.instantaneous.get_mut(i)) else {
        return false;
    };
    made.1 += grown;
    strain.scale_stress(length - made.1, (softness.0 / softness.1).min(1.0), springs.share);
    strain.rest = strain.stress_free();
    true
}

/// Set the law of `step`, or the instantaneous one.
fn set_law(sheet: &mut Sheet, flow: &mut InelasticState, step: Option<&InelasticStep>) {
    if flow.law.creep.is_none() {
        return;
    }
    let mut changed = !sheet.springs.is_empty();
    for element in sheet.elements.iter_mut().filter_map(|e| e.as_inelastic()) {
        changed |= element.begin_step(&sheet.state.x, step);
    }
    flow.springs.begin(&mut sheet.springs, &sheet.state.x, step);
    flow.in_step = step.is_some();
    if let Some(system) = sheet.system.as_mut().filter(|_| changed) {
        system.refresh(&sheet.springs);
    }
}

/// Take over changed spring stiffnesses and material constants.
pub(crate) fn update_inelastic_law(sheet: &mut Sheet) {
    let Some(mut flow) = sheet.state.inelastic.take() else { return };
    let creep = flow.law.creep.is_some();
    flow.law = InelasticLaw::new(&sheet.parameters.material, creep, flow.law.plastic.is_some());
    for i in 0..flow.springs.strains.len() {
        flow.springs.instantaneous[i].0 = sheet.springs.stiffness[i];
        flow.springs.apply(i, &mut sheet.springs);
    }
    sheet.state.inelastic = Some(flow);
}
