//! Situations that break contact elsewhere: nothing passes through anything, by the check of every
//! pair of triangles after each step, and led bodies have their way.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;

/// World of a scene after `seconds`.
fn run_for(scene: &str, seconds: f64, is_checked: bool) -> World {
    let scene = Scene::parse(scene).expect("a scene");
    let mut world = World::new(&scene).expect("starts apart");
    world.set_penetration_check(is_checked);
    world.advance(seconds);
    world
}

/// World of a scene after `seconds`, checked for penetration after each step.
fn run(scene: &str, seconds: f64) -> World {
    let world = run_for(scene, seconds, true);
    let report = world.report(0.0, &[]);
    assert_eq!(report.status, "ok", "{:?}", world.events());
    assert!(world.events().iter().all(|e| !matches!(e.kind, EventKind::Penetration | EventKind::Crossing)));
    world
}

fn centre(world: &World) -> DVec3 {
    world.sheets()[0].centre_of_mass()
}

#[test]
fn pads_that_close_below_the_thickness_hold_a_sheet() {
    for gap in [2.9e-4, 2.5e-4, 1e-4] {
        let closing = 0.5 * (6e-4 - gap);
        let pad = |name: &str, sign: f64| {
            format!(
                "(name: \"{name}\", shape: Box((0.01, 0.02, 0.02)), placement: (position: ({}, 0.06, 0)), \
                 path: [(time: 0), (time: 0.1, offset: ({}, 0, 0))])",
                sign * 0.0053,
                -sign * closing
            )
        };
        let scene = format!(
            r#"(engine: "tr-bdf2", dt: 0.016666666666666666, contact: (friction: 0.5, restitution: 0),
                sheets: [(name: "card", structure: "shell", grid: (8, 1, 5), size: (0.14, 0.08),
                    material: (young: 3e9, poisson: 0.3, density: 1000, thickness: 3e-4, damping_ratio: 0.02),
                    placement: (rotation: (0, 0, 90)), pins: [(region: Left, until: 0.2)])],
                bodies: [{}, {}])"#,
            pad("left", -1.0),
            pad("right", 1.0)
        );
        let world = run(&scene, 0.8);
        let fallen = centre(&world).y;
        assert!(fallen > -1e-4, "gap of {gap} m: at {fallen} m");
        assert!(world.events().iter().all(|e| e.kind != EventKind::GivenUp), "gap of {gap} m: by the solver");
    }
}

#[test]
fn a_shaken_box_keeps_what_is_in_it() {
    // A box of 0.12 m that moves by 50 mm to and fro in 0.2 s.
    let path: Vec<String> = (0..=5)
        .map(|k| format!("(time: {}, offset: ({}, 0, 0))", 0.1 * f64::from(k), if k % 2 == 1 { 0.05 } else { 0.0 }))
        .collect();
    let wall = |size: [f64; 3], at: [f64; 3]| {
        let name = format!("wall {at:?}").replace(['[', ']', ',', '.'], "");
        format!(
            "(name: \"{name}\", shape: Box(({}, {}, {})), placement: (position: ({}, {}, {})), path: [{}]),",
            size[0],
            size[1],
            size[2],
            at[0],
            at[1],
            at[2],
            path.join(", ")
        )
    };
    let mut walls = String::new();
    for side in [-0.065, 0.065] {
        walls += &wall([0.01, 0.14, 0.14], [side, 0.0, 0.0]);
        walls += &wall([0.14, 0.01, 0.14], [0.0, side, 0.0]);
        walls += &wall([0.14, 0.14, 0.01], [0.0, 0.0, side]);
    }
    let scene = format!(
        r#"(engine: "tr-bdf2", dt: 0.008333333333333333, contact: (friction: 0.3, restitution: 0.1),
            sheets: [(name: "paper", structure: "shell", grid: (9, 1, 8), size: (0.11, 0.1), material: "paper",
                placement: (position: (0, -0.03, 0)))], bodies: [{walls}])"#
    );
    let world = run(&scene, 0.5);
    assert!(centre(&world).distance(DVec3::X * 0.05) < 0.07, "{}", centre(&world));
}

#[test]
fn a_strip_whose_ends_clap_at_40_metres_a_second_does_not_pass_through_itself() {
    let scene = r#"(engine: "tr-bdf2", dt: 0.016666666666666666, gravity: (0, 0, 0), contact: (friction: 0.2, restitution: 0),
        sheets: [(name: "strip", structure: "shell", grid: (41, 1, 3), size: (0.4, 0.02), material: "pet",
            pins: [(region: Rect((0.45, 0.55), (0, 1)))],
            velocities: [(region: Rect((0, 0.25), (0, 1)), value: (0, -40, 0)),
                (region: Rect((0.75, 1), (0, 1)), value: (0, -40, 0))])])"#;
    run(scene, 0.1);
}

#[test]
fn a_film_of_a_millimetre_lies_on_a_ball() {
    let scene = r#"(engine: "tr-bdf2", dt: 0.001, contact: (friction: 0.4, restitution: 0),
        sheets: [(name: "film", structure: "shell", grid: (11, 1, 11), size: (0.001, 0.001),
            material: (young: 4.5e9, poisson: 0.38, density: 1395, thickness: 2e-6, damping_ratio: 0.02),
            placement: (position: (0.00001, 0.0004, 0)))],
        bodies: [(name: "ball", shape: Ball(0.0002))])"#;
    let world = run(scene, 0.04);
    assert!(centre(&world).y > 1e-4, "{}", centre(&world));
}

