//! Flexion limit of a sheet in contact: the limit, contacts of nodes and further contacts of the
//! sheet are solved together ([`crate::elements::flexion_limit::solver`]).
//!
//! Detection has found the nodes whose free motion meets a body. The solve may move others into
//! one, or a node at a ridge from one of its faces into the next: these contacts are added and the
//! solve is repeated. Contact with dynamic bodies and with other sheets is not part of it.

use glam::DVec3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::{ColliderHandle, Real};

use crate::collision::constraint::ContactSide;
use crate::contact::IslandView;
use crate::contact::node::clearance::Clearance;
use crate::contact::node::response::{NodeContactSurface, NodeResponse};
use crate::contact::node::target::{NO_FACE, PathHit, StepTarget};
use crate::contact::settings::{ContactSettings, NodeContactSettings};
use crate::contact::workspace::ContactWorkspace;
use crate::elements::flexion_limit::solver::{FlexionSettings, LimitContact, LimitedStep, TripleImpulses};
use crate::elements::thickness_limit::ThicknessLimit;
use crate::rigid::RigidView;
use crate::sheet::{Sheet, SheetState, node_contact};

const SETTINGS: NodeContactSettings = ContactSettings::DEFAULT.node;

/// Begin the contact of a step: keep the free motion of a sheet with a limit.
pub(crate) fn begin(sheet: &mut Sheet) {
    let Sheet { work, state, inverse_mass, pins, parameters, .. } = sheet;
    let Some(limit) = &parameters.flexion.limit else { return };
    let work = &mut work.flexion;
    let cells = parameters.thickness_limit.as_ref().map_or(0, ThicknessLimit::len);
    work.reserve(state.x.len(), limit.triples.len(), cells);
    work.contacts.clear();
    work.free.0.clone_from(&state.x);
    work.free.1.clone_from(&state.v);
    if (state.flexion_impulses.triples.len(), state.flexion_impulses.cells.len()) != (limit.triples.len(), cells) {
        state.flexion_impulses.reset(limit.triples.len(), cells);
    }
    work.start_impulses.copy_from(&state.flexion_impulses);
    work.is_coupled = false;
    work.mobility.clear();
    work.mobility.extend(inverse_mass.iter().map(|w| DVec3::splat(*w)));
    for (node, _) in pins.fixed_axes() {
        work.mobility[node as usize] = pins.free_axes(node) * inverse_mass[node as usize];
    }
}

/// Record the contact of node `i` with `surface` and its response.
pub(crate) fn record(sheet: &mut Sheet, i: usize, surface: &NodeContactSurface, response: &NodeResponse) {
    if sheet.parameters.flexion.limit.is_some() {
        let rebounds = response.impact > 0.0;
        let contact = limit_contact(i, surface, node_contact::contact_offset(sheet));
        sheet.work.flexion.contacts.push(LimitContact { rebounds, ..contact });
    }
}

fn limit_contact(i: usize, surface: &NodeContactSurface, offset: f64) -> LimitContact {
    let level = surface.point.dot(surface.normal) + offset;
    let contact = LimitContact::of_node(i as u32, surface.normal, level);
    LimitContact { velocity: surface.velocity, friction: surface.friction, ..contact }
}

/// Hold the limit after the response of the nodes to contact in a step of `dt` (s): together with
/// contact and pins, or in the velocities alone where nothing holds the sheet. `remaining` and
/// `touched` are those of [`crate::contact::node::detection::resolve_node_contact`].
pub(crate) fn hold_limit(
    sheet: &mut Sheet,
    clearance: &mut Clearance,
    view: Option<&RigidView>,
    (dt, remaining): (f64, f64),
    touched: &mut dyn FnMut(ColliderHandle),
) {
    let Some(limit) = &sheet.parameters.flexion.limit else { return };
    sheet.work.flexion.dt = dt;
    if sheet.work.flexion.contacts.is_empty() && sheet.pins.is_empty() {
        limit.apply(&sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, dt);
        sheet.state.flexion_impulses.clear();
        return;
    }
    if !is_active(sheet) {
        return;
    }
    begin_solve(sheet);
    for _ in 0..=SETTINGS.maximum_corner_iterations {
        solve(sheet, dt);
        let Some(view) = view else { break };
        if !add_contacts(sheet, clearance, view, (dt, remaining), touched) {
            break;
        }
    }
    for i in 0..sheet.node_count() {
        if let Some(near) = clearance.nearest.get_mut(i).filter(|near| **near > 0.0) {
            *near = (*near - sheet.state.x.get(i).distance(sheet.work.flexion.free.0.get(i))).max(0.0);
        }
    }
}

