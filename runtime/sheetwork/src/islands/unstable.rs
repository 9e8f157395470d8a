//! Unstable sheets: the test after a step, and the stop or freeze that follows.

use crate::islands::StepContext;
use crate::islands::contact_log::ContactLog;
use crate::islands::event::{EventKind, InstabilityReport, RecoveryAction};
use crate::islands::settings::{InstabilitySettings, StepSettings};
use crate::sheet::{Sheet, Status, fracture, stage};

const SETTINGS: InstabilitySettings = StepSettings::DEFAULT.instability;

/// Whether a sheet is faster or larger than any motion of it can make it, or its step diverged.
pub(crate) fn is_unstable(sheet: &Sheet) -> bool {
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
pub(crate) fn stop_unstable(sheet: &mut Sheet, touches: &mut ContactLog, context: &StepContext, dt: f64) {
    let alarm = InstabilityReport::new(sheet, context.field.gravity, dt);
    sheet.state.x.copy_from(&sheet.work.x_before);
    if sheet.recovery.is_some() && sheet.state.x.max_squared().is_finite() {
        freeze(sheet, touches, context.time, alarm);
        return;
    }
    sheet.state.v.clear();
    let (mass, place) = (alarm.mass, sheet.state.x.get(alarm.mass as usize));
    sheet.state.status = Status::Unstable { time: context.time, mass, place, speed: alarm.speed_m_s };
    touches.report_instability(context.time, EventKind::Unstable, alarm);
}

/// Freeze a sheet until one of its parameters changes, and report the event.
pub(crate) fn freeze(sheet: &mut Sheet, touches: &mut ContactLog, time: f64, alarm: InstabilityReport) {
    sheet.state.v.clear();
    stage::restart_engine(sheet);
    sheet.state.status = Status::Frozen { time };
    touches.report_instability(
        time,
        EventKind::Contained,
        InstabilityReport { handled: RecoveryAction::Frozen, ..alarm },
    );
}
