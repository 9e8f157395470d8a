//! View of the scene: action of the mouse with each tool, and the overlay.

use bevy_egui::egui::{self, PointerButton, Rect, Response, Sense, Ui};
use glam::Vec2;
use sheetwork::scene::SpotSpec;

use super::tool::handle_of;
use super::{EditorState, Held, Tool, keys, legend, overlay};
use crate::camera::Camera;
use crate::gizmo::Gizmo;
use crate::pick;
use crate::session::{Item, Session};
use crate::tiles::tiles;

/// Points of scrolling per notch of the wheel.
const NOTCH: f32 = 50.0;

/// Bisection steps of the search for the edge of a sheet, and distance in material coordinates
/// within which a line snaps to the edge.
const BISECTIONS: u32 = 14;
const EDGE: f64 = 0.01;
/// Maximum number of dabs of the brush per frame.
const MAX_DABS: u32 = 40;

/// Handle mouse and keys in the view: camera and tool. The scene itself is drawn behind it by the
/// Bevy layer.
pub fn view(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.interact(rect, ui.id().with("view"), Sense::click_and_drag());
    let blind = state.is_blind();
    // Tools act on the scene itself, not on its variants.
    let tiles = tiles(rect, session.shown_count());
    let own = tiles.first().copied().unwrap_or(rect);
    let taken = !blind && use_tool(ui, session, state, &response, own);
    if response.clicked() || response.dragged() {
        // The view takes the keyboard focus.
        ui.memory_mut(|m| m.stop_text_input());
        ui.ctx().memory_mut(|m| m.focused().into_iter().for_each(|id| m.surrender_focus(id)));
    }
    if response.dragged() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
    }
    if let Some(scale) = state.display.scale_of(session) {
        legend(&ui.painter_at(rect), rect, &scale);
    }
    if !blind {
        overlay::paint(ui, (rect, &tiles), session, state);
        keys::keys_and_drops(ui, session, state);
    }
    // After the overlay: the scene was drawn with the previous camera, and the overlay must match
    // it.
    navigate(ui, session, state, &response, (own, taken));
}

/// Rotate, pan and zoom the camera by the mouse, unless a tool has `taken` its left button.
fn navigate(ui: &Ui, session: &Session, state: &mut EditorState, response: &Response, (own, taken): (Rect, bool)) {
    let drag = Vec2::from(<[f32; 2]>::from(response.drag_delta()));
    if response.dragged_by(PointerButton::Primary) && !taken {
        match state.tool {
            Tool::Pan => state.camera.pan(drag, Vec2::new(own.width(), own.height())),
            Tool::Zoom => state.camera.zoom(drag.x / NOTCH),
            Tool::None => {}
            _ => state.camera.orbit(drag),
        }
    }
    if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
        state.camera.pan(drag, Vec2::new(own.width(), own.height()));
    }
    if response.hovered() {
        let scroll = ui.input(|i| i.smooth_scroll_delta.y);
        if scroll != 0.0 {
            state.camera.zoom(scroll / NOTCH);
        }
    }
    if response.double_clicked() && state.tool == Tool::Look {
        state.camera = Camera::from_session(session);
    }
}

/// Position in the picture of a position in the window.
fn within(rect: Rect, at: egui::Pos2) -> Vec2 {
    Vec2::new(at.x - rect.left(), at.y - rect.top())
}

