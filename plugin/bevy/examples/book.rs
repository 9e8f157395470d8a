//! A page of an open book is turned by its corner.
//!
//! `cargo run --release -p bevy_sheetwork --example book`

use bevy::asset::RenderAssetUsages;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_sheetwork::prelude::*;

mod stage;

/// Page, m: A5.
const PAGE: (f64, f64) = (0.148, 0.21);

fn main() {
    let mut app = stage::app("book", Vec3::new(0.05, 0.23, 0.29), Vec3::new(0.0, 0.05, 0.0), 1.4);
    app.add_systems(Startup, setup).run();
}

fn setup(mut commands: Commands, mut images: ResMut<Assets<Image>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let cloth = MeshMaterial3d(paints.add(Color::srgb(0.10, 0.22, 0.30)));
    let edge = MeshMaterial3d(paints.add(Color::srgb(0.86, 0.82, 0.72)));
    let (length, width) = (PAGE.0 as f32, PAGE.1 as f32);
    commands.spawn((SheetBody::cuboid(0.31, 0.004, 0.22), cloth, Transform::from_xyz(0.0, 0.002, 0.0)));
    for side in [-1.0, 1.0] {
        let block = SheetBody::cuboid(length, 0.016, width).friction(0.3);
        commands.spawn((block, edge.clone(), Transform::from_xyz(side * (0.5 * length + 0.001), 0.012, 0.0)));
    }
    let printed = MeshMaterial3d(paints.add(StandardMaterial {
        base_color_texture: Some(images.add(print())),
        perceptual_roughness: 0.95,
        double_sided: true,
        cull_mode: None,
        ..default()
    }));
    let left = Sheet::new("paper").size(PAGE.0, PAGE.1).grid(12, 16).pin(Region::Right);
    commands.spawn((left, printed.clone(), Transform::from_xyz(-0.5 * length, 0.0202, 0.0)));
    for page in 0..3 {
        let mut paper = Sheet::new("paper").size(PAGE.0, PAGE.1).grid(12, 16).damping_ratio(0.1).pin(Region::Left);
        if page == 2 {
            paper.spec.pins.push(turned());
        }
        let place = Transform::from_xyz(0.5 * length, 0.0202 + 0.0004 * page as f32, 0.0);
        commands.spawn((paper, printed.clone(), place));
    }
}

/// Picture of a printed page: lines of words, and a margin.
fn print() -> Image {
    let (width, height) = (296, 420);
    let mut pixels = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let line = y / 10;
        let is_text = (40..260).contains(&x) && (4..38).contains(&line) && line % 9 != 8 && y % 10 < 4;
        let ink = is_text && (x / 3 * 37 + line * 101) % 23 > 3;
        pixels.extend(if ink { [120, 115, 110, 255] } else { [246, 241, 228, 255] });
    }
    let size = Extent3d { width, height, depth_or_array_layers: 1 };
    Image::new(size, TextureDimension::D2, pixels, TextureFormat::Rgba8UnormSrgb, RenderAssetUsages::RENDER_WORLD)
}

/// Motion of the corner that a hand holds: up, over the spine, and let go.
fn turned() -> PinSpec {
    let key = |time: f64| {
        let angle = (time - 0.3) / 1.5 * 2.6;
        let reach = PAGE.0 * (1.0 - 0.25 * angle.sin());
        let at = DVec3::new(reach * angle.cos(), reach * angle.sin(), -0.04 * angle.sin());
        PathKey { time, offset: at - DVec3::X * PAGE.0, ..default() }
    };
    let path = (0..=15).map(|k| key(0.3 + 0.1 * f64::from(k))).collect();
    PinSpec { path, until: Some(1.8), ..PinSpec::fixed(Region::Rect((0.95, 1.0), (0.95, 1.0))) }
}
