//! What is seen: meshes and materials for sheets, bodies and the room.
//!
//! `sheet` keeps a sheet's mesh where its masses are, `clear` keeps it out of bodies, `colour` gives it the colours of its temperature or of what `measure` finds; `body`
//! makes meshes of rigid bodies, `heater` of what heats, `room` draws floor and back wall with `grid`, the picture of their squares.

mod body;
mod clear;
mod colour;
mod grid;
mod heater;
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

/// The materials that are given to what has none of its own; made when first needed.
#[derive(Resource, Default)]
struct Materials {
    sheet: Option<Handle<StandardMaterial>>,
    /// The same in white, for sheets that are coloured vertex by vertex.
    coloured: Option<Handle<StandardMaterial>>,
    body: Option<Handle<StandardMaterial>>,
    heater: Option<Handle<StandardMaterial>>,
}

impl Materials {
    /// A saturated plastic, seen from both sides.
    fn sheet(&mut self, coloured: bool, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: if coloured { Color::WHITE } else { Color::srgb(0.86, 0.13, 0.03) },
            perceptual_roughness: 0.38,
            reflectance: 0.5,
            double_sided: true,
            cull_mode: None,
            // A sheet that lies on a body is in its surface, and drawn before it: by some 0.1 % of its distance.
            depth_bias: 10_000.0,
            ..default()
        };
        let kept = if coloured { &mut self.coloured } else { &mut self.sheet };
        kept.get_or_insert_with(|| assets.add(make())).clone()
    }

    /// Whether a material is one that [`Materials::sheet`] gave.
    fn is_of_sheet(&self, material: &Handle<StandardMaterial>) -> bool {
        [&self.sheet, &self.coloured].into_iter().flatten().any(|m| m == material)
    }

    /// A dark metal.
    fn heater(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: Color::srgb(0.42, 0.43, 0.45),
            perceptual_roughness: 0.7,
            reflectance: 0.35,
            ..default()
        };
        self.heater.get_or_insert_with(|| assets.add(make())).clone()
    }

    /// A cool light grey.
    fn body(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: Color::srgb(0.60, 0.68, 0.78),
            perceptual_roughness: 0.62,
            reflectance: 0.35,
            ..default()
        };
        self.body.get_or_insert_with(|| assets.add(make())).clone()
    }
}
