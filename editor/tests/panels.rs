//! The panels in use: chosen, dragged and typed values reach the world, and rejections are
//! reported.

use bevy_sheetwork::inspector::ParameterAccess;
use std::path::Path;

use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{self, Event, Key, Modifiers, MouseWheelUnit, Pos2, TouchPhase, Ui, Vec2};
use bevy_sheetwork::SheetLayer;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use sheetwork::scene::{Air, PinSpec, Region, Scene, SheetSpec};
use sheetwork_editor::panels::{self, EditorState};
use sheetwork_editor::session::Session;

type Both = (Session, EditorState);

fn session() -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron");
    Session::open(&file).expect("the test's scene is valid")
}

fn harness<'a>(session: Session, panel: impl FnMut(&mut Ui, &mut Both) + 'a) -> Harness<'a, Both> {
    let state = EditorState::new(&session);
    Harness::builder().with_size(Vec2::new(1200.0, 760.0)).build_ui_state(panel, (session, state))
}

fn whole() -> Harness<'static, Both> {
    harness(session(), |ui, (session, state)| panels::show(ui, session, state))
}

/// Type `text` into the number with this label, or beside the slider with it.
fn type_number(harness: &mut Harness<'_, Both>, label: &str, text: &str) {
    match harness.query_by_role_and_label(Role::SpinButton, label) {
        Some(number) => number.click(),
        None => {
            let row = harness.get_by_role_and_label(Role::Slider, label).rect();
            let beside = |r: egui::Rect| r.left() > row.left() && (r.center().y - row.center().y).abs() < 3.0;
            let mut numbers = harness.query_all_by_role(Role::SpinButton);
            numbers.find(|n| beside(n.rect())).expect("a number beside the slider").click();
        }
    }
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text(text.to_owned()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
}

#[test]
fn the_bar_plays_pauses_steps_and_resets() {
    let mut harness = harness(session(), |ui, (session, state)| panels::top(ui, session, state));
    harness.get_by_label("▶ Play").click();
    harness.run_steps(2);
    assert!(harness.state().0.playing());
    harness.get_by_label("⏸ Pause").click();
    harness.run_steps(2);
    assert!(!harness.state().0.playing());
    harness.get_by_label("⏭ Step").click();
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().steps(), 1);
    harness.get_by_label("⟲ Reset").click();
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().steps(), 0);
    type_number(&mut harness, "Speed", "2.5");
    assert_eq!(harness.state().0.speed(), 2.5);
}

#[test]
fn a_scene_is_opened_from_the_menu_and_an_invalid_file_is_reported() {
    let mut harness = whole();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron");
    let generation = harness.state().0.generation();
    harness.state_mut().1.scenes = vec![file];
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("Scenes ⏵").click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, "wedge").click();
    harness.run_steps(3);
    assert_ne!(harness.state().0.generation(), generation);
    harness.state_mut().1.path = "no-such-scene.ron".into();
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("Open").click();
    harness.run_steps(3);
    assert!(harness.state().0.messages()[0].text.contains("no-such-scene.ron"));
    harness.get_by_label("✖").click();
    harness.run_steps(3);
    assert!(harness.state().0.messages().is_empty());
}

#[test]
fn a_dropped_file_is_opened() {
    let mut harness = whole();
    let generation = harness.state().0.generation();
    let file = egui::DroppedFile { path: harness.state().0.file().map(Path::to_path_buf), ..Default::default() };
    harness.input_mut().dropped_files.push(file);
    harness.run_steps(2);
    assert_eq!(harness.state().0.generation(), generation + 1);
}

#[test]
fn the_display_panel_chooses_what_is_drawn() {
    let mut harness = harness(session(), |ui, (session, state)| panels::display(ui, session, state));
    for label in ["Springs", "Nodes", "Bottom layer", "Flat", "Room"] {
        harness.get_by_label(label).click();
        harness.run_steps(2);
    }
    let display = harness.state().1.display;
    assert!(display.surface && display.springs && display.nodes && !display.smooth && !display.room);
    assert_eq!(display.layer, SheetLayer::Bottom);
    harness.state_mut().1.camera.zoom(5.0);
    harness.get_by_label("Look at the scene").click();
    harness.run_steps(2);
    let fresh = EditorState::new(&harness.state().0).camera;
    assert_eq!(harness.state().1.camera, fresh);
}

#[test]
fn the_engine_panel_reaches_the_world() {
    let mut harness = harness(session(), |ui, (session, _)| panels::engine(ui, session));
    harness.get_by_role_and_label(Role::ComboBox, "Integrator").click();
    harness.run_steps(3);
    harness.get_by_label("rk45").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.world().engine().name(), "rk45");
    type_number(&mut harness, "Step", "0.5");
    assert!((harness.state().0.world().dt() - 5e-4).abs() < 1e-12);
    type_number(&mut harness, "Tolerance", "2");
    assert!((harness.state().0.parameter("tolerance").expect("a number") - 2e-6).abs() < 1e-15);
    type_number(&mut harness, "y", "-3.5");
    assert_eq!(harness.state().0.world().gravity().y, -3.5);
    harness.get_by_label("Moon").click();
    harness.run_steps(2);
    assert_eq!(harness.state().0.world().gravity().y, -1.62);
    type_number(&mut harness, "Air", "1.3");
    assert_eq!(harness.state().0.world().air().density, 1.3);
    type_number(&mut harness, "Linear damping", "0.9");
    assert_eq!(harness.state().0.world().air().factor, 0.9);
    assert!(harness.state().0.messages().is_empty());
}

