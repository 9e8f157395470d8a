//! What a sheet is made of, changed while it runs.

use bevy_egui::egui::{ComboBox, Grid, Ui};

use super::EditorState;
use super::controls::{format_si, number, parse_si, slider};
use crate::session::Session;

/// Material, damping and contact of the chosen sheet.
pub fn sheet(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let count = session.world().sheets().len();
    state.sheet = state.sheet.min(count.saturating_sub(1));
    if count > 1 {
        choose(ui, session, state);
    }
    let index = state.sheet;
    let Some(sheet) = session.world().sheets().get(index) else {
        ui.weak("This scene has no sheet.");
        return;
    };
    let (nx, layers, nz) = sheet.grid;
    ui.weak(format!("{} {nx}×{layers}×{nz}, {}", sheet.structure, format_si(1e3 * sheet.total_mass(), "g")));
    let (material, damping) = (sheet.material().clone(), sheet.damping());
    let (friction, restitution) = (sheet.friction, sheet.restitution);
    let path = |name: &str| format!("sheets.{index}.{name}");
    Grid::new("sheet").num_columns(2).show(ui, |ui| {
        let about = "Young's modulus: how hard the sheet is to stretch. Type 3G for 3 GPa";
        let names = ("Young", about, path("material.young"));
        slider(ui, session, (names.0, names.1, &names.2), (material.young, 1.0..=1e11), |s| {
            s.logarithmic(true).custom_formatter(|v, _| format_si(v, "Pa")).custom_parser(|text| parse_si(text, "Pa"))
        });
        let label = ui.label("Thickness");
        if let Some(value) = number(ui, &label, material.thickness, 1e3, 0.005, " mm") {
            session.set(&path("material.thickness"), &value.to_string());
        }
        ui.end_row();
        let about = "Dashpots along the springs, as a fraction of critical";
        let damping_path = path("damping");
        slider(ui, session, ("Damping", about, &damping_path), (damping, 0.0..=1.0), |s| s.max_decimals(3));
        let friction_path = path("friction");
        let about = "Coulomb friction coefficient of the sheet";
        slider(ui, session, ("Friction", about, &friction_path), (friction, 0.0..=1.0), |s| s.max_decimals(3));
        let restitution_path = path("restitution");
        let about = "Part of the speed of impact that is given back";
        slider(ui, session, ("Restitution", about, &restitution_path), (restitution, 0.0..=1.0), |s| s.max_decimals(3));
        flexion_limit(ui, session, index);
    });
}

fn choose(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let sheets = session.world().sheets();
    let now = sheets.get(state.sheet).map_or("", |s| s.name.as_str());
    ComboBox::from_label("of").selected_text(now).show_ui(ui, |ui| {
        for (index, sheet) in sheets.iter().enumerate() {
            ui.selectable_value(&mut state.sheet, index, sheet.name.as_str());
        }
    });
}

/// The angle limit, for structures with flexion triples.
fn flexion_limit(ui: &mut Ui, session: &mut Session, index: usize) {
    let Some(sheet) = session.world().sheets().get(index) else { return };
    let Some(largest) = sheet.largest_flexion_angle() else { return };
    let (limit, path) = (sheet.flexion_angle_limit(), format!("sheets.{index}.flexion_limit"));
    let mut limited = limit.is_some();
    if ui.checkbox(&mut limited, "Bend limit").on_hover_text("Largest angle a flexion triple may bend to").changed() {
        let value = if limited { largest.clamp(30.0, 180.0).to_string() } else { "none".to_owned() };
        session.set(&path, &value);
    }
    match limit {
        Some(now) => {
            let mut value = now;
            let slider = bevy_egui::egui::Slider::new(&mut value, 1.0..=180.0)
                .clamping(bevy_egui::egui::SliderClamping::Never)
                .update_while_editing(false)
                .suffix("°");
            if ui.add(slider).changed() && value != now {
                session.set(&path, &value.to_string());
            }
        }
        None => {
            ui.weak(format!("bends to {largest:.1}° now"));
        }
    }
    ui.end_row();
}
