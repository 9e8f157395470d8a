//! What a sheet is made of, changed while it runs.

use bevy_egui::egui::{ComboBox, Grid, Ui};

use sheetwork::scene::MaterialChoice;
use sheetwork::scene::material::LIBRARY;

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
    let (material, damping, ratio) = (sheet.material().clone(), sheet.damping(), sheet.damping_ratio());
    let (follows, drag, airy) = (sheet.follows_material(), sheet.drag(), session.world().air().density > 0.0);
    let (friction, restitution) = (sheet.friction, sheet.restitution);
    let path = |name: &str| format!("sheets.{index}.{name}");
    Grid::new("sheet").num_columns(2).show(ui, |ui| {
        materials(ui, session, index);
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
        if follows {
            let about = "Poisson's ratio: how much it narrows when it is stretched";
            let poisson = path("material.poisson");
            slider(ui, session, ("Poisson", about, &poisson), (material.poisson, 0.0..=0.49), |s| s.max_decimals(3));
            let about = "Damping ratio of the slowest bending motion; faster ones are damped more";
            let damping_path = path("damping_ratio");
            slider(ui, session, ("Damping", about, &damping_path), (ratio, 0.0..=0.5), |s| s.max_decimals(4));
        } else {
            let about = "Dashpots along the springs, as a fraction of critical";
            let damping_path = path("damping");
            slider(ui, session, ("Damping", about, &damping_path), (damping, 0.0..=1.0), |s| s.max_decimals(3));
        }
        if airy {
            let (across, along) = (path("drag.0"), path("drag.1"));
            let about = "Drag coefficient where the air meets the sheet's face";
            slider(ui, session, ("Drag", about, &across), (drag.0, 0.0..=2.0), |s| s.max_decimals(3));
            let about = "Drag coefficient where the air runs along the sheet";
            slider(ui, session, ("… along", about, &along), (drag.1, 0.0..=0.2), |s| s.max_decimals(4));
        }
        let friction_path = path("friction");
        let about = "Coulomb friction coefficient of the sheet";
        slider(ui, session, ("Friction", about, &friction_path), (friction, 0.0..=1.0), |s| s.max_decimals(3));
        let restitution_path = path("restitution");
        let about = "Part of the speed of impact that is given back";
        slider(ui, session, ("Restitution", about, &restitution_path), (restitution, 0.0..=1.0), |s| s.max_decimals(3));
        flexion_limit(ui, session, index);
    });
}

/// The materials of the library. Mass and shape are another material's too, so that choosing one starts the scene anew.
fn materials(ui: &mut Ui, session: &mut Session, index: usize) {
    let label = ui.label("Material");
    let now = match session.world().scene().sheets.get(index).map(|s| &s.material) {
        Some(MaterialChoice::Named(name)) => name.clone(),
        Some(MaterialChoice::File(file)) => file.display().to_string(),
        _ => "its own".to_owned(),
    };
    let mut chosen = now.clone();
    let shown = ComboBox::from_id_salt("material").selected_text(&now).width(150.0).show_ui(ui, |ui| {
        for (name, about, _) in LIBRARY {
            ui.selectable_value(&mut chosen, (*name).to_owned(), *name).on_hover_text(*about);
        }
    });
    shown.response.labelled_by(label.id).on_hover_text("Choosing another starts the scene anew");
    if chosen != now {
        session.choose_material(index, &chosen);
    }
    ui.end_row();
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
