//! Temperatures of a sheet, and their effect on its stiffness.
//!
//! Each node has one temperature (°C); a shell of one layer may have two, of the lower and the
//! upper half of its thickness, which give the gradient. A sheet without heat stores none:
//! [`Sheet::heat`] is then `None`, and the sheet has the temperature of the surroundings and the
//! stiffness of its material.
//!
//! Stiffness is updated when the temperature of a node has changed by `TEMPERATURE_THRESHOLD` since
//! the last update, or its E by the fraction `STIFFNESS_THRESHOLD`. E, expansion and curl are then
//! updated for every node; elements keep their strain where they soften and their stress where they
//! stiffen ([`crate::elements::Element::apply_temperature`]).

use crate::elements::{ThermalFields, rest_strain_after_softening};
use crate::error::InputError;
use crate::scene::Material;
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};
use crate::sheet::temperature::conduction::{ConductionStepper, Exchange};
use crate::sheet::temperature::patches::SheetPatches;
use crate::sheet::temperature::softening::Softening;
use crate::sheet::{Sheet, creep};
use crate::units::parameters::ParameterId as Id;

/// Change of temperature that triggers an update of stiffness and size, K: polystyrene expands by
/// 7e-6 with it.
const TEMPERATURE_THRESHOLD: f64 = 0.1;
/// Relative change of E that triggers an update: 0.02 K in the middle of a glass transition.
const STIFFNESS_THRESHOLD: f64 = 8e-3;
/// Relative change of a given stiffness that triggers an update.
const GIVEN_STIFFNESS_THRESHOLD: f64 = 2e-3;

/// Temperatures of a sheet by node.
pub struct SheetTemperature {
    /// Temperature of every node, then of the upper halves where there are two points, °C.
    nodes: Vec<f64>,
    /// Mean through the thickness, °C; empty with one point per node.
    mean: Vec<f64>,
    /// Temperatures of the last stiffness update, °C, ordered as `nodes`, and the change of each
    /// node that triggers the next, K.
    applied: Vec<f64>,
    room: Vec<f64>,
    compliance: Vec<f64>,
    expansion: Vec<f64>,
    /// Curvature from the difference of the halves, 1/m; empty with one point per node.
    curl: Vec<f64>,
    springs: Vec<SpringThermalState>,
    curve: Softening,
    coefficient: f64,
    /// Thickness, m.
    thickness: f64,
    /// Whether compliances are given instead of computed from temperatures.
    given: bool,
    body: Option<Box<ThermalBody>>,
}

/// Thermal network with its stepper, built before the first step.
pub(crate) struct ThermalBody {
    pub stepper: ConductionStepper,
    pub faces: SheetPatches,
    pub exchange: Exchange,
}

/// Thermal state of a spring.
#[derive(Clone, Copy, Debug)]
struct SpringThermalState {
    softness: f64,
    /// Rest length of the cold spring, m.
    cold: f64,
    expansion: f64,
}

state!(SpringThermalState { softness, cold, expansion });

impl SheetTemperature {
    /// State of a sheet at `celsius` (°C), with one or two `points` through the thickness.
    fn new(sheet: &Sheet, celsius: f64, points: usize) -> Self {
        let n = sheet.node_count();
        let springs = sheet.springs();
        let cold = |i: usize| SpringThermalState { softness: 1.0, cold: springs.rest[i], expansion: 0.0 };
        Self {
            nodes: vec![celsius; n * points],
            mean: if points > 1 { vec![celsius; n] } else { Vec::new() },
            applied: vec![f64::NAN; n * points],
            room: vec![0.0; n],
            compliance: vec![1.0; n],
            expansion: vec![0.0; n],
            curl: if points > 1 { vec![0.0; n] } else { Vec::new() },
            springs: (0..springs.len()).map(cold).collect(),
            curve: Softening::of(sheet.material()),
            coefficient: sheet.material().expansion,
            thickness: sheet.material().thickness,
            given: false,
            body: None,
        }
    }

