//! Fallbacks of contact: conservation of momentum, energy and separation where the contact solver
//! does not converge.
//!
//! A free aluminium foil of 16 µm, 0.25 m square, is hit by a dynamic body at 60 steps per second.
//! At 6 to 25 m/s the foil wraps around the body within a few steps, in folds that no substep
//! resolves; foil and body then move as one rigid body. Two free sheets that collide keep their
//! momentum, with or without a fallback.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;
use sheetwork_tests::world_of;

/// Nodes along a side of the foil.
const SIDE: usize = 21;
const STEPS: u32 = 20;
/// Interpolated positions between two steps at which the passage of the body is checked.
const INTERPOLATIONS: u32 = 100;

/// A free foil, and a dynamic body of this shape that hits it at `speed` m/s.
fn struck(shape: &str, speed: f64) -> World {
    world_of(&format!(
        r#"(
            engine: "tr-bdf2", dt: 0.0166666666666667, gravity: (0, 0, 0), contact: (friction: 0.3, restitution: 0.2),
            sheets: [(name: "foil", structure: "shell", grid: ({SIDE}, 1, {SIDE}), size: (0.25, 0.25), material: "aluminium-foil")],
            bodies: [(name: "body", shape: {shape}, density: 2000, velocity: (0, -{speed:?}, 0),
                placement: (position: (0.013, 0.2, 0.008)))],
        )"#
    ))
}

/// Positions of the foil's nodes and of the body's centre.
fn places(world: &World) -> (Vec<DVec3>, DVec3) {
    let body = world.body_state("body").expect("it is there");
    (world.sheets()[0].state.x.iter().collect(), body.centre())
}

fn momentum(world: &World) -> DVec3 {
    world.sheets()[0].momentum() + world.body_state("body").expect("it is there").momentum()
}

fn energy(world: &World) -> f64 {
    world.sheets()[0].energy(DVec3::ZERO).total + world.body_state("body").expect("it is there").kinetic_energy()
}

/// Signed solid angle of the foil from `eye`. It jumps by 4π when the point passes through the foil
/// and changes little otherwise.
fn solid_angle(foil: &[DVec3], eye: DVec3) -> f64 {
    let of = |corners: [usize; 3]| {
        let [a, b, c] = corners.map(|i| foil[i] - eye);
        let (p, q, r) = (a.length(), b.length(), c.length());
        2.0 * a.dot(b.cross(c)).atan2(p * q * r + a.dot(b) * r + b.dot(c) * p + c.dot(a) * q)
    };
    let cells = (0..SIDE - 1).flat_map(|j| (0..SIDE - 1).map(move |i| j * SIDE + i));
    cells.map(|m| of([m, m + SIDE, m + 1]) + of([m + 1, m + SIDE, m + SIDE + 1])).sum()
}

