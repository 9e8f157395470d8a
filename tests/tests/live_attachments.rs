//! Attachment of a running sheet to bodies of the world and of a caller's rigid world.

use glam::{DQuat, DVec3};
use sheetwork::journal::JournalInput;
use sheetwork::rapier3d::prelude::{
    ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, RigidBodyType, Vector,
};
use sheetwork::rigid::RigidView;
use sheetwork::scene::{PathKey, Region, Scene};
use sheetwork::{ForceKind, SheetId, World};
use sheetwork_tests::{journal_repeats, state_hash};

/// Tick of the game, s.
const DT: f64 = 1.0 / 60.0;

/// A card, 20 cm by 10 cm, without gravity unless `gravity`, and the bodies of `bodies`.
fn card(gravity: bool, bodies: &str) -> (Scene, &'static str) {
    let gravity = if gravity { "(0, -9.81, 0)" } else { "(0, 0, 0)" };
    let scene = format!(
        r#"(gravity: {gravity}, sheets: [(name: "card", structure: "shell", grid: (9, 1, 5), size: (0.2, 0.1),
            material: "card", placement: (position: (0, 1, 0)))], bodies: [{bodies}])"#
    );
    (Scene::parse(&scene).expect("a scene"), "card")
}

fn id_of(world: &World) -> SheetId {
    world.sheet_id("card").expect("there")
}

/// Nodes of the edges x = 0 and x = 0.2 m.
fn edge(right: bool) -> impl Iterator<Item = usize> {
    (0..5).map(move |row| 9 * row + if right { 8 } else { 0 })
}

fn at(world: &World, node: usize) -> DVec3 {
    world.sheets()[0].state.x.get(node)
}

