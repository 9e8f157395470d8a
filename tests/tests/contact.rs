//! Contact with rigid bodies: the virtual rigs against closed forms with several integrators and
//! structures, and sheets that are carried, hit and passed through.
//!
//! The sheets are soft (4 MPa) and coarse, so that each run takes well under a second; the closed
//! forms hold for any stiffness.

use glam::DVec3;
use serde_json::Value;
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::contact::MINIMUM_CONTACT_OFFSET;
use sheetwork::scene::{ContactDefaults, Material, PathKey, PinSpec, Placement, Region, Scene, Shape, SpringLaw};
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::rig::{measured, number};
use sheetwork_tests::{body, run, scene_without_gravity, shipped_scene, small_sheet, world};

/// Explicit integrators and structures of the rigs: order 1, 2, 4 and adaptive; one, two and three
/// layers.
const RIGS: [(IntegratorKind, StructureKind, u32); 7] = [
    (IntegratorKind::EulerCromer, StructureKind::Trimm, 2),
    (IntegratorKind::EulerRichardson, StructureKind::Trimm, 2),
    (IntegratorKind::Verlet, StructureKind::Samm, 3),
    (IntegratorKind::Verlet, StructureKind::Provot2d, 1),
    (IntegratorKind::Rk4, StructureKind::Provot3d, 2),
    (IntegratorKind::Rk4, StructureKind::Slamm, 1),
    (IntegratorKind::Rk45, StructureKind::DoubleDiagonal, 2),
];

fn setup((engine, structure, layers): (IntegratorKind, StructureKind, u32)) -> Setup {
    let material = Material { young: 4e6, poisson: 0.3, density: 900.0, thickness: 1e-3, ..Material::default() };
    Setup {
        engine,
        structure,
        layers: Some(layers),
        springs: SpringLaw::Length,
        grid: (7, 6),
        material,
        length: 0.2,
        width: 0.15,
        damping_ratio: 0.1,
        ..Setup::default()
    }
}

fn what(setup: &Setup) -> String {
    format!("{} on {} of {} layers", setup.engine, setup.structure, setup.layer_count())
}

#[test]
fn a_sheet_slides_down_an_incline_with_g_sin_minus_mu_cos() {
    for rig in RIGS {
        for (angle, friction, gravity) in [(25.0_f64, 0.25, 9.81), (50.0, 0.6, 9.81), (12.0, 0.0, 3.7)] {
            let setup = Setup { angle, friction, gravity, ..setup(rig) };
            let found = measured("incline", &setup);
            let a = number(&found, "acceleration_m_s2");
            let expected = gravity * (angle.to_radians().sin() - friction * angle.to_radians().cos());
            println!("{}: {a:.5}, {expected:.5} m/s²", what(&setup));
            assert!((a / expected - 1.0).abs() < 0.01, "{}: {a}, {expected}", what(&setup));
        }
    }
}

#[test]
fn a_sheet_sticks_on_an_incline_up_to_the_angle_of_friction() {
    for rig in RIGS {
        // tan 28° = 0.5317: the sheet sticks at a friction of a hundredth above and slips at three
        // hundredths below.
        for (factor, slides) in [(1.01, false), (0.97, true)] {
            let friction = factor * 28.0_f64.to_radians().tan();
            let mut setup = Setup { angle: 28.0, friction, ..setup(rig) };
            // Stiffer, so that layers have taken up their weight before the measurement.
            setup.material.young = 5e7;
            let found = measured("incline", &setup);
            assert_eq!(found["slid"], slides, "{}: {found}", what(&setup));
        }
    }
}

