//! One step of a sheet by an explicit integrator: the order of its phases.
//!
//!   move kinematic nodes → integrator → instability detector → contact and flexion limit
//!     → thickness limit
//!     → (again, where the integrator took less than the step)
//!     → contact with dynamic bodies and sharp edges ([`crate::islands::explicit`])
//!     → place kinematic nodes → sleep test

use rapier3d::prelude::ColliderHandle;

use crate::contact::SheetContact;
use crate::contact::node::bonding;
use crate::contact::node::detection::resolve_node_contact;
use crate::contact::node::drawn_contact::{DrawnContact, resolve_drawn_contact};
use crate::contact::node::flexion;
use crate::islands::contact_log::{ContactLog, ContactRecorder};
use crate::islands::resting::fall_asleep;
use crate::islands::settings::{InstabilitySettings, StepSettings};
use crate::islands::unstable::{is_unstable, stop_unstable};
use crate::islands::{StepContext, instability};
use crate::profiler::Phase;
use crate::sheet::forces::with_record;
use crate::sheet::{ForcePartner, Sheet, accelerations, node_contact};

const SETTINGS: InstabilitySettings = StepSettings::DEFAULT.instability;

/// Advance one sheet through `context.dt` with contact of its nodes with static and kinematic
/// bodies only. Used for sheets of explicit integrators and for sheets in their islands.
/// [`finish_step`] ends the step.
///
/// Returns the length of the last substep, s.
pub(crate) fn advance_free(
    sheet: &mut Sheet,
    contact: &mut SheetContact,
    touches: &mut ContactLog,
    context: &StepContext,
) -> f64 {
    node_contact::resize_workspace(sheet);
    DrawnContact::prepare(&mut contact.drawn, sheet);
    touches.begin(context.time);
    sheet.state.touching.fill(false);
    node_contact::save_start(sheet);
    let mut done = 0.0;
    let mut substeps = 0;
    let mut last = context.dt;
    let most = context.dt / f64::from(sheet.substeps_of_step(context.dt)) * (1.0 + 1e-12);
    // A rest below rounding error belongs to the last substep.
    while context.dt - done > context.dt * 1e-12 {
        let part = (context.dt - done).min(most);
        let Some(taken) = substep((sheet, contact, touches), context, done, part) else { break };
        last = taken;
        done += last;
        substeps += 1;
        if substeps > SETTINGS.maximum_adaptive_substeps {
            stop_unstable(sheet, touches, context, last);
            break;
        }
    }
    last
}

/// End the step of a sheet that touched no dynamic body: place pins, record touches, test for
/// sleep.
pub(crate) fn finish_step(sheet: &mut Sheet, touches: &mut ContactLog, context: &StepContext, last: f64) {
    if !sheet.pins.is_empty() {
        sheet.pins.prescribe_positions(context.time + context.dt, &mut sheet.state.x);
    }
    touches.end(context.time + context.dt, sheet);
    if context.sleep {
        fall_asleep(sheet, touches, context, last);
    }
}

/// Take one step of the integrator and apply limits, instability detector and contact. Returns the
/// time taken, s; `None` when the sheet is stopped for the rest of the step.
fn substep(
    (sheet, contact, touches): (&mut Sheet, &mut SheetContact, &mut ContactLog),
    context: &StepContext,
    done: f64,
    part: f64,
) -> Option<f64> {
    let time = context.time + done;
    if !sheet.pins.is_empty() {
        sheet.pins.prescribe_velocities(time, part, &sheet.state.x, &mut sheet.state.v);
    }
    sheet.work.x_before.copy_from(&sheet.state.x);
    sheet.work.v_before.copy_from(&sheet.state.v);
    let taken = match sheet.recovery {
        // The implicit step checks its own energy.
        Some(_) if node_contact::is_explicit(sheet) => instability::advance(sheet, touches, context, time, part)?,
        _ => accelerations::advance(sheet, context.field, time, part).elapsed,
    };
    if is_unstable(sheet) {
        stop_unstable(sheet, touches, context, taken);
        return None;
    }
    with_record(sheet, |forces, sheet| forces.begin_node_contact(&sheet.state.v));
    bonding::pull(sheet, taken);
    flexion::begin(sheet);
    if let Some(view) = context.view {
        let remaining = (context.dt - done - taken).max(0.0);
        let displaced = sheet.state.displaced;
        let mut recorder = ContactRecorder { touches, view };
        context.profiler.measure(Phase::Detection, || {
            let touched = &mut |collider| recorder.touched(collider);
            resolve_node_contact(sheet, &mut contact.clearance, view, (taken, remaining), touched);
            if let Some(drawn) = &mut contact.drawn {
                let met = &contact.clearance.node_surfaces;
                resolve_drawn_contact(sheet, drawn, met, view, ((taken, remaining), displaced), touched);
            }
        });
    } else {
        bonding::begin(sheet);
        bonding::release_unmet(sheet);
        flexion::hold_limit(sheet, &mut contact.clearance, None, (taken, 0.0), &mut |_| {});
    }
    with_record(sheet, |forces, sheet| {
        let nearest = &contact.clearance.nearest_face;
        forces.add_node_contact(sheet, |i| partner_of(nearest.get(i).filter(|_| sheet.state.touching[i]), context));
    });
    let is_held = sheet.parameters.flexion.limit.is_some() && sheet.work.flexion.is_coupled;
    if !is_held {
        apply_thickness_limit(sheet, taken);
    }
    Some(taken)
}

/// Apply the thickness limit after a step of `dt` (s).
pub(crate) fn apply_thickness_limit(sheet: &mut Sheet, dt: f64) {
    if let Some(limit) = &sheet.parameters.thickness_limit {
        if let Some(forces) = &mut sheet.work.forces {
            forces.begin_node_contact(&sheet.state.v);
        }
        limit.apply(&sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, &sheet.state.touching, dt);
        with_record(sheet, |forces, sheet| forces.add_limit(sheet));
    }
}

/// The body of the collider that a node touches.
fn partner_of(nearest: Option<&(ColliderHandle, u32)>, context: &StepContext) -> ForcePartner {
    let (Some(view), Some((collider, _))) = (context.view, nearest) else { return ForcePartner::None };
    match view.body_of(*collider) {
        Some(body) => ForcePartner::Body(body),
        None if view.colliders.contains(*collider) => ForcePartner::Collider(*collider),
        None => ForcePartner::None,
    }
}
