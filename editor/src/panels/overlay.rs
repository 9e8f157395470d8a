//! What is drawn over the scene: the tools, what is held and touched, the gizmo, the hand and its force, and a rim while it plays.

use bevy_egui::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, UiBuilder, pos2, vec2,
};
use glam::{DVec3, Vec2, Vec3};

use super::style::ACCENT;
use super::view::{Held, place_of};
use super::{EditorState, Tool};
use crate::gizmo::{Gizmo, Handle};
use crate::session::Session;
use crate::units::format_si;

/// Colours of the axes.
const AXES: [Color32; 3] =
    [Color32::from_rgb(230, 80, 70), Color32::from_rgb(110, 190, 80), Color32::from_rgb(80, 140, 240)];
const PIN: Color32 = Color32::from_rgb(70, 130, 250);
const TOUCH: Color32 = Color32::from_rgb(255, 205, 60);

/// Draws it all.
pub(super) fn paint(ui: &mut Ui, rect: Rect, session: &Session, state: &mut EditorState) {
    let painter = ui.painter_at(rect);
    let seen =
        |p: Vec3| state.camera.project(p, Vec2::new(rect.width(), rect.height())).map(|v| rect.min + vec2(v.x, v.y));
    if session.playing() {
        // Seen at a glance: what is changed now is changed while it runs.
        painter.rect_filled(rect, 0.0, ACCENT.gamma_multiply(0.035));
        painter.rect_stroke(rect, 0.0, Stroke::new(3.0, ACCENT.gamma_multiply(0.9)), StrokeKind::Inside);
    }
    masses(&painter, session, state, &seen);
    if state.tool == Tool::Move {
        items(&painter, session, state, &seen);
        gizmo(&painter, rect, session, state);
    }
    hand(&painter, session, &seen);
    names(&painter, session, &seen);
    tools(ui, rect, state);
    corner(&painter, rect, state);
}

/// Masses that are held, and those that touch something.
fn masses(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    let pins = state.display.pins || state.tool == Tool::Pin;
    if !pins && !state.display.contacts {
        return;
    }
    let alpha = session.alpha();
    for (sheet, before) in session.world().sheets().iter().zip(session.before()) {
        for i in 0..sheet.masses().min(before.len()) {
            let held = pins && sheet.is_held(i);
            let touches = state.display.contacts && sheet.touching().get(i).copied().unwrap_or(false);
            if !held && !touches {
                continue;
            }
            let Some(at) = seen(before.get(i).lerp(sheet.x.get(i), alpha).as_vec3()) else { continue };
            if held {
                let corners =
                    vec![at + vec2(0.0, -5.0), at + vec2(4.5, 0.0), at + vec2(0.0, 5.0), at + vec2(-4.5, 0.0)];
                painter.add(Shape::convex_polygon(corners, PIN, Stroke::new(1.0, Color32::WHITE)));
            } else {
                painter.circle(at, 2.5, TOUCH, Stroke::new(0.5, Color32::BLACK));
            }
        }
    }
}

/// Marks of what can be moved.
fn items(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    for item in session.items() {
        let Some(at) = place_of(session, item).and_then(seen) else { continue };
        let chosen = state.selected == Some(item);
        let colour = if chosen { ACCENT } else { Color32::from_gray(240) };
        painter.circle(at, 5.0, colour.gamma_multiply(0.55), Stroke::new(1.5, colour));
        if !chosen {
            label(painter, at + vec2(9.0, -7.0), &session.name_of(item), Align2::LEFT_CENTER);
        }
    }
}

fn gizmo(painter: &Painter, rect: Rect, session: &Session, state: &EditorState) {
    let Some(item) = state.selected else { return };
    let size = Vec2::new(rect.width(), rect.height());
    let Some(gizmo) = place_of(session, item).and_then(|place| Gizmo::new(place, &state.camera, size)) else { return };
    let at = |v: Vec2| rect.min + vec2(v.x, v.y);
    let taken = match state.held {
        Some(Held::Handle(handle, ..)) => Some(handle),
        _ => None,
    };
    for axis in 0..3 {
        let width = if taken == Some(Handle::Axis(axis)) { 5.0 } else { 3.0 };
        let (from, to) = (at(gizmo.middle), at(gizmo.ends[axis]));
        painter.line_segment([from, to], Stroke::new(width, AXES[axis]));
        let along = (to - from).normalized();
        let across = vec2(-along.y, along.x);
        let head = vec![to + along * 11.0, to + across * 5.5, to - across * 5.5];
        painter.add(Shape::convex_polygon(head, AXES[axis], Stroke::NONE));
    }
    let square = Rect::from_center_size(at(gizmo.middle), vec2(11.0, 11.0));
    painter.rect(square, 2.0, ACCENT, Stroke::new(1.0, Color32::WHITE), StrokeKind::Middle);
    let mut text = session.name_of(item);
    if let Some((_, by)) = session.carried().filter(|c| c.0 == item) {
        let mm = by * 1e3;
        text = format!("{text}  ({:+.1}, {:+.1}, {:+.1}) mm", mm.x, mm.y, mm.z);
    }
    label(painter, at(gizmo.middle) + vec2(0.0, 18.0), &text, Align2::CENTER_TOP);
}

