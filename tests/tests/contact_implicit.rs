//! Contact of stiff sheets with implicit integrators at 60 Hz: the virtual rigs against closed
//! forms, and against documented bounds on penetration, energy and rest. The default sheet is 0.25
//! m square, 0.5 mm thick, 3 GPa, 1050 kg/m³.

use glam::DVec3;
use serde_json::Value;
use sheetwork::World;
use sheetwork::collision::overlap::between;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{Material, Scene};
use sheetwork::sheet::Status;
use sheetwork_rigs::measure::Setup;
use sheetwork_rigs::measure::drops::throw;
use sheetwork_tests::rig::{measured, number};
use sheetwork_tests::{shipped_scene, world, world_of};

/// Tolerance of the energy rise over the start, relative to the energy of the situation: rounding.
const ENERGY: f64 = 1e-9;

/// The default sheet without restitution.
fn setup_without_restitution() -> Setup {
    Setup { restitution: 0.0, ..Setup::default() }
}

/// Kelvin-Voigt damping ratio with which a sheet ceases to rock within two seconds.
const RESTING: f64 = 0.2;

fn drops_on_a_box(grid: u32, young: f64) -> Value {
    let base = setup_without_restitution();
    let setup = Setup {
        grid: (grid, grid),
        material: Material { young, ..base.material.clone() },
        height: 0.05,
        box_side: 0.1,
        friction: 0.3,
        damping_ratio: RESTING,
        ..base
    };
    let found = measured("drop-box", &setup);
    println!(
        "{grid}x{grid}, {young:.0e} Pa: {:.1e} m deep, at rest {}, gain {:.1e}, corner {:.5} m below",
        number(&found, "max_penetration_m"),
        found["at_rest_s"],
        number(&found, "energy_gain"),
        number(&found, "corner_below_centre_m")
    );
    assert!(number(&found, "max_penetration_m") < 1e-4, "{grid}, {young}: {found}");
    assert!(number(&found, "at_rest_s") < 2.0, "{grid}, {young}: {found}");
    assert!(number(&found, "energy_gain") <= ENERGY, "{grid}, {young}: {found}");
    found
}

#[test]
fn a_stiff_sheet_comes_to_rest_on_a_box_bent_by_its_overhang() {
    for grid in [11, 21] {
        drops_on_a_box(grid, 3e9);
    }
}

#[test]
fn sheets_from_300_mpa_to_steel_come_to_rest_on_a_box() {
    for grid in [11, 21] {
        for young in [3e8, 3e10, 2e11] {
            drops_on_a_box(grid, young);
        }
    }
}

/// The broad phase must include the thickness for every step and gravity.
#[test]
fn a_thick_plate_rests_on_a_box_in_any_step_and_gravity() {
    for (thickness, dt, gravity) in [(0.01, None, 9.81), (0.004, Some(1e-3), 9.81), (0.004, None, 0.1)] {
        let material = Material { thickness, ..Setup::default().material };
        let setup = Setup { grid: (11, 11), height: 0.005, material, dt, gravity, ..Setup::default() };
        let found = measured("drop-box", &setup);
        let what = format!("{thickness} m, {dt:?}, {gravity} m/s²: {found}");
        assert!(number(&found, "max_penetration_m") < 1e-5 && number(&found, "energy_gain") < 1e-9, "{what}");
        assert!(number(&found, "at_rest_s") < 1.0, "{what}");
    }
}

/// Restitution and friction of the landings.
const COEFFICIENTS: [(f64, f64); 3] = [(0.0, 0.1), (0.4, 0.5), (0.8, 1.0)];

fn lands(corner: bool) {
    for angle in [17.0, 30.0, 45.0] {
        for (restitution, friction) in COEFFICIENTS {
            let setup = Setup { angle, height: 1.0, restitution, friction, corner, ..Setup::default() };
            let found = measured("edge-landing", &setup);
            let (masses, surface) = (number(&found, "max_mass_penetration_m"), number(&found, "max_penetration_m"));
            let gain = number(&found, "energy_gain");
            println!("{angle}°, e {restitution}, μ {friction}: {masses:.1e} and {surface:.1e} m deep, gain {gain:.1e}");
            assert!(masses < 5e-5 && surface < 1e-4, "{angle}°, e {restitution}, μ {friction}: {found}");
            assert!(gain <= ENERGY, "{angle}°, e {restitution}, μ {friction}: {found}");
            assert!(found["rebound_speed_m_s"].is_f64(), "{found}");
        }
    }
}

