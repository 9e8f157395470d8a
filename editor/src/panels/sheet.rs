//! Description of a sheet: structure, grid, size, placement, damping, pins. Fields that need a new
//! sheet are applied on release of the mouse.

use bevy_egui::egui::{Button, ComboBox, Grid, RichText, Ui};
use bevy_sheetwork::inspector::behaviour;
use bevy_sheetwork::inspector::controls::{
    ControlOptions, DEGREES, MM, PLAIN, choice, input, name, number, tell, vector,
};
use sheetwork::mesh::structure::TABLE;
use sheetwork::scene::{InterLayerLaw, PinSpec, Region, SheetSpec, SpringLaw};

use super::EditorState;
use super::style::quiet;
use crate::session::Session;
use crate::units::format_si;

/// Structure, size, grid, springs, placement, damping, contact and pins of the selected sheet.
pub fn sheet(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    choose(ui, session, state);
    let index = state.sheet;
    let Some(sheet) = session.world().sheets().get(index) else {
        ui.weak("This scene has no sheet.");
        add(ui, session, state);
        return;
    };
    let text = format!(
        "{} nodes, {} springs, {}",
        sheet.node_count(),
        sheet.springs().len(),
        format_si(1e3 * sheet.total_mass(), "g")
    );
    ui.label(RichText::new(text).color(quiet(ui)));
    Grid::new("sheet").num_columns(2).show(ui, |ui| {
        structure(ui, session, index);
        shape(ui, session, index);
        placement(ui, session, index);
        behaviour(ui, session, index);
    });
    pins(ui, session, index);
    worked(ui, session, index);
    add(ui, session, state);
}

/// Choice of the sheet, where there are several.
pub(super) fn choose(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let sheets = session.world().sheets();
    state.sheet = state.sheet.min(sheets.len().saturating_sub(1));
    if sheets.len() < 2 {
        return;
    }
    let now = sheets.get(state.sheet).map_or("", |s| s.name.as_str());
    ui.horizontal(|ui| {
        let label = ui.label("Of sheet");
        let shown = ComboBox::from_id_salt("of sheet").selected_text(now).show_ui(ui, |ui| {
            for (index, sheet) in sheets.iter().enumerate() {
                ui.selectable_value(&mut state.sheet, index, sheet.name.as_str());
            }
        });
        shown.response.labelled_by(label.id);
    });
}

/// Edit the description of sheet `index`.
fn edit(session: &mut Session, index: usize, what: &str, change: impl FnOnce(&mut SheetSpec)) {
    session.edit_sheet(index, &format!("change of {what}"), &format!("sheets.{index}.{what}"), change);
}

/// Description of sheet `index` when the scene was opened, for a double click.
fn opened(session: &Session, index: usize) -> SheetSpec {
    session.document().opened().sheets.get(index).cloned().unwrap_or_default()
}

fn spec(session: &Session, index: usize) -> SheetSpec {
    session.scene().sheets.get(index).cloned().unwrap_or_default()
}

fn structure(ui: &mut Ui, session: &mut Session, index: usize) {
    let spec = spec(session, index);
    let label = name(ui, "Structure", "Discretisation: a shell, or a lattice of springs");
    let mut chosen = spec.structure;
    let from_file = spec.file.is_some();
    ui.add_enabled_ui(!from_file, |ui| {
        // The file of a sheet determines its structure.
        let own = session.world().sheets().get(index).map_or(spec.structure, |sheet| sheet.model.structure);
        let structures = TABLE.iter().map(|row| (row.kind, row.name, row.about));
        choice(ui, &label, ("structure", own.name(), 140.0), &mut chosen, structures);
    });
    if chosen != spec.structure {
        let (low, high) = chosen.info().layers;
        edit(session, index, "structure", |s| {
            s.structure = chosen;
            s.grid.1 = s.grid.1.clamp(low, high);
            if s.grid.1 < 2 {
                (s.inter_layer, s.inter_layer_stiffness) = (InterLayerLaw::Planar, None);
            }
        });
    }
    ui.end_row();
    let lattice = spec.structure.name() != "shell";
    if lattice {
        let label = name(ui, "Springs", "Law that determines spring stiffnesses from the material");
        let laws = [
            (SpringLaw::Uniform, "uniform", "The thesis's law: equal springs"),
            (SpringLaw::Calibrated, "calibrated", "Springs that reproduce the bending stiffness of the material"),
            (SpringLaw::Length, "by length", "E A / L of each spring"),
        ];
        let now = laws.iter().find(|l| l.0 == spec.springs).map_or("", |l| l.1);
        let mut law = spec.springs;
        choice(ui, &label, ("springs", now, 140.0), &mut law, laws);
        if law != spec.springs {
            edit(session, index, "springs", |s| {
                s.springs = law;
                if law != SpringLaw::Uniform {
                    // The other laws determine the springs between layers too.
                    (s.inter_layer, s.inter_layer_stiffness) = (InterLayerLaw::Planar, None);
                }
            });
        }
        ui.end_row();
    }
}

