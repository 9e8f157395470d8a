//! Comparison: variants of the scene with one field changed, simulated at the same time, and their
//! results in numbers.

use bevy_egui::egui::{ComboBox, Grid, RichText, TextEdit, Ui};
use sheetwork::integrators::TABLE as ENGINES;
use sheetwork::mesh::structure::TABLE as STRUCTURES;
use sheetwork::scene::material::LIBRARY;

use super::style::{quiet, readable};
use super::{EditorState, plots::COLOURS};
use crate::session::{MAX_VARIANTS, Session, Variant};
use crate::units::format_si;

/// Offered fields: title, path with `#` for the index of the sheet.
const FIELDS: [(&str, &str); 8] = [
    ("structure", "sheets.#.structure"),
    ("integrator", "engine"),
    ("step", "dt"),
    ("material", "sheets.#.material"),
    ("Young", "sheets.#.material.young"),
    ("thickness", "sheets.#.material.thickness"),
    ("grid", "sheets.#.grid"),
    ("friction", "sheets.#.friction"),
];

/// Materials and structures offered first, in this order: more than the maximum number of variants.
const MATERIALS: [&str; 5] = ["card", "paper", "hips", "pvc", "steel-foil"];
const OTHERS: [&str; 5] = ["shell", "slamm", "provot3d", "trimm", "provot2d"];

/// Variants, and a table of all.
pub fn compare(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let now: Vec<Variant> = session.variants().map(|b| b.0.clone()).collect();
    let mut new = now.clone();
    let mut removed = None;
    for (index, variant) in new.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.label(RichText::new("■").color(COLOURS[(index + 1) % COLOURS.len()]));
            row(ui, index, variant, state);
            if ui.small_button("✖").on_hover_text("Remove this variant").clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        new.remove(index);
    }
    ui.horizontal(|ui| {
        if new.len() < MAX_VARIANTS
            && ui.button("Add a variant").on_hover_text("The scene with one field changed").clicked()
        {
            new.push(another(session, state.sheet, &new));
        }
        if !now.is_empty() && ui.button("Stop comparing").on_hover_text("Show the scene alone").clicked() {
            new.clear();
        }
    });
    if new != now {
        session.compare_with(new);
    }
    for (variant, found) in session.variants() {
        if let Err(problem) = found {
            ui.label(RichText::new(format!("{}: {problem}", variant.label())).color(ui.visuals().error_fg_color));
        }
    }
    if session.variants().next().is_some() {
        table(ui, session);
    } else {
        ui.weak("Variants of the scene side by side, at the same time, with one field changed: structure, integrator, step, material …");
    }
}

/// Variant that differs from the scene and the other variants: a shell of another material, a
/// lattice of another structure.
fn another(session: &Session, sheet: usize, others: &[Variant]) -> Variant {
    let structure = session.world().sheets().get(sheet).map_or("", |s| s.model.structure.name());
    let material = || session.scene().sheets.get(sheet).map_or(String::new(), |s| s.material.name());
    let (field, own, offered) = match structure {
        "shell" => ("material", material(), MATERIALS),
        lattice => ("structure", lattice.to_owned(), OTHERS),
    };
    let path = format!("sheets.{sheet}.{field}");
    let taken = |name: &str| name == own || others.iter().any(|v| v.path == path && v.value == name);
    let value = offered.into_iter().find(|name| !taken(name)).unwrap_or(offered[0]).to_owned();
    Variant { path, value }
}

/// Field and value of a variant.
fn row(ui: &mut Ui, index: usize, variant: &mut Variant, state: &EditorState) {
    let sheet = state.sheet.to_string();
    let title = FIELDS.iter().find(|f| f.1.replace('#', &sheet) == variant.path).map_or(variant.path.as_str(), |f| f.0);
    let mut path = variant.path.clone();
    ComboBox::from_id_salt(("field", index)).selected_text(title).width(88.0).show_ui(ui, |ui| {
        for (title, field) in FIELDS {
            ui.selectable_value(&mut path, field.replace('#', &sheet), title);
        }
    });
    if path != variant.path {
        let value = choices(&path).first().map_or_else(|| first_value(&path), |v| (*v).to_owned());
        *variant = Variant { path, value };
    }
    let offered = choices(&variant.path);
    if offered.is_empty() {
        let id = ui.id().with(("value", index));
        let mut text = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| variant.value.clone());
        let field = ui
            .add(TextEdit::singleline(&mut text).desired_width(90.0))
            .on_hover_text("As in a scene file, in SI or with a unit");
        if field.lost_focus() {
            variant.value = text.trim().to_owned();
            ui.data_mut(|d| d.remove::<String>(id));
        } else if field.has_focus() {
            ui.data_mut(|d| d.insert_temp(id, text));
        }
        return;
    }
    ComboBox::from_id_salt(("choice", index)).selected_text(variant.value.as_str()).width(110.0).show_ui(ui, |ui| {
        for name in offered {
            ui.selectable_value(&mut variant.value, name.to_owned(), name);
        }
    });
}

/// Values of a field with named values.
fn choices(path: &str) -> Vec<&'static str> {
    match path.rsplit('.').next() {
        Some("structure") => STRUCTURES.iter().map(|s| s.name).collect(),
        Some("engine") => ENGINES.iter().map(|e| e.name).collect(),
        Some("material") => LIBRARY.iter().map(|m| m.0).collect(),
        _ => Vec::new(),
    }
}

/// Initial value of a numeric field.
fn first_value(path: &str) -> String {
    let value = match path.rsplit('.').next() {
        Some("dt") => "5 ms",
        Some("young") => "1 GPa",
        Some("thickness") => "1 mm",
        Some("grid") => "(11, 1, 11)",
        _ => "0.5",
    };
    value.to_owned()
}

/// Table of all worlds: height of the first probe and its difference, energy, step time.
fn table(ui: &mut Ui, session: &Session) {
    // The displayed moment, not the last sample: a rollback may lie between.
    let time = session.world().time();
    let first = session.height_at(time);
    Grid::new("compared").num_columns(4).striped(true).show(ui, |ui| {
        let titles = [
            ("", ""),
            ("height", "Of the first probe, or of the first sheet's centre of mass"),
            ("difference", "From the scene at the same time"),
            ("step time", "Wall-clock time of a step"),
        ];
        for (title, about) in titles {
            ui.label(RichText::new(title).color(quiet(ui))).on_hover_text(about);
        }
        ui.end_row();
        let own = std::iter::once(("this scene".to_owned(), session));
        let others = session.variants().filter_map(|(variant, found)| Some((variant.label(), found.ok()?)));
        for (index, (name, one)) in own.chain(others).enumerate() {
            let broken = one.unstable_since();
            let name = if broken.is_some() { format!("✖ {name}") } else { name };
            let label = ui.label(RichText::new(name).color(readable(ui, COLOURS[index % COLOURS.len()])));
            if let Some(time) = broken {
                label.on_hover_text(format!("Unstable at {time:.4} s, and stopped"));
            }
            let now = one.height_at(time);
            ui.monospace(now.map_or_else(String::new, |h| format_si(h, "m")));
            let apart = now.zip(first).filter(|_| index > 0 && broken.is_none()).map(|(a, b)| format_si(a - b, "m"));
            ui.monospace(apart.unwrap_or_default());
            ui.monospace(if one.timing().step_s > 0.0 { format_si(one.timing().step_s, "s") } else { String::new() });
            ui.end_row();
        }
    });
}