    /// Serialise the state: temperatures, those of the last stiffness update, and the slopes of the
    /// factorised matrix.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        to.numbers(&self.nodes);
        for list in [&self.applied, &self.room, &self.compliance, &self.expansion, &self.curl] {
            to.numbers(list);
        }
        self.springs.serialise(to);
        to.flag(self.given);
        to.option(self.body.as_ref(), |body, to| body.stepper.serialise(to));
    }

    /// Deserialise the state of `sheet`.
    pub(crate) fn deserialise(&mut self, from: &mut StateReader, sheet: &Sheet) -> ReadResult {
        from.numbers(&mut self.nodes)?;
        self.average();
        let lists = [&mut self.applied, &mut self.room, &mut self.compliance, &mut self.expansion, &mut self.curl];
        lists.into_iter().try_for_each(|list| from.numbers(list))?;
        self.springs.deserialise(from)?;
        self.given = from.flag()?;
        if !from.flag()? {
            self.body = None;
            return Ok(());
        }
        self.body(sheet).stepper.deserialise(from)
    }

    /// Number of temperatures through the thickness of each node.
    pub(crate) fn points(&self) -> usize {
        if self.mean.is_empty() { 1 } else { 2 }
    }

    /// Thermal network and stepper of `sheet`, built on first use.
    pub(crate) fn body(&mut self, sheet: &Sheet) -> &mut ThermalBody {
        let points = self.points();
        self.body.get_or_insert_with(|| {
            let stepper = ConductionStepper::new(sheet, points);
            let faces = SheetPatches::new(sheet, stepper.network(), points);
            Box::new(ThermalBody { stepper, faces, exchange: Exchange::default() })
        })
    }

    /// Discard the thermal network after a change; the next step builds it again. Temperatures are
    /// kept.
    pub(crate) fn discard_network(&mut self) {
        self.body = None;
    }

    /// Advance temperatures by `span` (s) of the present exchange.
    pub(crate) fn advance(&mut self, span: f64) {
        if let Some(body) = &mut self.body {
            body.stepper.advance(&mut self.nodes, &body.exchange, span);
        }
        self.average();
    }

    /// Set the stiffness of node `i` to `fraction(i)` of its law, in a room at `celsius` (°C),
    /// independently of temperature.
    pub(crate) fn set_fractions(&mut self, celsius: f64, fraction: impl Fn(usize) -> f64) {
        self.nodes.fill(celsius);
        self.average();
        for (i, compliance) in self.compliance.iter_mut().enumerate() {
            let new = 1.0 / fraction(i);
            if (new - *compliance).abs() > GIVEN_STIFFNESS_THRESHOLD * *compliance {
                self.applied[i] = f64::NAN;
                *compliance = new;
            }
        }
        self.given = true;
    }

    fn average(&mut self) {
        let (lower, upper) = self.nodes.split_at(self.mean.len());
        for (mean, (a, b)) in self.mean.iter_mut().zip(lower.iter().zip(upper)) {
            *mean = 0.5 * (a + b);
        }
    }

    /// Temperature of every node, °C; the mean through the thickness where a node has two.
    pub fn celsius(&self) -> &[f64] {
        if self.mean.is_empty() { &self.nodes } else { &self.mean }
    }

    /// Temperatures of the lower and of the upper half of the thickness, °C; `None` without a
    /// gradient.
    pub fn halves(&self) -> Option<(&[f64], &[f64])> {
        (!self.mean.is_empty()).then(|| self.nodes.split_at(self.mean.len()))
    }

    /// Lowest and highest temperature, °C, of either half of the thickness.
    pub fn range(&self) -> (f64, f64) {
        self.nodes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(*t), high.max(*t)))
    }

    /// E of the material over E at the temperature of node `i`, at the last stiffness update.
    /// Panics when there is no node `i`.
    pub fn compliance(&self, i: usize) -> f64 {
        self.compliance[i]
    }

    /// Set the temperatures, °C.
    pub(crate) fn set_nodes(&mut self, celsius: impl Iterator<Item = f64>) {
        self.nodes.iter_mut().zip(celsius).for_each(|(node, t)| *node = t);
        self.average();
    }

    /// Change the temperature of node `i` from `now` to `new(i, now)`, °C, through the whole
    /// thickness.
    pub(crate) fn blend(&mut self, new: impl Fn(usize, f64) -> f64) {
        let masses = self.compliance.len();
        for (k, node) in self.nodes.iter_mut().enumerate() {
            *node = new(k % masses, *node);
        }
        self.average();
    }

    /// Remaining stiffness of spring `i`.
    pub(crate) fn spring_softness(&self, i: usize) -> f64 {
        self.springs[i].softness
    }

    /// Rest length of spring `i` with thermal expansion, m, without permanent strain.
    pub(crate) fn grown_length(&self, i: usize) -> f64 {
        self.springs[i].cold * (1.0 + self.springs[i].expansion)
    }

    /// Set the material, whose curve applies from the next update on.
    pub(crate) fn set_material(&mut self, material: &Material) {
        self.curve = Softening::of(material);
        self.coefficient = material.expansion;
        self.thickness = material.thickness;
        self.applied.fill(f64::NAN);
        // Capacity and conductivity change too.
        self.body = None;
    }

    /// Whether all temperatures equal `celsius`, to the bit.
    pub(crate) fn is_all_at(&self, celsius: f64) -> bool {
        self.nodes.iter().all(|t| *t == celsius)
    }

    /// Whether stiffness and size are those at 20 °C, as built.
    fn is_as_built(&self) -> bool {
        !self.given
            && self.compliance.iter().all(|c| *c == 1.0)
            && self.expansion.iter().chain(&self.curl).all(|growth| *growth == 0.0)
    }

    /// Whether the temperature of a node requires an update of the stiffness.
    fn needs_update(&self) -> bool {
        let mut all = self.nodes.iter().zip(&self.applied).zip(self.room.iter().cycle());
        // NaN marks a node before its first update.
        all.any(|((now, then), room)| then.is_nan() || (now - then).abs() > *room)
    }

    /// Compute compliance and expansion of every node.
    fn apply(&mut self) {
        self.applied.copy_from_slice(&self.nodes);
        if self.given {
            return;
        }
        for i in 0..self.compliance.len() {
            let celsius = self.celsius()[i];
            let fraction = self.curve.fraction(celsius);
            self.compliance[i] = 1.0 / fraction;
            // A table has corners: the steeper side counts.
            let change = |by: f64| (self.curve.fraction(celsius + by) / fraction).ln().abs();
            self.room[i] = TEMPERATURE_THRESHOLD
                * (STIFFNESS_THRESHOLD
                    / change(TEMPERATURE_THRESHOLD).max(change(-TEMPERATURE_THRESHOLD)).max(STIFFNESS_THRESHOLD));
            self.expansion[i] = self.coefficient * (celsius - crate::units::temperature::REFERENCE);
        }
        let (lower, upper) = self.nodes.split_at(self.mean.len());
        for (curl, (lower, upper)) in self.curl.iter_mut().zip(lower.iter().zip(upper)) {
            // The middles of the halves are half a thickness apart; a warm upper side bends the
            // ends down.
            *curl = -2.0 * self.coefficient * (upper - lower) / self.thickness;
        }
    }

    fn warmth(&self) -> ThermalFields<'_> {
        ThermalFields { compliance: &self.compliance, expansion: &self.expansion, curl: &self.curl }
    }
}

