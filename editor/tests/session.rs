//! The session's clock: play, pause, step, reset, speed, and interpolation between two steps.

use std::path::{Path, PathBuf};

use bevy_sheetwork::inspector::ParameterAccess;
use sheetwork::scene::Scene;
use sheetwork_editor::session::Session;

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron")
}

fn session() -> Session {
    Session::open(&file()).expect("the test's scene is valid")
}

/// Displayed height of a node.
fn shown(session: &Session) -> f64 {
    let (before, after) = (session.before()[0].get(0), session.world().sheets()[0].state.x.get(0));
    before.lerp(after, session.alpha()).y
}

#[test]
fn a_paused_session_does_not_step_and_a_playing_one_takes_whole_steps() {
    let mut session = session();
    session.frame(0.1);
    assert_eq!(session.world().steps(), 0);
    session.play();
    session.frame(0.0061);
    assert_eq!((session.world().steps(), session.timing().steps), (3, 3), "three steps of 2 ms");
    assert!((session.alpha() - 0.05).abs() < 1e-6);
    session.frame(0.0018);
    assert_eq!(session.world().steps(), 3, "less than a step is owed");
    session.frame(0.0002);
    assert_eq!(session.world().steps(), 4);
    session.pause();
    session.frame(1.0);
    assert_eq!(session.world().steps(), 4);
}

#[test]
fn displayed_motion_is_even_at_any_frame_rate() {
    let mut session = session();
    session.play();
    // In free fall the height decreases monotonically, by 1/2 g t² up to a step and the drag.
    let mut last = shown(&session);
    let start = last;
    let mut time = 0.0;
    for frame in [0.0013, 0.0041, 0.0007, 0.0063, 0.0020, 0.0001, 0.0105, 0.0033, 0.0050, 0.0050] {
        session.frame(frame);
        time += frame;
        let now = shown(&session);
        assert!(now <= last, "{now} after {last}");
        last = now;
        let late = 0.002;
        let fallen = |t: f64| 0.5 * 0.981 * t.max(0.0).powi(2);
        let (least, most) = (0.9 * fallen(time - 2.0 * late), fallen(time + late) + 1e-9);
        assert!((least..=most).contains(&(start - now)), "fell {} in {time}", start - now);
    }
}

#[test]
fn a_single_step_pauses_and_shows_its_result() {
    let mut session = session();
    session.play();
    session.step();
    assert!(!session.playing());
    assert_eq!(session.world().steps(), 1);
    assert_eq!(shown(&session), session.world().sheets()[0].state.x.get(0).y);
    let before = shown(&session);
    session.play();
    session.frame(0.0005);
    assert!(shown(&session) <= before, "playing on does not go back");
}

#[test]
fn speed_scales_time_and_changes_in_steps() {
    let mut session = session();
    session.play();
    session.set_speed(4.0);
    session.frame(0.0101);
    assert_eq!(session.world().steps(), 20);
    session.set_speed(f64::NAN);
    assert_eq!(session.speed(), 4.0);
    session.faster();
    assert_eq!(session.speed(), 8.0);
    session.set_speed(3.0);
    session.slower();
    assert_eq!(session.speed(), 2.0);
    for _ in 0..50 {
        session.slower();
    }
    assert!(session.speed() > 0.0);
}

#[test]
fn a_reset_keeps_changes_and_a_reload_does_not() {
    let mut session = session();
    assert!(session.set("sheets.0.material.young", "500"));
    assert!(session.set("gravity", "(0, -2, 0)"));
    session.run(0.2);
    assert!(session.world().time() > 0.19 && session.history().len() > 50);
    assert!(session.reset());
    assert_eq!((session.world().time(), session.world().steps(), session.history().len()), (0.0, 0, 1));
    assert_eq!(session.world().sheets()[0].material().young, 500.0);
    assert_eq!(session.world().gravity().y, -2.0);
    assert_eq!(session.changes().len(), 2);
    session.play();
    assert!(session.reload());
    assert!(session.playing(), "it goes on playing");
    assert_eq!(session.world().gravity().y, -0.981);
    assert!(session.changes().is_empty());
}

#[test]
fn a_rejected_change_or_file_is_reported_once_and_changes_nothing() {
    let mut session = session();
    for _ in 0..3 {
        assert!(!session.set("dt", "-1"));
    }
    assert_eq!(session.messages().len(), 1);
    assert!(session.messages()[0].text.contains("dt") && session.messages()[0].error);
    assert_eq!(session.world().dt(), 0.002);
    let generation = session.generation();
    assert!(!session.load(Path::new("no-such-file.ron")));
    assert_eq!((session.messages().len(), session.generation()), (2, generation));
    session.dismiss(0);
    session.dismiss(7);
    assert!(session.messages()[0].text.contains("no-such-file.ron"));
    assert!(session.load(&file()));
    assert_ne!(session.generation(), generation);
    assert_eq!(session.messages().len(), 1, "messages stay until dismissed");
}

