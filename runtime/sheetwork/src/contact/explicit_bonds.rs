//! Bonds of explicit integrators between two sheets and with dynamic bodies.
//!
//! A bond of force f (N) lets the normal contact force p of the solver bear tension, p ≥ -f, with
//! friction |p_t| ≤ μ (p + f). The solver is the sweeps on nodes and bodies
//! ([`crate::contact::solver::lattice_sweeps`]): a bond closes a gap as a contact closes an
//! overlap, with the masses alone, and the springs are never evaluated inside the other side.

use crate::collision::constraint::ContactConstraint;
use crate::contact::IslandView;
use crate::contact::adhesion::{node_contact, other_body, other_sheet, towards};
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::settings::ContactSettings;

/// Give the detected contacts that are still closed their bond forces. Bonded contacts do not
/// rebound. Returns whether there are any.
pub(crate) fn find_bonded(island: &mut IslandView, detected: &mut DetectedContacts) -> bool {
    if !island.sheets.iter().any(|sheet| sheet.state.adhesion.is_some()) {
        return false;
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
    let mut is_any = false;
    for contact in &mut detected.contacts {
        let Some((sheet, node, side)) = bonded_side(island, contact) else { continue };
        if let Some(stuck) = &island.sheets[sheet as usize].state.adhesion {
            let parts = f64::from(stuck.pair_count[node as usize][side].max(1));
            contact.bond = stuck.pair_force[node as usize][side] / parts;
            contact.restitution = 0.0;
            is_any = true;
        }
    }
    is_any
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
    let reach = 2.0 * ContactSettings::DEFAULT.closed_gap_at_end * island.half_thickness();
    let is_pair = gives || other_sheet(contact).is_some();
    (is_pair && gap(island, contact, StagePose::Start) < reach).then_some((sheet, node, side))
}

/// Bond force of a contact in its position solve, N. There it displaces as a load does with the
/// weight θ of the integrator, Δx = θ h² f/m.
pub(crate) fn position_bond(island: &IslandView, contact: &ContactConstraint) -> f64 {
    if contact.bond == 0.0 {
        return 0.0;
    }
    let drift = node_contact(contact).map_or(0.0, |(sheet, ..)| island.sheet(sheet).engine_kind.info().drift);
    contact.bond * if drift > 0.0 { drift } else { 0.5 }
}