#[test]
fn a_dropped_sheet_rebounds_to_e_squared_of_its_height() {
    for rig in RIGS {
        for (height, restitution) in [(0.15, 0.7), (0.3, 0.4)] {
            let setup = Setup { height, restitution, ..setup(rig) };
            let found = measured("bounce", &setup);
            let heights: Vec<f64> =
                found["heights_m"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
            println!("{}: {heights:.5?} from {height} with {restitution}", what(&setup));
            assert_eq!(heights.len(), 3, "{}", what(&setup));
            for (n, found) in heights.iter().enumerate() {
                let expected = height * restitution.powi(2 * (n as i32 + 1));
                assert!((found / expected - 1.0).abs() < 0.01, "{}: bounce {n}: {found}, {expected}", what(&setup));
            }
        }
    }
}

#[test]
fn a_sliding_sheet_stops_after_v_squared_over_two_mu_g() {
    for rig in RIGS {
        for (speed, friction) in [(0.6, 0.25), (2.0, 0.8)] {
            let setup = Setup { speed, friction, ..setup(rig) };
            let found = measured("slide", &setup);
            let (distance, expected) = (number(&found, "distance_m"), speed * speed / (2.0 * friction * 9.81));
            println!("{}: {distance:.5}, {expected:.5} m", what(&setup));
            assert!((distance / expected - 1.0).abs() < 0.01, "{}: {distance}, {expected}", what(&setup));
        }
    }
}

/// A scene of one small damped sheet under gravity with friction.
fn scene_with_friction(structure: StructureKind, friction: f64) -> Scene {
    let mut scene = scene_without_gravity(small_sheet(structure, 0.3), IntegratorKind::Verlet);
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.contact = ContactDefaults { friction, restitution: 0.0, ..ContactDefaults::default() };
    scene.dt = 2e-3;
    scene
}

fn moved(scene: &Scene, seconds: f64) -> (World, DVec3) {
    let mut world = world(scene);
    let start = world.sheets()[0].centre_of_mass();
    run(&mut world, (seconds / scene.dt).round() as u32, scene.dt);
    let moved = world.sheets()[0].centre_of_mass() - start;
    (world, moved)
}

#[test]
fn a_sheet_rests_on_a_tilted_box_and_slides_off_a_steeper_one() {
    for (angle, stays) in [(20.0, true), (40.0, false)] {
        let mut scene = scene_with_friction(StructureKind::Trimm, 0.6);
        let tilt = Placement { position: DVec3::new(0.3, 0.2, -0.1), rotation: DVec3::new(angle, 30.0, 0.0) };
        scene.bodies.push(body("ramp", Shape::Box(DVec3::new(1.0, 0.2, 1.0)), tilt, vec![]));
        scene.sheets[0].placement =
            Placement { position: tilt.apply(DVec3::new(0.0, 0.1 + MINIMUM_CONTACT_OFFSET, 0.0)), ..tilt };
        let (world, moved) = moved(&scene, 1.0);
        println!("{angle} degrees: moved {:.4} m, {:.1e} m deep", moved.length(), world.penetration());
        // The upper layer sags by less than a centimetre; a slip covers g (sin 40 - 0.6 cos 40) / 2
        // = 0.9 m.
        assert_eq!(moved.length() < 0.01, stays, "{moved}");
        assert!(world.penetration() < 1e-6);
        let still = world.sheets()[0].max_speed();
        assert_eq!(still < 1e-3, stays, "{still} m/s");
    }
}

#[test]
fn contact_is_invariant_under_translation_and_rotation() {
    // A scene that is translated by metres and rotated with its gravity must give the translated
    // and rotated result. Contact is computed in each body's frame, in f32.
    let rest = |placement: Placement| {
        let mut scene = scene_with_friction(StructureKind::Slamm, 0.4);
        let q = placement.quaternion();
        scene.gravity = q * scene.gravity;
        scene.bodies.push(body("table", Shape::Box(DVec3::new(0.2, 0.1, 0.5)), placement, vec![]));
        scene.sheets[0].placement = Placement { position: placement.apply(DVec3::new(0.02, 0.1, 0.01)), ..placement };
        let mut world = world(&scene);
        run(&mut world, 400, scene.dt);
        assert!(world.penetration() < 2e-6, "{}", world.penetration());
        let back = q.inverse();
        world.sheets()[0].state.x.iter().map(|p| back * (p - placement.position)).collect::<Vec<_>>()
    };
    let here = rest(Placement::default());
    for (position, rotation) in [
        (DVec3::new(3.0, -1.0, 7.0), DVec3::ZERO),
        (DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.0, 0.0, 90.0)),
        (DVec3::new(-2.0, 4.0, 1.0), DVec3::new(25.0, 60.0, -110.0)),
    ] {
        let there = rest(Placement { position, rotation });
        let off = here.iter().zip(&there).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        println!("{position} {rotation}: {off:.1e} m");
        assert!(off < 1e-4, "{off}");
    }
}