#[test]
fn the_sheet_and_material_panels_reach_the_sheet() {
    let mut harness = harness(session(), |ui, (session, state)| {
        panels::sheet(ui, session, state);
        panels::material(ui, session, state);
    });
    for (label, text) in [
        ("Young", "3 k"),
        ("Thickness", "0.2 cm"),
        ("Damping", "0.3"),
        ("Friction", "0.7"),
        ("Restitution", "50 %"),
        ("Pressure", "2 Pa"),
    ] {
        type_number(&mut harness, label, text);
    }
    let sheet = &harness.state().0.world().sheets()[0];
    assert_eq!((sheet.material().young, sheet.material().thickness, sheet.damping()), (3000.0, 0.002, 0.3));
    assert_eq!((sheet.parameters.friction, sheet.parameters.restitution), (0.7, 0.5));
    assert!(harness.query_by_label("Bend limit").is_none(), "a trimm has no flexion");
}

/// A sheet of a real material, clamped at one edge, in air.
fn real_sheet() -> Session {
    let spec = SheetSpec {
        structure: "shell".parse().expect("known"),
        grid: (9, 1, 9),
        size: (0.25, 0.25),
        material: "hips".into(),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::thesis()
    };
    let (engine, dt) = ("tr-bdf2".parse().expect("known"), 1.0 / 60.0);
    let air = Air { density: 1.2, ..Air::default() };
    Session::new(&Scene { engine, dt, air, sheets: vec![spec], ..Scene::default() }).expect("valid")
}

#[test]
fn damping_and_drag_of_a_sheet_are_set_by_its_panel() {
    let mut harness = harness(real_sheet(), |ui, (session, state)| {
        panels::sheet(ui, session, state);
        panels::material(ui, session, state);
    });
    for (label, text) in [("Poisson", "0.2"), ("Damping", "0.3"), ("Drag", "1"), ("… along", "0.1")] {
        type_number(&mut harness, label, text);
    }
    let sheet = &harness.state().0.world().sheets()[0];
    assert_eq!((sheet.material().poisson, sheet.damping_ratio(), sheet.drag()), (0.2, 0.3, (1.0, 0.1)));
    assert!(harness.state().0.messages().is_empty());
}

#[test]
fn another_material_is_chosen_from_the_list() {
    let mut session = real_sheet();
    session.run(0.1);
    let mass = session.world().sheets()[0].total_mass();
    let mut harness = harness(session, |ui, (session, state)| panels::material(ui, session, state));
    harness.get_by_role_and_label(Role::ComboBox, "Material").click();
    harness.run_steps(3);
    harness.get_by_label("steel-foil").click();
    harness.run_steps(3);
    let world = harness.state().0.world();
    assert_eq!((world.time(), world.sheets()[0].material().young), (0.0, 2.05e11));
    assert!((world.sheets()[0].total_mass() / mass - 7850.0 * 1e-4 / (1045.0 * 5e-4)).abs() < 1e-9);
}

#[test]
fn the_numbers_show_the_delivered_stiffness() {
    let mut session = real_sheet();
    session.run(1.0);
    let world = session.world();
    let told = world.sheets()[0].delivered_stiffness(world.dt()).expect("a shell");
    assert!((1.5e9..2.0e9).contains(&told.bends_as_pa), "{told:?}");
    let harness = harness(session, |ui, (session, _)| panels::numbers(ui, session));
    let wanted = format!("delivers {:.2} GPa of 2.00 GPa", told.bends_as_pa / 1e9);
    assert!(harness.query_by_label_contains(&wanted).is_some(), "{wanted}");
}

#[test]
fn the_bend_limit_acts_on_structures_with_flexion_springs() {
    let spec = SheetSpec { structure: "provot2d".parse().expect("known"), grid: (7, 1, 7), ..SheetSpec::thesis() };
    let second = SheetSpec { name: "second".into(), ..spec.clone() };
    let session = Session::new(&Scene { sheets: vec![spec, second], ..Scene::thesis() }).expect("valid");
    let mut harness = harness(session, |ui, (session, state)| panels::sheet(ui, session, state));
    harness.get_by_role_and_label(Role::ComboBox, "Of sheet").click();
    harness.run_steps(3);
    harness.get_by_label("second").click();
    harness.run_steps(3);
    harness.get_by_label("Bend limit").click();
    harness.run_steps(3);
    let limits = |h: &Harness<'_, Both>| -> Vec<Option<f64>> {
        h.state().0.world().sheets().iter().map(|s| s.flexion_angle_limit()).collect()
    };
    assert_eq!(limits(&harness), [None, Some(30.0)]);
    harness.get_by_label("Bend limit").click();
    harness.run_steps(3);
    assert_eq!(limits(&harness), [None, None]);
}

