//! The editor in use: undo by keys, tools of the view, timeline, plots, generation of a sheet.

use std::path::{Path, PathBuf};

use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sheetwork_editor::panels::{self, EditorState, Section, Tool};
use sheetwork_editor::session::{Item, Session};

type Both = (Session, EditorState);

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron")
}

fn whole_of(session: Session) -> Harness<'static, Both> {
    let state = EditorState::new(&session);
    let show = |ui: &mut egui::Ui, (session, state): &mut Both| panels::show(ui, session, state);
    Harness::builder().with_size(Vec2::new(1300.0, 900.0)).build_ui_state(show, (session, state))
}

fn whole() -> Harness<'static, Both> {
    whole_of(Session::open(&file()).expect("valid"))
}

fn type_number(harness: &mut Harness<'_, Both>, label: &str, text: &str) {
    harness.get_by_role_and_label(Role::SpinButton, label).click();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text(text.to_owned()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
}

#[test]
fn typed_letters_within_one_frame_are_not_shortcuts() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Engine].into();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::SpinButton, "Step").click();
    harness.run_steps(2);
    assert!(harness.ctx.text_edit_focused());
    // As in a slow frame: keys, their text and the end of the edit together.
    for key in [Key::P, Key::Space, Key::C] {
        harness.event(Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE });
    }
    harness.event(Event::Text("p c".into()));
    harness.key_press(Key::Enter);
    harness.run_steps(1);
    assert!(!harness.ctx.text_edit_focused(), "left");
    assert!(harness.state().1.tool == Tool::Look && !harness.state().0.playing());
    harness.run_steps(2);
    harness.key_press(Key::P);
    harness.run_steps(2);
    assert!(harness.state().1.tool == Tool::Pin, "and then they are again");
}

fn button(harness: &mut Harness<'_, Both>, pos: Pos2, pressed: bool) {
    harness.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE });
    harness.run_steps(1);
}

fn click(harness: &mut Harness<'_, Both>, at: Pos2) {
    harness.event(Event::PointerMoved(at));
    harness.run_steps(1);
    button(harness, at, true);
    button(harness, at, false);
    harness.run_steps(2);
}

/// Press at a position and move in parts, without release.
fn drag(harness: &mut Harness<'_, Both>, from: Pos2, to: Pos2) {
    harness.event(Event::PointerMoved(from));
    harness.run_steps(1);
    button(harness, from, true);
    for i in 1..=5 {
        harness.event(Event::PointerMoved(from.lerp(to, i as f32 / 5.0)));
        harness.run_steps(1);
    }
}

/// Position of a point of the scene in the window.
fn seen(harness: &Harness<'_, Both>, point: glam::DVec3) -> Pos2 {
    let state = &harness.state().1;
    let size = glam::Vec2::new(state.viewport.width(), state.viewport.height());
    let at = state.camera.project(point.as_vec3(), size).expect("in view");
    state.viewport.min + Vec2::new(at.x, at.y)
}

#[test]
fn a_typed_value_is_undone_and_redone_by_keys() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Engine].into();
    harness.run_steps(2);
    type_number(&mut harness, "Step", "1 ms");
    assert_eq!(harness.state().0.world().dt(), 1e-3);
    assert!(harness.query_by_label_contains("not saved").is_some(), "the mark of unsaved work");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().dt(), 0.002);
    assert!(harness.query_by_label_contains("not saved").is_none());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().dt(), 1e-3);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    harness.get_by_label("Edit").click();
    harness.run_steps(3);
    harness.get_by_label_contains("Redo change of dt").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().dt(), 1e-3);
}

