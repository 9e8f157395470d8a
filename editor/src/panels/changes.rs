//! The menu of edits: undo, redo, and what differs from the file, each field by the names of what it belongs to, with its unit.

use bevy_egui::egui::{Button, Grid, RichText, Ui};
use sheetwork::scene::Scene;

use super::style::quiet;
use crate::document::path::numbered;
use crate::session::Session;
use crate::units::format_si;

/// Most fields that are listed.
const MOST_LISTED: usize = 16;

/// Most letters of a value that is text.
const LONGEST: usize = 32;

/// Undo, redo, and what has changed.
pub(super) fn menu(ui: &mut Ui, session: &mut Session) {
    ui.set_min_width(300.0);
    let named = |word: &str, what: Option<&str>| what.map_or(word.to_owned(), |what| format!("{word} {what}"));
    let (undo, redo) = (session.document().undoes().map(str::to_owned), session.document().redoes().map(str::to_owned));
    let button = |text: String, keys: &'static str| Button::new(text).shortcut_text(keys);
    if ui.add_enabled(undo.is_some(), button(named("Undo", undo.as_deref()), "Ctrl+Z")).clicked() {
        session.undo();
        ui.close();
    }
    if ui.add_enabled(redo.is_some(), button(named("Redo", redo.as_deref()), "Ctrl+Shift+Z")).clicked() {
        session.redo();
        ui.close();
    }
    ui.separator();
    let changes = session.changes();
    match changes.len() {
        0 => _ = ui.weak("nothing differs from the file"),
        1 => _ = ui.label(RichText::new("1 value differs from the file").color(quiet(ui))),
        count => _ = ui.label(RichText::new(format!("{count} values differ from the file")).color(quiet(ui))),
    }
    Grid::new("changes").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
        for (path, value) in changes.iter().take(MOST_LISTED) {
            ui.label(in_words(session.scene(), path)).on_hover_text(path);
            ui.label(with_unit(session, path, value)).on_hover_text(value);
            ui.end_row();
        }
    });
    if changes.len() > MOST_LISTED {
        ui.label(RichText::new(format!("and {} more", changes.len() - MOST_LISTED)).color(quiet(ui)));
    }
}

/// A path as its user calls it: things of a list by their names, the rest as words.
fn in_words(scene: &Scene, path: &str) -> String {
    let mut parts = path.splitn(3, '.');
    let (first, second) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let rest = parts.next().unwrap_or_default();
    let Ok(index) = second.parse::<usize>() else { return path.replace(['.', '_'], " ") };
    let (kind, name) = match first {
        "sheets" => ("sheet", scene.sheets.get(index).map(|s| s.name.as_str())),
        "bodies" => ("body", scene.bodies.get(index).map(|b| b.name.as_str())),
        "heaters" => ("heater", scene.heaters.get(index).map(|h| h.name.as_str())),
        _ => return path.replace(['.', '_'], " "),
    };
    let thing = name.filter(|n| !n.is_empty()).map_or_else(|| format!("{kind} {}", index + 1), str::to_owned);
    format!("{thing}: {}", rest.replace(['.', '_'], " "))
}

/// A value with the unit that the world knows it by; text in so many letters.
fn with_unit(session: &Session, path: &str, value: &str) -> String {
    let sheets = session.world().sheets();
    let known = session.world().parameters().into_iter().find(|p| numbered(sheets, &p.path) == path);
    let unit = known.map_or("", |p| p.unit);
    match (value.parse::<f64>(), unit) {
        (Ok(number), "Pa" | "m" | "s" | "N") => format_si(number, unit),
        (Ok(number), _) => format!("{} {unit}", (number * 1e6).round() / 1e6).trim_end().to_owned(),
        _ if value.chars().count() > LONGEST => format!("{} …", value.chars().take(LONGEST).collect::<String>()),
        _ => format!("{value} {unit}").trim_end().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_said_by_name_and_with_its_unit() {
        let scene = Scene::parse(r#"(sheets: [(name: "card", structure: "shell", material: "card"), ()])"#);
        let mut session = Session::new(&scene.expect("valid")).expect("valid");
        assert!(session.set("sheets.card.material.young", "2.5e9") && session.set("gravity", "(0, -5, 0)"));
        assert!(session.edit("place", "place", |s| s.sheets[1].placement.position.y = 0.123_456_7));
        let changes = session.changes();
        let said = |path: &str| {
            let (path, value) = changes.iter().find(|c| c.0 == path).expect("changed");
            (in_words(session.scene(), path), with_unit(&session, path, value))
        };
        assert_eq!(said("sheets.0.material.young"), ("card: material young".into(), "2.50 GPa".into()));
        assert_eq!(said("gravity.1"), ("gravity 1".into(), "-5".into()));
        assert_eq!(said("sheets.1.placement.position.1"), ("sheet 2: placement position 1".into(), "0.123457".into()));
    }
}
