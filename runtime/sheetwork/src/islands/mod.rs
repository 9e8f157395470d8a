//! One step of a sheet: the order of its phases.
//!
//!   move kinematic nodes → integrator → flexion limit → instability detector → contact
//!     → thickness limit
//!     → (again, where the integrator took less than the step)
//!     → contact with dynamic bodies and sharp edges (`explicit`)
//!     → place kinematic nodes → sleep test
//!
//! Features that a scene does not use cost no call. The first step sizes the working arrays; later
//! steps allocate nothing here. Sheets that do not touch share no state, so any number of threads
//! gives the same result. Sheets of implicit integrators are stepped in `implicit_step`.

pub(crate) mod broad_phase;
pub(crate) mod energy_budget;
pub mod event;
pub(crate) mod explicit;
pub(crate) mod fallback;
pub(crate) mod implicit_step;
pub(crate) mod instability;
pub(crate) mod island_builder;
pub(crate) mod island_detection;
pub(crate) mod island_manager;
pub(crate) mod island_progress;
pub(crate) mod island_step;
pub(crate) mod rigid_motion;
pub(crate) mod settings;
pub mod step_report;
pub(crate) mod union_find;

use crate::contact::SheetContact;
use crate::contact::node::detection::resolve_node_contact;
use crate::islands::event::{ContactLog, ContactRecorder, EventKind, InstabilityReport, RecoveryAction};
use crate::islands::settings::{InstabilitySettings, StepSettings};
use crate::math::Vectors;
use crate::profiler::{Phase, Profiler};
use crate::rigid::RigidView;
use crate::scene::sleep::SLEEP;
use crate::sheet::{Sheet, Status, accelerations, creep, fracture, node_contact, stage};

pub use crate::sheet::Field;

const SETTINGS: InstabilitySettings = StepSettings::DEFAULT.instability;

/// Inputs of the step of a sheet.
#[derive(Clone, Copy)]
pub(crate) struct StepContext<'a> {
    pub field: Field,
    pub time: f64,
    pub dt: f64,
    pub view: Option<&'a RigidView<'a>>,
    pub sleep: bool,
    /// Whether contact between sheets is enabled.
    pub sheets_meet: bool,
    pub watch: &'a Profiler,
}

/// Advance one sheet through `stage.dt` with contact of its nodes with static and kinematic bodies
/// only. Used for sheets of explicit integrators and for sheets in their islands. [`finish_step`]
/// ends the step.
///
/// Returns the length of the last substep, s.
pub(crate) fn advance_free(
    sheet: &mut Sheet,
    contact: &mut SheetContact,
    touches: &mut ContactLog,
    stage: &StepContext,
) -> f64 {
    node_contact::resize_workspace(sheet);
    touches.begin(stage.time);
    sheet.state.touching.fill(false);
    node_contact::save_start(sheet);
    let mut done = 0.0;
    let mut substeps = 0;
    let mut last = stage.dt;
    let most = stage.dt / f64::from(sheet.substeps_of_step(stage.dt)) * (1.0 + 1e-12);
    // A rest below rounding error belongs to the last substep.
    while stage.dt - done > stage.dt * 1e-12 {
        let part = (stage.dt - done).min(most);
        let Some(taken) = substep((sheet, contact, touches), stage, done, part) else { break };
        last = taken;
        done += last;
        substeps += 1;
        if substeps > SETTINGS.maximum_adaptive_substeps {
            stop_unstable(sheet, touches, stage, last);
            break;
        }
    }
    last
}

/// End the step of a sheet that touched no dynamic body: place pins, record touches, test for
/// sleep.
pub(crate) fn finish_step(sheet: &mut Sheet, touches: &mut ContactLog, stage: &StepContext, last: f64) {
    if !sheet.pins.is_empty() {
        sheet.pins.prescribe_positions(stage.time + stage.dt, &mut sheet.state.x);
    }
    touches.end(stage.time + stage.dt, sheet);
    if stage.sleep {
        fall_asleep(sheet, touches, stage, last);
    }
}

