//! Joints, motors, forces, collision groups and sensors of the world's own bodies.

use glam::DVec3;
use sheetwork::rapier3d::prelude::{
    GenericJoint, Group, InteractionGroups, InteractionTestMode, JointAxis, PrismaticJointBuilder,
    RevoluteJointBuilder, SphericalJointBuilder, Vector,
};
use sheetwork::scene::Scene;
use sheetwork::{BodyId, EventKind, StepOutcome, World};

/// A world with these bodies, and with a sheet if `sheet` is not empty.
fn world_with(gravity: bool, bodies: &str, sheet: &str) -> World {
    let gravity = if gravity { "(0, -9.81, 0)" } else { "(0, 0, 0)" };
    let sheets = if sheet.is_empty() { String::new() } else { format!("sheets: [{sheet}],") };
    let text = format!("(gravity: {gravity}, dt: 0.004, {sheets} bodies: [{bodies}])");
    World::new(&Scene::parse(&text).expect("a scene")).expect("a world")
}

fn id(world: &World, name: &str) -> BodyId {
    world.body_id(name).expect("there")
}

fn centre(world: &World, name: &str) -> DVec3 {
    world.get_body(id(world, name)).expect("there").centre()
}

/// Rods hang from a post by a hinge along z at their upper end.
const ROD: &str = r#"(name: "post", shape: Box((0.02, 0.02, 0.02)), placement: (position: (0, 2, 0))),
    (name: "rod", shape: Box((0.4, 0.02, 0.02)), mass: 0.5, placement: (position: (0.2, 2, 0)))"#;

fn hinge() -> GenericJoint {
    let joint = RevoluteJointBuilder::new(Vector::Z).local_anchor1(Vector::ZERO).local_anchor2(Vector::X * -0.2);
    joint.contacts_enabled(false).build().into()
}

#[test]
fn a_rod_on_a_hinge_swings_with_the_period_of_a_physical_pendulum() {
    let text = ROD.replace("(position: (0.2, 2, 0))", "(position: (0.0199, 1.80099, 0), rotation: (0, 0, -84.29))");
    let mut world = world_with(true, &text, "");
    let joint = world.insert_joint(id(&world, "post"), id(&world, "rod"), hinge()).expect("a hinge");
    assert!(world.joint(joint).is_some());
    let (mut crossings, mut before) = (Vec::new(), centre(&world, "rod").x);
    for _ in 0..1500 {
        world.step();
        let place = centre(&world, "rod");
        assert!(((place - DVec3::new(0.0, 2.0, 0.0)).length() - 0.2).abs() < 2e-4, "{place}");
        if before > 0.0 && place.x <= 0.0 {
            crossings.push(world.time());
        }
        before = place.x;
    }
    // T = 2π sqrt(I/(m g d)) (1 + θ²/16), with I = m (L² + h²)/12 + m d² and θ = 0.1 rad.
    let inertia = (0.4_f64.powi(2) + 0.02_f64.powi(2)) / 12.0 + 0.2_f64.powi(2);
    let period = std::f64::consts::TAU * (inertia / (9.81 * 0.2)).sqrt() * (1.0 + 0.01 / 16.0);
    let measured = (crossings[4] - crossings[0]) / 4.0;
    assert!((measured / period - 1.0).abs() < 0.01, "{measured} s, {period} s");
}

#[test]
fn motors_limits_and_removal_act() {
    let mut world = world_with(false, ROD, "");
    let (post, rod) = (id(&world, "post"), id(&world, "rod"));
    let joint = world.insert_joint(post, rod, hinge()).expect("a hinge");
    let mut driven = hinge();
    driven.set_motor_velocity(JointAxis::AngX, 2.0, 100.0);
    assert_eq!(world.set_joint(joint, driven), Ok(true));
    world.advance(1.0);
    let spin = world.get_body(rod).expect("there").spin();
    assert!((spin.z - 2.0).abs() < 0.02, "{spin}");
    assert!(world.remove_joint(joint) && !world.remove_joint(joint) && world.joint(joint).is_none());
    // Rod and post overlap, which the joint allowed.
    assert!(world.remove_body(post));
    let before = centre(&world, "rod");
    world.advance(0.5);
    // Free: the centre goes on with ω r.
    let speed = centre(&world, "rod").distance(before) / 0.5;
    assert!((speed - 0.4).abs() < 0.01, "{speed} m/s");

    let slider = PrismaticJointBuilder::new(Vector::X).limits([-0.1, 0.3]);
    let bodies = r#"(name: "rail", shape: Box((0.02, 0.02, 0.02)), placement: (position: (0, 1, 0.5))),
        (name: "cart", shape: Ball(0.05), mass: 1, placement: (position: (0, 1, 0)), velocity: (1, 0, 0))"#;
    let mut world = world_with(true, bodies, "");
    let (rail, cart) = (id(&world, "rail"), id(&world, "cart"));
    world.insert_joint(rail, cart, slider.local_anchor1(Vector::Z * -0.5)).expect("a slider");
    world.advance(2.0);
    let place = centre(&world, "cart");
    assert!(place.x < 0.305 && place.x > -0.105 && (place.y - 1.0).abs() < 1e-3, "{place}");
}

