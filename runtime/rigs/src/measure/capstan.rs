//! Strip that slips over a fixed cylinder: T₂ = T₁ exp(μ φ) (Euler 1769, Eytelwein 1808),
//! without gravity.
//!
//! A constant load T₁ pulls at the left end, 60° below the horizontal. The right end is led to
//! the other side and pulled at constant speed; T₂ is the recorded force of its pins. The wrap
//! angle φ follows from the directions of T₁ and T₂. The cylinder is a prism: at each of its
//! edges the strip slips as on an arc of the same angle. The force of the cylinder balances both
//! tensions.

use glam::DVec3;
use serde_json::json;

use crate::measure::pull::force_of;
use crate::measure::{RigResult, Runner, Setup, body};
use sheetwork::ForceKind;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::polyhedron::Polyhedron;
use sheetwork::scene::{Material, MaterialChoice, PathKey, PinSpec, Placement, Region, RegionVector, Shape, SheetSpec};

/// Radius of the cylinder and width of the prism, m, and its number of sides.
const RADIUS: f64 = 0.05;
const PRISM_WIDTH: f64 = 0.06;
const SIDES: u32 = 48;
/// Length and width of the strip, m, and its nodes.
const STRIP: (f64, f64) = (0.24, 0.02);
const GRID: (u32, u32) = (61, 3);
/// Load at the left end, N, and its angle below the horizontal, rad.
const LOAD: f64 = 1.0;
const ANGLE: f64 = std::f64::consts::FRAC_PI_3;
/// Times at which the end has been led down, the measurement begins and it ends, s, and speed of
/// the pull, m/s.
const LED: f64 = 1.0;
const BEGIN: f64 = 2.0;
const END: f64 = 3.0;
const SPEED: f64 = 0.015;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    scene.gravity = DVec3::ZERO;
    scene.contact.sheets = false;
    (scene.air.factor, scene.air.per) = (0.5, 0.05);
    scene.bodies.push(body("cylinder", Shape::Polyhedron(prism()), DVec3::ZERO));
    let thin = Material { young: 1e9, poisson: 0.0, density: 1000.0, thickness: 1e-4, ..Material::default() };
    let height = RADIUS + 0.5 * thin.thickness;
    let (cos, sin) = (ANGLE.cos(), ANGLE.sin());
    let along = DVec3::new(cos, -sin, 0.0);
    let led = DVec3::new(height * sin, height * cos, 0.0) + along * (0.5 * STRIP.0 - height * ANGLE);
    let led = led - DVec3::new(0.5 * STRIP.0, height, 0.0);
    let key = |time: f64, offset: DVec3| PathKey { time, offset, rotation: DVec3::ZERO };
    let path = vec![key(0.0, DVec3::ZERO), key(LED, led), key(END, led + along * (SPEED * (END - LED)))];
    let load = DVec3::new(-cos, -sin, 0.0) * LOAD;
    scene.sheets = vec![SheetSpec {
        name: "strip".into(),
        structure: StructureKind::Shell,
        grid: (GRID.0, 1, GRID.1),
        size: STRIP,
        material: MaterialChoice::Inline(thin),
        damping_ratio: Some(0.5),
        friction: scene.sheets[0].friction,
        placement: Placement { position: DVec3::Y * height, ..Placement::default() },
        forces: vec![RegionVector { region: Region::Left, value: load / f64::from(GRID.1) }],
        pins: vec![PinSpec { path, ..PinSpec::fixed(Region::Right) }],
        ..SheetSpec::default()
    }];
    let mut world = setup.world(&scene)?;
    world.record_forces(true);
    let mut runner = Runner::new(world);
    runner.run(BEGIN, |_| true);
    let (mut pull, mut cylinder, mut steps) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    runner.run(END - BEGIN, |world| {
        pull += force_of(world, |kind, _| kind == ForceKind::Pins);
        cylinder += force_of(world, |kind, _| kind == ForceKind::Contact);
        steps += 1.0;
        true
    });
    let (pull, cylinder) = (pull / steps, cylinder / steps);
    let wrap = std::f64::consts::PI - load.angle_between(pull);
    let expected = LOAD * (setup.friction * wrap).exp();
    let keys = json!({
        "friction": setup.friction,
        "load_n": LOAD,
        "pull_n": pull.length(),
        "wrap_deg": wrap.to_degrees(),
        "expected_pull_n": expected,
        "pull_ratio": pull.length() / expected,
        "cylinder_error": (cylinder + pull + load).length() / cylinder.length(),
    });
    Ok(runner.outcome(keys))
}

/// Prism about the z axis with the cylinder as its circumscribed one.
fn prism() -> Polyhedron {
    let corner = |k: u32, z: f64| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
        DVec3::new(RADIUS * angle.cos(), RADIUS * angle.sin(), z)
    };
    let half = 0.5 * PRISM_WIDTH;
    let vertices = (0..SIDES).map(|k| corner(k, half)).chain((0..SIDES).map(|k| corner(k, -half))).collect();
    let side = |k: u32| vec![k, SIDES + k, SIDES + (k + 1) % SIDES, (k + 1) % SIDES];
    let ends = [(0..SIDES).collect(), (0..SIDES).rev().map(|k| SIDES + k).collect()];
    Polyhedron { vertices, faces: (0..SIDES).map(side).chain(ends).collect() }
}
