//! Rigid bodies of the scene: placement, mass, contact parameters.

use bevy_egui::egui::{CollapsingHeader, Grid, RichText, Ui};
use glam::DVec3;
use sheetwork::ParameterId;
use sheetwork::scene::{BodySpec, OvenKey, Placement, Shape};

use super::EditorState;
use super::heat::{bounds, place};
use crate::session::{Item, Session};
use crate::units::{DisplayUnit, Quantity, format_si};
use bevy_sheetwork::inspector::controls::{CELSIUS, ControlOptions, PLAIN, number};

const SECONDS: DisplayUnit = DisplayUnit::fixed(Quantity::Time, "s", 1.0);
const GRAM: DisplayUnit = DisplayUnit::fixed(Quantity::Mass, "g", 1e-3);

/// All bodies, and buttons to add more.
pub fn bodies(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    for index in 0..session.scene().bodies.len() {
        let (title, item) = (session.name_of(Item::Body(index)), Item::Body(index));
        let chosen = state.selected == Some(item);
        let header = CollapsingHeader::new(RichText::new(title).strong()).id_salt(("body", index));
        let header =
            header.default_open(session.scene().bodies.len() < 3).open(chosen.then_some(true)).show(ui, |ui| {
                body(ui, session, index);
            });
        if header.header_response.clicked() && !chosen {
            state.selected = Some(item);
        }
    }
    add(ui, session, state);
}

fn body(ui: &mut Ui, session: &mut Session, index: usize) {
    let Some(spec) = session.scene().bodies.get(index).cloned() else { return };
    ui.horizontal(|ui| {
        ui.weak(match &spec.shape {
            Shape::File(file) | Shape::Part(file, _) => {
                file.file_name().unwrap_or_default().to_string_lossy().into_owned()
            }
            Shape::Polyhedron(p) => format!("polyhedron of {} faces", p.faces.len()),
            Shape::Box(size) => {
                // Short enough for the column.
                let [x, y, z] = [size.x, size.y, size.z].map(|s| (1e5 * s).round() / 1e2);
                format!("box {x} × {y} × {z} mm")
            }
            Shape::Ball(radius) => format!("ball of radius {}", format_si(*radius, "m")),
            Shape::HalfSpace => "half-space below a plane".to_owned(),
        });
        if ui.small_button("Remove").on_hover_text("Remove this body from the scene").clicked() {
            session.edit("removal of a body", "remove body", |s| _ = s.bodies.remove(index));
        }
    });
    if index >= session.scene().bodies.len() {
        return;
    }
    place(ui, session, Item::Body(index), spec.placement);
    Grid::new(("body", index)).num_columns(3).show(ui, |ui| {
        mass(ui, session, index, &spec);
        contact(ui, session, index, &spec);
        temperature(ui, session, index, &spec);
    });
}

fn edit(session: &mut Session, index: usize, what: &str, change: impl Fn(&mut BodySpec)) {
    session.edit(&format!("change of {what}"), &format!("bodies.{index}.{what}"), |s| change(&mut s.bodies[index]));
}

/// Whether the body is dynamic, and its mass.
fn mass(ui: &mut Ui, session: &mut Session, index: usize, spec: &BodySpec) {
    let mut free = spec.is_dynamic();
    let about = "A dynamic body moves by forces; without this the body is static";
    let check = ui.checkbox(&mut free, "Dynamic").on_hover_text(about);
    if check.changed() && spec.shape != Shape::HalfSpace {
        edit(session, index, "mass", |b| (b.mass, b.density, b.path) = (free.then_some(0.02), None, Vec::new()));
    }
    let own = session.name_of(Item::Body(index));
    // Mass that follows from a density.
    let weighs = spec.mass.or_else(|| session.world().body_state(&own).filter(|s| s.is_dynamic()).map(|s| s.mass()));
    if let Some(mass) = weighs {
        ui.end_row();
        let how = ControlOptions::default().on_release();
        let done = number(ui, session, ("Mass", "Distributed uniformly over the shape", "mass"), mass, GRAM, &how);
        if let Some(mass) = done.value {
            edit(session, index, "mass", |b| (b.mass, b.density) = (Some(mass), None));
        }
    }
    ui.end_row();
}

/// Friction and restitution; a double click restores the scene's defaults.
fn contact(ui: &mut Ui, session: &mut Session, index: usize, spec: &BodySpec) {
    let all = session.scene().contact.clone();
    let how = ControlOptions::usual(ParameterId::BodyFriction).on_release();
    let row = ("Friction", "Coulomb friction coefficient of this body", "friction");
    let done = number(ui, session, row, spec.friction.unwrap_or(all.friction), PLAIN, &how);
    if done.reset || done.value.is_some() {
        edit(session, index, "friction", |b| b.friction = done.value);
    }
    ui.end_row();
    let row = ("Restitution", "Ratio of separation to approach speed", "restitution");
    let done = number(ui, session, row, spec.restitution.unwrap_or(all.restitution), PLAIN, &how);
    if done.reset || done.value.is_some() {
        edit(session, index, "restitution", |b| b.restitution = done.value);
    }
    ui.end_row();
}

