//! Attachments of a sheet to bodies: binding, motion, and release.

use glam::DVec3;
use rapier3d::prelude::RigidBodyHandle;

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::scene::PathKey;
use crate::sheet::attached_body::AttachedTo;
use crate::sheet::{Sheet, stage};

impl Sheet {
    /// Nodes attached to dynamic bodies: node, index of the body, position in the frame of the body
    /// (m).
    pub fn dynamic_attachments(&self) -> impl Iterator<Item = (u32, usize, DVec3)> + '_ {
        self.pins.dynamic_attachments()
    }
}

/// Bind attachments to their bodies; `find` gives index and state by name. Nodes attached to a
/// static or kinematic body become kinematic; those attached to a dynamic body start with its
/// motion.
///
/// # Errors
/// When a body does not exist.
pub(crate) fn attach_to_bodies(
    sheet: &mut Sheet,
    find: impl Fn(&str) -> Option<(usize, BodyState)>,
) -> Result<(), InputError> {
    let named = |name: String| InputError::new("pins", format!("no body named \"{name}\" is there to be glued to"));
    let held = sheet.pins.bind_bodies(&find).map_err(named)?;
    for mass in &held {
        sheet.inverse_mass[*mass as usize] = 0.0;
        sheet.state.v.set(*mass as usize, DVec3::ZERO);
    }
    for (mass, state) in sheet.pins.attached_body_states() {
        let i = mass as usize;
        sheet.state.v.set(i, state.velocity_at(sheet.state.x.get(i)));
    }
    if !held.is_empty() {
        invalidate_system(sheet);
    }
    Ok(())
}

/// Whether any node is attached to a dynamic body.
pub(crate) fn has_dynamic_attachments(sheet: &Sheet) -> bool {
    sheet.pins.has_dynamic_attachments()
}

/// Release the attachments to the removed body `index`; later indices decrease by one.
pub(crate) fn detach_body(sheet: &mut Sheet, index: usize) {
    let freed = sheet.pins.detach_body(index);
    set_free(sheet, &freed);
}

/// Attach `nodes`, a sorted list, where they are to a body in the state `state`; earlier pins let
/// them go. Nodes attached to a dynamic body start with its motion.
pub(crate) fn attach_nodes(sheet: &mut Sheet, nodes: &[u32], owner: AttachedTo, state: BodyState) {
    sheet.pins.unpin(nodes);
    sheet.pins.attach(nodes.iter().map(|node| (*node, sheet.state.x.get(*node as usize))), owner, state);
    for node in nodes.iter().map(|node| *node as usize) {
        let led = !state.is_dynamic();
        let velocity = if led { DVec3::ZERO } else { state.velocity_at(sheet.state.x.get(node)) };
        sheet.state.v.set(node, velocity);
        sheet.inverse_mass[node] = if led || sheet.is_detached(node) { 0.0 } else { 1.0 / sheet.model.mass[node] };
    }
    stage::restart_engine(sheet);
    invalidate_system(sheet);
}

/// Attach the attached nodes again where they are, to bodies in the state that `find` gives.
pub(crate) fn renew_attachments(sheet: &mut Sheet, find: impl Fn(AttachedTo) -> Option<BodyState>) {
    sheet.pins.renew_attachments(&sheet.state.x, find);
}

/// Release the attachments to lent bodies that are gone.
pub(crate) fn detach_lent(sheet: &mut Sheet, gone: impl Fn(RigidBodyHandle) -> bool) {
    if sheet.pins.is_attached_to_lent(&gone) {
        let freed = sheet.pins.detach_lent(gone);
        set_free(sheet, &freed);
        sheet.wake();
    }
}

/// Fix exactly the nodes that are pinned or detached.
pub(crate) fn fix_pinned_nodes(sheet: &mut Sheet) {
    let mut held = vec![false; sheet.node_count()];
    sheet.pins.masses().for_each(|m| held[m as usize] = true);
    for (i, held) in held.into_iter().enumerate() {
        sheet.inverse_mass[i] = if held || sheet.is_detached(i) { 0.0 } else { 1.0 / sheet.model.mass[i] };
    }
    invalidate_system(sheet);
}

/// Release the pins that end by time `t` (s); their nodes keep the prescribed velocity.
#[doc(hidden)]
pub fn release_pins(sheet: &mut Sheet, t: f64) {
    if sheet.pins.has_release_by(t) {
        let freed = sheet.pins.release(t);
        set_free(sheet, &freed);
        stage::restart_engine(sheet);
    }
}

/// Pin `nodes`, a sorted list, where they are: fixed, or along `path`, whose offsets count from
/// there, until the time `until` (s). Earlier pins let them go.
pub(crate) fn pin_nodes(sheet: &mut Sheet, nodes: Vec<u32>, path: Vec<PathKey>, until: Option<f64>) {
    sheet.pins.unpin(&nodes);
    let start = nodes.iter().map(|node| sheet.state.x.get(*node as usize)).collect();
    for node in &nodes {
        sheet.inverse_mass[*node as usize] = 0.0;
        sheet.state.v.set(*node as usize, DVec3::ZERO);
    }
    sheet.pins.add(nodes, start, path, until);
    stage::restart_engine(sheet);
    invalidate_system(sheet);
}

/// Unpin `nodes`, a sorted list; return how many a pin held.
pub(crate) fn unpin_nodes(sheet: &mut Sheet, nodes: &[u32]) -> usize {
    let freed = sheet.pins.unpin(nodes);
    set_free(sheet, &freed);
    stage::restart_engine(sheet);
    freed.len()
}

fn set_free(sheet: &mut Sheet, freed: &[u32]) {
    for mass in freed {
        let i = *mass as usize;
        if !sheet.is_detached(i) && !sheet.pins.masses().any(|held| held == *mass) {
            sheet.inverse_mass[i] = 1.0 / sheet.model.mass[i];
        }
    }
    if !freed.is_empty() {
        invalidate_system(sheet);
    }
}

/// Discard the linear system after a change of the dynamic nodes.
pub(crate) fn invalidate_system(sheet: &mut Sheet) {
    sheet.system = None;
    sheet.last_field = None;
    sheet.wake();
}
