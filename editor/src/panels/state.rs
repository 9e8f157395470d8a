//! The state of the editor beside the session.

use std::collections::BTreeSet;
use std::path::PathBuf;

use bevy_egui::egui::Rect;
use bevy_sheetwork::inspector::Previews;
use sheetwork::scene::Scene;

use super::dialog::Dialog;
use super::draft::Draft;
use super::options::{Display, Plots, Section};
use super::tool::{Brush, Held, Tool};
use crate::camera::Camera;
use crate::export::Job;
use crate::keeping::Keeper;
use crate::scenes;
use crate::session::{Item, Session};
use crate::study::{Stage, Study};

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
    /// Part of the window that shows the scene, points; filled in by [`show`](super::show).
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

    /// Radius of the brush on a sheet, m.
    pub(super) fn brush_radius(&self, session: &Session, sheet: usize) -> f64 {
        let size = session.world().sheets().get(sheet).map_or((0.1, 0.1), |s| s.rest_size());
        self.brush.radius_on(size)
    }
}