/// Apply the tool. Returns whether it has taken the left button.
fn use_tool(ui: &Ui, session: &mut Session, state: &mut EditorState, response: &Response, rect: Rect) -> bool {
    let size = Vec2::new(rect.width(), rect.height());
    let pressed = ui.input(|i| i.pointer.press_origin()).filter(|p| rect.contains(*p)).map(|p| within(rect, p));
    let now = response.interact_pointer_pos().map(|p| within(rect, p));
    if response.drag_started_by(PointerButton::Primary)
        && let Some(from) = pressed
    {
        state.held = take(session, state, from, size);
    }
    if response.clicked_by(PointerButton::Primary)
        && let Some(at) = now.filter(|at| at.cmple(size).all())
    {
        click(session, state, at, size);
    }
    let Some(held) = state.held else { return false };
    // The position at release counts too: a slow frame may have missed the drag.
    if (response.dragged_by(PointerButton::Primary) || response.drag_stopped_by(PointerButton::Primary))
        && let Some(at) = now
    {
        match held {
            Held::Line(sheet, from, last) => {
                let under = hit(session, state, at, size).filter(|h| h.sheet == sheet).map(|h| h.uv);
                let to = under.or_else(|| towards(session, state, (sheet, last), (at, size)));
                state.held = Some(Held::Line(sheet, from, to.unwrap_or(last)));
            }
            Held::Brush(sheet, last) => {
                if let Some(place) = stroke(session, state, (sheet, last), (at, size)) {
                    state.held = Some(Held::Brush(sheet, place));
                }
            }
            Held::Sheet(place) => session.pull(state.camera.on_plane(at, size, place).as_dvec3()),
            Held::Handle(handle, gizmo, from) => {
                if let Some(item) = state.selected {
                    session.move_item(item, gizmo.moved(handle, from, at));
                }
            }
        }
    }
    if !response.dragged_by(PointerButton::Primary) {
        match (state.tool, state.held) {
            (Tool::Crease, Some(Held::Line(sheet, from, to))) => {
                _ = session.crease(sheet, (from, to), state.brush.angle)
            }
            (Tool::Cut, Some(Held::Line(sheet, from, to))) => _ = session.cut(sheet, (from, to)),
            _ => {}
        }
        session.end_stroke();
        session.release();
        session.release_item();
        session.seal();
        state.held = None;
    }
    true
}

/// Take hold of the object under the mouse.
fn take(session: &mut Session, state: &EditorState, from: Vec2, size: Vec2) -> Option<Held> {
    let ray = state.camera.ray(from, size);
    match state.tool {
        Tool::Look | Tool::Pin | Tool::Pan | Tool::Zoom | Tool::None => None,
        Tool::Grab => {
            let hit = pick::sheet(session.world(), ray, state.display.layer.into())?;
            let before = pick::body(session.world(), ray).is_none_or(|b| hit.distance <= b.1 * 1.001);
            (before && session.grab(hit.sheet, hit.uv)).then(|| Held::Sheet(hit.place.as_vec3()))
        }
        Tool::Crease | Tool::Cut => {
            let hit = hit(session, state, from, size)?;
            Some(Held::Line(hit.sheet, hit.uv, hit.uv))
        }
        Tool::Heat => {
            let hit = hit(session, state, from, size)?;
            (session.begin_stroke(hit.sheet) && dab(session, state, &hit)).then_some(Held::Brush(hit.sheet, hit.place))
        }
        Tool::Move => {
            let gizmo = Gizmo::new(handle_of(session, state.selected?)?, &state.camera, size)?;
            Some(Held::Handle(gizmo.handle_at(from)?, gizmo, from))
        }
    }
}

fn click(session: &mut Session, state: &mut EditorState, at: Vec2, size: Vec2) {
    let ray = state.camera.ray(at, size);
    match state.tool {
        Tool::Pin => {
            if let Some(hit) = pick::sheet(session.world(), ray, state.display.layer.into()) {
                session.toggle_pin(hit.sheet, hit.node);
            }
        }
        Tool::Move => {
            let marks = session.items().into_iter().filter_map(|item| {
                let seen = state.camera.project(handle_of(session, item)?, size)?;
                Some((seen.distance(at), item))
            });
            let near = marks.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|m| m.0 < 14.0).map(|m| m.1);
            let found = near.or_else(|| under(session, state, ray));
            if found.is_none() && pick::sheet(session.world(), ray, state.display.layer.into()).is_some() {
                session.note("A sheet is moved where it starts: Reset (Backspace) first.");
            }
            state.choose(found);
        }
        Tool::Heat => {
            if let Some(hit) = hit(session, state, at, size)
                && session.begin_stroke(hit.sheet)
            {
                dab(session, state, &hit);
                session.end_stroke();
            }
        }
        Tool::Look | Tool::Grab | Tool::Crease | Tool::Cut | Tool::Pan | Tool::Zoom | Tool::None => {}
    }
}

