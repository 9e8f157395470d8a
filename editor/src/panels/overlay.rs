//! Overlay on the scene: tools, marks of fixed nodes and contacts, gizmo, grab with its force, and
//! a frame during playback.

use bevy_egui::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, UiBuilder, vec2};
use glam::{Vec2, Vec3};
use sheetwork::QueryFilter;

use bevy_sheetwork::inspector::controls::{CELSIUS, ControlOptions, DEGREES, MM, number};

use super::plots::COLOURS;
use super::style::ACCENT;
use super::tool::handle_of;
use super::{EditorState, Held, Tool};
use crate::gizmo::{Gizmo, Handle};
use crate::pick;
use crate::session::{Item, Session};
use crate::units::format_si;

/// Colours of the axes.
const AXES: [Color32; 3] =
    [Color32::from_rgb(230, 80, 70), Color32::from_rgb(110, 190, 80), Color32::from_rgb(80, 140, 240)];
const PIN: Color32 = Color32::from_rgb(70, 130, 250);
const TOUCH: Color32 = Color32::from_rgb(255, 205, 60);

/// Draw the overlay into `whole` and into the tiles of the compared worlds.
pub(super) fn paint(ui: &mut Ui, (whole, tiles): (Rect, &[Rect]), session: &mut Session, state: &mut EditorState) {
    let painter = ui.painter_at(whole);
    for (which, tile) in tiles.iter().enumerate() {
        let Some(one) = session.shown(which) else { continue };
        let (painter, camera) = (ui.painter_at(*tile), state.camera);
        let seen =
            |p: Vec3| camera.project(p, Vec2::new(tile.width(), tile.height())).map(|v| tile.min + vec2(v.x, v.y));
        masses(&painter, one, state, &seen);
        normals(&painter, one, state, &seen);
    }
    names(&painter, session, tiles);
    rim(&painter, whole, session);
    hands(ui, tiles.first().copied().unwrap_or(whole), session, state);
    tools(ui, whole, session, state);
    corner(&painter, whole, state);
}

/// A coloured frame shows that edits act on a running world.
fn rim(painter: &Painter, rect: Rect, session: &Session) {
    if session.playing() {
        painter.rect_filled(rect, 0.0, ACCENT.gamma_multiply(0.035));
        painter.rect_stroke(rect, 0.0, Stroke::new(3.0, ACCENT.gamma_multiply(0.9)), StrokeKind::Inside);
    }
}

/// Marks of the tools.
fn hands(ui: &Ui, rect: Rect, session: &Session, state: &EditorState) {
    let painter = ui.painter_at(rect);
    let seen =
        |p: Vec3| state.camera.project(p, Vec2::new(rect.width(), rect.height())).map(|v| rect.min + vec2(v.x, v.y));
    if state.tool == Tool::Move {
        items(&painter, session, state, &seen);
        gizmo(&painter, rect, session, state);
    }
    hand(&painter, session, &seen);
    creases(&painter, session, state, &seen);
    line(&painter, session, state, &seen);
    ring(ui, &painter, session, state, rect);
}

