//! Controls, drawn with egui alone: they read and change a [`Session`] and an [`EditorState`], and
//! do not depend on a window.
//!
//! [`show`] lays out everything around the view of the scene, and handles mouse and keys that no
//! control uses.

mod bodies;
mod camera;
mod changes;
mod chart;
mod compare;
mod controls;
mod dialog;
mod display;
mod draft;
mod engine;
mod export;
mod files;
mod generate;
mod heat;
mod help;
mod keys;
mod legend;
mod link;
mod material;
mod messages;
mod numbers;
mod options;
mod overlay;
mod plots;
mod sheet;
mod state;
mod study;
mod style;
mod timeline;
mod tool;
mod top;
mod view;

use bevy_egui::egui::{self, ScrollArea, Ui};

use crate::session::Session;
use crate::study::Stage;

pub use crate::units::format_si;
pub use bevy_sheetwork::inspector::Previews;
pub use bodies::bodies;
pub use camera::camera;
pub use compare::compare;
pub use dialog::{Dialog, Purpose};
pub use display::display;
pub use draft::Draft;
pub use engine::engine;
pub use export::export;
pub use files::dialog;
pub use generate::generate;
pub use heat::heat;
pub use help::help;
pub use legend::{legend, ticks};
pub use link::link;
pub use material::material;
pub use messages::messages;
pub use numbers::numbers;
pub use options::{Display, Plots, Section};
pub use plots::plots;
pub use sheet::sheet;
pub use state::EditorState;
pub use study::{blind, study};
pub use style::apply as apply_style;
pub use timeline::timeline;
pub use tool::{Brush, Held, Tool};
pub use top::top;
pub use view::view;

/// Bars and panels around the view, in a `ui` that fills the window.
pub fn show(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    style::choose(ui.ctx(), state.light);
    if !ui.input(|i| i.pointer.any_down()) {
        // A change after the release of the mouse is an undo step of its own.
        session.seal();
    }
    if state.is_blind() {
        egui::Panel::top("study").show(ui, |ui| study::bar(ui, session, state));
        if !session.messages().is_empty() {
            egui::Panel::bottom("messages").show(ui, |ui| messages(ui, session));
        }
        if state.study.as_ref().is_some_and(|s| matches!(s.stage(), Stage::Asking | Stage::Last)) {
            egui::Panel::bottom("questions").show(ui, |ui| study::questions(ui, session, state));
        }
        state.viewport = ui.available_rect_before_wrap();
        view(ui, session, state);
        study(ui, session, state);
        return;
    }
    egui::Panel::top("top").show(ui, |ui| top(ui, session, state));
    if !session.messages().is_empty() {
        egui::Panel::bottom("messages").show(ui, |ui| messages(ui, session));
    }
    let side = |right: bool, id: &'static str| if right { egui::Panel::right(id) } else { egui::Panel::left(id) };
    if state.controls {
        let panel = side(!state.swapped, "controls").resizable(false).exact_size(318.0);
        panel.show(ui, |ui| controls::column(ui, session, state));
    }
    if state.numbers {
        let panel = side(state.swapped, "numbers").resizable(false).exact_size(225.0);
        panel.show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| numbers(ui, session));
        });
    }
    if state.timeline {
        egui::Panel::bottom("timeline").show(ui, |ui| timeline(ui, session, state));
    }
    session.time_stages(state.plots.shown && state.plots.stages);
    if state.plots.shown {
        let panel = egui::Panel::bottom("plots").resizable(true).default_size(190.0).min_size(120.0);
        panel.show(ui, |ui| plots(ui, session, state));
    }
    state.viewport = ui.available_rect_before_wrap();
    view(ui, session, state);
    controls::windows(ui, session, state);
    help(ui, state);
    dialog(ui, session, state);
    generate(ui, session, state);
    export(ui, session, state);
    study(ui, session, state);
}
