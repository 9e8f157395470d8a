//! The controls, drawn with egui alone: they read and change a [`Session`] and an [`EditorState`], and know no window.
//!
//! [`show`] lays everything out around the view of the scene and takes the mouse and the keys that no control has taken.

mod bodies;
mod camera;
mod changes;
mod chart;
mod compare;
mod controls;
mod display;
mod engine;
mod export;
mod files;
mod generate;
mod heat;
mod help;
mod keys;
mod legend;
mod link;
mod material;
mod messages;
mod numbers;
mod overlay;
mod plots;
mod sheet;
mod study;
mod style;
mod timeline;
mod top;
mod view;

use std::collections::BTreeSet;
use std::path::PathBuf;

use bevy_egui::egui::{self, Rect, ScrollArea, Ui};

use bevy_sheetwork::SheetColour;
use bevy_sheetwork::render::ColourScale;
use clap::ValueEnum;
use sheetwork::World;
use sheetwork::scene::Scene;

use crate::camera::Camera;
use crate::export::Job;
use crate::keeping::Keeper;
use crate::picture::{Layer, Look};
use crate::scenes;
use crate::session::{Item, Session};
use crate::study::{Stage, Study};

pub use crate::units::format_si;
pub use bevy_sheetwork::inspector::Previews;
pub use bodies::bodies;
pub use camera::camera;
pub use compare::compare;
pub use display::display;
pub use engine::engine;
pub use export::export;
pub use files::{Dialog, Purpose, dialog};
pub use generate::{Draft, generate};
pub use heat::heat;
pub use help::help;
pub use legend::{legend, ticks};
pub use link::link;
pub use material::material;
pub use messages::messages;
pub use numbers::numbers;
pub use plots::{Plots, plots};
pub use sheet::sheet;
pub use study::{blind, study};
pub use style::apply as apply_style;
pub use timeline::timeline;
pub use top::top;
pub use view::{Held, view};

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
    /// Rigid bodies.
    pub bodies: bool,
    /// Masses that are held, as marks.
    pub pins: bool,
    /// Masses that touch something, as marks.
    pub contacts: bool,
    /// Which way the drawn side faces, as lines from the masses.
    pub normals: bool,
}

impl Default for Display {
    fn default() -> Self {
        let (layer, colour) = (Layer::Top, None);
        let (pins, contacts, room, bodies) = (true, false, true, true);
        Self {
            surface: true,
            layer,
            smooth: true,
            colour,
            springs: false,
            masses: false,
            room,
            bodies,
            pins,
            contacts,
            normals: false,
        }
    }
}

impl Display {
    /// The same for `session`: an old recording has no temperatures that sheets could be coloured by.
    pub fn of(self, session: &Session) -> Self {
        let plain = session.playback().is_some_and(|recording| !recording.has_heat());
        if plain { Self { colour: Some(SheetColour::Plain), ..self } } else { self }
    }

    /// The same for our own rasteriser.
    pub fn look(&self) -> Look {
        Look { layer: self.layer, parts: if self.smooth { 4 } else { 1 }, colour: self.colour }
    }

    /// The scale of the colours that the surfaces of `world` have; `None` where they have none, or are not drawn.
    pub fn scale(&self, world: &World) -> Option<ColourScale> {
        let colour = self.colour.unwrap_or_else(|| SheetColour::of_heat(world));
        colour.scale(world).filter(|_| self.surface)
    }

    /// One scale for all worlds that `session` shows: from the least to the most of any.
    pub fn scale_of(&self, session: &Session) -> Option<ColourScale> {
        let shown = (0..).map_while(|which| session.shown(which));
        let all = shown.filter_map(|one| self.scale(one.world()));
        all.reduce(|mut a, b| {
            if a.low < a.high {
                (a.low, a.high) = (a.low.min(b.low), a.high.max(b.high));
            }
            a
        })
    }
}

/// What the left button does in the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Tool {
    /// Turns the view.
    #[default]
    Look,
    /// Pulls at a sheet.
    Grab,
    /// Pins a mass, or lets it go.
    Pin,
    /// Moves bodies and heaters, and sheets before time has passed.
    Move,
    /// Folds a sheet along a line.
    Crease,
    /// Paints warmth.
    Heat,
    /// Cuts a sheet along a line.
    Cut,
}