#[test]
fn a_landing_on_an_edge_neither_penetrates_nor_gains_energy() {
    lands(false);
}

#[test]
fn a_landing_on_a_corner_neither_penetrates_nor_gains_energy() {
    lands(true);
}

#[test]
fn a_flat_drop_keeps_e_squared_of_its_energy() {
    for (height, restitution) in [(0.2, 0.5), (0.5, 0.8), (0.1, 0.3)] {
        let setup = Setup { height, restitution, ..Setup::default() };
        let ratio = number(&measured("bounce", &setup), "energy_ratio");
        let wanted = restitution * restitution;
        println!("from {height} m with {restitution}: {ratio:.5} against {wanted:.5}");
        assert!((ratio / wanted - 1.0).abs() < 0.01, "{height}, {restitution}: {ratio}");
    }
    for height in [0.05, 0.5] {
        let found = measured("bounce", &Setup { height, ..setup_without_restitution() });
        assert!(number(&found, "rebound_ratio") < 0.01, "{height}: {found}");
    }
}

#[test]
fn a_sticking_sheet_does_not_creep_and_a_slipping_one_has_g_sin_minus_mu_cos() {
    for angle in [10.0_f64, 20.0, 35.0] {
        let limit = angle.to_radians().tan();
        for (factor, slides) in [(2.0, false), (1.005, false), (0.995, true), (0.5, true), (0.0, true)] {
            let friction = factor * limit;
            let found = measured("incline", &Setup { angle, friction, ..setup_without_restitution() });
            assert_eq!(found["slid"], slides, "{angle}°, {factor} of the limit: {found}");
            if slides {
                let (got, wanted) = (number(&found, "acceleration_m_s2"), number(&found, "expected_acceleration_m_s2"));
                println!("{angle}°, {factor} of the limit: {got:.6} against {wanted:.6} m/s²");
                assert!((got / wanted - 1.0).abs() < 0.005, "{angle}°, {factor}: {found}");
            } else {
                assert!(number(&found, "creep_m_s") < 1e-5, "{angle}°, {factor}: {found}");
                assert_eq!(number(&found, "creep_asleep_m_s"), 0.0, "{angle}°, {factor}: {found}");
            }
        }
    }
}

#[test]
fn a_sliding_sheet_stops_after_v_squared_over_two_mu_g() {
    for (speed, friction) in [(1.0, 0.3), (2.0, 0.8), (0.5, 0.1)] {
        let found = measured("slide", &Setup { speed, friction, ..setup_without_restitution() });
        let (got, wanted) = (number(&found, "distance_m"), speed * speed / (2.0 * friction * 9.81));
        println!("{speed} m/s, μ {friction}: {got:.6} against {wanted:.6} m");
        assert!((got / wanted - 1.0).abs() < 0.005, "{speed}, {friction}: {found}");
    }
}

/// Frictionless contact must not catch at mesh lines of the sheet below.
#[test]
fn a_frictionless_card_slides_over_another_as_over_a_plane() {
    let mut world = world_of(
        r#"(engine: "tr-bdf2", dt: 0.0166666666666667, contact: (friction: 0, restitution: 0),
        sheets: [(name: "under", structure: "shell", grid: (13, 1, 9), size: (0.3, 0.2), material: "card", pins: [(region: All)]),
            (name: "over", structure: "shell", grid: (9, 1, 7), size: (0.1, 0.07), material: "card", velocity: (0.3, 0, 0),
                placement: (position: (-0.09, 0.0006, 0.003), rotation: (0, 12, 0)))])"#,
    );
    let start = world.sheets()[1].centre_of_mass();
    world.advance(0.5);
    let gone = world.sheets()[1].centre_of_mass() - start;
    assert!((gone.x / 0.15 - 1.0).abs() < 0.01 && gone.z.abs() < 1e-3, "{gone} for 0.15 m");
}

#[test]
fn supports_carry_the_weight() {
    let engines = [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::Bdf2];
    for (engine, dt) in engines.into_iter().flat_map(|engine| [(engine, None), (engine, Some(1.0 / 240.0))]) {
        let found = measured("weight", &Setup { engine, dt, ..setup_without_restitution() });
        for key in ["floor_force_ratio", "box_force_ratio", "held_edges_force_ratio", "support_force_ratio"] {
            assert!((number(&found, key) - 1.0).abs() < 1e-3, "{key}: {found}");
        }
    }
}

