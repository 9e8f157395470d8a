//! Contacts of sheets as messages and on entities.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_rapier3d::rapier::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, Vector};
use bevy_sheetwork::prelude::*;
use common::{app, app_with, lend, run};

/// Messages so far.
#[derive(Resource, Default)]
struct Heard(Vec<SheetContact>);

/// Events so far.
#[derive(Resource, Default)]
struct Told(Vec<SheetEvent>);

fn listen(
    (mut heard, mut told): (ResMut<Heard>, ResMut<Told>),
    mut contacts: MessageReader<SheetContact>,
    mut events: MessageReader<SheetEvent>,
) {
    heard.0.extend(contacts.read());
    told.0.extend(events.read().cloned());
}

fn heard(app: &mut App) -> Vec<SheetContact> {
    std::mem::take(&mut app.world_mut().resource_mut::<Heard>().0)
}

fn with_ear(mut app: App) -> App {
    app.init_resource::<Heard>().init_resource::<Told>().add_systems(Update, listen);
    app
}

#[test]
fn contacts_begin_and_end_with_both_entities() {
    let mut app = with_ear(app());
    let floor = app.world_mut().spawn(SheetBody::floor()).id();
    let low = app.world_mut().spawn((Sheet::new("card").size(0.2, 0.2), Transform::from_xyz(0.0, 0.02, 0.0))).id();
    let high = app
        .world_mut()
        .spawn((Sheet::new("card").size(0.1, 0.1), SheetContacts::above(0.1), Transform::from_xyz(0.0, 0.1, 0.0)))
        .id();
    run(&mut app, 1.0);
    let said = heard(&mut app);
    let of_pair = |contact: &&SheetContact| contact.contact.sheet == Some(high) && contact.contact.partner == Some(low);
    assert_eq!(said.iter().filter(of_pair).filter(|c| c.kind == ContactEventKind::Began).count(), 1, "{said:?}");
    assert!(said.iter().any(|c| c.kind == ContactEventKind::ForceExceeded && c.contact.pair.force > 0.1), "{said:?}");
    assert!(!said.iter().any(|c| c.contact.partner == Some(floor)), "only the upper sheet records: {said:?}");
    let pairs = &app.world().get::<SheetContacts>(high).expect("there").pairs;
    assert_eq!(pairs.iter().map(|pair| (pair.sheet, pair.partner)).collect::<Vec<_>>(), [(Some(high), Some(low))]);
    // Without the sheet below the upper one falls on the floor.
    app.world_mut().despawn(low);
    run(&mut app, 1.0);
    let said = heard(&mut app);
    let kinds: Vec<_> = said.iter().map(|contact| (contact.kind, contact.contact.partner)).collect();
    assert!(kinds.contains(&(ContactEventKind::Ended, None)), "{said:?}");
    assert!(kinds.contains(&(ContactEventKind::Began, Some(floor))), "{said:?}");
    // A removed component sends nothing.
    app.world_mut().entity_mut(high).remove::<SheetContacts>();
    run(&mut app, 0.2);
    assert!(heard(&mut app).is_empty());
    assert!(app.world().resource::<SheetWorld>().contacts().is_empty());
}

#[test]
fn a_body_of_the_callers_world_is_named_by_its_entity() {
    let mut app = with_ear(app_with(SheetworkPlugins.set(SheetworkCorePlugin { borrow_bodies: true, ..default() })));
    let table = app.world_mut().spawn_empty().id();
    let mut game = PhysicsWorld::new();
    let body = game.insert_body(RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.1, 0.0)));
    // As bevy_rapier3d does.
    let collider = ColliderBuilder::cuboid(1.0, 0.1, 1.0).user_data(table.to_bits().into());
    game.insert_collider(collider, Some(body));
    lend(&mut app, game);
    let sheet =
        app.world_mut().spawn((Sheet::new("card"), SheetContacts::default(), Transform::from_xyz(0.0, 0.02, 0.0))).id();
    run(&mut app, 0.5);
    let said = heard(&mut app);
    assert_eq!(said.len(), 1, "{said:?}");
    assert_eq!((said[0].contact.sheet, said[0].contact.partner), (Some(sheet), Some(table)));
    let touched = |event: &&SheetEvent| event.kind == EventKind::FirstContact && event.body_entity == Some(table);
    assert_eq!(app.world().resource::<Told>().0.iter().filter(touched).count(), 1);
}
