//! Mistakes of a game: each is told once in the log, with its entity, and changes nothing.
#![cfg(feature = "render")]

mod common;

use std::fmt::{Debug, Write};
use std::sync::{Mutex, PoisonError};

use bevy::log::tracing::field::{Field, Visit};
use bevy::log::tracing::{Event, Level, Subscriber, subscriber};
use bevy::log::tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use bevy::log::tracing_subscriber::registry;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, run};

/// Warnings and errors so far.
static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Ear;

struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, _: &Field, value: &dyn Debug) {
        write!(self.0, "{value:?} ").expect("a text");
    }
}

impl<S: Subscriber> Layer<S> for Ear {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() <= Level::WARN {
            let mut text = Text(String::new());
            event.record(&mut text);
            SAID.lock().unwrap_or_else(PoisonError::into_inner).push(text.0);
        }
    }
}

/// Messages since the last call.
fn said() -> Vec<String> {
    std::mem::take(&mut *SAID.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Runs for a third of a second; there is one message, with `part` and the entity.
fn is_told_once(app: &mut App, entity: Entity, part: &str) {
    run(app, 0.3);
    let said = said();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains(part) && said[0].contains(&entity.to_string()), "{said:?}");
}

#[test]
fn mistakes_are_told_once_with_their_entity() {
    subscriber::set_global_default(registry().with(Ear)).expect("the first");
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let card = app.world_mut().spawn((Sheet::new("card").size(0.1, 0.1), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.05);
    said();
    app.world_mut().entity_mut(card).insert(SheetContacts::above(f32::NAN));
    is_told_once(&mut app, card, "threshold");
    app.world_mut().entity_mut(card).insert(SheetContacts::default());
    run(&mut app, 1.0);
    assert!(!app.world().get::<SheetContacts>(card).expect("there").pairs.is_empty(), "it lies on the floor");

    let zone = WindZone { velocity: Vec3::splat(f32::NAN).as_dvec3(), ..default() };
    let fan = app.world_mut().spawn(SheetWind { zone }).id();
    is_told_once(&mut app, fan, "velocity");
    app.world_mut().despawn(fan);

    let nobody = app.world_mut().spawn_empty().id();
    app.world_mut().entity_mut(card).insert(SheetAttachments::new(Region::Left, nobody));
    is_told_once(&mut app, nobody, "body");
    // The body comes later.
    app.world_mut().entity_mut(nobody).insert((SheetBody::ball(0.02), Transform::from_xyz(0.5, 0.5, 0.5)));
    run(&mut app, 0.1);
    let world = app.world().resource::<SheetWorld>();
    assert!(world.sheets()[0].is_held(0), "attached now");
    app.world_mut().despawn(nobody);
    run(&mut app, 0.1);
    said();

    let centre = |app: &App| app.world().get::<SheetState>(card).expect("there").centre;
    let before = centre(&app);
    app.world_mut().get_mut::<Transform>(card).expect("there").translation.x = f32::NAN;
    is_told_once(&mut app, card, "finite");
    assert!(centre(&app).distance(before) < 0.01);

    let parent = app.world_mut().spawn(Transform::default()).id();
    let child = Sheet::new("card").size(0.1, 0.1).grid(7, 7).clamp(Region::Left);
    let child = app.world_mut().spawn((child, Transform::from_xyz(2.0, 1.0, 0.0), ChildOf(parent))).id();
    run(&mut app, 0.05);
    app.world_mut().get_mut::<Transform>(parent).expect("there").scale = Vec3::splat(2.0);
    is_told_once(&mut app, child, "scale");
    app.world_mut().get_mut::<Transform>(parent).expect("there").rotate_y(0.1);
    is_told_once(&mut app, child, "clamp");
    app.world_mut().despawn(child);

    app.world_mut().despawn(card);
    run(&mut app, 0.1);
    assert!(said().is_empty());
    assert!(app.world().resource::<SheetWorld>().sheets().is_empty());
}
