//! Scenes of playing cards: a pack that is dropped, and a house of three storeys that stands.
//! Lengths in m.
//!
//! Two cards of total weight W lean against each other at the angle θ from the vertical, with a
//! load P on their top edges. Their feet press on the ground with W + P and are pushed apart by
//! (W/2 + P) tan θ. They stand where
//!
//!   tan θ (W/2 + P)/(W + P) < μ,
//!
//! which holds for any load where tan θ < μ. At 15° tan θ is 0.268.
//!
//! All objects are placed at touching distance; cards are as thick on their edges as on their
//! faces. Two horizontal cards over three pairs overlap in the middle: the second lies on the
//! first, and the cards under its other end lean less, so that their tops are higher by one
//! thickness and the second card is level.

use std::fmt::Write;

use glam::DVec3;

use sheetwork::scene::Placement;

/// Length of a card, along the height of a leaning one.
pub const LENGTH: f64 = 0.088;
/// Width of a card.
pub const WIDTH: f64 = 0.063;
/// Thickness of a card.
pub const THICKNESS: f64 = 3e-4;
/// Friction between cards, and of cards on the floor.
pub const FRICTION: f64 = 0.35;
/// Lean of a card from the vertical, degrees.
pub const LEAN: f64 = 15.0;

/// Gap between touching surfaces, larger than the rounding of the numbers in a file.
const AIR: f64 = 1e-6;
/// Distance of the mid-surfaces of two touching cards.
const TOUCH: f64 = THICKNESS + AIR;
/// Distance on the ground between the feet of neighbours.
const BETWEEN_FEET: f64 = 4e-3;
/// Distance between the cards of a pack.
const LOOSE: f64 = 5e-5;
/// Drop height of a pack.
pub const DROP: f64 = 0.03;
/// Maximum rotation (degrees) and shift of the cards of a pack.
const TURN: f64 = 2.0;
const SHIFT: f64 = 5e-4;

/// Kind of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardScene {
    /// 52 cards dropped as a pack.
    Pack,
    /// A house of three storeys.
    House,
    /// The house, and a ball thrown at it.
    HouseAndBall,
}

/// Cards of a pack, lowest first: level, with small pseudo-random rotations and shifts.
pub fn pack(count: u32) -> Vec<Placement> {
    // Linear congruential sequence (Knuth's MMIX), the same on every run.
    let mut seed = 52_u64;
    let mut signed = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count)
        .map(|i| Placement {
            position: DVec3::new(
                SHIFT * signed(),
                DROP + 0.5 * THICKNESS + f64::from(i) * (THICKNESS + LOOSE),
                SHIFT * signed(),
            ),
            rotation: DVec3::new(0.0, TURN * signed(), 0.0),
        })
        .collect()
}

/// Cards of a house of three storeys: three leaning pairs, two horizontal cards, two pairs, one
/// horizontal card, one pair.
pub fn house() -> Vec<Placement> {
    let upright = LENGTH * LEAN.to_radians().cos();
    let pitch = 2.0 * LENGTH * LEAN.to_radians().sin() + TOUCH + BETWEEN_FEET;
    let (ground, mut cards) = (0.5 * THICKNESS + AIR, Vec::new());
    let top = ground + upright;
    // Heights of the horizontal cards of the first storey; the second lies on the first.
    let (first, second) = (top + TOUCH, top + 2.0 * TOUCH);
    // Horizontal cards are shifted across a little, so that no side of a card is flush with
    // another's.
    pair(&mut cards, -pitch, (ground, ground), top, 0.0);
    pair(&mut cards, 0.0, (ground, ground), top, 0.0);
    pair(&mut cards, pitch, (ground, ground), second - TOUCH, 0.0);
    lying(&mut cards, -0.5 * pitch, first, 1.2e-3);
    lying(&mut cards, 0.5 * pitch, second, -1.0e-3);
    let top = second + TOUCH + upright;
    pair(&mut cards, -0.5 * pitch, (first + TOUCH, second + TOUCH), top, 4e-4);
    pair(&mut cards, 0.5 * pitch, (second + TOUCH, second + TOUCH), top, 4e-4);
    lying(&mut cards, 0.0, top + TOUCH, -7e-4);
    let floor = top + 2.0 * TOUCH;
    pair(&mut cards, 0.0, (floor, floor), floor + upright, 3e-4);
    cards
}

/// Two cards that lean against each other at x, with feet at two heights and tops at one.
fn pair(cards: &mut Vec<Placement>, x: f64, feet: (f64, f64), top: f64, z: f64) {
    for (foot, side) in [(feet.0, -1.0), (feet.1, 1.0)] {
        let lean = ((top - foot) / LENGTH).acos();
        let edge = DVec3::new(x + side * 0.5 * TOUCH, top, z);
        let down = DVec3::new(side * lean.sin(), -lean.cos(), 0.0);
        cards.push(Placement {
            position: edge + down * (0.5 * LENGTH),
            rotation: DVec3::new(0.0, 0.0, 90.0 + side * lean.to_degrees()),
        });
    }
}

fn lying(cards: &mut Vec<Placement>, x: f64, y: f64, z: f64) {
    cards.push(Placement { position: DVec3::new(x, y, z), rotation: DVec3::ZERO });
}

