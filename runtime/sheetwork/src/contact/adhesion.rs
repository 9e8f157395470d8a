//! Adhesion of hot sheets: contacts become bonds that bear tension and break under load or when
//! cold.
//!
//! The contact solvers of implicit integrators and the response of single nodes do not know
//! adhesion; the solver of explicit integrators does (`explicit_bonds`). After a step, every closed
//! contact of a node becomes a bond if the sheet is adhesive and warm enough, or was bonded
//! and is not too cold. In the next step the two sides are pulled together by a constant force f
//! along the contact normal, as an applied force. The contact force is then p + f ≥ 0 for tensile
//! loads up to f, and friction is bounded by μ (p + f). A bond under a larger load opens and is
//! not closed after the step, which removes it.
//!
//! The force is bounded by σ A, with σ the adhesion strength (Pa) and A the area (m²) of the node.
//! Between two sheets, where nodes of each meet triangles of the other, half of that area counts. A
//! node divides its force among the contacts on the same side of the sheet. Edge contacts and
//! corner contacts without a node form no bond.
//!
//! Because f moves the free motion deep into the other side, only the part of σ A that may be
//! needed is applied. It is the larger of two values: the force that accelerates the node by
//! [`AdhesionSettings::node_acceleration`] (plus the share of a suspended body), and twice the load
//! of the bond in the last step. A load must therefore more than double within a step, from 200
//! m/s² on, to break a bond that σ would hold.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::contact::settings::{AdhesionSettings, ContactSettings};
use crate::contact::step_bodies::{StepBodies, StepBody};
use crate::contact::workspace::ContactWorkspace;
use crate::scene::Adhesion;
use crate::sheet::node_contact::{half_thickness, solves_node_by_node};
use crate::sheet::{Sheet, bonds};

const SETTINGS: AdhesionSettings = ContactSettings::DEFAULT.adhesion;

/// Adhesion strength at a point of the sheet, Pa; 0 if it is too cold. `stuck` selects the
/// lower temperature limit of existing bonds.
fn strength(sheet: &Sheet, point: &SheetPoint, stuck: bool) -> f64 {
    let Some(Adhesion { strength, above, lets_go_below }) = sheet.tack() else { return 0.0 };
    let celsius: f64 = point.terms().map(|(i, w)| w * bonds::celsius(sheet, i)).sum();
    let holds = stuck && lets_go_below.is_none_or(|limit| celsius >= limit);
    if celsius >= above || holds { strength } else { 0.0 }
}

/// Call `push` for every bond force of `sheets` on a dynamic body, with the body's index, force
/// (N) and point in its frame (m).
pub(crate) fn on_bodies(sheets: &[Sheet], mut push: impl FnMut(u32, DVec3, DVec3)) {
    for stuck in sheets.iter().filter_map(|sheet| sheet.state.adhesion.as_ref()) {
        stuck.on_bodies.iter().for_each(|(body, force, at)| push(*body, *force, *at));
    }
}

/// Update the bonds of the sheets of an island after a step: count the contacts of every node, then
/// bond the closed contacts that are warm enough. `solved` holds the contacts of the solver, if it
/// ran, and maps the island's body indices to indices in `around`.
pub(crate) fn update_bonds(sheets: &mut [Sheet], solved: Option<(&ContactWorkspace, &[u32])>, around: &StepBodies) {
    if !sheets.iter().any(|sheet| sheet.tack().is_some()) {
        return;
    }
    for sheet in sheets.iter_mut() {
        let masses = sheet.node_count();
        sheet.state.adhesion.get_or_insert_default().begin(masses);
    }
    if let Some((workspace, _)) = solved {
        workspace.for_each_closed(|contact, _| {
            if let Some((sheet, mass, _)) = node_contact(contact)
                && let Some(stuck) = &mut sheets[sheet as usize].state.adhesion
            {
                stuck.has_contact(mass, towards(contact));
                stuck.is_solved[mass as usize] |= other_body(contact).is_some();
            }
        });
    }
    sheets.iter_mut().filter_map(|sheet| sheet.state.adhesion.as_mut()).for_each(|stuck| stuck.count_node_contacts());
    if let Some((workspace, bodies)) = solved {
        bond_solved_contacts(sheets, workspace, around, bodies);
    }
    sheets.iter_mut().for_each(bond_node_contacts);
}

