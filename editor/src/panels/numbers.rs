//! Live numbers: energies, speed, contacts, events.

use bevy_egui::egui::{Color32, Grid, Pos2, Rect, RichText, Sense, Shape, Stroke, Ui, vec2};
use bevy_sheetwork::inspector::ParameterAccess;
use sheetwork::islands::event::{Event, EventKind};
use sheetwork::sheet::Status;

use super::style::{ELASTIC, GRAVITY, KINETIC, TOTAL, quiet, readable};
use crate::samples::Sample;
use crate::session::{HISTORY, Session};
use crate::units::format_si;

/// Maximum number of listed events.
const MAX_EVENTS: usize = 12;

/// Numbers of the present state of the session.
pub fn numbers(ui: &mut Ui, session: &Session) {
    ui.add_space(4.0);
    ui.strong("Energy");
    energies(ui, last(session));
    ui.separator();
    ui.strong("Speed of the simulation");
    Grid::new("timing").num_columns(2).show(ui, |ui| timing(ui, session));
    ui.separator();
    ui.strong("Sheets");
    Grid::new("sheets").num_columns(2).show(ui, |ui| counts(ui, session));
    ui.separator();
    if session.world().sheets().iter().any(|s| s.delivered_stiffness(session.world().dt()).is_some()) {
        ui.strong("Stiffness");
        stiffness(ui, session);
        ui.separator();
    }
    ui.strong("Events");
    events(ui, session);
}

fn row(ui: &mut Ui, name: &str, value: impl Into<RichText>) {
    ui.label(RichText::new(name).color(quiet(ui)));
    ui.label(value.into().monospace());
    ui.end_row();
}

/// Last samples up to the displayed one; after a rollback there are later ones.
fn last(session: &Session) -> &[Sample] {
    let now = session.world().time() + 0.5 * session.world().dt();
    let end = session.history().partition_point(|s| s.time <= now);
    let past = &session.history()[..end];
    &past[past.len().saturating_sub(HISTORY)..]
}

fn energies(ui: &mut Ui, history: &[Sample]) {
    let now = history.last().cloned().unwrap_or_default();
    Grid::new("energies").num_columns(2).show(ui, |ui| {
        let rows = [
            ("kinetic", KINETIC, now.kinetic),
            ("elastic", ELASTIC, now.elastic),
            ("potential", GRAVITY, now.gravity),
            ("total", TOTAL, now.total()),
        ];
        for (name, colour, value) in rows {
            ui.label(RichText::new(name).color(readable(ui, colour)));
            ui.monospace(format_si(value, "J"));
            ui.end_row();
        }
    });
    graph(ui, history);
}

/// Colour and value of a line.
type Line = (Color32, fn(&Sample) -> f64);

/// Energies of the last samples; potential and total energy relative to their minimum.
fn graph(ui: &mut Ui, history: &[Sample]) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 76.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    if history.len() < 2 {
        return;
    }
    let lines: [Line; 4] =
        [(TOTAL, Sample::total), (GRAVITY, |e| e.gravity), (ELASTIC, |e| e.elastic), (KINETIC, |e| e.kinetic)];
    // The zero of the potential energy is arbitrary: lines are scaled to the changes.
    let lowest = history.iter().map(|e| e.gravity).fold(f64::INFINITY, f64::min);
    let base = [lowest, lowest, 0.0, 0.0];
    let values = |k: usize| history.iter().map(move |e| lines[k].1(e) - base[k]);
    let top = (0..4).flat_map(values).fold(1e-15, f64::max);
    for (k, (colour, _)) in lines.iter().enumerate() {
        let points = values(k).enumerate().map(|(i, value)| {
            let x = i as f32 / (history.len() - 1) as f32;
            point(rect, x, (value / top).clamp(-0.1, 1.0) as f32)
        });
        painter.add(Shape::line(points.collect(), Stroke::new(1.3, *colour)));
    }
}

fn point(rect: Rect, x: f32, y: f32) -> Pos2 {
    let inner = rect.shrink(4.0);
    Pos2::new(inner.left() + x * inner.width(), inner.bottom() - y * inner.height())
}