/// Takes a step and returns the largest change of that angle between interpolated positions.
fn step_and_look(world: &mut World) -> f64 {
    let (foil, body) = places(world);
    world.step();
    let (foil_after, body_after) = places(world);
    let angle = |k: u32| {
        let part = f64::from(k) / f64::from(INTERPOLATIONS);
        let there: Vec<DVec3> = foil.iter().zip(&foil_after).map(|(a, b)| a.lerp(*b, part)).collect();
        solid_angle(&there, body.lerp(body_after, part))
    };
    let angles: Vec<f64> = (0..=INTERPOLATIONS).map(angle).collect();
    angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn no_dynamic_body_passes_through_a_free_foil_and_momentum_is_conserved() {
    let cases = [
        ("Ball(0.02)", 6.0),
        ("Ball(0.02)", 10.0),
        ("Ball(0.02)", 20.0),
        ("Box((0.03, 0.03, 0.03))", 20.0),
        ("Ball(0.004)", 20.0),
    ];
    for (shape, speed) in cases {
        let mut world = struck(shape, speed);
        let (start, energy_at_start) = (momentum(&world), energy(&world));
        for step in 0..STEPS {
            let change = step_and_look(&mut world);
            assert!(change < 1.0, "{shape} at {speed} m/s goes through in step {step}: {change}");
            let lost = momentum(&world).distance(start) / start.length();
            assert!(lost < 1e-6, "{shape} at {speed} m/s: {lost} of the momentum is gone after step {step}");
            let gained = energy(&world) / energy_at_start - 1.0;
            assert!(gained < 1e-3, "{shape} at {speed} m/s: {gained} of the energy is new after step {step}");
        }
        assert!(world.unstable().is_none(), "{shape} at {speed} m/s");
    }
}

#[test]
fn a_contact_fallback_sends_an_event() {
    let mut world = struck("Ball(0.004)", 20.0);
    (0..STEPS).for_each(|_| _ = world.step());
    let parts = world.contact_counters(0).given_up;
    assert!(parts > 0, "this is to be too much for contact");
    let told = world.events().iter().filter(|e| e.kind == EventKind::GivenUp).count() as u64;
    assert!(told > 0 && told <= parts, "{told} events of {parts} parts");
    assert!(world.events().iter().all(|e| e.kind != EventKind::GivenUp || e.sheet == "foil"));
}

/// Two interpenetrating cards that no motion separates. They are reported, pass through one
/// another, and collide again once they are apart.
#[test]
fn interpenetrating_sheets_pass_until_they_are_apart() {
    let card = |name: &str, rotation: &str, pins: &str| {
        format!(
            r#"(name: "{name}", structure: "shell", grid: (7, 1, 5), size: (0.088, 0.063), pins: [{pins}],
                material: (young: 3e9, poisson: 0.35, density: 850, thickness: 3e-4),
                placement: (position: (0, 0.1, 0), rotation: {rotation}))"#
        )
    };
    let crossed = |held: &str| {
        let text = format!(
            r#"(engine: "tr-bdf2", dt: 0.0166666666666667, sheets: [{}, {}], bodies: [(name: "floor", shape: HalfSpace)])"#,
            card("held", "(0, 0, 0)", held),
            card("other", "(70, 30, 0)", "")
        );
        World::with_start_overlaps(&Scene::parse(&text).expect("a scene")).expect("a world")
    };
    let told = |world: &World, kind: EventKind| world.events().iter().filter(|e| e.kind == kind).count();
    // Both cards fall and rest on the floor, interpenetrating.
    let mut world = crossed("");
    let start = world.energy().total;
    for _ in 0..180 {
        world.step();
        assert!(world.energy().total < start + 1e-9, "they gain energy");
    }
    assert_eq!((told(&world, EventKind::Crossing), told(&world, EventKind::GivenUp)), (2, 0));
    assert!(world.unstable().is_none() && world.sheets().iter().all(|s| s.state.x.iter().all(|p| p.y > 1e-4)));
    // One card is fixed: the other falls out of it, and lands on it when placed above.
    let mut world = crossed("(region: Left, clamp: true)");
    (0..30).for_each(|_| _ = world.step());
    let height = |world: &World, i: usize| world.sheets()[i].centre_of_mass().y;
    assert!(height(&world, 0) - height(&world, 1) > 0.05, "it has not come out");
    assert_eq!((told(&world, EventKind::Crossing), told(&world, EventKind::GivenUp)), (2, 0));
    let sheet = world.sheet_mut("other").expect("there");
    for i in 0..sheet.node_count() {
        let p = sheet.state.x.get(i);
        sheet.state.x.set(i, DVec3::new(p.x, 0.12, p.z));
        sheet.state.v.set(i, DVec3::ZERO);
    }
    (0..60).for_each(|_| _ = world.step());
    assert!(height(&world, 1) > height(&world, 0), "it has gone through");
    assert_eq!(told(&world, EventKind::Crossing), 2);
    // A program that moves one card through the other during the run triggers a new check.
    let (masses, middle) = (world.sheets()[0].node_count(), world.sheets()[0].centre_of_mass());
    let sheet = world.sheet_mut("other").expect("there");
    for i in 0..masses {
        let p = sheet.state.x.get(i);
        sheet.state.x.set(i, DVec3::new(middle.x + p.z, middle.y + p.x, middle.z));
        sheet.state.v.set(i, DVec3::ZERO);
    }
    sheet.wake();
    world.step();
    assert_eq!(told(&world, EventKind::Crossing), 4);
}

