//! Rollback: ticks repeated with late inputs equal, bit for bit, ticks with inputs in time.
#![cfg(feature = "render")]

mod common;

// Only the history of the example is used here.
#[allow(dead_code)]
#[path = "../examples/late_inputs/history.rs"]
mod history;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, frame};
use history::{History, LATE, blow};

fn hanging() -> App {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    app.world_mut().spawn((SheetBody::ball(0.02).mass(0.01), Transform::from_xyz(0.02, 0.3, 0.05)));
    let hangs = Transform::from_xyz(0.0, 0.2, 0.0).with_rotation(Quat::from_rotation_x(1.2));
    app.world_mut().spawn((Sheet::new("pet").size(0.2, 0.2).clamp(Region::Back), hangs));
    frame(&mut app, 0.0);
    app
}

/// Inputs of the players in a tick.
fn played(tick: u64) -> [f64; 2] {
    [if tick.is_multiple_of(7) { 1.0 } else { 0.0 }, if (tick / 5).is_multiple_of(2) { 1.0 } else { -1.0 }]
}

fn state(world: &SheetWorld) -> Vec<u8> {
    world.serialise()
}

#[test]
fn late_inputs_end_in_the_same_bits_as_inputs_in_time() {
    const TICKS: u64 = 30;
    let mut in_time = hanging();
    let mut late = hanging();
    {
        let mut world = in_time.world_mut().resource_mut::<SheetWorld>();
        for tick in 1..=TICKS {
            blow(&mut world, played(tick));
            world.step();
        }
    }
    let mut history = History::default();
    let mut rollbacks = 0;
    {
        let mut world = late.world_mut().resource_mut::<SheetWorld>();
        for tick in 1..=TICKS + LATE {
            if tick > TICKS {
                // The game has ended; late inputs still arrive.
                break;
            }
            history.begin(&world, [played(tick)[0], 0.0]);
            if let Some(then) = tick.checked_sub(LATE).filter(|t| *t >= 1)
                && history.arrives(then, played(then)[1])
            {
                history.replay(&mut world, then);
                rollbacks += 1;
            }
            blow(&mut world, history.inputs(tick));
            world.step();
        }
        // The last inputs arrive one by one.
        for then in TICKS - LATE + 1..=TICKS {
            if history.arrives(then, played(then)[1]) {
                history.replay(&mut world, then);
                blow(&mut world, history.inputs(TICKS));
                world.step();
                rollbacks += 1;
            }
        }
    }
    assert!(rollbacks >= 4, "{rollbacks}");
    let (a, b) = (in_time.world().resource::<SheetWorld>(), late.world().resource::<SheetWorld>());
    assert_eq!(a.steps(), b.steps());
    assert!(state(a) == state(b), "what was rolled back came out otherwise");
    assert!(a.sheets()[0].state.x.iter().zip(b.sheets()[0].state.x.iter()).all(|(p, q)| p == q));
}

#[test]
fn a_snapshot_of_other_sheets_is_rejected_and_changes_nothing() {
    let mut app = hanging();
    let saved = state(app.world().resource::<SheetWorld>());
    app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(1.0, 1.0, 0.0)));
    frame(&mut app, 0.0);
    let mut world = app.world_mut().resource_mut::<SheetWorld>();
    world.step();
    let before = state(&world);
    assert!(world.rewind(&saved).expect_err("other sheets").problem.contains("other sheets"));
    assert!(state(&world) == before);
}

/// Key of an entity that the game rolls back.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key(u64);

/// Components of an entity, as a rollback library stores them.
#[derive(Clone)]
struct Stored {
    key: Key,
    sheet: Option<(Sheet, Option<SheetMotion>)>,
    body: Option<(SheetBody, Option<BodyMotion>)>,
    transform: Transform,
}

/// Query of those components.
type StoredData = (
    &'static Key,
    Option<(&'static Sheet, Option<&'static SheetMotion>)>,
    Option<(&'static SheetBody, Option<&'static BodyMotion>)>,
    &'static Transform,
);

/// Game before a tick.
type Saved = (SheetCheckpoint, Vec<Stored>);

fn save(app: &mut App) -> Saved {
    let world = app.world_mut();
    let mut entities = world.query::<StoredData>();
    let mut stored = Vec::new();
    for (key, sheet, body, transform) in entities.iter(world) {
        let sheet = sheet.map(|(sheet, motion)| (sheet.clone(), motion.cloned()));
        let body = body.map(|(body, motion)| (body.clone(), motion.cloned()));
        stored.push(Stored { key: *key, sheet, body, transform: *transform });
    }
    (world.resource_mut::<SheetWorld>().checkpoint(), stored)
}