/// Under refinement of grid and step `tr-bdf2` converges to 2.02 mm.
#[test]
fn the_overhang_on_a_box_is_equal_with_every_implicit_integrator() {
    for engine in [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::Bdf2] {
        let found = measured(
            "drop-box",
            &Setup { engine, height: 0.05, box_side: 0.1, friction: 0.3, ..setup_without_restitution() },
        );
        let corner = number(&found, "corner_below_centre_m");
        println!("{}: {corner:.6} m", engine.name());
        assert!((corner / 2.02e-3 - 1.0).abs() < 0.01, "{}: {found}", engine.name());
        assert!(number(&found, "at_rest_s") < 2.0 && number(&found, "energy_gain") <= ENERGY, "{found}");
    }
}

#[test]
fn impacts_on_a_sheet_conserve_momentum() {
    let all = [(0.0, 0.0), (0.5, 0.3), (0.8, 1.0)];
    for (on_sheet, (restitution, friction)) in [false, true].into_iter().flat_map(|s| all.map(|c| (s, c))) {
        let found = measured("impact", &Setup { restitution, friction, on_sheet, ..Setup::default() });
        assert_eq!(found["met"], true, "{found}");
        assert!(number(&found, "momentum_error") < 1e-9, "{restitution}, {friction}: {found}");
        assert!(number(&found, "energy_gain") <= ENERGY, "{restitution}, {friction}: {found}");
    }
}

#[test]
fn no_random_drop_is_unstable_or_passes_through() {
    // The first dozen, and draws with folds, slides over corners and past rims, needles, and the
    // edge of a wedge.
    for index in (0..12).chain([83, 146, 155, 167, 175, 206, 208, 214, 266, 428, 742, 833, 971]) {
        let drop = throw(0, index, IntegratorKind::TrBdf2).expect("a valid draw");
        assert!(drop.unstable.is_none() && drop.through.is_none() && drop.penetration < 1e-4, "{drop:?}");
        assert!(drop.energy_ratio < 1.0 + 1e-6, "{drop:?}");
    }
    // A few with the other integrators, and two hard ones: a box that passes within a step, and
    // contradictory contacts.
    let others = [(IntegratorKind::BackwardEuler, 1222), (IntegratorKind::Bdf2, 1097)];
    let few =
        [IntegratorKind::BackwardEuler, IntegratorKind::Bdf2].into_iter().flat_map(|e| (12..16).map(move |i| (e, i)));
    for (engine, index) in few.chain(others) {
        let drop = throw(0, index, engine).expect("a valid draw");
        assert!(
            drop.unstable.is_none() && drop.through.is_none() && drop.penetration < 1e-4,
            "{}: {drop:?}",
            engine.name()
        );
        assert!(drop.energy_ratio < 1.0 + 1e-6, "{}: {drop:?}", engine.name());
    }
}

fn run_scene(name: &str) -> World {
    let scene = shipped_scene(name);
    let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    while world.time() < scene.duration {
        world.step();
    }
    assert!(world.unstable().is_none(), "{name}");
    world
}

fn place(world: &World, body: &str) -> DVec3 {
    world.body_state(body).unwrap_or_else(|| panic!("no {body}")).centre()
}

#[test]
fn a_box_bends_the_sheet_it_rests_on_as_a_beam_bends() {
    // Twice the thickness of the scene's sheet, so that the sag is small against the span.
    let thickness = 1e-3;
    let scene =
        shipped_scene("box_on_sheet").with_override("sheets.sheet.material.thickness", "1e-3").expect("a thickness");
    let scene = scene.with_override("bodies.box.placement.position.1", "0.01555").expect("a height");
    let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    while world.time() < scene.duration {
        world.step();
    }
    let sheet = &world.sheets()[0];
    let (length, width, box_side, gravity) = (0.25_f64, 0.15, 0.05, 9.81);
    // The sheet curves away under the box, which rests on two of its edges: four-point bending
    // (Gere and Timoshenko) plus 5 q L⁴/384 EI.
    let load = 0.02 * gravity;
    let line = sheet.material().density * thickness * width * gravity;
    let reach = 0.5 * (length - box_side);
    let sag = |stiffness: f64| {
        load * reach * (3.0 * length * length - 4.0 * reach * reach) / (48.0 * stiffness)
            + 5.0 * line * length.powi(4) / (384.0 * stiffness)
    };
    let (beam, plate) =
        (sheet.material().young * thickness.powi(3) / 12.0 * width, sheet.material().plate_stiffness() * width);
    let middle = sheet.probes.iter().find(|p| p.name == "middle").expect("a probe").at(&sheet.state.x).y;
    println!("sag {} m, a beam's {} and a plate's {}", -middle, sag(beam), sag(plate));
    // Between a narrow beam and one without anticlastic curvature, and a few percent for the rise
    // of the ends.
    assert!(-middle > 0.97 * sag(plate) && -middle < 1.03 * sag(beam), "{middle}");
    let rest = place(&world, "box");
    assert!(rest.with_y(0.0).length() < 1e-3, "{rest}");
}

