//! Adhesion of lattices with explicit integrators, against weights and Coulomb's law by hand.

use glam::DVec3;
use sheetwork::World;
use sheetwork_tests::fracture::slip_angle;
use sheetwork_tests::{scenes_folder, state_hash, world_of};

/// A tenth of the Earth's gravity, m/s², as in the thesis's scenes.
const G: f64 = 0.981;
/// Step, s.
const STEP: f64 = 0.001;

/// A structure with its number of layers and the modulus (Pa) of its springs between layers.
type Layers = (&'static str, u32, f64);
const ONE_TRIMM: Layers = ("trimm", 1, 185.0);
const TRIMM: Layers = ("trimm", 2, 740.0);
const SLAMM: Layers = ("slamm", 2, 185.0);

/// The thesis's lattice at `position`, with adhesion of `strength` (Pa) and further fields.
fn sheet(name: &str, (structure, layers, modulus): Layers, strength: f64, position: &str, more: &str) -> String {
    let between = if layers > 1 { format!("inter_layer: SumModulus({modulus}),") } else { String::new() };
    format!(
        r#"(name: "{name}", structure: "{structure}", grid: (11, {layers}, 11), size: (0.025, 0.025), gap: 0.001,
            material: (young: 185, poisson: 0.3, density: 1000, thickness: 1e-3, expansion: 0,
                tack: (strength: {strength}, above: 80, lets_go_below: 60)),
            springs: Uniform, {between} node_mass: 4e-5, damping: 0.3, sticky: true,
            placement: (position: {position}), {more})"#
    )
}

/// Weight of a lattice per area, Pa: its own mass on 25 mm x 25 mm.
fn weight(layers: Layers) -> f64 {
    let world = scene("rk4", &[sheet("sheet", layers, 1.0, "(0, 0, 0)", "")], "", 0.0);
    world.sheets()[0].total_mass() * G / (0.025 * 0.025)
}

/// A scene in a room of 120 °C, with gravity upwards.
fn scene(engine: &str, sheets: &[String], bodies: &str, restitution: f64) -> World {
    let mut world = world_of(&format!(
        r#"(gravity: (0, {G}, 0), engine: "{engine}", dt: {STEP}, contact: (friction: 0.4, restitution: {restitution}),
            ambient_temperature: 120, air: (factor: 0.97, per: 0.015), sheets: [{}], bodies: [{bodies}])"#,
        sheets.join(", ")
    ));
    world.set_sleep(false);
    world
}

/// A plate with its underside at 0, and one with its upper side at 0.
const PLATE: &str = r#"(name: "plate", shape: Box((0.1, 0.02, 0.1)), placement: (position: (0, 0.01, 0)))"#;
const FLOOR: &str = r#"(name: "floor", shape: Box((0.1, 0.02, 0.1)), placement: (position: (0, -0.01, 0)))"#;

fn run(world: &mut World, seconds: f64) {
    (0..(seconds / STEP) as u32).for_each(|_| _ = world.step());
    assert!(world.unstable().is_none());
}

/// Turn gravity from `from` to `to` (m/s²) within two seconds.
fn turn(world: &mut World, from: DVec3, to: DVec3) {
    for step in 0..=2000 {
        world.set_gravity(from.lerp(to, f64::from(step) / 2000.0)).expect("in range");
        world.step();
    }
    assert!(world.unstable().is_none());
}

/// Press the sheets upwards for half a second, then let them hang.
fn hang(world: &mut World) {
    run(world, 0.5);
    turn(world, DVec3::Y * G, DVec3::NEG_Y * G);
}

/// Lowest and highest node of a sheet, m.
fn heights(world: &World, sheet: usize) -> (f64, f64) {
    let heights = world.sheets()[sheet].state.x.iter().map(|p| p.y);
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)))
}