/// Bond the closed contacts of the solver.
fn bond_solved_contacts(sheets: &mut [Sheet], workspace: &ContactWorkspace, around: &StepBodies, bodies: &[u32]) {
    let mut suspension = Suspension { workspace, around, bodies, last: (u32::MAX, 0.0) };
    workspace.for_each_closed(|contact, _| {
        let Some((sheet, mass, _)) = node_contact(contact) else { return };
        let Some(force) = bond_force(sheets, contact, &mut suspension) else { return };
        let is_pair = other_sheet(contact).is_some() || dynamic_body(contact, bodies, around).is_some();
        let is_explicit = solves_node_by_node(&sheets[sheet as usize]);
        if !(is_explicit && is_pair) {
            apply_bond(sheets, contact, force, bodies, around);
        }
        if let Some(stuck) = &mut sheets[sheet as usize].state.adhesion {
            stuck.set_bonded(mass);
            if is_explicit && is_pair {
                let side = stuck.side(mass, towards(contact));
                stuck.pair_force[mass as usize][side] += force;
            }
        }
    });
}

/// Bond the contacts of single nodes with kinematic and static bodies, as far as the solver did not
/// solve them too.
fn bond_node_contacts(sheet: &mut Sheet) {
    let Some(mut stuck) = sheet.state.adhesion.take() else { return };
    for k in 0..stuck.node_contacts.len() {
        let contact = stuck.node_contacts[k];
        let i = contact.node;
        let most_stress = strength(sheet, &SheetPoint::node(i), stuck.was_bonded[i as usize]);
        let gap = -sheet.state.x.get(i as usize).dot(contact.towards) - contact.level;
        let is_open = gap > ContactSettings::DEFAULT.closed_gap_at_end * half_thickness(sheet);
        if stuck.is_solved[i as usize] || is_open || most_stress <= 0.0 {
            continue;
        }
        let parts = f64::from(stuck.contacts(i, contact.towards).max(1));
        let before = stuck.previous_bond_force.get(i as usize).length() / parts;
        let load = load_of((contact.force, contact.towards, contact.friction), before);
        let need = unloaded_acceleration(sheet) * sheet.node_mass(i as usize) / parts;
        let need = need.max(SETTINGS.maximum_load_growth * load);
        let force = need.min(most_stress * sheet.area_of(i) / parts);
        stuck.bond_force.add(i as usize, contact.towards * force);
        stuck.set_bonded(i);
    }
    sheet.state.adhesion = Some(stuck);
}

/// Force of the bond that a closed contact becomes, N: the force that may be needed, bounded by the
/// adhesion strength. `None` if the contact does not bond.
fn bond_force(sheets: &[Sheet], contact: &ContactConstraint, suspension: &mut Suspension) -> Option<f64> {
    let (sheet, mass, point) = node_contact(contact)?;
    let own = &sheets[sheet as usize];
    let stuck = own.state.adhesion.as_ref()?;
    let was = stuck.was_bonded[mass as usize];
    let (mut most_stress, mut share) = (strength(own, &point, was), 1.0);
    if let Some((other, place)) = other_sheet(contact) {
        let other = &sheets[other as usize];
        most_stress = most_stress.max(strength(other, &place, was));
        // This contact also represents nodes of the other sheet that have no contact of their own.
        let has_no_contact =
            |i: u32| other.state.adhesion.as_ref().is_some_and(|s| s.contacts(i, -towards(contact)) == 0);
        share = 0.5 * (1.0 + place.terms().filter(|(i, _)| has_no_contact(*i)).map(|(_, w)| w).sum::<f64>());
    }
    if most_stress <= 0.0 {
        return None;
    }
    let mut need = unloaded_acceleration(own) * own.node_mass(mass as usize);
    if let Some(load) = suspension.load_of_body(contact) {
        need += load;
    }
    let parts = f64::from(stuck.contacts(mass, towards(contact)).max(1));
    let is_pull = contact.bond > 0.0;
    let before = if is_pull { contact.bond } else { stuck.previous_bond_force.get(mass as usize).length() / parts };
    let mut contact_force = suspension.workspace.force_of(&contact.key).unwrap_or(DVec3::ZERO);
    if solves_node_by_node(own) {
        // The response of the node alone came first; the solver's force acts on displacements.
        let drift = own.engine_kind.info().drift;
        contact_force /= if drift > 0.0 { drift } else { 1.0 };
        contact_force += contact.normal * contact.bond;
        if other_body(contact).is_some() {
            contact_force += stuck.node_force.get(mass as usize) * towards(contact).dot(-contact.normal);
        }
    }
    let load = load_of((contact_force, contact.normal, contact.friction), before);
    need = (need / parts).max(SETTINGS.maximum_load_growth * load);
    Some(need.min(most_stress * share * own.area_of(mass) / parts))
}

/// Acceleration of a node that a bond bears without an earlier load, m/s².
fn unloaded_acceleration(sheet: &Sheet) -> f64 {
    let dt = sheet.state.adhesion.as_ref().map_or(0.0, |stuck| stuck.substep);
    if dt > 0.0 {
        SETTINGS.node_acceleration.min(SETTINGS.node_displacement / (dt * dt))
    } else {
        SETTINGS.node_acceleration
    }
}

