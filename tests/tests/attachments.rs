//! Sheets attached to dynamic bodies, with implicit integrators: momentum, angular momentum and
//! energy of the pair, without gravity and air. Fixed nodes, and their release.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::{PinSpec, Region, Scene};
use sheetwork_tests::card::{card, rejection};
use sheetwork_tests::world;

/// A strip of HIPS, 12 by 6 cm, whose `region` is attached to a box of 0.1 kg with angular velocity
/// `spin` (rad/s), in steps of 1/`rate` s of `engine`. The initial motion is a rigid rotation about
/// the box's centre.
fn strip_on_drum(engine: &str, region: &str, spin: DVec3, rate: f64) -> World {
    let ([x, y, z], arm) = (spin.to_array(), DVec3::new(0.081, 0.0, 0.0));
    let [u, v, w] = spin.cross(arm).to_array();
    let text = format!(
        r#"(
            engine: "{engine}", dt: {}, duration: 1, gravity: (0, 0, 0), air: (factor: 1),
            room: (x: (-10, 10), y: (-10, 10), z: (-10, 10)),
            sheets: [(name: "strip", structure: "shell", grid: (13, 1, 7), size: (0.12, 0.06), material: "hips",
                velocity: ({u}, {v}, {w}), spin: ({x}, {y}, {z}), pins: [(region: {region}, body: "drum")])],
            bodies: [(name: "drum", shape: Box((0.04, 0.06, 0.04)), mass: 0.1, spin: ({x}, {y}, {z}),
                placement: (position: (-0.081, 0, 0)))],
        )"#,
        1.0 / rate
    );
    world(&Scene::parse(&text).unwrap_or_else(|e| panic!("{e}")))
}

/// Momentum (kg m/s), angular momentum about the origin (kg m²/s) and energy (J) of strips and
/// drum.
fn conserved_quantities(world: &World) -> (DVec3, DVec3, f64) {
    let body = world.body_state("drum").expect("it is there");
    let (mut momentum, mut about) = (body.momentum(), body.angular_momentum(DVec3::ZERO));
    let mut energy = body.kinetic_energy();
    for sheet in world.sheets() {
        momentum += sheet.momentum();
        about +=
            (0..sheet.node_count()).map(|i| sheet.x.get(i).cross(sheet.v.get(i)) * sheet.node_mass(i)).sum::<DVec3>();
        energy += sheet.energy(DVec3::ZERO).total;
    }
    (momentum, about, energy)
}

/// Largest relative change of momentum and of angular momentum in `time` s, and ratio of energies.
fn changes(mut world: World, time: f64) -> (f64, f64, f64) {
    let (p, l, e) = conserved_quantities(&world);
    let (mut momentum, mut turning) = (0.0_f64, 0.0_f64);
    while world.time() < time - 1e-9 {
        world.step();
        let (now, about, _) = conserved_quantities(&world);
        momentum = momentum.max(now.distance(p) / p.length());
        turning = turning.max(about.distance(l) / l.length());
    }
    assert!(world.unstable().is_none());
    (momentum, turning, conserved_quantities(&world).2 / e)
}

#[test]
fn a_strip_attached_to_a_drum_conserves_angular_momentum() {
    for spin in [DVec3::Z * 10.0, DVec3::Y * 10.0, DVec3::new(3.0, 4.0, 8.0)] {
        let mut lost = Vec::new();
        for rate in [60.0, 240.0] {
            let (momentum, turning, energy) =
                changes(strip_on_drum("tr-bdf2", "Rect((0, 0.1), (0, 1))", spin, rate), 0.5);
            println!("{spin}, 1/{rate} s: momentum {momentum:.1e}, angular momentum {turning:.4}, energy {energy:.4}");
            assert!(momentum < 1e-8, "{spin}, {rate}: {momentum:e}");
            assert!((0.9..1.0 + 1e-3).contains(&energy), "{spin}, {rate}: {energy}");
            lost.push(turning);
        }
        assert!(lost[0] < 0.03 && lost[1] < 0.01 && lost[1] < 0.5 * lost[0], "{spin}: {lost:?}");
    }
}

/// Integrators of order 1, which include `bdf2` on an attached sheet, lose or gain some percent of
/// the energy.
#[test]
fn other_implicit_integrators_nearly_conserve_energy_of_an_attached_strip() {
    for engine in ["backward-euler", "bdf2"] {
        for rate in [60.0, 240.0] {
            let world = strip_on_drum(engine, "Rect((0, 0.1), (0, 1))", DVec3::Z * 10.0, rate);
            let (momentum, turning, energy) = changes(world, 1.0);
            println!(
                "{engine}, 1/{rate} s: momentum {momentum:.1e}, angular momentum {turning:.4}, energy {energy:.4}"
            );
            assert!(momentum < 1e-8 && turning < 0.15, "{engine}, {rate}: {momentum:e} {turning}");
            assert!((0.9..1.1).contains(&energy), "{engine}, {rate}: {energy}");
        }
    }
}

