//! Sheets with thickness, and the child entities of faces with materials of their own.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{NoAutoAabb, RenderLayers};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::light::NotShadowCaster;
use bevy::prelude::*;

use super::solid::Face;

/// Thickness of a displayed sheet, with materials for its lower face and its rim.
///
/// With this component the mesh of a [`Sheet`](crate::Sheet) is closed: an upper and a lower face
/// at the distance of the material's thickness (m, not enlarged), and a rim between them along
/// outline, holes, cuts and tears. Single layers have their nodes in the middle between the faces;
/// in lattices of several layers the displayed layer is one of the faces. The default displays all
/// faces with the material of the sheet, in one mesh.
///
/// A face with a material of its own is a child entity with a [`SheetSide`], which appears and goes
/// with that material. It has the visibility, `RenderLayers` and `NotShadowCaster` of the sheet.
/// For a material of another type, replace `MeshMaterial3d<StandardMaterial>` of the child.
///
/// All faces have the (u, v) of their material point. A picture on the back that is to be read from
/// there needs [`StandardMaterial::FLIP_HORIZONTAL`] as `uv_transform`. Materials of a sheet with
/// sides should have no `depth_bias`, which draws hidden faces in front of visible ones. A moving
/// sheet with sides has about two and a half times the vertices of one without. Rays and picking
/// meet the nodes, half a thickness below a face of a single layer.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// fn setup(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
///     let colours = [Color::WHITE, Color::srgb(0.1, 0.3, 0.6), Color::srgb(0.6, 0.5, 0.4)];
///     let [front, back, rim] = colours.map(|colour| materials.add(colour));
///     commands.spawn((Sheet::new("card"), MeshMaterial3d(front), SheetSides::new(back, rim)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetSides {
    /// Material of the lower face; `None` for that of the sheet.
    pub back: Option<Handle<StandardMaterial>>,
    /// Material of the rim; `None` for that of the sheet.
    pub rim: Option<Handle<StandardMaterial>>,
}

/// Face of a sheet that a child entity displays.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub enum SheetSide {
    /// Lower face.
    Back,
    /// Rim between the faces.
    Rim,
}

/// Child entities of a sheet, in the order of its meshes.
#[derive(Component, Clone, Debug)]
pub(super) struct SideChildren(pub Vec<SideChild>);

/// Child entity that displays a face.
#[derive(Clone, Debug)]
pub(super) struct SideChild {
    side: SheetSide,
    entity: Entity,
    pub mesh: Handle<Mesh>,
}

impl SheetSides {
    /// Materials of the lower face and the rim.
    pub fn new(back: impl Into<Handle<StandardMaterial>>, rim: impl Into<Handle<StandardMaterial>>) -> Self {
        Self { back: Some(back.into()), rim: Some(rim.into()) }
    }

    /// Material of a side, if it has one of its own.
    pub fn material(&self, side: SheetSide) -> Option<&Handle<StandardMaterial>> {
        match side {
            SheetSide::Back => self.back.as_ref(),
            SheetSide::Rim => self.rim.as_ref(),
        }
    }

    /// Sides with materials of their own.
    pub(super) fn own(&self) -> impl Iterator<Item = SheetSide> {
        [SheetSide::Back, SheetSide::Rim].into_iter().filter(|side| self.material(*side).is_some())
    }
}

impl SheetSide {
    pub(super) fn face(self) -> Face {
        match self {
            Self::Back => Face::Lower,
            Self::Rim => Face::Rim,
        }
    }
}

impl SideChildren {
    /// Whether there is one child for each side with a material of its own, and all of them exist.
    pub fn fit(&self, sides: &SheetSides, exists: impl Fn(Entity) -> bool) -> bool {
        sides.own().eq(self.0.iter().map(|child| child.side)) && self.0.iter().all(|child| exists(child.entity))
    }

    /// Child entities, in the order of the meshes.
    pub fn entities(&self) -> impl Iterator<Item = Entity> {
        self.0.iter().map(|child| child.entity)
    }

    /// Give the children the present materials of `sides`.
    pub fn insert_materials(&self, commands: &mut Commands, sides: &SheetSides) {
        for child in &self.0 {
            if let Some(material) = sides.material(child.side) {
                commands.entity(child.entity).try_insert(MeshMaterial3d(material.clone()));
            }
        }
    }
}

/// Let the children of `sheet` display `made`: existing children keep their entity and mesh handle,
/// others are despawned, missing ones are spawned.
pub(super) fn replace_children(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    (sheet, old): (Entity, Option<&SideChildren>),
    sides: Option<&SheetSides>,
    made: Vec<(SheetSide, Mesh)>,
) {
    let mut old: Vec<SideChild> = old.map(|old| old.0.clone()).unwrap_or_default();
    let mut children = Vec::new();
    for (side, mesh) in made {
        let kept = old.iter().position(|child| child.side == side).map(|k| old.swap_remove(k));
        let kept = kept.filter(|child| commands.get_entity(child.entity).is_ok());
        let material = sides.and_then(|sides| sides.material(side)).cloned().unwrap_or_default();
        children.push(match kept {
            Some(child) if meshes.contains(&child.mesh) => {
                _ = meshes.insert(&child.mesh, mesh);
                child
            }
            kept => {
                old.extend(kept);
                let mesh = meshes.add(mesh);
                let drawn = (Mesh3d(mesh.clone()), MeshMaterial3d(material), NoAutoAabb, Aabb::default());
                let entity = commands.spawn((side, drawn, Pickable::IGNORE, ChildOf(sheet))).id();
                SideChild { side, entity, mesh }
            }
        });
    }
    for child in old {
        if let Ok(mut child) = commands.get_entity(child.entity) {
            child.try_despawn();
        }
    }
    match sides {
        Some(_) => commands.entity(sheet).try_insert(SideChildren(children)),
        None => commands.entity(sheet).try_remove::<SideChildren>(),
    };
}

/// Disable the children of a disabled sheet.
pub(super) fn disabled(
    added: On<Add, Disabled>,
    mut commands: Commands,
    sheets: Query<&SideChildren, Allow<Disabled>>,
) {
    let children = sheets.get(added.entity).into_iter().flat_map(SideChildren::entities);
    children.for_each(|child| _ = commands.entity(child).try_insert(Disabled));
}

/// Enable the children of an enabled sheet.
pub(super) fn enabled(
    removed: On<Remove, Disabled>,
    mut commands: Commands,
    sheets: Query<&SideChildren, Allow<Disabled>>,
) {
    let children = sheets.get(removed.entity).into_iter().flat_map(SideChildren::entities);
    children.for_each(|child| _ = commands.entity(child).try_remove::<Disabled>());
}

/// Give the children the render layers and shadows of their sheet.
pub(super) fn copy_render_components(
    mut commands: Commands,
    sheets: Query<(&SideChildren, Option<&RenderLayers>, Has<NotShadowCaster>)>,
    children: Query<(Option<&RenderLayers>, Has<NotShadowCaster>), With<SheetSide>>,
) {
    for (sides, layers, shadowless) in &sheets {
        for entity in sides.entities() {
            let Ok((own_layers, own_shadowless)) = children.get(entity) else { continue };
            if own_layers != layers {
                match layers {
                    Some(layers) => commands.entity(entity).try_insert(layers.clone()),
                    None => commands.entity(entity).try_remove::<RenderLayers>(),
                };
            }
            if own_shadowless != shadowless {
                match shadowless {
                    true => commands.entity(entity).try_insert(NotShadowCaster),
                    false => commands.entity(entity).try_remove::<NotShadowCaster>(),
                };
            }
        }
    }
}
