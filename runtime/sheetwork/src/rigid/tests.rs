//! Tests of rigid bodies among themselves, without sheets.

use glam::{DQuat, DVec3};

use crate::rigid::{BodyState, RigidWorld};
use crate::scene::{BodySpec, PathKey, Placement, Scene, Shape};

const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);
const DT: f64 = 1.0 / 60.0;

fn world(text: &str) -> RigidWorld {
    RigidWorld::build(&Scene::parse(text).expect("valid")).expect("valid")
}

fn state(world: &RigidWorld, name: &str) -> BodyState {
    *world.index_of(name).and_then(|i| world.state(i)).expect("there")
}

fn run(world: &mut RigidWorld, seconds: f64, g: DVec3) {
    for i in 0..(seconds / DT).round() as u32 {
        world.step(f64::from(i) * DT, DT, g);
    }
}

const FLOOR: &str = "(name: \"floor\", shape: HalfSpace)";

#[test]
fn a_free_body_flies_its_parabola_and_keeps_its_spin() {
    let text =
        "(bodies: [(name: \"a\", shape: Box((0.1, 0.2, 0.3)), density: 500, velocity: (3, 4, -1), spin: (1, 9, 2),
        placement: (position: (5, 100, 3), rotation: (10, 20, 30)))])";
    let mut world = world(text);
    let start = state(&world, "a");
    assert!((start.mass() - 3.0).abs() < 1e-12);
    run(&mut world, 2.0, G);
    let end = state(&world, "a");
    let wanted = start.centre() + start.velocity() * 2.0 + G * 2.0;
    assert!(end.centre().distance(wanted) < 1e-11, "{}", end.centre().distance(wanted));
    assert!(end.velocity().distance(start.velocity() + G * 2.0) < 1e-12);
    assert_eq!(end.angular_momentum(end.centre()), start.angular_momentum(start.centre()));
    let (view, index) = (world.view(), world.index_of("a").expect("there"));
    let shown = view.colliders.iter().next().expect("one").1.position().translation.as_dvec3();
    assert!(shown.distance(world.pose(index).expect("there").0) < 1e-5);
}

#[test]
fn a_box_comes_to_rest_on_the_floor_and_sleeps() {
    for size in [0.01, 0.1, 1.0] {
        let height = 0.8 * size;
        let mut world = world(&format!(
            "(bodies: [{FLOOR}, (name: \"a\", shape: Box(({size}, {size}, {size})), density: 500,
                placement: (position: (0, {height}, 0), rotation: (5, 0, 3)))])"
        ));
        let index = world.index_of("a").expect("there");
        let mut slept = None;
        for i in 0..240 {
            world.step(f64::from(i) * DT, DT, G);
            if world.is_asleep(index) {
                slept = Some(f64::from(i) * DT);
                break;
            }
        }
        assert!(slept.is_some_and(|t| t < 3.0), "{size}: {slept:?} {:?}", state(&world, "a"));
        let rest = state(&world, "a");
        // Rapier's contacts penetrate slightly under load.
        assert!((rest.centre().y - 0.5 * size).abs() < 1e-4, "{size}: {}", rest.centre().y);
        assert!(!rest.is_moving());
        run(&mut world, 1.0, G);
        assert_eq!(state(&world, "a"), rest, "what sleeps stays to the bit");
        assert!(world.all_asleep());
    }
}