#[test]
fn a_moving_body_carries_the_sheet_on_it() {
    for structure in [StructureKind::Trimm, StructureKind::Provot2d] {
        let mut scene = scene_with_friction(structure, 0.8);
        // Slowly sideways, then up: friction transfers 0.1 m/s within a millisecond of slip.
        let path = vec![
            PathKey { time: 0.2, ..PathKey::default() },
            PathKey { time: 1.2, offset: DVec3::new(0.1, 0.0, -0.05), rotation: DVec3::ZERO },
            PathKey { time: 2.2, offset: DVec3::new(0.1, 0.15, -0.05), rotation: DVec3::ZERO },
        ];
        scene.bodies.push(body("tray", Shape::Box(DVec3::new(0.6, 0.04, 0.6)), Placement::default(), path));
        scene.sheets[0].placement.position = DVec3::new(0.0, 0.02 + MINIMUM_CONTACT_OFFSET, 0.0);
        let (world, moved) = moved(&scene, 3.0);
        println!("{structure}: carried {moved}");
        // A start and a stop at 0.1 m/s each slip by at most v²/(2 μ g) = 0.6 mm; two layers sag a
        // little under their weight.
        let slip = moved - DVec3::new(0.1, 0.15, -0.05);
        assert!(slip.with_y(0.0).length() < 2e-3 && slip.y.abs() < 5e-3, "{structure}: {slip}");
        assert!(world.penetration() < 1e-6);
    }
}

#[test]
fn a_turntable_turns_the_sheet_on_it() {
    let mut scene = scene_with_friction(StructureKind::Slamm, 1.0);
    let turn = |time: f64, degrees: f64| PathKey { time, offset: DVec3::ZERO, rotation: DVec3::new(0.0, degrees, 0.0) };
    let path = (0..=18).map(|i| turn(0.2 + 0.1 * f64::from(i), 5.0 * f64::from(i))).collect();
    scene.bodies.push(body("table", Shape::Box(DVec3::new(0.6, 0.04, 0.6)), Placement::default(), path));
    scene.sheets[0].placement.position = DVec3::new(0.0, 0.02 + MINIMUM_CONTACT_OFFSET, 0.0);
    let mut world = world(&scene);
    let start: Vec<DVec3> = world.sheets()[0].state.x.iter().collect();
    run(&mut world, 1200, scene.dt);
    let sheet = &world.sheets()[0];
    let bottom = sheet.model.layers[0].range();
    // A quarter turn about y takes (x, z) to (z, -x). Slip at the start, the stop and the rim adds
    // a small error.
    let off = bottom.map(|i| {
        let (a, b) = (start[i], sheet.state.x.get(i));
        DVec3::new(a.z, b.y, -a.x).distance(b)
    });
    let off = off.fold(0.0, f64::max);
    assert!(off < 0.01, "{off}");
}