/// Pyramids that fall on, or are thrown at, a sheet on the floor or one fixed at its edges: a
/// fallback must not add energy.
#[test]
fn a_contact_fallback_adds_no_energy() {
    let pyramid = |half: f64| {
        let corner = |x: f64, z: f64| format!("({}, 0, {})", x * half, z * half);
        let base = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)].join(", ");
        format!(
            "Polyhedron((vertices: [{base}, (0, 0.05, 0)], faces: [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))"
        )
    };
    let cases = [
        (0.008, "paper", "(0.0148, 0.3, -0.0239)", "(212.6, 278.7, 138.1)", 0.0, 0.0006, false, 27),
        (0.004, "paper", "(0.011, 0.1, 0.007)", "(172, 10, 4)", 0.0, 0.0, true, 20),
        (0.004, "paper", "(-0.017, 0.1852, 0.0373)", "(14.8, 161.8, 127.2)", 12.5, 0.05, true, 30),
        (0.004, "aluminium-foil", "(0.0193, 0.1454, 0.0072)", "(88.2, 50.2, 36.9)", 2.4, 0.05, true, 30),
    ];
    let mut replaced = 0;
    for (half, material, position, rotation, speed, height, is_held, steps) in cases {
        let pins = if is_held { "(region: Border)" } else { "" };
        let room = if height > 0.0 {
            "room: (x: (-0.4, 0.4), y: (0, 0.4), z: (-0.3, 0.3), grid: 0.02, back_wall: false),"
        } else {
            ""
        };
        let mut world = world_of(&format!(
            r#"(engine: "tr-bdf2", dt: 0.0166666666666667, contact: (friction: 0.3, restitution: 0.1, step_budget: 1000), {room}
            sheets: [(name: "s", structure: "shell", grid: (15, 1, 15), size: (0.2, 0.2), material: "{material}", pins: [{pins}],
                placement: (position: (0, {height}, 0)))],
            bodies: [(name: "b", shape: {}, mass: 0.004, velocity: (0, -{speed:?}, 0), placement: (position: {position}, rotation: {rotation}))])"#,
            pyramid(half)
        ));
        let start = world.energy().total;
        for step in 0..steps {
            replaced += world.step().barrier;
            let now = world.energy().total;
            assert!(now < start * 1.001, "{half} m: {now} J of {start} J after step {step}");
        }
    }
    assert!(replaced > 0, "this is to be too much for the contact solver");
}

#[test]
fn a_needle_comes_to_rest_on_a_sheet_without_fallback() {
    // Near its tip the needle is thinner than the tolerated penetration at the start of a stage.
    // Its far edges must not count as contacts from within.
    let laid = [
        (
            "(-0.000547789548967087, 0.16718212205620062, -0.006061072225351426)",
            "(305.07614529740374, 274.95886283158103, 91.8248492661918)",
        ),
        (
            "(0.0013529665642330255, 0.522210925762524, -0.011407903505950286)",
            "(272.8635850585089, 151.4057690991042, 93.2100301054668)",
        ),
        (
            "(0.04025986537553394, 0.5780171359446247, 0.02831639868822279)",
            "(341.21789534136576, 20.35849238165113, 30.553918257211787)",
        ),
    ];
    for (position, rotation) in laid {
        let mut world = world_of(&format!(
            r#"(
                engine: "tr-bdf2", dt: 0.0166666666666667, contact: (friction: 0.3, restitution: 0.1),
                sheets: [(name: "sheet", structure: "shell", grid: (15, 1, 15), size: (0.2, 0.2), material: "paper",
                    placement: (position: (0, 0.0006, 0)))],
                bodies: [
                    (name: "floor", shape: HalfSpace),
                    (name: "needle", shape: Polyhedron((
                        vertices: [(-0.004, 0, -0.004), (-0.004, 0, 0.004), (0.004, 0, 0.004), (0.004, 0, -0.004), (0, 0.05, 0)],
                        faces: [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
                    )), mass: 0.004, placement: (position: {position}, rotation: {rotation})),
                ],
            )"#
        ));
        world.advance(2.0);
        let work = world.report(0.0, &[]).sheets[0].contact_work;
        println!("{} factors, {} halved", work.factors, work.halved);
        assert_eq!(work.given_up, 0, "{position}, {rotation}");
        assert!(work.factors < 10_000, "{position}, {rotation}: {} factors", work.factors);
        assert!(world.is_resting(), "{position}, {rotation}");
    }
}

