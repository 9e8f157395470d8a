//! Force that drags a sheet over a floor at constant speed, with a box on it: F = μ N (Coulomb).
//!
//! F is the recorded force of the pins at the right edge, N the recorded normal force of the floor;
//! N and the vertical force of the pins carry the weight of sheet and box. The floor feels the
//! reaction of both.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigResult, Runner, Setup, body, ground};
use sheetwork::scene::{BodySpec, PathKey, PinSpec, Placement, Region, Shape};
use sheetwork::{ForceKind, World};

/// Time before the measurement, s, and its duration, s.
const SETTLING_TIME: f64 = 1.0;
const MEASUREMENT_TIME: f64 = 0.5;
/// Mass of the box, kg; its side over the length of the sheet, its height over its side.
const BOX_MASS: f64 = 0.1;
const BOX_RATIO: f64 = 0.4;
const BOX_HEIGHT_RATIO: f64 = 0.2;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let gravity = setup.required_gravity()?;
    let mut scene = setup.scene();
    let time = SETTLING_TIME + MEASUREMENT_TIME;
    ground::place_on_ground(setup, &mut scene, Placement::default(), setup.speed * time)?;
    let velocity = DVec3::X * setup.speed;
    let path = [0.0, 2.0 * time].map(|time| PathKey { time, offset: velocity * time, rotation: DVec3::ZERO });
    scene.sheets[0].pins.push(PinSpec { path: path.to_vec(), ..PinSpec::fixed(Region::Right) });
    scene.sheets[0].velocity = velocity;
    let side = BOX_RATIO * setup.length;
    let size = DVec3::new(side, BOX_HEIGHT_RATIO * side, side);
    let top = 2.0 * setup.contact_offset()?;
    let block = body("box", Shape::Box(size), DVec3::Y * (top + 0.5 * size.y));
    scene.bodies.push(BodySpec { mass: Some(BOX_MASS), velocity, ..block });
    let mut world = setup.world(&scene)?;
    world.record_forces(true);
    let mut runner = Runner::new(world);
    let mut watch = ContactObserver::new(&runner.world);
    runner.run(SETTLING_TIME, |_| true);
    let (mut pins, mut floor, mut steps) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    runner.run(MEASUREMENT_TIME, |world| {
        watch.observe_step(world);
        pins += force_of(world, |kind, _| kind == ForceKind::Pins);
        floor += force_of(world, |kind, name| kind == ForceKind::Contact && name == Some("ground"));
        steps += 1.0;
        true
    });
    let weight = (runner.world.sheets()[0].total_mass() + BOX_MASS) * gravity;
    let scale = contact_observer::energy_of_speed(&runner.world, setup.speed);
    let own = json!({
        "speed_m_s": setup.speed,
        "friction": setup.friction,
        "pull_n": pins.x / steps,
        "floor_n": floor.y / steps,
        "expected_pull_n": setup.friction * floor.y / steps,
        "pull_ratio": pins.x / (setup.friction * floor.y),
        "friction_ratio": -floor.x / (setup.friction * floor.y),
        "support_ratio": (floor.y + pins.y) / (weight * steps),
    });
    Ok(runner.contact_outcome(&watch, scale, own))
}

/// Sum of the recorded forces on the first sheet that `is_it` selects by kind and partner, N.
pub(crate) fn force_of(world: &World, is_it: impl Fn(ForceKind, Option<&str>) -> bool) -> DVec3 {
    let of_sheet = world.forces().iter().filter(|entry| entry.sheet == 0);
    of_sheet.filter(|entry| is_it(entry.kind, world.partner_name(entry))).map(|entry| entry.force).sum()
}