#[test]
fn an_edge_follows_a_kinematic_body_exactly_and_is_let_go() {
    let (scene, _) =
        card(true, r#"(name: "arm", shape: Box((0.02, 0.02, 0.1)), placement: (position: (-0.13, 1, 0)))"#);
    let mut world = World::new(&scene).expect("a world");
    let (id, arm) = (id_of(&world), world.body_id("arm").expect("there"));
    assert_eq!(world.attach(id, &Region::Left, arm), Ok(5));
    let start: Vec<DVec3> = edge(false).map(|node| at(&world, node) - DVec3::new(-0.13, 1.0, 0.0)).collect();
    let pose = |time: f64| (DVec3::new(-0.13 + 0.3 * time, 1.0, 0.0), DQuat::from_rotation_x(2.0 * time));
    for _ in 0..60 {
        let end = world.time() + world.dt();
        let (place, turn) = pose(end);
        assert!(world.move_body(arm, place, turn));
        world.step();
        for (node, local) in edge(false).zip(&start) {
            let there = place + turn * *local;
            assert!(at(&world, node).distance(there) < 1e-9, "{} m", at(&world, node).distance(there));
        }
    }
    assert!(world.sheets()[0].is_held(0));
    assert_eq!(world.unpin(id, &Region::Left), Ok(5));
    let height = world.sheets()[0].centre_of_mass().y;
    world.advance(0.3);
    assert!(world.sheets()[0].centre_of_mass().y < height - 0.1);
}

#[test]
fn a_dynamic_body_hangs_on_the_sheet_with_its_weight() {
    let (scene, _) =
        card(true, r#"(name: "ball", shape: Ball(0.01), mass: 0.01, placement: (position: (0.11, 1, 0)))"#);
    let mut world = World::new(&scene).expect("a world");
    let (id, ball) = (id_of(&world), world.body_id("ball").expect("there"));
    let right = Region::Masses(edge(true).map(|node| node as u32).collect());
    assert_eq!(world.pin(id, &sheetwork::scene::PinSpec::fixed(Region::Left)), Ok(5));
    assert_eq!(world.attach(id, &right, ball), Ok(5));
    world.record_forces(true);
    // The impulse of the sheet and that of gravity are the change of momentum of the ball.
    let mut impulse = DVec3::ZERO;
    let steps = 120;
    for _ in 0..steps {
        world.step();
        let pulls = world.forces().iter().filter(|entry| entry.kind == ForceKind::Attachment);
        impulse -= pulls.map(|entry| entry.impulse).sum::<DVec3>();
    }
    let weight = DVec3::Y * (-9.81 * 0.01 * world.dt() * f64::from(steps));
    let momentum = world.get_body(ball).expect("there").velocity() * 0.01;
    assert!(impulse.y > 0.01 && (impulse + weight).distance(momentum) < 1e-9, "{impulse} {weight} {momentum} N s");
    let before = world.get_body(ball).expect("there").velocity();
    world.unpin(id, &right).expect("attached");
    world.advance(0.1);
    let fallen = world.get_body(ball).expect("there").velocity() - before;
    assert!((fallen + DVec3::Y * 0.981).length() < 0.02, "it flies freely: {fallen} m/s");
}

#[test]
fn attachments_continue_from_a_snapshot_and_go_with_it() {
    let body = r#"(name: "arm", shape: Box((0.02, 0.02, 0.1)), placement: (position: (-0.13, 1, 0)))"#;
    let (scene, _) = card(true, body);
    let mut world = World::new(&scene).expect("a world");
    let (id, arm) = (id_of(&world), world.body_id("arm").expect("there"));
    let before = world.serialise();
    world.attach(id, &Region::Left, arm).expect("valid");
    let run = |world: &mut World| {
        for _ in 0..20 {
            let place = DVec3::new(-0.13, 1.0 + 0.2 * world.time(), 0.0);
            world.move_body(arm, place, DQuat::IDENTITY);
            world.step();
        }
        state_hash(world)
    };
    run(&mut world);
    let saved = world.serialise();
    let end = run(&mut world);
    world.deserialise(&before).expect("its own");
    assert!(!world.sheets()[0].is_held(0), "not attached yet");
    world.step();
    world.deserialise(&saved).expect("its own");
    assert!(world.sheets()[0].is_held(0));
    assert_eq!(run(&mut world), end);
    let mut other = World::new(&scene).expect("a world");
    other.deserialise(&saved).expect("of the same scene");
    let arm = other.body_id("arm").expect("there");
    for _ in 0..20 {
        let place = DVec3::new(-0.13, 1.0 + 0.2 * other.time(), 0.0);
        other.move_body(arm, place, DQuat::IDENTITY);
        other.step();
    }
    assert_eq!(state_hash(&other), end);
}

#[test]
fn bad_attachments_change_nothing() {
    let (mut scene, _) = card(true, r#"(name: "arm", shape: Ball(0.01), placement: (position: (-0.13, 1, 0)))"#);
    scene.sheets[0].pins =
        vec![sheetwork::scene::PinSpec { clamp: true, ..sheetwork::scene::PinSpec::fixed(Region::Left) }];
    let mut world = World::new(&scene).expect("a world");
    let (id, arm) = (id_of(&world), world.body_id("arm").expect("there"));
    let hash = state_hash(&world);
    let clamped = world.attach(id, &Region::Left, arm).expect_err("clamped");
    assert!(clamped.to_string().contains("clamp"), "{clamped}");
    world.attach(id, &Region::Masses(vec![1000]), arm).expect_err("no such node");
    assert_eq!(state_hash(&world), hash);
    assert_eq!(world.attach(id, &Region::Right, arm), Ok(5));
    assert!(world.remove_body(arm));
    world.attach(id, &Region::Right, arm).expect_err("removed");
    world.advance(0.2);
    assert!(!world.sheets()[0].is_held(8), "the removed body let it go");
}

/// A game: its rigid world with one body of radius 2 cm, and sheets.
struct Game {
    rigid: PhysicsWorld,
    body: RigidBodyHandle,
    sheets: World,
}

impl Game {
    fn new(gravity: bool, kind: RigidBodyType, place: [f32; 3]) -> Self {
        let sheets = World::without_bodies(&card(gravity, "").0).expect("a world");
        let mut rigid = PhysicsWorld::new();
        rigid.gravity = Vector::new(0.0, if gravity { -9.81 } else { 0.0 }, 0.0);
        rigid.integration_parameters.dt = DT as f32;
        let [x, y, z] = place;
        let body = rigid.insert_body(RigidBodyBuilder::new(kind).translation(Vector::new(x, y, z)).can_sleep(false));
        rigid.insert_collider(ColliderBuilder::ball(0.02).mass(0.02), Some(body));
        Self { rigid, body, sheets }
    }

    fn step(&mut self) {
        self.rigid.step();
        let rigid = &self.rigid;
        let view = RigidView::new(&rigid.broad_phase, &rigid.narrow_phase, &rigid.bodies, &rigid.colliders).pushing();
        self.sheets.advance_with(&view, DT);
        self.sheets.write_lent_bodies(&mut self.rigid.bodies);
    }

    fn place(&self) -> DVec3 {
        self.rigid.bodies[self.body].translation().as_dvec3()
    }
}

#[test]
fn a_lent_kinematic_body_leads_an_edge_and_lets_it_go_when_removed() {
    let mut game = Game::new(true, RigidBodyType::KinematicVelocityBased, [-0.13, 1.0, 0.0]);
    game.rigid.bodies[game.body].set_linvel(Vector::new(0.0, 0.5, 0.0), true);
    let id = id_of(&game.sheets);
    let before: Vec<DVec3> = edge(false).map(|node| at(&game.sheets, node)).collect();
    assert_eq!(game.sheets.attach_lent(id, &Region::Left, (&game.rigid.bodies, game.body)), Ok(5));
    for _ in 0..60 {
        game.step();
    }
    let by = game.place() - DVec3::new(-0.13, 1.0, 0.0);
    assert!((by.y - 0.5).abs() < 1e-3);
    for (node, before) in edge(false).zip(before) {
        // The caller's positions are in single precision.
        assert!(at(&game.sheets, node).distance(before + by) < 1e-6, "{}", at(&game.sheets, node));
    }
    game.rigid.remove_body(game.body);
    let height = game.sheets.sheets()[0].centre_of_mass().y;
    for _ in 0..20 {
        game.step_without_body();
    }
    assert!(game.sheets.sheets()[0].centre_of_mass().y < height - 0.1);
}

impl Game {
    fn step_without_body(&mut self) {
        self.rigid.step();
        let rigid = &self.rigid;
        let view = RigidView::new(&rigid.broad_phase, &rigid.narrow_phase, &rigid.bodies, &rigid.colliders).pushing();
        self.sheets.advance_with(&view, DT);
    }
}

#[test]
fn a_lent_dynamic_body_hangs_on_the_sheet() {
    let mut game = Game::new(true, RigidBodyType::Dynamic, [0.12, 1.0, 0.0]);
    let id = id_of(&game.sheets);
    game.sheets.pin(id, &sheetwork::scene::PinSpec::fixed(Region::Left)).expect("valid");
    assert_eq!(game.sheets.attach_lent(id, &Region::Right, (&game.rigid.bodies, game.body)), Ok(5));
    for _ in 0..240 {
        game.step();
    }
    let hung = game.place();
    assert!(hung.y < 0.95 && hung.distance(DVec3::new(-0.1, 1.0, 0.0)) < 0.24, "{hung}");
    // It keeps its distance from the attached edge.
    let middle = at(&game.sheets, 9 * 2 + 8);
    assert!((hung.distance(middle) - 0.02).abs() < 1e-4, "{}", hung.distance(middle));
    game.sheets.unpin(id, &Region::Right).expect("attached");
    for _ in 0..20 {
        game.step();
    }
    assert!(game.place().y < hung.y - 0.2, "{}", game.place());
}

#[test]
fn a_free_sheet_and_a_lent_body_keep_their_common_momentum() {
    let mut game = Game::new(false, RigidBodyType::Dynamic, [0.12, 1.0, 0.0]);
    let id = id_of(&game.sheets);
    game.sheets.attach_lent(id, &Region::Right, (&game.rigid.bodies, game.body)).expect("valid");
    game.rigid.bodies[game.body].set_linvel(Vector::new(0.0, 0.3, 0.0), true);
    for _ in 0..60 {
        game.step();
    }
    let velocity = game.rigid.bodies[game.body].linvel().as_dvec3();
    let total = game.sheets.sheets()[0].momentum() + velocity * 0.02;
    assert!((total.y - 0.02 * 0.3).abs() < 2e-3 * 0.006 && total.x.abs() < 1e-5, "{total}");
    assert!(velocity.y < 0.299, "the sheet is taken along: {velocity}");
}

#[test]
fn a_journal_repeats_changes_of_a_running_sheet() {
    let body = r#"(name: "arm", shape: Box((0.02, 0.02, 0.1)), placement: (position: (-0.13, 1, 0)))"#;
    let mut world = World::new(&card(true, body).0).expect("a world");
    let sheet = || "card".to_owned();
    let key = |time, offset| PathKey { time, offset, ..PathKey::default() };
    let path = vec![key(0.0, DVec3::ZERO), key(0.1, DVec3::Y * 0.02)];
    let inputs = [
        JournalInput::Attach { sheet: sheet(), region: Region::Left, body: "arm".to_owned() },
        JournalInput::Pin { sheet: sheet(), region: Region::Right, path, until: Some(0.3) },
        JournalInput::Cut { sheet: sheet(), from: (0.55, 0.0), to: (0.55, 0.6) },
        JournalInput::Unpin { sheet: sheet(), region: Region::Left },
        JournalInput::MoveSheet { sheet: sheet(), by: DVec3::X * 0.1, rotation: DQuat::from_rotation_y(0.3) },
    ];
    journal_repeats(&mut world, inputs, 3);
}