/// Whole number within bounds. Returns the new one after a change.
fn count(
    ui: &mut Ui,
    session: &mut Session,
    (title, about): (&str, &str),
    now: u32,
    (low, high): (u32, u32),
    first: u32,
) -> Option<u32> {
    let label = ui.weak(title).on_hover_text(about);
    let done = input(ui, &label, f64::from(now), PLAIN, &ControlOptions::speed(0.1).on_release());
    let whole = |v: f64| (v.round().clamp(0.0, 1e6) as u32).clamp(low, high);
    tell(session, title, done.error);
    let new = done.value.map(whole).or(done.reset.then_some(first));
    new.filter(|n| *n != now)
}

fn shape(ui: &mut Ui, session: &mut Session, index: usize) {
    let (spec, first) = (spec(session, index), opened(session, index));
    if let Some(file) = &spec.file {
        ui.label("File");
        ui.label(file.file_name().unwrap_or_default().to_string_lossy()).on_hover_text(file.display().to_string());
        ui.end_row();
        return;
    }
    name(ui, "Grid", "Nodes along length and width, and layers through the thickness");
    ui.horizontal(|ui| {
        ui.spacing_mut().interact_size.x = 30.0;
        let (low, high) = spec.structure.info().layers;
        let new_x = count(ui, session, ("nx", "Nodes along the length"), spec.grid.0, (2, 400), first.grid.0);
        let new_z = count(ui, session, ("nz", "Nodes along the width"), spec.grid.2, (2, 400), first.grid.2);
        let layers =
            count(ui, session, ("layers", "Layers through the thickness"), spec.grid.1, (low, high), first.grid.1);
        if new_x.or(new_z).or(layers).is_some() {
            let grid = (new_x.unwrap_or(spec.grid.0), layers.unwrap_or(spec.grid.1), new_z.unwrap_or(spec.grid.2));
            edit(session, index, "grid", |s| s.grid = grid);
        }
    });
    ui.end_row();
    let mut length = |ui: &mut Ui, title: &str, about: &str, now: f64, first: f64| -> Option<f64> {
        let done = number(ui, session, (title, about, title), now, MM, &ControlOptions::default().on_release());
        ui.end_row();
        done.value.or(done.reset.then_some(first)).filter(|v| *v != now)
    };
    let new_length = length(ui, "Length", "Along x, of the bottom layer", spec.size.0, first.size.0);
    let new_width = length(ui, "Width", "Along z, of the bottom layer", spec.size.1, first.size.1);
    let layered = spec.grid.1 > 1 && spec.springs != SpringLaw::Calibrated;
    let new_gap = if layered { length(ui, "Gap", "Distance between layers", spec.gap, first.gap) } else { None };
    if new_length.or(new_width).is_some() {
        let size = (new_length.unwrap_or(spec.size.0), new_width.unwrap_or(spec.size.1));
        edit(session, index, "size", |s| s.size = size);
    }
    if let Some(gap) = new_gap {
        edit(session, index, "gap", |s| s.gap = gap);
    }
}

fn placement(ui: &mut Ui, session: &mut Session, index: usize) {
    let (spec, first) = (spec(session, index), opened(session, index));
    name(ui, "Position", "Initial position of the middle of the bottom layer");
    let how = ControlOptions::speed(0.5).on_release();
    let (new, reset) = vector(ui, session, "place", spec.placement.position, MM, &how);
    if let Some(position) = new.or(reset.then_some(first.placement.position)) {
        edit(session, index, "place", |s| s.placement.position = position);
    }
    ui.end_row();
    name(ui, "Rotation", "Initial rotation about the fixed x, y and z axes, in this order");
    let (new, reset) = vector(ui, session, "turn", spec.placement.rotation, DEGREES, &how);
    if let Some(rotation) = new.or(reset.then_some(first.placement.rotation)) {
        edit(session, index, "turn", |s| s.placement.rotation = rotation);
    }
    ui.end_row();
}

const EDGES: [(Region, &str); 4] =
    [(Region::Left, "left"), (Region::Right, "right"), (Region::Back, "back"), (Region::Front, "front")];

