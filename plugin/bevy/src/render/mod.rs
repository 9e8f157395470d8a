//! What is seen: meshes and materials for sheets, bodies and the room.
//!
//! `sheet` keeps a sheet's mesh where its masses are, `clear` keeps it out of bodies, `colour` gives it the colours of its temperature or of what `measure` finds; `body`
//! makes meshes of rigid bodies, `heater` of what heats, `room` draws floor and back wall with `grid`, the picture of their squares.

mod body;
mod clear;
mod colour;
mod grid;
mod heater;
mod materials;
mod measure;
mod room;
mod sheet;

use bevy::asset::AssetEventSystems;
use bevy::camera::visibility::VisibilitySystems;
use bevy::prelude::*;
use bevy::transform::TransformSystems;

pub use body::polyhedra_mesh;
pub use clear::clear_of_bodies;
pub use colour::{ColourScale, SheetColour, heat_colour};
pub use grid::grid_picture;
pub use heater::{glow, heater_meshes};
pub use room::{SheetRoom, room_mesh};
pub use sheet::{
    SheetDisplay, SheetLayer, clearing, sheet_mesh, triangles_of, update_sheet_colours, update_sheet_mesh,
};

use crate::core::Sheet;
use materials::Materials;

/// Gives sheets, bodies and rooms meshes and materials, and keeps them where the simulation has them.
///
/// An entity that already has a `Mesh3d` (a body) or a `MeshMaterial3d<StandardMaterial>` keeps its own. Does nothing where
/// there are no meshes or standard materials, as on a server.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkRenderPlugin;

impl Plugin for SheetworkRenderPlugin {
    fn build(&self, app: &mut App) {
        let can_draw = resource_exists::<Assets<Mesh>>
            .and_then(resource_exists::<Assets<StandardMaterial>>)
            .and_then(resource_exists::<Assets<Image>>);
        app.register_required_components::<Sheet, SheetDisplay>();
        app.register_type::<SheetDisplay>().register_type::<SheetRoom>();
        app.init_resource::<Materials>();
        app.add_systems(
            PostUpdate,
            (
                (sheet::dress, body::dress, heater::dress, room::dress)
                    .after(crate::core::SheetworkSynced)
                    .before(TransformSystems::Propagate),
                // Before the asset events are sent, or the picture would be a frame late.
                sheet::update
                    .after(TransformSystems::Propagate)
                    .after(VisibilitySystems::VisibilityPropagate)
                    .before(AssetEventSystems)
                    .before(VisibilitySystems::CheckVisibility),
            )
                .run_if(can_draw),
        );
    }
}