fn timing(ui: &mut Ui, session: &Session) {
    let timing = session.timing();
    let none = || "-".to_owned();
    let step = if timing.step_s > 0.0 { format_si(timing.step_s, "s") } else { none() };
    row(ui, "step time", step);
    row(ui, "real time", session.real_time_factor().map_or_else(none, |f| format!("{f:.1}×")));
    row(ui, "steps per frame", timing.steps.to_string());
    row(ui, "steps", session.world().steps().to_string());
    if timing.lost_s > 0.0 {
        let text = RichText::new(format!("{:.2} s", timing.lost_s));
        // Time lost in an earlier slow moment is not a warning.
        let slow = session.real_time_factor().is_some_and(|factor| factor < session.speed());
        row(ui, "time lost", if slow { text.color(ui.visuals().warn_fg_color) } else { text });
    }
}

fn counts(ui: &mut Ui, session: &Session) {
    let sheets = session.world().sheets();
    row(ui, "simulated", format!("{:.3} s", session.world().time()));
    row(ui, "nodes", sheets.iter().map(|s| s.node_count()).sum::<usize>().to_string());
    row(ui, "springs", sheets.iter().map(|s| s.springs().len()).sum::<usize>().to_string());
    row(ui, "contacts", session.contacts().to_string());
    row(ui, "max speed", format_si(sheets.iter().map(|s| s.max_speed()).fold(0.0, f64::max), "m/s"));
    row(ui, "penetration", format_si(session.penetration().iter().copied().fold(0.0, f64::max), "m"));
    let resting = sheets.iter().filter(|s| s.state.status == Status::Asleep).count();
    row(ui, "asleep", format!("{resting} of {}", sheets.len()));
}

/// Delivered and requested stiffness of each sheet: "delivers 2.98 GPa of 3.00 GPa"; sheets
/// with equal values share a line.
fn stiffness(ui: &mut Ui, session: &Session) {
    let world = session.world();
    let mut said: Vec<(String, String, Vec<&str>)> = Vec::new();
    for sheet in world.sheets() {
        let Some(found) = sheet.delivered_stiffness(world.dt()) else { continue };
        let text = format!("delivers {} of {}", format_si(found.bends_as_pa, "Pa"), format_si(found.asked_pa, "Pa"));
        let percent = |part: f64| format!("{:.2} %", 100.0 * part);
        let about = format!(
            "Delivered fractions of the material's stiffness: structure {}, grid {} for the present shape, time step {} for the \
             present motion. Damping ratios of the present wave: integrator {}, material {}.",
            percent(found.structure),
            percent(found.grid),
            percent(found.step),
            percent(found.numerical_damping_ratio),
            percent(found.material_damping_ratio),
        );
        match said.iter_mut().find(|(same, ..)| *same == text) {
            Some((.., names)) => names.push(&sheet.name),
            None => said.push((text, about, vec![&sheet.name])),
        }
    }
    for (text, about, names) in said {
        if world.sheets().len() > 1 {
            let others = if names.len() > 1 { format!(" and {} more", names.len() - 1) } else { String::new() };
            ui.label(RichText::new(format!("{}{others}", names[0])).color(quiet(ui))).on_hover_text(names.join(", "));
        }
        ui.label(RichText::new(text).monospace().size(10.5)).on_hover_text(about);
    }
}

fn events(ui: &mut Ui, session: &Session) {
    if session.events().next().is_none() {
        ui.weak("nothing yet");
    }
    for event in session.events().rev().take(MAX_EVENTS) {
        ui.horizontal_wrapped(|ui| {
            ui.monospace(format!("{:7.3}", event.time_s));
            ui.label(describe(event));
        });
    }
}

pub(super) fn describe(event: &Event) -> String {
    let what = match event.kind {
        EventKind::FirstContact => "touches",
        EventKind::SlidOff => "slides off",
        EventKind::Flat => "lies flat on",
        EventKind::AtRest => "comes to rest",
        EventKind::Woke => "wakes",
        EventKind::Unstable => "becomes unstable",
        EventKind::Contained => "is stabilised by the recovery policy",
        EventKind::GivenUp => "moves by a fallback: contact did not converge",
        EventKind::Penetration => "penetrates",
        EventKind::Crossing => "interpenetrates another sheet until they separate",
        EventKind::Recovered => "has recovered",
        EventKind::Buckled => "buckles",
        EventKind::Resampled => "changes to another grid",
        EventKind::Torn if event.opening.is_some_and(|o| o.melted) => "melts",
        EventKind::Torn => "tears",
    };
    match (&event.body, event.grid) {
        (Some(body), _) => format!("{} {what} {body}", event.sheet),
        (None, Some((nx, nz))) => format!("{} {what}, {nx} × {nz}", event.sheet),
        (None, None) => format!("{} {what}", event.sheet),
    }
}