/// Nearest movable item along a ray.
fn under(session: &Session, state: &EditorState, ray: pick::Ray) -> Option<Item> {
    let world = session.world();
    let body = pick::body(world, ray).filter(|b| b.0 < session.scene().bodies.len());
    let sheet = pick::sheet(world, ray, state.display.layer.into()).filter(|_| world.steps() == 0);
    let heater = pick::heater(session.scene(), ray);
    let all = [
        body.map(|(index, distance)| (distance, Item::Body(index))),
        heater.map(|(index, distance)| (distance, Item::Heater(index))),
        sheet.map(|hit| (hit.distance, Item::Sheet(hit.sheet))),
    ];
    all.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)).map(|found| found.1)
}

/// Point of a sheet at a position of the view, unless a body occludes it.
fn hit(session: &Session, state: &EditorState, at: Vec2, size: Vec2) -> Option<pick::SheetHit> {
    let ray = state.camera.ray(at, size);
    let hit = pick::sheet(session.world(), ray, state.display.layer.into())?;
    pick::body(session.world(), ray).is_none_or(|b| hit.distance <= b.1 * 1.001).then_some(hit)
}

/// Last point of a sheet on the way from its point `last` to a position of the view outside it: a
/// line drawn past an edge ends at it.
fn towards(
    session: &Session,
    state: &EditorState,
    (sheet, last): (usize, (f64, f64)),
    (at, size): (Vec2, Vec2),
) -> Option<(f64, f64)> {
    let place = pick::place(session.world(), sheet, last, state.display.layer.into())?;
    let begun = state.camera.project(place.as_vec3(), size)?;
    let (mut found, mut low, mut high) = (None, 0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        match hit(session, state, begun.lerp(at, middle), size).filter(|h| h.sheet == sheet) {
            Some(hit) => (found, low) = (Some(hit.uv), middle),
            None => high = middle,
        }
    }
    let to_edge = |s: f64| {
        if s < EDGE {
            0.0
        } else if s > 1.0 - EDGE {
            1.0
        } else {
            s
        }
    };
    found.map(|(u, v)| (to_edge(u), to_edge(v)))
}

/// Paint with the brush from its last dab to a position of the view, in several dabs if far.
/// Returns the position of the last dab.
fn stroke(
    session: &mut Session,
    state: &EditorState,
    (sheet, last): (usize, glam::DVec3),
    (at, size): (Vec2, Vec2),
) -> Option<glam::DVec3> {
    // Dabs overlap enough for an even temperature.
    let apart = 0.3 * state.brush_radius(session, sheet);
    let end = hit(session, state, at, size).filter(|h| h.sheet == sheet && h.place.distance(last) > apart)?;
    let begun = state.camera.project(last.as_vec3(), size)?;
    let count = ((end.place.distance(last) / apart) as u32).clamp(1, MAX_DABS);
    for k in 1..count {
        let between = hit(session, state, begun.lerp(at, k as f32 / count as f32), size);
        if let Some(hit) = between.filter(|h| h.sheet == sheet) {
            dab(session, state, &hit);
        }
    }
    dab(session, state, &end);
    Some(end.place)
}

/// Heat the sheet under the brush.
fn dab(session: &mut Session, state: &EditorState, hit: &pick::SheetHit) -> bool {
    let radius = state.brush_radius(session, hit.sheet);
    session.dab(SpotSpec { at: hit.uv, radius, temperature: state.brush.celsius })
}
