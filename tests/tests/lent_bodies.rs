//! Dynamic bodies of a caller's Rapier world that sheets push.

use glam::DVec3;
use sheetwork::World;
use sheetwork::rapier3d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, Vector};
use sheetwork::rigid::RigidView;
use sheetwork::scene::{Region, Scene};

/// Tick of the game, s.
const DT: f64 = 1.0 / 60.0;

/// Radius of the ball, m.
const RADIUS: f32 = 0.02;

/// A game: its rigid world with a ball, and sheets.
struct Game {
    rigid: PhysicsWorld,
    ball: RigidBodyHandle,
    sheets: World,
}

impl Game {
    /// A ball of `mass` (kg) at `place` (m) with `velocity` (m/s), and the sheets of `scene`.
    fn new(scene: &str, gravity: f32, mass: f32, place: [f32; 3], velocity: [f32; 3]) -> Self {
        let scene = Scene::parse(scene).expect("a scene");
        let sheets = World::without_bodies(&scene).expect("a world");
        let mut rigid = PhysicsWorld::new();
        rigid.gravity = Vector::new(0.0, -gravity, 0.0);
        rigid.integration_parameters.dt = DT as f32;
        let vector = |[x, y, z]: [f32; 3]| Vector::new(x, y, z);
        let body = RigidBodyBuilder::dynamic().translation(vector(place)).linvel(vector(velocity)).can_sleep(false);
        let ball = rigid.insert_body(body);
        rigid.insert_collider(ColliderBuilder::ball(RADIUS).mass(mass), Some(ball));
        Self { rigid, ball, sheets }
    }

    fn step(&mut self, parts: u32) {
        self.rigid.step();
        let rigid = &self.rigid;
        let view = RigidView::new(&rigid.broad_phase, &rigid.narrow_phase, &rigid.bodies, &rigid.colliders).pushing();
        self.sheets.advance_with(&view, DT);
        assert_eq!(self.sheets.steps() % u64::from(parts), 0);
        self.sheets.write_lent_bodies(&mut self.rigid.bodies);
    }

    fn ball(&self) -> (DVec3, DVec3) {
        let body = &self.rigid.bodies[self.ball];
        (body.translation().as_dvec3(), body.linvel().as_dvec3())
    }

    fn momentum(&self) -> DVec3 {
        let sheets: DVec3 = self.sheets.sheets().iter().map(|sheet| sheet.momentum()).sum();
        sheets + self.ball().1 * f64::from(self.rigid.bodies[self.ball].mass())
    }
}

/// A steel foil of 0.1 mm in a frame.
const FOIL: &str = r#"(contact: (friction: 0.3, restitution: 0), sheets: [(name: "foil", structure: "shell",
    grid: (11, 1, 11), size: (0.2, 0.2), pins: [(region: Border)],
    material: (young: 2e11, poisson: 0.3, density: 7800, thickness: 1e-4, damping_ratio: 0.1))])"#;

#[test]
fn a_lent_ball_does_not_pass_through_a_clamped_foil_at_any_speed() {
    for speed in [1.0, 5.0, 20.0, 100.0] {
        let mut game = Game::new(FOIL, 9.81, 0.01, [0.011, 0.2, 0.007], [0.0, -speed, 0.0]);
        for _ in 0..30 {
            game.step(1);
            let (place, velocity) = game.ball();
            assert!(place.y > 0.0 && velocity.is_finite(), "{speed} m/s: {place} m, {velocity} m/s");
        }
    }
}

/// Assert that an own ball of 10 g at 1 to 100 m/s stays above the foil of `world_of`, which gets
/// the description of the ball.
fn assert_own_ball_stays_above(world_of: impl Fn(&str) -> World) {
    for speed in [1.0, 5.0, 20.0, 100.0] {
        let bodies = format!(
            r#"(name: "ball", shape: Ball({RADIUS}), mass: 0.01, placement: (position: (0.011, 0.2, 0.007)),
            velocity: (0, {}, 0))"#,
            -speed
        );
        let mut world = world_of(&bodies);
        let ball = world.body_id("ball").expect("there");
        for _ in 0..30 {
            world.advance(DT);
            let state = world.get_body(ball).expect("there");
            let (place, velocity) = (state.centre(), state.velocity());
            assert!(place.y > 0.0 && velocity.is_finite(), "{speed} m/s: {place} m, {velocity} m/s");
        }
    }
}

