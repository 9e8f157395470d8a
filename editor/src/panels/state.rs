//! State of the editor beside the session.

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
use crate::persistence::Persistence;
use crate::scenes;
use crate::session::{Item, Session};
use crate::study::{Stage, Study};

/// State of the editor beside the session.
pub struct EditorState {
    /// Displayed items.
    pub display: Display,
    /// Camera of the view.
    pub camera: Camera,
    /// Tool of the left button.
    pub tool: Tool,
    /// Object held by the tool.
    pub held: Option<Held>,
    /// Settings of the brush.
    pub brush: Brush,
    /// Item selected by the move tool.
    pub selected: Option<Item>,
    /// Index of the sheet in the sheet and material panels.
    pub sheet: usize,
    /// Contents of the field for a file name.
    pub path: String,
    /// Scenes of the menu.
    pub scenes: Vec<PathBuf>,
    /// Whether the help is open.
    pub help: bool,
    /// Whether the column of controls is shown.
    pub controls: bool,
    /// Open sections of the column.
    pub open_sections: BTreeSet<Section>,
    /// Sections detached from the column as windows.
    pub floating: BTreeSet<Section>,
    /// Whether the controls are on the left and the numbers on the right.
    pub swapped: bool,
    /// Whether the numbers are shown.
    pub numbers: bool,
    /// Whether the timeline is shown.
    pub timeline: bool,
    /// Displayed plots.
    pub plots: Plots,
    /// Whether the panels are light.
    pub light: bool,
    /// Droop previews of materials.
    pub previews: Previews,
    /// File dialog, while it is open.
    pub dialog: Option<Dialog>,
    /// Folder of the last opened or saved file.
    pub folder: Option<PathBuf>,
    /// Folder of the last export.
    pub out: Option<PathBuf>,
    /// Draft of a sheet, while its dialog is open.
    pub generate: Option<Draft>,
    /// Export in preparation or in progress.
    pub export: Option<Job>,
    /// Study, while it runs.
    pub study: Option<Study>,
    /// Session and camera before the study.
    pub aside: Option<(Box<Session>, Camera)>,
    /// Recent files and backups of unsaved work.
    pub persistence: Persistence,
    /// Unsaved work found at the start: backup and scene.
    pub left: Option<(PathBuf, Scene)>,
    /// Area of the view in the window, points; set by [`show`](super::show).
    pub viewport: Rect,
    /// Whether the user asked to quit.
    pub quit: bool,
}

impl EditorState {
    /// Initial state for this session. Nothing persists between runs until `persistence` has a
    /// folder.
    pub fn new(session: &Session) -> Self {
        Self {
            display: Display::default().for_session(session),
            camera: Camera::from_session(session),
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
            persistence: Persistence::new(None),
            left: None,
            viewport: Rect::ZERO,
            quit: false,
        }
    }
}

impl EditorState {
    /// Select the item of the move tool, and open its controls where they are hidden.
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

    /// Whether a study runs whose trials must stay anonymous.
    pub fn is_blind(&self) -> bool {
        self.study.as_ref().is_some_and(|study| !matches!(study.stage(), Stage::Welcome | Stage::Over))
    }

    /// Radius of the brush on a sheet, m.
    pub(super) fn brush_radius(&self, session: &Session, sheet: usize) -> f64 {
        let size = session.world().sheets().get(sheet).map_or((0.1, 0.1), |s| s.rest_size());
        self.brush.radius_on(size)
    }
}
