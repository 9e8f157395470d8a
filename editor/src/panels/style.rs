//! Colours and spacing of the controls, dark and light.

use bevy_egui::egui::{self, Button, Color32, CornerRadius, RichText, Stroke, Theme, Ui};

pub(super) use bevy_sheetwork::inspector::style::{ACCENT, QUIET, quiet, readable};

/// Kinetic energy.
pub(super) const KINETIC: Color32 = Color32::from_rgb(240, 150, 70);
/// Elastic energy.
pub(super) const ELASTIC: Color32 = Color32::from_rgb(95, 170, 235);
/// Potential energy.
pub(super) const GRAVITY: Color32 = Color32::from_rgb(140, 200, 120);
/// Total energy.
pub(super) const TOTAL: Color32 = Color32::from_rgb(170, 170, 178);

/// Apply the editor's style to a context, dark by default.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(Theme::Dark);
    ctx.style_mut_of(Theme::Dark, |style| {
        style.visuals.panel_fill = Color32::from_rgb(32, 34, 38);
        style.visuals.window_fill = Color32::from_rgb(38, 40, 45);
        style.visuals.error_fg_color = Color32::from_rgb(255, 128, 108);
        style.visuals.weak_text_color = Some(Color32::from_gray(150));
    });
    ctx.style_mut_of(Theme::Light, |style| {
        style.visuals.panel_fill = Color32::from_rgb(238, 238, 236);
        style.visuals.window_fill = Color32::from_rgb(246, 246, 245);
        style.visuals.extreme_bg_color = Color32::from_rgb(222, 223, 222);
        style.visuals.weak_text_color = Some(Color32::from_gray(88));
        style.visuals.error_fg_color = Color32::from_rgb(178, 32, 16);
        style.visuals.warn_fg_color = Color32::from_rgb(150, 78, 0);
        // Boxes and buttons have an edge: their background is close to that of the panel.
        style.visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, Color32::from_gray(168));
        style.visuals.widgets.inactive.bg_fill = Color32::from_gray(250);
        style.visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(226);
    });
    ctx.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        if visuals.dark_mode {
            visuals.selection.bg_fill = ACCENT.gamma_multiply(0.75);
        } else {
            visuals.selection.bg_fill = Color32::from_rgb(205, 78, 52);
            visuals.selection.stroke.color = Color32::WHITE;
        }
        visuals.slider_trailing_fill = true;
        visuals.hyperlink_color = ACCENT;
        for widget in [
            &mut visuals.widgets.inactive,
            &mut visuals.widgets.hovered,
            &mut visuals.widgets.active,
            &mut visuals.widgets.open,
        ] {
            widget.corner_radius = CornerRadius::same(4);
        }
        style.spacing.item_spacing = egui::vec2(7.0, 5.0);
        style.spacing.slider_width = 104.0;
        style.spacing.interact_size.y = 21.0;
    });
}

/// Apply the dark or the light theme.
pub(super) fn choose(ctx: &egui::Context, light: bool) {
    let wanted = if light { Theme::Light } else { Theme::Dark };
    if ctx.theme() != wanted {
        ctx.set_theme(wanted);
    }
}

/// Button of the main action, in the accent colour.
pub(super) fn first<'a>(ui: &Ui, text: &str) -> Button<'a> {
    let text = RichText::new(text).strong();
    if ui.visuals().dark_mode {
        Button::new(text).fill(ACCENT.gamma_multiply(0.7))
    } else {
        Button::new(text.color(Color32::WHITE)).fill(Color32::from_rgb(190, 66, 34))
    }
}