impl Sheet {
    /// Thermal state; `None` for a sheet without heat.
    pub fn heat(&self) -> Option<&SheetTemperature> {
        self.state.heat.as_deref()
    }

    /// Temperature of every node, °C, the mean through the thickness; `None` for a sheet without
    /// heat, which has the temperature of the surroundings.
    pub fn temperatures(&self) -> Option<&[f64]> {
        self.heat().map(SheetTemperature::celsius)
    }

    /// Temperature of every node, °C, on the upper or on the lower side; that of the whole
    /// thickness without a gradient, and `None` as with [`Sheet::temperatures`].
    pub fn side_temperatures(&self, upper: bool) -> Option<&[f64]> {
        let heat = self.heat()?;
        Some(match heat.halves() {
            Some((_, above)) if upper => above,
            Some((below, _)) => below,
            None => heat.celsius(),
        })
    }

    /// Set the temperature of node `i` to `celsius(i)`, °C, -273.15 to 5000, through the whole
    /// thickness, and update the stiffness. A sheet without heat starts its thermal state.
    ///
    /// # Errors
    /// When a temperature is out of range; nothing changes then.
    pub fn set_temperatures(&mut self, celsius: impl Fn(usize) -> f64) -> Result<(), InputError> {
        let n = self.node_count();
        (0..n).try_for_each(|i| Id::Temperature.check("temperature", celsius(i)))?;
        start_temperatures(self, crate::units::temperature::REFERENCE);
        if let Some(heat) = &mut self.state.heat {
            let count = heat.nodes.len();
            heat.set_nodes((0..count).map(|k| celsius(k % n)));
        }
        update_thermal_stiffness(self);
        Ok(())
    }
}