#[test]
fn a_scene_too_slow_for_real_time_loses_time_and_not_the_frame() {
    let mut session = session();
    session.play();
    session.set_speed(1000.0);
    assert!(session.set("dt", "1e-5"));
    let start = std::time::Instant::now();
    // Ten million steps are due.
    session.frame(0.1);
    assert!(start.elapsed().as_secs_f64() < 5.0);
    assert!(session.timing().lost_s > 0.05, "{}", session.timing().lost_s);
    assert!((0.0..=1.0).contains(&session.alpha()));
}

#[test]
fn instability_is_reported() {
    let mut session = session();
    assert!(session.set("engine", "euler"));
    assert!(session.set("sheets.0.material.young", "1e9"));
    session.play();
    for _ in 0..100 {
        session.frame(0.05);
    }
    assert!(session.world().unstable().is_some());
    assert_eq!(session.messages().iter().filter(|m| m.text.contains("unstable")).count(), 1);
    session.reset();
    assert!(session.world().unstable().is_none());
}

#[test]
fn the_largest_step_follows_engine_and_stiffness() {
    let mut session = session();
    assert!(session.set("engine", "verlet"));
    let soft = session.largest_step().expect("verlet has a limit");
    assert!(session.set("sheets.0.material.young", &(4.0 * 185.0).to_string()));
    let stiff = session.largest_step().expect("verlet has a limit");
    assert!((soft / stiff - 2.0).abs() < 0.05, "{soft} {stiff}");
    assert!(session.set("engine", "euler"));
    assert_eq!(session.largest_step(), None, "explicit Euler always grows");
}

#[test]
fn an_implicit_integrator_has_no_stability_limit() {
    let mut session = session();
    assert!(session.set("engine", "tr-bdf2"));
    assert_eq!(session.largest_step(), None);
}

#[test]
fn choosing_a_material_discards_changes_of_the_old_one() {
    let mut session = session();
    assert!(session.set("sheets.0.material.young", "500") && session.set("gravity", "(0, -2, 0)"));
    session.run(0.1);
    assert!(session.choose_material(0, "rubber"));
    let world = session.world();
    assert_eq!((world.time(), world.sheets()[0].material().young, world.gravity().y), (0.0, 3e6, -2.0));
    assert!(!session.choose_material(0, "cheese") && session.messages()[0].text.contains("hips"));
    assert_eq!(session.world().sheets()[0].material().young, 3e6);
    assert!(session.reset());
    assert_eq!(session.world().sheets()[0].material().young, 3e6, "kept");
}

#[test]
fn an_empty_scene_plays() {
    let mut session = Session::new(&Scene::default()).expect("nothing in it to refuse");
    session.play();
    session.frame(0.05);
    assert!(session.world().steps() > 0);
    assert_eq!(session.contacts(), 0);
}

#[test]
fn the_live_link_publishes_the_session_and_its_parameters_survive_a_reset() {
    use sheetwork_link::link_place::LinkPlace;
    use sheetwork_link::{Client, Command};
    let root = std::env::temp_dir().join(format!("sheetwork-editor-link-{}", std::process::id()));
    let place = LinkPlace::within(&root, "editor").expect("a name");
    let mut session = session();
    assert_eq!(session.link().status(), "off");
    session.open_link(&place);
    session.exchange();
    assert!(session.link().is_on() && session.link().status().contains("no process"));
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let mut client = Client::attach(&place).expect("attaches");
            client.set_timeout(std::time::Duration::from_secs(60));
            let _frames = client.frames(false).expect("reads");
            client.set("gravity", "(0, -2, 0)").expect("accepted");
            assert!(client.set("gravity", "(0, 1e9, 0)").is_err());
            client.send(&Command::Step { steps: 3 }).expect("done");
            client.send(&Command::Reset).expect("done");
        });
        let mut named = false;
        while !other.is_finished() {
            session.exchange();
            named |= session.link().status().contains(&format!("({})", std::process::id()));
        }
        assert!(named, "the status says which process is attached");
        other.join().expect("no panic");
    });
    assert_eq!((session.world().steps(), session.world().gravity().y), (0, -2.0));
    assert!(session.messages().is_empty(), "a refusal is told to who asked");
    session.set_link(false);
    assert_eq!(session.link().status(), "off");
    let _ = std::fs::remove_dir_all(root);
}