/// Whether the body has a temperature, and its value or its schedule.
fn temperature(ui: &mut Ui, session: &mut Session, index: usize, spec: &BodySpec) {
    let mut hot = spec.is_hot();
    let about = "Whether the body exchanges heat with sheets in contact";
    if ui.checkbox(&mut hot, "Exchanges heat").on_hover_text(about).changed() {
        edit(session, index, "temperature", |b| {
            (b.temperature, b.temperature_schedule) = (hot.then_some(100.0), Vec::new());
            b.hot_spots.clear();
        });
    }
    if !spec.temperature_schedule.is_empty() {
        ui.end_row();
        schedule(ui, session, index, &spec.temperature_schedule);
    } else if let Some(celsius) = spec.temperature {
        let row = ("at", "Temperature of this body, °C", "temperature");
        let done = number(ui, session, row, celsius, CELSIUS, &ControlOptions::speed(1.0));
        if let Some(celsius) = done.value {
            edit(session, index, "temperature", |b| b.temperature = Some(celsius));
        }
        ui.end_row();
        if ui.small_button("over time").on_hover_text("Temperatures at times, linear in between").clicked() {
            let keys =
                [(0.0, celsius), (60.0, celsius)].map(|(time, value)| OvenKey { time, temperature: Some(value) });
            edit(session, index, "temperature_schedule", |b| b.temperature_schedule = keys.to_vec());
        }
    }
    ui.end_row();
}

/// Temperatures over time: a row for each, with a button that removes it; another button adds one.
fn schedule(ui: &mut Ui, session: &mut Session, index: usize, keys: &[OvenKey]) {
    let mut new: Option<Vec<OvenKey>> = None;
    let how = ControlOptions::speed(1.0).on_release();
    let ambient = session.scene().ambient_temperature;
    for (at, key) in keys.iter().enumerate() {
        let with =
            |changed: OvenKey| keys.iter().enumerate().map(|(i, k)| if i == at { changed } else { *k }).collect();
        ui.horizontal(|ui| {
            let row = ("from", "Time of this temperature, s", "time");
            if let Some(time) = number(ui, session, row, key.time, SECONDS, &how).value {
                new = Some(with(OvenKey { time, ..*key }));
            }
        });
        ui.horizontal(|ui| {
            let row = ("at", "Temperature of the body at that time, °C", "temperature");
            let celsius = key.temperature.unwrap_or(ambient);
            if let Some(value) = number(ui, session, row, celsius, CELSIUS, &how).value {
                new = Some(with(OvenKey { temperature: Some(value), ..*key }));
            }
        });
        if ui.small_button("remove").on_hover_text("Remove this temperature").clicked() {
            new = Some(keys.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, key)| *key).collect());
        }
        ui.end_row();
    }
    if let Some(last) = keys.last().filter(|_| ui.small_button("add").on_hover_text("A further temperature").clicked())
    {
        new = Some(keys.iter().copied().chain([OvenKey { time: last.time + 60.0, ..*last }]).collect());
    }
    if let Some(all) = new {
        // Without a schedule the body keeps the temperature that it would have started with.
        let first = keys.first().and_then(|key| key.temperature);
        edit(session, index, "temperature_schedule", |b| {
            b.temperature = b.temperature.or(first);
            b.temperature_schedule.clone_from(&all);
        });
    }
}

fn add(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.horizontal(|ui| {
        ui.label("Add");
        let (low, high) = bounds(session);
        let size = 0.3 * (high - low).max_element().max(1e-3);
        let (middle, below) = (0.5 * (low + high), low.y - size);
        let shapes = [
            ("box", Shape::Box(DVec3::splat(size)), DVec3::new(middle.x, below, middle.z), None),
            ("ball", Shape::Ball(0.4 * size), DVec3::new(middle.x, high.y + size, middle.z), Some(0.02)),
        ];
        for (title, shape, position, mass) in shapes {
            if ui.button(title).on_hover_text("A static body below the sheet, a dynamic body above it").clicked() {
                let placement = Placement { position, rotation: DVec3::ZERO };
                session.edit(&format!("new {title}"), "new body", |s| {
                    s.bodies.push(BodySpec { placement, mass, ..BodySpec::new(shape) });
                });
                state.selected = Some(Item::Body(session.scene().bodies.len().saturating_sub(1)));
            }
        }
    });
}