/// The spring from the sheet to the mouse, and what it pulls with.
fn hand(painter: &Painter, session: &Session, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    let Some(hand) = session.hand() else { return };
    let (Some(from), Some(to)) = (seen(hand.point.as_vec3()), seen(hand.target.as_vec3())) else { return };
    let length = from.distance(to);
    let (along, turns) = ((to - from) / length.max(1e-3), 9.0);
    let across = vec2(-along.y, along.x);
    let coil = (0..=72).map(|i| {
        let s = i as f32 / 72.0;
        let swing = (s * turns * std::f32::consts::TAU).sin() * 5.0 * (std::f32::consts::PI * s).sin();
        from + along * (length * s) + across * swing
    });
    // Light on dark, to be seen before any sheet.
    let coil: Vec<Pos2> = coil.collect();
    painter.add(Shape::line(coil.clone(), Stroke::new(4.0, Color32::from_rgb(30, 32, 36))));
    painter.add(Shape::line(coil, Stroke::new(1.8, Color32::WHITE)));
    painter.circle(from, 4.0, ACCENT, Stroke::new(1.0, Color32::WHITE));
    painter.circle(to, 5.0, Color32::TRANSPARENT, Stroke::new(2.0, Color32::WHITE));
    let (force, apart) = (hand.force.length(), (hand.target - hand.point).length());
    let text = format!("{}  over {}", format_si(force, "N"), format_si(apart, "m"));
    label(painter, to + vec2(12.0, -12.0), &text, Align2::LEFT_BOTTOM);
}

/// What each of the worlds that are compared is.
fn names(painter: &Painter, session: &Session, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    let others = session.beside().filter(|b| b.1.is_ok()).map(|b| b.0.label());
    let all: Vec<String> = std::iter::once("this scene".to_owned()).chain(others).collect();
    if all.len() < 2 {
        return;
    }
    let Some((low, high)) = crate::camera::content(session.world()) else { return };
    let above = Vec3::new(0.5 * (low.x + high.x), high.y + 0.12 * (high - low).max_element(), 0.5 * (low.z + high.z));
    for (which, name) in all.iter().enumerate() {
        if let Some(at) = seen(above + session.offset(which)) {
            label(painter, at, name, Align2::CENTER_BOTTOM);
        }
    }
}

/// Text on a plate, so that it can be read over anything.
fn label(painter: &Painter, at: Pos2, text: &str, align: Align2) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), Color32::from_gray(240));
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand2(vec2(5.0, 2.0)), 4.0, Color32::from_rgba_unmultiplied(24, 26, 30, 205));
    painter.galley(rect.min, galley, Color32::from_gray(240));
}

/// The row of tools in the upper left corner.
fn tools(ui: &mut Ui, rect: Rect, state: &mut EditorState) {
    let place = Rect::from_min_size(rect.left_top() + vec2(10.0, 10.0), vec2(300.0, 28.0));
    if rect.width() < place.width() {
        return;
    }
    let mut row = ui.new_child(UiBuilder::new().max_rect(place).id_salt("tools"));
    let frame = bevy_egui::egui::Frame::new()
        .fill(row.visuals().panel_fill.gamma_multiply(0.92))
        .corner_radius(5.0)
        .inner_margin(4.0);
    frame.show(&mut row, |ui| {
        ui.horizontal(|ui| {
            for (tool, title, about) in Tool::ALL {
                ui.selectable_value(&mut state.tool, tool, title).on_hover_text(about);
            }
        });
    });
}

/// The world's axes in the lower right corner.
fn corner(painter: &Painter, rect: Rect, state: &EditorState) {
    if rect.width() < 200.0 || rect.height() < 200.0 {
        return;
    }
    let middle = rect.right_bottom() + vec2(-42.0, -42.0);
    let (right, up) = state.camera.axes();
    for (axis, name) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(["x", "y", "z"]).map(|(a, n)| (a.as_vec3(), n)) {
        let end = middle + vec2(axis.dot(right), -axis.dot(up)) * 26.0;
        let colour = AXES[["x", "y", "z"].iter().position(|n| *n == name).unwrap_or(0)];
        painter.line_segment([middle, end], Stroke::new(2.0, colour));
        painter.text(
            pos2(end.x, end.y) + (end - middle) * 0.25,
            Align2::CENTER_CENTER,
            name,
            FontId::proportional(11.0),
            colour,
        );
    }
}
