//! A paper label comes off a bottle: its glue gives way column by column, and the paper, which
//! curls outwards by itself, rolls off.
//!
//! `cargo run --release -p bevy_sheetwork --example label`

use std::f64::consts::TAU;

use bevy::math::{DVec2, DVec3};
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::Polyhedron;

mod stage;

const RADIUS: f64 = 0.035;

#[derive(Resource)]
struct Bottle(Entity);

fn main() {
    let mut app = stage::app("label", Vec3::new(0.14, 0.20, 0.34), Vec3::new(0.02, 0.105, 0.0), 1.0);
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (wrap, peel).chain().before(SheetworkSet::Sync)).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let glass = MeshMaterial3d(paints.add(StandardMaterial {
        base_color: Color::srgb(0.05, 0.22, 0.10),
        perceptual_roughness: 0.12,
        ..default()
    }));
    let circle: Vec<DVec2> = (0..72).map(|k| RADIUS * DVec2::from_angle(TAU * f64::from(k) / 72.0)).collect();
    let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let bottle = SheetBody::polyhedron(Polyhedron::prism(&circle, 0.14));
    let bottle =
        commands.spawn((bottle, glass.clone(), Transform::from_xyz(0.0, 0.07, 0.0).with_rotation(upright))).id();
    commands.insert_resource(Bottle(bottle));
    let shoulder = ConicalFrustum { radius_top: 0.014, radius_bottom: RADIUS as f32, height: 0.035 };
    commands.spawn((Mesh3d(meshes.add(shoulder)), glass.clone(), Transform::from_xyz(0.0, 0.1575, 0.0)));
    let neck = Mesh3d(meshes.add(Cylinder::new(0.014, 0.06)));
    commands.spawn((neck, glass, Transform::from_xyz(0.0, 0.205, 0.0)));
    let print = MeshMaterial3d(paints.add(StandardMaterial {
        base_color: Color::srgb(0.93, 0.86, 0.66),
        perceptual_roughness: 0.9,
        double_sided: true,
        cull_mode: None,
        ..default()
    }));
    let mut label = Sheet::new("paper").size(0.13, 0.07).grid(21, 11).damping_ratio(0.2);
    label.spec.curl = (12.0, 0.0);
    commands.spawn((label, print, Transform::from_xyz(0.0, 0.4, 0.0)));
}

/// Wrap the new label around the bottle and glue it on.
fn wrap(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    bottle: Res<Bottle>,
    new: Query<(Entity, &SheetMotion), Added<SheetMotion>>,
) {
    for (entity, motion) in &new {
        let Some(sheet) = world.get_sheet_mut(motion.id()) else { continue };
        for i in 0..sheet.state.x.len() {
            let flat = sheet.state.x.get(i);
            let (sin, cos) = (flat.x / RADIUS + 0.1).sin_cos();
            let radius = RADIUS + 1e-4;
            sheet.state.x.set(i, DVec3::new(radius * sin, 0.075 - flat.z, radius * cos));
        }
        let column = |k: u32| Region::Rect((f64::from(k) / 20.0 - 0.01, f64::from(k) / 20.0 + 0.01), (0.0, 1.0));
        let glue = (0..20).map(|k| (column(k), bottle.0)).collect();
        commands.entity(entity).insert(SheetAttachments(glue));
    }
}

/// Let the glue of the outermost column give way, every 0.06 s.
fn peel(world: Res<SheetWorld>, mut labels: Query<&mut SheetAttachments>) {
    for mut label in &mut labels {
        let glued = 20 - (((world.time() - 0.2) / 0.06).max(0.0) as usize).min(9);
        if label.0.len() > glued {
            label.0.truncate(glued);
        }
    }
}
