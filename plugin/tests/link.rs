//! The live link of a Bevy game: another thread attaches, sees the sheets and turns a knob while the game runs.
#![cfg(feature = "link")]

mod common;

use std::time::Duration;

use bevy::app::PluginGroup;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::link::{Client, Command, LinkPlace};

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
            client.set_patience(Duration::from_secs(60));
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
