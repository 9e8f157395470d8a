//! Entities added to and removed from the world: a sheet in one line, static and moving bodies,
//! removal, changes.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, frame, run, thesis_app};

fn state(app: &App, entity: Entity) -> SheetState {
    *app.world().get::<SheetState>(entity).expect("every sheet has a state")
}

#[test]
fn a_sheet_spawned_in_one_line_falls_on_a_body_and_rests() {
    let mut app = thesis_app();
    app.world_mut().spawn(SheetBody::cuboid(0.1, 0.02, 0.1));
    let sheet = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.0, 0.03, 0.0))).id();
    frame(&mut app, 0.0);
    assert!((state(&app, sheet).centre.y - 0.0305).abs() < 1e-4, "in the world in the frame it was spawned in");
    run(&mut app, 4.0);
    let state = state(&app, sheet);
    assert!((state.centre.y - 0.0105).abs() < 1e-3, "lies on the box: {state:?}");
    assert!(state.asleep && state.contacts > 0 && !state.unstable, "{state:?}");
}

#[test]
fn the_readme_sheet_of_stiff_material_stays_stable() {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let sheet = Sheet::new("rubber").size(0.25, 0.25);
    let sheet = app.world_mut().spawn((sheet, Transform::from_xyz(0.0, 0.1, 0.0))).id();
    run(&mut app, 1.0);
    assert_eq!(app.world().resource::<SheetWorld>().dt(), 1.0 / 64.0, "the game's own step");
    let state = state(&app, sheet);
    assert!(!state.unstable && state.centre.y < 0.01, "{state:?}");
}

#[test]
fn the_initial_pose_and_size_follow_parents_and_scale() {
    let mut app = thesis_app();
    let turned = Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
    let parent = app.world_mut().spawn((turned, Visibility::default())).id();
    let local = Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::splat(2.0));
    let sheet = app.world_mut().spawn((Sheet::thesis(), local, ChildOf(parent))).id();
    frame(&mut app, 0.0);
    let name = app.world().get::<SheetMotion>(sheet).expect("built").name().to_owned();
    let world = app.world().resource::<SheetWorld>();
    let (low, high) = world.sheet(&name).expect("there").state.x.bounds().expect("masses");
    assert!(high.x < -0.997 && low.x > -1.01, "up is now to -x: {low} {high}");
    assert!((high.y - low.y - 0.05).abs() < 0.003, "twice as long, and upright: {low} {high}");
}

#[test]
fn despawned_entities_are_removed_from_the_world() {
    let mut app = thesis_app();
    let sheet = app.world_mut().spawn(Sheet::thesis()).id();
    let other = app.world_mut().spawn(Sheet::thesis().named("other")).id();
    let body = app.world_mut().spawn(SheetBody::ball(0.01)).id();
    run(&mut app, 0.1);
    let count = |app: &App| {
        let world = app.world().resource::<SheetWorld>();
        (world.sheets().len(), world.rigid().map_or(0, |r| r.bodies().len()))
    };
    assert_eq!(count(&app), (2, 1));
    app.world_mut().despawn(sheet);
    app.world_mut().entity_mut(body).remove::<SheetBody>();
    assert_eq!(count(&app), (1, 0));
    assert!(app.world().get::<SheetMotion>(other).is_some());
    assert!(app.world().get::<BodyMotion>(body).is_none());
    run(&mut app, 0.1);
    assert_eq!(count(&app), (1, 0));
}

#[test]
fn a_body_that_is_moved_carries_a_sheet_along() {
    let mut app = thesis_app();
    let tray = app.world_mut().spawn(SheetBody::cuboid(0.1, 0.01, 0.1).friction(2.0)).id();
    let sheet = app.world_mut().spawn((Sheet::thesis().friction(2.0), Transform::from_xyz(0.0, 0.006, 0.0))).id();
    run(&mut app, 1.0);
    for _ in 0..64 {
        app.world_mut().get_mut::<Transform>(tray).expect("has one").translation += Vec3::new(0.0005, 0.001, 0.0);
        frame(&mut app, 1.0 / 64.0);
    }
    let state = state(&app, sheet);
    assert!((state.centre.y - 0.0695).abs() < 2e-3, "lifted by 64 mm: {state:?}");
    assert!((state.centre.x - 0.032).abs() < 4e-3, "carried by 32 mm: {state:?}");
}

