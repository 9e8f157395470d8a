//! Rigid bodies of the scene: placement, mass, contact parameters.

use bevy_egui::egui::{CollapsingHeader, Grid, RichText, Ui};
use glam::DVec3;
use sheetwork::ParameterId;
use sheetwork::scene::{BodySpec, Placement, Shape};

use super::EditorState;
use super::heat::place;
use crate::session::{Item, Session};
use crate::units::{DisplayUnit, Quantity, format_si};
use bevy_sheetwork::inspector::controls::{CELSIUS, ControlOptions, PLAIN, input, name, tell};

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
        let label = name(ui, "Mass", "Distributed uniformly over the shape");
        let done = input(ui, &label, mass, GRAM, &ControlOptions::late());
        tell(session, "mass", done.error);
        if let Some(mass) = done.value {
            edit(session, index, "mass", |b| (b.mass, b.density) = (Some(mass), None));
        }
    }
    ui.end_row();
}

/// Friction and restitution; a double click restores the scene's defaults.
fn contact(ui: &mut Ui, session: &mut Session, index: usize, spec: &BodySpec) {
    let all = session.scene().contact.clone();
    let how = ControlOptions { late: true, ..ControlOptions::usual(ParameterId::BodyFriction) };
    let label = name(ui, "Friction", "Coulomb friction coefficient of this body");
    let done = input(ui, &label, spec.friction.unwrap_or(all.friction), PLAIN, &how);
    tell(session, "friction", done.error);
    if done.reset || done.value.is_some() {
        edit(session, index, "friction", |b| b.friction = done.value);
    }
    ui.end_row();
    let label = name(ui, "Restitution", "Ratio of separation to approach speed");
    let done = input(ui, &label, spec.restitution.unwrap_or(all.restitution), PLAIN, &how);
    tell(session, "restitution", done.error);
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
        let label = name(ui, "at", "Temperature of this body, °C");
        let done = input(ui, &label, celsius, CELSIUS, &ControlOptions { speed: 1.0, ..ControlOptions::default() });
        tell(session, "temperature", done.error);
        if let Some(celsius) = done.value {
            edit(session, index, "temperature", |b| b.temperature = Some(celsius));
        }
    }
    ui.end_row();
}

fn add(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.horizontal(|ui| {
        ui.label("Add");
        let sheets = session.world().sheets().iter().filter_map(|s| s.state.x.bounds());
        let (low, high) =
            sheets.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((DVec3::splat(-0.1), DVec3::splat(0.1)));
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