#[test]
fn a_lattice_hangs_from_a_hot_plate_if_adhesion_exceeds_its_weight() {
    // The lower layer of two reaches half a cell beyond the upper one: a corner node of slamm
    // carries 3.25 nodes, with a mean of 2.21.
    for (layers, falls, holds) in [(ONE_TRIMM, 0.95, 1.05), (SLAMM, 0.95, 1.3), (TRIMM, 0.95, 1.4)] {
        let (weight, place) = (weight(layers), if layers.1 > 1 { "(0, -0.0012, 0)" } else { "(0, -0.0005, 0)" });
        for engine in ["rk4", "euler-cromer"] {
            for factor in [0.5, falls, holds, 2.0] {
                let sheet = sheet("sheet", layers, factor * weight, place, "");
                let mut world = scene(engine, &[sheet], PLATE, 0.0);
                hang(&mut world);
                run(&mut world, 1.0);
                let ((low, high), bonds) = (heights(&world, 0), world.sheets()[0].bonds());
                let (low, high) = (1e3 * low, 1e3 * high);
                println!("{layers:?}, {engine}, σ = {factor} ρ t g: {low:.3} to {high:.3} mm, {bonds} bonds");
                if factor > 1.0 {
                    assert!(low > -1.8 && high > -0.02 && bonds >= 121, "{layers:?}, {engine}, {factor}");
                } else {
                    assert!(high < -100.0 && bonds == 0, "{layers:?}, {engine}, {factor}");
                }
            }
        }
    }
}

#[test]
fn bonds_of_a_lattice_release_below_the_release_temperature() {
    for (celsius, hangs) in [(70.0, true), (50.0, false)] {
        let sheet = sheet("sheet", SLAMM, 2.0 * weight(SLAMM), "(0, -0.0012, 0)", "");
        let mut world = scene("rk4", &[sheet], PLATE, 0.0);
        hang(&mut world);
        assert_eq!(world.sheets()[0].bonds(), 132);
        world.set("ambient_temperature", &celsius.to_string()).expect("a room");
        world.sheets_mut()[0].set_temperatures(|_| celsius).expect("in range");
        run(&mut world, 1.0);
        let (low, _) = heights(&world, 0);
        println!("at {celsius} °C: {:.3} mm, {} bonds", 1e3 * low, world.sheets()[0].bonds());
        assert_eq!(low > -2e-3, hangs, "at {celsius} °C");
    }
}

#[test]
fn friction_of_a_lattice_on_an_incline_includes_adhesion() {
    // m g sin θ = μ (m g cos θ + σ A) with σ = s ρ t g.
    let friction = 0.4;
    for share in [0.0_f64, 0.5, 1.5] {
        let slips_at = slip_angle(friction, share);
        for engine in ["rk4", "euler-cromer"] {
            for factor in [0.97, 1.03] {
                let angle = slips_at * factor;
                let strength = (share * weight(ONE_TRIMM)).max(1e-3);
                let sheet = sheet("sheet", ONE_TRIMM, strength, "(0, 0.0001, 0)", "");
                let mut world = scene(engine, &[sheet], FLOOR, 0.0);
                let (down, slope) = (DVec3::NEG_Y * G, DVec3::new(angle.sin(), -angle.cos(), 0.0) * G);
                world.set_gravity(down).expect("in range");
                run(&mut world, 0.5);
                turn(&mut world, down, slope);
                let from = world.sheets()[0].centre_of_mass().x;
                run(&mut world, 0.5);
                let gone = world.sheets()[0].centre_of_mass().x - from;
                println!(
                    "{engine}: σ = {share} ρ t g at {factor} of {:.2}°: {gone:.3e} m in 0.5 s",
                    slips_at.to_degrees()
                );
                assert_eq!(gone > 1e-3, factor > 1.0, "{engine}, σ = {share} ρ t g at {factor} of the angle");
                assert!(factor > 1.0 || gone.abs() < 1e-6, "it creeps: {gone} m");
            }
        }
    }
}

#[test]
fn a_lattice_hangs_from_another() {
    let weight = weight(SLAMM);
    for (factor, hangs) in [(0.5, false), (0.9, false), (2.0, true), (4.0, true)] {
        let upper = sheet("upper", SLAMM, factor * weight, "(0, 0, 0)", "pins: [(region: All)]");
        let lower = sheet("lower", SLAMM, factor * weight, "(0, -0.0015, 0)", "");
        let mut world = scene("rk4", &[upper, lower], "", 0.0);
        hang(&mut world);
        run(&mut world, 1.0);
        let ((low, high), bonds) = (heights(&world, 1), [0, 1].map(|i| world.sheets()[i].bonds()));
        println!("two, σ = {factor} ρ t g: {:.3} to {:.3} mm, {bonds:?} bonds", 1e3 * low, 1e3 * high);
        assert_eq!(low > -2e-3, hangs, "{factor}");
    }
}