#[test]
fn a_body_moved_while_paused_is_put_there_without_pushing() {
    let mut app = thesis_app();
    let wall = app.world_mut().spawn((SheetBody::cuboid(0.01, 0.1, 0.1), Transform::from_xyz(-0.1, 0.0, 0.0))).id();
    app.world_mut().resource_mut::<SheetWorld>().set_gravity(bevy::math::DVec3::ZERO).expect("in range");
    let sheet = app.world_mut().spawn(Sheet::thesis()).id();
    run(&mut app, 0.1);
    app.world_mut().resource_mut::<SheetClock>().paused = true;
    app.world_mut().get_mut::<Transform>(wall).expect("has one").translation.x = 0.1;
    run(&mut app, 0.1);
    app.world_mut().resource_mut::<SheetClock>().paused = false;
    run(&mut app, 0.1);
    assert!(state(&app, sheet).centre.length() < 2e-3, "{:?}", state(&app, sheet));
    let motion = app.world().get::<BodyMotion>(wall).expect("in the world again");
    let rigid = app.world().resource::<SheetWorld>();
    let index = rigid.rigid().expect("owned").bodies().iter().position(|b| b.name == motion.name()).expect("named");
    assert!((rigid.rigid().and_then(|r| r.pose(index)).expect("there").0.x - 0.1).abs() < 1e-6);
}

#[test]
fn the_path_of_a_body_starts_when_it_is_spawned() {
    let mut app = app();
    run(&mut app, 0.5);
    let key = |time, y| PathKey { time, offset: bevy::math::DVec3::new(0.0, y, 0.0), ..default() };
    let lift = SheetBody::ball(0.01).along([key(0.0, 0.0), key(1.0, 1.0)]);
    let lift = app.world_mut().spawn((lift, Transform::from_xyz(3.0, 0.0, 0.0))).id();
    run(&mut app, 0.5);
    let at = app.world().get::<Transform>(lift).expect("has one").translation;
    assert!((at.y - 0.5).abs() < 0.05 && at.x == 3.0, "{at}");
}

#[test]
fn changing_the_component_changes_the_sheet() {
    let mut app = thesis_app();
    let entity = app.world_mut().spawn((Sheet::thesis().pin(Region::All), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.2);
    let x = |app: &App| app.world().get::<SheetMotion>(entity).expect("built").positions().clone();
    let before = x(&app);
    app.world_mut().get_mut::<Sheet>(entity).expect("has one").spec.damping = 0.5;
    run(&mut app, 0.1);
    let sheets = app.world().resource::<SheetWorld>().sheets();
    assert_eq!((sheets.len(), sheets[0].damping()), (1, 0.5), "changed in place");
    assert_eq!(x(&app), before);
    app.world_mut().get_mut::<Sheet>(entity).expect("has one").spec.grid = (5, 1, 5);
    run(&mut app, 0.1);
    let sheets = app.world().resource::<SheetWorld>().sheets();
    assert_eq!((sheets.len(), sheets[0].node_count()), (1, 25), "built anew");
}

#[test]
fn a_rejected_entity_is_left_out_and_tried_again_after_a_change() {
    let mut app = app();
    let bad = app.world_mut().spawn(Sheet::new("cheese")).id();
    let body = app.world_mut().spawn(SheetBody::ball(-1.0)).id();
    run(&mut app, 0.1);
    assert!(app.world().resource::<SheetWorld>().is_empty());
    *app.world_mut().get_mut::<Sheet>(bad).expect("has one") = Sheet::new("rubber");
    *app.world_mut().get_mut::<SheetBody>(body).expect("has one") = SheetBody::ball(1.0);
    run(&mut app, 0.1);
    let world = app.world().resource::<SheetWorld>();
    assert_eq!((world.sheets().len(), world.rigid().map_or(0, |r| r.bodies().len())), (1, 1));
}

#[test]
fn events_are_sent_with_their_entities() {
    #[derive(Resource, Default)]
    struct Heard(Vec<SheetEvent>);
    let mut app = thesis_app();
    app.init_resource::<Heard>().add_systems(
        Update,
        |mut events: MessageReader<SheetEvent>, mut heard: ResMut<Heard>| {
            heard.0.extend(events.read().cloned());
        },
    );
    let floor = app.world_mut().spawn(SheetBody::floor().named("ground")).id();
    let sheet = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.0, 0.01, 0.0))).id();
    run(&mut app, 3.0);
    let heard = &app.world().resource::<Heard>().0;
    let first = heard.iter().find(|e| e.kind == EventKind::FirstContact).expect("it landed");
    assert_eq!((first.entity, first.body_entity, first.body.as_deref()), (Some(sheet), Some(floor), Some("ground")));
    assert_eq!(heard.iter().filter(|e| e.kind == EventKind::FirstContact).count(), 1);
    assert!(heard.iter().any(|e| e.kind == EventKind::AtRest), "{heard:?}");
}

