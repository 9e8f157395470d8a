//! One rigid world for a game and its sheets: bevy_rapier3d owns the ramp and the ball; the sheet
//! is in contact with them.
//!
//! bevy_rapier3d steps in `FixedUpdate`. The sheets step after it, against its sets, and push its
//! dynamic bodies.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::rigid::RigidView;

fn main() {
    App::new()
        .add_plugins(DefaultPlugins)
        .add_plugins(RapierPhysicsPlugin::<NoUserData>::default().in_fixed_schedule())
        .add_plugins(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() }))
        .insert_resource(ClearColor(Color::srgb(0.80, 0.83, 0.87)))
        .insert_resource(TimestepMode::Fixed { dt: 1.0 / 64.0, substeps: 1 })
        .add_systems(Startup, setup)
        .add_systems(FixedUpdate, step_sheets.in_set(SheetworkSet::Step).after(PhysicsSet::Writeback))
        .run();
}

/// Step the sheets against the world of bevy_rapier3d after its own step.
fn step_sheets(
    rapier: Single<(&RapierContextSimulation, &RapierContextColliders, &mut RapierRigidBodySet)>,
    mut sheets: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
) {
    let (simulation, colliders, mut bodies) = rapier.into_inner();
    let view = RigidView::new(&simulation.broad_phase, &simulation.narrow_phase, &bodies.bodies, &colliders.colliders);
    sheets.advance_with(&view.pushing(), clock.due());
    sheets.write_lent_bodies(&mut bodies.bodies);
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.9, 0.9, 1.6).looking_at(Vec3::Y * 0.2, Vec3::Y)));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let mut solid = |shape: Mesh, colour: Color| (Mesh3d(meshes.add(shape)), MeshMaterial3d(materials.add(colour)));
    let (stone, blue) = (Color::srgb(0.6, 0.66, 0.72), Color::srgb(0.15, 0.35, 0.75));

    commands.spawn((
        solid(Cuboid::new(4.0, 0.1, 4.0).into(), stone),
        RigidBody::Fixed,
        Collider::cuboid(2.0, 0.05, 2.0),
        Transform::from_xyz(0.0, -0.05, 0.0),
    ));
    let ramp = Transform::from_xyz(-0.35, 0.3, 0.0).with_rotation(Quat::from_rotation_z(-0.5));
    commands.spawn((
        solid(Cuboid::new(1.0, 0.04, 0.8).into(), stone),
        RigidBody::Fixed,
        Collider::cuboid(0.5, 0.02, 0.4),
        Friction::coefficient(0.1),
        ramp,
    ));
    commands.spawn((
        solid(Sphere::new(0.12).into(), blue),
        RigidBody::Dynamic,
        Collider::ball(0.12),
        Restitution::coefficient(0.5),
        Transform::from_xyz(0.45, 0.9, 0.0),
    ));

    let above_ramp = ramp * Transform::from_xyz(-0.15, 0.06, 0.0);
    commands.spawn((Sheet::new("rubber").size(0.4, 0.4).friction(0.1), above_ramp));
    // A trampoline below the ball.
    let net = Sheet::new("rubber").size(0.5, 0.5).grid(17, 17).pin(Region::Border);
    commands.spawn((net, Transform::from_xyz(0.45, 0.35, 0.0)));
}
