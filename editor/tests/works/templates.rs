//! Every template, begun as the menu begins it: played, edited, undone, reset and saved, with every section and plot open; and drawn.

use bevy_egui::egui::{Event, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use sheetwork_editor::panels::{EditorState, Section};
use sheetwork_editor::session::{Session, Variant};
use sheetwork_editor::shell::offscreen::Offscreen;
use sheetwork_editor::shell::probe;
use sheetwork_editor::templates;

use super::common::{folder, strip, whole};

/// A session that is at work: with variants, played for a while, its sheet warm.
fn at_work() -> Session {
    let mut session = strip();
    let variant = |path: &str, value: &str| Variant { path: path.into(), value: value.into() };
    session.compare_with(vec![variant("sheets.0.structure", "slamm"), variant("dt", "0.005")]);
    session.run(0.1);
    session.play();
    session
}

#[test]
fn every_template_of_the_menu_is_begun_played_edited_and_saved() {
    let (folder, mut harness) = (folder("templates"), whole(at_work()));
    harness.state_mut().1.open_sections = Section::ALL.iter().map(|s| s.0).collect();
    harness.state_mut().1.plots.shown = true;
    harness.state_mut().1.plots.stages = true;
    harness.run_steps(3);
    for template in templates::TABLE {
        let name = template.name;
        harness.get_by_label("File").click();
        harness.run_steps(3);
        harness.get_by_label("New ⏵").click();
        harness.run_steps(3);
        harness.get_by_label(name).click();
        harness.run_steps(3);
        assert_eq!(harness.state().0.scene(), &template.scene(), "{name}");
        assert!(!harness.state().0.playing() && harness.state().0.beside().next().is_none(), "{name}");
        harness.state_mut().0.play();
        for _ in 0..6 {
            harness.state_mut().0.frame(1.0 / 30.0);
            harness.run_steps(1);
        }
        assert!(harness.state().0.world().time() > 0.05, "{name}");
        assert!(harness.state_mut().0.set("gravity", "(0, -3, 0)") && harness.state_mut().0.undo(), "{name}");
        assert!(harness.state_mut().0.reset());
        harness.run_steps(2);
        assert_eq!(harness.state().0.world().steps(), 0, "{name}");
        let file = folder.join(format!("{name}.ron"));
        let (session, state) = harness.state_mut();
        assert!(state.save_as(session, &file), "{name}");
        harness.run_steps(2);
        assert!(harness.state().0.messages().is_empty(), "{name}: {:?}", harness.state().0.messages());
        let again = Session::open(&file).expect("what was saved is read");
        assert_eq!(again.world().sheets().len(), template.scene().sheets.len(), "{name}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

/// Clicks where the panels are, in the app that also draws the scene.
fn click(editor: &mut Offscreen, pos: Pos2) {
    editor.event(Event::PointerMoved(pos));
    editor.frame();
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        editor.event(Event::PointerButton { pos, button, pressed, modifiers });
        editor.frame();
    }
    // A menu takes some frames to lie where it stays.
    (0..4).for_each(|_| editor.frame());
}

#[test]
fn a_template_that_is_begun_while_another_world_is_drawn_does_not_end_the_editor() {
    if let Err(reason) = probe::adapter() {
        println!("skipped: {reason}");
        return;
    }
    let session = at_work();
    let mut state = EditorState::new(&session);
    (state.display.masses, state.display.springs, state.display.normals) = (true, true, true);
    let mut editor = Offscreen::editor(session, state, (1100, 700));
    (0..4).for_each(|_| editor.frame());
    for (row, template) in templates::TABLE.iter().enumerate().chain(templates::TABLE.iter().enumerate().take(2)) {
        // File, New, and its row: places of the menu as it lies in a window of this size.
        for at in [Pos2::new(22.0, 16.0), Pos2::new(50.0, 45.0), Pos2::new(376.0, 43.5 + 26.0 * row as f32)] {
            click(&mut editor, at);
        }
        let (session, _) = editor.parts();
        assert_eq!(session.scene().name, template.scene().name);
        session.frame(0.05);
        editor.frame();
    }
    editor.picture().expect("a picture");
}