/// A body that cannot reach a nearby sheet in the step moves as it would without the sheet.
#[test]
fn a_ball_above_a_fixed_sheet_falls_freely_until_contact() {
    let scene = |depth: f64| {
        let text = format!(
            r#"(engine: "tr-bdf2", dt: 0.016666666666666666,
                sheets: [(structure: "shell", grid: (11, 1, 11), size: (0.2, 0.2), material: "rubber",
                    placement: (position: (0, {depth}, 0)), pins: [(region: Border)])],
                bodies: [(name: "ball", shape: Ball(0.015), mass: 0.02, placement: (position: (0.01, 0.06, 0)))])"#
        );
        Scene::parse(&text).expect("valid")
    };
    let (mut near, mut far) = (world(&scene(0.0)), world(&scene(-9.0)));
    let meets = |world: &World| !world.events().is_empty();
    while !meets(&near) {
        assert!(place(&near, "ball").distance(place(&far, "ball")) < 1e-12, "{} s", near.time());
        assert!(near.time() < 0.2, "the ball is at {}", place(&near, "ball"));
        near.step();
        far.step();
    }
    // The free fall of 45 mm takes √(2 · 45 mm / g) = 0.096 s.
    assert!((near.time() - 0.096).abs() < 0.02, "{}", near.time());
}

/// Side edges of the triangles ahead must not act as obstacles with oblique normals.
#[test]
fn a_ball_slides_along_a_flat_sheet_at_any_speed_and_friction_makes_it_roll() {
    for (speed, friction, end) in
        [(1.0, 0.0, 1.0), (2.0, 0.0, 2.0), (3.0, 0.0, 3.0), (20.0, 0.0, 20.0), (3.0, 0.3, 15.0 / 7.0)]
    {
        let text = format!(
            r#"(engine: "tr-bdf2", dt: 0.016666666666666666, contact: (friction: {friction}, restitution: 0),
                sheets: [(structure: "shell", grid: (401, 1, 5), size: (8, 0.08), material: "hips", pins: [(region: All)])],
                bodies: [(name: "ball", shape: Ball(0.012), density: 1000, velocity: ({speed}, 0, 0),
                    placement: (position: (-3.9, 0.01255, 0)))])"#
        );
        let mut world = world(&Scene::parse(&text).expect("valid"));
        let mut up = 0.0_f64;
        for _ in 0..22 {
            world.step();
            up = up.max(world.body_state("ball").expect("a ball").velocity().y);
        }
        let along = world.body_state("ball").expect("a ball").velocity().x;
        assert!(up < 0.05 && (along / end - 1.0).abs() < 0.01, "{speed} {friction}: {up} up, {along} along");
    }
}

/// A contact that opens within the step in which it closed counts as contact.
#[test]
fn a_bounce_within_a_step_counts_as_contact() {
    let setup = Setup { height: 0.5, restitution: 0.8, ..Setup::default() };
    let found = measured("bounce", &setup);
    assert!(number(&found, "contacts") >= 441.0, "{found}");
    assert!((number(&found, "rebound_ratio") - 0.64).abs() < 0.0064, "{found}");
    assert_eq!(measured("impact", &Setup { speed: 20.0, ..Setup::default() })["met"], true);
}