impl CardScene {
    /// Text of the scene file.
    pub fn text(self) -> String {
        let (name, description, camera, grid, duration) = match self {
            Self::Pack => (
                "pack of cards",
                "52 playing cards are dropped as a pack and come to rest on one another.",
                "(eye: (0.12, 0.1, 0.22), target: (0, 0.01, 0))",
                "(5, 1, 4)",
                4,
            ),
            Self::House => (
                "house of cards",
                "Fifteen playing cards stand as a house of three storeys, by friction alone.",
                "(eye: (0.24, 0.2, 0.47), target: (0, 0.13, 0))",
                "(5, 1, 3)",
                10,
            ),
            Self::HouseAndBall => (
                "house of cards and ball",
                "A ball is thrown at a house of cards of three storeys, and it falls.",
                "(eye: (0.38, 0.25, 0.68), target: (0.1, 0.09, 0))",
                "(5, 1, 3)",
                4,
            ),
        };
        let (cards, flag) = match self {
            Self::Pack => (pack(52), "pack"),
            Self::House => (house(), "house"),
            Self::HouseAndBall => (house(), "house-ball"),
        };
        let sheets: String = cards.iter().enumerate().map(|(i, card)| sheet(i, card, grid)).collect();
        // Cards hit by the ball slide far.
        let right = if self == Self::HouseAndBall { 0.7 } else { 0.4 };
        let ball = if self == Self::HouseAndBall { BALL } else { "" };
        format!(
            "// {description}\n//\n// Made by `sheetwork generate --cards {flag}`.\n(\n    name: \"{name}\",\n    description: \
             \"{description}\",\n    engine: \"tr-bdf2\",\n    dt: 0.0166666666666667,\n    duration: {duration},\n    room: (x: \
             (-0.4, {right}), y: (0, 0.4), z: (-0.3, 0.3), grid: 0.02, back_wall: false),\n    contact: (friction: {FRICTION}, \
             restitution: 0.1),\n    sheets: [\n{sheets}    ],\n{ball}    camera: {camera},\n)\n"
        )
    }
}

/// Wooden ball, as heavy as the house; it meets the second storey a quarter of a second after the
/// throw.
const BALL: &str = "    bodies: [(name: \"ball\", shape: Ball(0.02), density: 650, placement: (position: (-0.85, 0.06, 0.004)), \
                    velocity: (3, 1.6, 0))],\n";

fn sheet(index: usize, card: &Placement, grid: &str) -> String {
    let mut text = String::new();
    let (p, r) = (card.position, card.rotation);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "        (name: \"card {}\", structure: \"shell\", grid: {grid}, size: ({LENGTH}, {WIDTH}), material: \"playing-card\", \
         placement: (position: ({}, {}, {}), rotation: ({}, {}, {}))),",
        index + 1,
        number(p.x),
        number(p.y),
        number(p.z),
        number(r.x),
        number(r.y),
        number(r.z)
    );
    text
}

/// Number to nine decimals, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::World;
    use sheetwork::collision::overlap::pairs;
    use sheetwork::scene::{Scene, material};

    fn world(cards: CardScene) -> World {
        let scene = Scene::parse(&cards.text()).unwrap_or_else(|e| panic!("{e}"));
        World::new(&scene).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn every_card_leans_within_the_cone_of_friction() {
        let worst = house().iter().map(|c| (c.rotation.z - 90.0).abs()).filter(|a| *a < 45.0).fold(0.0, f64::max);
        assert!((worst - LEAN).abs() < 1e-9 && worst.to_radians().tan() < 0.8 * FRICTION, "{worst}");
    }

    #[test]
    fn the_house_stands_at_touching_distance() {
        let world = world(CardScene::House);
        assert_eq!(world.sheets().len(), 15);
        let sheets = world.sheets();
        assert!(sheets.iter().all(|s| (s.material().thickness - THICKNESS).abs() < 1e-15));
        let touching = pairs(sheets, 3.0 * AIR);
        // No cards overlap; touching are 6 pairs of tops, 11 lids with tops or each other, and 6
        // feet.
        let names: Vec<(usize, usize)> = touching.iter().map(|(i, j, _)| (i + 1, j + 1)).collect();
        let tops = [(1, 2), (3, 4), (5, 6), (9, 10), (11, 12), (14, 15)];
        let lids = [(1, 7), (2, 7), (3, 7), (4, 7), (5, 8), (6, 8), (7, 8), (9, 13), (10, 13), (11, 13), (12, 13)];
        let feet = [(7, 9), (8, 10), (8, 11), (8, 12), (13, 14), (13, 15)];
        let mut wanted: Vec<_> = tops.into_iter().chain(lids).chain(feet).collect();
        wanted.sort_unstable();
        assert_eq!(names, wanted);
        assert!(touching.iter().all(|(_, _, overlap)| *overlap <= 0.0), "{touching:?}");
        let lowest = sheets.iter().flat_map(|s| s.state.x.y.iter().copied()).fold(f64::INFINITY, f64::min);
        assert!((lowest - 0.5 * THICKNESS - AIR).abs() < 1e-8, "{lowest}");
    }

    #[test]
    fn the_pack_is_loose_and_whole() {
        let world = world(CardScene::Pack);
        assert_eq!(world.sheets().len(), 52);
        assert!(pairs(world.sheets(), 0.0).is_empty());
        let card = material::by_name("playing-card").expect("there");
        assert_eq!((card.young, card.density, card.thickness), (3e9, 850.0, THICKNESS));
    }

    #[test]
    fn the_ball_meets_the_second_storey() {
        let scene = Scene::parse(&CardScene::HouseAndBall.text()).unwrap_or_else(|e| panic!("{e}"));
        let ball = &scene.bodies[0];
        let time = -ball.placement.position.x / ball.velocity.x;
        let height = ball.placement.position.y + ball.velocity.y * time + 0.5 * scene.gravity.y * time * time;
        assert!((0.09..0.16).contains(&height), "{height}");
    }
}
