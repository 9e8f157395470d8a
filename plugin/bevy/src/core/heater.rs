//! Component that describes a heater, and its addition to, motion in and removal from the world.

use bevy::ecs::query::Has;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::{HeaterSpec, HotFaceSpec};
use sheetwork::{HeaterId, InputError};

use super::reflect::HeaterSpecReflect;
use super::sync::{Rejected, insert_link};
use super::{SheetWorld, placement};

/// Polyhedron with hot faces, which radiate to the sheets on their outer side. Sheets and bodies
/// cast shadows; a heater makes no contact.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # fn setup(mut commands: Commands) {
/// // A panel half a metre above the floor that heats what is below it.
/// let panel = SheetHeater::cuboid(0.4, 0.02, 0.4).hot(2, 300.0, 0.9);
/// commands.spawn((panel, Transform::from_xyz(0.0, 0.5, 0.0)));
/// # }
/// ```
///
/// The entity's transform, without its scale, is the heater's pose, and moves it.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform)]
#[cfg_attr(feature = "render", require(Visibility))]
pub struct SheetHeater {
    /// Description of the heater. Its placement is relative to the entity.
    #[reflect(remote = HeaterSpecReflect)]
    pub spec: HeaterSpec,
}

impl From<HeaterSpec> for SheetHeater {
    fn from(spec: HeaterSpec) -> Self {
        Self { spec }
    }
}

impl SheetHeater {
    /// Box of this size, m, about its centre, without hot faces. The faces are numbered from 0: -x,
    /// +x, -y, +y, -z, +z.
    pub fn cuboid(x: impl Into<f64>, y: impl Into<f64>, z: impl Into<f64>) -> Self {
        HeaterSpec { size: Some(DVec3::new(x.into(), y.into(), z.into())), ..HeaterSpec::default() }.into()
    }

    /// Heater of a `.heater` file at this path (relative to the working directory).
    pub fn from_file(file: impl Into<std::path::PathBuf>) -> Self {
        HeaterSpec { file: Some(file.into()), ..HeaterSpec::default() }.into()
    }

    /// Make face number `face` hot: temperature in °C, -273.15 to 5000, emissivity 0 to 1.
    pub fn hot(mut self, face: u32, temperature: impl Into<f64>, emissivity: impl Into<f64>) -> Self {
        self.spec.hot.push(HotFaceSpec { face, temperature: temperature.into(), emissivity: emissivity.into() });
        self
    }

    /// Set the name in the world and in parameter paths, made unique there. When empty, the
    /// entity's `Name` is used.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.spec.name = name.into();
        self
    }

    /// Switch the heater on or off.
    pub fn on(mut self, on: bool) -> Self {
        self.spec.on = on;
        self
    }
}

/// Link from the entity to its heater in the [`SheetWorld`]. Inserted when the heater is built,
/// removed with its [`SheetHeater`].
#[derive(Component, Clone, Debug)]
pub struct HeaterHandle {
    id: HeaterId,
    name: String,
    generation: u32,
    built_from: SheetHeater,
    given: GlobalTransform,
}

impl HeaterHandle {
    /// Name of the heater in the world: `world.set("heaters.NAME.temperature", "250")`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the heater is in the world.
    pub(super) fn is_in(&self, world: &SheetWorld) -> bool {
        world.get_heater(self.id).is_some()
    }

    /// Remove the heater from the world.
    pub(super) fn remove_from(&self, world: &mut SheetWorld) {
        if self.generation == world.generation() {
            world.remove_heater(self.id);
        }
    }
}

/// Add new heaters, rebuild changed ones, and move those whose transform changed.
pub(super) fn sync(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    mut heaters: Query<(Entity, Ref<SheetHeater>, Option<&Name>, Option<&mut HeaterHandle>, Has<Rejected>)>,
    transforms: TransformHelper,
) {
    for (entity, heater, name, place, refused) in &mut heaters {
        if place.is_none() && refused && !heater.is_changed() {
            continue;
        }
        let Ok(there) = transforms.compute_global_transform(entity) else { continue };
        let inner = placement::pose_of_placement(&heater.spec.placement);
        let placed = placement::placement_of(placement::compose(placement::pose_of(&there), inner));
        if let Some(mut place) = place.filter(|p| p.generation == world.generation()) {
            if place.built_from == *heater {
                if place.given != there {
                    world.move_heater(place.id, &placed);
                    place.given = there;
                }
                continue;
            }
            world.remove_heater(place.id);
        }
        let mut spec = HeaterSpec { placement: placed, ..heater.spec.clone() };
        if let (true, Some(name)) = (spec.name.is_empty(), name) {
            spec.name = name.as_str().to_owned();
        }
        let added = insert(&mut world, &spec, &heater, there);
        insert_link::<HeaterHandle>(commands.entity(entity), "heater", added);
    }
}

/// Add a heater to the world at the placement of its description.
pub(crate) fn insert(
    world: &mut SheetWorld,
    spec: &HeaterSpec,
    built_from: &SheetHeater,
    given: GlobalTransform,
) -> Result<HeaterHandle, InputError> {
    let id = world.add_heater(spec)?;
    let name = world.get_heater(id).map(|h| h.name.clone()).unwrap_or_default();
    Ok(HeaterHandle { id, name, generation: world.generation(), built_from: built_from.clone(), given })
}

/// Remove the heater from the world with its component.
pub(super) fn removed(
    removed: On<Remove, SheetHeater>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    places: Query<&HeaterHandle>,
) {
    if let Ok(place) = places.get(removed.entity) {
        place.remove_from(&mut world);
        commands.entity(removed.entity).try_remove::<HeaterHandle>();
    }
}
