//! Serialisation of a sheet for snapshots: parameters that can change during a run, and state that
//! a step takes from earlier steps.
//!
//! Topology, node masses and rest shape follow from the scene and are not serialised, nor is the
//! workspace of a step. Elements serialise their rates and stresses while an implicit integrator
//! runs, and their law where temperature, creep, plasticity or fracture have changed it.

use crate::elements::Element;
use crate::elements::grab_spring::GrabSpring;
use crate::scene::{Material, WhenUnstable, validate};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::bonds::AdhesionState;
use crate::sheet::inter_layer;
use crate::sheet::{
    Field, ImplicitSystem, RecoveryState, Sheet, SheetState, attachment, fracture, grab, instability, node_contact,
    temperature,
};

/// Serialise the layout that a snapshot must match.
pub(crate) fn serialise_layout(sheet: &Sheet, to: &mut StateWriter) {
    to.text(&sheet.name);
    let own = sheet.elements.len() - sheet.grabs.len();
    for count in [sheet.node_count(), sheet.springs.len(), own, sheet.model.layers.len()] {
        to.count(count as u64);
    }
    // A cut of a running sheet is state.
    let cells = sheet.open_cells().filter(|_| fracture::is_described(sheet));
    to.count(cells.map_or(0, <[bool]>::len) as u64);
    to.flag(sheet.state.inelastic.is_some());
}

/// Whether steps have changed the law of its elements or its open cells.
pub(crate) fn is_changed(sheet: &Sheet) -> bool {
    sheet.state.heat.is_some() || sheet.state.inelastic.is_some() || sheet.open_count() > 0
}

/// Serialise the parameters that can change during a run.
pub(crate) fn serialise_settings(sheet: &Sheet, to: &mut StateWriter) {
    serialise_material(&sheet.parameters.material, to);
    to.numbers(&[
        sheet.parameters.friction,
        sheet.parameters.restitution,
        sheet.parameters.springs.damping,
        sheet.parameters.damping_ratio,
    ]);
    sheet.flexion_angle_limit().serialise(to);
    inter_layer::own_stiffness(sheet).serialise(to);
    sheet.parameters.drag.serialise_settings(to);
    sheet.state.inelastic.as_ref().map(|f| f.celsius()).serialise(to);
    to.text(instability::chosen_engine(sheet).name());
    sheet.when_unstable().serialise(to);
    to.number(sheet.parameters.max_step);
    sheet.parameters.applied.axes().into_iter().for_each(|axis| to.sparse(axis));
    to.count(sheet.grabs.len() as u64);
    sheet.grabs.iter().for_each(|pull| pull.serialise(to));
}

/// Deserialise the parameters; `tolerance` is that of an adaptive integrator, m.
pub(crate) fn deserialise_settings(sheet: &mut Sheet, from: &mut StateReader, tolerance: f64) -> ReadResult {
    let material = deserialise_material(from)?;
    (sheet.parameters.friction, sheet.parameters.restitution) = (from.number()?, from.number()?);
    let (damping, ratio) = (from.number()?, from.number()?);
    if (damping, ratio) != (sheet.parameters.springs.damping, sheet.parameters.damping_ratio) {
        (sheet.parameters.springs.damping, sheet.parameters.damping_ratio) = (damping, ratio);
        sheet.refresh();
    }
    if material != sheet.parameters.material {
        sheet.set_material(material).map_err(|_| CorruptState)?;
    }
    let limit = from.read()?;
    if limit != sheet.flexion_angle_limit() {
        sheet.set_flexion_limit(limit).map_err(|_| CorruptState)?;
    }
    let between_layers = from.read()?;
    if between_layers != inter_layer::own_stiffness(sheet) {
        sheet.set_inter_layer_stiffness(between_layers).map_err(|_| CorruptState)?;
    }
    sheet.parameters.drag.deserialise_settings(from)?;
    let celsius = from.read()?;
    if let Some((flow, celsius)) = sheet.state.inelastic.as_mut().zip(celsius) {
        flow.set_celsius(celsius);
    }
    let engine = from.text()?.parse().map_err(|_| CorruptState)?;
    if engine != instability::chosen_engine(sheet) {
        sheet.set_engine(engine, tolerance);
    }
    sheet.engine.set_tolerance(tolerance);
    let policy = WhenUnstable::deserialise(from)?;
    if policy != sheet.when_unstable() {
        instability::set_recovery_policy(sheet, policy, tolerance);
    }
    sheet.recovery.iter_mut().for_each(|guard| guard.tolerance = tolerance);
    sheet.parameters.max_step = from.number()?;
    // A shorter step than 1e-9 s would need an unbounded number of substeps.
    if sheet.parameters.max_step.is_nan() || sheet.parameters.max_step < 1e-9 {
        return Err(CorruptState);
    }
    sheet.parameters.applied.axes_mut().into_iter().try_for_each(|axis| from.sparse(axis))?;
    deserialise_grabs(sheet, from)
}