#[test]
fn a_double_click_on_a_number_resets_it() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Engine].into();
    harness.run_steps(2);
    type_number(&mut harness, "Step", "0.5");
    assert_eq!(harness.state().0.world().dt(), 5e-4);
    let at = harness.get_by_role_and_label(Role::SpinButton, "Step").rect().center();
    harness.event(Event::PointerMoved(at));
    harness.run_steps(1);
    // All within one frame: a frame of the test clock lasts a quarter of a second.
    for pressed in [true, false, true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        harness.input_mut().events.push(Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    harness.run_steps(4);
    assert_eq!(harness.state().0.world().dt(), 0.002);
    // It stays so when the field loses the focus.
    click(&mut harness, Pos2::new(600.0, 400.0));
    assert_eq!(harness.state().0.world().dt(), 0.002);
}

#[test]
fn a_dragged_slider_is_one_undo_step() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Sheet].into();
    harness.run_steps(2);
    let slider = harness.get_by_role_and_label(Role::Slider, "Friction").rect();
    let before = harness.state().0.world().sheets()[0].parameters.friction;
    drag(&mut harness, slider.left_center() + Vec2::new(40.0, 0.0), slider.left_center() + Vec2::new(80.0, 0.0));
    button(&mut harness, slider.left_center() + Vec2::new(80.0, 0.0), false);
    harness.run_steps(2);
    assert!(harness.state().0.world().sheets()[0].parameters.friction > before);
    assert!(harness.state_mut().0.undo() && !harness.state_mut().0.undo());
    assert_eq!(harness.state().0.world().sheets()[0].parameters.friction, before);
}

#[test]
fn a_grid_is_typed_and_a_bad_one_refused() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Sheet].into();
    harness.run_steps(2);
    type_number(&mut harness, "nx", "7");
    assert_eq!(harness.state().0.world().sheets()[0].model.grid, (7, 2, 11));
    type_number(&mut harness, "nz", "none");
    assert!(harness.state().0.messages()[0].text.contains("does not begin with a number"));
    harness.get_by_role_and_label(Role::ComboBox, "Structure").click();
    harness.run_steps(3);
    harness.get_by_label("shell").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().sheets()[0].model.grid, (7, 1, 11), "a shell has one layer");
    harness.get_by_label("left").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.scene().sheets[0].pins.len(), 1);
}

#[test]
fn several_steps_back_in_one_frame_are_several() {
    let mut harness = whole();
    (0..10).for_each(|_| harness.state_mut().0.step());
    for _ in 0..3 {
        harness.event(Event::Key {
            key: Key::ArrowLeft,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: Modifiers::NONE,
        });
    }
    harness.run_steps(1);
    assert_eq!(harness.state().0.world().steps(), 7);
}

#[test]
fn mouse_modes_rotate_pan_and_zoom_the_view_or_leave_it() {
    let mut harness = whole();
    let corner = harness.state().1.viewport.left_bottom() + Vec2::new(40.0, -40.0);
    let mut moved = |tool: Tool| {
        harness.state_mut().1.tool = tool;
        harness.run_steps(1);
        let before = harness.state().1.camera;
        drag(&mut harness, corner, corner + Vec2::new(60.0, 0.0));
        button(&mut harness, corner + Vec2::new(60.0, 0.0), false);
        let after = harness.state().1.camera;
        (after.yaw != before.yaw, after.target != before.target, after.distance - before.distance)
    };
    assert_eq!(moved(Tool::Look), (true, false, 0.0));
    assert_eq!(moved(Tool::Pan), (false, true, 0.0));
    let (turned, panned, further) = moved(Tool::Zoom);
    assert!(!turned && !panned && further < 0.0, "a drag to the right zooms in: {further}");
    assert_eq!(moved(Tool::None), (false, false, 0.0));
}

#[test]
fn the_grab_tool_pulls_at_the_sheet_and_elsewhere_turns_the_view() {
    let mut harness = whole();
    harness.key_press(Key::G);
    harness.run_steps(2);
    assert_eq!(harness.state().1.tool, Tool::Grab);
    let sheet = &harness.state().0.world().sheets()[0];
    let middle = seen(&harness, sheet.centre_of_mass());
    drag(&mut harness, middle, middle + Vec2::new(0.0, -80.0));
    let hand = harness.state().0.hand().expect("it holds the sheet");
    assert!(hand.target.y > hand.point.y && hand.force.y > 0.0, "{hand:?}");
    harness.state_mut().0.play();
    let start = hand.point;
    for _ in 0..30 {
        harness.state_mut().0.frame(0.02);
        harness.run_steps(1);
    }
    assert!(harness.state().0.hand().is_some_and(|h| h.point.y > start.y), "it follows");
    button(&mut harness, middle + Vec2::new(0.0, -80.0), false);
    harness.run_steps(2);
    assert!(harness.state().0.hand().is_none(), "let go");
    let camera = harness.state().1.camera;
    let corner = harness.state().1.viewport.left_bottom() + Vec2::new(40.0, -40.0);
    drag(&mut harness, corner, corner + Vec2::new(60.0, 0.0));
    button(&mut harness, corner + Vec2::new(60.0, 0.0), false);
    assert_ne!(harness.state().1.camera.yaw, camera.yaw);
}

