//! Editing a scene without a window: undo, saving, rollback, grabbing, pinning, moving.

use std::path::{Path, PathBuf};

use bevy_sheetwork::inspector::ParameterAccess;
use glam::DVec3;
use sheetwork::World;
use sheetwork::scene::{BodySpec, HeaterSpec, HotFaceSpec, MaterialChoice, OvenSpec, PinSpec, Region, Scene, Shape};
use sheetwork_editor::samples::heights;
use sheetwork_editor::session::{Item, MAX_VARIANTS, Session, Variant};
use sheetwork_editor::templates::TABLE;

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes")
}

fn wedge() -> Session {
    Session::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron")).expect("valid")
}

/// A clamped strip that hangs in air, with an implicit integrator.
fn strip() -> Session {
    let scene = Scene::parse(
        r#"(name: "strip", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            sheets: [(name: "strip", structure: "shell", grid: (13, 1, 4), size: (0.2, 0.04), material: "hips",
                pins: [(region: Left, clamp: true)], probes: {"tip": (1, 0.5)})],
            bodies: [(name: "block", shape: Box((0.05, 0.02, 0.05)), placement: (position: (0.5, -0.2, 0)))])"#,
    );
    Session::new(&scene.expect("valid")).expect("valid")
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sheetwork-editing-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

#[test]
fn every_parameter_is_undone_and_redone_in_the_world() {
    let mut session = wedge();
    let paths: Vec<_> = session.world().parameters().into_iter().filter(|p| p.kind.name() == "number").collect();
    assert!(paths.len() > 8);
    for parameter in paths {
        let Some((low, high)) = parameter.range else { continue };
        // An optional number may have no value to come back to.
        let Ok(before) = parameter.value.parse::<f64>() else { continue };
        let other =
            if before == low { low + 0.4 * (high - low).min(1.0) } else { 0.5 * (before + low.max(before - 1.0)) };
        let path = parameter.path.as_str();
        assert!(session.set(path, &other.to_string()), "{path}: {:?}", session.messages());
        session.seal();
        let now = |s: &Session| s.parameter(path).expect("still there");
        assert!((now(&session) - other).abs() <= 1e-9 * other.abs().max(1e-9), "{path}");
        assert!(session.undo(), "{path}");
        assert!((now(&session) - before).abs() <= 1e-12 * before.abs(), "{path}: {} {before}", now(&session));
        assert!(session.redo(), "{path}");
        assert!((now(&session) - other).abs() <= 1e-9 * other.abs().max(1e-9), "{path}");
        assert!(session.undo());
    }
    assert!(!session.document().is_unsaved() && session.messages().is_empty());
}

#[test]
fn edits_of_the_scene_are_undone_with_the_world() {
    let mut session = strip();
    session.run(0.3);
    let (time, tip) =
        (session.world().time(), session.world().sheets()[0].probes[0].at(&session.world().sheets()[0].state.x));
    assert!(session.edit("new body", "body", |s| s.bodies.push(BodySpec::new(Shape::Ball(0.01)))));
    assert_eq!((session.world().rigid().expect("own").bodies().len(), session.world().time()), (2, time));
    let there = session.world().sheets()[0].probes[0].at(&session.world().sheets()[0].state.x);
    assert_eq!(there, tip, "the sheet goes on from where it was");
    assert!(session.undo());
    assert_eq!(session.world().rigid().expect("own").bodies().len(), 1);
    assert!(session.edit("grid", "grid", |s| s.sheets[0].grid = (7, 1, 3)));
    assert_eq!(
        (session.world().time(), session.world().sheets()[0].node_count()),
        (0.0, 21),
        "another sheet begins anew"
    );
    assert!(session.undo());
    assert_eq!(session.world().sheets()[0].node_count(), 52);
    assert!(!session.edit("bad", "bad", |s| s.dt = -1.0) && session.messages()[0].text.contains("dt"));
    assert!(!session.edit("bad", "bad", |s| s.sheets[0].material = MaterialChoice::Named("cheese".into())));
    assert_eq!(session.document().redoes(), Some("grid"), "a refusal is no edit");
}