/// Marks of fixed nodes and of nodes in contact.
fn masses(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    let pins = state.display.pins || state.tool == Tool::Pin;
    if !pins && !state.display.contacts {
        return;
    }
    let alpha = session.alpha();
    for (sheet, before) in session.world().sheets().iter().zip(session.before()) {
        for i in 0..sheet.node_count().min(before.len()) {
            let held = pins && sheet.is_held(i);
            let touches = state.display.contacts && sheet.touching().get(i).copied().unwrap_or(false);
            if !held && !touches {
                continue;
            }
            let Some(at) = seen(before.get(i).lerp(sheet.state.x.get(i), alpha).as_vec3()) else { continue };
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

/// Normals of the displayed layer, out of its upper side.
fn normals(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    if !state.display.normals {
        return;
    }
    for sheet in session.world().sheets() {
        let surface = state.display.layer.index(sheet).and_then(|layer| sheet.surface(layer, 1));
        let Some(surface) = surface else { continue };
        let mesh = surface.mesh(&sheet.state.x);
        let length = sheet.spacing().map_or(1e-3, |(shortest, _)| 0.6 * shortest) as f32;
        for (place, normal) in mesh.positions.iter().zip(&mesh.normals) {
            let (from, normal) = (Vec3::from(*place), Vec3::from(*normal));
            if let Some((a, b)) = seen(from).zip(seen(from + length * normal)) {
                painter.line_segment([a, b], Stroke::new(1.2, AXES[2]));
            }
        }
    }
}

/// Marks of items that can be moved.
fn items(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    for item in session.items() {
        let Some(at) = handle_of(session, item).and_then(seen) else { continue };
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
    let Some(gizmo) = handle_of(session, item).and_then(|place| Gizmo::new(place, &state.camera, size)) else { return };
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
    if let Some((_, by)) = session.moved_item().filter(|c| c.0 == item) {
        let mm = by * 1e3;
        text = format!("{text}  ({:+.1}, {:+.1}, {:+.1}) mm", mm.x, mm.y, mm.z);
        if let Item::Body(index) = item
            && session.has_left_start(index)
        {
            text += ", in this run";
        }
    }
    label(painter, at(gizmo.middle) + vec2(0.0, 18.0), &text, Align2::CENTER_TOP);
}

/// Spring of the grab, and its force.
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
    // Light on dark, visible on any sheet.
    let coil: Vec<Pos2> = coil.collect();
    painter.add(Shape::line(coil.clone(), Stroke::new(4.0, Color32::from_rgb(30, 32, 36))));
    painter.add(Shape::line(coil, Stroke::new(1.8, Color32::WHITE)));
    painter.circle(from, 4.0, ACCENT, Stroke::new(1.0, Color32::WHITE));
    painter.circle(to, 5.0, Color32::TRANSPARENT, Stroke::new(2.0, Color32::WHITE));
    let (force, apart) = (hand.force.length(), (hand.target - hand.point).length());
    let text = format!("{}  over {}", format_si(force, "N"), format_si(apart, "m"));
    label(painter, to + vec2(12.0, -12.0), &text, Align2::LEFT_BOTTOM);
}

/// Line that is being drawn on a sheet, and its length.
fn line(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    let Some(Held::Line(index, from, to)) = state.held else { return };
    let Some(sheet) = session.world().sheets().get(index) else { return };
    let points = on_sheet(session, index, (from, to), state, seen);
    painter.add(Shape::line(points.clone(), Stroke::new(4.0, Color32::from_rgb(30, 32, 36))));
    painter.add(Shape::line(points.clone(), Stroke::new(2.0, Color32::WHITE)));
    let size = sheet.rest_size();
    let length = ((to.0 - from.0) * size.0).hypot((to.1 - from.1) * size.1);
    if let Some(end) = points.last() {
        label(painter, *end + vec2(10.0, -10.0), &format_si(length, "m"), Align2::LEFT_BOTTOM);
    }
}

/// Creases of the sheets, while the crease tool is chosen: a crease is not visible before the first
/// step.
fn creases(painter: &Painter, session: &Session, state: &EditorState, seen: &dyn Fn(Vec3) -> Option<Pos2>) {
    if state.tool != Tool::Crease {
        return;
    }
    for (sheet, spec) in session.scene().sheets.iter().enumerate() {
        for crease in &spec.creases {
            let points = on_sheet(session, sheet, (crease.from, crease.to), state, seen);
            painter.extend(Shape::dashed_line(&points, Stroke::new(3.0, Color32::from_rgb(30, 32, 36)), 7.0, 5.0));
            painter.extend(Shape::dashed_line(&points, Stroke::new(1.5, ACCENT), 7.0, 5.0));
            if let Some(end) = points.last() {
                label(painter, *end + vec2(8.0, 8.0), &format!("{:.0}°", crease.angle), Align2::LEFT_TOP);
            }
        }
    }
}

/// Straight line in material coordinates, projected from the sheet.
fn on_sheet(
    session: &Session,
    sheet: usize,
    (from, to): ((f64, f64), (f64, f64)),
    state: &EditorState,
    seen: &dyn Fn(Vec3) -> Option<Pos2>,
) -> Vec<Pos2> {
    let Some(id) = session.world().sheet_ids().nth(sheet) else { return Vec::new() };
    let queries = session.world().queries(QueryFilter { layer: state.display.layer.into(), sheet: Some(id) });
    let at = |s: f64| queries.point_at(id, (from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1)));
    (0..=32).filter_map(|i| seen(at(f64::from(i) / 32.0)?.position.as_vec3())).collect()
}

/// Outline of the brush on the sheet under the mouse.
fn ring(ui: &Ui, painter: &Painter, session: &Session, state: &EditorState, rect: Rect) {
    let pointer = ui.input(|i| i.pointer.hover_pos()).filter(|p| state.tool == Tool::Heat && rect.contains(*p));
    let Some(pointer) = pointer else { return };
    let size = Vec2::new(rect.width(), rect.height());
    let ray = state.camera.ray(Vec2::new(pointer.x - rect.left(), pointer.y - rect.top()), size);
    let layer = state.display.layer.into();
    let Some(hit) = pick::sheet(session.world(), ray, layer) else { return };
    let (Some(sheet), Some(id)) = (session.world().sheets().get(hit.sheet), session.world().sheet_ids().nth(hit.sheet))
    else {
        return;
    };
    let queries = session.world().queries(QueryFilter { layer, sheet: Some(id) });
    let (radius, extent) = (state.brush_radius(session, hit.sheet), sheet.rest_size());
    let points = (0..=48).filter_map(|i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 48.0).sin_cos();
        let uv = (hit.uv.0 + radius * cos / extent.0, hit.uv.1 + radius * sin / extent.1);
        let place = queries.point_at(id, (uv.0.clamp(0.0, 1.0), uv.1.clamp(0.0, 1.0)))?.position;
        state.camera.project(place.as_vec3(), size).map(|v| rect.min + vec2(v.x, v.y))
    });
    painter.add(Shape::line(points.collect(), Stroke::new(2.0, Color32::WHITE)));
}

