//! Recorded forces: balance of momentum of sheets and bodies, sums over nodes, same results.

use sheetwork::glam::DVec3;
use sheetwork::scene::Scene;
use sheetwork::{ForceKind, ForcePartner, World};
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::{state_hash, world_of};

const SHELL: &str = r#"structure: "shell", grid: (9, 1, 9), size: (0.1, 0.1), material: "hips""#;
const LATTICE: &str = r#"structure: "slamm", grid: (7, 2, 7), size: (0.1, 0.1), material: "thesis""#;
const ROOM: &str = "room: (x: (-1, 1), y: (0, 1), z: (-1, 1), back_wall: false)";
const BALL: &str = r#"bodies: [(name: "ball", shape: Ball(0.02), mass: 0.02, placement: (position: (0.01, 0.05, 0)),
    velocity: (0.2, -1, 0))]"#;

fn world(engine: &str, dt: f64, rest: &str) -> World {
    let mut world = world_of(&format!("(engine: \"{engine}\", dt: {dt}, {rest})"));
    world.record_forces(true);
    world
}

/// Tolerance of the balance: the primal solver of two colliding shells converges to 1e-5.
fn tolerance(name: &str) -> f64 {
    if name.starts_with("struck by a sheet") { 1e-5 } else { 1e-6 }
}

/// Momentum of the body "ball", kg m/s; zero without one.
fn ball_momentum(world: &World) -> DVec3 {
    world.body_state("ball").map_or(DVec3::ZERO, |ball| ball.momentum())
}

/// Largest errors over `steps` steps, relative to the contact and attachment forces: of the
/// momentum of the sheets that no force explains, of the balance with the ball, and of the sum over
/// nodes. Also the number of steps with contact.
fn errors(name: &str, mut world: World, steps: usize) -> ([f64; 3], u32) {
    let (mut worst, mut touched) = ([0.0_f64; 3], 0);
    for step in 0..steps {
        let momenta: Vec<DVec3> = world.sheets().iter().map(|s| s.momentum()).collect();
        let ball = ball_momentum(&world);
        world.step();
        let is_applied = |kind| matches!(kind, ForceKind::Contact | ForceKind::Attachment | ForceKind::Bond);
        let applied = || world.forces().iter().filter(|e| is_applied(e.kind));
        let scale: f64 = applied().map(|e| e.magnitude * world.dt()).sum();
        let mass = world.body_state("ball").map_or(0.0, |ball| ball.mass());
        let on_ball = ball_momentum(&world) - ball - world.gravity() * (mass * world.dt());
        let from_ball: DVec3 = applied().filter(|e| world.partner_name(e) == Some("ball")).map(|e| e.impulse).sum();
        for (index, sheet) in world.sheets().iter().enumerate() {
            let own = || world.forces().iter().filter(move |e| e.sheet == index);
            let change = sheet.momentum() - momenta[index];
            let sum: DVec3 = own().map(|e| e.impulse).sum();
            assert!(sum.distance(change) <= 1e-12 * (scale + change.length()) + 1e-18, "{name}, step {step}");
            let numerical: DVec3 = own().filter(|e| e.kind == ForceKind::Numerical).map(|e| e.impulse).sum();
            let contact = own().filter(|e| matches!(e.kind, ForceKind::Contact | ForceKind::Attachment));
            let contact: DVec3 = contact.map(|e| e.impulse / world.dt()).sum();
            let nodes: DVec3 = sheet.mean_forces().expect("recorded").0.iter().sum();
            if scale > 1e-9 {
                worst[0] = worst[0].max(numerical.length() / scale);
                worst[2] = worst[2].max(nodes.distance(contact) * world.dt() / scale);
            }
        }
        if scale > 1e-9 {
            touched += 1;
            worst[1] = worst[1].max((on_ball + from_ball).length() / scale);
        }
    }
    assert!(world.unstable().is_none(), "{name}");
    println!("{name}: {:.1e} {:.1e} {:.1e} in {touched} steps", worst[0], worst[1], worst[2]);
    (worst, touched)
}

#[test]
fn forces_of_implicit_sheets_balance_the_momentum_of_sheets_and_bodies() {
    let thrown = format!("({SHELL}, placement: (position: (0, 0.03, 0), rotation: (12, 0, 6)), velocity: (0.3, 0, 0))");
    let strip = r#"(structure: "shell", grid: (13, 1, 7), size: (0.12, 0.06), material: "hips",
        pins: [(region: Rect((0, 0.1), (0, 1)), body: "ball")])"#;
    let drum = r#"bodies: [(name: "ball", shape: Box((0.04, 0.06, 0.04)), mass: 0.1, spin: (0, 0, 10),
        placement: (position: (-0.081, 0, 0)))]"#;
    let still = "gravity: (0, 0, 0)";
    let two = format!(
        "({SHELL}), ({SHELL}, placement: (position: (0.02, 0.03, 0), rotation: (0, 20, 5)), velocity: (0, -1, 0))"
    );
    for engine in ["tr-bdf2", "bdf2", "backward-euler"] {
        for (name, rest, steps) in [
            ("thrown on a floor", format!("{ROOM}, sheets: [{thrown}]"), 120),
            ("struck by a ball", format!("{still}, sheets: [({SHELL})], {BALL}"), 60),
            ("struck by a sheet", format!("{still}, sheets: [{two}]"), 60),
            ("attached to a drum", format!("{still}, sheets: [{strip}], {drum}"), 60),
        ] {
            let name = format!("{name}, {engine}");
            let (worst, touched) = errors(&name, world(engine, 0.004, &rest), steps);
            assert!(touched > 1 && worst.iter().all(|e| *e < tolerance(&name)), "{name}: {worst:?}, {touched} steps");
        }
    }
}