#[test]
fn a_block_on_the_floor_pushes_a_sheet_of_any_thickness_by_its_edge() {
    for thickness in [2e-5, 1e-4, 4e-4] {
        let scene = format!(
            r#"(engine: "tr-bdf2", dt: 0.008333333333333333, contact: (friction: 0.3, restitution: 0),
                sheets: [(name: "paper", structure: "shell", grid: (6, 1, 5), size: (0.1, 0.08),
                    material: (young: 3e9, poisson: 0.3, density: 800, thickness: {thickness}, damping_ratio: 0.02),
                    placement: (position: (0, {}, 0)))],
                bodies: [(name: "floor", shape: HalfSpace), (name: "block", shape: Box((0.02, 0.04, 0.2)),
                    placement: (position: (-0.065, 0.02, 0)),
                    path: [(time: 0), (time: 1, offset: (0.1, 0, 0))])])"#,
            0.5 * thickness
        );
        let world = run(&scene, 0.4);
        // The block starts 5 mm from the edge and goes 40 mm.
        let moved = centre(&world).x;
        assert!((moved - 0.035).abs() < 5e-4, "{thickness} m: moved by {moved} m");
    }
}

/// Material of the compressed sheets.
const PLASTIC: &str = "material: (young: 3e9, poisson: 0.3, density: 1200, thickness: 3e-4, damping_ratio: 0.02)";

#[test]
fn a_plate_presses_a_sheet_onto_a_box_edge() {
    // The gap is a third of the thickness, and the overlap of plate and box smaller than the cells.
    let scene = format!(
        r#"(engine: "tr-bdf2", dt: 0.016666666666666666, contact: (friction: 0.5, restitution: 0),
            sheets: [(name: "s", structure: "shell", grid: (12, 1, 7), size: (0.2, 0.1), {PLASTIC},
                placement: (position: (0, 0.06, 0)))],
            bodies: [(name: "box", shape: Box((0.05, 0.05, 0.05)), placement: (position: (0, 0.025, 0)), path: [(time: 0), (time: 3)]),
                (name: "plate", shape: Box((0.04, 0.04, 0.04)), placement: (position: (0.02, 0.1, 0.01)),
                    path: [(time: 0), (time: 0.4, offset: (0, -0.0299, 0))])])"#
    );
    let world = run(&scene, 0.6);
    let plate = world.body_state("plate").expect("there").origin().y;
    assert!((plate - 0.0701).abs() < 1e-9, "the plate is at {plate} m");
}

/// A sheet that hangs in a gripper, which closes to a gap below the thickness within two steps and
/// then moves 0.2 m aside, 0.1 m up and 0.05 m back in 0.2 s.
fn gripped(budget: &str) -> World {
    let jaw = |name: &str, side: f64| {
        let at = |x: f64| x - side * 6e-4;
        format!(
            "(name: \"{name}\", shape: Box((0.01, 0.02, 0.03)), placement: (position: ({}, 0.09, 0)), path: [(time: 0), \
             (time: 0.03, offset: ({}, 0, 0)), (time: 0.1, offset: ({}, 0, 0)), (time: 0.3, offset: ({}, 0.1, 0.05))])",
            side * 0.00565,
            at(0.0),
            at(0.0),
            at(0.2)
        )
    };
    let scene = format!(
        r#"(engine: "tr-bdf2", dt: 0.016666666666666666, contact: (friction: 0.5, restitution: 0{budget}),
            sheets: [(name: "s", structure: "shell", grid: (12, 1, 7), size: (0.2, 0.1), {PLASTIC},
                placement: (rotation: (0, 0, 90)), pins: [(region: Left, until: 0.1)])],
            bodies: [{}, {}])"#,
        jaw("left", 1.0),
        jaw("right", -1.0)
    );
    run_for(&scene, 0.45, false)
}

/// Distance of the node of the sheet that is nearest to the gripper from its end.
fn nearest_to_gripper(world: &World) -> f64 {
    let end = DVec3::new(0.2, 0.19, 0.05);
    world.sheets()[0].state.x.iter().map(|x| x.distance(end)).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_gripper_that_moves_at_1_m_per_s_keeps_the_sheet() {
    let world = gripped("");
    assert_eq!(world.report(0.0, &[]).status, "ok", "{:?}", world.events());
    let distance = nearest_to_gripper(&world);
    assert!(distance < 0.015, "{distance} m");
}

#[test]
fn a_step_budget_bounds_the_work_and_is_told() {
    let world = gripped(", step_budget: 20000");
    let told = world.events().iter().any(|e| e.kind == EventKind::GivenUp);
    assert!(told, "{:?}", world.events());
    assert!(world.contact_counters(0).given_up > 0);
    assert!(nearest_to_gripper(&world) < 0.015);
    assert_eq!(gripped(", step_budget: 20000").state_hash(), world.state_hash());
    let refusal = Scene::parse(r#"(contact: (step_budget: 10), sheets: [(structure: "shell")])"#).err();
    let refusal = refusal.map(|error| error.to_string()).unwrap_or_default();
    assert!(refusal.contains("contact.step_budget"), "{refusal}");
}
