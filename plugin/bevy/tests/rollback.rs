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
