//! Component that describes a wind zone, and its transfer to the world.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::WindZone;

use super::{SheetWorld, placement};

/// Wind zone about the entity's position, along its axes: wind, gusts, turbulence, a vortex, a
/// blast or a fluid. The entity's transform, without its scale, moves and turns the zone.
///
/// ```
/// # use bevy::math::DVec3;
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # use bevy_sheetwork::sheetwork::scene::{WindZone, ZoneVolume};
/// # fn setup(mut commands: Commands) {
/// // A fan that blows along the forward direction of its entity, up to 3 m from it.
/// let volume = ZoneVolume::Ball(3.0);
/// let fan = SheetWind { zone: WindZone { volume, velocity: DVec3::NEG_Z * 4.0, ..default() } };
/// commands.spawn((fan, Transform::from_xyz(0.0, 1.0, 2.0)));
/// # }
/// ```
///
/// While there are such entities, they replace the zones that
/// [`World::set_wind_zones`](sheetwork::World::set_wind_zones) has set. With a zone
/// out of range all stay as they were, with a warning.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform)]
pub struct SheetWind {
    /// Description of the zone. Its placement is relative to the entity.
    #[reflect(ignore)]
    pub zone: WindZone,
}

/// Whether any entity has had a zone since the last without, and the last problem that was told.
#[derive(Default)]
pub(super) struct LastZones {
    has_zones: bool,
    told: Option<String>,
}

/// Pass the zones of all entities, in their order, to the world.
pub(super) fn sync(
    mut world: ResMut<SheetWorld>,
    zones: Query<(Entity, &SheetWind, Option<&Name>)>,
    mut last: Local<LastZones>,
    transforms: TransformHelper,
) {
    if zones.is_empty() && !last.has_zones {
        return;
    }
    let mut entities: Vec<_> = zones.iter().collect();
    entities.sort_by_key(|(entity, ..)| *entity);
    let placed: Vec<WindZone> =
        entities.iter().filter_map(|(entity, wind, name)| placed_zone(*entity, wind, *name, &transforms)).collect();
    last.has_zones = !placed.is_empty();
    // A restart, a reset or a rewind of the world may have brought other zones.
    let problem = if world.wind_zones() == placed { None } else { world.set_wind_zones(&placed).err() };
    let text = problem.map(|problem| {
        let index = problem.field.split('.').nth(1).and_then(|index| index.parse::<usize>().ok());
        let entity = index.and_then(|index| entities.get(index)).map(|(entity, ..)| entity.to_string());
        format!("wind zone of {}: {problem}", entity.unwrap_or_default())
    });
    if let Some(text) = text.as_ref().filter(|text| last.told.as_ref() != Some(text)) {
        warn!("{text}; the zones stay as they were");
    }
    last.told = text;
}

/// Zone of an entity in the world.
fn placed_zone(
    entity: Entity,
    wind: &SheetWind,
    name: Option<&Name>,
    transforms: &TransformHelper,
) -> Option<WindZone> {
    let there = transforms.compute_global_transform(entity).ok()?;
    let inner = placement::pose_of_placement(&wind.zone.placement);
    let placement = placement::placement_of(placement::compose(placement::pose_of(&there), inner));
    let mut zone = WindZone { placement, ..wind.zone.clone() };
    if let (true, Some(name)) = (zone.name.is_empty(), name) {
        zone.name = name.as_str().to_owned();
    }
    Some(zone)
}
