//! Controls of the integrator, its step, gravity, air and wind.

use bevy::math::DVec3;
use bevy_egui::egui::{RichText, Ui};
use sheetwork::ParameterId as Id;
use sheetwork::integrators::TABLE;

use super::ParameterAccess;
use super::controls::{
    ControlOptions, MS, PLAIN, choice, name, parameter_control, parameter_row, text_of, usual_row, vector_row,
};
use super::units::{DisplayUnit, Quantity, format_si};

/// Gravity presets, m/s², downwards.
const GRAVITIES: [(&str, f64); 4] = [("Earth", 9.81), ("Moon", 1.62), ("1/10", 0.981), ("none", 0.0)];

const GRAVITY: DisplayUnit = DisplayUnit::fixed(Quantity::Acceleration, "", 1.0);
const WIND: DisplayUnit = DisplayUnit::fixed(Quantity::Speed, "", 1.0);
const DENSITY: DisplayUnit = DisplayUnit::fixed(Quantity::Density, "kg/m³", 1.0);
const MICRO: DisplayUnit = DisplayUnit::fixed(Quantity::Length, "µm", 1e-6);

/// Rows of integrator, step, substeps per frame, gravity and air in a grid of two columns.
/// `factor`: whether the linear damping of the air can be edited.
pub fn engine(ui: &mut Ui, access: &mut dyn ParameterAccess, factor: bool) {
    engine_and_step(ui, access);
    substeps(ui, access);
    gravity(ui, access);
    air(ui, access, factor);
}

fn engine_and_step(ui: &mut Ui, access: &mut dyn ParameterAccess) {
    let info = access.world().engine().info();
    let label = name(ui, "Integrator", "Scheme that advances positions and velocities");
    let mut chosen = info.name;
    let engines = TABLE.iter().map(|row| (row.name, row.name, row.about));
    choice(ui, &label, ("engine", info.name, 150.0), &mut chosen, engines).on_hover_text(info.about);
    if chosen != info.name {
        access.set("engine", chosen);
    }
    ui.end_row();

    let label = name(ui, "Step", "Time step, ms");
    ui.horizontal(|ui| {
        let dt = access.world().dt();
        parameter_control(ui, access, &label, "dt", dt, MS, &ControlOptions::speed(0.01));
        let limit = access.largest_step();
        if info.adaptive {
            ui.weak("adapts");
        } else if info.implicit {
            ui.weak("stable at any step").on_hover_text("A longer step is less accurate; see the delivered stiffness");
        } else if let Some(limit) = limit {
            let text = RichText::new(format!("≤ {}", format_si(limit, "s")));
            let text = if access.world().dt() > limit { text.color(ui.visuals().warn_fg_color) } else { text.weak() };
            ui.label(text).on_hover_text("Stability limit of the undamped sheet, by its highest frequency");
        }
    });
    ui.end_row();

    if info.adaptive {
        let now = access.parameter("tolerance").unwrap_or_default();
        let row = ("Tolerance", "Tolerance of the position error of a step, µm", "tolerance");
        parameter_row(ui, access, row, now, MICRO, &ControlOptions::default());
    }
}

/// Steps per frame of 1/60 s, an alternative to the step for game programmers.
fn substeps(ui: &mut Ui, access: &mut dyn ParameterAccess) {
    let now = 1.0 / (60.0 * access.world().dt());
    let label = name(ui, "Steps per frame", "Time steps per frame of 1/60 s");
    ui.horizontal(|ui| {
        for (n, title) in [(1.0, "1"), (2.0, "2"), (4.0, "4"), (8.0, "8"), (16.0, "16")] {
            let is = (now / n - 1.0_f64).abs() < 1e-6;
            if ui
                .selectable_label(is, title)
                .on_hover_text(format!("A time step of {}", format_si(1.0 / (60.0 * n), "s")))
                .clicked()
            {
                access.set("dt", &(1.0 / (60.0 * n)).to_string());
            }
        }
        ui.weak(format!("{now:.3}")).labelled_by(label.id);
    });
    ui.end_row();
}

fn gravity(ui: &mut Ui, access: &mut dyn ParameterAccess) {
    let now = access.world().gravity();
    vector_row(ui, access, ("Gravity", "m/s²; y points up", "gravity"), now, GRAVITY);
    ui.label("");
    ui.horizontal(|ui| {
        for (name, g) in GRAVITIES {
            if ui.small_button(name).on_hover_text(format!("{g} m/s² downwards")).clicked() {
                access.set("gravity", &text_of(DVec3::new(0.0, -g, 0.0)));
            }
        }
    });
    ui.end_row();
}

fn air(ui: &mut Ui, access: &mut dyn ParameterAccess, factor: bool) {
    let air = access.world().air();
    let about = "Density of the air for pressure drag; 1.2 kg/m³ in a room";
    usual_row(ui, access, ("Air", about, "air.density"), air.density, DENSITY, Id::AirDensity);
    if air.density > 0.0 {
        vector_row(ui, access, ("Wind", "m/s; y points up", "air.wind"), air.wind, WIND);
    }
    if air.factor >= 1.0 && !factor {
        return;
    }
    let about = format!(
        "Linear damping: fraction of its speed that a node keeps in every {}; 1 is none",
        format_si(air.per, "s")
    );
    usual_row(ui, access, ("Linear damping", &about, "air.factor"), air.factor, PLAIN, Id::AirFactor);
    let about = "Time of that fraction, ms";
    parameter_row(ui, access, ("… in every", about, "air.per"), air.per, MS, &ControlOptions::default());
}