#[test]
fn the_pin_tool_pins_and_unpins_a_node() {
    let mut harness = whole();
    harness.key_press(Key::P);
    harness.run_steps(2);
    let sheet = &harness.state().0.world().sheets()[0];
    let top = sheet.model.layers.last().expect("layers").at(3, 4);
    let at = seen(&harness, sheet.state.x.get(top as usize));
    click(&mut harness, at);
    assert!(harness.state().0.world().sheets()[0].is_held(top as usize));
    click(&mut harness, at);
    assert!(!harness.state().0.world().sheets()[0].is_held(top as usize));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert!(harness.state().0.world().sheets()[0].is_held(top as usize));
}

#[test]
fn the_move_tool_moves_a_body_along_an_axis() {
    let mut harness = whole();
    harness.key_press(Key::W);
    harness.run_steps(2);
    let place = harness.state().0.handle_of(Item::Body(0)).expect("the wedge");
    let middle = seen(&harness, place);
    click(&mut harness, middle);
    assert_eq!(harness.state().1.selected, Some(Item::Body(0)));
    let size = glam::Vec2::new(harness.state().1.viewport.width(), harness.state().1.viewport.height());
    let gizmo = sheetwork_editor::gizmo::Gizmo::new(place.as_vec3(), &harness.state().1.camera, size).expect("in view");
    let along = gizmo.ends[0] - gizmo.middle;
    let at = |part: f32| middle + Vec2::new(along.x, along.y) * part;
    drag(&mut harness, at(0.8), at(2.0));
    let (moved_item, by) = harness.state().0.moved_item().expect("on its way");
    assert!(moved_item == Item::Body(0) && by.x > 0.0 && by.y == 0.0 && by.z == 0.0, "{by}");
    button(&mut harness, at(2.0), false);
    harness.run_steps(2);
    let (session, _) = harness.state();
    assert!((session.scene().bodies[0].placement.position.x - by.x).abs() < 1e-9 && session.moved_item().is_none());
    assert!((session.body_pose(0).expect("the wedge").0.x - by.x).abs() < 1e-6);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert_eq!(harness.state().0.scene().bodies[0].placement.position.x, 0.0);
}

#[test]
fn keys_stop_step_back_and_keep_moments() {
    let mut harness = whole();
    for _ in 0..3 {
        harness.key_press(Key::ArrowRight);
        harness.run_steps(1);
    }
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num4);
    harness.run_steps(2);
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().steps(), 2);
    harness.key_press(Key::Num4);
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().steps(), 3);
    harness.key_press(Key::Space);
    harness.run_steps(1);
    harness.state_mut().0.frame(0.05);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Space);
    harness.run_steps(2);
    assert_eq!((harness.state().0.world().steps(), harness.state().0.playing()), (3, false));
}

#[test]
fn the_timeline_is_dragged_and_shows_snapshots() {
    let mut session = Session::open(&file()).expect("valid");
    session.run(1.0);
    let mut harness = whole_of(session);
    harness.run_steps(2);
    let viewport = harness.state().1.viewport;
    let strip = Pos2::new(viewport.left() + 0.4 * viewport.width(), viewport.bottom() + 14.0);
    drag(&mut harness, strip, strip + Vec2::new(5.0, 0.0));
    button(&mut harness, strip + Vec2::new(5.0, 0.0), false);
    let time = harness.state().0.world().time();
    assert!((0.2..0.6).contains(&time), "{time}");
    harness.get_by_label("7").click();
    harness.run_steps(2);
    assert!(harness.state().0.snapshot_times()[6].is_some_and(|t| (t - time).abs() < 1e-9));
}

