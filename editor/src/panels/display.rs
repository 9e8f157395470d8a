//! What is drawn of the sheets.

use bevy_egui::egui::Ui;

use super::EditorState;
use crate::camera::Camera;
use crate::picture::Layer;
use crate::session::Session;

/// Surface, layer, smoothing, springs, masses, room.
pub fn display(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let display = &mut state.display;
    ui.horizontal(|ui| {
        ui.checkbox(&mut display.surface, "Surface");
        ui.checkbox(&mut display.springs, "Springs").on_hover_text("Blue where compressed, red where stretched");
        ui.checkbox(&mut display.masses, "Masses").on_hover_text("Bright where they touch a body");
    });
    ui.add_enabled_ui(display.surface, |ui| {
        ui.horizontal(|ui| {
            ui.radio_value(&mut display.layer, Layer::Top, "Top layer");
            ui.radio_value(&mut display.layer, Layer::Bottom, "Bottom layer");
        });
        ui.horizontal(|ui| {
            ui.radio_value(&mut display.smooth, true, "Smoothed")
                .on_hover_text("A spline surface through the masses; where they are far apart it can cut an edge");
            ui.radio_value(&mut display.smooth, false, "Flat").on_hover_text("Triangles between the masses");
        });
    });
    ui.horizontal(|ui| {
        ui.checkbox(&mut display.room, "Room");
        if ui.button("Look at the scene").clicked() {
            state.camera = Camera::of(session.world());
        }
    });
}
