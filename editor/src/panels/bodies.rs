//! Rigid bodies of the scene: placement, mass, contact parameters.

use bevy_egui::egui::{CollapsingHeader, Grid, RichText, Ui};
use glam::DVec3;
use sheetwork::ParameterId;
use sheetwork::scene::{BodySpec, Placement, Shape};

use super::EditorState;
use super::heat::{bounds, place};
use crate::session::{Item, Session};
use crate::units::{DisplayUnit, Quantity, format_si};
use bevy_sheetwork::inspector::controls::{CELSIUS, ControlOptions, PLAIN, number};

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

/// Whether the body has a temperature, and its value.
fn temperature(ui: &mut Ui, session: &mut Session, index: usize, spec: &BodySpec) {
    let mut hot = spec.temperature.is_some();
    let about = "Whether the body exchanges heat with sheets in contact";
    if ui.checkbox(&mut hot, "Exchanges heat").on_hover_text(about).changed() {
        edit(session, index, "temperature", |b| b.temperature = hot.then_some(100.0));
    }
    if let Some(celsius) = spec.temperature {
        let row = ("at", "Temperature of this body, °C", "temperature");
        let done = number(ui, session, row, celsius, CELSIUS, &ControlOptions::speed(1.0));
        if let Some(celsius) = done.value {
            edit(session, index, "temperature", |b| b.temperature = Some(celsius));
        }
    }
    ui.end_row();
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