/// Patches of the sheet; `None` before the first thermal step.
pub(crate) fn faces(sheet: &Sheet) -> Option<&SheetPatches> {
    sheet.state.heat.as_ref()?.body.as_ref().map(|b| &b.faces)
}

/// Set the temperatures of the lower and of the upper half of the thickness, °C, by node;
/// without a gradient those of the lower. Updates the stiffness.
pub(crate) fn set_side_temperatures(sheet: &mut Sheet, [lower, upper]: &[Vec<f64>; 2]) {
    if let Some(heat) = &mut sheet.state.heat {
        heat.set_nodes(lower.iter().chain(upper).copied());
    }
    update_thermal_stiffness(sheet);
}

/// Start the thermal state at `celsius` (°C), or at the initial temperature of its
/// specification. Without effect when it exists.
#[doc(hidden)]
pub fn start_temperatures(sheet: &mut Sheet, celsius: f64) {
    if sheet.state.heat.is_none() {
        let points = if sheet.model.described_temperature.has_gradient { 2 } else { 1 };
        sheet.state.heat = Some(Box::new(SheetTemperature::new(
            sheet,
            sheet.model.described_temperature.initial.unwrap_or(celsius),
            points,
        )));
        update_thermal_stiffness(sheet);
    }
}

/// Update stiffness and size where the temperatures have changed enough.
pub(crate) fn update_thermal_stiffness(sheet: &mut Sheet) {
    let Some(mut heat) = sheet.state.heat.take_if(|h| h.needs_update()) else { return };
    let was_as_built = heat.is_as_built();
    heat.apply();
    if was_as_built && heat.is_as_built() {
        sheet.state.heat = Some(heat);
        return;
    }
    warm_springs(sheet, &mut heat);
    let warmth = heat.warmth();
    sheet.elements.iter_mut().for_each(|e| e.apply_temperature(&sheet.state.x, &warmth));
    sheet.state.heat = Some(heat);
    sheet.refresh_springs();
}

