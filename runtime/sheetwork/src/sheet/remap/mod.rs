//! Change of the grid of a sheet: state transfer to a refined or coarsened grid.
//!
//! The sheet is built from its description on the other grid and then takes over the state of the
//! old one:
//!
//! - positions and velocities by splines through the nodes (`spline`), corrected to the strains and
//!   rates of strain of the old grid (`strain`); prescribed nodes have their prescribed positions;
//! - momentum and angular momentum of a free sheet, and a kinetic energy of at most the old one
//!   minus the gain of elastic energy;
//! - temperatures of each half of the thickness, and their means;
//! - inelastic strains and thermal expansion of the elements ([`crate::elements::remap`]);
//! - applied forces, distributed to the nodes of their cell by the lever rule; grabs; parameters.
//!
//! The integrator restarts, and the contact cache is discarded.

pub(crate) mod apex;
pub(crate) mod attachments;
pub(crate) mod clamp_springs;
pub(crate) mod lattice;
pub(crate) mod layer_offsets;
pub(crate) mod loads;
pub(crate) mod membrane;
pub(crate) mod motion;
pub(crate) mod outline;
pub(crate) mod patch;
pub(crate) mod row_interpolation;
pub(crate) mod spline;
pub(crate) mod springs;
pub(crate) mod strain;

use crate::elements::remap::{GridRemap, MeshRemap, Remap};
use crate::error::{InputError, reject_if};
use crate::mesh::outline::TriangleMesh;
use crate::scene::{Region, SheetSpec};
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::{RecoveryState, Sheet, Status, attachment, buckling, instability, inter_layer, temperature};
use crate::units::temperature::REFERENCE;

/// Iterations for the largest frequency, which give an accuracy of a few percent.
const FREQUENCY_ITERATIONS: usize = 60;
/// Stability limit hω of every explicit integrator with damping.
const STABILITY_LIMIT: f64 = 1.0;
/// Minimum length of a substep, s.
const MIN_SUBSTEP: f64 = 1e-9;

impl Sheet {
    /// Number of substeps of a step of `dt` (s): more than one on a changed grid whose explicit
    /// integrator is unstable for the whole step.
    pub fn substeps_of_step(&self, dt: f64) -> u32 {
        (dt / self.parameters.max_step).ceil().max(1.0) as u32
    }
}

/// Check that the grid can change; `spec` is the description of the sheet.
pub(crate) fn check_grid_change(sheet: &Sheet, spec: &SheetSpec) -> Result<(), InputError> {
    let by_number = |r: &Region| matches!(r, Region::Masses(_));
    let refusals = [
        (spec.file.is_some(), "the sheet is of a file, which has its masses"),
        (spec.sticky, "the sheet is sticky, and what it sticks by are its masses"),
        (sheet.open_count() > 0, "cells of the sheet are open, which another grid does not have"),
        (spec.pins.iter().any(|p| p.body.is_some()), "the sheet is glued to a body by its masses"),
        (sheet.pins.is_changed(), "masses of the sheet were pinned or unpinned while it ran"),
        (spec.pins.iter().any(|p| by_number(&p.region)), "the sheet is pinned at masses by number"),
        (matches!(sheet.state.status, Status::Unstable { .. }), "the sheet went unstable"),
    ];
    match refusals.into_iter().find(|(refused, _)| *refused) {
        Some((_, why)) => Err(InputError::new("grid", format!("cannot change: {why}"))),
        None => Ok(()),
    }
}

/// Take over the state of `old`, the same sheet on another grid, at `time` (s). This sheet must
/// be as built; `tolerance` is that of an adaptive integrator, m.
///
/// # Errors
/// When a pin at a single node would prescribe another material point.
pub(crate) fn take_state_from(
    sheet: &mut Sheet,
    old: &Sheet,
    spec: &SheetSpec,
    time: f64,
    tolerance: f64,
) -> Result<(), InputError> {
    check_points(sheet, old, spec)?;
    let (from, to) = (old.model.meshes.present.clone(), sheet.model.meshes.present.clone());
    let carry = match (&from, &to) {
        (Some(from), Some(to)) => Remap::Mesh(mesh_remap((from, old), (to, sheet))),
        _ => Remap::Grid(GridRemap { from: nodes_along(old), to: nodes_along(sheet) }),
    };
    copy_settings_from(sheet, old, tolerance)?;
    remap_temperatures(sheet, old, &carry);
    attachment::release_pins(sheet, time);
    match &carry {
        Remap::Mesh(meshes) => outline::remap_outline(sheet, old, spec, meshes, time),
        Remap::Grid(_) => motion::remap_motion(sheet, old, spec, time),
    }
    let own = (sheet.elements.len(), old.elements.len() - old.grabs.len());
    for (element, before) in sheet.elements[..own.0].iter_mut().zip(&old.elements[..own.1]) {
        element.transfer_state(&**before, &carry);
    }
    springs::remap_springs(sheet, old);
    clamp_springs::remap_clamp_springs(sheet, old, spec);
    motion::limit_kinetic_energy_to(sheet, old);
    match &carry {
        Remap::Mesh(meshes) => outline::remap_outline_forces(sheet, old, meshes),
        Remap::Grid(_) => loads::remap_forces(sheet, old),
    }
    for pull in old.pulls() {
        let (u, v) = pull.material_point(&old.model.uv);
        let index = sheet.grab((u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)), pull.stiffness)?;
        sheet.pull(index, pull.target)?;
    }
    match &carry {
        Remap::Mesh(meshes) => outline::remap_outline_contact_flags(sheet, old, meshes),
        Remap::Grid(_) => loads::remap_contact_flags(sheet, old),
    }
    update_max_step(sheet);
    (sheet.state.counters, sheet.state.rest_time, sheet.state.status) =
        (old.state.counters, old.state.rest_time, old.state.status);
    Ok(())
}