/// Whether the limit may act: it did in the last step, or a triple is near it.
fn is_active(sheet: &Sheet) -> bool {
    let margin = FlexionSettings::DEFAULT.margin;
    let acted = sheet.work.flexion.start_impulses.triples.iter().any(|total| *total != TripleImpulses::default());
    acted || sheet.parameters.flexion.limit.as_ref().is_some_and(|limit| limit.is_near(&sheet.state.x, margin))
}

/// Set the motion without limit: the free motion of nodes in resting contact, whose response is the
/// start of their impulse, and the response of all others.
fn begin_solve(sheet: &mut Sheet) {
    let Sheet { work, state: SheetState { x, v, flexion_impulses, .. }, .. } = sheet;
    let work = &mut work.flexion;
    flexion_impulses.copy_from(&work.start_impulses);
    let (free_x, free_v) = &mut work.free;
    for k in 0..work.contacts.len() {
        let i = work.contacts[k].nodes[0] as usize;
        let is_first = work.contacts[..k].iter().all(|c| c.nodes[0] as usize != i);
        let rebounds = work.contacts.iter().any(|c| c.rebounds && c.nodes[0] as usize == i);
        if !is_first || rebounds {
            continue;
        }
        let (weight, contact) = (work.mobility[i].max_element(), &mut work.contacts[k]);
        if weight > 0.0 {
            let impulse = (v.get(i) - free_v.get(i)) / weight;
            let pressing = impulse.dot(contact.normal);
            contact.impulse = (pressing.max(0.0), impulse - contact.normal * pressing);
        }
        x.set(i, free_x.get(i));
        v.set(i, free_v.get(i));
    }
    free_x.clone_from(x);
    free_v.clone_from(v);
}

/// Solve limit and contacts of a step of `dt` (s) from the motion without limit.
fn solve(sheet: &mut Sheet, dt: f64) {
    let drift = sheet.engine.drift(dt).unwrap_or(sheet.engine_kind.info().drift);
    let Sheet { work, state: SheetState { x, v, flexion_impulses, .. }, parameters, .. } = sheet;
    let Some(limit) = &parameters.flexion.limit else { return };
    let free = std::mem::take(&mut work.flexion.free);
    let step = LimitedStep { start: &work.x_before, free: (&free.0, &free.1), dt, drift };
    let limits = (limit, parameters.thickness_limit.as_ref());
    work.flexion.solve(limits, &step, (x, v), flexion_impulses);
    work.flexion.free = free;
    work.flexion.is_coupled = true;
}

/// Add the contacts into which the solve has moved nodes. Returns whether there were any.
fn add_contacts(
    sheet: &mut Sheet,
    clearance: &mut Clearance,
    view: &RigidView,
    (dt, remaining): (f64, f64),
    touched: &mut dyn FnMut(ColliderHandle),
) -> bool {
    let offset = node_contact::contact_offset(sheet);
    let Some((low, high)) = sheet.state.x.bounds() else { return false };
    let around = Aabb::new(low.as_vec3(), high.as_vec3()).loosened(2.0 * offset as Real);
    let before = sheet.work.flexion.contacts.len();
    for (handle, collider) in view.query_fixed().intersect_aabb_conservative(around) {
        let target = StepTarget::new(handle, collider, view, sheet, dt, remaining);
        for i in 0..sheet.node_count() {
            let (start, free, end) =
                (sheet.work.x_before.get(i), sheet.work.flexion.free.0.get(i), sheet.state.x.get(i));
            if sheet.inverse_mass[i] == 0.0 || clearance.is_clear(i, end, free, offset) {
                continue;
            }
            let (a, b) = (target.start.local_point(start).as_vec3(), target.end.local_point(end).as_vec3());
            let (near, known) = clearance.nearest_face[i];
            let mut face = if near == handle { known } else { NO_FACE };
            let PathHit::Surface(surface) = target.test_path(a, b, 0.0, &mut face) else { continue };
            let depth = offset - (end - surface.point).dot(surface.normal);
            let is_known = |c: &LimitContact| {
                c.count == 1 && c.nodes[0] as usize == i && c.normal.dot(surface.normal) > SETTINGS.same_face_cosine
            };
            if depth > 0.1 * offset && !sheet.work.flexion.contacts.iter().any(is_known) {
                sheet.work.flexion.contacts.push(limit_contact(i, &surface, offset));
                sheet.state.touching[i] = true;
                sheet.state.counters.contacts += 1;
                clearance.nearest[i] = 0.0;
                touched(handle);
            }
        }
    }
    sheet.work.flexion.contacts.len() > before
}

