//! Menu of edits: undo, redo, and the differences from the file, each with names and unit.

use bevy_egui::egui::{Button, Grid, RichText, Ui};
use sheetwork::ParameterId;
use sheetwork::scene::Scene;

use super::style::quiet;
use crate::session::{Item, Session};
use crate::units::format_si;

/// Maximum number of listed fields.
const MAX_LISTED: usize = 16;

/// Maximum number of characters of a text value.
const MAX_TEXT: usize = 32;

/// Undo, redo, and list of changes.
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
    let since = if session.file().is_some() { "the file" } else { "how it began" };
    let said = if changes.is_empty() { "nothing differs from" } else { "differs from" };
    ui.label(RichText::new(format!("{said} {since}{}", if changes.is_empty() { "" } else { ":" })).color(quiet(ui)));
    let lines = lines(session, &changes);
    Grid::new("changes").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
        for (what, value, path) in lines.iter().take(MAX_LISTED) {
            ui.label(what).on_hover_text(path);
            ui.label(value);
            ui.end_row();
        }
    });
    if lines.len() > MAX_LISTED {
        ui.label(RichText::new(format!("and {} more", lines.len() - MAX_LISTED)).color(quiet(ui)));
    }
}

/// Differences, one per line: name, present value, path. An added object is one line, and so are
/// the creases, cuts, spots and pins of a sheet.
fn lines(session: &Session, changes: &[(String, String)]) -> Vec<(String, String, String)> {
    let (old, new) = (session.document().saved(), session.scene());
    let mut lines: Vec<(String, String, String)> = Vec::new();
    for (path, value) in changes {
        let parts: Vec<&str> = path.split('.').collect();
        let index = parts.get(1).and_then(|p| p.parse::<usize>().ok());
        let is_new = index.is_some_and(|i| i >= count(old, parts[0]));
        let (what, value, path) = match (parts.as_slice(), index) {
            ([list, ..], Some(i)) if is_new => (thing(session, list, i), "added".to_owned(), parts[..2].join(".")),
            (["sheets", _, list @ ("creases" | "slits" | "spots" | "pins"), ..], Some(i)) => {
                let now = new.sheets.get(i).map_or(0, |s| match *list {
                    "creases" => s.creases.len(),
                    "slits" => s.slits.len(),
                    "spots" => s.spots.len(),
                    _ => s.pins.len(),
                });
                (format!("{}: {list}", thing(session, "sheets", i)), now.to_string(), parts[..3].join("."))
            }
            _ => (in_words(session, path), with_unit(path, value), path.clone()),
        };
        if lines.iter().all(|line| line.2 != path) {
            lines.push((what, value, path));
        }
    }
    for list in ["sheets", "bodies", "heaters"] {
        let fewer = count(old, list).saturating_sub(count(new, list));
        if fewer > 0 {
            lines.push((list.to_owned(), format!("{fewer} fewer"), list.to_owned()));
        }
    }
    lines
}

/// Length of a list of the scene.
fn count(scene: &Scene, list: &str) -> usize {
    match list {
        "sheets" => scene.sheets.len(),
        "bodies" => scene.bodies.len(),
        "heaters" => scene.heaters.len(),
        _ => usize::MAX,
    }
}

/// Name of an element of a list.
fn thing(session: &Session, list: &str, index: usize) -> String {
    session.name_of(match list {
        "sheets" => Item::Sheet(index),
        "bodies" => Item::Body(index),
        _ => Item::Heater(index),
    })
}

/// Path in words: elements of lists by name, components of vectors by axis.
fn in_words(session: &Session, path: &str) -> String {
    let mut parts: Vec<&str> = path.split('.').collect();
    let index =
        parts.get(1).and_then(|p| p.parse::<usize>().ok()).filter(|_| count(session.scene(), parts[0]) < usize::MAX);
    let of = index.map(|i| format!("{}: ", thing(session, parts[0], i))).unwrap_or_default();
    parts.drain(..if index.is_some() { 2 } else { 0 });
    if let Some(last) = parts.last_mut()
        && let Some(axis) = last.parse::<usize>().ok().and_then(|k| ["x", "y", "z"].get(k))
    {
        *last = axis;
    }
    format!("{of}{}", parts.join(" ").replace('_', " "))
}

/// Value with the unit of its parameter; text is shortened.
fn with_unit(path: &str, value: &str) -> String {
    let unit = ParameterId::from_path(path).map_or("", |id| id.row().unit);
    match (value.parse::<f64>(), unit) {
        (Ok(number), "Pa" | "m" | "s" | "N") => format_si(number, unit),
        (Ok(number), _) => format!("{} {unit}", (number * 1e6).round() / 1e6).trim_end().to_owned(),
        _ if value.chars().count() > MAX_TEXT => format!("{} …", value.chars().take(MAX_TEXT).collect::<String>()),
        _ => format!("{value} {unit}").trim_end().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_listed_by_name_with_their_unit() {
        let scene =
            Scene::parse(r#"(sheets: [(name: "card", structure: "shell", grid: (5, 1, 5), material: "card"), ()])"#);
        let mut session = Session::new(&scene.expect("valid")).expect("valid");
        assert!(session.set("sheets.card.material.young", "2.1e9") && session.set("gravity", "(0, -5, 0)"));
        assert!(session.edit("place", "place", |s| s.sheets[1].placement.position.y = 0.0123));
        assert!(session.edit("crease", "crease", |s| {
            let crease = sheetwork::scene::CreaseSpec { from: (0.0, 0.5), to: (1.0, 0.5), angle: 30.0 };
            s.sheets[0].creases.push(crease);
        }));
        let box_of = sheetwork::scene::Shape::Ball(0.1);
        assert!(session.edit("body", "body", |s| s.bodies.push(sheetwork::scene::BodySpec::new(box_of))));
        let said = lines(&session, &session.changes());
        let said: Vec<(&str, &str)> = said.iter().map(|l| (l.0.as_str(), l.1.as_str())).collect();
        for wanted in [
            ("card: material young", "2.10 GPa"),
            ("gravity y", "-5 m/s²"),
            ("sheet 1: placement position y", "12.30 mm"),
            ("card: creases", "1"),
            ("body 0", "added"),
        ] {
            assert_eq!(said.iter().filter(|l| **l == wanted).count(), 1, "{wanted:?} in {said:?}");
        }
    }
}
