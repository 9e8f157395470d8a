//! Rest and sleep of a sheet: how long it has been resting, and the test for sleep.
//!
//! A sheet rests while each node is slower than the sleep speed, or has moved by less than the
//! sleep displacement since the rest began ([`crate::scene::sleep`]). Times in s.

use crate::islands::StepContext;
use crate::islands::contact_log::ContactLog;
use crate::math::Vectors;
use crate::scene::sleep::SLEEP;
use crate::sheet::{Sheet, Status, creep};

/// Put a resting sheet to sleep after the sleep delay. `last` is the length of the last substep, s.
pub(crate) fn fall_asleep(sheet: &mut Sheet, touches: &ContactLog, context: &StepContext, last: f64) {
    // Sleeping requires a pin or a contact: a free sheet can drift slowly.
    let held = (!sheet.pins.is_empty() || touches.count() > 0) && !creep::is_creeping(sheet);
    if update_rest_time(sheet, held, (last, context.dt)) {
        sheet.state.status = Status::Asleep;
        sheet.state.v.clear();
    }
}

/// Update the time for which a sheet has been resting, after a step of `dt` (s) with a last substep
/// of `last` (s). Resting requires `held`. Returns whether the sleep delay has passed.
pub(crate) fn update_rest_time(sheet: &mut Sheet, held: bool, (last, dt): (f64, f64)) -> bool {
    if !held || !(is_speed_small(sheet, last) || is_displacement_small(sheet)) {
        sheet.state.rest_time = 0.0;
        return false;
    }
    if sheet.state.rest_time == 0.0 {
        sheet.state.rest_positions.clone_from(&sheet.work.x_before);
    }
    sheet.state.rest_time += dt;
    sheet.state.rest_time >= SLEEP.delay
}

/// Whether the displacement of every node since the start of the rest, or since the start of the
/// step, is below the sleep displacement threshold.
fn is_displacement_small(sheet: &Sheet) -> bool {
    let before = if sheet.state.rest_time > 0.0 { &sheet.state.rest_positions } else { &sheet.work.x_before };
    before.len() == sheet.node_count()
        && is_displacement_below(
            &sheet.state.x,
            before,
            SLEEP.displacement.min(SLEEP.displacement_of_small * sheet.model.initial_diagonal),
        )
}

/// Whether every node moved more slowly than
/// [`SleepSettings::speed`](crate::scene::sleep::SleepSettings::speed), measured by displacement.
/// Next to nodes in contact, a multi-stage integrator can rest with a residual velocity that each
/// step cancels.
fn is_speed_small(sheet: &Sheet, dt: f64) -> bool {
    is_displacement_below(&sheet.state.x, &sheet.work.x_before, SLEEP.speed * dt)
}

fn is_displacement_below(now: &Vectors, before: &Vectors, most: f64) -> bool {
    (0..now.len()).all(|i| now.get(i).distance_squared(before.get(i)) < most * most)
}
