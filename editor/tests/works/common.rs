//! The whole editor over a session, driven by mouse and keys.

use std::path::PathBuf;

use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sheetwork::QueryLayer;
use sheetwork::scene::Scene;
use sheetwork_editor::panels::{self, EditorState};
use sheetwork_editor::session::Session;

/// Session and state, which the panels change.
pub type Both = (Session, EditorState);

/// A shell of polystyrene that is clamped at one edge, without other bodies.
pub fn strip() -> Session {
    let scene = Scene::parse(
        r#"(name: "strip", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2), duration: 0.5,
            sheets: [(name: "strip", structure: "shell", grid: (13, 1, 9), size: (0.12, 0.08), material: "hips",
                pins: [(region: Left)], probes: {"tip": (1, 0.5)})],
            bodies: [(name: "ball", shape: Ball(0.01), mass: 0.01, placement: (position: (0.2, 0.05, 0)))],
            camera: (eye: (0.05, 0.3, 0.12), target: (0.01, -0.01, 0)))"#,
    );
    Session::new(&scene.expect("valid")).expect("valid")
}

/// Harness of the editor.
pub fn whole(session: Session) -> Harness<'static, Both> {
    let state = EditorState::new(&session);
    let builder = Harness::builder().with_size(Vec2::new(1300.0, 860.0));
    let mut harness =
        builder.build_ui_state(|ui, (session, state): &mut Both| panels::show(ui, session, state), (session, state));
    harness.run_steps(2);
    harness
}

/// Folder of the test.
pub fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sheetwork-works-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Position of the material point (u, v) of the first sheet in the window.
pub fn seen(harness: &Harness<'_, Both>, uv: (f64, f64)) -> Pos2 {
    let (session, state) = harness.state();
    let place = sheetwork_editor::pick::place(session.world(), 0, uv, QueryLayer::Upper).expect("on the sheet");
    let size = glam::Vec2::new(state.viewport.width(), state.viewport.height());
    let at = state.camera.project(place.as_vec3(), size).expect("in view");
    state.viewport.min + Vec2::new(at.x, at.y)
}

/// Press at a position, move in parts and release.
pub fn drag(harness: &mut Harness<'_, Both>, from: Pos2, to: Pos2) {
    let button = |pos: Pos2, pressed: bool| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    harness.event(Event::PointerMoved(from));
    harness.run_steps(1);
    harness.event(button(from, true));
    harness.run_steps(1);
    for i in 1..=10 {
        harness.event(Event::PointerMoved(from.lerp(to, i as f32 / 10.0)));
        harness.run_steps(1);
    }
    harness.event(button(to, false));
    harness.run_steps(2);
}

/// Type `text` into the number with this label.
pub fn type_number(harness: &mut Harness<'_, Both>, label: &str, text: &str) {
    harness.get_by_role_and_label(Role::SpinButton, label).click();
    harness.run_steps(2);
    type_over(harness, text);
}

/// Replace the contents of the field with the focus by `text`, and press Enter.
pub fn type_over(harness: &mut Harness<'_, Both>, text: &str) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.event(Event::Text(text.to_owned()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}