/// Names of the compared worlds.
fn names(painter: &Painter, session: &Session, tiles: &[Rect]) {
    let others = session.variants().filter_map(|(variant, found)| Some((variant.label(), found.ok()?)));
    let all = std::iter::once(("this scene".to_owned(), session)).chain(others);
    if tiles.len() < 2 {
        return;
    }
    for (which, ((name, one), tile)) in all.zip(tiles).enumerate() {
        // Below the tools, in its colour of plots and tables.
        let at = tile.center_top() + vec2(0.0, if tile.top() < tiles[0].top() + 1.0 { 62.0 } else { 12.0 });
        let galley = painter.layout_no_wrap(name, FontId::proportional(13.0), Color32::from_gray(240));
        let rect = Align2::CENTER_TOP.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(vec2(8.0, 3.0)), 4.0, Color32::from_rgba_unmultiplied(24, 26, 30, 215));
        let line = [rect.left_bottom() + vec2(0.0, 1.0), rect.right_bottom() + vec2(0.0, 1.0)];
        painter.line_segment(line, Stroke::new(2.0, COLOURS[which % COLOURS.len()]));
        painter.galley(rect.min, galley, Color32::from_gray(240));
        if let Some(time) = one.unstable_since() {
            mark(painter, at + vec2(0.0, 25.0), &format!("✖ unstable since {time:.3} s"));
        }
    }
}

/// Instability of a world, below its name.
fn mark(painter: &Painter, at: Pos2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), Color32::WHITE);
    let rect = Align2::CENTER_TOP.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand2(vec2(5.0, 2.0)), 4.0, Color32::from_rgb(190, 40, 30));
    painter.galley(rect.min, galley, Color32::WHITE);
}

/// Text on a background, readable over anything.
fn label(painter: &Painter, at: Pos2, text: &str, align: Align2) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), Color32::from_gray(240));
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand2(vec2(5.0, 2.0)), 4.0, Color32::from_rgba_unmultiplied(24, 26, 30, 205));
    painter.galley(rect.min, galley, Color32::from_gray(240));
}

/// Row of tools in the upper left corner.
fn tools(ui: &mut Ui, rect: Rect, session: &mut Session, state: &mut EditorState) {
    let place = Rect::from_min_size(rect.left_top() + vec2(10.0, 10.0), vec2(330.0, 56.0));
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
        options(ui, session, state);
    });
}

/// Options of the chosen tool.
fn options(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let size = session.world().sheets().get(state.sheet).map_or((0.1, 0.1), |s| s.rest_size());
    if !matches!(state.tool, Tool::Heat | Tool::Crease) {
        return;
    }
    let brush = &mut state.brush;
    ui.horizontal(|ui| match state.tool {
        Tool::Heat => {
            let row = ("to", "Painted temperature, °C", "brush");
            let done = number(ui, session, row, brush.celsius, CELSIUS, &ControlOptions::speed(1.0));
            brush.celsius = done.value.unwrap_or(brush.celsius).clamp(-273.15, 5000.0);
            let about = "Radius of the brush, of which the inner half is painted fully. A double click takes a twelfth of the sheet";
            let (row, wide) = (("radius", about, "brush"), brush.radius_on(size));
            let done = number(ui, session, row, wide, MM, &ControlOptions::speed(0.1));
            brush.radius = if done.reset { None } else { done.value.map(|v| v.clamp(1e-6, 1e3)).or(brush.radius) };
        }
        Tool::Crease => {
            let about = "Rest angle of the crease; positive angles raise the sides towards the upper side";
            let row = ("by", about, "crease");
            let done = number(ui, session, row, brush.angle, DEGREES, &ControlOptions::speed(0.5));
            brush.angle = done.value.unwrap_or(brush.angle).clamp(-175.0, 175.0);
        }
        _ => {}
    });
}

/// World axes in the lower right corner.
fn corner(painter: &Painter, rect: Rect, state: &EditorState) {
    if rect.width() < 200.0 || rect.height() < 200.0 {
        return;
    }
    let middle = rect.right_bottom() + vec2(-42.0, -42.0);
    let (right, up) = state.camera.axes();
    for ((axis, name), colour) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(["x", "y", "z"]).zip(AXES) {
        let end = middle + vec2(axis.dot(right), -axis.dot(up)) * 26.0;
        painter.line_segment([middle, end], Stroke::new(2.0, colour));
        let at = end + (end - middle) * 0.25;
        painter.text(at, Align2::CENTER_CENTER, name, FontId::proportional(11.0), colour);
    }
}