#[test]
fn a_rod_that_swings_through_its_post_gains_no_energy() {
    for dt in [0.001, 0.004, 1.0 / 60.0] {
        let mut world = world_with(true, ROD, "");
        world.set("dt", &dt.to_string()).expect("in range");
        let (post, rod) = (id(&world, "post"), id(&world, "rod"));
        world.insert_joint(post, rod, hinge()).expect("a hinge");
        for _ in 0..20 {
            world.advance(0.15);
            let state = world.get_body(rod).expect("there");
            let energy = state.kinetic_energy() + 0.5 * 9.81 * (state.centre().y - 2.0);
            // Part of the 0.98 J between its highest and its lowest place.
            assert!(energy < 1e-3 && energy > -0.2, "{energy} J with steps of {dt} s");
        }
    }
}

#[test]
fn a_joint_whose_forces_exceed_all_numbers_is_removed_and_told() {
    let mut world = world_with(true, ROD, "");
    let (post, rod) = (id(&world, "post"), id(&world, "rod"));
    let mut driven = hinge();
    driven.set_motor_velocity(JointAxis::AngX, f32::MAX, f32::MAX);
    let joint = world.insert_joint(post, rod, driven).expect("finite");
    let mut told = 0;
    for _ in 0..250 {
        let report = world.step();
        told += report.lost_joints;
        assert_eq!(report.lost_joints > 0, report.outcome() == StepOutcome::Stopped);
        assert!(world.get_body(rod).expect("there").centre().is_finite());
    }
    assert!(told == 1 && world.joint(joint).is_none(), "{told}");
}

#[test]
fn jointed_bodies_sleep_and_wake_together_and_continue_from_a_snapshot() {
    let bodies = r#"(name: "hook", shape: Box((0.02, 0.02, 0.02)), placement: (position: (0, 2, 0))),
        (name: "upper", shape: Ball(0.03), mass: 0.2, placement: (position: (0, 1.8, 0))),
        (name: "lower", shape: Ball(0.03), mass: 0.2, placement: (position: (0, 1.6, 0)))"#;
    let mut world = world_with(true, bodies, "");
    let link = || SphericalJointBuilder::new().local_anchor1(Vector::Y * -0.1).local_anchor2(Vector::Y * 0.1);
    let names = ["hook", "upper", "lower"].map(|name| id(&world, name));
    let first = world.insert_joint(names[0], names[1], link()).expect("a joint");
    world.insert_joint(names[1], names[2], link()).expect("a joint");
    world.advance(4.0);
    let asleep = |world: &World, name: &str| {
        let rigid = world.rigid().expect("bodies");
        rigid.is_asleep(rigid.index_of(name).expect("there"))
    };
    assert!(asleep(&world, "upper") && asleep(&world, "lower"), "{}", centre(&world, "lower"));
    world.apply_body_impulse(names[2], DVec3::X * 0.1, None).expect("a dynamic body");
    world.step();
    world.step();
    assert!(!asleep(&world, "upper") && !asleep(&world, "lower"));
    let saved = world.serialise();
    let run = |world: &mut World| {
        world.advance(1.0);
        (centre(world, "upper").to_array(), centre(world, "lower").to_array())
    };
    let once = run(&mut world);
    assert!(world.remove_joint(first));
    world.deserialise(&saved).expect("its own snapshot");
    assert!(world.joint(first).is_some(), "restored with the world");
    assert_eq!(run(&mut world), once);
    assert!(world.remove_body(names[1]) && world.joint(first).is_none());
    world.advance(0.5);
    assert!(centre(&world, "lower").y < 1.0, "it falls");
}

#[test]
fn forces_and_impulses_move_a_body_exactly() {
    let ball = r#"(name: "ball", shape: Ball(0.1), mass: 2, placement: (position: (0, 5, 0)))"#;
    let mut world = world_with(false, ball, "");
    let ball = id(&world, "ball");
    world.apply_body_force(ball, DVec3::new(3.0, 0.0, 0.0), None).expect("a dynamic body");
    world.advance(0.5);
    // a t²/2 with a = 1.5 m/s².
    let state = *world.get_body(ball).expect("there");
    assert!((state.centre().x - 0.1875).abs() < 1e-12 && (state.velocity().x - 0.75).abs() < 1e-12, "{state:?}");
    world.advance(0.5);
    assert!((world.get_body(ball).expect("there").velocity().x - 0.75).abs() < 1e-12, "a force ends with its advance");
    let place = world.get_body(ball).expect("there").centre() + DVec3::Y * 0.1;
    world.apply_body_impulse(ball, DVec3::X, Some(place)).expect("a dynamic body");
    let state = *world.get_body(ball).expect("there");
    // r × p / I with I = 2/5 m r².
    assert!((state.velocity().x - 1.25).abs() < 1e-12 && (state.spin().z + 0.1 / 0.008).abs() < 1e-9, "{state:?}");
    world.set_body_velocity(ball, DVec3::ZERO, DVec3::ZERO).expect("a dynamic body");
    let before = centre(&world, "ball");
    world.advance(0.1);
    assert_eq!(centre(&world, "ball"), before);
}

