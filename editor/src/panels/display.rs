//! Display settings of the sheets: items, smoothing, colours.

use bevy_egui::egui::{DragValue, RichText, Ui};
use bevy_sheetwork::inspector::controls::choice;
use bevy_sheetwork::{SheetColour, SheetLayer};
use sheetwork::sheet::surface::SurfaceSmoothing;

use super::EditorState;
use super::style::quiet;
use crate::camera::Camera;
use crate::session::Session;
use crate::units::format_si;

/// Kinds of smoothing: title, value (none for flat triangles), description.
const SMOOTHINGS: [(&str, Option<SurfaceSmoothing>, &str); 4] = [
    ("Smoothed", Some(SurfaceSmoothing::Interpolating), "A spline surface through the nodes"),
    (
        "B-spline",
        Some(SurfaceSmoothing::BSpline),
        "Cubic B-splines with the nodes as control points: they round corners and even out edges",
    ),
    (
        "Bézier",
        Some(SurfaceSmoothing::Bezier),
        "One piece over the whole sheet, the thesis's 2 n knots for n nodes: rounder still",
    ),
    ("Flat", None, "Flat triangles between the nodes"),
];

/// Surface, layer, smoothing, colours, springs, nodes, room.
pub fn display(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let display = &mut state.display;
    ui.horizontal(|ui| {
        ui.checkbox(&mut display.surface, "Surface");
        ui.checkbox(&mut display.springs, "Springs").on_hover_text("Blue in compression, red in tension");
        ui.checkbox(&mut display.nodes, "Nodes").on_hover_text("Bright in contact with a body");
    });
    ui.add_enabled_ui(display.surface, |ui| {
        ui.horizontal(|ui| {
            ui.radio_value(&mut display.layer, SheetLayer::Top, "Top layer");
            ui.radio_value(&mut display.layer, SheetLayer::Bottom, "Bottom layer");
        });
        ui.horizontal(|ui| {
            let mut kind = display.smooth.then_some(display.spline);
            for (title, value, about) in SMOOTHINGS {
                ui.radio_value(&mut kind, value, title).on_hover_text(about);
            }
            display.smooth = kind.is_some();
            display.spline = kind.unwrap_or(display.spline);
        });
        if display.smooth
            && let Some(gap) = gap(ui, session, display.layer, display.spline)
        {
            ui.label(RichText::new(format!("up to {} from the contact triangles", format_si(gap, "m"))).color(quiet(ui)))
                .on_hover_text(
                    "Largest distance between the smoothed surface and the flat triangles used in contact. The displayed surface is moved out of bodies.",
                );
        }
        colours(ui, session, &mut display.colour);
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut display.room, "Room").on_hover_text("Floor and back wall");
        ui.checkbox(&mut display.bodies, "Bodies").on_hover_text("Rigid bodies; hidden ones still make contact");
        ui.checkbox(&mut display.pins, "Pins").on_hover_text("Fixed nodes");
        ui.checkbox(&mut display.contacts, "Contacts").on_hover_text("Nodes in contact");
        ui.checkbox(&mut display.normals, "Normals").on_hover_text("Normals of the displayed side at every node");
    });
    ui.horizontal(|ui| {
        if ui.button("Look at the scene").on_hover_text("The camera of the scene (F)").clicked() {
            state.camera = Camera::from_session(session);
        }
    });
}

/// Largest distance between the displayed surface and the contact triangles, m, recomputed after a
/// change.
fn gap(ui: &Ui, session: &Session, layer: SheetLayer, spline: SurfaceSmoothing) -> Option<f64> {
    type Known = ((u64, u64, u64, bool, SurfaceSmoothing), Option<f64>);
    let now = (session.generation(), session.revision(), session.world().steps(), layer == SheetLayer::Top, spline);
    let id = ui.id().with("gap");
    if let Some((_, gap)) = ui.data(|d| d.get_temp::<Known>(id)).filter(|known| known.0 == now) {
        return gap;
    }
    let gap = crate::gap::largest(session.world(), layer, spline);
    ui.data_mut(|d| d.insert_temp::<Known>(id, (now, gap)));
    gap
}

/// Field of the colours, and the ends of a manual scale.
fn colours(ui: &mut Ui, session: &Session, chosen: &mut Option<SheetColour>) {
    let played = session.playback();
    let now = SheetColour::Temperature.scale(session.world());
    let (low, high) = now.map_or((20.0, 120.0), |s| (s.low, s.high));
    let own = match *chosen {
        Some(own @ SheetColour::TemperatureBetween { .. }) => own,
        _ => SheetColour::TemperatureBetween { low, high },
    };
    let choices = [
        (None, "Automatic", "Temperature in a scene with heat; remaining stiffness with the thesis's formulas"),
        (Some(SheetColour::Plain), "One colour", "The colour of the sheet"),
        (Some(SheetColour::Temperature), "Temperature", "Of the displayed side, from the surroundings to the highest"),
        (Some(own), "Temperature from … to", "On a fixed scale"),
        (Some(SheetColour::Stiffness), "Remaining stiffness", "Relative to the cold material, %"),
        (Some(SheetColour::Stretch), "Strain", "Largest strain of the edges at each node, %"),
        (Some(SheetColour::Bending), "Curvature", "Largest curvature at each node, 1/m"),
        (Some(SheetColour::Speed), "Speed", "Of each node, m/s"),
        (
            Some(SheetColour::Contact),
            "Contact force",
            "At each node, mN; exact at rest, with the error of the inertial force in motion",
        ),
    ];
    let name = choices.iter().find(|c| c.0 == *chosen).map_or("", |c| c.1);
    ui.horizontal(|ui| {
        let label = ui.label("Colour");
        let fields = choices.into_iter().filter(|c| played.is_none_or(|run| is_recorded(c.0, run.has_heat())));
        choice(ui, &label, ("colour", name, 170.0), chosen, fields);
    });
    if let Some(SheetColour::TemperatureBetween { low, high }) = chosen {
        ui.horizontal(|ui| {
            let from = ui.label("From");
            ui.add(DragValue::new(low).range(-273.15..=5000.0).suffix(" °C")).labelled_by(from.id);
            let to = ui.label("to");
            ui.add(DragValue::new(high).range(*low + 1.0..=5001.0).suffix(" °C")).labelled_by(to.id);
        });
    }
}

/// Whether a recording has the field: positions, and temperatures where recorded.
fn is_recorded(colour: Option<SheetColour>, heat: bool) -> bool {
    match colour {
        Some(SheetColour::Plain | SheetColour::Stretch | SheetColour::Bending) => true,
        None | Some(SheetColour::Temperature | SheetColour::TemperatureBetween { .. }) => heat,
        _ => false,
    }
}
