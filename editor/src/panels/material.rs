//! What a sheet is made of: a preset, chosen by how far a strip of it would hang, and its constants; what of its stiffness is delivered, and what it
//! costs.

use bevy_egui::egui::{self, Color32, Grid, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};
use sheetwork::scene::material::{LIBRARY, by_name};
use sheetwork::scene::{Material, MaterialChoice};

use super::EditorState;
use super::controls::{How, MM, PASCAL, PLAIN, dial, input, name, tell};
use super::style::{ACCENT, QUIET};
use crate::hang::{Hang, gamma, hang};
use crate::session::Session;
use crate::units::{Quantity, Shown, format_si};

const DENSITY: Shown = Shown::fixed(Quantity::Density, "kg/m³", 1.0);

/// Droop previews, worked out once for a material and a length.
#[derive(Clone, Debug, Default)]
pub struct Previews {
    /// Length of the strip, m; that of the sheet if none.
    pub length: Option<f64>,
    known: Vec<(u64, Hang)>,
}

impl Previews {
    /// The strip of this Γ.
    fn of(&mut self, gamma: f64) -> &Hang {
        let key = gamma.to_bits();
        let at = self.known.iter().position(|k| k.0 == key).unwrap_or_else(|| {
            if self.known.len() >= 64 {
                self.known.remove(0);
            }
            self.known.push((key, hang(gamma)));
            self.known.len() - 1
        });
        &self.known[at].1
    }
}

/// Preset, droop, constants, delivered stiffness and cost of the chosen sheet.
pub fn material(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    super::sheet::choose(ui, session, state);
    let index = state.sheet;
    let Some(sheet) = session.world().sheets().get(index) else { return };
    let (now, follows, size) = (sheet.material().clone(), sheet.follows_material(), sheet.rest_size());
    let length = state.previews.length.unwrap_or(size.0.max(size.1));
    presets(ui, session, state, index, length);
    droop(ui, session, state, &now, length);
    Grid::new("material").num_columns(2).show(ui, |ui| {
        let path = |name: &str| format!("sheets.{index}.material.{name}");
        if now.orthotropic.is_some() {
            ui.label("Stiffness").on_hover_text("Measured along warp and weft: the scene's file has the numbers");
            ui.label(format_si(now.plate_stiffness(), "N m"));
            ui.end_row();
        }
        let about = "Young's modulus: how hard it is to stretch. Type 2.1 GPa, or 3G for 3 GPa";
        dial(ui, session, ("Young", about, &path("young")), now.young, PASCAL, &How::log(1.0..=1e11));
        let about = "Thickness: bending goes with its cube. Type 0.3 mm, 16 µm";
        let how = How { logarithmic: true, late: true, ..How::slider(1e-5..=5e-3) };
        dial(ui, session, ("Thickness", about, &path("thickness")), now.thickness, MM, &how);
        if follows {
            let about = "Poisson's ratio: how much it narrows when it is stretched";
            dial(ui, session, ("Poisson", about, &path("poisson")), now.poisson, PLAIN, &How::slider(0.0..=0.49));
        }
        let about = "Density; with the thickness it makes the weight. Type 1.05 g/cm³";
        let how = How { late: true, ..How::log(10.0..=2e4) };
        dial(ui, session, ("Density", about, &path("density")), now.density, DENSITY, &how);
    });
    delivered(ui, session, index);
    cost(ui, session);
}

