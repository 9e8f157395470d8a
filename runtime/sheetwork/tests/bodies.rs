//! Dynamic bodies, and sheets attached to bodies, through the public interface of the world.

use glam::{DQuat, DVec3};
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;

fn world(text: &str) -> World {
    World::new(&Scene::parse(text).expect("valid")).expect("valid")
}

/// A strip attached at its left edge to a body "arm", as to a stiff bracket; `sheet` and `arm` are
/// further fields of the two.
fn held(engine: &str, sheet: &str, arm: &str) -> World {
    world(&format!(
        "(engine: \"{engine}\", dt: 0.002, gravity: (0, -0.981, 0), sheets: [(name: \"strip\", pins: [(region: Left, body: \"arm\")], {sheet})],
          bodies: [(name: \"ball\", shape: Ball(0.01), mass: 1, placement: (position: (1, 0, 0))),
            (name: \"arm\", shape: Box((0.02, 0.02, 0.02)), placement: (position: (-0.1, 0.2, 0)), {arm})])"
    ))
}

const LATTICE: &str =
    "structure: \"trimm\", grid: (11, 2, 11), size: (0.025, 0.025), material: \"thesis\", springs: Uniform";
const SHELL: &str = "structure: \"shell\", grid: (7, 1, 5), size: (0.1, 0.05), material: \"hips\"";
const SWEEP: &str = "path: [(time: 0), (time: 0.1, offset: (0.02, 0.01, 0), rotation: (0, 20, 10))]";

#[test]
fn nodes_attached_to_a_kinematic_body_follow_without_lag() {
    for (engine, sheet) in [("euler-richardson", LATTICE), ("rk45", LATTICE), ("tr-bdf2", SHELL), ("bdf2", SHELL)] {
        let mut world = held(engine, sheet, SWEEP);
        let index = world.rigid().and_then(|r| r.index_of("arm")).expect("there");
        let state = |world: &World| *world.body_state("arm").expect("there");
        let sheet = &world.sheets()[0];
        let glued: Vec<usize> = (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).collect();
        assert!(!glued.is_empty(), "{engine}");
        let locals: Vec<DVec3> = glued.iter().map(|i| state(&world).local_point(sheet.state.x.get(*i))).collect();
        for _ in 0..150 {
            world.step();
            let arm = state(&world);
            assert_eq!(world.rigid().and_then(|r| r.pose(index)), Some((arm.origin(), arm.rotation())));
            for (i, local) in glued.iter().zip(&locals) {
                let lag = world.sheets()[0].state.x.get(*i).distance(arm.world_point(*local));
                assert!(lag < 1e-15, "{engine}: {lag:e}");
            }
        }
        assert!(world.unstable().is_none(), "{engine}");
        assert!(state(&world).origin().distance(DVec3::new(-0.08, 0.21, 0.0)) < 1e-15);
    }
}

#[test]
fn an_attached_sheet_follows_a_moved_body_and_falls_after_its_removal() {
    let mut world = held("tr-bdf2", SHELL, "");
    world.step();
    let before = world.sheets()[0].state.x.get(0);
    assert!(world.move_body(world.body_id("arm").expect("there"), DVec3::new(-0.1, 0.2001, 0.0), DQuat::IDENTITY));
    world.step();
    assert!((world.sheets()[0].state.x.get(0) - before).distance(DVec3::Y * 1e-4) < 1e-15);
    // Bodies after the removed one get new indices; those before it keep theirs.
    assert!(world.remove_body(world.body_id("arm").expect("there")));
    assert!((0..world.sheets()[0].node_count()).all(|i| !world.sheets()[0].is_held(i)));
    let height = world.sheets()[0].centre_of_mass().y;
    world.advance(0.6);
    assert!(world.sheets()[0].centre_of_mass().y < height - 0.15);
    world.reset().expect("the pin went with its body");
    assert!(world.scene().sheets[0].pins.is_empty() && world.body_state("arm").is_none());
}

#[test]
fn nodes_attached_to_a_dynamic_body_are_dynamic_and_start_with_its_motion() {
    let world = held("tr-bdf2", SHELL, "mass: 0.1, velocity: (0, 1, 0), spin: (0, 0, 2)");
    let sheet = &world.sheets()[0];
    let glued: Vec<_> = sheet.dynamic_attachments().collect();
    let arm = *world.body_state("arm").expect("there");
    assert_eq!(glued.len(), 5);
    for (mass, index, local) in glued {
        let i = mass as usize;
        assert_eq!(world.rigid().and_then(|r| r.index_of("arm")), Some(index));
        assert!(!sheet.is_held(i));
        assert!(arm.world_point(local).distance(sheet.state.x.get(i)) < 1e-16);
        assert!(sheet.state.v.get(i).distance(arm.velocity_at(sheet.state.x.get(i))) < 1e-15);
    }
}

#[test]
fn an_attachment_to_a_missing_body_is_rejected() {
    let scene = Scene::parse("(bodies: [(shape: Ball(1))], sheets: [(pins: [(region: Left, body: \"body 0\")])])");
    let error = World::without_bodies(&scene.expect("valid")).err().expect("nothing there");
    assert!(error.field == "sheets.0.pins" && error.problem.contains("body 0"), "{error}");
}

#[test]
fn a_dynamic_body_conserves_energy_and_is_reported() {
    let mut world = world(
        "(dt: 0.01, bodies: [(name: \"top\", shape: Box((0.1, 0.02, 0.05)), mass: 0.3, velocity: (1, 5, 0), spin: (20, 3, 1)),
            (name: \"post\", shape: Box((0.1, 1, 0.1)), placement: (position: (9, 0, 0)))])",
    );
    let start = world.energy();
    let kinetic = world.body_state("top").expect("there").kinetic_energy();
    assert_eq!((start.kinetic, start.elastic), (kinetic, 0.0));
    world.advance(1.0);
    assert!((world.energy().total - start.total).abs() < 1e-12 * start.kinetic);
    let report = world.report(0.0, &[]);
    let (top, post) = (&report.bodies[0], &report.bodies[1]);
    assert_eq!((top.mass_kg, post.mass_kg), (Some(0.3), None));
    assert!((top.velocity_m_s[1] - (5.0 - 9.81)).abs() < 1e-12 && top.spin_rad_s[0].abs() > 1.0 && !top.asleep);
    world.set_gravity(DVec3::ZERO).expect("in range");
    world.advance(1.0);
    assert!((world.body_state("top").expect("there").velocity().y - (5.0 - 9.81)).abs() < 1e-12);
    world.reset().expect("valid");
    assert_eq!(world.energy(), start);
}

#[test]
fn a_scene_of_bodies_is_bit_identical_on_any_number_of_threads() {
    let text = "(dt: 0.0166, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), sheets: [(name: \"a\"), (name: \"b\")], repair: true,
        bodies: [(name: \"x\", shape: Box((0.1, 0.1, 0.1)), density: 300, placement: (position: (0.5, 0.2, 0), rotation: (9, 0, 4))),
            (name: \"y\", shape: Ball(0.05), density: 300, placement: (position: (0.53, 0.4, 0.01)))])";
    let end = |threads: usize| {
        let mut world = world(text);
        let sheets: Vec<_> = world.sheet_ids().collect();
        assert!(sheets.into_iter().all(|id| world.remove_sheet(id)));
        world.set_threads(threads).expect("threads");
        let mut taken = 0;
        while taken < 1200 && !world.is_resting() {
            world.step();
            taken += 1;
        }
        let states = ["x", "y"].map(|name| *world.body_state(name).expect("there"));
        (taken, states)
    };
    let (one, two) = (end(1), end(2));
    assert_eq!(one, two);
    assert!(one.1.iter().all(|s| s.centre().y > 0.04));
}

#[test]
fn bodies_can_be_added_during_a_run() {
    let mut world = world("(engine: \"euler-richardson\", dt: 0.001, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)))");
    let ball =
        Scene::parse("(bodies: [(name: \"ball\", shape: Ball(0.1), mass: 1, placement: (position: (0, 0.5, 0)))])");
    let spec = ball.expect("valid").bodies.remove(0);
    let (first, second) = (world.add_body(&spec).expect("valid"), world.add_body(&spec).expect("valid"));
    assert_eq!((world.body_name(first), world.body_name(second)), (Some("ball"), Some("ball 2")));
    assert!(world.remove_body(second));
    world.advance(0.1);
    let fallen: f64 = 0.5 - world.body_state("ball").expect("there").centre().y;
    assert!((fallen - 0.5 * 9.81 * 0.01).abs() < 1e-12, "{fallen}");
}

#[test]
fn a_moved_dynamic_body_is_at_rest_and_wakes_sleeping_sheets() {
    let mut world = world(
        "(room: (x: (-1, 1), y: (0, 1), z: (-1, 1)), engine: \"tr-bdf2\", dt: 0.01,
            sheets: [(name: \"card\", structure: \"shell\", grid: (9, 1, 9), size: (0.2, 0.2), material: \"card\",
                pins: [(region: Left), (region: Right)], placement: (position: (0, 0.1, 0)))],
            bodies: [(name: \"ball\", shape: Ball(0.02), mass: 0.01, placement: (position: (0, 0.13, 0))),
                (name: \"box\", shape: Box((0.1, 0.1, 0.1)), placement: (position: (0.5, 0.05, 0)))])",
    );
    world.advance(6.0);
    assert!(world.is_resting(), "all sleeps");
    let there = DVec3::new(0.3, 0.5, 0.2);
    let id = |name| world.body_id(name).expect("there");
    let (ball, fixed) = (id("ball"), id("box"));
    assert!(world.place_body(ball, there, DQuat::IDENTITY));
    assert!(!world.place_body(fixed, there, DQuat::IDENTITY), "it is static");
    let loaded = world.sheets()[0].centre_of_mass().y;
    world.advance(0.1);
    let ball = *world.body_state("ball").expect("there");
    let fall = 0.5 * 9.81 * 0.1_f64.powi(2);
    assert!((there.y - ball.centre().y - fall).abs() < 1e-9, "{}", there.y - ball.centre().y);
    assert!(world.sheets()[0].centre_of_mass().y > loaded, "the sheet springs back");
    world.advance(0.2);
    let off = world.events().iter().find(|e| e.kind == EventKind::SlidOff).expect("the ball has left it");
    assert!((5.9..6.1).contains(&off.time_s), "when it left, not when it fell asleep: {}", off.time_s);
}
