//! Creases, cuts and heat drawn on a sheet reach the world and can be undone.

use bevy_egui::egui::{self, Key, Modifiers};
use sheetwork::World;
use sheetwork::scene::{Scene, SpotSpec};
use sheetwork_editor::panels::Tool;
use sheetwork_editor::session::Session;

use super::common::{drag, seen, strip, whole};

fn temperature(session: &Session) -> (f64, f64) {
    session.world().sheets()[0].heat().map_or((20.0, 20.0), |h| h.range())
}

#[test]
fn heat_is_painted_under_the_mouse_and_a_stroke_can_be_undone() {
    let mut harness = whole(strip());
    harness.state_mut().0.run(0.1);
    harness.state_mut().1.tool = Tool::Heat;
    let (from, to) = (seen(&harness, (0.4, 0.5)), seen(&harness, (0.8, 0.5)));
    drag(&mut harness, from, to);
    {
        let session = &harness.state().0;
        let sheet = &session.world().sheets()[0];
        let celsius = sheet.temperatures().expect("warm");
        let at = |u: f64, v: f64| {
            let near = |i: &usize| (sheet.model.uv[*i].0 - u).hypot(sheet.model.uv[*i].1 - v);
            let mass = (0..sheet.node_count()).min_by(|a, b| near(a).total_cmp(&near(b))).expect("masses");
            celsius[mass]
        };
        assert!((at(0.6, 0.5) - 120.0).abs() < 1.0, "in the stroke: {}", at(0.6, 0.5));
        assert!((at(0.1, 0.5) - 20.0).abs() < 1e-9 && (at(0.6, 0.0) - 20.0).abs() < 1e-9, "aside of it");
        assert!(session.scene().sheets[0].spots.len() > 2, "kept in the scene");
        assert!(session.world().time() > 0.09, "and the run goes on");
    }
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert_eq!(temperature(&harness.state().0), (20.0, 20.0));
    assert!(harness.state().0.scene().sheets[0].spots.is_empty());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(2);
    assert!((temperature(&harness.state().0).1 - 120.0).abs() < 1.0, "and done again");
    assert!(harness.state_mut().0.reset());
    assert!((temperature(&harness.state().0).1 - 120.0).abs() < 1.0, "it is part of the scene");
}

#[test]
fn a_crease_is_drawn_and_folds_the_sheet() {
    let mut harness = whole(strip());
    harness.state_mut().1.tool = Tool::Crease;
    let (from, to) = (seen(&harness, (0.5, 0.02)), seen(&harness, (0.5, 0.98)));
    drag(&mut harness, from, to);
    let session = &mut harness.state_mut().0;
    let creases = session.scene().sheets[0].creases.clone();
    assert_eq!(creases.len(), 1);
    assert!((creases[0].from.0 - 0.5).abs() < 0.02 && (creases[0].to.1 - 0.98).abs() < 0.03, "{creases:?}");
    let folded = {
        let mut free = Scene { gravity: glam::DVec3::ZERO, ..session.scene().clone() };
        free.sheets[0].pins[0].clamp = true;
        let mut world = World::new(&free).expect("valid");
        world.find_equilibrium(1e-9);
        world.sheets()[0].probes[0].at(&world.sheets()[0].state.x).y
    };
    assert!(folded > 0.02, "half of 12 cm stands up by 60 degrees: {folded}");
    assert!(session.undo() && session.scene().sheets[0].creases.is_empty());
    let lattice = Scene::parse(
        r#"(engine: "euler-richardson", dt: 0.001,
            sheets: [(structure: "slamm", grid: (5, 2, 5), size: (0.025, 0.025), material: "thesis", springs: Uniform)])"#,
    )
    .expect("valid");
    let mut session = Session::new(&lattice).expect("valid");
    assert!(!session.crease(0, ((0.5, 0.0), (0.5, 1.0)), 60.0));
    assert!(session.messages()[0].text.contains("creases"), "{:?}", session.messages());
}

