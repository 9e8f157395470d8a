//! Heat sources: oven, surroundings, heaters with their faces, heat gun; and the temperatures of
//! the sheets.

use bevy_egui::egui::{CollapsingHeader, Grid, RichText, Ui};
use glam::DVec3;
use sheetwork::ParameterId as Id;
use sheetwork::scene::{HeatGunSpec, HeatMode, HeaterSpec, HotFaceSpec, OvenSpec, Placement};

use super::style::quiet;
use crate::document::path::opened;
use crate::session::{Item, Session};
use crate::units::{DisplayUnit, Quantity};
use bevy_sheetwork::inspector::controls::{
    CELSIUS, ControlOptions, DEGREES, MM, PLAIN, name, number, parameter_control, usual_row, vector,
};

const CONVECTION: DisplayUnit = DisplayUnit::fixed(Quantity::Convection, "W/(m² K)", 1.0);
/// Faces of a box, in the order of the scene description.
const SIDES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];
/// Initial temperature of a hot face, °C.
const HOT: f64 = 300.0;

/// Oven, surroundings, heaters, heat gun, and the temperatures of the sheets.
pub fn heat(ui: &mut Ui, session: &mut Session) {
    Grid::new("oven").num_columns(2).show(ui, |ui| {
        oven(ui, session);
        room(ui, session);
    });
    if let HeatMode::Thesis { .. } = session.scene().heat_mode {
        ui.weak("Stiffness by the thesis's formulas")
            .on_hover_text("The scene's heat_mode; sheets have no temperature then");
    }
    for index in 0..session.scene().heaters.len() {
        heater(ui, session, index);
    }
    gun(ui, session);
    add(ui, session);
    temperatures(ui, session);
}

fn oven(ui: &mut Ui, session: &mut Session) {
    let spec = session.scene().oven.clone();
    let mut on = spec.as_ref().is_some_and(|o| o.on);
    if ui.checkbox(&mut on, "Oven").on_hover_text("Air and walls of the room at one temperature").changed() {
        match &spec {
            Some(_) => _ = session.set("oven.on", if on { "1" } else { "0" }),
            None => _ = session.edit("oven", "oven", |s| s.oven = Some(OvenSpec::default())),
        }
    }
    match spec {
        Some(spec) => {
            if spec.schedule.is_empty() {
                ui.horizontal(|ui| {
                    let label = name(ui, "at", "Temperature of the oven, °C");
                    let how = ControlOptions::usual(Id::OvenTemperature);
                    parameter_control(ui, session, &label, "oven.temperature", spec.temperature, CELSIUS, &how);
                });
            } else {
                ui.horizontal(|ui| {
                    let now = session.world().room_temperature();
                    ui.label(CELSIUS.format(now)).on_hover_text("By the schedule");
                    if ui.small_button("hold").on_hover_text("Keep this temperature in place of the schedule").clicked()
                    {
                        session.edit("oven held", "oven", |s| {
                            s.oven = Some(OvenSpec { schedule: Vec::new(), temperature: now, ..spec.clone() });
                        });
                    }
                });
            }
        }
        None => _ = ui.weak("off"),
    }
    ui.end_row();
}

fn room(ui: &mut Ui, session: &mut Session) {
    let (ambient, convection, lapse) =
        (session.scene().ambient_temperature, session.scene().convection, session.scene().time_lapse);
    let about = "Temperature of the surroundings, °C; type 70 °F or 300 K if you like";
    usual_row(ui, session, ("Ambient", about, "ambient_temperature"), ambient, CELSIUS, Id::AmbientTemperature);
    let about = "Convection coefficient of both sides of a sheet together in still air, W/(m² K)";
    usual_row(ui, session, ("Convection", about, "convection"), convection, CONVECTION, Id::Convection);
    let about = "Factor of thermal time over mechanical time";
    usual_row(ui, session, ("Time-lapse", about, "time_lapse"), lapse, PLAIN, Id::TimeLapse);
}