#[test]
fn forces_of_explicit_sheets_balance_the_momentum_of_sheets_and_bodies() {
    let thrown = format!("({LATTICE}, placement: (position: (0, 0.02, 0), rotation: (12, 0, 6)))");
    let two = format!(
        "({LATTICE}), ({LATTICE}, placement: (position: (0.02, 0.04, 0), rotation: (0, 20, 5)), velocity: (0, -1, 0))"
    );
    let (still, ball) = ("gravity: (0, 0, 0)", BALL.replace("0.05, 0)", "0.08, 0)"));
    for engine in ["euler-cromer", "rk4", "verlet"] {
        for (name, rest, steps) in [
            ("thrown on a floor", format!("{ROOM}, sheets: [{thrown}]"), 2000),
            ("struck by a ball", format!("{still}, sheets: [({LATTICE})], {ball}"), 2000),
            ("struck by a sheet", format!("{still}, sheets: [{two}]"), 2000),
        ] {
            let name = format!("{name}, {engine}");
            let (worst, touched) = errors(&name, world(engine, 1e-4, &rest), steps);
            assert!(touched > 1 && worst.iter().all(|e| *e < tolerance(&name)), "{name}: {worst:?}, {touched} steps");
        }
    }
}

/// A sheet held at one edge, in equilibrium: the pins carry its weight, and node by node the sum.
#[test]
fn pins_carry_a_hanging_sheet_and_the_moment_of_its_weight() {
    let mut world =
        world("tr-bdf2", 0.01, &format!("sheets: [({SHELL}, damping_ratio: 1, pins: [(region: Left, clamp: true)])]"));
    world.set_sleep(false);
    world.advance(3.0);
    let sheet = &world.sheets()[0];
    let weight = sheet.total_mass() * 9.81;
    let pins: DVec3 = sheet.mean_forces().expect("recorded").1.iter().sum();
    assert!(pins.distance(DVec3::Y * weight) < 1e-6 * weight, "{pins} of {weight}");
    let entry = world.forces().iter().find(|e| e.partner == ForcePartner::Pin(0)).expect("an entry");
    assert!(entry.force.distance(pins) < 1e-9 * weight);
}

#[test]
fn bonds_and_contact_together_carry_a_sheet_below_a_plate() {
    let mut world = world(
        "tr-bdf2",
        1.0 / 60.0,
        r#"ambient_temperature: 120, sheets: [(structure: "shell", grid: (11, 1, 11), size: (0.1, 0.1), sticky: true,
            material: (young: 5e7, density: 1000, thickness: 5e-4, damping_ratio: 0.5,
                tack: Some((strength: 1000, above: 80))), placement: (position: (0, -0.00025, 0)))],
        bodies: [(name: "plate", shape: Box((0.3, 0.02, 0.3)), placement: (position: (0, 0.01, 0)))]"#,
    );
    world.set_sleep(false);
    world.set_gravity(DVec3::Y * 9.81).expect("in range");
    world.advance(0.3);
    world.set_gravity(DVec3::Y * -9.81).expect("in range");
    world.advance(1.0);
    let of_plate = |kind| {
        let entry = world.forces().iter().find(|e| e.kind == kind && world.partner_name(e) == Some("plate"));
        entry.expect("an entry").force.y
    };
    let (contact, bond) = (of_plate(ForceKind::Contact), of_plate(ForceKind::Bond));
    let weight = world.sheets()[0].total_mass() * 9.81;
    assert!(contact <= 0.0 && bond > weight, "{contact}, {bond}, {weight}");
    assert!((contact + bond - weight).abs() < 1e-4 * weight, "{contact} + {bond} is not {weight}");
}

#[test]
fn recording_changes_no_result_and_a_warm_step_allocates_nothing_more() {
    let text = format!(
        "(dt: 0.004, {ROOM}, sheets: [({SHELL}, pins: [(region: Left)], placement: (position: (0, 0.01, 0)))])"
    );
    let mut worlds = [world_of(&text), world_of(&text)];
    worlds[0].record_forces(true);
    let mut allocated = [0; 2];
    for (world, allocated) in worlds.iter_mut().zip(&mut allocated) {
        world.advance(0.5);
        *allocated = allocation_counter::measure(|| _ = world.advance(0.04)).count_total;
    }
    assert_eq!(state_hash(&worlds[0]), state_hash(&worlds[1]));
    assert_eq!(allocated[0], allocated[1]);
    assert!(worlds[1].forces().is_empty() && worlds[1].sheets()[0].mean_forces().is_none());
    assert_eq!(worlds[0].reset().map(|()| worlds[0].forces().len()), Ok(0));
    let scene = Scene::parse(&text).expect("valid");
    assert_eq!(World::new(&scene).expect("valid").report(0.0, &[]).forces, []);
}

/// Coulomb's law, Euler and Eytelwein's formula, and the weight.
#[test]
fn rigs_of_forces_agree_with_their_formulas() {
    let setup = Setup { grid: (11, 11), restitution: 0.0, ..Setup::default() };
    for (case, keys, tolerance) in [
        ("pull", &["pull_ratio", "friction_ratio", "support_ratio"][..], 0.01),
        ("capstan", &["pull_ratio"], 0.06),
        ("weight", &["recorded_floor_force_ratio"], 1e-3),
    ] {
        let found = measure(case, &setup).expect("it can be measured");
        println!("{found}");
        for key in keys {
            let ratio = found[*key].as_f64().expect("a number");
            assert!((ratio - 1.0).abs() < tolerance, "{case}: {key} {ratio}");
        }
    }
}
