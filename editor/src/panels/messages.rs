//! Messages to the user, until dismissed.

use bevy_egui::egui::{RichText, ScrollArea, Ui};

use crate::session::Session;

/// The messages, newest last, each with a button to dismiss it.
pub fn messages(ui: &mut Ui, session: &mut Session) {
    let mut dismissed = None;
    ui.add_space(3.0);
    ScrollArea::vertical().max_height(110.0).stick_to_bottom(true).show(ui, |ui| {
        for (index, message) in session.messages().iter().enumerate() {
            ui.horizontal_wrapped(|ui| {
                if ui.small_button("✖").on_hover_text("Dismiss").clicked() {
                    dismissed = Some(index);
                }
                let colour = if message.error { ui.visuals().error_fg_color } else { ui.visuals().text_color() };
                ui.label(RichText::new(&message.text).color(colour));
            });
        }
    });
    if let Some(index) = dismissed {
        session.dismiss(index);
    }
    ui.add_space(3.0);
}
