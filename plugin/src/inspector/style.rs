//! Colours that mean the same in every panel.

use bevy_egui::egui::Color32;

/// The sheets' own colour, for what is chosen or active.
pub const ACCENT: Color32 = Color32::from_rgb(226, 92, 52);
/// Names of numbers.
pub const QUIET: Color32 = Color32::from_rgb(142, 144, 150);
