//! Study: a bar during a trial, windows with questions, and a picture of the real drop beside them.

use std::ops::RangeInclusive;

use bevy_egui::egui::{
    Align, Align2, Button, ColorImage, DragValue, Grid, Id, Image, Layout, RichText, TextEdit, TextureHandle,
    TextureOptions, Ui, WidgetInfo, WidgetType, Window,
};
use bevy_sheetwork::SheetLayer;
use sheetwork_rigs::bench::thesis::REFERENCES;
use sheetwork_rigs::study::{Background, LAST_QUESTIONS, QUESTIONS, Question, Sex, WeeklyHours};

use super::style::{self, quiet};
use super::{Display, EditorState};
use crate::camera::Camera;
use crate::picture::Picture;
use crate::scenes;
use crate::session::Session;
use crate::study::{Stage, Study};

/// Width of the picture of a real drop, points.
const REFERENCE_WIDTH: f32 = 340.0;

/// Display of a trial: the smoothed surface of the sheet and the room, without bodies, springs and
/// nodes.
pub fn blind() -> Display {
    Display { layer: SheetLayer::Top, smooth: true, surface: true, bodies: false, pins: false, ..Display::default() }
}

/// Open the dialog of the study.
pub(super) fn open(state: &mut EditorState) {
    // Any seed will do: it is shown, and can be typed again.
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seed = now.map_or(1, |t| t.as_secs() % 1_000_000);
    let mut study = Study::new(seed);
    // An absolute path, independent of the working directory.
    let folder = state.out.clone().or_else(|| std::env::current_dir().ok()).unwrap_or_default();
    study.file = folder.join(&study.file).display().to_string();
    state.study = Some(study);
}

/// The bar during a study, and its windows.
pub fn study(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut study) = state.study.take() else { return };
    let mut stays = true;
    match study.stage() {
        Stage::Welcome => welcome(ui, session, state, &mut study, &mut stays),
        Stage::Watching => {
            reference(ui, &study);
            if session.world().time() >= session.scene().duration {
                session.pause();
                study.ask();
            }
        }
        // The questions are below the view.
        Stage::Asking => reference(ui, &study),
        Stage::Last => {}
        Stage::Over => over(ui, &study, &mut stays),
    }
    keep_or_end(session, state, study, stays);
}

/// Picture of the real drop of a test, as the thesis showed footage beside each; nothing where the
/// file is missing.
fn reference(ui: &Ui, study: &Study) {
    let Some((test, _, caption)) =
        study.trial().and_then(|trial| REFERENCES.into_iter().find(|(test, ..)| *test == trial.test))
    else {
        return;
    };
    let id = Id::new(("reference of the study", test));
    let texture = ui.data_mut(|data| data.get_temp::<Option<TextureHandle>>(id)).unwrap_or_else(|| {
        let file = scenes::folder().map(|folder| folder.with_file_name("study").join(format!("{test}.png")));
        let texture = file.and_then(|file| Picture::read(&file)).map(|picture| {
            let size = [picture.width, picture.height].map(|side| side as usize);
            ui.ctx().load_texture(test, ColorImage::from_rgb(size, &picture.pixels), TextureOptions::LINEAR)
        });
        ui.data_mut(|data| data.insert_temp(id, texture.clone()));
        texture
    });
    let Some(texture) = texture else { return };
    let window = Window::new("The real sheet").resizable(false).anchor(Align2::RIGHT_TOP, [-10.0, 52.0]);
    window.show(ui.ctx(), |ui| {
        ui.add(Image::new(&texture).max_width(REFERENCE_WIDTH).alt_text(caption));
        ui.label(format!("{caption}: drawn from a computation with its moduli."));
    });
}