fn heater(ui: &mut Ui, session: &mut Session, index: usize) {
    let (title, item) = (session.name_of(Item::Heater(index)), Item::Heater(index));
    let Some(spec) = session.scene().heaters.get(index).cloned() else { return };
    CollapsingHeader::new(RichText::new(title).strong()).id_salt(("heater", index)).default_open(true).show(ui, |ui| {
        ui.horizontal(|ui| {
            let mut on = spec.on;
            if ui.checkbox(&mut on, "On").on_hover_text("Whether the heater radiates").changed() {
                session.edit("heater switched", &format!("heaters.{index}.on"), |s| s.heaters[index].on = on);
            }
            if ui.small_button("Remove").on_hover_text("Remove this heater from the scene").clicked() {
                session.edit("removal of a heater", "remove heater", |s| _ = s.heaters.remove(index));
            }
        });
        if index < session.scene().heaters.len() {
            faces(ui, session, index, &spec);
            place(ui, session, item, spec.placement);
        }
    });
}

/// Hot faces and their temperatures.
fn faces(ui: &mut Ui, session: &mut Session, index: usize, spec: &HeaterSpec) {
    let whole = match opened(spec, session.scene()) {
        Ok(whole) => whole,
        Err(error) => {
            ui.weak(error.problem);
            return;
        }
    };
    let count = whole.polyhedron.as_ref().map_or(6, |p| p.faces.len());
    Grid::new(("faces", index)).num_columns(2).show(ui, |ui| {
        for face in 0..count as u32 {
            let title = if whole.size.is_some() { SIDES[face as usize % 6].to_owned() } else { format!("face {face}") };
            let hot = whole.hot.iter().find(|h| h.face == face).copied();
            let mut on = hot.is_some();
            let check = ui.checkbox(&mut on, title).on_hover_text("Whether this face is hot");
            let mut new = hot;
            if check.changed() {
                let like =
                    whole.hot.first().copied().unwrap_or(HotFaceSpec { face, temperature: HOT, emissivity: 1.0 });
                new = on.then_some(HotFaceSpec { face, ..like });
            }
            match hot {
                Some(spec) => {
                    let row = ("at", "Temperature of this face, °C; type 700 K if you like", "temperature");
                    let how = ControlOptions::speed(1.0);
                    let done = ui.horizontal(|ui| number(ui, session, row, spec.temperature, CELSIUS, &how)).inner;
                    if let Some(temperature) = done.value.or(done.reset.then_some(HOT)) {
                        new = Some(HotFaceSpec { temperature, ..spec });
                    }
                }
                None => _ = ui.weak("cold"),
            }
            ui.end_row();
            if new != hot {
                let key = format!("heaters.{index}.face {face}");
                session.edit("heater's face", &key, |s| {
                    let mut changed = whole.clone();
                    changed.hot.retain(|h| h.face != face);
                    changed.hot.extend(new);
                    changed.hot.sort_by_key(|h| h.face);
                    s.heaters[index] = changed;
                });
            }
        }
    });
}

/// Placement of an item: position and rotation.
pub(super) fn place(ui: &mut Ui, session: &mut Session, item: Item, now: Placement) {
    Grid::new(("place", session.name_of(item))).num_columns(2).show(ui, |ui| {
        name(ui, "Position", "Position, mm; or drag it with the move tool in the view");
        let (new, _) = vector(ui, session, "place", now.position, MM, &ControlOptions::speed(0.5).on_release());
        if let Some(position) = new {
            session.place(item, Placement { position, ..now });
        }
        ui.end_row();
        if item == Item::HeatGun {
            return;
        }
        name(ui, "Rotation", "About the fixed x, y and z axes, in this order");
        let (new, _) = vector(ui, session, "turn", now.rotation, DEGREES, &ControlOptions::speed(0.5).on_release());
        if let Some(rotation) = new {
            session.place(item, Placement { rotation, ..now });
        }
        ui.end_row();
    });
}

