//! Controls of a sheet's material: constants, droop of a strip, delivered stiffness, cost.

use bevy_egui::egui::{Color32, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};
use sheetwork::ParameterId as Id;
use sheetwork::scene::Material;

use super::ParameterAccess;
use super::controls::{ControlOptions, MM, PASCAL, PLAIN, number, parameter_row, usual_row};
use super::hang::{Hang, gamma, hang};
use super::style::{ACCENT, quiet};
use super::units::format_si;

/// Cache of droop previews.
#[derive(Clone, Debug, Default)]
pub struct Previews {
    /// Length of the strip, m; `None` for that of the sheet.
    pub length: Option<f64>,
    known: Vec<(u64, Hang)>,
}

impl Previews {
    /// Shape of the strip with load parameter Γ.
    pub fn strip(&mut self, gamma: f64) -> &Hang {
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

/// Rows of Young's modulus, thickness and Poisson's ratio of sheet `index` in a grid of two
/// columns.
pub fn constants(ui: &mut Ui, access: &mut dyn ParameterAccess, index: usize) {
    let Some(sheet) = access.world().sheets().get(index) else { return };
    let (now, follows) = (sheet.material().clone(), sheet.follows_material());
    let path = |name: &str| format!("sheets.{index}.material.{name}");
    if now.orthotropic.is_some() {
        ui.label("Stiffness").on_hover_text("Orthotropic; its numbers are in the scene file");
        ui.label(format_si(now.plate_stiffness(), "N m"));
        ui.end_row();
    }
    let about = "Young's modulus: stress per strain. Type 2.1 GPa, or 3G for 3 GPa";
    usual_row(ui, access, ("Young", about, &path("young")), now.young, PASCAL, Id::MaterialYoung);
    let about = "Thickness; bending stiffness grows with its cube. Type 0.3 mm, 16 µm";
    let how = ControlOptions::usual(Id::MaterialThickness).on_release();
    parameter_row(ui, access, ("Thickness", about, &path("thickness")), now.thickness, MM, &how);
    if follows {
        let about = "Poisson's ratio: transverse contraction per extension";
        usual_row(ui, access, ("Poisson", about, &path("poisson")), now.poisson, PLAIN, Id::MaterialPoisson);
    }
    if let Some(value) = now.thesis_sensitivity {
        let about = "Thermal sensitivity of the thesis's formulas: stiffness lost per kelvin at one metre, N/K";
        let row = ("Sensitivity", about, &*path("thesis_sensitivity"));
        usual_row(ui, access, row, value, PLAIN, Id::MaterialThesisSensitivity);
    }
    if let Some(value) = now.thesis_conductivity {
        let about = "Thermal conductivity coefficient of the thesis's formulas: spreads the effect of a heater";
        let row = ("Spread", about, &*path("thesis_conductivity"));
        usual_row(ui, access, row, value, PLAIN, Id::MaterialThesisConductivity);
    }
}

/// Draw a hanging strip to scale into `rect`, its clamp at the upper left.
pub fn strip_shape(ui: &Ui, rect: Rect, strip: &Hang, colour: Color32) {
    let painter = ui.painter_at(rect);
    let (room, from) = (rect.shrink(3.0), rect.shrink(3.0).left_top() + vec2(0.0, 2.0));
    let scale = room.width().min(room.height() - 2.0);
    let at =
        |(r, d): &(f32, f32)| pos2(from.x + 4.0 + r * scale * (room.width() - 4.0) / room.width(), from.y + d * scale);
    let block = Rect::from_min_size(from - vec2(1.0, 3.0), vec2(5.0, 6.0));
    painter.rect_filled(block, 1.0, ui.visuals().weak_text_color());
    painter.add(Shape::line(strip.points.iter().map(at).collect(), Stroke::new(1.8, colour)));
}

/// Droop of a strip of the present material, at a length that can be typed.
pub fn droop(ui: &mut Ui, access: &mut dyn ParameterAccess, previews: &mut Previews, now: &Material, length: f64) {
    let gravity = access.world().gravity().length();
    let load = gamma(now, length, gravity);
    let strip = previews.strip(load).clone();
    ui.horizontal(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(86.0, 74.0), Sense::hover());
        ui.painter_at(rect).rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        strip_shape(ui, rect.shrink(5.0), &strip, ACCENT);
        response.on_hover_text(format!(
            "Shape of a strip clamped level at its left end, under {gravity:.3} m/s² (Γ = {load:.3})"
        ));
        ui.vertical(|ui| {
            ui.horizontal(|ui| {
                let about = "Length of the strip in the preview; a double click takes the sheet's own";
                let done = number(ui, access, ("Strip of", about, "strip"), length, MM, &ControlOptions::default());
                previews.length = done.value.map(|v| v.clamp(1e-6, 1e3)).or(previews.length);
                if done.reset {
                    previews.length = None;
                }
            });
            ui.label(RichText::new(format!("droops by {}", format_si(strip.drop * length, "m"))).strong());
            ui.label(RichText::new(format!("{:.1} % of its length", 100.0 * strip.drop)).color(quiet(ui)));
        });
    });
}

/// Delivered stiffness, relative to the requested one.
pub fn delivered(ui: &mut Ui, access: &dyn ParameterAccess, index: usize) {
    let world = access.world();
    let Some(sheet) = world.sheets().get(index) else { return };
    let Some(found) = sheet.delivered_stiffness(world.dt()) else {
        if !sheet.follows_material() {
            ui.weak("Springs by the thesis's law: soft, and stiffer on a finer grid.").on_hover_text(
                "Choose the shell, or calibrated springs, for the material's bending stiffness on any grid",
            );
        }
        return;
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new("Requested").color(quiet(ui)));
        ui.monospace(format_si(found.asked_pa, "Pa"));
        ui.label(RichText::new("delivered").color(quiet(ui)));
        let part = found.bends_as_pa / found.asked_pa.max(1e-300);
        let text = RichText::new(format_si(found.bends_as_pa, "Pa")).monospace();
        let text = if part < 0.9 { text.color(ui.visuals().warn_fg_color) } else { text };
        let percent = |part: f64| format!("{:.2} %", 100.0 * part);
        ui.label(text).on_hover_text(format!(
            "Structure {}, grid {} for the present shape, time step {} for the present motion",
            percent(found.structure),
            percent(found.grid),
            percent(found.step)
        ));
    });
}

/// A factor with its significant digits.
fn times(factor: f64) -> String {
    if factor < 10.0 { format!("{factor:.1}×") } else { format!("{factor:.0}×") }
}

/// Cost of a step, and a warning where it exceeds real time.
pub fn cost(ui: &mut Ui, access: &dyn ParameterAccess) {
    let Some(factor) = access.real_time_factor() else { return };
    let text = format!("a step takes {} of {}", format_si(access.step_s(), "s"), format_si(access.world().dt(), "s"));
    // A frame needs 20 % of its time for other work.
    if factor * 0.8 < access.speed() {
        let about = "Use a coarser grid, a longer step with an implicit integrator, or a lower speed";
        let what = if factor < access.speed() { "slower than requested" } else { "close to the limit" };
        let warning = format!("⚠ {what}: {text}, {factor:.2}× real time at most");
        ui.label(RichText::new(warning).color(ui.visuals().warn_fg_color)).on_hover_text(about);
    } else {
        ui.label(RichText::new(format!("{text}, {} real time", times(factor))).color(quiet(ui)));
    }
}
