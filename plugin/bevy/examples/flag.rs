//! Two flags of light nylon in a turbulent wind. Arrow keys change it.
//!
//! `cargo run --release -p bevy_sheetwork --example flag`

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::TurbulenceSpec;

mod stage;

fn main() {
    let mut app = stage::app("flag", Vec3::new(0.9, 1.45, 1.9), Vec3::new(0.42, 1.38, 0.0), 2.6);
    app.add_systems(Startup, setup).add_systems(Update, blow).run();
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut paints: ResMut<Assets<StandardMaterial>>) {
    // The eddies travel along the cloth with the mean wind; the cloth waves with them.
    let turbulence = Some(TurbulenceSpec { intensity: 1.5, length: 0.6, seed: 1 });
    commands.spawn(SheetWind { zone: WindZone { velocity: DVec3::new(4.5, 0.0, 0.5), turbulence, ..default() } });
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
        let flag = Sheet::default().material(nylon).damping_ratio(0.02).size(0.8, 0.5).grid(25, 17);
        commands.spawn((flag.pin(Region::Left), MeshMaterial3d(cloth), upright));
    }
}

fn blow(keys: Option<Res<ButtonInput<KeyCode>>>, mut wind: Single<&mut SheetWind>) {
    let Some(keys) = keys else { return };
    let more = f64::from(keys.just_pressed(KeyCode::ArrowUp)) - f64::from(keys.just_pressed(KeyCode::ArrowDown));
    if more != 0.0 {
        wind.zone.velocity.x += more;
        info!("wind {} m/s", wind.zone.velocity.x);
    }
}
