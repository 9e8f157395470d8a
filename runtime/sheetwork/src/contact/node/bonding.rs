//! Contacts of single nodes that may become bonds ([`crate::contact::adhesion`]).
//!
//! The bond force f of the last step is added to the motion of the integrator, and not to its
//! forces: its stages would evaluate the springs at positions inside the body. The sum is the free
//! motion of a node. A response that changes the velocity of the node by Δv in a step of `dt` (s)
//! exerts the force m Δv/dt, whose normal part is p + f. A load above f leads the node away from
//! the surface: the bond is open, and exerts no force. So it is when the contact of sheets has
//! moved the node further from the surface than the tolerance of closed contacts.

use glam::DVec3;

use crate::contact::node::clearance::Clearance;
use crate::contact::node::response::{NodeContactSurface, NodePath, NodeResponse};
use crate::contact::settings::ContactSettings;
use crate::elements::flexion_limit::solver::LimitContact;
use crate::sheet::bonds::NodeBondContact;
use crate::sheet::{Sheet, node_contact};

/// Gap of a closed contact of the sheet, m.
fn closed_gap(sheet: &Sheet) -> f64 {
    ContactSettings::DEFAULT.closed_gap_at_end * node_contact::half_thickness(sheet)
}

/// Gap of closed bonds of the sheet, m; zero for a sheet without adhesion.
pub(crate) fn tolerance(sheet: &Sheet) -> f64 {
    if sheet.state.adhesion.is_some() { closed_gap(sheet) } else { 0.0 }
}

/// Add the bond forces to the motion of a substep of `dt` (s).
pub(crate) fn pull(sheet: &mut Sheet, dt: f64) {
    let drift = sheet.engine.drift(dt).unwrap_or(sheet.engine_kind.info().drift);
    let tolerance = tolerance(sheet);
    let Sheet { state, inverse_mass, pins, work, .. } = sheet;
    let Some(stuck) = &mut state.adhesion else { return };
    stuck.substep = dt;
    stuck.pull.clear();
    for (i, inverse) in inverse_mass.iter().enumerate().filter(|(_, inverse)| **inverse > 0.0) {
        let force = stuck.bond_force.get(i);
        if force != DVec3::ZERO {
            let change = force * pins.free_axes(i as u32) * (inverse * dt);
            // The node cannot have gone further from the surface; the response moves it by its
            // velocities alone. A longer way could leave the body through another face.
            let way = 2.0 * state.x.get(i).distance(work.x_before.get(i)) + tolerance;
            let shift = (change * (drift * dt)).clamp_length_max(way);
            stuck.pull.set(i, shift);
            state.v.add(i, change);
            state.x.add(i, shift);
        }
    }
}

/// Undo the pull on nodes that met no surface: an open bond exerts no force.
pub(crate) fn release_unmet(sheet: &mut Sheet) {
    let Sheet { state, inverse_mass, pins, .. } = sheet;
    let Some(stuck) = &mut state.adhesion else { return };
    for contact in &stuck.node_contacts {
        stuck.pull.set(contact.node as usize, DVec3::ZERO);
    }
    for (i, inverse) in inverse_mass.iter().enumerate() {
        let shift = stuck.pull.get(i);
        if shift != DVec3::ZERO {
            let change = stuck.bond_force.get(i) * pins.free_axes(i as u32) * (inverse * stuck.substep);
            state.v.add(i, -change);
            state.x.add(i, -shift);
        }
    }
}

/// Begin the contact of a substep: the contacts of the last one are those that may still be closed.
pub(crate) fn begin(sheet: &mut Sheet) {
    if let Some(stuck) = &mut sheet.state.adhesion {
        std::mem::swap(&mut stuck.node_contacts, &mut stuck.previous_node_contacts);
        stuck.node_contacts.clear();
    }
}

/// Record the response of node `i` to `surface`. An impact loads no bond.
pub(crate) fn record(
    sheet: &mut Sheet,
    i: usize,
    flight: &NodePath,
    surface: &NodeContactSurface,
    response: &NodeResponse,
) {
    let (mass, offset) = (sheet.model.mass[i], node_contact::contact_offset(sheet));
    let Some(stuck) = &mut sheet.state.adhesion else { return };
    let impulse = if response.impact > 0.0 { DVec3::ZERO } else { (response.v - flight.v1) * mass };
    let level = surface.point.dot(surface.normal) + offset;
    let (node, towards, friction) = (i as u32, -surface.normal, surface.friction);
    let contact = NodeBondContact { node, towards, level, force: impulse, friction };
    stuck.node_contacts.push(contact);
}

/// End the contact of a substep of `dt` (s): impulses become forces, and bonded nodes that are
/// within the tolerance of the surface count as closed.
pub(crate) fn finish(sheet: &mut Sheet, clearance: &Clearance, dt: f64) {
    if sheet.state.adhesion.is_none() {
        return;
    }
    let reach = node_contact::contact_offset(sheet) + tolerance(sheet);
    let closed_gap = closed_gap(sheet);
    let Sheet { state, work, .. } = sheet;
    let Some(stuck) = &mut state.adhesion else { return };
    if work.flexion.is_coupled {
        let x = &state.x;
        let is_closed = |c: &&LimitContact| {
            let gap = x.get(c.nodes[0] as usize).dot(c.normal) - c.level;
            c.count == 1 && (c.impulse.0 > 0.0 || gap < closed_gap)
        };
        stuck.node_contacts.clear();
        stuck.node_contacts.extend(work.flexion.contacts.iter().filter(is_closed).map(NodeBondContact::of_limit));
    }
    for contact in &mut stuck.node_contacts {
        contact.force /= dt;
    }
    for k in 0..stuck.previous_node_contacts.len() {
        let mut last = stuck.previous_node_contacts[k];
        let i = last.node as usize;
        let is_near = clearance.nearest.get(i).is_some_and(|near| *near > 0.0 && *near < reach);
        if is_near && stuck.bonded[i] && state.x.get(i).is_finite() {
            (last.force, last.level) = (DVec3::ZERO, -state.x.get(i).dot(last.towards));
            stuck.node_contacts.push(last);
        }
    }
}
