//! Generation of a sheet: structure, grid and size with a preview and counts, for the scene or a
//! file.

use bevy_egui::egui::{Grid, RichText, Sense, Stroke, Ui, Window, pos2, vec2};
use sheetwork::mesh::structure::TABLE;
use sheetwork::scene::{SheetSpec, sht};
use sheetwork::sheet::to_file;

use super::EditorState;
use super::draft::{Draft, one};
use super::style::ACCENT;
use crate::session::Session;
use bevy_sheetwork::inspector::controls::{ControlOptions, MM, PLAIN, choice, name, number};

/// The dialog, while it is open.
pub fn generate(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut draft) = state.generate.take() else { return };
    let (mut open, mut done) = (true, false);
    let window =
        Window::new("Generate a sheet").open(&mut open).collapsible(false).resizable(false).default_pos([340.0, 90.0]);
    window.show(ui.ctx(), |ui| {
        draft.build(session);
        ui.horizontal(|ui| {
            picture(ui, &draft);
            ui.vertical(|ui| {
                Grid::new("generate").num_columns(2).show(ui, |ui| fields(ui, session, &mut draft.spec));
                if let Some((_, Ok(found))) = &draft.built {
                    let text = format!("{} nodes, {} springs, {:.3} g", found.masses, found.springs, found.grams);
                    ui.label(RichText::new(text).strong());
                }
                if let Some((_, Err(problem))) = &draft.built {
                    ui.label(RichText::new(problem).color(ui.visuals().error_fg_color));
                }
            });
        });
        let fine = matches!(&draft.built, Some((_, Ok(_))));
        ui.add_enabled_ui(fine, |ui| {
            ui.horizontal(|ui| {
                if ui.button("Add to the scene").on_hover_text("As one edit, with undo").clicked() {
                    let spec = draft.spec.clone();
                    done = session.edit("generated sheet", "generate", |s| s.sheets.push(spec));
                }
                let label = ui.label("File");
                let field = bevy_egui::egui::TextEdit::singleline(&mut draft.file).desired_width(150.0);
                ui.add(field).labelled_by(label.id);
                if ui
                    .button("Write .SHT")
                    .on_hover_text("Sheet file of the thesis, also readable by `sheetwork`")
                    .clicked()
                {
                    write(session, &draft);
                }
            });
        });
    });
    if open && !done {
        state.generate = Some(draft);
    }
}

fn write(session: &mut Session, draft: &Draft) {
    let file = std::path::PathBuf::from(draft.file.trim());
    let written = one(session.scene(), &draft.spec).and_then(|sheet| sht::write_sht_file(&file, &to_file(&sheet)));
    if session.accept(written).is_some() {
        session.note(format!("written: {}", file.display()));
    }
}

fn fields(ui: &mut Ui, session: &mut Session, spec: &mut SheetSpec) {
    let label = name(ui, "Structure", "Discretisation: a shell, or a lattice of springs");
    let structures = TABLE.iter().map(|row| (row.kind, row.name, row.about));
    let now = ("new structure", spec.structure.name(), ui.spacing().combo_width);
    choice(ui, &label, now, &mut spec.structure, structures);
    ui.end_row();
    let (low, high) = spec.structure.info().layers;
    let mut count = |ui: &mut Ui, title: &str, now: u32, (low, high): (u32, u32)| {
        let how = ControlOptions::speed(0.1);
        let done = number(ui, session, (title, "Nodes", title), f64::from(now), PLAIN, &how);
        ui.end_row();
        (done.value.unwrap_or(f64::from(now)).round().clamp(0.0, 1e6) as u32).clamp(low, high)
    };
    spec.grid.0 = count(ui, "Along the length", spec.grid.0, (2, 200));
    spec.grid.1 = count(ui, "Layers", spec.grid.1, (low, high));
    spec.grid.2 = count(ui, "Along the width", spec.grid.2, (2, 200));
    let mut length = |ui: &mut Ui, title: &str, now: f64| {
        let done = number(ui, session, (title, "", title), now, MM, &ControlOptions::default());
        ui.end_row();
        done.value.unwrap_or(now)
    };
    spec.size.0 = length(ui, "New length", spec.size.0);
    spec.size.1 = length(ui, "New width", spec.size.1);
    if spec.grid.1 > 1 {
        spec.gap = length(ui, "New gap", spec.gap);
    }
}

fn picture(ui: &mut Ui, draft: &Draft) {
    let (rect, _) = ui.allocate_exact_size(vec2(210.0, 210.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let Some((spec, Ok(found))) = &draft.built else { return };
    let scale = (rect.width() - 20.0) / (spec.size.0.max(spec.size.1).max(1e-9) as f32);
    let at = |(x, z): (f64, f64)| pos2(rect.center().x + x as f32 * scale, rect.center().y + z as f32 * scale);
    // All lines of a large sheet would be slow and appear as a grey square.
    let every = found.lines.len() / 6000 + 1;
    for [a, b] in found.lines.iter().step_by(every) {
        painter.line_segment([at(*a), at(*b)], Stroke::new(0.8, ACCENT));
    }
}