/// Dynamic bodies of an island that may be suspended from bonds.
struct Suspension<'a> {
    workspace: &'a ContactWorkspace,
    around: &'a StepBodies,
    /// Index in `around` of each body of the island.
    bodies: &'a [u32],
    /// Body of the last call, and its number of closed contacts.
    last: (u32, f64),
}

impl Suspension<'_> {
    /// Share of a contact in the load of its suspended body, N; `None` without a dynamic body.
    fn load_of_body(&mut self, contact: &ContactConstraint) -> Option<f64> {
        let body = other_body(contact)?;
        let (_, over) = dynamic_body(contact, self.bodies, self.around)?;
        if self.last.0 != body {
            let mut contacts = 0.0;
            self.workspace.for_each_closed(|c, _| contacts += if other_body(c) == Some(body) { 1.0 } else { 0.0 });
            self.last = (body, contacts);
        }
        Some(SETTINGS.body_acceleration * over.start.mass() / f64::max(self.last.1, 1.0))
    }
}

/// Load of a bond in the step, N, given the contact force (N), its normal and friction coefficient,
/// and the bond force `force`: its tension, plus the normal force that its friction requires.
fn load_of((contact_force, normal, friction): (DVec3, DVec3, f64), force: f64) -> f64 {
    let across = contact_force.dot(normal).abs();
    let along = contact_force.reject_from_normalized(normal).length();
    let for_friction = if friction > 0.0 { along / friction } else { 0.0 };
    (force - across).max(0.0) + for_friction
}

/// Pull the two sides of a contact together with `force` (N).
fn apply_bond(sheets: &mut [Sheet], contact: &ContactConstraint, force: f64, bodies: &[u32], around: &StepBodies) {
    let Some((owner, ..)) = node_contact(contact) else { return };
    for (side, sign) in [(&contact.a, -force), (&contact.b, force)] {
        let push = contact.normal * sign;
        match side {
            ContactSide::Sheet { sheet, point } => {
                let Some(stuck) = &mut sheets[*sheet as usize].state.adhesion else { continue };
                for (i, w) in point.terms() {
                    stuck.bond_force.set(i as usize, stuck.bond_force.get(i as usize) + push * w);
                }
            }
            ContactSide::Body { local, .. } => {
                if let Some(stuck) = &mut sheets[owner as usize].state.adhesion
                    && let Some((index, _)) = dynamic_body(contact, bodies, around)
                {
                    stuck.on_bodies.push((index, push, *local));
                }
            }
        }
    }
}

/// Sheet, node and point of a contact of one node with a body or triangle; `None` for other
/// contacts.
pub(crate) fn node_contact(contact: &ContactConstraint) -> Option<(u32, u32, SheetPoint)> {
    let single = |side: &ContactSide| match side {
        ContactSide::Sheet { sheet, point } if point.weights[0] == 1.0 => Some((*sheet, point.nodes[0], *point)),
        _ => None,
    };
    single(&contact.a).or_else(|| single(&contact.b))
}

/// Direction from the node of a contact to its other side.
pub(crate) fn towards(contact: &ContactConstraint) -> DVec3 {
    let of_a = matches!(contact.a, ContactSide::Sheet { point, .. } if point.weights[0] == 1.0);
    if of_a { -contact.normal } else { contact.normal }
}

/// The other sheet of a sheet-sheet contact, with the contact point on it.
pub(crate) fn other_sheet(contact: &ContactConstraint) -> Option<(u32, SheetPoint)> {
    let (sheet, mass, own) = node_contact(contact)?;
    [contact.a, contact.b].into_iter().find_map(|side| match side {
        ContactSide::Sheet { sheet: other, point } if (other, point) != (sheet, own) => {
            Some((other, point)).filter(|_| other != sheet || point.nodes[0] != mass)
        }
        _ => None,
    })
}

/// Index in the island of the body of a contact, if it has one.
pub(crate) fn other_body(contact: &ContactConstraint) -> Option<u32> {
    [contact.a, contact.b].into_iter().find_map(|side| match side {
        ContactSide::Body { body, .. } => Some(body),
        ContactSide::Sheet { .. } => None,
    })
}

/// The dynamic body of a contact, with its index in `around`, if it has one. `bodies` holds the
/// index of each body of the island.
fn dynamic_body<'a>(
    contact: &ContactConstraint,
    bodies: &[u32],
    around: &'a StepBodies,
) -> Option<(u32, &'a StepBody)> {
    let index = *bodies.get(other_body(contact)? as usize)?;
    let body = around.bodies.get(index as usize)?;
    body.start.is_dynamic().then_some((index, body))
}