impl Tool {
    /// All of them: name and what they do.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Look, "Look", "Left drag turns the view (Q)"),
        (Self::Grab, "Grab", "Left drag pulls at a sheet with a spring, whose force is shown (G)"),
        (Self::Pin, "Pin", "A click pins a mass where it is, or lets it go (P)"),
        (
            Self::Move,
            "Move",
            "A click chooses a body, heater, heat gun, or before time has passed a sheet; its arrows move it (W)",
        ),
        (Self::Crease, "Crease", "Left drag draws a line along which a shell is folded (C)"),
        (Self::Heat, "Heat", "Left drag paints warmth on a sheet (H)"),
        (Self::Cut, "Cut", "Left drag draws a line along which the cells of a sheet open (X)"),
    ];
}

/// What the tools put on a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Temperature of what is painted, °C.
    pub celsius: f64,
    /// Its radius, m; none for a twelfth of the sheet.
    pub radius: Option<f64>,
    /// By how much a line folds the sheet, degrees.
    pub angle: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { celsius: 120.0, radius: None, angle: 60.0 }
    }
}

impl Brush {
    /// The radius on a sheet of this length and width, m.
    pub fn radius_on(&self, (length, width): (f64, f64)) -> f64 {
        self.radius.unwrap_or_else(|| length.max(width) / 12.0).clamp(1e-6, 1e3)
    }
}

/// A part of the controls on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Section {
    /// Structure, grid, size, place, damping, pins.
    Sheet,
    /// What it is made of.
    Material,
    /// Rigid bodies.
    Bodies,
    /// How time passes.
    Engine,
    /// What heats.
    Heat,
    /// What is drawn.
    Display,
    /// Where it is seen from.
    Camera,
    /// Variants beside the scene.
    Compare,
    /// Other processes.
    Link,
}

impl Section {
    /// All of them, with their titles.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Material, "Material"),
        (Self::Sheet, "Sheet"),
        (Self::Bodies, "Bodies"),
        (Self::Engine, "Engine"),
        (Self::Heat, "Heat"),
        (Self::Display, "Display"),
        (Self::Camera, "Camera"),
        (Self::Compare, "Compare"),
        (Self::Link, "Live link"),
    ];
}

/// What the editor remembers besides the session.
pub struct EditorState {
    /// What is drawn.
    pub display: Display,
    /// Where it is drawn from.
    pub camera: Camera,
    /// What the left button does in the view.
    pub tool: Tool,
    /// What it holds.
    pub held: Option<Held>,
    /// What it puts on a sheet.
    pub brush: Brush,
    /// What the move tool has chosen.
    pub selected: Option<Item>,
    /// Sheet that the sheet and material panels show.
    pub sheet: usize,
    /// Contents of the field that takes a file name.
    pub path: String,
    /// Scenes of the open menu.
    pub scenes: Vec<PathBuf>,
    /// Whether the help is shown.
    pub help: bool,
    /// Whether the controls on the right are shown.
    pub controls: bool,
    /// Which of them.
    pub open_sections: BTreeSet<Section>,
    /// Those that have been taken out of the column and are windows of their own.
    pub floating: BTreeSet<Section>,
    /// Whether the column is on the left and the numbers on the right.
    pub swapped: bool,
    /// Whether the numbers on the left are shown.
    pub numbers: bool,
    /// Whether the timeline is shown.
    pub timeline: bool,
    /// Which plots are shown.
    pub plots: Plots,
    /// Whether panels are light.
    pub light: bool,
    /// Droop previews of materials.
    pub previews: Previews,
    /// The dialog that chooses a file, while it is open.
    pub dialog: Option<Dialog>,
    /// Where the last file was opened or saved, and where the last export was written.
    pub folder: Option<PathBuf>,
    /// See `folder`.
    pub out: Option<PathBuf>,
    /// The sheet that is being generated, while that dialog is open.
    pub generate: Option<Draft>,
    /// The export that is being set up or written.
    pub export: Option<Job>,
    /// The study that is on.
    pub study: Option<Study>,
    /// What was open before it, and where it was seen from.
    pub aside: Option<(Box<Session>, Camera)>,
    /// Recent files and copies of unsaved work.
    pub keeper: Keeper,
    /// Unsaved work that was found at the start: the copy and the scene.
    pub left: Option<(PathBuf, Scene)>,
    /// Part of the window that shows the scene, points; filled in by [`show`].
    pub viewport: Rect,
    /// Whether the user asked to end.
    pub quit: bool,
}