/// Update rest lengths and softness of springs, as for elements.
fn warm_springs(sheet: &mut Sheet, heat: &mut SheetTemperature) {
    let warmth = ThermalFields { compliance: &heat.compliance, expansion: &heat.expansion, curl: &[] };
    for (i, spring) in heat.springs.iter_mut().enumerate() {
        let ends = [sheet.springs.a[i], sheet.springs.b[i]];
        let (softness, expansion) = (warmth.stiffness(&ends), warmth.mean_expansion(&ends));
        let length = sheet.state.x.get(ends[0] as usize).distance(sheet.state.x.get(ends[1] as usize));
        let grown = spring.cold * (expansion - spring.expansion);
        if !creep::heat_creeping_spring(sheet, i, length, grown, (spring.softness, softness)) {
            let rest = rest_strain_after_softening(length, sheet.springs.rest[i] + grown, spring.softness, softness);
            sheet.springs.set_rest(i, rest);
        }
        (spring.softness, spring.expansion) = (softness, expansion);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::OutlineSpec;
    use crate::mesh::structure::StructureKind;
    use crate::scene::{PinSpec, Region, Scene, SheetSpec, SpringLaw};
    use glam::DVec3;

    /// Sheet of polystyrene of this structure, bent and stretched.
    fn bent(structure: StructureKind, outline: Option<OutlineSpec>, pins: &[PinSpec]) -> Sheet {
        let spec = SheetSpec {
            structure,
            grid: (7, if structure == StructureKind::Shell { 1 } else { 2 }, 6),
            size: (0.25, 0.2),
            material: "hips".into(),
            springs: SpringLaw::Calibrated,
            pins: pins.to_vec(),
            outline,
            ..SheetSpec::default()
        };
        let scene = Scene { sheets: vec![spec], ..Scene::thesis() };
        let mut sheet = Sheet::build(&scene, 0).expect("valid");
        for i in 0..sheet.node_count() {
            let p = sheet.state.x.get(i);
            let lift = DVec3::new(0.001 * p.z, 0.03 * (6.0 * p.x + 2.0 * p.z).sin(), 0.0);
            sheet.state.x.set(i, p * 1.002 + lift);
        }
        sheet
    }

    fn all(pins: &[PinSpec]) -> Vec<Sheet> {
        let disc = Some(OutlineSpec::Disc { radius: 0.1 });
        let mut all = vec![bent(StructureKind::Shell, None, pins), bent(StructureKind::Shell, disc, pins)];
        all.extend([StructureKind::Trimm, StructureKind::DoubleDiagonal].map(|s| bent(s, None, pins)));
        all
    }

    fn clamped() -> Vec<Sheet> {
        all(&[PinSpec::clamped(Region::Left)])
    }

    #[test]
    fn no_change_of_stiffness_adds_energy() {
        for mut sheet in clamped() {
            let mut material = sheet.material().clone();
            material.expansion = 0.0;
            sheet.set_material(material).expect("valid");
            let mut energy = sheet.energy(DVec3::ZERO).elastic;
            let first = energy;
            for step in 0..40_u32 {
                let swing = |i: usize| 80.0 + 70.0 * ((step * (3 + step % 5)) as f64 + 0.3 * i as f64).sin();
                sheet.set_temperatures(swing).expect("valid");
                let now = sheet.energy(DVec3::ZERO).elastic;
                assert!(now <= energy * (1.0 + 1e-12), "{}: {energy} to {now} at {step}", sheet.model.structure);
                energy = now;
            }
            assert!(energy < 1e-3 * first);
        }
    }

    #[test]
    fn a_softened_sheet_keeps_its_shape_when_it_stiffens() {
        for mut sheet in clamped() {
            let mut material = sheet.material().clone();
            material.expansion = 0.0;
            sheet.set_material(material).expect("valid");
            let cold = sheet.energy(DVec3::ZERO).elastic;
            sheet.set_temperatures(|_| 140.0).expect("valid");
            let hot = sheet.energy(DVec3::ZERO).elastic;
            assert!(hot < 2e-3 * cold, "{}: {hot} of {cold}", sheet.model.structure);
            sheet.set_temperatures(|_| 20.0).expect("valid");
            let set = sheet.energy(DVec3::ZERO).elastic;
            assert!((set / hot / (hot / cold) - 1.0).abs() < 1e-9, "{}: {set}", sheet.model.structure);
        }
    }

    #[test]
    fn a_sheet_grown_by_its_expansion_is_at_rest() {
        for mut sheet in all(&[]) {
            let scale = 1.0 + sheet.material().expansion * 30.0;
            let before = sheet.energy(DVec3::ZERO).elastic;
            sheet.set_temperatures(|_| 50.0).expect("valid");
            for i in 0..sheet.node_count() {
                sheet.state.x.set(i, sheet.state.x.get(i) * scale);
            }
            let after = sheet.energy(DVec3::ZERO).elastic;
            let softer = Softening::of(sheet.material()).fraction(50.0);
            // The shape is the same, 0.2 % larger: the energy differs by that and by the stiffness.
            assert!((after / (before * softer) - 1.0).abs() < 0.02, "{}: {after} of {before}", sheet.model.structure);
        }
    }
}