/// Hold the limits of the sheets of `island` again after a contact solve of `dt` (s) that found
/// contacts of edges, faces and the sheet with itself. A sheet that touches a dynamic body or
/// another sheet keeps the result of that solve.
pub(crate) fn hold_limits_with_contacts(island: &mut IslandView, workspace: &ContactWorkspace, dt: f64) {
    for number in 0..island.sheets.len() {
        let sheet = &island.sheets[number];
        // A sheet that took several substeps has been held in each of them.
        let work = &sheet.work.flexion;
        if sheet.parameters.flexion.limit.is_none() || work.dt != dt {
            continue;
        }
        if !(work.is_coupled || work.contacts.is_empty() && is_active(sheet)) {
            continue;
        }
        let mut contacts = std::mem::take(&mut island.sheets[number].work.flexion.contacts);
        let nodes = contacts.len();
        let is_alone = append_contacts(island, workspace, number as u32, dt, &mut contacts);
        let sheet = &mut island.sheets[number];
        let has_more = contacts.len() > nodes;
        sheet.work.flexion.contacts = contacts;
        if is_alone && has_more {
            sheet.state.flexion_impulses.copy_from(&sheet.work.flexion.start_impulses);
            solve(sheet, dt);
        }
    }
}

/// Append the contacts of sheet `number` with kinematic and static bodies and with itself. Returns
/// whether it touches nothing else.
fn append_contacts(
    island: &IslandView,
    workspace: &ContactWorkspace,
    number: u32,
    dt: f64,
    contacts: &mut Vec<LimitContact>,
) -> bool {
    let drift = island.sheet(number).engine_kind.info().drift;
    let is_own = |side: &ContactSide| matches!(side, ContactSide::Sheet { sheet, .. } if *sheet == number);
    for ((detected, gap), _) in workspace.measured_contacts() {
        if !is_own(&detected.a) && !is_own(&detected.b) {
            continue;
        }
        let mut contact = LimitContact { friction: detected.friction, level: detected.offset, ..Default::default() };
        let sign = if is_own(&detected.a) { 1.0 } else { -1.0 };
        contact.normal = detected.normal * sign;
        let mut is_supported = true;
        for (side, sign) in [(&detected.a, sign), (&detected.b, -sign)] {
            match side {
                ContactSide::Sheet { point, .. } if is_own(side) => {
                    point.terms().for_each(|(node, weight)| contact.add_term(node, sign * weight));
                }
                ContactSide::Sheet { .. } => is_supported = false,
                ContactSide::Body { body, local } => {
                    let state = &island.solver_bodies[*body as usize].free;
                    let place = state.world_point(*local);
                    contact.level += place.dot(contact.normal);
                    contact.velocity = state.velocity_at(place);
                    is_supported &= !state.is_dynamic();
                }
            }
        }
        if is_supported {
            let force = workspace.cache.of(&detected.key).map_or(DVec3::ZERO, |f| f.position) * sign;
            let pressing = force.dot(contact.normal).max(0.0);
            let impulse = force * (dt / drift);
            contact.impulse = (pressing * dt / drift, impulse - contact.normal * impulse.dot(contact.normal));
            contacts.push(contact);
        } else if *gap < ContactSettings::DEFAULT.closed_gap_at_end * workspace.half_thickness {
            return false;
        }
    }
    true
}
