//! Time: interpolation at irregular frame times, pause, single steps, speed, the limit of ticks.
#![cfg(feature = "render")]

mod common;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{frame, run, thesis_app};

/// A sheet in free flight along x at 1 m/s.
fn flying(app: &mut App) -> Entity {
    let mut world = app.world_mut().resource_mut::<SheetWorld>();
    world.set_gravity(DVec3::ZERO).expect("in range");
    // Air would slow the sheet.
    world.set("air.density", "0").expect("in range");
    let sheet = app.world_mut().spawn(Sheet::thesis().velocity(Vec3::X)).id();
    frame(app, 0.0);
    sheet
}

/// Displayed x of node 0 in the world, m.
fn drawn(app: &App, sheet: Entity) -> f32 {
    let mesh = app.world().get::<Mesh3d>(sheet).expect("dressed");
    let mesh = app.world().resource::<Assets<Mesh>>().get(&mesh.0).expect("there");
    let first = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions")[0];
    app.world().get::<GlobalTransform>(sheet).expect("there").transform_point(first.into()).x
}

#[test]
fn displayed_motion_is_even_at_irregular_frame_times() {
    // 1/1024 s divides the tick, 15 ms does not, 40 ms is longer than the tick.
    for dt in [1.0 / 1024.0, 0.015, 0.04] {
        let mut app = thesis_app();
        app.world_mut().resource_mut::<SheetWorld>().set_dt(dt).expect("in range");
        let sheet = flying(&mut app);
        run(&mut app, 0.5);
        let frames = [0.016, 0.007, 0.021, 0.0331, 0.004, 0.0167, 0.05, 0.0011, 0.0333];
        let mut last = drawn(&app, sheet);
        for seconds in frames.into_iter().cycle().take(60) {
            frame(&mut app, seconds);
            let now = drawn(&app, sheet);
            assert!((f64::from(now - last) - seconds).abs() < 1e-5, "dt {dt}: {seconds} s moved it by {}", now - last);
            last = now;
        }
    }
}

#[test]
fn the_number_of_steps_does_not_depend_on_frame_rate_and_speed() {
    let run_at = |frame_time: f64, speed: f64| {
        let mut app = thesis_app();
        app.world_mut().resource_mut::<SheetClock>().speed = speed;
        app.world_mut().spawn(SheetBody::ball(0.01));
        app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.001, 0.02, 0.0)));
        let mut at_200 = None;
        while app.world().resource::<SheetWorld>().steps() < 200 {
            frame(&mut app, frame_time);
            let world = app.world().resource::<SheetWorld>();
            if world.steps() == 200 {
                at_200 = world.sheets().first().map(|s| s.state.x.clone());
            }
        }
        at_200
    };
    // One step per tick: 200 steps end exactly at the time.
    let slow = run_at(1.0 / 128.0, 0.064);
    let slower = run_at(1.0 / 50.0, 0.032);
    assert!(slow.is_some());
    assert_eq!(slow, slower);
}

#[test]
fn paused_sheets_stand_still_but_for_single_steps() {
    let mut app = thesis_app();
    let sheet = flying(&mut app);
    run(&mut app, 0.2);
    app.world_mut().resource_mut::<SheetClock>().paused = true;
    frame(&mut app, 0.02);
    let steps = |app: &App| app.world().resource::<SheetWorld>().steps();
    let (taken, shown) = (steps(&app), drawn(&app, sheet));
    for seconds in [0.003, 0.02, 0.0071, 0.03] {
        frame(&mut app, seconds);
        assert_eq!((steps(&app), drawn(&app, sheet)), (taken, shown), "it does not swing with the overstep");
    }
    app.world_mut().resource_mut::<SheetClock>().step_once();
    run(&mut app, 0.1);
    assert_eq!(steps(&app), taken + 1);
    assert!((drawn(&app, sheet) - shown - 0.001).abs() < 1e-5);
    app.world_mut().resource_mut::<SheetClock>().paused = false;
    let mut last = drawn(&app, sheet);
    for _ in 0..20 {
        frame(&mut app, 0.01);
        assert!(drawn(&app, sheet) >= last, "never backwards");
        last = drawn(&app, sheet);
    }
    assert!(last > shown + 0.15);
}

#[test]
fn a_long_frame_is_truncated_and_its_lost_time_reported() {
    let mut app = thesis_app();
    flying(&mut app);
    run(&mut app, 0.1);
    let time = |app: &App| app.world().resource::<SheetWorld>().time();
    let before = time(&app);
    frame(&mut app, 2.0);
    let passed = time(&app) - before;
    assert!((passed - 4.0 / 64.0).abs() < 2e-3, "four ticks: {passed}");
    let lost = app.world().resource::<SheetClock>().time_lost();
    assert!((lost + passed - 2.0).abs() < 0.03, "lost {lost}");
}

#[test]
fn speed_makes_time_go_faster() {
    let mut app = thesis_app();
    flying(&mut app);
    app.world_mut().resource_mut::<SheetClock>().speed = 3.0;
    run(&mut app, 0.5);
    let time = app.world().resource::<SheetWorld>().time();
    assert!((time - 1.5).abs() < 0.06, "{time}");
}

#[test]
fn diagnostics_are_measured() {
    use bevy::diagnostic::DiagnosticsStore;
    type Paths = SheetworkDiagnosticsPlugin;
    let mut app = thesis_app();
    app.world_mut().spawn(SheetBody::floor());
    app.world_mut().spawn(Sheet::thesis());
    run(&mut app, 0.5);
    let store = app.world().resource::<DiagnosticsStore>();
    let value = |path| store.get(&path).and_then(|d| d.value());
    assert_eq!(value(Paths::NODES), Some(221.0));
    assert!(value(Paths::STEP_TIME).is_some_and(|ms| ms > 0.0 && ms < 1000.0));
    assert!(value(Paths::CONTACTS).is_some_and(|n| n > 0.0));
    assert!(value(Paths::ENERGY).is_some_and(f64::is_finite));
    assert_eq!(value(Paths::TIME_LOST), Some(0.0));
}
