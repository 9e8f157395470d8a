//! A drinks can of aluminium, 0.1 mm thin, is crushed by a press and stays crumpled.
//!
//! `cargo run --release -p bevy_sheetwork --example can`

use std::f64::consts::TAU;

use bevy::math::{DVec2, DVec3};
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::{Polyhedron, material};

mod stage;

const RADIUS: f64 = 0.033;
const HEIGHT: f64 = 0.11;

/// Lid and bottom of the can.
#[derive(Resource)]
struct Ends(Entity, Entity);

fn main() {
    let mut app = stage::app("can", Vec3::new(0.11, 0.13, 0.20), Vec3::new(0.0, 0.062, 0.0), 0.55);
    app.add_systems(Startup, setup).add_systems(FixedUpdate, roll.before(SheetworkSet::Sync)).run();
}

fn setup(mut commands: Commands, mut paints: ResMut<Assets<StandardMaterial>>) {
    let metal = |color: Color, roughness| StandardMaterial {
        base_color: color,
        metallic: 0.35,
        perceptual_roughness: roughness,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    let red = MeshMaterial3d(paints.add(metal(Color::srgb(0.78, 0.10, 0.10), 0.35)));
    let silver = MeshMaterial3d(paints.add(metal(Color::srgb(0.75, 0.76, 0.78), 0.3)));
    let iron = MeshMaterial3d(paints.add(metal(Color::srgb(0.20, 0.22, 0.25), 0.5)));
    // The wall is a flat sheet at rest in the shape of a cylinder; `roll` gives it that shape.
    let alloy =
        SheetMaterial { thickness: 1e-4, yield_stress: Some(2.5e8), ..material::by_name("aluminium-foil").unwrap() };
    let mut wall = Sheet::default().material(alloy).size(TAU * RADIUS, HEIGHT).grid(33, 15).damping_ratio(0.3);
    wall.spec.plastic = true;
    wall.spec.curl = (1.0 / RADIUS, 0.0);
    commands.spawn((wall, red, Transform::from_xyz(0.0, 0.3, 0.0)));
    let circle: Vec<DVec2> = (0..32).map(|k| 1.02 * RADIUS * DVec2::from_angle(TAU * f64::from(k) / 32.0)).collect();
    let disc = SheetBody::polyhedron(Polyhedron::prism(&circle, 0.003));
    let at = |y| Transform::from_xyz(0.0, y, 0.0).with_rotation(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2));
    let bottom = commands.spawn((disc.clone(), silver.clone(), at(0.0015))).id();
    let key = |time, y| PathKey { time, offset: DVec3::Y * y, ..default() };
    // The lid stays down when the press has gone up again.
    let (start, down) = (key(0.1, 0.0), key(0.5, -0.026));
    let lid = commands.spawn((disc.along([start, down]), silver, at(HEIGHT as f32 + 0.0055))).id();
    commands.insert_resource(Ends(lid, bottom));
    let press = SheetBody::cuboid(0.09, 0.012, 0.09).along([start, down, key(1.3, 0.04)]);
    commands.spawn((press, iron, Transform::from_xyz(0.0, HEIGHT as f32 + 0.0135, 0.0)));
}

/// Roll the new sheet into a cylinder and solder it to the ends.
fn roll(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    ends: Res<Ends>,
    new: Query<(Entity, &SheetMotion), Added<SheetMotion>>,
) {
    for (entity, motion) in &new {
        let Some(sheet) = world.get_sheet_mut(motion.id()) else { continue };
        for i in 0..sheet.state.x.len() {
            let flat = sheet.state.x.get(i);
            let (sin, cos) = (0.996 * flat.x / RADIUS).sin_cos();
            sheet.state.x.set(i, DVec3::new(RADIUS * sin, 0.0035 + 0.5 * HEIGHT + flat.z, RADIUS * cos));
        }
        commands.entity(entity).insert(SheetAttachments::new(Region::Front, ends.0).and(Region::Back, ends.1));
    }
}
