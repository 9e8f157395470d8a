//! Live link: switch and status.

use bevy_egui::egui::{RichText, Ui};

use crate::session::Session;

/// Switch, and a line with clients, frames per second, and data rate.
pub fn link(ui: &mut Ui, session: &mut Session) {
    let mut on = session.link().is_on();
    let about = "Let other processes observe and command this session: sheetwork watch, sheetwork set, Python";
    if ui.checkbox(&mut on, "Open to other processes").on_hover_text(about).changed() {
        session.set_link(on);
    }
    ui.label(RichText::new(session.link().status()).weak());
    for one in session.link().attached() {
        let commands = if one.commands { ", may command" } else { "" };
        ui.label(RichText::new(format!("{one}: reads {} streams{commands}", one.reads)).weak().small());
    }
}