#[test]
fn components_are_reflected_field_by_field() {
    use bevy::reflect::{GetPath, TypeRegistry};
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let has = |registry: &TypeRegistry, path: &str| registry.get_with_type_path(path).is_some();
    for name in
        ["core::sheet::Sheet", "core::body::SheetBody", "core::state::SheetState", "render::sheet::SheetDisplay"]
    {
        assert!(has(&registry, &format!("bevy_sheetwork::{name}")), "{name}");
    }
    let mut sheet = Sheet::new("hips");
    *sheet.path_mut::<f64>(".spec.damping").expect("reflected") = 0.25;
    assert_eq!(sheet.spec.damping, 0.25);
    assert_eq!(sheet.path::<(f64, f64)>(".spec.size").expect("reflected"), &(0.25, 0.25));
}

/// A sheet of paper pinned along its left edge at a height of 1 m, after `seconds`.
fn hanging_card(seconds: f64) -> (App, Entity) {
    let mut app = app();
    let card = Sheet::new("paper").size(0.2, 0.1).grid(11, 6).pin(Region::Left);
    let entity = app.world_mut().spawn((card, Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, seconds);
    (app, entity)
}

#[test]
fn cleared_pins_let_a_sheet_fall_as_it_hangs() {
    let (mut app, entity) = hanging_card(2.0);
    let lowest = |app: &App| {
        let sheets = app.world().resource::<SheetWorld>();
        sheets.sheets()[0].state.x.iter().map(|x| x.y).fold(f64::INFINITY, f64::min)
    };
    let hung = lowest(&app);
    assert!(hung < 0.9, "it has not come down: {hung} m");
    app.world_mut().get_mut::<Sheet>(entity).expect("there").spec.pins.clear();
    run(&mut app, 0.1);
    let fallen = lowest(&app);
    assert!(fallen < hung && fallen > hung - 0.15, "{hung} m, then {fallen} m");
    // Pinned again in the air.
    app.world_mut().get_mut::<Sheet>(entity).expect("there").spec.pins.push(PinSpec::fixed(Region::All));
    run(&mut app, 0.1);
    let held = lowest(&app);
    run(&mut app, 0.5);
    assert_eq!(lowest(&app), held);
}

#[test]
fn writing_the_transform_moves_a_sheet_with_its_shape() {
    let (mut app, entity) = hanging_card(1.0);
    let positions = |app: &App| app.world().resource::<SheetWorld>().sheets()[0].state.x.iter().collect::<Vec<_>>();
    run(&mut app, 4.0);
    let before = positions(&app);
    let from = *app.world().get::<Transform>(entity).expect("there");
    let to = Transform::from_xyz(3.0, 2.0, 0.0).with_rotation(Quat::from_rotation_y(0.5));
    *app.world_mut().get_mut::<Transform>(entity).expect("there") = to;
    frame(&mut app, 1.0 / 64.0);
    let after = positions(&app);
    let by = to.compute_affine() * from.compute_affine().inverse();
    for (was, is) in before.iter().zip(&after) {
        let wanted = by.transform_point3(was.as_vec3());
        assert!(wanted.distance(is.as_vec3()) < 5e-3, "{wanted} {is}");
    }
    // The pinned edge stays at its new place.
    run(&mut app, 1.0);
    let left = |all: &[bevy::math::DVec3]| all[0];
    assert!(left(&positions(&app)).distance(left(&after)) < 1e-9);
}

#[test]
fn a_sheet_survives_a_scene_of_bevy_with_pins_outline_and_cuts() {
    use bevy::reflect::serde::{TypedReflectDeserializer, TypedReflectSerializer};
    use bevy::reflect::{FromReflect, TypeRegistry};
    use serde::de::DeserializeSeed;

    let mut registry = TypeRegistry::default();
    registry.register::<Sheet>();
    let path = [PathKey::default(), PathKey { time: 1.0, offset: Vec3::Y.as_dvec3(), ..default() }];
    let sheet = Sheet::new("paper")
        .outline(OutlineSpec::Disc { radius: 0.1 })
        .hole(HoleSpec::Disc { centre: (0.01, 0.02), radius: 0.03 })
        .cut([(0.05, 0.0), (0.08, 0.0)])
        .pin_along(Region::Border, path)
        .probe("tip", 1.0, 0.5)
        .tearing();
    let text = ron::to_string(&TypedReflectSerializer::new(&sheet, &registry)).expect("serialises");
    let registration = registry.get(std::any::TypeId::of::<Sheet>()).expect("registered");
    let mut from = ron::Deserializer::from_str(&text).expect("RON");
    let read = TypedReflectDeserializer::new(registration, &registry).deserialize(&mut from).expect("its own");
    assert_eq!(Sheet::from_reflect(&*read).as_ref(), Some(&sheet));
    // A world of a scene clones its components.
    let copy = sheet.reflect_clone().expect("has a clone");
    assert_eq!(copy.downcast_ref::<Sheet>(), Some(&sheet));
}

#[test]
fn the_transform_follows_a_sheet_and_a_write_puts_it_there() {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let turned = Quat::from_rotation_y(0.7);
    let place = Transform::from_xyz(0.3, 0.5, 0.0).with_rotation(turned);
    let card = app.world_mut().spawn((Sheet::new("card").size(0.1, 0.1), place)).id();
    let transform = |app: &App| *app.world().get::<Transform>(card).expect("there");
    frame(&mut app, 0.0);
    assert_eq!(transform(&app), place, "as spawned");
    run(&mut app, 2.0);
    let lies = transform(&app);
    assert!(lies.translation.distance(Vec3::new(0.3, 0.0, 0.0)) < 2e-3, "{lies:?}");
    assert!(lies.rotation.angle_between(turned) < 1e-3, "{lies:?}");
    app.world_mut().get_mut::<Transform>(card).expect("there").translation = Vec3::new(1.0, 2.0, -3.0);
    frame(&mut app, 1.0 / 64.0);
    assert!(state(&app, card).centre.distance(Vec3::new(1.0, 2.0, -3.0)) < 5e-3, "{:?}", state(&app, card));
    assert!(transform(&app).translation.distance(Vec3::new(1.0, 2.0, -3.0)) < 5e-3);
    // A child of a turned and scaled parent, and a restart.
    let parent = Transform::from_xyz(5.0, 1.0, 0.0).with_rotation(turned).with_scale(Vec3::splat(2.0));
    let parent = app.world_mut().spawn((parent, Visibility::default())).id();
    let child = app.world_mut().spawn((Sheet::new("card").size(0.1, 0.1), ChildOf(parent))).id();
    run(&mut app, 1.0);
    let fallen = app.world().get::<Transform>(child).expect("there").translation;
    assert!(fallen.distance(Vec3::NEG_Y * 0.5) < 2e-3, "half a unit of the parent is a metre: {fallen}");
    let settings = app.world().resource::<SheetWorld>().scene().clone();
    app.world_mut().resource_mut::<SheetWorld>().restart(&settings).expect("valid");
    frame(&mut app, 0.0);
    assert!(state(&app, card).centre.distance(place.translation) < 1e-3, "{:?}", state(&app, card));
    assert!(state(&app, child).centre.distance(Vec3::new(5.0, 1.0, 0.0)) < 1e-3, "{:?}", state(&app, child));
}