fn gun(ui: &mut Ui, session: &mut Session) {
    let Some(spec) = session.scene().heat_gun.clone() else { return };
    CollapsingHeader::new(RichText::new("Heat gun").strong()).default_open(true).show(ui, |ui| {
        ui.horizontal(|ui| {
            let mut on = spec.on;
            if ui.checkbox(&mut on, "Blows").on_hover_text("Whether the heat gun is on").changed() {
                session.set("heat_gun.on", if on { "1" } else { "0" });
            }
            if ui.small_button("Remove").on_hover_text("Remove the heat gun from the scene").clicked() {
                session.edit("removal of the heat gun", "heat gun", |s| s.heat_gun = None);
            }
        });
        Grid::new("gun").num_columns(2).show(ui, |ui| {
            let about = "Temperature of the jet, °C";
            usual_row(
                ui,
                session,
                ("Jet", about, "heat_gun.temperature"),
                spec.temperature,
                CELSIUS,
                Id::HeatGunTemperature,
            );
            name(ui, "Direction", "Direction of the jet, of any length but 0");
            let (new, _) = vector(ui, session, "direction", spec.direction, PLAIN, &ControlOptions::speed(0.02));
            if let Some(direction) = new.filter(|d| *d != DVec3::ZERO) {
                session.edit("heat gun's direction", "heat_gun.direction", |s| {
                    s.heat_gun.iter_mut().for_each(|g| g.direction = direction);
                });
            }
            ui.end_row();
        });
        place(ui, session, Item::HeatGun, Placement { position: spec.position, rotation: DVec3::ZERO });
    });
}

/// Bounding box of all sheets, m.
pub(super) fn bounds(session: &Session) -> (DVec3, DVec3) {
    let sheets = session.world().sheets().iter().filter_map(|s| s.state.x.bounds());
    sheets.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((DVec3::splat(-0.1), DVec3::splat(0.1)))
}

/// Buttons that add a heater above everything, or a heat gun.
fn add(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        let (low, high) = bounds(session);
        let (middle, size) = (0.5 * (low + high), (high - low).max_element().max(1e-3));
        let above = DVec3::new(middle.x, high.y + 0.4 * size, middle.z);
        if ui.button("Add heater").on_hover_text("A panel above the sheets, its lower face hot").clicked() {
            let spec = HeaterSpec {
                size: Some(DVec3::new(0.6 * size, 0.04 * size, 0.6 * size)),
                hot: vec![HotFaceSpec { face: 2, temperature: HOT, emissivity: 0.9 }],
                placement: Placement { position: above, rotation: DVec3::ZERO },
                ..HeaterSpec::default()
            };
            session.edit("new heater", "new heater", |s| s.heaters.push(spec));
        }
        if session.scene().heat_gun.is_none()
            && ui.button("Take a heat gun").on_hover_text("A jet of hot air from above").clicked()
        {
            let gun = HeatGunSpec { position: above, reach: 0.5 * size, ..HeatGunSpec::default() };
            session.edit("heat gun", "heat gun", |s| s.heat_gun = Some(gun));
        }
    });
}

fn temperatures(ui: &mut Ui, session: &mut Session) {
    let mut cool = None;
    let room = session.scene().ambient_temperature;
    Grid::new("temperatures").num_columns(3).show(ui, |ui| {
        for (index, sheet) in session.world().sheets().iter().enumerate() {
            let Some(heat) = sheet.heat() else { continue };
            let (low, high) = heat.range();
            ui.label(RichText::new(&sheet.name).color(quiet(ui)));
            ui.monospace(format!("{low:.1} to {high:.1} °C"));
            if ui.small_button("cool").on_hover_text("Set the sheet to the temperature of the surroundings").clicked() {
                cool = Some(index);
            }
            ui.end_row();
        }
    });
    if let Some(sheet) = cool.and_then(|index| session.world_mut().sheets_mut().get_mut(index)) {
        let cooled = sheet.set_temperature(room);
        session.accept(cooled);
    }
}