/// Bar during a trial; it does not identify the sheet.
pub(super) fn bar(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut study) = state.study.take() else { return };
    let mut stays = true;
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let (at, of) = study.progress();
        ui.label(RichText::new(format!("Sheet {} of {of}", at.min(of))).strong().size(16.0));
        ui.separator();
        if ui.button("⟲ See it again").on_hover_text("From the start").clicked() {
            session.reset();
            session.play();
        }
        if study.stage() == Stage::Watching
            && ui.add(style::first(ui, "Rate it")).on_hover_text("When you have seen enough").clicked()
        {
            session.pause();
            study.ask();
        }
        // Far from the frequently used buttons, at a fixed place.
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("Stop the study").on_hover_text("The answers so far stay in the file").clicked() {
                stays = false;
            }
        });
    });
    ui.add_space(4.0);
    keep_or_end(session, state, study, stays);
}

/// Keep the study, or end it and restore the session before it.
fn keep_or_end(session: &mut Session, state: &mut EditorState, study: Study, stays: bool) {
    if stays {
        state.study = Some(study);
        return;
    }
    session.pause();
    state.display = Display::default();
    if let Some((old, camera)) = state.aside.take() {
        session.replace_by(*old);
        state.display = state.display.for_session(session);
        state.camera = camera;
    }
}

/// Show the next sheet.
fn show(session: &mut Session, state: &mut EditorState, study: &Study) {
    let fresh = study.scene().and_then(|scene| Session::new(&scene));
    let Some(fresh) = session.accept(fresh) else { return };
    session.pause();
    let old = session.replace_by(fresh);
    // The session before the first trial.
    state.aside.get_or_insert_with(|| (Box::new(old), state.camera));
    state.display = blind();
    state.camera = Camera::from_session(session);
    session.play();
}

fn welcome(ui: &mut Ui, session: &mut Session, state: &mut EditorState, study: &mut Study, stays: &mut bool) {
    let mut open = true;
    let window = Window::new("Study").open(&mut open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, [0.0; 2]).show(ui.ctx(), |ui| {
        ui.set_max_width(470.0);
        ui.label(
            "A sheet falls on a hidden body: a cube, or one of two wedges, each with five kinds of sheet. Names are hidden, and the \
             order is random. After each trial you rate how it looked: 1 to 9, or N/A. It takes about a quarter of an hour. \
             The sheets are tested, not you; you may stop at any time.",
        );
        ui.add_space(6.0);
        Grid::new("study").num_columns(2).show(ui, |ui| {
            let label = ui.label("Subject").on_hover_text("A letter or number that identifies the subject");
            ui.add(TextEdit::singleline(&mut study.subject).desired_width(140.0)).labelled_by(label.id);
            ui.end_row();
            let label = ui.label("Answers").on_hover_text("A CSV file; answers of other subjects in it are kept");
            ui.add(TextEdit::singleline(&mut study.file).desired_width(320.0)).labelled_by(label.id);
            ui.end_row();
            let label = ui.label("Order").on_hover_text("Seed of the random order");
            ui.add(DragValue::new(&mut study.seed)).labelled_by(label.id);
            ui.end_row();
        });
        background(ui, &mut study.background);
        ui.weak("The open scene is restored afterwards.");
        ui.add_space(4.0);
        if ui.button(RichText::new("Begin").strong()).clicked() && session.accept(study.begin()).is_some() {
            show(session, state, study);
        }
    });
    *stays = open;
}

/// Questions about the subject; every one may be left out.
fn background(ui: &mut Ui, of: &mut Background) {
    ui.collapsing("About you (optional)", |ui| {
        Grid::new("background").num_columns(2).show(ui, |ui| {
            years(ui, "Age", &mut of.age, 1.0..=120.0);
            one_of(ui, "Sex", &mut of.sex, &Sex::ALL, Sex::name);
            years(ui, "Years of computing", &mut of.years, 0.0..=100.0);
            one_of(ui, "Hours a week at a computer", &mut of.hours, &WeeklyHours::ALL, WeeklyHours::name);
            let word: fn(bool) -> &'static str = |yes| if yes { "yes" } else { "no" };
            one_of(ui, "Familiar with computer simulation (not games)", &mut of.simulation, &[true, false], word);
            one_of(ui, "Familiar with advanced engineering or physics", &mut of.physics, &[true, false], word);
        });
    });
}

