//! Window of an export: rate and duration, then progress.

use bevy_egui::egui::{DragValue, Grid, ProgressBar, Ui, Window};

use super::EditorState;
use crate::export::{Job, Kind, MAX_TARGETS, moments, picture_file};
use crate::picture::LARGEST;
use crate::session::Session;
use crate::units::{DisplayUnit, Quantity};
use bevy_sheetwork::inspector::controls::{ControlOptions, number};
use sheetwork::World;

const SECOND: DisplayUnit = DisplayUnit::fixed(Quantity::Time, "s", 1.0);
/// Time of an export per frame, ms.
const BUDGET_MS: u128 = 25;

/// The window, while there is an export; part of the work is done in every frame.
pub fn export(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut job) = state.export.take() else { return };
    let title = if job.kind == Kind::Gltf { "Export glTF" } else { "Export pictures" };
    let mut open = true;
    let window = Window::new(title).open(&mut open).collapsible(false).resizable(false);
    window.default_pos([340.0, 90.0]).show(ui.ctx(), |ui| {
        ui.label(job.file.display().to_string());
        if job.has_begun() {
            ui.add(ProgressBar::new(job.progress()).show_percentage().desired_width(300.0));
            return;
        }
        show_settings(ui, session, &mut job);
        if job.kind == Kind::Gltf {
            ui.weak(format!(
                "Sheets as morph targets, bodies and heaters as glTF nodes; at most {MAX_TARGETS} moments."
            ));
        }
        let count = moments(job.rate, job.seconds, usize::MAX).map_or(0, |count| count);
        ui.weak(if count == 1 { "1 moment".to_owned() } else { format!("{count} moments") });
        ui.weak("The run continues from the present state; the open session is unchanged.");
        if ui.button("Write").clicked() {
            session.pause();
            let begun = job.begin(session, &state.camera);
            session.accept(begun);
        }
    });
    let has_ended = advance(ui, session, &mut job);
    if open && !has_ended {
        state.export = Some(job);
    }
}

/// Rate, duration and picture size of the export.
fn show_settings(ui: &mut Ui, session: &mut Session, job: &mut Job) {
    Grid::new("export").num_columns(2).show(ui, |ui| {
        let often = if job.kind == Kind::Gltf { "Per second" } else { "Pictures per second" };
        let label = ui.label(often).on_hover_text("Moments per simulated second, 0.01 to 10000");
        ui.add(DragValue::new(&mut job.rate).range(0.01..=1e4).speed(0.1)).labelled_by(label.id);
        ui.end_row();
        let row = ("Duration", "Simulated time from the present state on, s", "duration");
        let done = number(ui, session, row, job.seconds, SECOND, &ControlOptions::speed(0.02));
        job.seconds = done.value.map_or(job.seconds, |seconds| seconds.clamp(0.0, 1e6));
        ui.end_row();
        if let Kind::Sequence(_, (width, height)) = &mut job.kind {
            let label = ui.label("Size").on_hover_text("Of each picture, pixels: width and height");
            ui.horizontal(|ui| {
                for side in [width, height] {
                    ui.add(DragValue::new(side).range(16..=LARGEST).speed(2.0)).labelled_by(label.id);
                }
            });
            ui.end_row();
        }
    });
}

/// Do the work of one frame. Returns whether the export has ended, with success or an error.
fn advance(ui: &Ui, session: &mut Session, job: &mut Job) -> bool {
    let start = std::time::Instant::now();
    while job.has_begun() && start.elapsed().as_millis() < BUDGET_MS {
        match job.step() {
            Ok(false) => ui.ctx().request_repaint(),
            Ok(true) => {
                told(session, job);
                return true;
            }
            Err(error) => {
                session.fail(error.to_string());
                return true;
            }
        }
    }
    false
}

/// Report the written files, and instability of the run.
fn told(session: &mut Session, job: &Job) {
    match &job.kind {
        Kind::Sequence(..) => {
            session.note(format!("written: {} and those after it", picture_file(&job.file, 0).display()));
        }
        Kind::Gltf => session.note(format!("written: {}", job.file.display())),
    }
    if let Some(sheet) = job.world().and_then(World::unstable) {
        session.fail(format!("in the written run {} became unstable and was stopped", sheet.name));
    }
}