fn deserialise_grabs(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let mut pulls = Vec::new();
    for _ in 0..from.length(59)? {
        pulls.push(GrabSpring::deserialise(from, sheet.node_count())?);
    }
    let same = pulls.len() == sheet.grabs.len() && pulls.iter().zip(&sheet.grabs).all(|(a, b)| a.is_same_grab(b));
    if same {
        let targets = pulls.iter().enumerate();
        return targets.into_iter().try_for_each(|(i, p)| sheet.pull(i, p.target).map_err(|_| CorruptState));
    }
    while sheet.release_grab(0) {}
    for pull in pulls {
        sheet.grabs.push(pull);
        grab::add_pull(sheet);
    }
    Ok(())
}

/// Serialise the state that a step takes from earlier steps, without contact.
pub(crate) fn serialise_state(sheet: &Sheet, to: &mut StateWriter, clearance: impl FnOnce(&mut StateWriter)) {
    // Every field is named: a new one that is not serialised does not compile.
    let SheetState {
        x: _,
        v: _,
        status: _,
        counters: _,
        rest_time: _,
        rest_positions: _,
        interpenetration: _,
        displaced: _,
        touching,
        flexion_impulses,
        adhesion,
        heat,
        inelastic: _,
        fracture,
        buckle_detector,
    } = &sheet.state;
    sheet.pins.serialise(to);
    to.number(sheet.parameters.drag.pressure);
    sheet.state.serialise_motion(to);
    to.option(fracture.as_ref(), |tears, to| {
        to.flags(tears.cells());
        tears.serialise(to);
    });
    to.option(heat.as_ref(), |heat, to| heat.serialise(to));
    if is_changed(sheet) {
        serialise_changes(sheet, to);
    }
    sheet.recovery.iter().for_each(|guard| guard.state.serialise(to));
    serialise_arms(sheet, to);
    serialise_history(sheet, to);
    to.flags(touching);
    to.flag(sheet.work.stage.has_diverged);
    clearance(to);
    to.option(adhesion.as_ref(), |stuck, to| stuck.serialise(to));
    to.option(buckle_detector.as_ref(), |watch, to| watch.serialise(to));
    // Their number follows from the limits and the open cells.
    flexion_impulses.numbers().into_iter().for_each(|list| to.numbers(list));
}

/// Deserialise the state. Elements that were unchanged in the snapshot must be unchanged in
/// this sheet.
pub(crate) fn deserialise_state(
    sheet: &mut Sheet,
    from: &mut StateReader,
    clearance: impl FnOnce(&mut StateReader, usize) -> ReadResult,
) -> ReadResult {
    let masses = sheet.node_count();
    deserialise_pins(sheet, from)?;
    sheet.parameters.drag.pressure = from.number()?;
    let rest = sheet.state.deserialise_motion(from)?;
    deserialise_fracture(sheet, from)?;
    deserialise_heat(sheet, from)?;
    if is_changed(sheet) {
        deserialise_changes(sheet, from)?;
    }
    if sheet.recovery.is_some() {
        let state = RecoveryState::deserialise(from)?;
        instability::restore_recovery_state(sheet, Some(state));
    }
    deserialise_arms(sheet, from)?;
    deserialise_history(sheet, from)?;
    deserialise_touching(sheet, from)?;
    sheet.work.stage.has_diverged = from.flag()?;
    clearance(from, masses)?;
    sheet.state.displaced = false;
    deserialise_adhesion(sheet, from)?;
    deserialise_buckle_detector(sheet, from)?;
    sheet.state.flexion_impulses.numbers_mut().into_iter().try_for_each(|list| from.numbers(list))?;
    // Deserialising the other state may have woken the sheet.
    sheet.state.set_rest(rest);
    Ok(())
}

pub(super) fn deserialise_adhesion(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let masses = sheet.node_count();
    sheet.state.adhesion = if from.flag()? { Some(Box::new(AdhesionState::deserialise(from, masses)?)) } else { None };
    Ok(())
}

fn deserialise_fracture(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    if !from.flag()? {
        return if sheet.state.fracture.is_none() || fracture::undo_cuts(sheet) { Ok(()) } else { Err(CorruptState) };
    }
    fracture::prepare_cut(sheet);
    let mut cells = Vec::new();
    from.flags(&mut cells)?;
    if sheet.open_cells().is_none_or(|own| own.len() != cells.len()) {
        return Err(CorruptState);
    }
    fracture::set_open(sheet, &cells);
    sheet.state.fracture.as_mut().map_or(Ok(()), |tears| tears.deserialise(from))
}

fn deserialise_heat(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    if !from.flag()? {
        return if sheet.state.heat.is_none() { Ok(()) } else { Err(CorruptState) };
    }
    deserialise_temperatures(sheet, from)
}

pub(super) fn deserialise_temperatures(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    temperature::start_temperatures(sheet, crate::units::temperature::REFERENCE);
    let Some(mut heat) = sheet.state.heat.take() else { return Err(CorruptState) };
    let taken = heat.deserialise(from, sheet);
    sheet.state.heat = Some(heat);
    taken
}

fn own_elements(sheet: &Sheet) -> &[Box<dyn Element>] {
    &sheet.elements[..sheet.elements.len() - sheet.grabs.len()]
}