#[test]
fn a_double_click_restores_the_value_of_the_preset_or_the_scene() {
    let mut session = strip();
    assert!(session.set("sheets.strip.material.young", "5e9") && session.set("gravity", "(0, -3, 0)"));
    assert!(session.set_default("sheets.0.material.young") && session.set_default("gravity"));
    assert_eq!((session.world().sheets()[0].material().young, session.world().gravity().y), (2e9, -9.81));
    assert!(session.choose_material(0, "pvc"));
    assert!(session.set("sheets.0.material.thickness", "1e-3") && session.set_default("sheets.0.material.thickness"));
    assert_eq!(session.world().sheets()[0].material().thickness, 4e-4, "of the preset that is chosen now");
}

#[test]
fn a_changed_thickness_changes_the_mass_and_the_run_continues() {
    let mut session = strip();
    session.run(0.2);
    let mass = session.world().sheets()[0].total_mass();
    assert!(session.set("sheets.0.material.thickness", "1e-3"));
    let sheet = &session.world().sheets()[0];
    assert!((sheet.total_mass() / mass - 2.0).abs() < 1e-9 && session.world().time() > 0.19);
}

#[test]
fn every_shipped_scene_is_saved_and_read_back_as_it_is() {
    let folder = folder("save");
    let mut count = 0;
    for entry in std::fs::read_dir(shipped()).expect("the scenes") {
        let file = entry.expect("readable").path();
        if file.extension().is_none_or(|e| e != "ron") {
            continue;
        }
        count += 1;
        let scene = Scene::load(&file).expect("valid");
        let saved = sheetwork_editor::document::files::save(&scene, &folder.join(file.file_name().expect("a name")));
        let saved = saved.unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let again = Scene::load(&folder.join(file.file_name().expect("a name"))).expect("what was written is valid");
        assert_eq!(again, saved, "{}", file.display());
        // The scenes are equal apart from file names, which are relative to another folder.
        let here = sheetwork_editor::document::files::moved(&scene, &folder);
        assert_eq!(Scene { file: None, ..again.clone() }, Scene { file: None, ..here }, "{}", file.display());
        if count % 8 == 0 {
            World::new(&again).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        }
    }
    assert!(count > 30, "{count} scenes");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn saved_work_is_marked_and_opened_again() {
    let folder = folder("again");
    let file = folder.join("mine");
    let mut session = wedge();
    assert!(!session.document().is_unsaved());
    assert!(session.set("sheets.strip.material.young", "300") && session.document().is_unsaved());
    assert!(session.save_as(&file) && !session.document().is_unsaved());
    assert_eq!(session.file(), Some(folder.join("mine.ron").as_path()));
    session.run(0.05);
    let steps = session.world().steps();
    assert!(session.undo() && session.document().is_unsaved(), "undo goes back beyond the save");
    assert_eq!((session.world().steps(), session.timeline().len() > 2), (steps, true), "and leaves the run as it is");
    assert!(session.redo() && session.world().steps() == steps && session.save_as(&file));
    let opened = Session::open(&folder.join("mine.ron")).expect("valid");
    assert_eq!(opened.world().sheets()[0].material().young, 300.0);
    assert!(!session.save_as(Path::new("/proc/no/such/folder/a.ron")));
    assert!(session.messages().iter().any(|m| m.text.contains("not saved")));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn sheets_polyhedra_heaters_and_materials_are_added_from_files() {
    let assets = shipped().join("..");
    let mut session = wedge();
    assert!(session.add_file(&assets.join("sheets/slamm_5x2x5.sht"), 0), "{:?}", session.messages());
    assert!(session.add_file(&assets.join("polyhedra/cube.pol"), 0), "{:?}", session.messages());
    assert!(session.add_file(&assets.join("heaters/panel.heater"), 0), "{:?}", session.messages());
    assert!(session.add_file(&assets.join("materials/index_card.ron"), 0), "{:?}", session.messages());
    let scene = session.scene();
    assert_eq!((scene.sheets.len(), scene.bodies.len(), scene.heaters.len()), (2, 2, 1));
    assert_eq!(session.world().sheets().len(), 2);
    for _ in 0..4 {
        assert!(session.undo());
    }
    assert_eq!(session.world().sheets().len(), 1);
    assert!(!session.add_file(Path::new("notes.txt"), 0) && session.messages()[0].text.contains("notes.txt"));
}

#[test]
fn the_contents_of_a_file_are_placed_on_the_floor_beside_the_sheets() {
    let assets = shipped().join("..");
    let template = TABLE.iter().find(|t| t.name == "Sheet on a box").expect("there is one");
    let mut session = Session::new(&template.scene()).expect("valid");
    assert!(session.add_file(&assets.join("polyhedra/cube.pol"), 0), "{:?}", session.messages());
    let state = session.world().body_state("cube").expect("added");
    // The floor of its file is at -28.1 mm.
    assert!((state.centre().y - 0.0281).abs() < 1e-9, "{}", state.centre());
    assert!(session.add_file(&assets.join("sheets/slamm_5x2x5.sht"), 0), "{:?}", session.messages());
    let lowest = |i: usize| session.world().sheets()[i].state.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest(1) >= 0.0, "{}", lowest(1));
}

#[test]
fn stop_restores_the_state_before_playing() {
    let mut session = wedge();
    session.run(0.1);
    let (time, x) = (session.world().time(), session.world().sheets()[0].state.x.clone());
    assert!(!session.can_stop());
    session.play();
    for _ in 0..10 {
        session.frame(0.02);
    }
    session.pause();
    session.play();
    session.frame(0.02);
    assert!(session.world().time() > time + 0.1 && session.stop());
    assert_eq!((session.world().time(), session.playing(), session.can_stop()), (time, false, false));
    assert_eq!(session.world().sheets()[0].state.x, x);
}

#[test]
fn a_step_back_undoes_a_step_and_the_timeline_restores_any_moment() {
    let mut session = wedge();
    let mut places = vec![session.world().sheets()[0].state.x.clone()];
    for _ in 0..30 {
        session.step();
        places.push(session.world().sheets()[0].state.x.clone());
    }
    for back in (20..30).rev() {
        assert!(session.step_back());
        assert_eq!(session.world().steps(), back as u64);
        assert_eq!(session.world().sheets()[0].state.x, places[back], "an explicit engine keeps nothing else");
    }
    assert!(session.scrub(0.0) && session.world().steps() == 0 && !session.step_back());
    assert!(session.scrub(1e9));
    assert_eq!(session.world().sheets()[0].state.x, places[30], "what came after stays until time passes");
    assert!(session.scrub(0.02));
    let steps = session.world().steps();
    session.step();
    assert_eq!(session.timeline().span().map(|s| s.1), Some(session.world().time()), "the rest is no more");
    assert_eq!(session.world().steps(), steps + 1);
    assert!(session.history().last().is_some_and(|s| s.time <= session.world().time() + 1e-12));
}

#[test]
fn events_stay_on_the_timeline_when_it_is_gone_back_in() {
    let mut session = wedge();
    session.run(0.8);
    let all = session.events().count();
    assert!(all > 0);
    assert!(session.scrub(0.0));
    assert_eq!((session.events().count(), session.timeline().events().len()), (0, all));
    assert!(session.scrub(1e9) && session.events().count() == all);
    session.scrub(0.01);
    session.run(0.8);
    assert_eq!(session.events().count(), all, "the same happens again, once");
}

#[test]
fn numbered_snapshots_are_stored_and_restored() {
    let mut session = wedge();
    session.run(0.1);
    session.store_snapshot(3);
    session.store_snapshot(77);
    session.run(0.1);
    assert!(!session.restore_snapshot(2) && session.restore_snapshot(3));
    assert!((session.world().time() - 0.1).abs() < 1e-9);
    assert_eq!(session.snapshot_times().iter().flatten().count(), 1);
    assert!(session.reset() && session.snapshot_times().iter().flatten().count() == 0);
}

#[test]
fn a_loop_begins_again_after_the_scenes_duration() {
    let mut session = wedge();
    assert!(session.edit("duration", "duration", |s| s.duration = 0.1));
    session.set_looped(true);
    session.play();
    let mut latest: f64 = 0.0;
    for _ in 0..30 {
        session.frame(0.02);
        latest = latest.max(session.world().time());
    }
    assert!(session.playing() && latest < 0.13, "{latest}");
}

#[test]
fn a_grab_pulls_with_the_force_of_its_spring() {
    for mut session in [strip(), wedge()] {
        session.run(0.1);
        assert!(session.grab(0, (1.0, 0.5)));
        let hand = session.hand().expect("holds");
        assert_eq!(hand.force, DVec3::ZERO, "it takes hold where the sheet is");
        let size = session.world().sheets()[0].rest_size().0;
        let target = hand.point + DVec3::new(0.0, 0.5 * size, 0.2 * size);
        session.pull(target);
        let pulled = session.hand().expect("holds");
        let expected = (target - pulled.point) * pulled.stiffness;
        assert!(pulled.force.distance(expected) < 1e-9 * expected.length());
        session.play();
        for _ in 0..60 {
            session.frame(0.02);
        }
        let after = session.hand().expect("holds");
        assert!(after.point.y > hand.point.y + 0.1 * size, "{} {}", after.point, hand.point);
        assert!(session.world().unstable().is_none() && session.messages().is_empty(), "{:?}", session.messages());
        session.release();
        assert!(session.hand().is_none() && session.world().sheets()[0].pulls().is_empty());
    }
}

#[test]
fn a_node_is_pinned_at_its_position_and_unpinned() {
    let mut session = strip();
    session.run(0.5);
    let tip = session.world().sheets()[0].node_count() as u32 - 1;
    let place = |s: &Session| s.world().sheets()[0].state.x.get(tip as usize);
    let (here, start) = (place(&session), DVec3::new(0.1, 0.0, 0.02));
    assert!(here.distance(start) > 0.01, "it has sagged");
    assert!(session.toggle_pin(0, tip));
    session.run(0.3);
    assert!(place(&session).distance(here) < 1e-9, "held where it was pinned: {}", place(&session));
    assert!(session.toggle_pin(0, 5));
    session.run(0.1);
    assert!(place(&session).distance(here) < 1e-9, "and on, when another is pinned");
    assert!(session.undo() && session.undo());
    session.run(0.2);
    assert!(place(&session).distance(here) > 1e-4, "undo lets go");
    assert!(session.redo() && session.reset());
    assert!(place(&session).distance(start) < 1e-9);
    session.run(0.2);
    assert!(place(&session).distance(start) < 1e-9, "from a reset on it is held where it starts");
    // One node of an edge: the others stay pinned.
    let edge = session.world().sheets()[0].model.layers[0].at(0, 1);
    assert!(session.toggle_pin(0, edge));
    assert!(!session.world().sheets()[0].is_held(edge as usize));
    assert!(session.world().sheets()[0].is_held(session.world().sheets()[0].model.layers[0].at(0, 2) as usize));
}

#[test]
fn bodies_and_heaters_are_carried_and_put_down() {
    let mut session = strip();
    session.run(0.1);
    let time = session.world().time();
    let from = session.body_pose(0).expect("a block").0;
    for i in 1..=5 {
        session.move_item(Item::Body(0), DVec3::new(0.0, 0.01 * f64::from(i), 0.0));
    }
    assert!((session.body_pose(0).expect("a block").0 - from).distance(DVec3::new(0.0, 0.05, 0.0)) < 1e-9);
    assert!(session.release_item() && !session.release_item());
    assert!((session.world().rigid().expect("own").pose(0).expect("a block").0.y - from.y - 0.05).abs() < 1e-6);
    assert_eq!(session.world().time(), time, "the sheet goes on");
    assert!(session.undo());
    assert!((session.world().rigid().expect("own").pose(0).expect("a block").0.y - from.y).abs() < 1e-6);

    let hot = vec![HotFaceSpec { face: 2, temperature: 300.0, emissivity: 1.0 }];
    let heater = HeaterSpec { size: Some(DVec3::splat(0.05)), hot, ..HeaterSpec::default() };
    assert!(session.edit("heater", "heater", |s| s.heaters.push(heater)));
    session.move_item(Item::Heater(0), DVec3::new(0.0, 0.1, 0.0));
    assert!(session.release_item());
    assert_eq!(session.scene().heaters[0].placement.position.y, 0.1);
    assert!(session.set("heaters.0.temperature", "500"));
    assert_eq!(session.scene().heaters[0].hot[0].temperature, 500.0);
    assert!(session.undo() && session.parameter("heaters.0.temperature") == Some(300.0));
    assert_eq!(session.items().len(), 2);
    assert!(session.reset());
    assert_eq!(session.items().len(), 3, "the sheet, too, while it lies where it was placed");
    let (sheet, handle) = (Item::Sheet(0), session.handle_of(Item::Sheet(0)).expect("at its start"));
    session.move_item(sheet, DVec3::new(0.0, 0.02, 0.0));
    assert!(session.handle_of(sheet).expect("on its way").distance(handle + DVec3::new(0.0, 0.02, 0.0)) < 1e-12);
    assert!(
        session.release_item() && session.world().sheets()[0].state.x.bounds().expect("masses").0.y > handle.y + 0.01
    );
    assert!(session.undo() && session.handle_of(sheet) == Some(handle));
    session.step();
    assert!(session.items().len() == 2 && session.handle_of(sheet).is_none());
}

#[test]
fn a_body_that_moves_freely_is_put_elsewhere_in_the_run() {
    let template = TABLE.iter().find(|t| t.name == "Ball on a fixed sheet").expect("there is one");
    let mut session = Session::new(&template.scene()).expect("valid");
    let ball = |session: &Session| session.world().body_state("ball").expect("there").centre();
    let start = ball(&session);
    session.run(1.5);
    let rests = ball(&session);
    assert!(rests.y < start.y - 0.02 && session.has_left_start(0));
    session.move_item(Item::Body(0), DVec3::new(0.01, 0.05, 0.0));
    assert!(session.body_pose(0).expect("shown").0.distance(rests + DVec3::new(0.01, 0.05, 0.0)) < 1e-9);
    assert!(session.release_item());
    let (put, time) = (ball(&session), session.world().time());
    assert!(put.distance(rests + DVec3::new(0.01, 0.05, 0.0)) < 1e-9, "where it was let go");
    assert_eq!(session.scene().bodies[0].placement.position, start, "its start stays");
    assert!(!session.document().is_unsaved());
    session.run(0.05);
    assert!(ball(&session).y < put.y - 0.005, "and falls from there");
    assert!(session.undo() && ball(&session).distance(rests) < 1e-9 && session.world().time() <= time);
    assert!(session.redo() && ball(&session).y > rests.y + 0.03);
    assert!(session.reset() && ball(&session) == start);
    // Before the first step the initial position is moved.
    session.move_item(Item::Body(0), DVec3::new(0.0, 0.01, 0.0));
    assert!(session.release_item() && session.scene().bodies[0].placement.position.y > start.y);
}

#[test]
fn messages_of_a_run_end_with_it_and_errors_stay() {
    let mut session = wedge();
    assert!(!session.set("dt", "-1"));
    session.note("written: picture.png");
    assert_eq!(session.messages().len(), 2);
    assert!(session.load(&shipped().join("cube.ron")));
    let left: Vec<bool> = session.messages().iter().map(|m| m.error).collect();
    assert_eq!(left, [true]);
}

#[test]
fn a_sheet_from_a_file_is_put_above_the_body_that_it_would_be_in() {
    let assets = shipped().join("..");
    let mut session =
        Session::new(&Scene::parse("(bodies: [(name: \"block\", shape: Box((0.2, 0.2, 0.2)))])").expect("valid"))
            .expect("valid");
    assert!(session.add_file(&assets.join("sheets/slamm_5x2x5.sht"), 0), "{:?}", session.messages());
    let lowest = session.world().sheets()[0].state.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!((0.1..0.12).contains(&lowest), "{lowest}");
    assert!(session.add_file(&assets.join("polyhedra/cube.pol"), 0), "{:?}", session.messages());
    let [block, cube] = sheetwork_editor::pick::body_boxes(session.world())[..] else { panic!("two bodies") };
    assert!(cube.0.x > block.1.x || (cube.0.cmpgt(block.1) | cube.1.cmplt(block.0)).any(), "{block:?} {cube:?}");
}

#[test]
fn an_oven_is_switched_on_while_it_runs_and_undone() {
    let mut session = strip();
    session.run(0.1);
    assert!(session.edit("oven", "oven", |s| s.oven = Some(OvenSpec { temperature: 150.0, ..OvenSpec::default() })));
    let (time, y) = (session.world().time(), session.world().sheets()[0].state.x.get(51).y);
    assert!(time > 0.09 && session.world().room_temperature() == 150.0);
    assert!(session.set("oven.temperature", "90") && session.world().room_temperature() == 90.0);
    session.seal();
    assert!(session.undo() && session.undo());
    assert_eq!((session.world().room_temperature(), session.world().sheets()[0].state.x.get(51).y), (20.0, y));
}

#[test]
fn pinning_an_edge_restarts_the_run_and_can_be_undone() {
    let mut session = strip();
    session.run(0.1);
    assert!(session.edit("pin", "pin", |s| s.sheets[0].pins.push(PinSpec::fixed(Region::Right))));
    assert_eq!(session.world().time(), 0.0);
    assert!(session.undo() && session.scene().sheets[0].pins.len() == 1);
}

#[test]
fn a_recording_is_not_edited() {
    let folder = folder("recording");
    let file = folder.join("a.swr");
    let session = wedge();
    let mut recorder =
        sheetwork::world::recording::RecordingWriter::create(&file, session.world(), 60.0).expect("writable");
    recorder.frame(session.world()).expect("writable");
    recorder.frame(session.world()).expect("writable");
    recorder.finish().expect("written");
    let mut played = Session::open(&file).expect("a recording");
    assert!(!played.edit("dt", "dt", |s| s.dt = 0.5) && !played.toggle_pin(0, 0) && !played.grab(0, (0.5, 0.5)));
    played.move_item(Item::Body(0), DVec3::ONE);
    assert!(!played.release_item() && played.messages().len() >= 2);
    std::fs::remove_dir_all(folder).expect("removed");
}

fn variant(path: &str, value: &str) -> Variant {
    Variant { path: path.into(), value: value.into() }
}

#[test]
fn variants_go_in_step_and_follow_every_edit_but_their_own() {
    let mut session = strip();
    session.run(0.1);
    session.compare_with(vec![variant("sheets.strip.material.thickness", "1e-3"), variant("dt", "0.004")]);
    let ran = |s: &Session| -> Vec<f64> { (0..3).filter_map(|i| Some(s.shown(i)?.world().time())).collect() };
    assert!(ran(&session).iter().all(|t| (t - 0.1).abs() < 1e-6), "all are where the scene was: {:?}", ran(&session));
    session.play();
    for _ in 0..20 {
        session.frame(0.03);
    }
    let times = ran(&session);
    assert_eq!(times.len(), 3);
    assert!(times[0] > 0.5 && times.iter().all(|t| (t - times[0]).abs() < 1e-6), "{times:?}");
    let tip = |s: &Session| s.history().last().expect("sampled").heights[0];
    let (own, thick) = (tip(&session), tip(session.shown(1).expect("made")));
    assert!(thick > own + 0.001, "twice as thick it hangs less: {thick} {own}");
    assert!(session.set("gravity", "(0, -3, 0)") && session.set("dt", "0.01"));
    let of =
        |s: &Session, i: usize| (s.shown(i).expect("made").world().gravity().y, s.shown(i).expect("made").world().dt());
    assert_eq!((of(&session, 1), of(&session, 2)), ((-3.0, 0.01), (-3.0, 0.004)), "its own field stays");
    assert!(session.undo() && session.undo() && of(&session, 1).0 == -9.81);
    assert!(session.scrub(0.3));
    let times = ran(&session);
    assert!(times.iter().all(|t| (t - times[0]).abs() < 1e-6) && times[0] < 0.4, "back in time too: {times:?}");
    session.step();
    let (now, ahead) = (session.world().time(), session.shown(2).expect("made"));
    let late = ahead.world().time() - now;
    assert!(late > 1e-4 && late < 0.004, "whole steps of its own: {late}");
    assert!((ahead.alpha() - (1.0 - late / 0.004)).abs() < 1e-6, "and it is shown where the scene is");
    let height = ahead.height_at(now).expect("sampled");
    assert!((height - heights(ahead.world()).next().expect("a probe")).abs() > 1e-9, "between two of them");
    assert!(session.reset() && ran(&session) == [0.0; 3]);
    assert_eq!(session.shown_count(), 3);
}

#[test]
fn a_variant_that_differs_in_nothing_is_the_same_to_the_bit_however_long_the_frames_are() {
    let mut session = strip();
    let same = session.scene().sheets[0].structure.name();
    session.compare_with(vec![variant("sheets.0.structure", same)]);
    session.play();
    for k in 0..40 {
        session.frame(0.011 + 0.007 * f64::from(k % 5));
    }
    let bits = |s: &Session| -> Vec<[u64; 3]> {
        s.world().sheets()[0].state.x.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    let twin = session.shown(1).expect("made");
    assert!(session.world().steps() > 40 && session.world().steps() == twin.world().steps());
    assert_eq!(bits(&session), bits(twin));
    // The result of a run at once.
    let mut alone = strip();
    alone.run(session.world().time());
    assert_eq!(bits(&alone), bits(twin));
}

#[test]
fn an_invalid_variant_reports_the_reason_and_at_most_four_worlds_are_shown() {
    let mut session = strip();
    session.compare_with(vec![variant("sheets.0.structure", "cheese"), variant("engine", "rk4")]);
    let found: Vec<bool> = session.variants().map(|b| b.1.is_ok()).collect();
    assert_eq!(found, [false, true]);
    assert!(session.variants().next().is_some_and(|b| b.1.is_err_and(|e| e.contains("shell"))));
    assert!(session.shown(1).is_some_and(|s| s.world().engine().name() == "rk4") && session.shown(2).is_none());
    session.compare_with(vec![variant("dt", "0.01"); 9]);
    assert_eq!(session.variants().count(), MAX_VARIANTS);
    session.run(0.05);
    let steps = session.world().steps();
    assert!(steps > 0);
    session.compare_with(Vec::new());
    assert!(session.shown(1).is_none() && session.world().steps() == steps, "alone, where it was");
}