/// A sheet of 0.2 m at `height` (m) on a floor, under these bodies.
fn on_the_floor(material: &str, height: f64, bodies: &str) -> World {
    let text = format!(
        r#"(engine: "tr-bdf2", dt: 0.016666666666666666, contact: (friction: 0.3, restitution: 0),
            room: (x: (-1, 1), y: (0, 0.3), z: (-0.25, 0.25), back_wall: false),
            sheets: [(structure: "shell", grid: (21, 1, 21), size: (0.2, 0.2), material: "{material}",
                placement: (position: (0, {height}, 0)))],
            bodies: [{bodies}])"#
    );
    let mut world = world(&Scene::parse(&text).expect("valid"));
    world.set_sleep(true);
    world
}

/// In the rotating frame of the ball the contact point of the floor moves up its back; the floor
/// must not rotate the ball further.
#[test]
fn a_ball_that_rolls_off_a_sheet_gains_only_potential_energy() {
    let ball = r#"(name: "ball", shape: Ball(0.01), mass: 0.033, velocity: (-0.04, 0, 0), placement: (position: (-0.08, 0.0101, 0.02)))"#;
    let mut world = on_the_floor("paper", 5e-5, ball);
    let speed = |world: &World| world.body_state("ball").expect("there").velocity().with_y(0.0).length();
    let mut rolls = 0.0;
    while world.time() < 2.0 {
        world.step();
        let at = place(&world, "ball");
        assert!(at.y > 0.01 - 2e-4, "{at} at {} s", world.time());
        if at.x > -0.098 && world.time() > 0.1 {
            rolls = speed(&world);
            // Two sevenths of the initial speed change into spin; the rolling friction of the
            // contact patch takes 5/7 of 5e-4 g.
            let wanted = 0.04 / 1.4 - 5.0 / 7.0 * 5e-4 * 9.81 * world.time();
            assert!((rolls - wanted).abs() < 5e-4, "{rolls} m/s at {} s", world.time());
        }
    }
    assert!(place(&world, "ball").x < -0.11, "{}", place(&world, "ball"));
    // A descent of 0.1 mm: m g h = 7/10 m v².
    let most = (rolls * rolls + 9.81 * 1e-4 / 0.7).sqrt();
    assert!(speed(&world) < 1.02 * most, "{} m/s, {most} at most", speed(&world));
}

/// A sheet whose mid-surface is placed on the floor starts half of its thickness in the floor.
/// Depenetration must not add energy.
#[test]
fn depenetration_of_a_sheet_under_a_box_adds_no_energy() {
    for height in [2e-4, 1e-4] {
        let cube =
            "(name: \"box\", shape: Box((0.05, 0.05, 0.05)), mass: 0.1, placement: (position: (0.01, 0.0257, 0.01)))";
        let mut world = on_the_floor("hips", height, cube);
        world.advance(2.0);
        assert!(world.sheets()[0].state.status == Status::Asleep, "{height}");
        let work = world.contact_counters(0);
        assert!(work.halved < 40 && world.unstable().is_none(), "{height}: {work:?}");
        assert!(place(&world, "box").y > 0.0254, "{height}: {}", place(&world, "box"));
    }
}

/// Triangles beside the contact point of a ball have oblique normals; they must not push it
/// sideways.
#[test]
fn a_ball_and_a_box_on_a_sheet_stay_in_place_and_sleep() {
    let bodies = |ball: DVec3, other: &str| {
        let DVec3 { x, y, z } = ball;
        format!("(name: \"ball\", shape: Ball(0.01), mass: 0.033, placement: (position: ({x}, {y}, {z}))), {other}")
    };
    let cube =
        |y: f64| format!("(shape: Box((0.05, 0.05, 0.05)), mass: 0.1, placement: (position: (0.01, {y}, 0.01)))");
    let second = "(shape: Ball(0.01), mass: 0.033, placement: (position: (0.043, 0.0102, -0.034)))";
    let cases = [
        ("paper", 1e-4, DVec3::new(-0.06, 0.05, 0.02), cube(0.0255)),
        ("paper", 1e-4, DVec3::new(-0.0537, 0.0102, 0.0234), cube(0.0255)),
        ("hips", 3e-4, DVec3::new(-0.06, 0.05, 0.02), cube(0.026)),
        ("paper", 1e-4, DVec3::new(-0.06, 0.0102, 0.02), second.to_owned()),
    ];
    for (material, height, at, other) in cases {
        let mut world = on_the_floor(material, height, &bodies(at, &other));
        while world.time() < 2.0 {
            world.step();
            let now = place(&world, "ball");
            assert!((now - at).with_y(0.0).length() < 1e-4, "{material}, {other}: {now} at {} s", world.time());
        }
        assert_eq!(world.sheets()[0].state.status, Status::Asleep, "{material}, {other}");
        assert!(world.rigid().is_some_and(|r| r.all_asleep()), "{material}, {other}");
    }
}

