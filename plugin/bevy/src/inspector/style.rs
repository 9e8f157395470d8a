//! Colours of the panels, for dark and light themes.

use bevy_egui::egui::{Color32, Ui};

/// Colour of chosen or active items: the default colour of a sheet.
pub const ACCENT: Color32 = Color32::from_rgb(226, 92, 52);
/// Colour of reference lines.
pub const QUIET: Color32 = Color32::from_rgb(142, 144, 150);
/// Lightness factor of coloured text on a light background, for a contrast of at least 4.5 (WCAG
/// 2.2, 1.4.3).
const ON_LIGHT: f32 = 0.54;

/// A colour as text: darker on a light background.
pub fn readable(ui: &Ui, colour: Color32) -> Color32 {
    if ui.visuals().dark_mode {
        return colour;
    }
    let [r, g, b, _] = colour.to_array().map(|c| (f32::from(c) * ON_LIGHT) as u8);
    Color32::from_rgb(r, g, b)
}

/// Colour of the names of numbers.
pub fn quiet(ui: &Ui) -> Color32 {
    readable(ui, QUIET)
}
