//! The controls, drawn with egui alone: they read and change a [`Session`] and an [`EditorState`], and know no window.
//!
//! [`show`] lays everything out around the view of the scene and takes the mouse and the keys that no control has taken.

mod controls;
mod display;
mod engine;
mod help;
mod legend;
mod link;
mod messages;
mod numbers;
mod sheet;
mod style;
mod top;
mod view;

use std::path::PathBuf;

use bevy_egui::egui::{self, Rect, ScrollArea, Ui};

use bevy_sheetwork::SheetColour;
use bevy_sheetwork::render::ColourScale;
use sheetwork::World;

use crate::camera::Camera;
use crate::picture::Layer;
use crate::scenes;
use crate::session::Session;

pub use controls::{format_si, parse_si};
pub use display::display;
pub use engine::engine;
pub use help::help;
pub use legend::{legend, ticks};
pub use link::link;
pub use messages::messages;
pub use numbers::numbers;
pub use sheet::sheet;
pub use style::apply as apply_style;
pub use top::top;
pub use view::view;

/// What is drawn of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// The sheets' surfaces.
    pub surface: bool,
    /// Which layer the surface goes through.
    pub layer: Layer,
    /// Whether the surface is smoothed through the masses, or flat between them.
    pub smooth: bool,
    /// What the surface is coloured by; none for what shows most of a scene's heat, where it has any.
    pub colour: Option<SheetColour>,
    /// The springs as lines, coloured by their strain.
    pub springs: bool,
    /// The masses as dots.
    pub masses: bool,
    /// The floor and the back wall.
    pub room: bool,
}

impl Default for Display {
    fn default() -> Self {
        let (layer, colour) = (Layer::Top, None);
        Self { surface: true, layer, smooth: true, colour, springs: false, masses: false, room: true }
    }
}

impl Display {
    /// The same for `session`: an old recording has no temperatures that sheets could be coloured by.
    pub fn of(self, session: &Session) -> Self {
        let plain = session.playback().is_some_and(|recording| !recording.has_heat());
        if plain { Self { colour: Some(SheetColour::Plain), ..self } } else { self }
    }

    /// The scale of the colours that the surfaces of `world` have; `None` where they have none, or are not drawn.
    pub fn scale(&self, world: &World) -> Option<ColourScale> {
        let colour = self.colour.unwrap_or_else(|| SheetColour::of_heat(world));
        colour.scale(world).filter(|_| self.surface)
    }
}

/// What the editor remembers besides the session.
#[derive(Clone, Debug)]
pub struct EditorState {
    /// What is drawn.
    pub display: Display,
    /// Where it is drawn from.
    pub camera: Camera,
    /// Sheet that the sheet panel shows.
    pub sheet: usize,
    /// Contents of the field that takes a file name.
    pub path: String,
    /// Scenes of the open menu.
    pub scenes: Vec<PathBuf>,
    /// Whether the help is shown.
    pub help: bool,
    /// Whether the controls on the right are shown.
    pub controls: bool,
    /// Whether the numbers on the left are shown.
    pub numbers: bool,
    /// Part of the window that shows the scene, points; filled in by [`show`].
    pub viewport: Rect,
    /// Whether the user asked to end.
    pub quit: bool,
}

impl EditorState {
    /// The state a fresh editor has with this session.
    pub fn new(session: &Session) -> Self {
        Self {
            display: Display::default().of(session),
            camera: Camera::of(session.world()),
            sheet: 0,
            path: String::new(),
            scenes: scenes::folder().map(|f| scenes::list(&f)).unwrap_or_default(),
            help: false,
            controls: true,
            numbers: true,
            viewport: Rect::ZERO,
            quit: false,
        }
    }

    /// Opens a scene file in the session and looks at it as it asks; a refusal becomes a message.
    pub fn open(&mut self, session: &mut Session, file: &std::path::Path) {
        if session.load(file) {
            self.display = self.display.of(session);
            self.camera = Camera::of(session.world());
            self.sheet = 0;
        }
    }
}

/// Everything, into a `ui` that fills the window: bars and panels around the view.
pub fn show(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    egui::Panel::top("top").show(ui, |ui| top(ui, session, state));
    if !session.messages().is_empty() {
        egui::Panel::bottom("messages").show(ui, |ui| messages(ui, session));
    }
    if state.controls {
        let panel = egui::Panel::right("controls").resizable(false).exact_size(290.0);
        panel.show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                section(ui, "Display", |ui| display(ui, session, state));
                section(ui, "Engine", |ui| engine(ui, session));
                section(ui, "Sheet", |ui| sheet(ui, session, state));
                section(ui, "Live link", |ui| link(ui, session));
            });
        });
    }
    if state.numbers {
        let panel = egui::Panel::left("numbers").resizable(false).exact_size(225.0);
        panel.show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| numbers(ui, session));
        });
    }
    state.viewport = ui.available_rect_before_wrap();
    view(ui, session, state);
    help(ui, state);
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(true).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        contents(ui);
        ui.add_space(4.0);
    });
    ui.separator();
}