/// Despawns the entities that were not there, spawns those that are gone, and restores components.
fn load(app: &mut App, (checkpoint, stored): &Saved) {
    let world = app.world_mut();
    let present: Vec<(Entity, Key)> = world.query::<(Entity, &Key)>().iter(world).map(|(e, key)| (e, *key)).collect();
    for (entity, key) in &present {
        if !stored.iter().any(|stored| stored.key == *key) {
            world.despawn(*entity);
        }
    }
    for Stored { key, sheet, body, transform } in stored {
        let found = present.iter().find(|(_, other)| other == key).map(|(entity, _)| *entity);
        let entity = found.unwrap_or_else(|| world.spawn(*key).id());
        let mut entity = world.entity_mut(entity);
        entity.insert(*transform);
        if let Some((sheet, motion)) = sheet {
            entity.insert(sheet.clone());
            match motion {
                Some(motion) => entity.insert(motion.clone()),
                None => entity.remove::<SheetMotion>(),
            };
        }
        if let Some((body, motion)) = body {
            entity.insert(body.clone());
            match motion {
                Some(motion) => entity.insert(motion.clone()),
                None => entity.remove::<BodyMotion>(),
            };
        }
    }
    world.resource_mut::<SheetWorld>().rewind_to(checkpoint).expect("of this world");
}

/// Input of the other player: a card or a ball is thrown in, or the oldest thing of its kind goes.
fn input(tick: u64) -> u64 {
    [0, 1, 0, 0, 3, 0, 2, 1, 0, 4][(tick % 10) as usize]
}

/// One tick of the game with an input.
fn play(app: &mut App, tick: u64, input: u64) {
    let world = app.world_mut();
    let height = 0.1 + 0.01 * (tick % 7) as f32;
    let place = Transform::from_xyz(0.01 * (tick % 5) as f32, height, 0.0);
    match input {
        1 => _ = world.spawn((Key(tick), Sheet::new("card").size(0.1, 0.1).grid(7, 7), place)),
        3 => _ = world.spawn((Key(tick), SheetBody::ball(0.02).mass(0.01), place)),
        2 | 4 => {
            let mut keys = world.query::<(Entity, &Key, Has<Sheet>)>();
            let of_kind = keys.iter(world).filter(|(_, _, is_sheet)| *is_sheet == (input == 2));
            if let Some((entity, ..)) = of_kind.min_by_key(|(_, key, _)| **key) {
                world.despawn(entity);
            }
        }
        _ => {}
    }
    world.run_schedule(FixedUpdate);
}

fn table() -> App {
    let mut app = app();
    app.world_mut().resource_mut::<SheetClock>().max_ticks_per_frame = u32::MAX;
    app.world_mut().spawn(SheetBody::floor());
    frame(&mut app, 0.0);
    app
}

#[test]
fn late_spawns_and_despawns_end_in_the_same_bits_as_those_in_time() {
    const TICKS: u64 = 40;
    const DELAY: u64 = 6;
    let (mut in_time, mut late) = (table(), table());
    (1..=TICKS).for_each(|tick| play(&mut in_time, tick, input(tick)));
    let mut saved: Vec<Saved> = vec![save(&mut late)];
    let mut rollbacks = 0;
    for tick in 1..=TICKS {
        // The input of this tick is guessed to be that of the tick before the last one known.
        let guess = |tick: u64, now: u64| input(if tick + DELAY <= now { tick } else { tick.saturating_sub(1) });
        saved.push(save(&mut late));
        play(&mut late, tick, guess(tick, tick));
        let known = tick.saturating_sub(DELAY);
        if known >= 1 && input(known) != input(known - 1) {
            load(&mut late, &saved[known as usize]);
            rollbacks += 1;
            for again in known..=tick {
                saved[again as usize] = save(&mut late);
                play(&mut late, again, guess(again, tick));
            }
        }
    }
    load(&mut late, &saved[(TICKS - DELAY) as usize]);
    (TICKS - DELAY..=TICKS).for_each(|tick| play(&mut late, tick, input(tick)));
    assert!(rollbacks > 20, "{rollbacks}");
    let ids = |app: &mut App| {
        let world = app.world_mut();
        let mut ids: Vec<_> = world.query::<(&Key, &SheetMotion)>().iter(world).map(|(k, m)| (k.0, m.id())).collect();
        ids.sort();
        ids
    };
    assert_eq!(ids(&mut in_time), ids(&mut late));
    let (a, b) = (in_time.world().resource::<SheetWorld>(), late.world().resource::<SheetWorld>());
    assert_eq!((a.steps(), a.sheets().len()), (b.steps(), b.sheets().len()));
    assert!(a.sheets().len() > 2 && a.sheets().iter().any(|sheet| sheet.touching().contains(&true)));
    assert!(state(a) == state(b), "other bits");
}

#[test]
fn an_entity_that_the_game_does_not_roll_back_gets_a_new_sheet() {
    let mut app = table();
    let checkpoint = app.world_mut().resource_mut::<SheetWorld>().checkpoint();
    play(&mut app, 1, 1);
    play(&mut app, 2, 0);
    app.world_mut().resource_mut::<SheetWorld>().rewind_to(&checkpoint).expect("of this world");
    assert!(app.world().resource::<SheetWorld>().sheets().is_empty());
    frame(&mut app, 0.0);
    let world = app.world().resource::<SheetWorld>();
    assert_eq!((world.sheets().len(), world.steps()), (1, 0));
    let settings = world.scene().clone();
    let mut world = app.world_mut().resource_mut::<SheetWorld>();
    world.restart(&settings).expect("valid");
    assert!(world.rewind_to(&checkpoint).expect_err("another world").problem.contains("restarted"));
}
