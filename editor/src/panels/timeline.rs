//! Timeline below the view: present time, range of the run, events, and numbered snapshots.

use bevy_egui::egui::{Align2, Color32, FontId, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};
use sheetwork::islands::event::EventKind;

use super::EditorState;
use super::numbers::describe;
use super::style::{ACCENT, KINETIC, quiet};
use crate::session::Session;

/// Height of the strip, points.
const HEIGHT: f32 = 30.0;

/// The strip, and a row of controls.
pub fn timeline(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.add_space(3.0);
    strip(ui, session);
    ui.horizontal(|ui| {
        ui.toggle_value(&mut state.plots.shown, "Plots").on_hover_text("Energies, step time, heights and temperatures");
        let mut looped = session.looped();
        let about = format!("Restart after {} s, the duration of the scene", session.scene().duration);
        if ui.checkbox(&mut looped, "Loop").on_hover_text(about).changed() {
            session.set_looped(looped);
        }
        slots(ui, session);
        let line = session.timeline();
        if session.playback().is_none() {
            let text = format!("{} moments, {:.1} MB", line.len(), line.bytes() as f64 / 1e6);
            let about = "Snapshots for rollback. When memory is full, every second one of the older half is dropped.";
            ui.label(RichText::new(text).color(quiet(ui))).on_hover_text(about);
        }
    });
    ui.add_space(2.0);
}

/// Numbered snapshots: a click stores an empty one and restores a stored one.
fn slots(ui: &mut Ui, session: &mut Session) {
    ui.label(RichText::new("Snapshots").color(quiet(ui)));
    ui.spacing_mut().item_spacing.x = 2.0;
    for (i, kept) in session.snapshot_times().into_iter().enumerate() {
        let number = i + 1;
        let about = match kept {
            Some(time) => format!("Restore {time:.3} s ({number}); Ctrl+{number} or a right click replaces it"),
            None => format!("Store a snapshot (Ctrl+{number})"),
        };
        let response = ui.selectable_label(kept.is_some(), number.to_string()).on_hover_text(about);
        if response.secondary_clicked() || (response.clicked() && kept.is_none()) {
            session.store_snapshot(number);
        } else if response.clicked() {
            session.restore_snapshot(number);
        }
    }
    ui.spacing_mut().item_spacing.x = 7.0;
}

fn strip(ui: &mut Ui, session: &mut Session) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
    let (first, last, now) = match session.playback() {
        Some(recording) => (0.0, recording.duration(), recording.at()),
        None => {
            let (first, last) = session.timeline().span().unwrap_or((0.0, 0.0));
            (first, last.max(session.world().time()), session.world().time())
        }
    };
    // A short run is shown on a longer scale.
    let end = last.max(first + 1.0).max(if session.playing() { last * 1.1 } else { last });
    let end = if session.playback().is_some() { last.max(1e-9) } else { end };
    let inner = rect.shrink2(vec2(10.0, 0.0));
    let x = |time: f64| inner.left() + inner.width() * (((time - first) / (end - first)) as f32).clamp(0.0, 1.0);
    let visuals = ui.visuals().clone();
    let painter = ui.painter_at(rect);
    let track = Rect::from_min_max(pos2(inner.left(), rect.top() + 4.0), pos2(inner.right(), rect.top() + 14.0));
    painter.rect_filled(track, 3.0, visuals.extreme_bg_color);
    painter.rect_filled(
        Rect::from_min_max(track.min, pos2(x(last), track.max.y)),
        3.0,
        visuals.widgets.inactive.bg_fill,
    );
    painter.rect_filled(Rect::from_min_max(track.min, pos2(x(now), track.max.y)), 3.0, ACCENT.gamma_multiply(0.75));
    ticks(ui, first, end, &x, track.bottom());
    let mut under = None;
    let pointer = response.hover_pos();
    for event in session.timeline().events() {
        let at = pos2(x(event.time_s), track.center().y);
        let colour = colour_of(event.kind);
        painter.add(Shape::convex_polygon(
            vec![at + vec2(0.0, -5.0), at + vec2(4.0, 0.0), at + vec2(0.0, 5.0), at + vec2(-4.0, 0.0)],
            colour,
            Stroke::NONE,
        ));
        if pointer.is_some_and(|p| (p.x - at.x).abs() < 5.0) {
            under = Some(format!("{:.3} s: {}", event.time_s, describe(event)));
        }
    }
    for time in session.snapshot_times().into_iter().flatten() {
        painter.line_segment([pos2(x(time), track.top()), pos2(x(time), track.bottom())], Stroke::new(1.5, KINETIC));
    }
    let hand = x(now);
    painter.line_segment(
        [pos2(hand, rect.top() + 1.0), pos2(hand, track.bottom() + 3.0)],
        Stroke::new(2.0, visuals.strong_text_color()),
    );
    // The position at release counts too: a slow frame may have missed the drag.
    if (response.dragged() || response.drag_stopped() || response.clicked())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let part = f64::from((pointer.x - inner.left()) / inner.width()).clamp(0.0, 1.0);
        session.scrub(first + part * (end - first));
    }
    let about = "Drag to go back to a snapshot, one per drawn frame; the arrow keys go step by step; marks are events";
    // A tooltip would obstruct the drag.
    if !response.dragged() {
        response.on_hover_text(under.unwrap_or_else(|| about.to_owned()));
    }
}

fn ticks(ui: &Ui, first: f64, end: f64, x: &dyn Fn(f64) -> f32, below: f32) {
    let step = nice((end - first) / 8.0);
    let mut time = (first / step).ceil() * step;
    let colour = ui.visuals().weak_text_color();
    while time <= end + 1e-9 {
        let text = format!("{} s", (time * 1e6).round() / 1e6);
        ui.painter().line_segment([pos2(x(time), below), pos2(x(time), below + 3.0)], Stroke::new(1.0, colour));
        ui.painter().text(pos2(x(time), below + 3.0), Align2::CENTER_TOP, text, FontId::proportional(10.0), colour);
        time += step;
    }
}

/// Smallest 1, 2, 5 or 10 times a power of ten that is not below `value`.
pub(super) fn nice(value: f64) -> f64 {
    let power = 10.0_f64.powf(value.max(1e-12).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|n| *n >= 0.999 * value).unwrap_or(power)
}

fn colour_of(kind: EventKind) -> Color32 {
    match kind {
        EventKind::FirstContact | EventKind::SlidOff | EventKind::Flat | EventKind::Resampled => {
            Color32::from_rgb(95, 170, 235)
        }
        EventKind::AtRest | EventKind::Woke | EventKind::Recovered => Color32::from_rgb(140, 200, 120),
        EventKind::Unstable | EventKind::Torn => Color32::from_rgb(240, 80, 70),
        EventKind::Buckled
        | EventKind::Contained
        | EventKind::GivenUp
        | EventKind::Crossing
        | EventKind::Penetration => Color32::from_rgb(240, 190, 70),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn marks_are_at_round_times() {
        for (value, round) in [(0.013, 0.02), (0.1, 0.1), (0.3, 0.5), (7.0, 10.0), (0.0, 1e-12)] {
            assert!((super::nice(value) / round - 1.0_f64).abs() < 1e-9, "{value}");
        }
    }
}