#[test]
fn plots_are_shown_and_exported() {
    let mut session = Session::open(&file()).expect("valid");
    session.run(0.3);
    let mut harness = whole_of(session);
    harness.get_by_label("Plots").click();
    harness.run_steps(3);
    assert!(harness.state().1.plots.shown && harness.query_by_label("Step time").is_some());
    harness.get_by_label("Export CSV…").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("Export samples").is_some());
    let csv = harness.state().0.csv();
    assert!(csv.starts_with("time_s,kinetic_j") && csv.lines().count() > 100);
}

#[test]
fn a_generated_sheet_shows_its_counts_and_is_added() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Sheet].into();
    harness.run_steps(2);
    harness.get_by_label("Generate…").click();
    harness.run_steps(3);
    type_number(&mut harness, "Along the length", "8");
    type_number(&mut harness, "Along the width", "8");
    assert!(harness.query_by_label_contains("113 nodes, 428 springs").is_some(), "the thesis's counts of 8x2x8");
    harness.get_by_label("Add to the scene").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().sheets().len(), 2);
    assert!(harness.state().1.generate.is_none());
}

#[test]
fn heat_is_set_by_its_panel() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Heat].into();
    harness.run_steps(2);
    harness.get_by_label("Oven").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().room_temperature(), 140.0);
    harness.get_by_label("Add heater").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.scene().heaters.len(), 1);
    assert_eq!(harness.state().1.selected, Some(Item::Heater(0)), "and is chosen");
    harness.get_by_label("Oven").click();
    harness.run_steps(3);
    type_number(&mut harness, "at", "700 K");
    let hot = harness.state().0.scene().heaters[0].hot[0];
    assert!((hot.temperature - 426.85).abs() < 1e-9, "{hot:?}");
    harness.get_by_label("+x").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.scene().heaters[0].hot.len(), 2);
    harness.get_by_label("Take a heat gun").click();
    harness.run_steps(3);
    harness.get_by_label("Blows").click();
    harness.run_steps(3);
    assert!(harness.state().0.scene().heat_gun.as_ref().is_some_and(|g| !g.on));
    assert!(harness.state().0.messages().is_empty(), "{:?}", harness.state().0.messages());
    while harness.state_mut().0.undo() {}
    assert!(harness.state().0.scene().oven.is_none() && harness.state().0.scene().heaters.is_empty());
}

#[test]
fn the_camera_panel_shows_sides_and_keeps_a_view() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Camera].into();
    harness.run_steps(2);
    harness.get_by_label("top").click();
    harness.run_steps(2);
    assert!((harness.state().1.camera.pitch - 1.55).abs() < 1e-6);
    harness.get_by_label("Keep in scene").click();
    harness.run_steps(2);
    assert!(harness.state().0.scene().camera.is_some());
    type_number(&mut harness, "Distance", "20 cm");
    assert!((harness.state().1.camera.distance - 0.2).abs() < 1e-6);
}

#[test]
fn variants_are_added_in_the_panel_and_shown_in_numbers() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Compare].into();
    harness.run_steps(2);
    harness.get_by_label("Add a variant").click();
    harness.run_steps(3);
    assert!(
        harness.state().0.shown(1).is_some_and(|s| s.world().sheets()[0].model.structure.name() == "shell"),
        "{:?}",
        harness.state().0.variants().next().map(|b| b.1.err())
    );
    harness.get_by_label("Add a variant").click();
    harness.run_steps(3);
    let structure = |which: usize| harness.state().0.shown(which).map(|s| s.world().sheets()[0].model.structure);
    let all: std::collections::BTreeSet<_> = (0..3).filter_map(|which| Some(structure(which)?.name())).collect();
    assert_eq!(all.len(), 3, "what is added differs from what is there: {all:?}");
    harness.state_mut().0.step();
    harness.state_mut().1.plots.shown = true;
    harness.run_steps(2);
    (0..60).for_each(|_| harness.state_mut().0.step());
    harness.run_steps(2);
    let height = |h: &Harness<'_, Both>| panels::format_si(h.state().0.world().sheets()[0].centre_of_mass().y, "m");
    let late = height(&harness);
    assert!(harness.query_all_by_label(&late).count() > 0, "{late}");
    harness.state_mut().0.scrub(0.0);
    harness.run_steps(2);
    assert!(
        height(&harness) != late && harness.query_all_by_label(&height(&harness)).count() > 0,
        "of the moment shown"
    );
    harness.get_by_label("Stop comparing").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.variants().count(), 0);
}

