//! The profiler measures on request, variants that fail are marked, and differences are plotted.

use egui_kittest::kittest::Queryable;
use sheetwork::scene::Scene;
use sheetwork_editor::session::{Session, Variant};

use super::common::{strip, whole};

/// A heated sheet on a box.
fn on_a_box() -> Session {
    let scene = Scene::parse(
        r#"(name: "on a box", engine: "tr-bdf2", dt: 0.0166666666666667, air: (density: 1.2),
            sheets: [(name: "card", structure: "shell", grid: (9, 1, 9), size: (0.1, 0.1), material: "paper", temperature: 60,
                placement: (position: (0.02, 0.0452, 0.01)))],
            bodies: [(name: "box", shape: Box((0.08, 0.08, 0.08)))])"#,
    );
    Session::new(&scene.expect("valid")).expect("valid")
}

#[test]
fn stages_are_timed_while_their_plot_is_shown_and_results_do_not_change() {
    let mut harness = whole(on_a_box());
    harness.state_mut().0.run(0.2);
    assert!(harness.state().0.history().iter().all(|s| s.stages.is_none()), "nobody asked");
    harness.state_mut().1.plots.shown = true;
    harness.run_steps(2);
    harness.get_by_label("Stages").click();
    harness.run_steps(2);
    harness.state_mut().0.run(0.2);
    let stages = harness.state().0.history().last().and_then(|s| s.stages).expect("asked for");
    for (index, name) in ["motion", "detection", "contact", "heat"].into_iter().enumerate() {
        assert!(stages[index] > 0.0, "{name}: {stages:?}");
    }
    assert!(
        harness
            .state()
            .0
            .csv()
            .lines()
            .next()
            .expect("a head")
            .contains("motion_s,detection_s,contact_s,heat_s,bodies_s")
    );
    // A rebuilt world is profiled too.
    assert!(harness.state_mut().0.reset());
    harness.state_mut().0.run(0.1);
    assert!(harness.state().0.history().last().and_then(|s| s.stages).is_some());
    let timed = harness.state().0.world().sheets()[0].state.x.clone();
    let mut untimed = on_a_box();
    untimed.run(0.1);
    assert!(timed.iter().eq(untimed.world().sheets()[0].state.x.iter()), "bit by bit");
}

#[test]
fn an_unstable_variant_is_marked_and_differences_are_at_equal_times() {
    let mut session = strip();
    let variant = |path: &str, value: &str| Variant { path: path.into(), value: value.into() };
    session.compare_with(vec![variant("engine", "rk4"), variant("sheets.0.material.young", "1e9")]);
    session.run(0.2);
    assert!(session.shown(1).and_then(Session::unstable_since).is_some(), "a stiff sheet at 60 Hz by rk4");
    let mut harness = whole(session);
    harness.state_mut().1.open_sections = [sheetwork_editor::panels::Section::Compare].into();
    harness.state_mut().1.plots.shown = true;
    harness.run_steps(3);
    assert!(harness.query_by_label("✖ engine rk4").is_some());
    assert!(harness.query_by_label("✖ young 1e9").is_none());
}
