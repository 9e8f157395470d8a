//! Backend of `bevy_picking`: sheets under the pointers.

use bevy::camera::visibility::RenderLayers;
use bevy::picking::PickingSystems;
use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::backend::{HitData, PointerHits};
use bevy::prelude::*;
use sheetwork::{QueryFilter, QueryLayer};

use crate::core::{SheetMotion, SheetWorld};
use crate::render::SheetDisplay;

/// Plugin that sends sheets under the pointers to `bevy_picking`, so that observers of
/// `Pointer<Over>`, `Pointer<Click>`, `Pointer<Drag>` and others on the entity of a sheet run.
///
/// Rays meet the displayed layer at the displayed time, flat between the nodes: where smoothing
/// bulges the displayed surface, the hit lies up to the height of that bulge beside it. Open cells
/// are not hit. The position of a hit is in world space (m), its normal faces the pointer, and
/// `hit.extra_as::<SurfacePoint>()` gives node, weights and (u, v).
///
/// Sheets do not need `MeshPickingPlugin`. In an app that has it for other entities, the nearer hit
/// of the two backends counts, and that of the mesh has no extra data; add `Pickable` and
/// `MeshPickingCamera` to the others and set `MeshPickingSettings::require_markers`. A sheet with
/// [`Pickable::IGNORE`] and a hidden one are not hit. Not part of
/// [`SheetworkPlugins`](crate::SheetworkPlugins).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # use bevy_sheetwork::sheetwork::SurfacePoint;
/// # fn setup(mut commands: Commands) {
/// commands.spawn(Sheet::new("card")).observe(push);
/// # }
///
/// fn push(click: On<Pointer<Click>>, mut world: ResMut<SheetWorld>) {
///     let Some(point) = click.hit.extra_as::<SurfacePoint>() else { return };
///     if let Some(sheet) = world.get_sheet_mut(point.sheet) {
///         _ = sheet.apply_impulse(point.node as usize, -1e-3 * point.normal);
///     }
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetPickingPlugin;

impl Plugin for SheetPickingPlugin {
    fn build(&self, app: &mut App) {
        let hits = update_hits.in_set(PickingSystems::Backend);
        app.add_systems(PreUpdate, hits.run_if(resource_exists::<RayMap>));
    }
}

/// Components of a sheet that decide whether and where a ray meets it.
type PickedSheet = (
    Entity,
    &'static SheetMotion,
    Option<&'static SheetDisplay>,
    Option<&'static InheritedVisibility>,
    Option<&'static Pickable>,
    Option<&'static RenderLayers>,
);

fn update_hits(
    rays: Res<RayMap>,
    world: Res<SheetWorld>,
    cameras: Query<(&Camera, Option<&RenderLayers>)>,
    sheets: Query<PickedSheet>,
    mut writer: MessageWriter<PointerHits>,
) {
    let all_layers = RenderLayers::default();
    for (id, ray) in rays.iter() {
        let Ok((camera, seen)) = cameras.get(id.camera) else { continue };
        let seen = seen.unwrap_or(&all_layers);
        let mut picks = Vec::new();
        for (entity, motion, display, visible, pickable, layers) in &sheets {
            let is_seen = seen.intersects(layers.unwrap_or(&all_layers));
            let is_shown = visible.is_none_or(|visible| visible.get());
            let is_wanted = pickable.is_none_or(|pickable| *pickable != Pickable::IGNORE);
            if is_seen && is_shown && is_wanted {
                picks.extend(meet(&world, motion, display, *id, *ray).map(|hit| (entity, hit)));
            }
        }
        if !picks.is_empty() {
            writer.write(PointerHits::new(id.pointer, picks, camera.order as f32));
        }
    }
}

/// First hit of a ray on the displayed layer of a sheet.
fn meet(
    world: &SheetWorld,
    motion: &SheetMotion,
    display: Option<&SheetDisplay>,
    id: RayId,
    ray: Ray3d,
) -> Option<HitData> {
    motion.sheet(world)?;
    let layer = display.map_or(QueryLayer::Upper, |display| display.layer.into());
    let filter = QueryFilter { layer, sheet: Some(motion.id()) };
    let queries = world.queries_at(filter, |_| Some(motion.around(world.shown_time())));
    let direction = ray.direction.as_dvec3();
    let hit = queries.cast_ray(ray.origin.as_dvec3(), direction, f64::INFINITY)?;
    let normal = if hit.normal.dot(direction) > 0.0 { -hit.normal } else { hit.normal };
    let (position, normal) = (hit.position.as_vec3(), normal.as_vec3());
    Some(HitData::new_with_extra(id.camera, hit.distance as f32, Some(position), Some(normal), hit))
}
