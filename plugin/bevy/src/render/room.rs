//! Room of a scene: floor and back wall with a square grid, visible from inside only.

use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use sheetwork::scene::Room;

use super::grid;
use super::triangle_mesh::triangle_mesh;

/// Displayed floor and back wall. Contact needs separate [`SheetBody`](crate::SheetBody)s.
///
/// Spawned with a scene that has a room, or on its own.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[require(Transform, Visibility)]
pub struct SheetRoom {
    /// Left, floor and back, m.
    pub low: Vec3,
    /// Right, top and front, m.
    pub high: Vec3,
    /// Spacing of the grid, m; more than 0.
    pub grid: f32,
    /// Whether the back wall is displayed.
    pub back_wall: bool,
}

impl Default for SheetRoom {
    fn default() -> Self {
        Self { low: Vec3::new(-1.0, 0.0, -1.0), high: Vec3::ONE, grid: 0.1, back_wall: true }
    }
}

impl From<&Room> for SheetRoom {
    fn from(room: &Room) -> Self {
        Self {
            low: Vec3::new(room.x.0 as f32, room.y.0 as f32, room.z.0 as f32),
            high: Vec3::new(room.x.1 as f32, room.y.1 as f32, room.z.1 as f32),
            grid: room.grid as f32,
            back_wall: room.back_wall,
        }
    }
}

/// Material of the grid, shared by all rooms.
#[derive(Default)]
pub(super) struct GridMaterial(Option<Handle<StandardMaterial>>);

/// Insert mesh and material of rooms; a new mesh after a change.
pub(super) fn insert_meshes(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    mut look: Local<GridMaterial>,
    rooms: Query<(Entity, &SheetRoom, Has<MeshMaterial3d<StandardMaterial>>), Changed<SheetRoom>>,
) {
    for (entity, room, has_material) in &rooms {
        commands.entity(entity).try_insert((Mesh3d(meshes.add(room_mesh(room))), NotShadowCaster));
        if !has_material {
            let material = look.0.get_or_insert_with(|| {
                materials.add(StandardMaterial {
                    base_color_texture: Some(images.add(grid::grid_picture())),
                    perceptual_roughness: 0.92,
                    reflectance: 0.15,
                    ..default()
                })
            });
            commands.entity(entity).try_insert(MeshMaterial3d(material.clone()));
        }
    }
}

/// Mesh of a room: two single-sided quadrilaterals for the texture of
/// [`grid_picture`](super::grid_picture).
pub fn room_mesh(room: &SheetRoom) -> Mesh {
    let (low, high) = (room.low, room.high);
    let scale = 1.0 / (room.grid.max(1e-6) * grid::SQUARES as f32);
    let (mut positions, mut normals, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut quad = |corners: [Vec3; 4], normal: Vec3, uv: fn(Vec3) -> Vec2| {
        let first = positions.len() as u32;
        for corner in corners {
            positions.push(corner.to_array());
            normals.push(normal.to_array());
            uvs.push((uv(corner - low) * scale).to_array());
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    };
    let at = Vec3::new;
    let floor = [at(low.x, low.y, high.z), at(high.x, low.y, high.z), at(high.x, low.y, low.z), low];
    quad(floor, Vec3::Y, |p| Vec2::new(p.x, p.z));
    if room.back_wall {
        let wall = [low, at(high.x, low.y, low.z), at(high.x, high.y, low.z), at(low.x, high.y, low.z)];
        quad(wall, Vec3::Z, |p| Vec2::new(p.x, p.y));
    }
    triangle_mesh(positions, normals, uvs, indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floor_and_wall_face_into_the_room() {
        let mesh = room_mesh(&SheetRoom::default());
        let triangles: Vec<_> = mesh.triangles().expect("a list of triangles").collect();
        assert_eq!(triangles.len(), 4);
        for (triangle, normal) in triangles.iter().zip([Vec3::Y, Vec3::Y, Vec3::Z, Vec3::Z]) {
            let [a, b, c] = triangle.vertices;
            assert!((b - a).cross(c - a).normalize().dot(normal) > 0.999, "{triangle:?}");
        }
    }
}
