//! Entities that are disabled, hidden, changed and despawned in the ways of Bevy.
#![cfg(feature = "render")]

mod common;

use bevy::app::PluginGroup;
use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use bevy::state::app::StatesPlugin;
use bevy_sheetwork::HeaterHandle;
use bevy_sheetwork::prelude::*;
use common::{app, app_with, frame, run};

fn world(app: &App) -> &SheetWorld {
    app.world().resource::<SheetWorld>()
}

fn state(app: &App, entity: Entity) -> SheetState {
    *app.world().get::<SheetState>(entity).expect("every sheet has a state")
}

/// A falling card.
fn falling(app: &mut App, x: f32) -> Entity {
    let place = Transform::from_xyz(x, 2.0, 0.0).with_rotation(Quat::from_rotation_z(0.3));
    app.world_mut().spawn((Sheet::new("card").size(0.1, 0.1).grid(9, 9), place)).id()
}

fn disable(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).insert(Disabled);
}

fn enable(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<Disabled>();
}

#[test]
fn a_disabled_sheet_is_out_of_the_simulation_and_comes_back_with_its_state() {
    let mut app = app();
    let (sheet, other) = (falling(&mut app, 0.0), falling(&mut app, 1.0));
    run(&mut app, 0.2);
    let before = state(&app, sheet);
    assert!(before.velocity.y < -0.5, "{before:?}");
    let id = app.world().get::<SheetMotion>(sheet).expect("built").id();
    disable(&mut app, sheet);
    assert_eq!(world(&app).sheets().len(), 1);
    run(&mut app, 0.3);
    assert!(world(&app).get_sheet(id).is_none() && world(&app).sheets().len() == 1);
    assert_eq!(state(&app, sheet), before, "not stepped");
    assert!(state(&app, other).centre.y < before.centre.y);
    enable(&mut app, sheet);
    let name = app.world().get::<SheetMotion>(sheet).expect("kept").name().to_owned();
    let back = world(&app).get_sheet(id).expect("with its id");
    assert!(back.name == name && back.centre_of_mass().as_vec3().distance(before.centre) < 1e-6);
    frame(&mut app, 1.0 / 64.0);
    let after = state(&app, sheet);
    assert!(after.velocity.y < before.velocity.y && after.velocity.y > before.velocity.y - 0.2, "{after:?}");
    assert!(before.centre.y - after.centre.y < 0.05, "no jump");
}

#[test]
fn what_a_disabled_sheet_lay_on_or_carried_does_not_meet_it() {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let table = Sheet::new("card").size(0.3, 0.3).grid(7, 7).pin(Region::All);
    let table = app.world_mut().spawn((table, Transform::from_xyz(0.0, 0.2, 0.0))).id();
    let card = Sheet::new("card").size(0.1, 0.1).grid(7, 7);
    let card = app.world_mut().spawn((card, Transform::from_xyz(0.0, 0.22, 0.0))).id();
    run(&mut app, 1.0);
    assert!(state(&app, card).centre.y > 0.19, "it lies on the other");
    disable(&mut app, table);
    run(&mut app, 1.0);
    assert!(state(&app, card).centre.y < 0.05, "{:?}", state(&app, card));
}

#[test]
fn a_disabled_entity_can_be_despawned_changed_and_moved() {
    let mut app = app();
    let (gone, changed, fresh) = (falling(&mut app, 0.0), falling(&mut app, 1.0), falling(&mut app, 2.0));
    disable(&mut app, fresh);
    run(&mut app, 0.1);
    assert_eq!(world(&app).sheets().len(), 2, "disabled before it was built");
    [gone, changed].into_iter().for_each(|entity| disable(&mut app, entity));
    app.world_mut().despawn(gone);
    run(&mut app, 0.1);
    app.world_mut().get_mut::<Sheet>(changed).expect("there").spec.material = "paper".into();
    app.world_mut().get_mut::<Transform>(changed).expect("there").translation = Vec3::new(5.0, 3.0, 0.0);
    run(&mut app, 0.1);
    [changed, fresh].into_iter().for_each(|entity| enable(&mut app, entity));
    frame(&mut app, 1.0 / 64.0);
    assert_eq!(world(&app).sheets().len(), 2);
    let sheet = app.world().get::<SheetMotion>(changed).and_then(|motion| motion.sheet(world(&app))).expect("there");
    assert_eq!(sheet.material().name, "paper");
    assert!(sheet.centre_of_mass().as_vec3().distance(Vec3::new(5.0, 3.0, 0.0)) < 0.1);
    run(&mut app, 0.2);
    [changed, fresh].into_iter().for_each(|entity| _ = app.world_mut().despawn(entity));
    assert!(world(&app).sheets().is_empty());
}

