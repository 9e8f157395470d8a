//! Material of a sheet: preset, chosen by the droop of a strip, constants, delivered stiffness,
//! cost.

use bevy_egui::egui::{self, Grid, Sense, Ui, vec2};
use bevy_sheetwork::inspector::controls::{ControlOptions, name, parameter_row};
use bevy_sheetwork::inspector::hang::gamma;
use bevy_sheetwork::inspector::{constants, cost, delivered, droop, strip_shape};
use sheetwork::ParameterId as Id;
use sheetwork::scene::MaterialChoice;
use sheetwork::scene::material::{LIBRARY, by_name};

use super::EditorState;
use super::style::ACCENT;
use crate::session::Session;
use crate::units::{DisplayUnit, Quantity, format_si};

const DENSITY: DisplayUnit = DisplayUnit::fixed(Quantity::Density, "kg/m³", 1.0);

/// Preset, droop, constants, delivered stiffness and cost of the selected sheet.
pub fn material(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    super::sheet::choose(ui, session, state);
    let index = state.sheet;
    let Some(sheet) = session.world().sheets().get(index) else { return };
    let (now, size) = (sheet.material().clone(), sheet.rest_size());
    let length = state.previews.length.unwrap_or(size.0.max(size.1));
    presets(ui, session, state, index, length);
    droop(ui, session, &mut state.previews, &now, length);
    Grid::new("material").num_columns(2).show(ui, |ui| {
        constants(ui, session, index);
        let about = "Mass per volume. Type 1.05 g/cm³";
        let how = ControlOptions::usual(Id::MaterialDensity).on_release();
        let path = format!("sheets.{index}.material.density");
        parameter_row(ui, session, ("Density", about, &path), now.density, DENSITY, &how);
    });
    delivered(ui, session, index);
    cost(ui, session);
}

/// All materials of the library with the shape of a strip; a click chooses one.
fn presets(ui: &mut Ui, session: &mut Session, state: &mut EditorState, index: usize, length: f64) {
    let choice = session.scene().sheets.get(index).map(|s| s.material.clone());
    let (now, changed) = match &choice {
        Some(MaterialChoice::Named(name)) => (name.clone(), false),
        Some(MaterialChoice::File(file)) => {
            (file.file_stem().unwrap_or_default().to_string_lossy().into_owned(), false)
        }
        Some(MaterialChoice::Inline(m)) if !m.name.is_empty() => {
            let same = by_name(&m.name).is_ok_and(|preset| preset == *m);
            (m.name.clone(), !same)
        }
        _ => ("its own".to_owned(), false),
    };
    let text = if changed { format!("{now} (changed)") } else { now.clone() };
    let gravity = session.world().gravity().length();
    let mut chosen = None;
    ui.horizontal(|ui| {
        let label = name(ui, "Material", "Preset; another choice restarts the scene");
        let combo = egui::ComboBox::from_id_salt("material").selected_text(text).width(190.0).height(460.0);
        let shown = combo.show_ui(ui, |ui| {
            for (name, about, material) in LIBRARY {
                ui.horizontal(|ui| {
                    let strip = state.previews.strip(gamma(material, length, gravity));
                    let (rect, _) = ui.allocate_exact_size(vec2(46.0, 34.0), Sense::hover());
                    strip_shape(ui, rect, strip, ACCENT);
                    let about = format!(
                        "{about}. A strip of {} droops by {:.0} % of its length.",
                        format_si(length, "m"),
                        100.0 * strip.drop
                    );
                    if ui.selectable_label(*name == now, *name).on_hover_text(about).clicked() {
                        chosen = Some(*name);
                    }
                });
            }
        });
        shown.response.labelled_by(label.id);
        if changed && ui.small_button("⟲").on_hover_text(format!("Reset to {now} of the library")).clicked() {
            chosen = LIBRARY.iter().map(|row| row.0).find(|name| **name == *now);
        }
    });
    if let Some(name) = chosen.filter(|name| changed || **name != *now) {
        session.choose_material(index, name);
    }
}