#[test]
fn no_section_pushes_the_view_aside() {
    let mut harness = whole();
    harness.run_steps(2);
    let viewport = harness.state().1.viewport;
    for (section, title) in Section::ALL {
        harness.state_mut().1.open_sections = [section].into();
        harness.run_steps(3);
        assert_eq!(harness.state().1.viewport, viewport, "{title}");
    }
}

#[test]
fn light_and_dark_and_every_section_are_drawn() {
    let mut harness = whole();
    harness.state_mut().1.light = true;
    harness.state_mut().1.open_sections = Section::ALL.iter().map(|s| s.0).collect();
    harness.run_steps(3);
    assert_eq!(harness.ctx.theme(), egui::Theme::Light);
    for (_, title) in Section::ALL {
        assert!(harness.query_all_by_label(title).count() >= 2, "{title}: its switch and its header");
    }
    harness.state_mut().1.light = false;
    harness.run_steps(2);
    assert_eq!(harness.ctx.theme(), egui::Theme::Dark);
}

#[test]
fn a_slider_that_needs_a_new_world_is_applied_on_release() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Material].into();
    harness.run_steps(2);
    let slider = harness.get_by_role_and_label(Role::Slider, "Thickness").rect();
    let (before, generation) = (harness.state().0.world().sheets()[0].total_mass(), harness.state().0.generation());
    let to = slider.left_center() + Vec2::new(20.0, 0.0);
    drag(&mut harness, slider.left_center() + Vec2::new(70.0, 0.0), to);
    assert_eq!(harness.state().0.generation(), generation, "not on its way");
    button(&mut harness, to, false);
    harness.run_steps(3);
    let thickness = harness.state().0.world().sheets()[0].material().thickness;
    assert!(thickness < 1e-3 && harness.state().0.generation() == generation + 1, "{thickness}");
    assert_eq!(harness.state().0.world().sheets()[0].total_mass(), before, "the scene gives each mass its own");
    assert!(harness.state_mut().0.undo() && !harness.state_mut().0.undo());
}

#[test]
fn a_section_is_detached_and_returned_and_the_sides_are_swapped() {
    let mut harness = whole();
    harness.state_mut().1.open_sections = [Section::Engine].into();
    harness.run_steps(3);
    let viewport = harness.state().1.viewport;
    // Its switch, its header, and the label below.
    let mut named: Vec<_> = harness.query_all_by_label("Integrator").map(|n| n.rect()).collect();
    named.sort_by(|a, b| a.top().total_cmp(&b.top()));
    let title = named[1];
    let (from, to) = (title.left_center() + Vec2::new(60.0, 0.0), viewport.center());
    drag(&mut harness, from, to);
    button(&mut harness, to, false);
    harness.run_steps(3);
    assert_eq!(harness.state().1.floating, [Section::Engine].into());
    assert_eq!(harness.state().1.viewport, viewport, "it lies over the view");
    // Its controls reach the world from the window.
    harness.get_by_label("Moon").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().gravity().y, -1.62);
    harness.state_mut().1.floating.clear();
    harness.run_steps(3);
    harness.get_by_label("Take Integrator out of the column").click();
    harness.run_steps(3);
    assert!(harness.state().1.floating.contains(&Section::Engine));
    harness.get_by_label("Close window").click();
    harness.run_steps(3);
    assert!(harness.state().1.floating.is_empty() && harness.query_by_label("Moon").is_some());
    harness.state_mut().1.swapped = true;
    harness.run_steps(3);
    assert!(harness.get_by_label("Moon").rect().right() < harness.state().1.viewport.left());
}
