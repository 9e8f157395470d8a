//! The part of the window that shows the scene: what the mouse does there.

use bevy_egui::egui::{self, PointerButton, Sense, Ui};
use glam::Vec2;

use super::{EditorState, legend, top};
use crate::camera::Camera;
use crate::session::Session;

/// Points of scrolling in a notch of the wheel.
const NOTCH: f32 = 50.0;

/// Turns, slides and nears the camera by what the mouse does in the view, and takes the keys. The view itself is drawn by
/// others, behind this.
pub fn view(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.interact(rect, ui.id().with("view"), Sense::click_and_drag());
    let drag = Vec2::from(<[f32; 2]>::from(response.drag_delta()));
    if response.dragged_by(PointerButton::Primary) {
        state.camera.orbit(drag);
    }
    if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
        state.camera.pan(drag, rect.height());
    }
    if response.hovered() {
        let scroll = ui.input(|i| i.smooth_scroll_delta.y);
        if scroll != 0.0 {
            state.camera.zoom(scroll / NOTCH);
        }
    }
    if response.double_clicked() {
        state.camera = Camera::of(session.world());
    }
    if response.clicked() || response.dragged() {
        // The keys are the view's again.
        ui.memory_mut(|m| m.stop_text_input());
        ui.ctx().memory_mut(|m| m.focused().into_iter().for_each(|id| m.surrender_focus(id)));
    }
    if response.dragged() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
    }
    if let Some(scale) = state.display.scale(session.world()) {
        legend(&ui.painter_at(rect), rect, &scale);
    }
    top::keys_and_drops(ui, session, state);
}