/// Remapping between two meshes of a sheet.
fn mesh_remap<'a>(from: (&'a TriangleMesh, &Sheet), to: (&'a TriangleMesh, &Sheet)) -> MeshRemap<'a> {
    let refinements = from.1.model.meshes.refinement.as_ref().zip(to.1.model.meshes.refinement.as_ref());
    match refinements.filter(|(a, b)| a.base == b.base) {
        Some((a, b)) => MeshRemap::nested((from.0, a), (to.0, b)),
        None => MeshRemap::new(from.0, to.0),
    }
}

/// Numbers of nodes along length and width.
pub(crate) fn nodes_along(sheet: &Sheet) -> [usize; 2] {
    [sheet.model.grid.0 as usize, sheet.model.grid.2 as usize]
}

/// Refuse a grid on which a pin at a point prescribes another material point.
fn check_points(sheet: &Sheet, old: &Sheet, spec: &SheetSpec) -> Result<(), InputError> {
    for (i, pin) in spec.pins.iter().enumerate() {
        let Region::Point(u, v) = pin.region else { continue };
        let of = |sheet: &Sheet| {
            let mass = crate::sheet::select(&pin.region, sheet).ok().and_then(|list| list.first().copied());
            mass.map_or((f64::NAN, f64::NAN), |m| sheet.model.uv[m as usize])
        };
        let (now, then) = (of(sheet), of(old));
        let ((u0, v0), (nu, _, nv)) = (then, sheet.model.grid);
        let is_away = (now.0 - u0).abs().max((now.1 - v0).abs()) > 1e-9;
        let held = format!("where pins.{i} holds the one next to ({u}, {v})");
        reject_if!(is_away, "grid", "{nu}x{nv} has no mass at ({u0}, {v0}), {held}");
    }
    Ok(())
}

fn copy_settings_from(sheet: &mut Sheet, old: &Sheet, tolerance: f64) -> Result<(), InputError> {
    (sheet.parameters.friction, sheet.parameters.restitution) = (old.parameters.friction, old.parameters.restitution);
    (sheet.parameters.springs.damping, sheet.parameters.damping_ratio) =
        (old.parameters.springs.damping, old.parameters.damping_ratio);
    if sheet.parameters.material != old.parameters.material {
        sheet.set_material(old.parameters.material.clone())?;
    } else {
        sheet.refresh();
    }
    if !sheet.parameters.flexion.triples.is_empty() {
        sheet.set_flexion_limit(old.flexion_angle_limit())?;
    }
    inter_layer::copy_stiffness(sheet, old)?;
    sheet.parameters.drag.copy_settings(&old.parameters.drag);
    if let Some((flow, before)) = sheet.state.inelastic.as_mut().zip(old.state.inelastic.as_ref()) {
        flow.set_celsius(before.celsius());
    }
    sheet.change_engine(instability::chosen_engine(old), tolerance);
    instability::set_recovery_policy(sheet, old.when_unstable(), tolerance);
    if let Some((own, before)) = sheet.recovery.as_mut().zip(old.recovery.as_ref()) {
        own.state = RecoveryState { delay: before.state.delay, ..RecoveryState::default() };
    }
    buckling::set_buckling_detection(sheet, old.state.buckle_detector.is_some());
    sheet.model.initial_diagonal = old.model.initial_diagonal;
    Ok(())
}

/// Remap the temperatures, and restore their mean, weighted by mass, in each half of the
/// thickness.
fn remap_temperatures(sheet: &mut Sheet, old: &Sheet, carry: &Remap) {
    if old.state.heat.is_none() {
        return;
    }
    temperature::start_temperatures(sheet, REFERENCE);
    let both = [false, true].map(|upper| {
        let before = old.side_temperatures(upper).unwrap_or_default();
        let mut now = read_temperatures(sheet, old, before, carry);
        let mean = |celsius: &[f64], mass: &[f64]| {
            celsius.iter().zip(mass).map(|(t, m)| t * m).sum::<f64>() / mass.iter().sum::<f64>()
        };
        let lost = mean(before, &old.model.mass) - mean(&now, &sheet.model.mass);
        now.iter_mut().for_each(|t| *t += lost);
        now
    });
    temperature::set_side_temperatures(sheet, &both);
}

/// Interpolate the temperatures `before` of `old` at the nodes of this sheet.
fn read_temperatures(sheet: &Sheet, old: &Sheet, before: &[f64], carry: &Remap) -> Vec<f64> {
    if lattice::is_lattice(sheet) {
        return LatticeLayout::from_sheet(sheet).means(&LatticeLayout::from_sheet(old), before);
    }
    carry.at_nodes(before)
}

/// Compute the longest stable step of an explicit integrator on this grid.
pub(crate) fn update_max_step(sheet: &mut Sheet) {
    let engine = sheet.engine_kind.info();
    let limited = !engine.implicit && !engine.adaptive;
    let frequency = if limited { sheet.largest_frequency(FREQUENCY_ITERATIONS) } else { 0.0 };
    // The highest mode of a Kelvin-Voigt solid has the damping ratio τ ω/2, which shortens the
    // stable step. Dashpots that are a fraction of each spring's own critical damping give two
    // to three times that ratio where a dozen springs meet.
    let solid = sheet.follows_material();
    let damping =
        if solid { 0.5 * sheet.law().retardation * frequency } else { 2.5 * sheet.parameters.springs.damping };
    let borne = STABILITY_LIMIT / (damping.hypot(1.0) + damping);
    sheet.parameters.max_step = if frequency > 0.0 { (borne / frequency).max(MIN_SUBSTEP) } else { f64::INFINITY };
}