#[test]
fn a_sleeping_stack_is_woken_by_a_ball_and_by_nothing_else() {
    let mut world = world(&format!(
        "(contact: (friction: 0.5, restitution: 0), bodies: [{FLOOR},
            (name: \"low\", shape: Box((0.1, 0.1, 0.1)), mass: 0.5, placement: (position: (0, 0.05, 0))),
            (name: \"high\", shape: Box((0.1, 0.1, 0.1)), mass: 0.5, placement: (position: (0, 0.15, 0))),
            (name: \"ball\", shape: Ball(0.05), mass: 1, placement: (position: (-20, 5, 0)), velocity: (10, 4, 0))])"
    ));
    let high = world.index_of("high").expect("there");
    run(&mut world, 1.5, G);
    assert!(world.is_asleep(high), "{:?}", state(&world, "high"));
    let rest = state(&world, "high");
    assert!((rest.centre().y - 0.15).abs() < 1e-3);
    let mut woken = false;
    for i in 0..240 {
        world.step(1.5 + f64::from(i) * DT, DT, G);
        let ball = state(&world, "ball");
        if !world.is_asleep(high) {
            woken = true;
            assert!(ball.centre().distance(state(&world, "low").centre()) < 0.5, "not by a far ball");
            break;
        }
        assert_eq!(state(&world, "high"), rest);
        let index = world.index_of("ball").expect("there");
        if i == 0 {
            // The ball is thrown again, horizontally, at the upper box.
            let thrown = BodyState::new(
                *ball.mass_properties(),
                DVec3::new(-1.0, 0.2, 0.0),
                DQuat::IDENTITY,
                DVec3::new(8.0, 0.0, 0.0),
                DVec3::ZERO,
            );
            world.set_state(index, thrown);
        }
    }
    assert!(woken);
    run(&mut world, 0.5, G);
    assert!(state(&world, "high").centre().distance(rest.centre()) > 0.05);
}

#[test]
fn bodies_that_collide_keep_their_momentum_to_single_precision() {
    let mut world = world(
        "(contact: (restitution: 1, friction: 0), bodies: [
            (name: \"a\", shape: Ball(0.05), mass: 1, velocity: (2, 0, 0), placement: (position: (-0.5, 0, 0))),
            (name: \"b\", shape: Ball(0.05), mass: 1)])",
    );
    run(&mut world, 1.0, DVec3::ZERO);
    let (a, b) = (state(&world, "a"), state(&world, "b"));
    // Two equal balls exchange their velocities.
    assert!((a.momentum() + b.momentum()).distance(DVec3::new(2.0, 0.0, 0.0)) < 1e-5);
    assert!(a.velocity().length() < 0.05 && (b.velocity().x - 2.0).abs() < 0.05, "{a:?} {b:?}");
}

#[test]
fn material_pairs_set_friction_between_bodies() {
    let slid = |pairs: &str| {
        let mut world = world(&format!(
            "(contact: (friction: 0, restitution: 0, pairs: [{pairs}]), bodies: [
                (name: \"floor\", shape: HalfSpace, material: \"felt\"),
                (name: \"a\", shape: Box((0.1, 0.05, 0.1)), mass: 1, material: \"wood\", velocity: (1, 0, 0),
                 placement: (position: (0, 0.025, 0)))])"
        ));
        run(&mut world, 0.05, G);
        let before = state(&world, "a").velocity().x;
        run(&mut world, 0.1, G);
        let contacts = world.body_contacts();
        assert!(!contacts.is_empty());
        ((before - state(&world, "a").velocity().x) / 0.1, contacts[0])
    };
    let (free, held) = (slid(""), slid("(between: (\"wood\", \"felt\"), friction: 0.4)"));
    assert!(free.0.abs() < 1e-3);
    // Coulomb friction decelerates by μ g.
    assert!((held.0 / (0.4 * 9.81) - 1.0).abs() < 2e-3, "{}", held.0);
    assert!((free.1.friction, (held.1.friction * 1e3).round()) == (0.0, 400.0));
    assert!(held.1.normal.y.abs() > 0.999 && held.1.distance.abs() < 1e-3);
}

#[test]
fn a_body_takes_the_state_set_by_contact_and_a_sleeping_one_stays() {
    let mut world = world("(bodies: [(name: \"a\", shape: Ball(0.1), mass: 2)])");
    world.step(0.0, DT, G);
    let start = *world.start(0).expect("there");
    let end = start.free_flight(DT, G).with_impulse_at(DVec3::new(0.0, 2.0 * 9.81 * DT, 0.0), start.centre());
    world.set_state(0, end);
    assert_eq!(world.state(0), Some(&end));
    world.step(DT, DT, G);
    assert_eq!(world.start(0), Some(&end));
    assert!(state(&world, "a").centre().distance(end.free_flight(DT, G).centre()) < 1e-15);
    world.put_to_sleep(0);
    let frozen = state(&world, "a");
    run(&mut world, 0.5, G);
    assert_eq!(state(&world, "a"), frozen);
    world.wake(0);
    run(&mut world, 0.5, G);
    assert!((frozen.centre().y - state(&world, "a").centre().y - 0.5 * 9.81 * 0.25).abs() < 1e-9);
}

#[test]
fn a_kinematic_body_is_exactly_on_its_path_with_the_velocity_of_its_step() {
    let path = vec![
        PathKey::default(),
        PathKey { time: 1.0, offset: DVec3::new(0.3, 0.0, 0.1), rotation: DVec3::new(0.0, 90.0, 0.0) },
    ];
    let placement = Placement { position: DVec3::new(1.1, 2.2, 3.3), rotation: DVec3::ZERO };
    let spec = BodySpec { name: "arm".into(), path, placement, ..BodySpec::new(Shape::Ball(0.1)) };
    let mut world = RigidWorld::build(&Scene { bodies: vec![spec], ..Scene::default() }).expect("valid");
    world.step(0.0, 0.25, G);
    let end = state(&world, "arm");
    assert_eq!(end.origin(), DVec3::new(1.1, 2.2, 3.3) + DVec3::new(0.3, 0.0, 0.1) * 0.25);
    assert!(end.velocity().distance(DVec3::new(0.3, 0.0, 0.1)) < 1e-14);
    assert!(end.spin().distance(DVec3::Y * 90.0_f64.to_radians()) < 1e-13);
    let flown = world.start(0).expect("there").free_flight(0.25, G);
    assert!(flown.rotation().angle_between(end.rotation()) < 1e-7);
    assert!(world.set_target(world.index_of("arm").expect("there"), DVec3::ONE, DQuat::IDENTITY));
    world.step(0.25, 0.25, G);
    assert_eq!(state(&world, "arm").origin(), DVec3::ONE);
    world.step(0.5, 0.25, G);
    assert!(!state(&world, "arm").is_moving());
}

#[test]
fn dynamic_bodies_accept_targets_and_removal() {
    let mut world = world(&format!(
        "(bodies: [{FLOOR}, (name: \"a\", shape: Box((0.1, 0.1, 0.1)), mass: 1, placement: (position: (0, 0.05, 0))),
            (name: \"b\", shape: Box((0.1, 0.1, 0.1)), mass: 1, placement: (position: (0, 0.15, 0)))])"
    ));
    run(&mut world, 1.5, G);
    assert!(world.all_asleep());
    assert!(world.set_target(world.index_of("a").expect("there"), DVec3::new(5.0, 0.05, 0.0), DQuat::IDENTITY));
    assert!(!state(&world, "a").is_dynamic());
    run(&mut world, 1.5, G);
    assert!((state(&world, "b").centre().y - 0.05).abs() < 5e-3, "{:?}", state(&world, "b"));
    let floor = world.index_of("floor").expect("there");
    assert_eq!(world.remove(floor), "floor");
    assert_eq!(world.index_of("floor"), None);
    run(&mut world, 0.5, G);
    assert!(state(&world, "b").centre().y < -1.0);
}

#[test]
fn two_runs_are_the_same_to_the_bit() {
    let boxes: Vec<String> = (0..12)
        .map(|i| {
            let (x, y, turn) = (0.02 * f64::from(i % 3), 0.1 + 0.13 * f64::from(i), 7 * i);
            format!(
                "(name: \"box {i} \", shape: Box((0.1, 0.08, 0.12)), density: 700,
                  placement: (position: ({x}, {y}, 0), rotation: ({turn}, {turn}, 0)))"
            )
        })
        .collect();
    let text = format!("(bodies: [{FLOOR}, {}])", boxes.join(", "));
    let end = || {
        let mut world = world(&text);
        run(&mut world, 2.0, G);
        let contacts = world.body_contacts().to_vec();
        ((0..13).filter_map(|i| world.state(i).copied()).collect::<Vec<_>>(), contacts)
    };
    let (first, second) = (end(), end());
    assert_eq!(first, second);
    assert!(first.1.windows(2).all(|p| (p[0].a, p[0].b) <= (p[1].a, p[1].b)));
    assert!(first.0.iter().skip(1).all(|s| s.centre().y > 0.03), "none through the floor");
}

#[test]
fn a_fast_body_does_not_pass_through_a_thin_wall() {
    let mut world = world(
        "(bodies: [(name: \"wall\", shape: Box((0.002, 1, 1))),
            (name: \"a\", shape: Ball(0.02), mass: 0.1, velocity: (20, 0, 0), placement: (position: (-0.71, 0, 0)))])",
    );
    run(&mut world, 0.5, DVec3::ZERO);
    assert!(state(&world, "a").centre().x < 0.0, "{:?}", state(&world, "a"));
}

/// Maximum depth (m) of the lowest point of body 1 in the floor at the end of any step, and maximum
/// ratio of its energy to the initial one.
fn deepest(world: &mut RigidWorld, seconds: f64, reach: impl Fn(&BodyState) -> f64) -> (f64, f64) {
    let energy = |s: &BodyState| s.kinetic_energy() + s.gravity_energy(G);
    let first = energy(world.state(1).expect("there"));
    let (mut depth, mut most) = (0.0_f64, 0.0_f64);
    for i in 0..(seconds / DT).round() as u32 {
        world.step(f64::from(i) * DT, DT, G);
        let state = world.state(1).expect("there");
        depth = depth.max(reach(state) - state.centre().y);
        most = most.max(energy(state) / first);
    }
    (depth, most)
}

#[test]
fn fast_bodies_stay_above_the_floor_and_bounce_by_their_restitution() {
    for speed in [0.5, 2.0, 5.0, 20.0] {
        let text = |shape: &str, spin: &str| {
            format!(
                "(contact: (friction: 0.3, restitution: 0.5), bodies: [{FLOOR}, (name: \"a\", shape: {shape}, density: 1000,
                    placement: (position: (0, 0.1, 0)), velocity: (0, -{speed}, 0), spin: {spin})])"
            )
        };
        let half = DVec3::new(0.015, 0.01, 0.02);
        let low = |s: &BodyState| {
            let up = s.rotation().conjugate() * DVec3::Y;
            half.dot(up.abs())
        };
        // Impact speed from the height of fall.
        let landed = (speed * speed + 2.0 * 9.81 * 0.09_f64).sqrt();
        for (shape, spin) in [("Ball(0.012)", "(0, 0, 0)"), ("Box((0.03, 0.02, 0.04))", "(0, 0, 0)")] {
            let mut world = world(&text(shape, spin));
            let round = shape.starts_with("Ball");
            let reach = |s: &BodyState| if round { 0.012 } else { low(s) };
            let mut up = 0.0_f64;
            for i in 0..60 {
                world.step(f64::from(i) * DT, DT, G);
                let state = state(&world, "a");
                assert!(
                    reach(&state) - state.centre().y < 5e-4,
                    "{shape} {speed}: {:e}",
                    reach(&state) - state.centre().y
                );
                if up == 0.0 && state.velocity().y > 0.0 {
                    // Speed at the floor, from the present energy.
                    up = (state.velocity().y.powi(2) + 2.0 * 9.81 * (state.centre().y - reach(&state))).sqrt();
                }
            }
            assert!((up / (0.5 * landed) - 1.0).abs() < 0.1, "{shape} {speed}: {up} of {landed}");
        }
        for spin in ["(30, 20, -50)", "(1, 2, 3)", "(200, 0, 100)"] {
            let (depth, energy) = deepest(&mut world(&text("Box((0.03, 0.02, 0.04))", spin)), 1.0, low);
            assert!(depth < 5e-4 && energy < 1.0 + 1e-6, "{spin} {speed}: {depth:e} {energy}");
        }
    }
}

#[test]
fn a_ball_rolls_on_and_a_sliding_one_ends_rolling_at_five_sevenths() {
    let ball = |velocity: &str, spin: &str| {
        let mut world = world(&format!(
            "(contact: (friction: 0.3, restitution: 0.5), bodies: [{FLOOR}, (name: \"a\", shape: Ball(0.012), density: 1000,
                placement: (position: (0, 0.012, 0)), velocity: {velocity}, spin: {spin})])"
        ));
        let (depth, _) = deepest(&mut world, 1.0, |_| 0.012);
        assert!(depth < 1e-6, "{depth:e}");
        state(&world, "a")
    };
    // Rolling resistance decelerates by 5/7 C g with C = 5e-4.
    let lost = 5.0 / 7.0 * 5e-4 * 9.81;
    let rolling = ball("(3, 0, 0)", "(0, 0, -250)");
    assert!((rolling.velocity().x - 3.0 + lost).abs() < 1e-6, "{rolling:?}");
    assert!((rolling.centre().x - 3.0 + 0.5 * lost).abs() < 1e-3, "{rolling:?}");
    // While the ball slides, friction decelerates it and both torques spin it up: v = 3 - μ g t and
    // ω r = 5/2 (μ - C) g t, until both are equal.
    let (friction, c, g) = (0.3, 5e-4, 9.81);
    let meets = 3.0 / (g * (friction + 2.5 * (friction - c)));
    let wanted = 3.0 - friction * g * meets - lost * (1.0 - meets);
    let slid = ball("(3, 0, 0)", "(0, 0, 0)");
    assert!((slid.velocity().x - wanted).abs() < 1e-4, "{slid:?}, {wanted}");
    assert!((slid.velocity().x + slid.spin().z * 0.012).abs() < 1e-6, "{slid:?}");
}

#[test]
fn a_ball_that_spins_in_place_or_rolls_slowly_comes_to_rest_and_sleeps() {
    let asleep_after = |velocity: &str, spin: &str, seconds: f64| {
        let mut world = world(&format!(
            "(contact: (friction: 0.3), bodies: [{FLOOR}, (name: \"a\", shape: Ball(0.012), density: 1000,
                placement: (position: (0, 0.012, 0)), velocity: {velocity}, spin: {spin})])"
        ));
        run(&mut world, seconds, G);
        (world.is_asleep(1), state(&world, "a"))
    };
    // 5/3 μ A g/r with A = 0.02: 8.2 rad/s².
    let slower = 5.0 / 3.0 * 0.3 * 0.02 * 9.81 / 0.012;
    let (asleep, end) = asleep_after("(0, 0, 0)", "(0, 20, 0)", 1.0);
    assert!(!asleep && (end.spin().y - 20.0 + slower).abs() < 1e-2 * slower, "{end:?}");
    assert!(asleep_after("(0, 0, 0)", "(0, 20, 0)", 20.0 / slower + 0.6).0);
    assert!(asleep_after("(0.01, 0, 0)", "(0, 0, -0.8333)", 0.01 / 0.0035 + 0.6).0);
}
