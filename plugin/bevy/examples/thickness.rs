//! Thick cards with a printed front, a blue back and an edge of bare board.
//!
//! `cargo run --release -p bevy_sheetwork --example thickness`

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::material;

mod stage;

/// Length and width of a card, m.
const SIZE: Vec2 = Vec2::new(0.15, 0.105);
/// Centre (from the middle of the card) and radius of its hole, m.
const HOLE: (Vec2, f32) = (Vec2::new(0.038, -0.015), 0.017);

fn main() {
    let mut app = stage::app("thickness", Vec3::new(0.025, 0.155, 0.265), Vec3::new(0.020, 0.010, 0.005), 1.5);
    app.add_systems(Startup, setup).run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    mut paints: ResMut<Assets<StandardMaterial>>,
) {
    let rough = StandardMaterial { perceptual_roughness: 0.85, reflectance: 0.3, ..default() };
    let print = Some(images.add(print()));
    let front = paints.add(StandardMaterial { base_color_texture: print, perceptual_roughness: 0.6, ..rough.clone() });
    let back = paints.add(StandardMaterial { base_color: Color::srgb(0.10, 0.27, 0.52), ..rough.clone() });
    let rim = paints.add(StandardMaterial { base_color: Color::srgb(0.72, 0.58, 0.40), ..rough.clone() });
    let wood = paints.add(StandardMaterial { base_color: Color::srgb(0.45, 0.33, 0.23), ..rough });
    // Board of 3 mm.
    let board = SheetMaterial {
        thickness: 3e-3,
        young: 8e8,
        density: 400.0,
        ..material::by_name("card").expect("in the library")
    };
    let hole = HoleSpec::Disc { centre: (f64::from(HOLE.0.x), f64::from(HOLE.0.y)), radius: f64::from(HOLE.1) };
    let card = Sheet::default().material(board).size(SIZE.x, SIZE.y).grid(37, 26).hole(hole);
    let sides = SheetSides::new(back, rim);
    let placed = |x: f32, y: f32, z: f32, turn: Quat| Transform::from_xyz(x, y, z).with_rotation(turn);
    let face_up = placed(-0.052, 0.036, 0.015, Quat::from_rotation_y(0.25) * Quat::from_rotation_x(0.30));
    let face_down = placed(0.098, 0.036, 0.005, Quat::from_rotation_y(-0.35) * Quat::from_rotation_x(3.44));
    for place in [face_up, face_down] {
        commands.spawn((card.clone(), MeshMaterial3d(front.clone()), sides.clone(), place));
    }
    let block = (Mesh3d(meshes.add(Cuboid::new(0.30, 0.03, 0.03))), MeshMaterial3d(wood));
    let block_body = SheetBody::cuboid(0.3, 0.03, 0.03).friction(0.6);
    commands.spawn((block, block_body, Transform::from_xyz(0.03, 0.015, -0.035)));
}

/// Picture of a sun over waves, with rings around the hole of the card.
fn print() -> Image {
    let size = Extent3d { width: 1000, height: 700, depth_or_array_layers: 1 };
    let mut data = Vec::new();
    for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
        let uv = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(size.width as f32, size.height as f32);
        data.extend(ink(uv * SIZE - 0.5 * SIZE).map(|channel| (255.0 * channel) as u8).into_iter().chain([255]));
    }
    let format = TextureFormat::Rgba8UnormSrgb;
    Image::new(size, TextureDimension::D2, data, format, RenderAssetUsages::default())
}

/// Colour of the print (sRGB) at a point of the card, m from its middle.
fn ink(point: Vec2) -> [f32; 3] {
    let to_edge = (0.5 * SIZE - point.abs()).min_element();
    if to_edge < 0.005 {
        return [0.96, 0.93, 0.86];
    }
    let rings = (point.distance(HOLE.0) - HOLE.1) / 0.006;
    if rings < 3.0 {
        return [[0.98, 0.80, 0.30], [0.95, 0.58, 0.22], [0.86, 0.33, 0.20]][rings.max(0.0) as usize];
    }
    for (level, colour) in [(0.03, [0.08, 0.25, 0.42]), (0.018, [0.16, 0.45, 0.58]), (0.005, [0.40, 0.68, 0.70])] {
        if point.y > level + 0.0035 * (120.0 * point.x + 180.0 * level).sin() {
            return colour;
        }
    }
    [0.97, 0.87, 0.70]
}