/// A kinematic body that moves into a fixed sheet strains it without bound. The self-contact search
/// must not degenerate to all pairs of triangles.
#[test]
fn a_kinematic_body_in_a_fixed_sheet_does_not_test_all_pairs() {
    let scene = Scene::parse(
        r#"(
            engine: "tr-bdf2", dt: 0.016666666666666666, duration: 0.5,
            sheets: [(structure: "shell", grid: (21, 1, 21), size: (0.2, 0.2), material: "card",
                placement: (position: (0.02, 0.083, 0.01)), pins: [(region: Masses([215]))])],
            bodies: [(shape: Box((0.08, 0.08, 0.08)), placement: (position: (0, 0.04, 0)),
                path: [(time: 0.3), (time: 0.32, offset: (0, 0.014, 0)), (time: 10, offset: (0, 0.014, 0))])],
        )"#,
    )
    .expect("valid");
    let mut world = world(&scene);
    while world.time() < scene.duration {
        world.step();
    }
    assert!(world.unstable().is_none());
    let report = world.report(0.0, &[]);
    let (looked, rounds) = (report.sheets[0].detection.self_tests, report.sheets[0].contact_work.rounds);
    println!("{looked} pairs of triangles in {rounds} rounds");
    // 800 triangles make 320,000 pairs.
    assert!(rounds > 30 && looked < 10_000 * rounds, "{looked} pairs of triangles in {rounds} rounds");
}

/// A card of three metres in a house of cards interpenetrates others and the floor without a
/// solution.
#[test]
fn a_step_without_contact_solution_falls_back() {
    let mut scene = shipped_scene("cards_house");
    scene.sheets[14].size.0 = 3.0;
    let mut world = World::with_start_overlaps(&scene).expect("a world");
    world.set_sleep(false);
    world.step();
    let factors: u64 = world.report(0.0, &[]).sheets.iter().map(|s| s.contact_work.factors).sum();
    println!("{factors} factors");
    assert!((100..10_000).contains(&factors), "{factors}");
    assert!(world.sheets().iter().all(|s| s.state.x.iter().all(|p| p.is_finite())));
}

#[test]
fn a_falling_sheet_tips_a_row_of_dominoes() {
    let world = run_scene("domino");
    for n in 1..=8 {
        let state = world.body_state(&format!("domino {n}")).unwrap_or_else(|| panic!("no domino {n}"));
        let up = state.rotation() * DVec3::Y;
        assert!(up.y < 0.8, "domino {n} stands: {up}");
        // Half the size of a domino: 8 x 48 x 24 mm.
        let half = DVec3::new(0.004, 0.024, 0.012);
        let corners = (0..8).map(|k| half * DVec3::from([1, 2, 4].map(|bit| if k & bit == 0 { -1.0 } else { 1.0 })));
        let lowest = corners.map(|c| state.world_point(c).y).fold(f64::INFINITY, f64::min);
        assert!(lowest > -3e-4, "domino {n} is {lowest} m in the floor");
    }
    let work = world.report(0.0, &[]).sheets[0].contact_work;
    println!("{} factors, {} halvings", work.factors, work.halved);
    assert!(work.factors < 10_000, "{} factors", work.factors);
}

#[test]
fn a_needle_never_penetrates_a_sheet() {
    let world = run_scene("needle");
    let sheet = &world.sheets()[0];
    assert!(sheet.centre_of_mass().y < 0.09, "{}", sheet.centre_of_mass());
}

#[test]
fn a_pile_of_sheets_comes_to_rest() {
    let setup = Setup { grid: (11, 11), sheets: 5, ..setup_without_restitution() };
    let found = measured("stack", &setup);
    assert_eq!(found["in_order"], true, "{found}");
    assert!(number(&found, "overlap_at_rest_m") < 1e-6, "{found}");
    assert!(number(&found, "max_sheet_overlap_m") < 1e-4, "{found}");
    assert!(number(&found, "drift_m") < 1e-3, "{found}");
    assert!(number(&found, "energy_gain") <= ENERGY, "{found}");
    assert!(found["asleep_s"].is_f64(), "{found}");
}