/// Two free sheets, given by grid, size, material, position and rotation (degrees), that approach
/// one another with `speeds` m/s along y.
fn pair(sheets: [&str; 2], speeds: [f64; 2], budget: &str) -> World {
    let sheet = |k: usize| {
        let (name, about, speed) = (["a", "b"][k], sheets[k], speeds[k]);
        format!(r#"(name: "{name}", structure: "shell", {about}, velocity: (0, {speed:?}, 0))"#)
    };
    world_of(&format!(
        r#"(
            engine: "tr-bdf2", dt: 0.0166666666666667, gravity: (0, 0, 0), contact: (friction: 0.3, restitution: 0.2, {budget}),
            sheets: [{}, {}],
        )"#,
        sheet(0),
        sheet(1)
    ))
}

#[test]
fn two_colliding_free_sheets_conserve_momentum() {
    let cards = [
        r#"grid: (9, 1, 9), size: (0.1, 0.1), material: "card", placement: (position: (0, -0.15, 0))"#,
        r#"grid: (9, 1, 9), size: (0.08, 0.08), material: "card", placement: (position: (0.02, 0.15, 0.01), rotation: (10, 20, 50))"#,
    ];
    let hips_on_paper = [
        r#"grid: (13, 1, 7), size: (0.0755, 0.1046), material: "hips",
            placement: (position: (0.0049, -0.15, 0.0099), rotation: (-14.3, 22.3, 49.4))"#,
        r#"grid: (7, 1, 7), size: (0.0776, 0.0911), material: "paper",
            placement: (position: (0.0074, 0.15, -0.0192), rotation: (46.6, -57.5, 39.3))"#,
    ];
    let rubber_on_pet = [
        r#"grid: (9, 1, 9), size: (0.1471, 0.0926), material: "rubber",
            placement: (position: (-0.0089, -0.15, 0.0236), rotation: (-89.8, -70.6, 11.8))"#,
        r#"grid: (11, 1, 9), size: (0.1167, 0.1124), material: "pet",
            placement: (position: (-0.0074, 0.15, -0.0041), rotation: (-49.3, -37.5, 85.0))"#,
    ];
    // Too fast and too thin for convergence in any substep.
    let pet_on_pvc = [
        r#"grid: (11, 1, 9), size: (0.1, 0.08), material: "pet", placement: (position: (0, -0.6, 0.3), rotation: (0, 20, 70))"#,
        r#"grid: (9, 1, 9), size: (0.1, 0.1), material: "pvc", placement: (position: (0.02, 0.6, 0.31), rotation: (70, 0, 10))"#,
    ];
    let cases =
        [(cards, [5.0, -5.0]), (hips_on_paper, [5.0, -5.0]), (rubber_on_pet, [2.5, -2.5]), (pet_on_pvc, [10.0, -20.0])];
    // A budget that the contact solver exceeds leaves the step to the barrier method.
    let each = cases.into_iter().enumerate().flat_map(|case| [(case, ""), (case, "step_budget: 1000")]);
    for ((k, (sheets, speeds)), budget) in each {
        let mut world = pair(sheets, speeds, budget);
        let of = |world: &World| world.sheets().iter().map(|s| s.momentum()).sum::<DVec3>();
        let energy = |world: &World| world.sheets().iter().map(|s| s.energy(DVec3::ZERO).total).sum::<f64>();
        let scale: f64 = world.sheets().iter().map(|s| s.momentum().length()).sum();
        let (start, energy_at_start) = (of(&world), energy(&world));
        let mut replaced = 0;
        for step in 0..10 {
            replaced += world.step().barrier;
            let lost = (of(&world) - start).length() / scale;
            assert!(lost < 1e-9, "pair {k}, step {step}: {lost:e} of the momentum");
            let gain = energy(&world) / energy_at_start;
            assert!(gain < 1.0 + 1e-9, "pair {k}, step {step}: {gain} of the energy");
        }
        assert!(energy(&world) < 0.9 * energy_at_start, "pair {k} has met");
        assert!(replaced > 0 || budget.is_empty(), "pair {k}");
    }
}
