//! Mouse tool and camera of the view.

use std::f32::consts::FRAC_PI_2;

use bevy_egui::egui::{Grid, Ui};
use sheetwork::scene::CameraSpec;

use super::{EditorState, Tool};
use crate::camera::Camera;
use crate::session::Session;
use crate::units::DisplayUnit;
use bevy_sheetwork::inspector::controls::{ControlOptions, DEGREES, MM, number};

/// Standard views: name, yaw, pitch, radians.
const VIEWS: [(&str, f32, f32); 6] = [
    ("front", 0.0, 0.0),
    ("back", 2.0 * FRAC_PI_2, 0.0),
    ("left", -FRAC_PI_2, 0.0),
    ("right", FRAC_PI_2, 0.0),
    ("top", 0.0, 1.55),
    ("below", 0.0, -1.55),
];

/// Mouse tool, views, focus, and the camera in numbers.
pub fn camera(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.horizontal(|ui| {
        for (tool, title, about) in Tool::ALL {
            ui.selectable_value(&mut state.tool, tool, title).on_hover_text(about);
        }
    });
    ui.horizontal(|ui| {
        ui.label("Mouse");
        for (tool, title, about) in Tool::MODES {
            ui.selectable_value(&mut state.tool, tool, title).on_hover_text(about);
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (title, yaw, pitch) in VIEWS {
            if ui.small_button(title).on_hover_text(format!("Seen from the {title}")).clicked() {
                state.camera = state.camera.from_side(yaw, pitch);
            }
        }
    });
    ui.horizontal(|ui| {
        if ui.button("Focus").on_hover_text("Show everything from the present direction").clicked() {
            state.camera = state.camera.focused(session.world());
        }
        if ui.button("Scene's own").on_hover_text("The camera of the scene (F)").clicked() {
            state.camera = Camera::from_session(session);
        }
        if ui.button("Keep in scene").on_hover_text("Store this view as the camera of the scene").clicked() {
            let (eye, target) = (state.camera.eye().as_dvec3(), state.camera.target.as_dvec3());
            session.edit("view", "camera", |s| s.camera = Some(CameraSpec { eye, target }));
        }
    });
    Grid::new("camera").num_columns(2).show(ui, |ui| numbers(ui, session, state));
}

fn numbers(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let camera = &mut state.camera;
    let mut row = |ui: &mut Ui, (title, about): (&str, &str), now: f64, shown: DisplayUnit| {
        let done = number(ui, session, (title, about, title), now, shown, &ControlOptions::speed(0.5));
        ui.end_row();
        done.value
    };
    if let Some(v) = row(ui, ("Distance", "From eye to target"), f64::from(camera.distance), MM) {
        camera.distance = (v as f32).clamp(1e-4, 1e4);
    }
    let angle = |radians: f32| f64::from(radians).to_degrees();
    if let Some(v) = row(ui, ("Yaw", "Rotation about the vertical"), angle(camera.yaw), DEGREES) {
        camera.yaw = v.to_radians() as f32;
    }
    if let Some(v) = row(ui, ("Pitch", "Elevation of the eye above the target"), angle(camera.pitch), DEGREES) {
        camera.pitch = (v.to_radians() as f32).clamp(-1.55, 1.55);
    }
    let about = "Angle between the upper and the lower edge of the view";
    if let Some(v) = row(ui, ("Field of view", about), angle(camera.field_of_view), DEGREES) {
        camera.field_of_view = (v.to_radians() as f32).clamp(0.05, 2.0);
    }
}