/// Every material of the library with the shape of its strip; a click takes it.
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
        let label = name(ui, "Material", "A preset; choosing another starts the scene anew");
        let combo = egui::ComboBox::from_id_salt("material").selected_text(text).width(190.0).height(460.0);
        let shown = combo.show_ui(ui, |ui| {
            for (name, about, material) in LIBRARY {
                ui.horizontal(|ui| {
                    let strip = state.previews.of(gamma(material, length, gravity));
                    let (rect, _) = ui.allocate_exact_size(vec2(46.0, 34.0), Sense::hover());
                    strip_shape(ui, rect, strip, ACCENT);
                    let about = format!(
                        "{about}. A strip of {} hangs by {:.0} % of its length.",
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
        if changed && ui.small_button("⟲").on_hover_text(format!("Back to {now} as it is in the library")).clicked() {
            chosen = LIBRARY.iter().map(|row| row.0).find(|name| **name == *now);
        }
    });
    if let Some(name) = chosen.filter(|name| changed || **name != *now) {
        session.choose_material(index, name);
    }
}

/// A hanging strip, drawn to scale into `rect`, its clamp at the upper left.
fn strip_shape(ui: &Ui, rect: Rect, strip: &Hang, colour: Color32) {
    let painter = ui.painter_at(rect);
    let (room, from) = (rect.shrink(3.0), rect.shrink(3.0).left_top() + vec2(0.0, 2.0));
    let scale = room.width().min(room.height() - 2.0);
    let at =
        |(r, d): &(f32, f32)| pos2(from.x + 4.0 + r * scale * (room.width() - 4.0) / room.width(), from.y + d * scale);
    let block = Rect::from_min_size(from - vec2(1.0, 3.0), vec2(5.0, 6.0));
    painter.rect_filled(block, 1.0, ui.visuals().weak_text_color());
    painter.add(Shape::line(strip.points.iter().map(at).collect(), Stroke::new(1.8, colour)));
}

/// How far a strip of the present material hangs, at a length that can be typed.
fn droop(ui: &mut Ui, session: &mut Session, state: &mut EditorState, now: &Material, length: f64) {
    let gravity = session.world().gravity().length();
    let number = gamma(now, length, gravity);
    let strip = state.previews.of(number).clone();
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(86.0, 74.0), Sense::hover());
        ui.painter_at(rect).rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        strip_shape(ui, rect.shrink(5.0), &strip, ACCENT);
        response.on_hover_text(format!(
            "Shape of a strip clamped level at its left end, under {gravity:.3} m/s² (Γ = {number:.3})"
        ));
        ui.vertical(|ui| {
            ui.horizontal(|ui| {
                let label =
                    name(ui, "Strip of", "Length of the strip in the preview; a double click takes the sheet's own");
                let done = input(ui, &label, length, MM, &How::default());
                state.previews.length = done.value.map(|v| v.clamp(1e-6, 1e3)).or(state.previews.length);
                tell(session, "strip", done.error);
                if done.reset {
                    state.previews.length = None;
                }
            });
            ui.label(RichText::new(format!("hangs by {}", format_si(strip.drop * length, "m"))).strong());
            ui.label(RichText::new(format!("{:.1} % of its length", 100.0 * strip.drop)).color(QUIET));
        });
    });
}

/// What is delivered of the stiffness that was asked for.
fn delivered(ui: &mut Ui, session: &Session, index: usize) {
    let world = session.world();
    let Some(sheet) = world.sheets().get(index) else { return };
    let Some(found) = sheet.delivered_stiffness(world.dt()) else {
        if !sheet.follows_material() {
            ui.weak("Springs by the thesis's rule: soft, and stiffer on a finer grid.").on_hover_text(
                "Choose the structure shell, or calibrated springs, for a sheet that bends as its material on any grid",
            );
        }
        return;
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new("Asked").color(QUIET));
        ui.monospace(format_si(found.asked_pa, "Pa"));
        ui.label(RichText::new("bends as").color(QUIET));
        let part = found.bends_as_pa / found.asked_pa.max(1e-300);
        let text = RichText::new(format_si(found.bends_as_pa, "Pa")).monospace();
        let text = if part < 0.9 { text.color(ui.visuals().warn_fg_color) } else { text };
        let percent = |part: f64| format!("{:.2} %", 100.0 * part);
        ui.label(text).on_hover_text(format!(
            "Structure {}, grid {} for the present shape, step {} for the present motion",
            percent(found.structure),
            percent(found.grid),
            percent(found.step)
        ));
    });
}

/// What a step takes, and a warning where that is more than there is.
pub(super) fn cost(ui: &mut Ui, session: &Session) {
    let Some(factor) = session.real_time_factor() else { return };
    let text =
        format!("a step takes {} of {}", format_si(session.timing().step_s, "s"), format_si(session.world().dt(), "s"));
    // A frame has other things to do, too.
    if factor * 0.8 < session.speed() {
        let about = "A coarser grid, a longer step with an implicit engine, or less speed bring it back";
        let warning = format!("⚠ not real time: {text}, {factor:.2}× at most");
        ui.label(RichText::new(warning).color(ui.visuals().warn_fg_color)).on_hover_text(about);
    } else {
        ui.label(RichText::new(format!("{text}, {factor:.0}× real time")).color(QUIET));
    }
}
