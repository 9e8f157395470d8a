//! Display: meshes and materials of sheets, bodies, heaters and the room.
//!
//! `sheet` updates the mesh of a sheet from its nodes, `clear` moves it out of bodies, `colour`
//! colours it by the fields of `measure`, `tangents` prepares it for normal maps. `solid` closes
//! the surface of a sheet with thickness, `sides` keeps the child entities of its faces. `body`,
//! `heater` and `room` make the other meshes, `grid` the texture of the room, `materials` the
//! defaults, `triangle_mesh` Bevy's mesh, which `mesh_arrays` writes in place.

mod body;
mod clear;
mod colour;
mod grid;
mod heater;
mod materials;
mod measure;
mod mesh_arrays;
mod room;
mod sheet;
mod sides;
mod solid;
mod tangents;
mod triangle_mesh;

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
pub use sheet::{MeshedSurface, SheetDisplay, SheetLayer, display_clearance};
pub use sides::{SheetSide, SheetSides};

use crate::core::Sheet;
use materials::Materials;

/// Plugin that displays sheets, bodies, heaters and rooms.
///
/// An entity with its own `Mesh3d` (a body) or `MeshMaterial3d<StandardMaterial>` keeps it. Without
/// assets for meshes, materials and images, as on a server, the plugin does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkRenderPlugin;

impl Plugin for SheetworkRenderPlugin {
    fn build(&self, app: &mut App) {
        let can_draw = resource_exists::<Assets<Mesh>>
            .and_then(resource_exists::<Assets<StandardMaterial>>)
            .and_then(resource_exists::<Assets<Image>>);
        app.register_required_components::<Sheet, SheetDisplay>();
        app.register_type::<SheetDisplay>().register_type::<SheetRoom>();
        app.register_type::<SheetSides>().register_type::<SheetSide>();
        app.init_resource::<Materials>();
        app.add_observer(sides::disabled).add_observer(sides::enabled);
        app.add_systems(
            PostUpdate,
            (
                (sheet::insert_meshes, body::insert_meshes, heater::insert_meshes, room::insert_meshes)
                    .after(crate::core::SheetworkSynced)
                    .before(TransformSystems::Propagate),
                sides::copy_render_components.after(sheet::insert_meshes).before(VisibilitySystems::CheckVisibility),
                // Before the asset events, to avoid a delay of one frame.
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
