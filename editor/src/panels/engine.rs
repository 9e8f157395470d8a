//! How time passes: the engine, its step, gravity and air.

use bevy_egui::egui::{ComboBox, Grid, RichText, Ui};
use glam::DVec3;
use sheetwork::engine::TABLE;

use super::controls::{format_si, number, slider};
use crate::session::Session;

/// Gravity that a button sets, m/s², downwards.
const GRAVITIES: [(&str, f64); 4] = [("Earth", 9.81), ("Moon", 1.62), ("1/10", 0.981), ("none", 0.0)];

/// Engine, step, tolerance, gravity, air.
pub fn engine(ui: &mut Ui, session: &mut Session) {
    Grid::new("engine").num_columns(2).show(ui, |ui| {
        engine_and_step(ui, session);
        gravity(ui, session);
        air(ui, session);
    });
}

fn engine_and_step(ui: &mut Ui, session: &mut Session) {
    let info = session.world().engine().info();
    let label = ui.label("Engine");
    let combo = ComboBox::from_id_salt("engine").selected_text(info.name).width(150.0);
    let mut chosen = info.name;
    let shown = combo.show_ui(ui, |ui| {
        for row in TABLE {
            ui.selectable_value(&mut chosen, row.name, row.name).on_hover_text(row.about);
        }
    });
    shown.response.labelled_by(label.id).on_hover_text(info.about);
    if chosen != info.name {
        session.set("engine", chosen);
    }
    ui.end_row();

    let label = ui.label("Step").on_hover_text("Time step of the engine");
    ui.horizontal(|ui| {
        let dt = session.world().dt();
        if let Some(dt) = number(ui, &label, dt, 1e3, 0.01, " ms") {
            session.set("dt", &dt.to_string());
        }
        let limit = session.largest_step();
        if info.adaptive {
            ui.weak("adapts");
        } else if info.implicit {
            ui.weak("any step holds").on_hover_text("A longer one is less exact: see the stiffness under Numbers");
        } else if let Some(limit) = limit {
            let text = RichText::new(format!("≤ {}", format_si(limit, "s")));
            let text = if session.world().dt() > limit { text.color(ui.visuals().warn_fg_color) } else { text.weak() };
            ui.label(text).on_hover_text("Largest step at which the undamped sheet holds, by its highest frequency");
        }
    });
    ui.end_row();

    if info.adaptive {
        let label = ui.label("Tolerance").on_hover_text("Position error allowed in a step");
        let now = session.parameter("tolerance").unwrap_or_default();
        if let Some(tolerance) = number(ui, &label, now, 1e6, 0.01, " µm") {
            session.set("tolerance", &tolerance.to_string());
        }
        ui.end_row();
    }
}

/// Three numbers, x, y and z, of a vector that is `now`; the new vector when one has been changed.
fn vector(ui: &mut Ui, now: DVec3, speed: f64) -> Option<DVec3> {
    let mut changed = None;
    ui.horizontal(|ui| {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let label = ui.weak(name);
            if let Some(value) = number(ui, &label, now[axis], 1.0, speed, "") {
                let mut new = now;
                new[axis] = value;
                changed = Some(new);
            }
        }
    });
    changed
}

/// A vector as [`Session::set`] takes it.
fn text(v: DVec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

fn gravity(ui: &mut Ui, session: &mut Session) {
    let now = session.world().gravity();
    let set = |session: &mut Session, g: DVec3| session.set("gravity", &text(g));
    ui.label("Gravity").on_hover_text("m/s²; y points up");
    if let Some(g) = vector(ui, now, 0.02) {
        set(session, g);
    }
    ui.end_row();
    ui.label("");
    ui.horizontal(|ui| {
        for (name, g) in GRAVITIES {
            if ui.small_button(name).on_hover_text(format!("{g} m/s² downwards")).clicked() {
                set(session, DVec3::new(0.0, -g, 0.0));
            }
        }
    });
    ui.end_row();
}

fn air(ui: &mut Ui, session: &mut Session) {
    let air = session.world().air();
    let about = "Density of the air that presses on sheets; a room's is 1.2 kg/m³";
    slider(ui, session, ("Air", about, "air.density"), (air.density, 0.0..=2.0), |s| {
        s.max_decimals(3).suffix(" kg/m³")
    });
    if air.density > 0.0 {
        ui.label("Wind").on_hover_text("m/s; y points up");
        if let Some(wind) = vector(ui, air.wind, 0.02) {
            session.set("air.wind", &text(wind));
        }
        ui.end_row();
    }
    if air.factor >= 1.0 && session.world().scene().air.factor >= 1.0 {
        return;
    }
    let about = format!("What a mass keeps of its speed in every {}; 1 is no air", format_si(air.per, "s"));
    slider(ui, session, ("Air factor", &about, "air.factor"), (air.factor, 0.8..=1.0), |s| s.max_decimals(4));
    let label = ui.label("… in every").on_hover_text("Time in which a mass keeps that part of its speed");
    if let Some(per) = number(ui, &label, air.per, 1e3, 0.1, " ms") {
        session.set("air.per", &per.to_string());
    }
    ui.end_row();
}