#[test]
fn disabled_bodies_and_heaters_are_out_until_they_are_enabled() {
    let mut app = app();
    let floor = app.world_mut().spawn(SheetBody::floor()).id();
    let heater = app.world_mut().spawn(SheetHeater::cuboid(0.4, 0.02, 0.4).hot(2, 300.0, 0.9)).id();
    let ball = SheetBody::ball(0.05).mass(0.1);
    let ball = app.world_mut().spawn((ball, Transform::from_xyz(0.5, 0.05, 0.0))).id();
    let height = |app: &App| app.world().get::<Transform>(ball).expect("there").translation.y;
    run(&mut app, 0.2);
    [floor, heater].into_iter().for_each(|entity| disable(&mut app, entity));
    run(&mut app, 0.3);
    assert!(height(&app) < 0.0, "it falls: {}", height(&app));
    assert!(app.world().get::<HeaterHandle>(heater).is_none() && app.world().get::<BodyMotion>(floor).is_none());
    [floor, heater].into_iter().for_each(|entity| enable(&mut app, entity));
    run(&mut app, 0.1);
    assert!(app.world().get::<HeaterHandle>(heater).is_some() && app.world().get::<BodyMotion>(floor).is_some());
}

#[test]
fn faces_of_a_disabled_sheet_are_not_drawn() {
    let mut app = app();
    let material = app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(Color::WHITE);
    let sheet = falling(&mut app, 0.0);
    app.world_mut().entity_mut(sheet).insert(SheetSides { back: Some(material), rim: None });
    run(&mut app, 0.1);
    let drawn = |app: &mut App| app.world_mut().query::<&Mesh3d>().iter(app.world()).count();
    assert_eq!(drawn(&mut app), 2);
    disable(&mut app, sheet);
    run(&mut app, 0.1);
    assert_eq!(drawn(&mut app), 0);
    enable(&mut app, sheet);
    run(&mut app, 0.1);
    assert_eq!(drawn(&mut app), 2);
}

#[test]
fn a_removed_component_removes_the_sheet_and_a_new_one_builds_it_at_its_transform() {
    let mut app = app();
    let sheet = falling(&mut app, 0.0);
    run(&mut app, 0.3);
    app.world_mut().entity_mut(sheet).remove::<Sheet>();
    assert!(world(&app).sheets().is_empty() && app.world().get::<SheetMotion>(sheet).is_none());
    run(&mut app, 0.3);
    let there = app.world().get::<Transform>(sheet).expect("kept").translation;
    app.world_mut().entity_mut(sheet).insert(Sheet::new("card").size(0.1, 0.1).grid(9, 9));
    frame(&mut app, 0.0);
    assert!(state(&app, sheet).centre.distance(there) < 1e-3, "{:?}", state(&app, sheet));
}

#[test]
fn a_hidden_sheet_is_simulated() {
    let mut app = app();
    let sheet = falling(&mut app, 0.0);
    app.world_mut().entity_mut(sheet).insert(Visibility::Hidden);
    run(&mut app, 0.3);
    assert!(state(&app, sheet).centre.y < 1.8);
    assert!(!app.world().get::<InheritedVisibility>(sheet).expect("there").get());
}

#[derive(States, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Screen {
    #[default]
    Play,
    Menu,
    End,
}

#[test]
fn states_stop_the_simulation_and_despawn_sheets() {
    let mut app = app_with(SheetworkPlugins.build().add(StatesPlugin));
    app.init_state::<Screen>();
    let sets = (SheetworkSet::Sync, SheetworkSet::Step, SheetworkSet::Writeback);
    app.configure_sets(FixedUpdate, sets.run_if(in_state(Screen::Play)));
    let sheet = falling(&mut app, 0.0);
    app.world_mut().entity_mut(sheet).insert(DespawnOnExit(Screen::Menu));
    run(&mut app, 0.2);
    let go = |app: &mut App, screen| {
        app.world_mut().resource_mut::<NextState<Screen>>().set(screen);
        frame(app, 0.0);
    };
    go(&mut app, Screen::Menu);
    let before = state(&app, sheet);
    run(&mut app, 0.5);
    assert_eq!(state(&app, sheet), before, "stopped");
    app.world_mut().entity_mut(sheet).insert(DespawnOnExit(Screen::Play));
    go(&mut app, Screen::Play);
    frame(&mut app, 1.0 / 64.0);
    let after = state(&app, sheet);
    assert!(after.centre.y < before.centre.y && after.centre.y > before.centre.y - 0.05, "{before:?} {after:?}");
    go(&mut app, Screen::End);
    assert!(world(&app).sheets().is_empty());
    assert!(app.world().get_entity(sheet).is_err());
}