#[test]
fn a_pack_of_cards_comes_to_rest_without_overlap() {
    let found = measured("card-pack", &Setup::default());
    assert_eq!(found["in_order"], true, "{found}");
    assert!(number(&found, "overlap_ratio") < 0.1, "{found}");
    assert!(number(&found, "energy_gain") <= ENERGY, "{found}");
    assert!(number(&found, "asleep_s") < 4.0, "{found}");
    // Some forty contacts hold a card on the next. Crossing borders add none, since those would
    // have oblique normals.
    let mut world = world(&shipped_scene("cards_pack"));
    world.advance(0.1);
    let most = world.report(0.0, &[]).sheets.iter().map(|s| s.contact_work.most).max();
    assert!(most.is_some_and(|most| (1..2500).contains(&most)), "{most:?}");
}

#[test]
fn a_house_of_cards_stands_until_a_ball_hits_it() {
    let scene = shipped_scene("cards_house");
    let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let top = |world: &World| world.sheets().iter().flat_map(|s| s.state.x.y.iter().copied()).fold(0.0, f64::max);
    let start = top(&world);
    while world.time() < scene.duration {
        world.step();
    }
    assert!(world.unstable().is_none());
    assert!((top(&world) - start).abs() < 1e-4, "{start} m, then {} m", top(&world));
    assert!(world.sheets().iter().all(|s| s.state.status == Status::Asleep));
    let stood = world.snapshot();
    // The result of an impact is sensitive to rounding; three throws cover more than one.
    for (times, most) in [(1.0, 3e-5), (0.97, 1e-4), (1.03, 1e-4)] {
        let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        world.restore(&stood).unwrap_or_else(|e| panic!("{e}"));
        let mut ball = shipped_scene("cards_house_ball").bodies.remove(0);
        ball.velocity *= times;
        world.add_body(&ball).unwrap_or_else(|e| panic!("{e}"));
        while world.time() < scene.duration + 1.5 {
            world.step();
        }
        assert!(world.unstable().is_none());
        assert!(top(&world) < 0.7 * start, "the house has not fallen: {} m", top(&world));
        // A card that has passed through another overlaps it by its whole thickness. In motion a
        // step tolerates a third of that.
        let overlap = between(world.sheets());
        assert!(overlap < most, "{overlap} m after a throw of {times}");
    }
}

/// A body in contact with a sheet attached to it: contact must not oppose the attachment.
#[test]
fn a_sheet_attached_to_a_dynamic_body_in_contact_hangs_on_it() {
    let scene = |density: f64| {
        let text = format!(
            r#"(
                engine: "tr-bdf2", dt: 0.0166666666666667, duration: 1.5,
                room: (x: (-1, 1), y: (0, 1), z: (-1, 1), back_wall: false), contact: (friction: 0.35, restitution: 0.1),
                sheets: [(name: "a", structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "hips",
                    placement: (position: (0.105, 0.3, 0)), pins: [(region: Left, body: "mover")])],
                bodies: [(name: "mover", shape: Box((0.01, 0.01, 0.2)), density: {density}, placement: (position: (0, 0.3, 0)))],
            )"#
        );
        Scene::parse(&text).unwrap_or_else(|e| panic!("{e}"))
    };
    for density in [100.0, 1000.0, 8000.0] {
        let scene = scene(density);
        let mut world = world(&scene);
        let edge: Vec<usize> = (0..81).filter(|i| (world.sheets()[0].state.x.get(*i).x - 0.005).abs() < 1e-9).collect();
        assert_eq!(edge.len(), 9);
        while world.time() < scene.duration {
            world.step();
        }
        assert!(world.unstable().is_none(), "{density}");
        let work = world.report(0.0, &[]).sheets[0].contact_work;
        assert!(work.given_up == 0 && work.factors < 20_000, "{density}: {work:?}");
        let state = world.body_state("mover").expect("it is there");
        assert!(
            state.world_point(DVec3::ZERO).y > -1e-3 && state.velocity().length() < 0.5,
            "{density}: {:?}",
            state.velocity()
        );
        // The whole edge lies on the face that it is attached to.
        for i in edge {
            let place =
                state.rotation().conjugate() * (world.sheets()[0].state.x.get(i) - state.world_point(DVec3::ZERO));
            assert!((place.x - 0.005).abs() < 1e-4 && place.y.abs() < 1e-4, "{density}: {place}");
        }
    }
}
