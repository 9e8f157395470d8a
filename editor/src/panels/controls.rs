//! Sections of the controls: a column of open ones, and windows of detached ones.

use bevy_egui::egui::{self, Rect, RichText, ScrollArea, Sense, Ui, Window, vec2};

use super::{EditorState, Section, bodies, camera, compare, display, engine, heat, link, material, sheet};
use crate::session::{Item, Session};

/// Row of sections, and the open ones below it.
pub(super) fn column(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.add_space(3.0);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (which, title) in Section::ALL {
            let open = state.open_sections.contains(&which);
            let response = ui.selectable_label(open, title).on_hover_text("Shift+click opens it beside the others");
            if response.clicked() {
                let more = ui.input(|i| i.modifiers.shift || i.modifiers.command);
                match (more, open) {
                    (true, true) => _ = state.open_sections.remove(&which),
                    (true, false) => _ = state.open_sections.insert(which),
                    (false, _) => state.open_sections = [which].into(),
                }
            }
        }
    });
    ui.separator();
    let column = ui.available_rect_before_wrap();
    // Both directions: content wider than the panel would displace the view.
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        for (which, title) in Section::ALL {
            if state.open_sections.contains(&which) && !state.floating.contains(&which) {
                section(ui, session, state, (which, title), column);
            }
        }
    });
}

/// Section of the column with its title, by which it can be dragged out.
fn section(
    ui: &mut Ui,
    session: &mut Session,
    state: &mut EditorState,
    (which, title): (Section, &'static str),
    column: Rect,
) {
    ui.add_space(4.0);
    // Behind the title, which takes the clicks.
    let bar = Rect::from_min_size(ui.cursor().min, vec2(column.width() - 8.0, 20.0));
    let drawn = ui.interact(bar, ui.id().with(("draw", title)), Sense::drag());
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        contents(ui, session, state, (which, title));
        ui.add_space(4.0);
    });
    let button = Rect::from_min_size(bar.right_top() - vec2(24.0, 0.0), vec2(22.0, 20.0));
    let response = ui.interact(button, ui.id().with(("take out", title)), Sense::click());
    let colour = ui.style().interact(&response).fg_stroke.color;
    // Icon: a small window that leaves a larger one.
    let (small, stroke) = (Rect::from_center_size(button.center(), vec2(8.0, 8.0)), egui::Stroke::new(1.2, colour));
    ui.painter().rect_stroke(small.translate(vec2(-1.5, 1.5)), 1.0, stroke, egui::StrokeKind::Middle);
    ui.painter().line_segment([small.center(), small.right_top() + vec2(2.5, -2.5)], stroke);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::WidgetType::Button, true, format!("Take {title} out of the column"))
    });
    let out = response.on_hover_text("Detach as a window, or drag the title out of the column").clicked();
    let left = drawn.interact_pointer_pos().is_some_and(|at| !column.expand(12.0).contains(at));
    if out || (drawn.dragged() && left) {
        state.floating.insert(which);
    }
    ui.separator();
}

fn contents(ui: &mut Ui, session: &mut Session, state: &mut EditorState, (which, title): (Section, &'static str)) {
    // Two sections may have controls of one name.
    ui.push_id(title, |ui| match which {
        Section::Sheet => sheet(ui, session, state),
        Section::Material => material(ui, session, state),
        Section::Bodies => bodies(ui, session, state),
        Section::Engine => engine(ui, session),
        Section::Heat => {
            let before = session.scene().heaters.len();
            heat(ui, session);
            if session.scene().heaters.len() > before {
                state.turn_to(session, Item::Heater(before));
            }
        }
        Section::Display => display(ui, session, state),
        Section::Camera => camera(ui, session, state),
        Section::Compare => compare(ui, session, state),
        Section::Link => link(ui, session),
    });
}

/// Detached sections as windows over the view; closing one returns it to the column.
pub(super) fn windows(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    for (which, title) in Section::ALL {
        if !state.floating.contains(&which) {
            continue;
        }
        let mut open = true;
        let at = ui.input(|i| i.pointer.latest_pos()).unwrap_or(state.viewport.center());
        let window = Window::new(title).id(egui::Id::new(("section", title))).open(&mut open).collapsible(true);
        let place = (at - vec2(60.0, 10.0)).max(state.viewport.min + vec2(8.0, 70.0));
        window.default_pos(place).default_size([300.0, 360.0]).vscroll(true).show(ui.ctx(), |ui| {
            contents(ui, session, state, (which, title));
        });
        if !open {
            state.floating.remove(&which);
            state.open_sections.insert(which);
        }
    }
}