#[test]
fn a_recording_is_played_sought_and_not_changed() {
    let folder = std::env::temp_dir().join(format!("sheetwork-played-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let recorded = folder.join("wedge.swr");
    let mut simulated = session();
    let mut recorder =
        sheetwork::world::recording::RecordingWriter::create(&recorded, simulated.world(), 60.0).expect("writable");
    recorder.frame(simulated.world()).expect("writable");
    for _ in 0..30 {
        simulated.run(1.0 / 60.0);
        recorder.frame(simulated.world()).expect("writable");
    }
    assert_eq!(recorder.finish().expect("written"), 31);

    let mut played = Session::open(&recorded).expect("a recording");
    let apart = |a: &Session, b: &Session| {
        let (a, b) = (&a.world().sheets()[0].state.x, &b.world().sheets()[0].state.x);
        a.iter().zip(b.iter()).map(|(p, q)| p.distance(q)).fold(0.0, f64::max)
    };
    let length = played.playback().expect("one is shown").duration();
    assert!((length - 0.5).abs() < 1e-9, "{length}");
    played.seek(1e9);
    assert!(apart(&played, &simulated) < 1e-6, "the end is where the simulation was");
    played.reset();
    assert!(played.playback().is_some_and(|r| r.at() == 0.0) && apart(&played, &session()) < 1e-6);
    played.step();
    assert!((played.world().time() - 1.0 / 60.0).abs() < 1e-9, "one frame");
    played.play();
    for _ in 0..40 {
        played.frame(1.0 / 60.0);
    }
    assert!(!played.playing() && apart(&played, &simulated) < 1e-6, "it stops at its end");
    assert!(!played.set("gravity", "(0, 0, 0)") && played.messages()[0].text.contains("recording"));
    played.play();
    assert!(played.playback().is_some_and(|r| r.at() == 0.0), "from its start again");

    let bytes = std::fs::read(&recorded).expect("readable");
    std::fs::write(&recorded, &bytes[..bytes.len() - 5]).expect("writable");
    assert!(!played.load(&recorded), "cut off");
    assert!(played.playback().is_some(), "the old one stays");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_recording_shows_temperatures_with_their_legend_and_holes() {
    use bevy_sheetwork::SheetColour;
    use sheetwork_editor::panels::EditorState;
    let scene = Scene::parse(
        r#"(name: "drawn", dt: 0.005, engine: "tr-bdf2", gravity: (0, 0, 0), oven: (temperature: 150, convection: 100), sheets: [
            (name: "strip", structure: "shell", grid: (9, 1, 5), size: (0.2, 0.1), material: "paper", tearing: true, damping_ratio: 0.5,
            temperature: 20, pins: [(region: Left), (region: Right, path: [(time: 0), (time: 0.4, offset: (0.04, 0, 0))])])])"#,
    )
    .expect("valid");
    let folder = std::env::temp_dir().join(format!("sheetwork-warm-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let recorded = folder.join("drawn.swr");
    let mut simulated = Session::new(&scene).expect("valid");
    let mut recorder =
        sheetwork::world::recording::RecordingWriter::create(&recorded, simulated.world(), 20.0).expect("writable");
    recorder.frame(simulated.world()).expect("writable");
    for _ in 0..8 {
        simulated.run(0.05);
        recorder.frame(simulated.world()).expect("writable");
    }
    recorder.finish().expect("written");
    let (hot, torn) = (&simulated.world().sheets()[0], simulated.world().sheets()[0].open_count());
    assert!(torn > 0 && hot.temperatures().expect("heated")[20] > 40.0);

    let mut played = Session::open(&recorded).expect("a recording");
    let state = EditorState::new(&played);
    let begin = played.world().sheets()[0].opening_revision();
    assert_eq!(played.world().sheets()[0].open_count(), 0);
    played.seek(1e9);
    let shown = &played.world().sheets()[0];
    assert!(shown.open_count() == torn && shown.opening_revision() != begin, "whoever draws it is told");
    assert_eq!(shown.open_cells(), hot.open_cells());
    let pairs = shown.temperatures().expect("shown").iter().zip(hot.temperatures().expect("heated"));
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 0.06);
    let scale = SheetColour::Temperature.scale(simulated.world());
    assert!(scale.is_some() && state.display.scale(played.world()) == scale, "the legend of the simulation");
    // Half way between two frames the temperature is the mean.
    let warmth = |session: &Session| session.world().sheets()[0].temperatures().expect("shown")[20];
    played.seek(0.10);
    let before = warmth(&played);
    played.seek(0.15);
    let after = warmth(&played);
    played.seek(0.125);
    assert!((warmth(&played) - 0.5 * (before + after)).abs() < 1e-3 && after > before + 0.5);
    played.seek(0.0);
    assert_eq!(played.world().sheets()[0].open_count(), 0, "whole again");

    // A flipped bit is reported, and the old recording stays.
    let mut bytes = std::fs::read(&recorded).expect("readable");
    let middle = bytes.len() - 1000;
    bytes[middle] ^= 1;
    std::fs::write(&recorded, bytes).expect("writable");
    assert!(!played.load(&recorded));
    assert!(played.messages().last().is_some_and(|m| m.text.contains("damaged")), "{:?}", played.messages());
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn values_from_outside_may_have_units_and_can_be_undone() {
    let mut session = session();
    let young = |s: &Session| s.world().sheets()[0].material().young;
    let before = young(&session);
    assert!(session.set("sheets.0.material.young", "2.1 kPa") && young(&session) == 2100.0);
    assert!(session.set("sheets.0.material.thickness", "1.5 mm"));
    assert!((session.world().sheets()[0].material().thickness - 1.5e-3).abs() < 1e-15);
    assert!(session.undo() && session.undo() && young(&session) == before);
    assert!(!session.set("sheets.0.material.young", "2.1 mm"));
    assert!(session.messages()[0].text.contains("there are Pa"), "{}", session.messages()[0].text);
}