#[test]
fn a_rejected_value_is_reported_with_its_range_and_changes_nothing() {
    let mut harness = harness(session(), |ui, (session, state)| {
        panels::engine(ui, session);
        panels::sheet(ui, session, state);
        panels::messages(ui, session);
    });
    type_number(&mut harness, "Step", "-4");
    type_number(&mut harness, "Friction", "99");
    type_number(&mut harness, "Length", "3 GPa");
    let (session, _) = harness.state();
    assert_eq!((session.world().dt(), session.world().sheets()[0].parameters.friction), (0.002, 0.3));
    assert_eq!(session.messages().len(), 3);
    assert!(harness.query_by_label_contains("dt: -0.004 s is outside").is_some());
    assert!(harness.query_by_label_contains("friction: 99 is outside 0 to 10").is_some());
    assert!(harness.query_by_label_contains("GPa is a unit of pressure").is_some());
    assert!(session.document().undoes().is_none(), "nothing was changed");
}

#[test]
fn the_numbers_are_the_worlds() {
    let mut session = session();
    session.run(0.6);
    let (steps, contacts) = (session.world().steps(), session.contacts());
    assert!(contacts > 0);
    let harness = harness(session, |ui, (session, _)| panels::numbers(ui, session));
    for text in ["0.600 s", "221", "881", &steps.to_string(), &contacts.to_string()] {
        assert!(harness.query_all_by_label(text).next().is_some(), "{text} is not shown");
    }
    assert!(harness.query_all_by_label_contains("strip touches wedge").next().is_some());
}

#[test]
fn keys_do_what_the_help_says() {
    let mut harness = whole();
    let mut press = |key| {
        harness.key_press(key);
        harness.run_steps(2);
        (
            harness.state().0.playing(),
            harness.state().0.world().steps(),
            harness.state().0.speed(),
            harness.state().1.help,
        )
    };
    assert!(press(Key::Space).0);
    let (playing, steps, ..) = press(Key::ArrowRight);
    assert_eq!((playing, steps), (false, 1));
    assert_eq!(press(Key::Plus).2, 2.0);
    assert_eq!(press(Key::Minus).2, 1.0);
    assert_eq!(press(Key::Backspace).1, 0);
    assert!(press(Key::F1).3);
    assert!(!press(Key::Escape).3);
}

#[test]
fn typing_in_a_field_triggers_no_shortcuts() {
    let mut harness = whole();
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_role(Role::TextInput).focus();
    harness.run_steps(2);
    harness.key_press(Key::Backspace);
    harness.key_press(Key::Space);
    harness.event(Event::Text(" a".into()));
    harness.run_steps(2);
    assert!(!harness.state().0.playing());
    assert!(harness.state().1.path.ends_with(" a"));
}

#[test]
fn the_mouse_turns_slides_and_nears_in_the_view_and_not_on_a_panel() {
    let mut harness = whole();
    harness.run_steps(2);
    let middle = harness.state().1.viewport.center();
    let start = harness.state().1.camera;
    drag(&mut harness, middle, egui::PointerButton::Primary);
    let turned = harness.state().1.camera;
    assert!(turned.yaw != start.yaw && turned.target == start.target);
    drag(&mut harness, middle, egui::PointerButton::Secondary);
    let slid = harness.state().1.camera;
    assert!(slid.target != turned.target && slid.yaw == turned.yaw);
    scroll(&mut harness, middle);
    let near = harness.state().1.camera;
    assert!(near.distance < slid.distance);
    let panel = Pos2::new(harness.state().1.viewport.right() + 100.0, middle.y + 200.0);
    drag(&mut harness, panel, egui::PointerButton::Primary);
    scroll(&mut harness, panel);
    assert_eq!(harness.state().1.camera, near);
}

fn drag(harness: &mut Harness<'_, Both>, from: Pos2, button: egui::PointerButton) {
    let press = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
    harness.event(Event::PointerMoved(from));
    harness.run_steps(1);
    harness.event(press(from, true));
    harness.run_steps(1);
    for i in 1..=4 {
        harness.event(Event::PointerMoved(from + Vec2::new(9.0, 6.0) * i as f32));
        harness.run_steps(1);
    }
    harness.event(press(from + Vec2::new(36.0, 24.0), false));
    harness.run_steps(1);
}

fn scroll(harness: &mut Harness<'_, Both>, at: Pos2) {
    harness.event(Event::PointerMoved(at));
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: Vec2::new(0.0, 120.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(4);
}

#[test]
fn every_control_has_a_name() {
    let harness = whole();
    for role in [Role::SpinButton, Role::Slider, Role::CheckBox, Role::RadioButton, Role::Button] {
        for node in harness.query_all_by_role(role) {
            let node = node.accesskit_node();
            let named = node.label().is_some_and(|l| !l.is_empty());
            assert!(named || node.value().is_some(), "{role:?} at {:?} has no name", node.bounding_box());
        }
    }
}