#[test]
fn a_strip_attached_by_a_row_swings_and_conserves_angular_momentum() {
    let (momentum, turning, energy) =
        changes(strip_on_drum("tr-bdf2", "Rect((0, 0.01), (0, 1))", DVec3::Z * 10.0, 60.0), 0.5);
    println!("momentum {momentum:.1e}, angular momentum {turning:.4}, energy {energy:.4}");
    assert!(momentum < 1e-8 && turning < 0.03 && energy < 1.0 + 1e-3, "{momentum} {turning} {energy}");
}

/// A strip and a distant body, joined as by a rigid massless bar.
#[test]
fn a_distant_attached_body_conserves_momentum() {
    let text = r#"(
        engine: "tr-bdf2", dt: 0.0166666666666667, duration: 1, gravity: (0, 0, 0), air: (factor: 1),
        room: (x: (-10, 10), y: (-10, 10), z: (-10, 10)),
        sheets: [(name: "strip", structure: "shell", grid: (13, 1, 7), size: (0.12, 0.06), material: "hips",
            pins: [(region: Rect((0, 0.1), (0, 1)), body: "drum")])],
        bodies: [(name: "drum", shape: Box((0.04, 0.06, 0.04)), mass: 0.1, velocity: (0.5, 0.3, 0),
            placement: (position: (-0.5, 0, 0)))],
    )"#;
    let (momentum, turning, energy) = changes(world(&Scene::parse(text).unwrap_or_else(|e| panic!("{e}"))), 0.5);
    println!("momentum {momentum:.1e}, angular momentum {turning:.4}, energy {energy:.4}");
    assert!(momentum < 1e-8 && turning < 0.03 && energy < 1.0 + 1e-3, "{momentum} {turning} {energy}");
}

/// Two strips on one drum, coupled through it: with a rigid rotation, and with an axial velocity of
/// the drum alone that jolts them.
#[test]
fn two_strips_on_a_drum_conserve_angular_momentum() {
    for along in [0.1, 0.0] {
        let strip = |name: &str, side: f64, region: &str| {
            let (x, v) = (0.081 * side, 0.81 * side);
            format!(
                r#"(name: "{name}", structure: "shell", grid: (13, 1, 7), size: (0.12, 0.06), material: "hips",
                    placement: (position: ({x}, 0, 0)), velocity: (0, {v}, {along}), spin: (0, 0, 10),
                    pins: [(region: {region}, body: "drum")])"#
            )
        };
        let text = format!(
            r#"(
                engine: "tr-bdf2", dt: 0.0166666666666667, duration: 1, gravity: (0, 0, 0), air: (factor: 1),
                room: (x: (-10, 10), y: (-10, 10), z: (-10, 10)),
                sheets: [{}, {}],
                bodies: [(name: "drum", shape: Box((0.04, 0.06, 0.04)), mass: 0.1, spin: (0, 0, 10), velocity: (0, 0, 0.1))],
            )"#,
            strip("right", 1.0, "Rect((0, 0.1), (0, 1))"),
            strip("left", -1.0, "Rect((0.9, 1), (0, 1))")
        );
        let (momentum, turning, energy) = changes(world(&Scene::parse(&text).unwrap_or_else(|e| panic!("{e}"))), 0.5);
        println!("strips at {along} m/s: momentum {momentum:.1e}, angular momentum {turning:.4}, energy {energy:.4}");
        assert!(momentum < 1e-8 && turning < 0.03 && energy < 1.0 + 1e-3, "{along}: {momentum} {turning} {energy}");
    }
}

#[test]
fn pins_are_released_at_their_end_time() {
    let mut scene = card((11, 7));
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.sheets[0].pins = vec![PinSpec { until: Some(0.5), ..PinSpec::fixed(Region::All) }];
    let mut world = world(&scene);
    world.advance(0.5);
    assert_eq!(world.sheets()[0].max_speed(), 0.0);
    world.advance(0.5);
    let fallen = -world.sheets()[0].centre_of_mass().y;
    assert!((fallen - 0.5 * 9.81 * 0.25).abs() < 1e-6, "{fallen}");
}

#[test]
fn a_sleeping_sheet_wakes_when_its_pins_are_released() {
    let mut scene = card((11, 7));
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.sheets[0].pins = vec![PinSpec { until: Some(1.0), ..PinSpec::fixed(Region::All) }];
    let mut world = world(&scene);
    world.set_sleep(true);
    world.advance(1.25);
    let kinds: Vec<EventKind> = world.events().iter().map(|e| e.kind).collect();
    assert_eq!(kinds, [EventKind::AtRest, EventKind::Woke]);
    assert!((world.events()[1].time_s - 1.0).abs() < 1e-6, "{}", world.events()[1].time_s);
}

#[test]
fn clamps_with_an_end_time_are_rejected() {
    assert!(rejection(&|s| s.pins[0].until = Some(1.0)).1.contains("without clamp"));
}