pub(super) fn serialise_changes(sheet: &Sheet, to: &mut StateWriter) {
    for list in [&sheet.springs.stiffness, &sheet.springs.rest, &sheet.springs.damping] {
        to.numbers(list);
    }
    own_elements(sheet).iter().for_each(|e| e.serialise_changes(to));
    sheet.state.inelastic.iter().for_each(|flow| flow.serialise(to));
}

pub(super) fn deserialise_changes(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let count = sheet.springs.len();
    let mut lists = [(); 3].map(|()| vec![0.0; count]);
    lists.iter_mut().try_for_each(|list| from.numbers(list))?;
    let [stiffness, rest, damping] = lists;
    for i in 0..count {
        sheet.springs.set_law(i, stiffness[i], damping[i]);
        sheet.springs.set_rest(i, rest[i]);
    }
    sheet.parameters.springs.has_dashpots = sheet.springs.is_damped();
    let own = sheet.elements.len() - sheet.grabs.len();
    sheet.elements[..own].iter_mut().try_for_each(|e| e.deserialise_changes(from))?;
    if let Some(flow) = &mut sheet.state.inelastic {
        flow.deserialise(from)?;
    }
    if let Some(system) = &mut sheet.system {
        system.refresh(&sheet.springs);
    }
    Ok(())
}

fn arm_values(sheet: &Sheet) -> u64 {
    own_elements(sheet).iter().filter_map(|e| e.arms()).map(|arms| arms.len() as u64).sum()
}

/// Serialise the strains of the arms of a flat loss factor.
pub(super) fn serialise_arms(sheet: &Sheet, to: &mut StateWriter) {
    to.count(arm_values(sheet));
    own_elements(sheet).iter().filter_map(|e| e.arms()).for_each(|arms| arms.serialise(to));
}

/// Deserialise the values that [`serialise_arms`] writes.
pub(super) fn deserialise_arms(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let own = sheet.elements.len() - sheet.grabs.len();
    if from.count()? != arm_values(sheet) {
        return Err(CorruptState);
    }
    sheet.elements[..own].iter_mut().filter_map(|e| e.arms_mut()).try_for_each(|arms| arms.deserialise(from))
}

/// Serialise the history of an implicit integrator; empty before its first step and after a
/// restart.
fn serialise_history(sheet: &Sheet, to: &mut StateWriter) {
    sheet.engine.serialise(to);
    let begun = sheet.last_field.zip(sheet.system.as_ref());
    to.flag(begun.is_some());
    if let Some((field, system)) = begun {
        to.vector(field.gravity);
        to.numbers(&[field.air, field.air_density]);
        to.vector(field.wind);
        system.springs.serialise_history(to);
        own_elements(sheet).iter().for_each(|e| e.serialise_history(to));
    }
}

fn deserialise_history(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    sheet.engine.deserialise(from, sheet.node_count())?;
    sheet.last_field = None;
    if !from.flag()? {
        return Ok(());
    }
    let (gravity, air, air_density) = (from.vector()?, from.number()?, from.number()?);
    let field = Field { gravity, air, air_density, wind: from.vector()? };
    let mut system = sheet.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(sheet)));
    system.forget_constant();
    let taken = system.springs.deserialise_history(from);
    sheet.system = Some(system);
    taken?;
    let own = sheet.elements.len() - sheet.grabs.len();
    sheet.elements[..own].iter_mut().try_for_each(|e| e.deserialise_history(from))?;
    sheet.last_field = Some(field);
    Ok(())
}

pub(super) fn serialise_material(material: &Material, to: &mut StateWriter) {
    to.text(&material.name);
    // `Material` omits an empty name when it is written, so the name is written separately.
    let named = Material { name: "-".to_owned(), ..material.clone() };
    let bytes = postcard::to_extend(&named, Vec::new()).unwrap_or_default();
    to.blob(&bytes);
}

pub(super) fn deserialise_material(from: &mut StateReader) -> ReadResult<Material> {
    let name = from.text()?.to_owned();
    let mut material: Material = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
    material.name = name;
    validate::material("material", &material).map_err(|_| CorruptState)?;
    Ok(material)
}

fn deserialise_pins(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let mut pins = std::mem::take(&mut sheet.pins);
    let others = pins.deserialise(from, sheet.node_count());
    sheet.pins = pins;
    if others? {
        attachment::fix_pinned_nodes(sheet);
    }
    Ok(())
}

/// Deserialise which nodes touch something; an empty list leaves them as they are.
fn deserialise_touching(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let mut touching = Vec::new();
    from.flags(&mut touching)?;
    if touching.len() == sheet.node_count() {
        node_contact::resize_workspace(sheet);
        sheet.state.touching = touching;
    } else if !touching.is_empty() {
        return Err(CorruptState);
    }
    Ok(())
}

fn deserialise_buckle_detector(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    if from.flag()? {
        let mut watch = crate::sheet::buckling::BuckleDetector::default();
        watch.deserialise(from, sheet.node_count(), sheet.opening_revision())?;
        sheet.state.buckle_detector.iter_mut().for_each(|own| **own = std::mem::take(&mut watch));
    }
    Ok(())
}
