//! Help on mouse and keys.

use bevy_egui::egui::{Align2, Grid, RichText, Ui, Window};

use super::EditorState;

const LINES: [(&str, &str); 32] = [
    ("left drag", "rotate the view, or use the tool"),
    ("right or middle drag", "pan the view"),
    ("wheel", "zoom"),
    ("double click, F", "show the whole scene"),
    ("Q  G  P  W  C  H  X", "tools: look, grab, pin, move, crease, heat, cut"),
    ("grab: drag the sheet", "pull it with a spring; its force is shown"),
    ("pin: click the sheet", "pin a node at its position, or unpin it"),
    ("move: click, drag", "select a body or heater, move it by its arrows"),
    ("crease, cut: drag a line", "crease a shell along it; open the cells along it"),
    ("heat: drag the sheet", "paint heat; temperature and radius are below the tools"),
    ("Space", "play, pause"),
    ("Shift+Space", "stop: back to the state before playing"),
    ("right, left arrow", "one time step forward, back"),
    ("Backspace", "reset to the start; changed values stay"),
    ("+  -", "faster, slower"),
    ("Ctrl+1 to Ctrl+9", "store a snapshot"),
    ("1 to 9", "restore a snapshot"),
    ("drag the timeline", "go back in the run"),
    ("Ctrl+Z  Ctrl+Shift+Z", "undo, redo"),
    ("Ctrl+O", "open, or add a file to the scene"),
    ("Ctrl+S  Ctrl+Shift+S", "save, save as"),
    ("drop a file", "open it, or add it to the scene"),
    ("drag a number", "change it while the scene runs"),
    ("click a number", "type it, with a unit: 0.3 mm, 2.1 GPa, 140 °C"),
    ("double-click a number", "reset to the value of the preset or the scene"),
    ("Tab", "the next number"),
    ("click a section", "open it"),
    ("Shift+click a section", "open it beside the others"),
    ("right-click a snapshot", "replace it by the present state"),
    ("hover anything", "explanation and unit"),
    ("F1", "this help"),
    ("Esc", "close it, clear the selection"),
];

/// The help window, while it is open.
pub fn help(ui: &mut Ui, state: &mut EditorState) {
    if !state.help {
        return;
    }
    // Low, so that the scene is visible above it.
    let window =
        Window::new("Mouse and keys").collapsible(false).resizable(false).anchor(Align2::CENTER_BOTTOM, [0.0, -12.0]);
    window.open(&mut state.help).show(ui.ctx(), |ui| {
        ui.horizontal_top(|ui| {
            for half in [&LINES[..16], &LINES[16..]] {
                Grid::new(half[0].0).num_columns(2).spacing([18.0, 6.0]).show(ui, |ui| {
                    for (what, does) in half {
                        ui.label(RichText::new(*what).strong());
                        ui.label(*does);
                        ui.end_row();
                    }
                });
            }
        });
    });
}