#[test]
fn hot_lattices_that_fall_on_a_hot_floor_and_on_each_other_stick() {
    // With rebound; afterwards gravity is turned upwards, and only adhesion holds the sheets.
    for sticky in [true, false] {
        let strength = if sticky { 5.0 * weight(SLAMM) } else { 1e-3 };
        let lower = sheet("lower", SLAMM, strength, "(0, 0.004, 0)", "");
        let upper = sheet("upper", SLAMM, strength, "(0.001, 0.008, 0.001)", "");
        let mut world = scene("rk4", &[lower, upper], FLOOR, 0.3);
        world.set_gravity(DVec3::NEG_Y * G).expect("in range");
        run(&mut world, 1.5);
        turn(&mut world, DVec3::NEG_Y * G, DVec3::Y * G);
        run(&mut world, 0.7);
        let ends = [0, 1].map(|i| heights(&world, i));
        println!("sticky {sticky}: {ends:?}, bonds {:?}", [0, 1].map(|i| world.sheets()[i].bonds()));
        assert_eq!(ends.iter().all(|(_, high)| *high < 5e-3), sticky, "{ends:?}");
        assert_eq!(ends.iter().all(|(low, _)| *low > 5e-2), !sticky, "{ends:?}");
    }
}

#[test]
fn a_box_hangs_from_a_hot_lattice_and_pulls_it_down() {
    // The soft lattice is held at its border and bows, so that the box hangs from the middle node:
    // 1 g against σ A of a node is 190 Pa.
    let hangs = |strength: f64| {
        let upper = sheet("upper", SLAMM, strength, "(0, 0, 0)", "pins: [(region: Border)]");
        let body =
            r#"(name: "box", shape: Box((0.012, 0.004, 0.012)), mass: 1e-3, placement: (position: (0, -0.0022, 0)))"#;
        let mut world = scene("rk4", &[upper], body, 0.0);
        world.set_gravity(DVec3::Y * (0.2 * G)).expect("in range");
        run(&mut world, 0.5);
        turn(&mut world, DVec3::Y * (0.2 * G), DVec3::NEG_Y * G);
        run(&mut world, 0.7);
        let y = world.body_state("box").expect("there").origin().y;
        println!("σ = {strength} Pa: the box at {:.3} mm, {} bonds", 1e3 * y, world.sheets()[0].bonds());
        (y, world.sheets()[0].centre_of_mass().y)
    };
    let (held, fell) = (hangs(400.0), hangs(2.0));
    assert!(held.0 > -0.02 && fell.0 < -0.1, "{held:?} {fell:?}");
    assert!(held.1 < fell.1 - 1e-5, "the sheet hangs lower with it: {held:?} {fell:?}");
}

#[test]
fn adhesion_of_lattices_is_bit_identical_on_any_number_of_threads_and_from_a_snapshot() {
    let start = |threads: usize| {
        let strength = 4.0 * weight(SLAMM);
        let upper = sheet("upper", SLAMM, strength, "(0, -0.0012, 0)", "");
        let lower = sheet("lower", SLAMM, strength, "(0, -0.0027, 0)", "");
        let mut world = scene("rk4", &[upper, lower], PLATE, 0.1);
        world.set_threads(threads).expect("threads");
        run(&mut world, 0.7);
        world
    };
    let mut one = start(1);
    assert_eq!(state_hash(&one), state_hash(&start(2)));
    let snapshot = one.snapshot();
    turn(&mut one, DVec3::Y * G, DVec3::NEG_Y * G);
    let (bonds, end) = ([0, 1].map(|i| one.sheets()[i].bonds()), state_hash(&one));
    one.restore(&snapshot).expect("its own");
    turn(&mut one, DVec3::Y * G, DVec3::NEG_Y * G);
    println!("{bonds:?} bonds {:?} {:?}", heights(&one, 0), heights(&one, 1));
    assert!(bonds.iter().all(|b| *b > 50), "{bonds:?}");
    assert_eq!(([0, 1].map(|i| one.sheets()[i].bonds()), state_hash(&one)), (bonds, end));
}

