//! Every template, started as by the menu: played, edited, undone, reset and saved, with every
//! section and plot open.

use egui_kittest::kittest::Queryable;
use sheetwork_editor::panels::Section;
use sheetwork_editor::session::{Session, Variant};
use sheetwork_editor::templates;

use super::common::{folder, strip, whole};

/// A session at work: with variants, played for a while, with a warm sheet.
fn at_work() -> Session {
    let mut session = strip();
    let variant = |path: &str, value: &str| Variant { path: path.into(), value: value.into() };
    session.compare_with(vec![variant("sheets.0.structure", "slamm"), variant("dt", "0.005")]);
    session.run(0.1);
    session.play();
    session
}

#[test]
fn every_template_can_be_started_played_edited_and_saved() {
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
        assert!(!harness.state().0.playing() && harness.state().0.variants().next().is_none(), "{name}");
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
        let told = harness.state().0.messages();
        assert!(told.len() == 1 && told[0].text.starts_with("saved: ") && !told[0].error, "{name}: {told:?}");
        let again = Session::open(&file).expect("what was saved is read");
        assert_eq!(again.world().sheets().len(), template.scene().sheets.len(), "{name}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
