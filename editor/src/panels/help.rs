//! Help on mouse and keys.

use bevy_egui::egui::{Align2, Grid, RichText, Ui, Window};

use super::EditorState;

const LINES: [(&str, &str); 32] = [
    ("left drag", "turn around the scene, or what the tool does"),
    ("right or middle drag", "slide the view"),
    ("wheel", "nearer, farther"),
    ("double click, F", "look at the whole scene"),
    ("Q  G  P  W  C  H  X", "tools: look, grab, pin, move, crease, heat, cut"),
    ("grab: drag the sheet", "pull at it with a spring; its force is shown"),
    ("pin: click the sheet", "hold a mass where it is, or let it go"),
    ("move: click, drag", "choose a body or heater, move it by its arrows"),
    ("crease, cut: drag a line", "fold a shell there; open the cells there"),
    ("heat: drag the sheet", "paint warmth; temperature and radius are beside the tools"),
    ("Space", "play, pause"),
    ("Shift+Space", "stop: back to the state before it was played"),
    ("right, left arrow", "one step of the engine on, back"),
    ("Backspace", "back to the start, changed values stay"),
    ("+  -", "faster, slower"),
    ("Ctrl+1 to Ctrl+9", "keep this moment"),
    ("1 to 9", "back to a kept moment"),
    ("drag the timeline", "go back in the run"),
    ("Ctrl+Z  Ctrl+Shift+Z", "undo, redo"),
    ("Ctrl+O", "open, or add a file to the scene"),
    ("Ctrl+S  Ctrl+Shift+S", "save, save as"),
    ("drop a file", "open it, or add it to the scene"),
    ("drag a number", "change it while the scene runs"),
    ("click a number", "type it, with a unit: 0.3 mm, 2.1 GPa, 140 °C"),
    ("double-click a number", "back to the preset, or to what the scene had"),
    ("Tab", "the next number"),
    ("click a section", "show it on the right"),
    ("Shift+click a section", "show it beside the others"),
    ("right-click a snapshot", "keep this moment in its place"),
    ("hover anything", "what it is, and its unit"),
    ("F1", "this help"),
    ("Esc", "close it, choose nothing"),
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
