//! The thin Bevy layer: a window or an image with the scene in it, and the panels around.
//!
//! `probe` asks whether there can be a window; `window` and `offscreen` are the two apps; `stage` is what they share: lights,
//! camera, backdrop; `scenery` shows the session's world.

mod keyboard;
pub mod offscreen;
pub mod probe;
mod scenery;
mod shapes;
mod stage;
pub mod window;

use bevy::prelude::Resource;
use bevy_egui::egui::{self, UiBuilder};

use crate::panels::{self, EditorState};
use crate::session::Session;

/// The session and what the editor remembers, as Bevy holds them.
#[derive(Resource)]
pub struct Editor {
    /// The world and its clock.
    pub session: Session,
    /// The rest.
    pub state: EditorState,
}

impl Editor {
    /// Lays the panels over the whole of an egui context.
    fn draw_panels(&mut self, ctx: &egui::Context) {
        let Self { session, state } = self;
        let everything = UiBuilder::new().layer_id(egui::LayerId::background()).max_rect(ctx.viewport_rect());
        let mut ui = egui::Ui::new(ctx.clone(), "editor".into(), everything);
        panels::show(&mut ui, session, state);
    }
}