impl EditorState {
    /// The state a fresh editor has with this session. It keeps nothing between runs until its `keeper` has a folder.
    pub fn new(session: &Session) -> Self {
        Self {
            display: Display::default().of(session),
            camera: Camera::of_session(session),
            tool: Tool::Look,
            held: None,
            brush: Brush::default(),
            selected: None,
            sheet: 0,
            path: String::new(),
            scenes: scenes::folder().map(|f| scenes::list(&f)).unwrap_or_default(),
            help: false,
            controls: true,
            open_sections: [Section::Material, Section::Sheet].into(),
            floating: BTreeSet::new(),
            swapped: false,
            numbers: true,
            timeline: true,
            plots: Plots::default(),
            light: false,
            previews: Previews::default(),
            dialog: None,
            folder: None,
            out: None,
            generate: None,
            export: None,
            study: None,
            aside: None,
            keeper: Keeper::new(None),
            left: None,
            viewport: Rect::ZERO,
            quit: false,
        }
    }
}

impl EditorState {
    /// Chooses what the move tool moves, and turns to its controls where they are not seen.
    pub fn choose(&mut self, item: Option<Item>) {
        self.selected = item;
        let section = match item {
            None => return,
            Some(Item::Sheet(index)) => {
                self.sheet = index;
                Section::Sheet
            }
            Some(Item::Body(_)) => Section::Bodies,
            Some(Item::Heater(_) | Item::HeatGun) => Section::Heat,
        };
        if !self.open_sections.contains(&section) && !self.floating.contains(&section) {
            self.open_sections = [section].into();
        }
    }

    /// Whether a study is on, in which nothing may say what is shown.
    pub fn is_blind(&self) -> bool {
        self.study.as_ref().is_some_and(|study| !matches!(study.stage(), Stage::Welcome | Stage::Over))
    }
}

/// Everything, into a `ui` that fills the window: bars and panels around the view.
pub fn show(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    style::choose(ui.ctx(), state.light);
    if !ui.input(|i| i.pointer.any_down()) {
        // What is changed after the mouse has let go is undone apart.
        session.seal();
    }
    if state.is_blind() {
        egui::Panel::top("study").show(ui, |ui| study::bar(ui, session, state));
        if !session.messages().is_empty() {
            egui::Panel::bottom("messages").show(ui, |ui| messages(ui, session));
        }
        if state.study.as_ref().is_some_and(|s| matches!(s.stage(), Stage::Asking | Stage::Last)) {
            egui::Panel::bottom("questions").show(ui, |ui| study::questions(ui, session, state));
        }
        state.viewport = ui.available_rect_before_wrap();
        view(ui, session, state);
        study(ui, session, state);
        return;
    }
    egui::Panel::top("top").show(ui, |ui| top(ui, session, state));
    if !session.messages().is_empty() {
        egui::Panel::bottom("messages").show(ui, |ui| messages(ui, session));
    }
    let side = |right: bool, id: &'static str| if right { egui::Panel::right(id) } else { egui::Panel::left(id) };
    if state.controls {
        let panel = side(!state.swapped, "controls").resizable(false).exact_size(318.0);
        panel.show(ui, |ui| controls::column(ui, session, state));
    }
    if state.numbers {
        let panel = side(state.swapped, "numbers").resizable(false).exact_size(225.0);
        panel.show(ui, |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| numbers(ui, session));
        });
    }
    if state.timeline {
        egui::Panel::bottom("timeline").show(ui, |ui| timeline(ui, session, state));
    }
    session.time_stages(state.plots.shown && state.plots.stages);
    if state.plots.shown {
        let panel = egui::Panel::bottom("plots").resizable(true).default_size(190.0).min_size(120.0);
        panel.show(ui, |ui| plots(ui, session, state));
    }
    state.viewport = ui.available_rect_before_wrap();
    view(ui, session, state);
    controls::windows(ui, session, state);
    help(ui, state);
    dialog(ui, session, state);
    generate(ui, session, state);
    export(ui, session, state);
    study(ui, session, state);
}
