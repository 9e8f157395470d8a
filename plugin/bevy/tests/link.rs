//! Live link of a Bevy game: another thread attaches, reads the sheets and sets a parameter while
//! the game runs.
#![cfg(all(feature = "link", feature = "render"))]

mod common;

use std::time::Duration;

use bevy::app::PluginGroup;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork_link::{Client, Command, LinkPlace};

#[test]
fn another_process_sees_the_sheets_and_turns_their_knobs() {
    let root = std::env::temp_dir().join(format!("sheetwork-plugin-link-{}", std::process::id()));
    let link = SheetLinkPlugin { name: "game".into(), root: Some(root.clone()) };
    let mut app = common::app_with(SheetworkPlugins.build().add(link));
    app.world_mut().spawn(Sheet::new("rubber"));
    let place = LinkPlace::within(&root, "game").expect("a name");
    assert_eq!(app.world().resource::<SheetLink>().name(), Some("game"));
    app.update();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let mut client = Client::attach(&place).expect("attaches");
            client.set_timeout(Duration::from_secs(60));
            let mut frames = client.frames(false).expect("reads");
            let frame = frames.wait(Duration::from_secs(60)).expect("a frame");
            let masses = frame.view().expect("sound").sheets().map(|s| s.positions().len()).sum::<usize>();
            assert!(masses > 0);
            client.set("gravity", "(0, -1.5, 0)").expect("accepted");
            assert!(client.set("gravity", "(0, 1e9, 0)").is_err());
            assert!(client.send(&Command::Load { file: "x.ron".into() }).is_err());
            client.send(&Command::Pause).expect("accepted");
        });
        while !other.is_finished() {
            app.update();
            std::thread::sleep(Duration::from_millis(1));
        }
        other.join().expect("no panic");
    });
    assert_eq!(app.world().resource::<SheetWorld>().gravity().y, -1.5);
    assert!(app.world().resource::<SheetClock>().paused);
    let statistics = app.world().resource::<SheetLink>().statistics().expect("open");
    assert_eq!((statistics.accepted, statistics.refused), (2, 2));
    drop(app);
    let _ = std::fs::remove_dir_all(root);
}

/// A reset restores parameters set by clients, but not those set by the game; the display goes back
/// with the world.
#[test]
fn a_reset_restores_the_parameters_of_the_game() {
    let root = std::env::temp_dir().join(format!("sheetwork-plugin-reset-{}", std::process::id()));
    let link = SheetLinkPlugin { name: "game".into(), root: Some(root.clone()) };
    let mut app = common::app_with(SheetworkPlugins.build().add(link));
    let entity = app.world_mut().spawn(Sheet::new("pet").size(0.2, 0.1).clamp(Region::Left)).id();
    let place = LinkPlace::within(&root, "game").expect("a name");
    common::run(&mut app, 0.5);
    app.world_mut().resource_mut::<SheetWorld>().set("gravity", "(0, -5, 0)").expect("allowed");
    let engine = app.world().resource::<SheetWorld>().engine();
    let dt = app.world().resource::<SheetWorld>().dt();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let mut client = Client::attach(&place).expect("attaches");
            client.set_timeout(Duration::from_secs(60));
            client.set("gravity", "(0, -1.5, 0)").expect("accepted");
            client.set("gravity", "(0, -1, 0)").expect("accepted");
            client.set("engine", "euler").expect("accepted");
            client.send(&Command::Step { steps: 400 }).expect("done");
            assert_eq!(client.status().expect("answers").stopped.len(), 1, "too stiff for it");
            client.send(&Command::Reset).expect("done");
            client.send(&Command::Step { steps: 3 }).expect("done");
            assert!(client.status().expect("answers").stopped.is_empty());
        });
        while !other.is_finished() {
            common::frame(&mut app, 1.0 / 64.0);
        }
        other.join().expect("no panic");
    });
    common::frame(&mut app, 1.0 / 64.0);
    let world = app.world().resource::<SheetWorld>();
    assert_eq!((world.gravity().y, world.engine(), world.dt()), (-5.0, engine, dt));
    assert!((world.time() - 3.0 * dt).abs() < 1e-9 && world.shown_time() <= world.time());
    let motion = app.world().entity(entity).get::<SheetMotion>().expect("in the world");
    let (_, last, s) = motion.around(world.shown_time());
    assert!(*last == world.sheets()[0].state.x && s <= 1.0, "what is drawn is what there is");
    drop(app);
    let _ = std::fs::remove_dir_all(root);
}
