//! Two flags of cloth-like paper in the wind. Arrow keys change it.
//!
//! `cargo run --release -p bevy_sheetwork --example flag`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;

mod stage;

fn main() {
    let mut app = stage::app("flag", Vec3::new(0.9, 1.5, 2.4), Vec3::new(0.45, 1.35, 0.0), 3.0);
    app.add_systems(Startup, setup).add_systems(Update, blow).run();
}

fn setup(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut paints: ResMut<Assets<StandardMaterial>>,
) {
    let mut air = world.air();
    air.wind = DVec3::new(6.0, 0.0, 1.0);
    world.set_air(air).expect("in range");
    let steel = paints.add(Color::srgb(0.55, 0.56, 0.58));
    let pole = meshes.add(Cylinder::new(0.012, 1.8));
    let colours = [Color::srgb(0.75, 0.12, 0.15), Color::srgb(0.93, 0.73, 0.12)];
    for (k, colour) in colours.into_iter().enumerate() {
        let (x, z) = (0.1 * k as f32, -0.7 * k as f32);
        commands.spawn((Mesh3d(pole.clone()), MeshMaterial3d(steel.clone()), Transform::from_xyz(x - 0.014, 0.9, z)));
        let cloth = paints.add(StandardMaterial {
            base_color: colour,
            double_sided: true,
            cull_mode: None,
            perceptual_roughness: 0.8,
            ..default()
        });
        let upright = Transform::from_xyz(x + 0.4, 1.5, z).with_rotation(Quat::from_rotation_x(1.57));
        // A light woven nylon: stiff in its plane, limp in bending.
        let nylon = SheetMaterial { young: 2e8, poisson: 0.3, density: 600.0, thickness: 1.2e-4, ..default() };
        let flag = Sheet::default().material(nylon).damping_ratio(0.1).size(0.8, 0.5).grid(25, 17);
        commands.spawn((flag.pin(Region::Left), MeshMaterial3d(cloth), upright));
    }
}

fn blow(keys: Option<Res<ButtonInput<KeyCode>>>, mut world: ResMut<SheetWorld>) {
    let Some(keys) = keys else { return };
    let more = f64::from(keys.just_pressed(KeyCode::ArrowUp)) - f64::from(keys.just_pressed(KeyCode::ArrowDown));
    if more != 0.0 {
        let mut air = world.air();
        air.wind.x += 2.0 * more;
        if world.set_air(air).is_ok() {
            info!("wind {} m/s", air.wind.x);
        }
    }
}
