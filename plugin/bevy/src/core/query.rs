//! Queries of the displayed sheets, with the entities of what they find.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sheetwork::{QueryFilter, SheetId, SheetQueries, SurfacePoint};

use super::{SheetMotion, SheetWorld};

/// System parameter for queries of the sheets as they are displayed, at [`SheetWorld::shown_time`]:
/// about a tick before the state of the world, which [`World::queries`](sheetwork::World::queries)
/// meets. Sheets are flat between their nodes; smoothing is not followed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// fn probe(sheets: SheetRayCast, eyes: Query<&GlobalTransform, With<Name>>) {
///     for eye in &eyes {
///         let ray = Ray3d::new(eye.translation(), eye.forward());
///         if let Some((entity, hit)) = sheets.cast_ray(ray, 10.0) {
///             info!("{entity} at {:?}, {} m away", hit.uv, hit.distance);
///         }
///     }
/// }
/// ```
#[derive(SystemParam)]
pub struct SheetRayCast<'w, 's> {
    world: Res<'w, SheetWorld>,
    sheets: Query<'w, 's, (Entity, &'static SheetMotion)>,
}

impl SheetRayCast<'_, '_> {
    /// Entity of a sheet, as of [`SurfacePoint::sheet`]; `None` for a sheet without entity.
    pub fn entity_of(&self, sheet: SheetId) -> Option<Entity> {
        let found = self.sheets.iter().find(|(_, motion)| motion.id() == sheet && motion.sheet(&self.world).is_some());
        found.map(|(entity, _)| entity)
    }

    /// Queries of the displayed surfaces that `filter` selects; all queries of a frame can use one
    /// value.
    pub fn queries(&self, filter: QueryFilter) -> SheetQueries<'_> {
        let time = self.world.shown_time();
        let mut motions: Vec<&SheetMotion> = self.sheets.iter().map(|(_, motion)| motion).collect();
        motions.retain(|motion| motion.sheet(&self.world).is_some());
        motions.sort_unstable_by_key(|motion| motion.id());
        let around = |id: SheetId| {
            let index = motions.binary_search_by_key(&id, |motion| motion.id()).ok()?;
            Some(motions[index].around(time))
        };
        self.world.queries_at(filter, around)
    }

    /// First point of a displayed upper layer on `ray`, at most `max_distance` (m) away, with its
    /// entity.
    pub fn cast_ray(&self, ray: Ray3d, max_distance: f64) -> Option<(Entity, SurfacePoint)> {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let hit = self.queries(QueryFilter::default()).cast_ray(origin, direction, max_distance)?;
        Some((self.entity_of(hit.sheet)?, hit))
    }
}
