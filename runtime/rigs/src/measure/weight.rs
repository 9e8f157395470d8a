//! Support forces of a sheet at rest: the floor below a sheet, the sheet below a box, and the
//! attached edges of that sheet.
//!
//! The force of a support follows from the balance of momentum over a time T at rest: F = (Δp + m g
//! T)/T. The force of the attached edges is the elastic force of the sheet on their nodes plus the
//! weight of these nodes. It is independent of contact and shows that the sheet is bent as the
//! weight of the box requires. Each force is divided by its exact value; `support_force_ratio` is
//! the ratio furthest from 1 of the three.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::ContactObserver;
use crate::measure::pull::force_of;
use crate::measure::{RigOutcome, RigResult, Runner, Setup, body, plane};
use sheetwork::math::Vectors;
use sheetwork::scene::{BodySpec, PinSpec, Placement, Region, Shape};
use sheetwork::sheet::{Sheet, accelerations};
use sheetwork::{ForceKind, InputError, World, check_range};

/// Time before the force measurement, for the sheet to come to rest, and its duration, s.
const SETTLING_TIME: f64 = 5.0;
const MEASUREMENT_TIME: f64 = 0.25;
/// Mass of the box, kg, and its height as a fraction of its side.
const BOX_MASS: f64 = 0.02;
const BOX_HEIGHT_RATIO: f64 = 0.2;
/// Largest side of the box as a fraction of the sheet's length.
const MAXIMUM_BOX_RATIO: f64 = 0.8;

pub(crate) fn run(setup: &Setup) -> RigResult {
    // A box above an attached edge would load the pins directly.
    check_range("box", setup.box_side, 1e-3, MAXIMUM_BOX_RATIO * setup.length, "m")?;
    let gravity = setup.required_gravity()?;
    let (floor, recorded) = on_the_floor(setup)?;
    let mut runner = Runner::new(bridge(setup)?);
    let mut watch = ContactObserver::new(&runner.world);
    let start = heights(&runner.world);
    runner.run(SETTLING_TIME, |world| {
        watch.observe_step(world);
        true
    });
    let (time, before) = (runner.world.time(), box_momentum(&runner.world));
    let mut pins = Vec::new();
    runner.run(MEASUREMENT_TIME, |world| {
        watch.observe_step(world);
        pins.extend(world.sheets().first().map(|s| attachment_force(s, gravity)));
        true
    });
    let (change, time) = (box_momentum(&runner.world) - before, runner.world.time() - time);
    let boxed = 1.0 + change / (BOX_MASS * gravity * time);
    let sheet = runner.world.sheets().first().map_or(0.0, Sheet::total_mass);
    let held = pins.iter().sum::<f64>() / (pins.len().max(1) as f64 * (sheet + BOX_MASS) * gravity);
    let furthest = [floor, boxed, held]
        .into_iter()
        .fold(1.0_f64, |worst, r| if (r - 1.0).abs() > (worst - 1.0).abs() { r } else { worst });
    let scale = BOX_MASS * gravity * (start - heights(&runner.world)).abs();
    let own = json!({
        "box_m": setup.box_side,
        "box_mass_kg": BOX_MASS,
        "support_force_ratio": furthest,
        "floor_force_ratio": floor,
        "recorded_floor_force_ratio": recorded,
        "box_force_ratio": boxed,
        "held_edges_force_ratio": held,
        "sag_m": start - heights(&runner.world),
    });
    let settled = Some(watch.still_since().is_some());
    Ok(RigOutcome { settled, ..runner.contact_outcome(&watch, scale, own) })
}

/// Force of the floor on a resting sheet, over its weight: by balance of momentum, and as recorded.
fn on_the_floor(setup: &Setup) -> Result<(f64, f64), InputError> {
    let mut scene = setup.scene();
    scene.bodies.push(plane("floor", Placement::default()));
    scene.sheets[0].placement.position = DVec3::Y * setup.contact_offset()?;
    let mut runner = Runner::new(setup.world(&scene)?);
    runner.run(0.5, |_| true);
    let momentum = |world: &World| world.sheets().first().map_or(0.0, |s| s.momentum().y);
    let (time, before) = (runner.world.time(), momentum(&runner.world));
    runner.world.record_forces(true);
    let (mut recorded, mut steps) = (0.0, 0.0);
    runner.run(MEASUREMENT_TIME, |world| {
        recorded += force_of(world, |kind, _| kind == ForceKind::Contact).y;
        steps += 1.0;
        true
    });
    let weight = runner.world.sheets().first().map_or(0.0, |s| s.total_mass() * setup.gravity);
    let balance = 1.0 + (momentum(&runner.world) - before) / (weight * (runner.world.time() - time));
    Ok((balance, recorded / (weight * steps)))
}

/// A sheet fixed at two edges with a box on its middle.
fn bridge(setup: &Setup) -> Result<World, InputError> {
    let mut scene = setup.scene();
    scene.sheets[0].pins.extend([PinSpec::fixed(Region::Left), PinSpec::fixed(Region::Right)]);
    let top = Sheet::build(&scene, 0)?.state.x.bounds().map_or(0.0, |(_, high)| high.y) + setup.contact_offset()?;
    let size = DVec3::new(1.0, BOX_HEIGHT_RATIO, 1.0) * setup.box_side;
    let block = body("box", Shape::Box(size), DVec3::Y * (top + 0.5 * size.y));
    scene.bodies.push(BodySpec { mass: Some(BOX_MASS), ..block });
    setup.world(&scene)
}

fn box_momentum(world: &World) -> f64 {
    world.body_state("box").map_or(0.0, |b| b.momentum().y)
}

/// Height of the box, m.
fn heights(world: &World) -> f64 {
    world.body_state("box").map_or(0.0, |b| b.centre().y)
}

/// Upward force on the fixed nodes, N.
fn attachment_force(sheet: &Sheet, gravity: f64) -> f64 {
    let mut force = Vectors::zeros(sheet.node_count());
    accelerations::add_internal_forces(sheet, &mut force);
    (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).map(|i| sheet.node_mass(i) * gravity - force.y[i]).sum()
}
