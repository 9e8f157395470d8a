//! Messages to the user, until dismissed.

use bevy_egui::egui::{ScrollArea, Ui};
use bevy_sheetwork::inspector::dismissible;

use crate::session::Session;

/// The messages, newest last, each with a button to dismiss it.
pub fn messages(ui: &mut Ui, session: &mut Session) {
    ui.add_space(3.0);
    let colours = [ui.visuals().text_color(), ui.visuals().error_fg_color];
    let all = session.messages().iter().map(|m| (m.text.as_str(), colours[usize::from(m.error)]));
    let area = ScrollArea::vertical().max_height(110.0).stick_to_bottom(true);
    let dismissed = area.show(ui, |ui| dismissible(ui, all)).inner;
    if let Some(index) = dismissed {
        session.dismiss(index);
    }
    ui.add_space(3.0);
}