/// Take one step of the integrator and apply limits, instability detector and contact. Returns the
/// time taken, s; `None` when the sheet is stopped for the rest of the step.
fn substep(
    (sheet, contact, touches): (&mut Sheet, &mut SheetContact, &mut ContactLog),
    stage: &StepContext,
    done: f64,
    part: f64,
) -> Option<f64> {
    let time = stage.time + done;
    if !sheet.pins.is_empty() {
        sheet.pins.prescribe_velocities(time, part, &sheet.state.x, &mut sheet.state.v);
    }
    sheet.work.x_before.copy_from(&sheet.state.x);
    sheet.work.v_before.copy_from(&sheet.state.v);
    let taken = match sheet.recovery {
        // The implicit step checks its own energy.
        Some(_) if node_contact::is_explicit(sheet) => instability::advance(sheet, touches, stage, time, part)?,
        _ => accelerations::advance(sheet, stage.field, time, part).elapsed,
    };
    if let Some(limit) = &sheet.parameters.flexion.limit {
        limit.apply(&sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, taken);
    }
    if is_unstable(sheet) {
        stop_unstable(sheet, touches, stage, taken);
        return None;
    }
    if let Some(view) = stage.view {
        let remaining = (stage.dt - done - taken).max(0.0);
        stage.watch.measure(Phase::Detection, || {
            resolve_node_contact(
                sheet,
                &mut contact.clearance,
                view,
                (taken, remaining),
                &mut ContactRecorder { touches, view },
            );
        });
    }
    if let Some(limit) = &sheet.parameters.thickness_limit {
        limit.apply(&sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, &sheet.state.touching, taken);
    }
    Some(taken)
}

fn is_unstable(sheet: &Sheet) -> bool {
    // The comparisons treat NaN as unstable.
    let slow = sheet.state.v.max_squared() < SETTINGS.maximum_speed * SETTINGS.maximum_speed;
    let most = SETTINGS.maximum_diagonal_ratio * sheet.model.initial_diagonal;
    let together = match sheet.open_cell_set() {
        None => sheet.state.x.bounds().is_some_and(|(low, high)| low.distance(high) < most),
        // Pieces of a fractured sheet may separate.
        Some(_) => fracture::is_intact_within(sheet, most),
    };
    sheet.work.stage.has_diverged || !(slow && together)
}

/// Stop a sheet that a step of `dt` (s) has made unstable: reset its positions to the start of the
/// step and report the event.
fn stop_unstable(sheet: &mut Sheet, touches: &mut ContactLog, stage: &StepContext, dt: f64) {
    let alarm = InstabilityReport::new(sheet, stage.field.gravity, dt);
    sheet.state.x.copy_from(&sheet.work.x_before);
    if sheet.recovery.is_some() && sheet.state.x.max_squared().is_finite() {
        freeze(sheet, touches, stage.time, alarm);
        return;
    }
    sheet.state.v.clear();
    let (mass, place) = (alarm.mass, sheet.state.x.get(alarm.mass as usize));
    sheet.state.status = Status::Unstable { time: stage.time, mass, place, speed: alarm.speed_m_s };
    touches.report_instability(stage.time, EventKind::Unstable, alarm);
}

/// Freeze a sheet until one of its parameters changes, and report the event.
fn freeze(sheet: &mut Sheet, touches: &mut ContactLog, time: f64, alarm: InstabilityReport) {
    sheet.state.v.clear();
    stage::restart_engine(sheet);
    sheet.state.status = Status::Frozen { time };
    touches.report_instability(
        time,
        EventKind::Contained,
        InstabilityReport { handled: RecoveryAction::Frozen, ..alarm },
    );
}

/// Put a resting sheet to sleep after the sleep delay. `last` is the length of the last substep, s.
fn fall_asleep(sheet: &mut Sheet, touches: &mut ContactLog, stage: &StepContext, last: f64) {
    // Sleeping requires a pin or a contact: a free sheet can drift slowly.
    let held = (!sheet.pins.is_empty() || touches.count() > 0) && !creep::is_creeping(sheet);
    if update_rest_time(sheet, held, (last, stage.dt)) {
        sheet.state.status = Status::Asleep;
        sheet.state.v.clear();
        touches.events.push((stage.time + stage.dt, EventKind::AtRest, None));
    }
}

/// Update the time for which a sheet has been resting, after a step of `dt` (s) with a last substep
/// of `last` (s). Resting requires `held`. Returns whether the sleep delay has passed.
fn update_rest_time(sheet: &mut Sheet, held: bool, (last, dt): (f64, f64)) -> bool {
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