/// A film above a box.
const FILM: &str = r#"(name: "film", structure: "shell", grid: (7, 1, 7), size: (0.1, 0.1), material: "card",
    placement: (position: (-0.05, 1.02, -0.05)))"#;
const BLOCK: &str = r#"(name: "block", shape: Box((0.3, 0.02, 0.3)), placement: (position: (0, 1, 0)))"#;

#[test]
fn a_sheet_falls_through_a_sensor_which_stays_one_in_a_snapshot() {
    let mut world = world_with(true, BLOCK, FILM);
    world.set_penetration_check(true);
    let block = id(&world, "block");
    let fresh = world.serialise();
    world.advance(0.5);
    assert!(world.sheets()[0].centre_of_mass().y > 1.0, "it lies on the block");
    world.set_body_sensor(block, true).expect("a body");
    let saved = world.serialise();
    world.advance(0.06);
    let middle = world.sheets()[0].centre_of_mass().y;
    assert!(middle < 1.01 && middle > 0.99, "{middle}");
    let error = world.set_body_sensor(block, false).expect_err("the sheet is in it");
    assert!(error.to_string().contains("a sheet is in the body"), "{error}");
    world.advance(0.5);
    assert!(world.sheets()[0].centre_of_mass().y < 0.5);
    let told = world.events_since(0).iter().any(|event| event.kind == EventKind::Penetration);
    assert!(!told, "a sensor is not penetrated");
    world.set_body_sensor(block, false).expect("the sheet has left it");
    world.deserialise(&saved).expect("its own snapshot");
    world.advance(0.5);
    assert!(world.sheets()[0].centre_of_mass().y < 0.5, "a sensor again");
    world.deserialise(&fresh).expect("its own snapshot");
    world.advance(0.5);
    assert!(world.sheets()[0].centre_of_mass().y > 1.0, "solid again");
}

#[test]
fn bodies_of_separate_groups_pass_each_other() {
    let ball = r#"(name: "ball", shape: Ball(0.05), mass: 1, placement: (position: (0, 1.2, 0)))"#;
    let box_on = r#"(name: "crate", shape: Box((0.1, 0.1, 0.1)), mass: 1, placement: (position: (0.08, 1.2, 0.09)))"#;
    let mut world = world_with(true, &format!("{BLOCK}, {ball}, {box_on}"), "");
    let groups = |own, others| InteractionGroups::new(own, others, InteractionTestMode::And);
    world.set_body_groups(id(&world, "ball"), groups(Group::GROUP_2, Group::GROUP_2)).expect("a body");
    world.set_body_groups(id(&world, "block"), groups(Group::GROUP_1, Group::GROUP_1)).expect("a body");
    world.advance(1.0);
    assert!(centre(&world, "ball").y < 0.0, "{}", centre(&world, "ball"));
    assert!(centre(&world, "crate").y > 1.0, "{}", centre(&world, "crate"));
}

#[test]
fn mistakes_are_refused() {
    let mut world = world_with(true, ROD, "");
    let (post, rod) = (id(&world, "post"), id(&world, "rod"));
    let text = |error: sheetwork::InputError| error.to_string();
    assert!(text(world.insert_joint(post, post, hinge()).expect_err("one body")).contains("two different bodies"));
    let mut broken = hinge();
    broken.motors[3].target_vel = f32::NAN;
    assert!(text(world.insert_joint(post, rod, broken).expect_err("not a number")).contains("motor"));
    let mut crossed = hinge();
    crossed.set_limits(JointAxis::AngX, [1.0, -1.0]);
    assert!(text(world.insert_joint(post, rod, crossed).expect_err("crossed")).contains("minimum above its maximum"));
    assert!(text(world.apply_body_force(post, DVec3::X, None).expect_err("static")).contains("not dynamic"));
    assert!(text(world.apply_body_force(rod, DVec3::NAN, None).expect_err("NaN")).contains("N"));
    assert!(text(world.apply_body_impulse(rod, DVec3::X * 1e9, None).expect_err("huge")).contains("N s"));
    assert!(text(world.set_body_velocity(rod, DVec3::X * 1e9, DVec3::ZERO).expect_err("huge")).contains("m/s"));
    assert!(world.remove_body(rod));
    assert!(text(world.insert_joint(post, rod, hinge()).expect_err("removed")).contains("removed"));
}
