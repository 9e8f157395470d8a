//! Steps on another thread: the bits of the main thread, one tick later.
#![cfg(feature = "render")]

mod common;

use bevy::app::{App, PluginGroup};
use bevy::ecs::entity_disabling::Disabled;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, app_with, frame, run};

const TICK: f64 = 1.0 / 64.0;

fn threaded() -> App {
    let core = SheetworkCorePlugin { threading: SheetThreading::Background, ..default() };
    app_with(SheetworkPlugins.build().set(core))
}

fn world(app: &App) -> &SheetWorld {
    app.world().resource::<SheetWorld>()
}

/// A floor, a ball, a moving tray, and a sheet that hangs from a moving parent over them.
fn scene(app: &mut App) -> [Entity; 3] {
    app.world_mut().spawn(SheetBody::floor());
    app.world_mut().spawn((SheetBody::ball(0.03).mass(0.02), Transform::from_xyz(0.0, 0.25, 0.0)));
    let tray = app.world_mut().spawn((SheetBody::cuboid(0.2, 0.02, 0.2), Transform::from_xyz(0.3, 0.05, 0.0))).id();
    let parent = app.world_mut().spawn((Transform::from_xyz(0.0, 0.3, 0.0), Visibility::default())).id();
    let card = Sheet::new("card").size(0.2, 0.1).grid(9, 7).pin(Region::Left);
    let card = app.world_mut().spawn((card, Transform::from_xyz(0.0, -0.1, 0.0), ChildOf(parent))).id();
    frame(app, 0.0);
    [tray, parent, card]
}

/// Commands and changes of the game before frame `number`.
fn change(app: &mut App, [tray, parent, _]: [Entity; 3], number: u32) {
    app.world_mut().get_mut::<Transform>(tray).expect("there").translation.y += 0.0005;
    app.world_mut().get_mut::<Transform>(parent).expect("there").translation.x += 0.0004;
    match number {
        10 => {
            _ = app.world_mut().spawn((
                Sheet::new("paper").grid(7, 7),
                Name::new("late"),
                Transform::from_xyz(0.3, 0.2, 0.0),
            ))
        }
        20 => {
            let wind = app.world_mut().resource_mut::<SheetWorld>();
            let air = sheetwork::scene::Air { wind: DVec3::X * 2.0, ..wind.air() };
            wind.into_inner().set_air(air).expect("in range");
        }
        30 | 34 | 40 => {
            let mut names = app
                .world_mut()
                .query_filtered::<(Entity, &Name), (With<Sheet>, Or<(With<Disabled>, Without<Disabled>)>)>();
            let late = names.iter(app.world()).find(|(_, name)| name.as_str() == "late").map(|(entity, _)| entity);
            let mut late = app.world_mut().entity_mut(late.expect("there"));
            match number {
                30 => _ = late.insert(Disabled),
                34 => _ = late.remove::<Disabled>(),
                _ => late.despawn(),
            }
        }
        _ => {}
    }
}

#[test]
fn a_step_on_another_thread_has_the_bits_of_the_main_thread_one_tick_later() {
    let (mut here, mut there) = (app(), threaded());
    let (a, b) = (scene(&mut here), scene(&mut there));
    let state = |app: &App, card| *app.world().get::<SheetState>(card).expect("there");
    let mut before = state(&here, a[2]);
    for number in 0..50 {
        change(&mut here, a, number);
        change(&mut there, b, number);
        frame(&mut here, TICK);
        frame(&mut there, TICK);
        assert_eq!(state(&there, b[2]), before, "frame {number}: one tick later");
        before = state(&here, a[2]);
        if number % 7 == 0 {
            // This waits for the step.
            assert!(world(&here).serialise() == world(&there).serialise(), "frame {number}: other bits");
        }
    }
    assert!(world(&here).serialise() == world(&there).serialise());
    assert!(world(&here).sheets()[0].touching().contains(&true) || world(&here).sheets()[0].max_speed() > 0.0);
}

#[test]
fn a_frame_without_changes_does_not_wait_for_the_step() {
    let mut app = threaded();
    let [_, _, card] = scene(&mut app);
    let falling = app.world_mut().spawn((Sheet::new("card").size(0.1, 0.1), Transform::from_xyz(2.0, 2.0, 0.0))).id();
    run(&mut app, 5.0 * TICK);
    assert!(world(&app).is_stepping(), "nothing has waited");
    let before = app.world().get::<SheetState>(falling).expect("there").centre.y;
    run(&mut app, 5.0 * TICK);
    assert!(app.world().get::<SheetState>(falling).expect("there").centre.y < before);
    // An access waits.
    let time = world(&app).time();
    assert!(!world(&app).is_stepping() && (time - 10.0 * TICK).abs() < 1e-9, "{time}");
    // A despawn during a step.
    frame(&mut app, TICK);
    assert!(world(&app).is_stepping());
    app.world_mut().despawn(card);
    assert_eq!(world(&app).sheets().len(), 1);
    run(&mut app, 0.1);
    assert_eq!(world(&app).sheets().len(), 1);
}

#[test]
fn a_pause_a_rewind_and_a_restart_work_between_steps() {
    let mut app = threaded();
    scene(&mut app);
    run(&mut app, 0.2);
    let saved = world(&app).serialise();
    run(&mut app, 0.2);
    let later = world(&app).serialise();
    app.world_mut().resource_mut::<SheetWorld>().rewind(&saved).expect("of this world");
    run(&mut app, 0.2);
    assert!(world(&app).serialise() == later, "repeated");
    app.world_mut().resource_mut::<SheetClock>().paused = true;
    run(&mut app, 0.1);
    assert!(world(&app).serialise() == later && world(&app).shown_time() == world(&app).time());
    let settings = world(&app).scene().clone();
    app.world_mut().resource_mut::<SheetWorld>().restart(&settings).expect("valid");
    frame(&mut app, 0.0);
    assert_eq!((world(&app).sheets().len(), world(&app).steps()), (1, 0));
}
