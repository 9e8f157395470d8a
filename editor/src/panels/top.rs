//! Top bar: menus, playback, speed, and name of the scene.

use bevy_egui::egui::containers::menu::{MenuButton, MenuConfig};
use bevy_egui::egui::{self, Button, PopupCloseBehavior, RichText, Slider, Ui};

use super::style::{self, ACCENT, quiet, readable};
use super::{EditorState, Section, changes, files};
use crate::camera::Camera;
use crate::scenes;
use crate::session::Session;

/// The top bar.
pub fn top(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.add_space(3.0);
    ui.horizontal_wrapped(|ui| {
        menus(ui, session, state);
        ui.separator();
        transport(ui, session);
        ui.separator();
        ui.label(RichText::new(format!("{:>8.3} s", session.world().time())).monospace().size(15.0))
            .on_hover_text("Simulated time");
        ui.separator();
        title(ui, session);
    });
    ui.add_space(2.0);
}

/// Name of the scene, with a mark while it is unsaved.
fn title(ui: &mut Ui, session: &Session) {
    let scene = session.scene();
    ui.label(RichText::new(&scene.name).strong()).on_hover_text(&scene.description);
    // The name of a scene may differ from that of its file.
    if let Some(file) = session.file()
        && scenes::title(file) != scene.name
    {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        ui.label(RichText::new(name).color(quiet(ui))).on_hover_text(file.display().to_string());
    }
    if session.document().is_unsaved() {
        let file = session.file().map_or_else(|| "no file yet".to_owned(), |f| f.display().to_string());
        ui.label(RichText::new("• not saved").color(readable(ui, ACCENT)))
            .on_hover_text(format!("Ctrl+S saves it: {file}"));
    } else if session.file().is_none() {
        ui.label(RichText::new("• new").color(quiet(ui))).on_hover_text("Ctrl+S saves it in a file");
    }
}

fn menus(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    // A click into the text field keeps the menu open; a choice closes it.
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new("File").config(config).ui(ui, |ui| {
        ui.set_min_width(300.0);
        files::menu(ui, session, state);
    });
    ui.menu_button("Edit", |ui| changes::menu(ui, session));
    ui.menu_button("View", |ui| {
        ui.checkbox(&mut state.controls, "Controls");
        ui.checkbox(&mut state.numbers, "Numbers");
        ui.checkbox(&mut state.timeline, "Timeline");
        ui.checkbox(&mut state.plots.shown, "Plots");
        ui.checkbox(&mut state.swapped, "Controls on the left").on_hover_text("And the numbers on the right");
        ui.separator();
        if ui.button("All controls").on_hover_text("Open every section").clicked() {
            state.open_sections = Section::ALL.iter().map(|s| s.0).collect();
            ui.close();
        }
        if ui.button("Look at the scene").clicked() {
            state.camera = Camera::from_session(session);
            ui.close();
        }
        ui.separator();
        ui.checkbox(&mut state.light, "Light").on_hover_text("Light panels in place of dark ones");
    });
    if ui.button("Help").on_hover_text("Mouse and keys (F1)").clicked() {
        state.help = !state.help;
    }
}

fn transport(ui: &mut Ui, session: &mut Session) {
    let play =
        if session.playing() { Button::new(RichText::new("⏸ Pause").strong()) } else { style::first(ui, "▶ Play") };
    if ui.add(play.min_size(egui::vec2(74.0, 0.0))).on_hover_text("Space").clicked() {
        session.toggle();
    }
    let stop = ui.add_enabled(session.can_stop(), Button::new("⏹ Stop"));
    if stop.on_hover_text("Pause, and restore the state before playing (Shift+Space)").clicked() {
        session.stop();
    }
    if ui.button("⏮").on_hover_text("One time step back (left arrow)").clicked() {
        session.step_back();
    }
    if ui.button("⏭ Step").on_hover_text("Take one time step and pause (right arrow)").clicked() {
        session.step();
    }
    if ui.button("⟲ Reset").on_hover_text("Reset to the start; changed values stay (Backspace)").clicked() {
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
    let about = "Simulated seconds per real second (+ and -); below 1 is slow motion";
    if ui.add(slider).labelled_by(label.id).on_hover_text(about).changed() {
        session.set_speed(speed);
    }
}