#[test]
fn strong_adhesion_adds_no_energy() {
    // Up to 600 times the weight of a sheet, and 50 times the modulus of its springs.
    let polyhedra = scenes_folder().join("../polyhedra").display().to_string();
    let scene = std::fs::read_to_string(scenes_folder().join("sticky_wedge.ron")).expect("a scene");
    for (strength, step, engine, most) in [
        (500.0, 0.005, "euler-richardson", 0.001),
        (2e3, 0.005, "euler-richardson", 0.002),
        (2e3, 0.005, "rk4", 0.002),
        (1e4, 0.005, "rk4", 0.15),
        (1e4, 0.001, "rk4", 0.05),
    ] {
        let text = scene
            .replace("../polyhedra", &polyhedra)
            .replace("strength: 60", &format!("strength: {strength}"))
            .replace("dt: 0.005", &format!("dt: {step}"))
            .replace("euler-richardson", engine);
        let mut world = world_of(&text);
        let start = world.energy().total;
        let (mut least, mut rise) = (start, 0.0_f64);
        for _ in 0..(1.5 / step) as u32 {
            world.step();
            let total = world.energy().total;
            least = least.min(total);
            rise = rise.max(total - least);
        }
        let (fallen, kinetic) = (start - world.energy().total, world.energy().kinetic);
        println!("{strength} Pa, {step} s, {engine}: rises by {rise:.1e} of {fallen:.1e} J, kinetic {kinetic:.1e}");
        assert!(world.unstable().is_none());
        assert!(rise < most * fallen && kinetic < 0.02 * fallen, "{strength} Pa, {step} s, {engine}");
    }
}

#[test]
fn bonds_of_lattices_conserve_momentum_and_add_no_energy() {
    // Two lattices without gravity and air; then one with a box, heavy and light.
    let text = |engine: &str, other: &str| {
        let upper = sheet("upper", SLAMM, 2e3, "(0, 0, 0)", "");
        format!(
            r#"(gravity: (0, 0, 0), engine: "{engine}", dt: 0.002, contact: (friction: 0.4, restitution: 0.1),
                ambient_temperature: 120, sheets: [{upper}, {other})"#
        )
    };
    let lower = sheet("lower", SLAMM, 2e3, "(0.001, -0.0016, 0.001)", "velocity: (0.02, 0.05, 0.01)");
    let a_box = |mass: f64| {
        format!(
            r#"], bodies: [(name: "box", shape: Box((0.012, 0.004, 0.012)), mass: {mass}, velocity: (0.02, 0.05, 0.01),
                placement: (position: (0.001, -0.003, 0.001)))]"#
        )
    };
    let momentum = |world: &World| {
        let sheets: DVec3 = world.sheets().iter().map(sheetwork::sheet::Sheet::momentum).sum();
        sheets + world.body_state("box").map_or(DVec3::ZERO, |body| body.momentum())
    };
    for engine in ["euler", "euler-cromer", "euler-richardson", "verlet", "rk4", "rk45", "analytical"] {
        for (what, other) in
            [("a sheet", format!("{lower}]")), ("a box of 1 g", a_box(1e-3)), ("a box of 0.1 g", a_box(1e-4))]
        {
            let mut world = world_of(&text(engine, &other));
            world.set_sleep(false);
            let start = momentum(&world);
            let (mut least, mut rise) = (world.energy().total, 0.0_f64);
            let first = least;
            for _ in 0..250 {
                world.step();
                let change = (momentum(&world) - start).length();
                assert!(change < 1e-6 * start.length(), "{engine}, {what} at {}: {change} of {start}", world.time());
                let total = world.energy().total;
                least = least.min(total);
                rise = rise.max(total - least);
            }
            let bonds: usize = world.sheets().iter().map(|sheet| sheet.bonds()).sum();
            println!("{engine}, {what}: {bonds} bonds, {least:.1e} of {first:.1e} J, rises by {rise:.1e}");
            assert!(bonds > 10 && world.unstable().is_none(), "{engine}, {what}: {bonds}");
            assert!(rise < 0.02 * first, "{engine}, {what}: {rise} of {first}");
        }
    }
}