/// Pins of the sheet: edges by a click, nodes by the pin tool.
fn pins(ui: &mut Ui, session: &mut Session, index: usize) {
    let spec = spec(session, index);
    ui.horizontal_wrapped(|ui| {
        ui.label("Pins").on_hover_text("Fixed edges; the pin tool in the view pins single nodes");
        for (region, title) in EDGES {
            let held = spec.pins.iter().find(|p| p.region == region);
            let clamped = held.is_some_and(|p| p.clamp);
            let text = if clamped { format!("{title} clamped") } else { title.to_owned() };
            let about = format!("The {title} edge: free, fixed, clamped (slope fixed too), in turn");
            if ui.selectable_label(held.is_some(), text).on_hover_text(about).clicked() {
                edit(session, index, &format!("{title} edge"), |s| {
                    let was = s.pins.iter().position(|p| p.region == region);
                    match was {
                        None => s.pins.push(PinSpec::fixed(region.clone())),
                        Some(at) if !s.pins[at].clamp && s.structure.name() == "shell" => s.pins[at].clamp = true,
                        Some(at) => _ = s.pins.remove(at),
                    }
                });
            }
        }
        let others: Vec<String> =
            spec.pins.iter().filter(|p| !EDGES.iter().any(|e| e.0 == p.region)).map(in_words).collect();
        if !others.is_empty() {
            ui.label(RichText::new(format!("and {}", others.join(", "))).color(quiet(ui)));
            if ui.small_button("✖").on_hover_text("Remove all pins").clicked() {
                edit(session, index, "pins", |s| s.pins.clear());
            }
        }
    });
}

/// Region of a pin that is not an edge, and its motion.
fn in_words(pin: &PinSpec) -> String {
    let held = match &pin.region {
        Region::All => "all nodes".to_owned(),
        Region::Border => "the whole border".to_owned(),
        Region::Point(u, v) => format!("the node at ({u}, {v})"),
        Region::Rect(u, v) => format!("u {} to {}, v {} to {}", u.0, u.1, v.0, v.1),
        Region::Masses(masses) if masses.len() == 1 => "1 node".to_owned(),
        Region::Masses(masses) => format!("{} nodes", masses.len()),
        Region::Left | Region::Right | Region::Back | Region::Front => "an edge".to_owned(),
    };
    pin.body.as_ref().map_or_else(|| held.clone(), |body| format!("{held} on {body}"))
}

/// Creases, slits and painted spots of the sheet.
fn worked(ui: &mut Ui, session: &mut Session, index: usize) {
    let spec = spec(session, index);
    for (k, crease) in spec.creases.iter().enumerate() {
        ui.horizontal(|ui| {
            let (title, about) =
                (format!("Crease {}", k + 1), "Rest angle of the crease; draw more with the crease tool");
            let how = ControlOptions::speed(0.5).on_release();
            let done = number(ui, session, (&title, about, "crease"), crease.angle, DEGREES, &how);
            if let Some(angle) = done.value {
                edit(session, index, &format!("crease {}", k + 1), |s| s.creases[k].angle = angle);
            }
            if ui.small_button("✖").on_hover_text("Remove this crease").clicked() {
                edit(session, index, "creases", |s| _ = s.creases.remove(k));
            }
        });
    }
    let lists = [("Cuts", spec.slits.len()), ("Painted spots", spec.spots.len())];
    for (title, count) in lists.into_iter().filter(|l| l.1 > 0) {
        ui.horizontal(|ui| {
            ui.label(title);
            ui.label(RichText::new(count.to_string()).color(quiet(ui)));
            if ui.small_button("✖").on_hover_text("Remove them; spots disappear with the next reset").clicked() {
                edit(session, index, title, |s| if title == "Cuts" { s.slits.clear() } else { s.spots.clear() });
            }
        });
    }
}

/// Buttons that add a sheet, or remove the selected one.
fn add(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.horizontal(|ui| {
        if ui.button("Generate…").on_hover_text("A new sheet, with a preview and its counts").clicked() {
            state.generate = Some(super::Draft::from_sheet(session, state.sheet));
        }
        let index = state.sheet;
        let some = index < session.scene().sheets.len();
        if ui.add_enabled(some, Button::new("Copy")).on_hover_text("A copy of the sheet, a little above").clicked() {
            session.edit("copy of a sheet", "copy", |scene| {
                let mut copy = scene.sheets[index].clone();
                copy.name = String::new();
                copy.placement.position.y += 0.1 * copy.size.0.max(copy.size.1);
                scene.sheets.push(copy);
            });
        }
        if ui.add_enabled(some, Button::new("Remove")).on_hover_text("Remove the sheet from the scene").clicked() {
            session.edit("removal of a sheet", "remove", |scene| _ = scene.sheets.remove(index));
        }
    });
}
