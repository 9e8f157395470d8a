//! Component that describes a heat gun, which blows along the forward direction of its entity.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::HeatGunSpec;

use super::{SheetWorld, placement};

/// Jet of hot air from the entity's position along its forward direction, -z. The entity's
/// transform moves and turns the jet.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # fn setup(mut commands: Commands) {
/// let nozzle = Transform::from_xyz(0.0, 0.2, 0.0).looking_at(Vec3::ZERO, Vec3::Z);
/// commands.spawn((SheetHeatGun { temperature: 250.0, ..default() }, nozzle));
/// # }
/// ```
///
/// A world has one heat gun: the first such entity of the query.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform)]
pub struct SheetHeatGun {
    /// Whether the gun is on.
    pub on: bool,
    /// Temperature of the jet, °C; -273.15 to 5000.
    pub temperature: f64,
    /// Convection coefficient at the nozzle, W/(m² K); 0 to 1e6.
    pub convection: f64,
    /// Angle from the axis at which a third of the convection remains, degrees; 0.1 to 90.
    pub half_angle: f64,
    /// Distance at which half of the convection remains, m; 1e-6 to 1e4.
    pub reach: f64,
}

impl Default for SheetHeatGun {
    fn default() -> Self {
        let HeatGunSpec { on, temperature, convection, half_angle, reach, .. } = HeatGunSpec::default();
        Self { on, temperature, convection, half_angle, reach }
    }
}

/// Heat gun last passed to the world: entity, generation of the world, description, transform.
#[derive(Default)]
pub(super) struct LastAim(Option<(Entity, u32, SheetHeatGun, GlobalTransform)>);

/// Pass the description and the aim of the heat gun to the world.
pub(super) fn aim(
    mut world: ResMut<SheetWorld>,
    guns: Query<(Entity, &SheetHeatGun)>,
    mut aimed: Local<LastAim>,
    transforms: TransformHelper,
) {
    let Some((entity, gun)) = guns.iter().next() else {
        aimed.0 = None;
        return;
    };
    let Ok(there) = transforms.compute_global_transform(entity) else { return };
    let now = (entity, world.generation(), *gun, there);
    if aimed.0 == Some(now) {
        return;
    }
    let placed = placement::placement_of(placement::pose_of(&there));
    let alike = aimed.0.is_some_and(|was| (was.0, was.1, was.2) == (now.0, now.1, now.2));
    if !(alike && world.place_heat_gun(&placed)) {
        let SheetHeatGun { on, temperature, convection, half_angle, reach } = *gun;
        let direction = placed.quaternion() * bevy::math::DVec3::NEG_Z;
        let path = Vec::new();
        let spec =
            HeatGunSpec { on, temperature, convection, half_angle, reach, position: placed.position, direction, path };
        if let Err(problem) = world.set_heat_gun(Some(spec)) {
            error!("heat gun {entity} is left as it was: {problem}");
        }
    }
    aimed.0 = Some(now);
}

/// Remove the heat gun from the world with its component.
pub(super) fn removed(_removed: On<Remove, SheetHeatGun>, mut world: ResMut<SheetWorld>) {
    // The removal of a heat gun cannot fail.
    let _ = world.set_heat_gun(None);
}