#[test]
fn an_own_ball_does_not_pass_through_a_clamped_foil_at_any_speed() {
    let clamped = |ball: &str| format!("{}, bodies: [{ball}])", FOIL.strip_suffix(')').expect("a scene"));
    assert_own_ball_stays_above(|ball| World::new(&Scene::parse(&clamped(ball)).expect("a scene")).expect("a world"));
}

#[test]
fn an_own_ball_does_not_pass_through_a_foil_that_is_glued_to_a_frame() {
    assert_own_ball_stays_above(|ball| {
        let free = FOIL.replace(", pins: [(region: Border)]", "");
        let frame = r#"(name: "frame", shape: Box((0.02, 0.02, 0.02)), placement: (position: (0.3, 0, 0)))"#;
        let text = format!("{}, bodies: [{ball}, {frame}])", free.strip_suffix(')').expect("a scene"));
        let mut world = World::new(&Scene::parse(&text).expect("a scene")).expect("a world");
        let (foil, frame) = (world.sheet_id("foil").expect("there"), world.body_id("frame").expect("there"));
        assert_eq!(world.attach(foil, &Region::Border, frame), Ok(40));
        world
    });
}

#[test]
fn a_lent_ball_does_not_pass_through_a_foil_that_is_glued_to_a_lent_frame() {
    for speed in [1.0, 5.0, 20.0, 100.0] {
        let free = FOIL.replace(", pins: [(region: Border)]", "");
        let mut game = Game::new(&free, 9.81, 0.01, [0.011, 0.2, 0.007], [0.0, -speed, 0.0]);
        let frame = RigidBodyBuilder::kinematic_position_based().translation(Vector::new(0.3, 0.0, 0.0));
        let frame = game.rigid.insert_body(frame);
        game.rigid.insert_collider(ColliderBuilder::cuboid(0.01, 0.01, 0.01), Some(frame));
        let foil = game.sheets.sheet_id("foil").expect("there");
        assert_eq!(game.sheets.attach_lent(foil, &Region::Border, (&game.rigid.bodies, frame)), Ok(40));
        for _ in 0..30 {
            game.step(1);
            let (place, velocity) = game.ball();
            assert!(place.y > 0.0 && velocity.is_finite(), "{speed} m/s: {place} m, {velocity} m/s");
        }
    }
}

#[test]
fn a_lent_ball_comes_to_rest_on_a_clamped_foil() {
    let mut game = Game::new(FOIL, 9.81, 0.05, [0.0, 0.05, 0.0], [0.0; 3]);
    (0..300).for_each(|_| game.step(1));
    let (place, velocity) = game.ball();
    // The foil sags by 0.7 mm under the weight.
    assert!((0.0185..0.0201).contains(&place.y) && velocity.length() < 0.05, "{place} m, {velocity} m/s");
}

#[test]
fn a_lent_ball_and_a_free_sheet_keep_their_momentum() {
    let card = r#"(gravity: (0, 0, 0), sheets: [(name: "card", structure: "shell", grid: (11, 1, 8), size: (0.1, 0.07),
        material: "card")])"#;
    for dt in [DT, DT / 4.0] {
        let mut game = Game::new(card, 0.0, 0.02, [0.02, 0.05, 0.01], [0.3, -2.0, 0.0]);
        game.sheets.set("dt", &dt.to_string()).expect("in range");
        let before = game.momentum();
        (0..30).for_each(|_| game.step((DT / dt).round() as u32));
        let after = game.momentum();
        assert!(game.sheets.sheets()[0].momentum().length() > 1e-3, "the ball has missed");
        assert!(after.distance(before) < 1e-5 * before.length(), "{before} {after}");
    }
}

#[test]
fn a_lent_ball_far_from_sheets_keeps_the_motion_of_its_owner() {
    let mut game = Game::new(FOIL, 9.81, 0.01, [5.0, 0.2, 0.0], [0.1, 0.2, 0.3]);
    let mut alone = Game::new("()", 9.81, 0.01, [5.0, 0.2, 0.0], [0.1, 0.2, 0.3]);
    for _ in 0..60 {
        game.step(1);
        alone.rigid.step();
        assert_eq!(game.ball(), alone.ball());
    }
}
