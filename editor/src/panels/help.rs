//! What mouse and keys do.

use bevy_egui::egui::{Align2, Grid, RichText, Ui, Window};

use super::EditorState;

const LINES: [(&str, &str); 13] = [
    ("left drag", "turn around the scene"),
    ("right or middle drag", "slide the view"),
    ("wheel", "nearer, farther"),
    ("double click, F", "look at the whole scene"),
    ("Space", "play, pause"),
    ("→", "one step of the engine"),
    ("Backspace", "back to the start, changed values stay"),
    ("+  -", "faster, slower"),
    ("drop a file", "open it"),
    ("drag a number", "change it while the scene runs"),
    ("click a number", "type it"),
    ("F1", "this help"),
    ("Esc", "close it"),
];

/// The help window, while it is asked for.
pub fn help(ui: &mut Ui, state: &mut EditorState) {
    if !state.help {
        return;
    }
    let window =
        Window::new("Mouse and keys").collapsible(false).resizable(false).anchor(Align2::CENTER_CENTER, [0.0; 2]);
    window.open(&mut state.help).show(ui.ctx(), |ui| {
        Grid::new("help").num_columns(2).spacing([18.0, 6.0]).show(ui, |ui| {
            for (what, does) in LINES {
                ui.label(RichText::new(what).strong());
                ui.label(does);
                ui.end_row();
            }
        });
    });
}

pub(super) fn close(state: &mut EditorState) {
    state.help = false;
}
