//! Files: scenes saved, opened and started from templates, the view exported, dropped files added
//! to the scene.

use std::path::{Path, PathBuf};

use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{self, Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sheetwork::scene::Scene;
use sheetwork_editor::panels::{Section, Tool};
use sheetwork_editor::persistence::Persistence;
use sheetwork_editor::session::{Item, Session};

use super::common::{Both, folder, whole};

fn wedge() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron")
}

fn opened() -> Harness<'static, Both> {
    whole(Session::open(&wedge()).expect("valid"))
}

#[test]
fn a_scene_is_saved_by_the_dialog_and_not_over_another_unasked() {
    let folder = folder("saved");
    let own = folder.join("own.ron");
    std::fs::copy(wedge(), &own).expect("copied");
    let mut harness = whole(Session::open(&own).expect("valid"));
    harness.state_mut().1.persistence = Persistence::new(Some(folder.join("state")));
    assert!(harness.state_mut().0.set("dt", "0.001"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(2);
    assert_eq!(Scene::load(&own).expect("valid").dt, 1e-3, "its own file is not asked about");
    assert!(!harness.state().0.document().is_unsaved());
    std::fs::write(folder.join("other.ron"), "()").expect("a file");
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    harness.run_steps(3);
    harness.get_by_label("other.ron").click();
    harness.run_steps(3);
    harness.get_by_label("Save it").click();
    harness.run_steps(3);
    assert_eq!(std::fs::read_to_string(folder.join("other.ron")).expect("there"), "()", "asked first");
    harness.get_by_label("Write over it").click();
    harness.run_steps(3);
    assert_eq!(Scene::load(&folder.join("other.ron")).expect("valid").dt, 1e-3);
    assert_eq!(harness.state().0.file().and_then(Path::file_name), Some("other.ron".as_ref()));
    assert_eq!(harness.state().1.persistence.recent().len(), 2);
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn the_view_is_exported_as_a_picture() {
    let file = std::env::temp_dir().join(format!("sheetwork-view-{}.png", std::process::id()));
    let _ = std::fs::remove_file(&file);
    let mut harness = opened();
    harness.run_steps(1);
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("Export picture…").click();
    harness.run_steps(3);
    let field = harness.get_by_role_and_label(Role::TextInput, "Name");
    field.focus();
    harness.run_steps(1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(Event::Text(file.display().to_string()));
    harness.run_steps(2);
    harness.get_by_label("Save it").click();
    harness.run_steps(2);
    assert!(harness.state().0.messages().iter().any(|m| !m.error && m.text.contains("written")));
    let bytes = std::fs::read(&file).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 10_000, "{}", bytes.len());
    std::fs::remove_file(&file).expect("removed");
}

#[test]
fn a_template_begins_a_scene_without_a_file() {
    let mut harness = opened();
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("New ⏵").click();
    harness.run_steps(3);
    harness.get_by_label("Clamped strip").click();
    harness.run_steps(3);
    let (session, _) = harness.state();
    assert_eq!((session.scene().name.as_str(), session.file()), ("clamped strip", None));
    assert!(!session.document().is_unsaved(), "there is no work in it");
    assert!(harness.query_by_label_contains("new").is_some());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.run_steps(3);
    assert!(harness.query_by_label("Save it").is_some(), "it is asked for a file");
}

#[test]
fn files_dropped_on_the_window_are_added_to_the_scene() {
    let mut harness = opened();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    for name in ["sheets/slamm_5x2x5.sht", "polyhedra/cube.pol", "heaters/panel.heater", "materials/index_card.ron"] {
        let file = egui::DroppedFile { path: Some(assets.join(name)), ..Default::default() };
        harness.input_mut().dropped_files.push(file);
        harness.run_steps(2);
    }
    let (session, _) = harness.state();
    let told: Vec<(&str, bool)> = session.messages().iter().map(|m| (m.text.as_str(), m.error)).collect();
    assert_eq!(told, [("the material of slamm_5x2x5 is now index_card.ron", false)]);
    let scene = session.scene();
    assert_eq!((scene.sheets.len(), scene.bodies.len(), scene.heaters.len()), (2, 2, 1));
    assert_eq!(scene.sheets[1].material.name(), "index_card", "of the sheet that was added, and so chosen");
    let state = &harness.state().1;
    assert_eq!((state.sheet, state.selected, state.tool), (1, Some(Item::Heater(0)), Tool::Move));
    assert_eq!(state.open_sections, [Section::Material].into(), "of what came last");
    // The handle is at the displayed panel: the file has it far from its origin.
    let handle = session.handle_of(Item::Heater(0)).expect("there");
    assert!(handle.distance(scene.heaters[0].placement.position) > 0.01, "{handle}");
    let size = glam::Vec2::new(state.viewport.width(), state.viewport.height());
    let at = state.camera.project(handle.as_vec3(), size).expect("before the eye");
    assert!(at.cmpge(glam::Vec2::ZERO).all() && at.cmple(size).all(), "{at}");
}

#[test]
fn the_dialog_stays_open_after_an_error_and_remembers_its_folder() {
    let (mut harness, folder) = (opened(), folder("folder"));
    std::fs::copy(wedge(), folder.join("mine.ron")).expect("copied");
    let open = |harness: &mut Harness<'_, Both>, text: &str| {
        harness.event(Event::Text(text.to_owned()));
        harness.run_steps(1);
        harness.key_press(Key::Enter);
        harness.run_steps(3);
    };
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.run_steps(4);
    open(&mut harness, "no_such.ron");
    assert!(harness.state().1.dialog.is_some() && harness.state().0.messages()[0].text.contains("no_such.ron"));
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().1.dialog.is_none());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.run_steps(4);
    open(&mut harness, folder.join("mine.ron").to_str().expect("text"));
    assert!(harness.state().1.dialog.is_none(), "{:?}", harness.state().0.messages());
    let (session, state) = harness.state();
    let there = std::fs::canonicalize(&folder).expect("there");
    assert_eq!(session.file().and_then(Path::parent), Some(folder.as_path()));
    assert_eq!(state.folder.as_deref().map(|f| std::fs::canonicalize(f).expect("there")), Some(there));
    std::fs::remove_dir_all(&folder).expect("removed");
}