#[test]
fn a_cut_opens_the_cells_under_the_line_while_it_runs() {
    let mut harness = whole(strip());
    harness.state_mut().0.run(0.1);
    harness.state_mut().1.tool = Tool::Cut;
    let (from, to) = (seen(&harness, (0.55, 0.02)), seen(&harness, (0.55, 0.98)));
    drag(&mut harness, from, to);
    let session = &mut harness.state_mut().0;
    assert_eq!(session.world().sheets()[0].open_count(), 8, "{:?}", session.messages());
    assert!(session.world().time() > 0.09, "the run goes on");
    let tip = |s: &Session| s.world().sheets()[0].probes[0].at(&s.world().sheets()[0].state.x).y;
    let before = tip(session);
    session.run(0.3);
    assert!(
        session.world().unstable().is_none() && tip(session) < before - 0.1,
        "what is cut off falls: {}",
        tip(session)
    );
    assert!(session.reset() && session.world().sheets()[0].open_count() == 8, "it is part of the scene");
    assert!(session.undo() && session.world().sheets()[0].open_count() == 0);
    let triangles = Scene::parse(
        r#"(engine: "euler-richardson", dt: 0.001,
            sheets: [(structure: "trimm", grid: (5, 2, 5), size: (0.025, 0.025), material: "thesis", springs: Uniform)])"#,
    )
    .expect("valid");
    let mut session = Session::new(&triangles).expect("valid");
    assert!(session.cut(0, ((0.5, 0.0), (0.5, 1.0))), "{:?}", session.messages());
    assert!(session.world().sheets()[0].open_count() > 0, "triangles open too");
}

#[test]
fn a_cut_drawn_past_an_edge_reaches_the_edge() {
    let mut harness = whole(strip());
    harness.state_mut().1.tool = Tool::Cut;
    let (inside, edge) = (seen(&harness, (0.55, 0.4)), seen(&harness, (0.55, 0.98)));
    // As far beyond the edge as the edge is from the middle: with few frames the mouse is never
    // close to the edge.
    drag(&mut harness, inside, inside + (edge - inside) * 2.0);
    let slits = &harness.state().0.scene().sheets[0].slits;
    assert_eq!(slits.len(), 1);
    assert!((slits[0].1.0 - 0.55).abs() < 0.05 && slits[0].1.1 == 1.0, "{slits:?}");
}

#[test]
fn a_fast_stroke_has_no_gaps() {
    let mut harness = whole(strip());
    harness.state_mut().1.tool = Tool::Heat;
    harness.state_mut().1.brush.radius = Some(0.01);
    let (from, to) = (seen(&harness, (0.3, 0.5)), seen(&harness, (0.9, 0.5)));
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let way = [
        egui::Event::PointerMoved(from),
        button(from, true),
        egui::Event::PointerMoved(from.lerp(to, 0.1)),
        egui::Event::PointerMoved(to),
        button(to, false),
    ];
    for event in way {
        harness.event(event);
        harness.run_steps(1);
    }
    let sheet = &harness.state().0.world().sheets()[0];
    let celsius = sheet.temperatures().expect("warm");
    let row: Vec<f64> = (0..sheet.node_count())
        .filter(|i| (0.31..0.89).contains(&sheet.model.uv[*i].0) && (sheet.model.uv[*i].1 - 0.5).abs() < 1e-9)
        .map(|i| celsius[i])
        .collect();
    assert!(row.len() > 3 && row.iter().all(|c| *c > 110.0), "{row:?}");
}

#[test]
fn painted_heat_is_restored_by_a_rollback() {
    let mut session = strip();
    session.run(0.1);
    let painted = session.world().time();
    let hottest = |s: &Session| s.world().sheets()[0].heat().map_or(20.0, |heat| heat.range().1);
    assert!(session.begin_stroke(0) && session.dab(SpotSpec { at: (0.5, 0.5), radius: 0.02, temperature: 90.0 }));
    session.end_stroke();
    session.run(0.1);
    assert!(session.scrub(painted) && (session.world().time() - painted).abs() < 1e-9);
    assert!(hottest(&session) > 80.0, "{}", hottest(&session));
    session.run(0.05);
    assert!(session.undo() && hottest(&session) < 21.0, "undo goes back to before the stroke");
    session.run(0.05);
    assert!(session.scrub(painted) && hottest(&session) < 21.0);
}
