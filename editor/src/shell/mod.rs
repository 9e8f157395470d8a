//! Bevy layer: a window or an image with the scene and the panels.
//!
//! `probe` tests whether a window is possible; `window` and `offscreen` are the two apps; `stage`
//! holds their lights, cameras and backdrop; `scenery` displays the session's world.

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

/// Session and state of the panels as a resource.
#[derive(Resource)]
pub struct Editor {
    /// Session: the world and its clock.
    pub session: Session,
    /// State of the panels.
    pub state: EditorState,
}

impl Editor {
    /// Lay out the panels over the whole of an egui context, which gets its style the first time.
    fn draw_panels(&mut self, ctx: &egui::Context, styled: &mut bool) {
        if !std::mem::replace(styled, true) {
            panels::apply_style(ctx);
        }
        let Self { session, state } = self;
        let everything = UiBuilder::new().layer_id(egui::LayerId::background()).max_rect(ctx.viewport_rect());
        let mut ui = egui::Ui::new(ctx.clone(), "editor".into(), everything);
        panels::show(&mut ui, session, state);
    }
}
