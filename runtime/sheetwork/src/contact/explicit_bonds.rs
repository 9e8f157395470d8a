//! Bonds of explicit integrators between two sheets and with dynamic bodies.
//!
//! A bond of force f (N) lets the normal contact force p bear tension, p ≥ -f, with friction
//! |p_t| ≤ μ (p + f). With p = p' - f this is unilateral contact, p' ≥ 0, of the free motion to
//! which f has been added. It is added after detection, so that contacts and normals are those of
//! the motion without it, and the springs are never evaluated at positions inside the other side.
//! The contact cache holds p: the solvers then start from the motion of the last step, whatever f
//! is now.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::adhesion::{node_contact, other_body, other_sheet, towards};
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::apply_force;

/// Add the bond forces of the detected contacts that are still closed to the free motion of a step
/// of `dt` (s). Bonded contacts do not rebound.
pub(crate) fn pull_bonded(island: &mut IslandView, detected: &mut DetectedContacts, dt: f64) {
    if !island.sheets.iter().any(|sheet| sheet.state.adhesion.is_some()) {
        return;
    }
    for stuck in island.sheets.iter_mut().filter_map(|sheet| sheet.state.adhesion.as_mut()) {
        stuck.pair_count.fill([0; 2]);
    }
    for contact in &detected.contacts {
        if let Some((sheet, node, side)) = bonded_side(island, contact)
            && let Some(stuck) = &mut island.sheets[sheet as usize].state.adhesion
        {
            stuck.pair_count[node as usize][side] += 1;
        }
    }
    for contact in &mut detected.contacts {
        if let Some((sheet, node, side)) = bonded_side(island, contact)
            && let Some(stuck) = &island.sheets[sheet as usize].state.adhesion
        {
            let parts = f64::from(stuck.pair_count[node as usize][side].max(1));
            contact.bond = stuck.pair_force[node as usize][side] / parts;
            contact.restitution = 0.0;
            pull(island, contact, dt);
        }
    }
}

/// Sheet, node and side of the node of a closed contact that has a bond.
fn bonded_side(island: &IslandView, contact: &ContactConstraint) -> Option<(u32, u32, usize)> {
    let (sheet, node, _) = node_contact(contact)?;
    let stuck = island.sheet(sheet).state.adhesion.as_ref()?;
    let side = stuck.side(node, towards(contact));
    if stuck.pair_force.get(node as usize)?[side] <= 0.0 {
        return None;
    }
    let gives = other_body(contact).is_some_and(|body| island.solver_bodies[body as usize].is_dynamic());
    // Twice the gap at the end of the last step: normal and nearest point are new ones.
    let reach = 2.0 * ContactSettings::DEFAULT.closed_gap_at_end;
    let is_pair = gives || other_sheet(contact).is_some();
    (is_pair && gap(island, contact, StagePose::Start) < reach).then_some((sheet, node, side))
}

/// Pull the two sides of a contact together by its bond force.
fn pull(island: &mut IslandView, contact: &ContactConstraint, dt: f64) {
    for (side, sign) in [(&contact.a, -contact.bond), (&contact.b, contact.bond)] {
        let force = contact.normal * sign;
        match side {
            ContactSide::Sheet { sheet, point } => {
                let sheet = &mut island.sheets[*sheet as usize];
                let drift = sheet.engine_kind.info().drift;
                for (i, weight) in point.terms() {
                    let free = if sheet.pins.is_empty() { DVec3::ONE } else { sheet.pins.free_axes(i) };
                    let change = force * free * (weight * sheet.inverse_mass[i as usize] * dt);
                    sheet.work.stage.velocity.add(i as usize, change);
                    sheet.work.stage.free_positions.add(i as usize, change * (drift * dt));
                }
            }
            ContactSide::Body { body, local } => {
                let body = &mut island.solver_bodies[*body as usize];
                if body.is_dynamic() {
                    let at = body.free.world_point(*local);
                    body.begin(apply_force(&body.free, force, at, (dt, 0.5)));
                }
            }
        }
    }
}

/// Bond force of a contact in its position solve, N: forces act there on displacements.
pub(crate) fn position_bond(island: &IslandView, contact: &ContactConstraint) -> f64 {
    let drift = |sheet: u32| island.sheet(sheet).engine_kind.info().drift;
    if contact.bond > 0.0 { contact.bond * node_contact(contact).map_or(0.0, |(sheet, ..)| drift(sheet)) } else { 0.0 }
}
