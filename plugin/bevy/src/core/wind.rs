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
/// [`World::set_wind_zones`](sheetwork::World::set_wind_zones) has set. A zone out of range is
/// ignored with a warning.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform)]
pub struct SheetWind {
    /// Description of the zone. Its placement is relative to the entity.
    #[reflect(ignore)]
    pub zone: WindZone,
}

/// Zones last passed to the world; `None` while no entity has one.
#[derive(Default)]
pub(super) struct LastZones(Option<Vec<WindZone>>);

/// Pass the zones of all entities, in their order, to the world.
pub(super) fn sync(
    mut world: ResMut<SheetWorld>,
    zones: Query<(Entity, &SheetWind, Option<&Name>)>,
    mut given: Local<LastZones>,
    transforms: TransformHelper,
) {
    if zones.is_empty() && given.0.is_none() {
        return;
    }
    let mut entities: Vec<_> = zones.iter().collect();
    entities.sort_by_key(|(entity, ..)| *entity);
    let placed = entities.into_iter().filter_map(|(entity, wind, name)| {
        let there = transforms.compute_global_transform(entity).ok()?;
        let inner = placement::pose_of_placement(&wind.zone.placement);
        let placement = placement::placement_of(placement::compose(placement::pose_of(&there), inner));
        let mut zone = WindZone { placement, ..wind.zone.clone() };
        if let (true, Some(name)) = (zone.name.is_empty(), name) {
            zone.name = name.as_str().to_owned();
        }
        Some(zone)
    });
    let placed: Vec<WindZone> = placed.collect();
    let is_known = given.0.as_ref() == Some(&placed);
    // A restart, a reset or a rewind of the world may have brought other zones.
    if (!is_known || world.wind_zones() != placed)
        && let Err(error) = world.set_wind_zones(&placed)
        && !is_known
    {
        warn!("wind zones: {error}");
    }
    given.0 = Some(placed).filter(|placed| !placed.is_empty());
}
