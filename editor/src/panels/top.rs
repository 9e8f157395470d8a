//! The bar at the top: opening scenes, playing and pausing, speed.

use std::path::{Path, PathBuf};

use bevy_egui::egui::{self, Button, Key, RichText, Slider, Ui};

use super::style::ACCENT;
use super::{EditorState, help};
use crate::camera::Camera;
use crate::scenes;
use crate::session::Session;

/// The bar at the top.
pub fn top(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.add_space(3.0);
    ui.horizontal_wrapped(|ui| {
        menus(ui, session, state);
        ui.separator();
        transport(ui, session);
        ui.separator();
        ui.label(RichText::new(format!("{:>8.3} s", session.world().time())).monospace().size(15.0))
            .on_hover_text("Simulated time");
        let scene = session.world().scene();
        ui.separator();
        ui.label(RichText::new(&scene.name).strong()).on_hover_text(&scene.description);
    });
    ui.add_space(2.0);
}

fn menus(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.menu_button("Scene", |ui| {
        ui.set_min_width(320.0);
        if let Some(file) = open_menu(ui, state) {
            state.open(session, &file);
            ui.close();
        }
        ui.separator();
        if ui.button("Reload from its file").on_hover_text("Start again with the file's own values").clicked() {
            session.reload();
            ui.close();
        }
        if ui.button("Quit").clicked() {
            state.quit = true;
        }
    });
    ui.menu_button("View", |ui| {
        ui.checkbox(&mut state.controls, "Controls");
        ui.checkbox(&mut state.numbers, "Numbers");
        if ui.button("Look at the scene").clicked() {
            state.camera = Camera::of(session.world());
            ui.close();
        }
    });
    if ui.button("Help").on_hover_text("Mouse and keys (F1)").clicked() {
        state.help = !state.help;
    }
}

/// The list of scenes and the field for any other; the file to open, if one was chosen.
fn open_menu(ui: &mut Ui, state: &mut EditorState) -> Option<PathBuf> {
    let mut chosen = None;
    egui::ScrollArea::vertical().max_height(360.0).show(ui, |ui| {
        for file in &state.scenes {
            if ui.button(scenes::title(file)).on_hover_text(file.display().to_string()).clicked() {
                chosen = Some(file.clone());
            }
        }
        if state.scenes.is_empty() {
            ui.weak("No folder assets/scenes was found.");
        }
    });
    ui.separator();
    ui.horizontal(|ui| {
        let label = ui.label("File");
        let field = egui::TextEdit::singleline(&mut state.path).desired_width(200.0).hint_text("path/to/scene.ron");
        let entered = ui.add(field).labelled_by(label.id).lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        let given = !state.path.trim().is_empty();
        if ui.add_enabled(given, Button::new("Open")).clicked() || (entered && given) {
            chosen = Some(scenes::find(Path::new(state.path.trim())));
        }
    });
    ui.weak("or drop a file on the window: a scene, or a recording (.swr)");
    chosen
}

fn transport(ui: &mut Ui, session: &mut Session) {
    let label = if session.playing() { "⏸ Pause" } else { "▶ Play" };
    let play = Button::new(RichText::new(label).strong()).min_size(egui::vec2(74.0, 0.0));
    let play = if session.playing() { play } else { play.fill(ACCENT.gamma_multiply(0.7)) };
    if ui.add(play).on_hover_text("Space").clicked() {
        session.toggle();
    }
    if ui.button("⏭ Step").on_hover_text("Take one step of the engine and pause (right arrow)").clicked() {
        session.step();
    }
    if ui.button("⟲ Reset").on_hover_text("Back to the start; changed values stay (Backspace)").clicked() {
        session.reset();
    }
    if let Some((at, duration)) = session.playback().map(|r| (r.at(), r.duration())) {
        let label = ui.label("Recording");
        let mut now = at;
        let slider = Slider::new(&mut now, 0.0..=duration).suffix(" s").fixed_decimals(2);
        if ui.add(slider).labelled_by(label.id).on_hover_text("Moment of the recording").changed() {
            session.pause();
            session.seek(now);
        }
    }
    let label = ui.label("Speed");
    let mut speed = session.speed();
    let slider = Slider::new(&mut speed, 0.01..=64.0).logarithmic(true).suffix("×").update_while_editing(false);
    let about = "Simulated seconds a real second (+ and -)";
    if ui.add(slider).labelled_by(label.id).on_hover_text(about).changed() {
        session.set_speed(speed);
    }
}

/// Keys that no text field wants, and files dropped on the window.
pub(super) fn keys_and_drops(ui: &Ui, session: &mut Session, state: &mut EditorState) {
    let dropped = ui.input(|i| i.raw.dropped_files.iter().find_map(|f| f.path.clone()));
    if let Some(file) = dropped {
        state.open(session, &file);
    }
    if ui.input(|i| i.key_pressed(Key::F1)) {
        state.help = !state.help;
    }
    if ui.ctx().text_edit_focused() {
        return;
    }
    let pressed = |key| ui.input(|i| i.key_pressed(key));
    // A button that has the focus takes the space bar itself.
    if pressed(Key::Space) && ui.memory(|m| m.focused().is_none()) {
        session.toggle();
    }
    if pressed(Key::ArrowRight) && ui.memory(|m| m.focused().is_none()) {
        session.step();
    }
    if pressed(Key::Backspace) {
        session.reset();
    }
    if pressed(Key::Plus) || pressed(Key::Equals) {
        session.faster();
    }
    if pressed(Key::Minus) {
        session.slower();
    }
    if pressed(Key::F) {
        state.camera = Camera::of(session.world());
    }
    if pressed(Key::Escape) {
        help::close(state);
    }
}