#[test]
fn a_body_passes_through_a_hanging_sheet_and_leaves_it_whole() {
    // A ball and a box on its edge rise through a sheet fixed at two edges, push it up and aside
    // and continue. At release the free edge reaches 9.9 m/s with layers that may snap through each
    // other, and 12.7 m/s with a thickness limit, which stores more energy. An instability is
    // faster by orders of magnitude.
    let shapes = [Shape::Ball(0.06), Shape::Box(DVec3::new(0.1, 0.1, 0.1))];
    for (shape, (limit, bound)) in shapes.iter().flat_map(|s| [(s.clone(), (0.0, 10.0)), (s.clone(), (0.5, 20.0))]) {
        let mut scene = scene_with_friction(StructureKind::DoubleDiagonal, 0.2);
        scene.sheets[0].thickness_limit = limit;
        scene.sheets[0].grid = (9, 2, 9);
        scene.sheets[0].pins.push(PinSpec::fixed(Region::Left));
        let path = vec![
            PathKey::default(),
            PathKey { time: 2.0, offset: DVec3::new(0.0, 1.2, 0.0), rotation: DVec3::new(0.0, 90.0, 0.0) },
        ];
        let below = Placement { position: DVec3::new(0.02, -0.3, 0.01), rotation: DVec3::new(45.0, 0.0, 0.0) };
        scene.bodies.push(body("riser", shape, below, path));
        let mut world = world(&scene);
        let (mut deepest, mut fastest) = (0.0_f64, 0.0_f64);
        for _ in 0..1250 {
            run(&mut world, 1, scene.dt);
            deepest = deepest.max(world.penetration());
            fastest = fastest.max(world.sheets()[0].max_speed());
        }
        println!("{deepest:.1e} m deep, {fastest:.2} m/s");
        assert!(world.sheets()[0].state.counters.contacts > 100, "it was never met");
        assert!(deepest < 1e-4, "{deepest}");
        assert!(fastest < bound, "{fastest} m/s with a thickness limit of {limit}");
        assert!(world.sheets()[0].state.x.iter().all(DVec3::is_finite));
    }
}

#[test]
fn the_cache_of_distant_nodes_has_no_effect_on_the_result() {
    // `wake` discards the cached distances of nodes from bodies; the result must be bit-identical.
    let mut falling = scene_with_friction(StructureKind::Trimm, 0.3);
    falling.sheets[0].placement.position = DVec3::new(0.02, 0.4, 0.0);
    falling.bodies.push(body("floor", Shape::HalfSpace, Placement::default(), vec![]));
    let path = vec![
        PathKey::default(),
        PathKey { time: 1.0, offset: DVec3::new(0.5, 0.05, 0.0), rotation: DVec3::new(0.0, 180.0, 30.0) },
    ];
    let at = Placement { position: DVec3::new(-0.3, 0.1, 0.0), rotation: DVec3::ZERO };
    falling.bodies.push(body("sweeper", Shape::Box(DVec3::new(0.1, 0.2, 0.4)), at, path));
    let mut scenes = vec![falling];
    scenes.extend(["wedge", "slide_11", "hemisphere", "two_walls"].map(shipped_scene));
    for scene in scenes {
        let (mut kept, mut forgetful) = (world(&scene), world(&scene));
        for step in 0..400 {
            forgetful.sheets_mut().iter_mut().for_each(sheetwork::sheet::Sheet::wake);
            kept.step();
            forgetful.step();
            let (a, b) = (&kept.sheets()[0], &forgetful.sheets()[0]);
            assert!(a.state.x == b.state.x && a.state.v == b.state.v, "{} differs at step {step}", scene.name);
        }
        assert!(kept.sheets()[0].state.counters.contacts > 100);
    }
}

#[test]
fn the_rigs_choose_a_stable_step_at_any_damping() {
    for rig in RIGS {
        for damping_ratio in [0.0, 0.05, 0.3, 1.0] {
            let setup = Setup { damping_ratio, angle: 20.0, friction: 0.2, ..setup(rig) };
            let found = measure("incline", &setup).expect("a valid set-up");
            assert_eq!(found["status"], "ok", "{} with damping {damping_ratio}", what(&setup));
        }
    }
}
