//! Joints between bodies by entity, and forces on bodies.

mod common;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::rapier3d::prelude::{GenericJoint, JointAxis, RevoluteJointBuilder, Vector};
use common::{app, run};

fn hinge() -> GenericJoint {
    let joint = RevoluteJointBuilder::new(Vector::Y).local_anchor2(Vector::X * -0.25).contacts_enabled(false);
    joint.build().into()
}

fn x(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).expect("there").translation
}

#[test]
fn a_door_swings_on_its_hinge_is_driven_and_falls_when_the_hinge_goes() {
    let mut app = app();
    let post = app.world_mut().spawn((SheetBody::cuboid(0.02, 0.5, 0.02), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    let joint = app.world_mut().spawn_empty().id();
    // The door comes after the joint that names it.
    let door = app.world_mut().spawn_empty().id();
    app.world_mut().entity_mut(joint).insert(SheetJoint::new(post, door, hinge()));
    run(&mut app, 0.1);
    let panel = SheetBody::cuboid(0.4, 0.4, 0.02).mass(2.0);
    app.world_mut().entity_mut(door).insert((panel, Transform::from_xyz(0.25, 1.0, 0.0)));
    run(&mut app, 0.5);
    assert!((x(&app, door) - Vec3::new(0.25, 1.0, 0.0)).length() < 1e-3, "held by the hinge: {}", x(&app, door));
    let body = app.world().get::<BodyMotion>(door).and_then(BodyMotion::id).expect("built");
    app.world_mut().resource_mut::<SheetWorld>().apply_body_impulse(body, DVec3::Z * 0.5, None).expect("dynamic");
    run(&mut app, 0.5);
    let (turned, place) = (x(&app, door).z, x(&app, door));
    assert!(turned > 0.05 && (place.with_y(0.0).length() - 0.25).abs() < 1e-3, "{place}");
    let mut driven = hinge();
    driven.set_motor_velocity(JointAxis::AngX, 3.0, 100.0);
    app.world_mut().get_mut::<SheetJoint>(joint).expect("there").joint = driven;
    run(&mut app, 1.0);
    let spin = app.world().resource::<SheetWorld>().get_body(body).expect("there").spin();
    assert!((spin.y - 3.0).abs() < 0.1, "{spin}");
    app.world_mut().despawn(joint);
    run(&mut app, 0.5);
    assert!(x(&app, door).y < 0.5, "{}", x(&app, door));
}