/// Row of a number of years that may be left out.
fn years(ui: &mut Ui, title: &str, value: &mut Option<f64>, range: RangeInclusive<f64>) {
    ui.label(title);
    ui.horizontal(|ui| {
        let mut given = value.is_some();
        if ui.checkbox(&mut given, "").changed() {
            *value = given.then_some(30.0_f64.clamp(*range.start(), *range.end()));
        }
        if let Some(number) = value {
            ui.add(DragValue::new(number).range(range).fixed_decimals(0).suffix(" years"));
        }
    });
    ui.end_row();
}

/// Row of a choice that may be left out: a second click takes it back.
fn one_of<T: Copy + PartialEq>(
    ui: &mut Ui,
    title: &str,
    value: &mut Option<T>,
    all: &[T],
    name: fn(T) -> &'static str,
) {
    ui.label(title);
    ui.horizontal(|ui| {
        for choice in all {
            let chosen = *value == Some(*choice);
            if ui.selectable_label(chosen, name(*choice)).clicked() {
                *value = (!chosen).then_some(*choice);
            }
        }
    });
    ui.end_row();
}

/// Present questions, below the view so that the sheet stays visible.
pub(super) fn questions(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut study) = state.study.take() else { return };
    let (title, all): (&str, &[Question]) = match study.stage() {
        Stage::Asking => ("How was it?", &QUESTIONS),
        _ => ("All in all", &LAST_QUESTIONS),
    };
    ui.add_space(6.0);
    ui.strong(title);
    ui.add_space(4.0);
    Grid::new("questions").num_columns(4).spacing([14.0, 5.0]).show(ui, |ui| {
        for (question, chosen) in all.iter().zip(&mut study.chosen) {
            ui.label(question.asks);
            ui.label(RichText::new(question.low).color(quiet(ui)));
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 3.0;
                for value in (1..=9).map(Some).chain([None]) {
                    let title = value.map_or_else(|| "N/A".to_owned(), |v: u8| v.to_string());
                    let about = format!("{} {title}", question.key);
                    let response =
                        ui.selectable_label(*chosen == Some(value), format!(" {title} ")).on_hover_text(&about);
                    // Ten answers in eight rows would otherwise have equal names.
                    response.widget_info(|| {
                        WidgetInfo::selected(WidgetType::SelectableLabel, true, *chosen == Some(value), &about)
                    });
                    if response.clicked() {
                        *chosen = Some(value);
                    }
                }
            });
            ui.label(RichText::new(question.high).color(quiet(ui)));
            ui.end_row();
        }
    });
    if study.stage() == Stage::Last {
        ui.add_space(4.0);
        let label = ui.label("Comments").on_hover_text("In your own words; may stay empty");
        ui.add(TextEdit::multiline(&mut study.comment).desired_rows(2)).labelled_by(label.id);
    }
    ui.add_space(4.0);
    let next = ui.add_enabled(study.is_answered(), Button::new(RichText::new("Next").strong()));
    if next.clicked() && session.accept(study.answer()) == Some(true) {
        show(session, state, &study);
    }
    ui.add_space(6.0);
    state.study = Some(study);
}

fn over(ui: &mut Ui, study: &Study, stays: &mut bool) {
    let window = Window::new("Thank you").collapsible(false).resizable(false).anchor(Align2::CENTER_CENTER, [0.0; 2]);
    window.show(ui.ctx(), |ui| {
        ui.label(format!("The answers are in {}.", study.file));
        ui.monospace(format!("sheetwork study {}", study.file));
        ui.label("evaluates them.");
        if ui.button("Close").clicked() {
            *stays = false;
        }
    });
}
