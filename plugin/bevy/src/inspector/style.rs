//! Colours that mean the same in every panel, dark or light.

use bevy_egui::egui::{Color32, Ui};

/// The sheets' own colour, for what is chosen or active.
pub const ACCENT: Color32 = Color32::from_rgb(226, 92, 52);
/// Lines that others are compared with.
pub const QUIET: Color32 = Color32::from_rgb(142, 144, 150);
/// How much of a colour's light is left in text on a light ground: with it each has a contrast of 4.5 or more (WCAG 2.2, 1.4.3).
const ON_LIGHT: f32 = 0.54;

/// A colour as text: darker on a light ground.
pub fn readable(ui: &Ui, colour: Color32) -> Color32 {
    if ui.visuals().dark_mode {
        return colour;
    }
    let [r, g, b, _] = colour.to_array().map(|c| (f32::from(c) * ON_LIGHT) as u8);
    Color32::from_rgb(r, g, b)
}

/// Names of numbers.
pub fn quiet(ui: &Ui) -> Color32 {
    readable(ui, QUIET)
}
