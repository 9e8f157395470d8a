//! CCD of sharp features at 20 m/s and 60 steps per second.
//!
//! Sheets are thrown at a box's edge and corner, at a thin plate and its rim, at a wedge's ridge
//! and at a needle; bodies are thrown at a sheet with fixed edges. Sheets also land on a ridge and
//! a needle that are narrower than the node spacing. Penetrations are those of the rigs' own
//! measure, `overlap`.

use glam::DVec3;
use sheetwork::World;
use sheetwork::collision::overlap::{BodyPose, OverlapSolid, faces, with_body};
use sheetwork::scene::{
    BodySpec, ContactDefaults, IntegratorKind, Material, MaterialChoice, PinSpec, Placement, Polyhedron, Region, Scene,
    Shape, SheetSpec,
};
use sheetwork_rigs::measure::{Setup, measure};

const SPEED: f64 = 20.0;
/// Penetration at which the rigs count a passage, m.
const PASSAGE_THRESHOLD: f64 = 1e-3;

fn sheet(grid: u32) -> SheetSpec {
    SheetSpec {
        grid: (grid, 1, grid),
        size: (0.25, 0.25),
        material: MaterialChoice::Inline(Material {
            young: 3e9,
            poisson: 0.35,
            density: 1050.0,
            thickness: 5e-4,
            ..Material::default()
        }),
        ..SheetSpec::thesis()
    }
}

fn scene(sheet: SheetSpec, body: BodySpec) -> Scene {
    Scene {
        engine: IntegratorKind::TrBdf2,
        dt: 1.0 / 60.0,
        contact: ContactDefaults { friction: 0.3, restitution: 0.2, ..ContactDefaults::default() },
        sheets: vec![sheet],
        bodies: vec![body],
        ..Scene::default()
    }
}

fn still(shape: Shape, position: DVec3, rotation: DVec3) -> BodySpec {
    BodySpec { placement: Placement { position, rotation }, ..BodySpec::new(shape) }
}

/// A square pyramid with its tip at the origin.
fn needle(base: f64, height: f64) -> Polyhedron {
    let b = 0.5 * base;
    let mut vertices: Vec<DVec3> =
        [(-b, -b), (-b, b), (b, b), (b, -b)].map(|(x, z)| DVec3::new(x, -height, z)).to_vec();
    vertices.push(DVec3::ZERO);
    let faces = std::iter::once(vec![3, 2, 1, 0]).chain((0..4).map(|i| vec![i, (i + 1) % 4, 4]));
    Polyhedron { vertices, faces: faces.collect() }
}

/// Obstacles with their sharpest feature upwards near the origin.
fn obstacles() -> Vec<(&'static str, BodySpec)> {
    let cube = || Shape::Box(DVec3::splat(0.1));
    let plate = || Shape::Box(DVec3::new(0.3, 0.005, 0.3));
    let down = |by: f64| DVec3::NEG_Y * by;
    vec![
        ("edge of a box", still(cube(), down(0.05 * 2.0_f64.sqrt()), DVec3::new(0.0, 0.0, 45.0))),
        ("corner of a box", still(cube(), down(0.05 * 3.0_f64.sqrt()), DVec3::new(45.0, 0.0, 35.264_389_7))),
        ("plate", still(plate(), down(0.0025), DVec3::ZERO)),
        ("rim of a plate", still(plate(), down(0.15), DVec3::new(0.0, 0.0, 90.0))),
        ("ridge", still(Shape::Polyhedron(Polyhedron::wedge(0.08, 0.08, 0.8)), down(0.08), DVec3::ZERO)),
        ("needle", still(Shape::Polyhedron(needle(0.016, 0.08)), DVec3::ZERO, DVec3::ZERO)),
    ]
}

/// Largest penetration of the sheet into the body (m) over `steps` steps.
fn deepest(world: &mut World, steps: u32) -> f64 {
    let solid = OverlapSolid::from_shape(&world.scene().bodies[0].shape).expect("of a known shape");
    let triangles = faces(&world.sheets()[0]);
    let mut deepest = 0.0_f64;
    for _ in 0..steps {
        world.step();
        let (position, rotation) = world.rigid().and_then(|r| r.pose(0)).expect("there");
        let (_, depth) = with_body(&world.sheets()[0], &triangles, &solid, &BodyPose { position, rotation });
        deepest = deepest.max(depth);
    }
    assert!(world.unstable().is_none());
    deepest
}

#[test]
fn no_sheet_thrown_at_a_sharp_feature_passes_through() {
    let poses = [
        ("flat", DVec3::new(0.0, 23.0, 0.0)),
        ("tilted", DVec3::new(30.0, 23.0, 20.0)),
        ("edge on", DVec3::new(0.0, 23.0, 85.0)),
    ];
    let mut failed = Vec::new();
    for (number, (name, body)) in obstacles().into_iter().enumerate() {
        for (k, (pose, rotation)) in poses.into_iter().enumerate() {
            // Excluded: sheets that are folded around a ridge or a rim by the impact, which contact
            // does not prevent.
            if pose == "flat" && ["plate", "ridge"].contains(&name) {
                continue;
            }
            // The sheet is off-centre and hits at any phase of a step. One of two grids per throw,
            // since each throw takes seconds.
            let (grid, phase, aside) = [(21, 0.0, 0.031), (11, 0.4, -0.017)][(number + k) % 2];
            // An edge-on sheet must hit a narrow obstacle.
            let aside = if pose == "edge on" { 0.05 * aside } else { aside };
            let position = DVec3::new(aside, 0.3 + phase * SPEED / 60.0, 0.6 * aside);
            let placement = Placement { position, rotation };
            let velocity = DVec3::NEG_Y * SPEED;
            let thrown = SheetSpec { placement, velocity, ..sheet(grid) };
            let mut world = World::new(&scene(thrown, body.clone())).expect("valid");
            let depth = deepest(&mut world, 8);
            println!("{name}, {grid}x{grid}, {pose}: {:.4} mm", 1e3 * depth);
            if depth > PASSAGE_THRESHOLD {
                failed.push(format!("{name}, {grid}x{grid}, {pose}: {:.3} mm", 1e3 * depth));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn no_body_thrown_at_a_fixed_sheet_passes_through() {
    let shapes = [
        ("box", Shape::Box(DVec3::splat(0.02))),
        ("ball", Shape::Ball(0.01)),
        ("needle", Shape::Polyhedron(needle(0.01, 0.04))),
    ];
    let mut failed = Vec::new();
    for (name, shape) in shapes {
        for grid in [11, 21] {
            for (density, turn) in [(1000.0, 0.0), (7800.0, 37.0)] {
                let held = SheetSpec { pins: vec![PinSpec::fixed(Region::Border)], ..sheet(grid) };
                let position = DVec3::new(0.013, 0.21, -0.007);
                // The needle flies with its tip ahead.
                let rotation = DVec3::new(180.0, turn, 0.4 * turn);
                let velocity = DVec3::NEG_Y * SPEED;
                let body = BodySpec { density: Some(density), velocity, ..still(shape.clone(), position, rotation) };
                let mut world = World::new(&scene(held, body)).expect("valid");
                let depth = deepest(&mut world, 8);
                let height = world.rigid().and_then(|r| r.pose(0)).map_or(0.0, |(p, _)| p.y);
                let middle = world.sheets()[0].centre_of_mass().y;
                println!("{name}, {grid}x{grid}, {density}: {:.4} mm, {height:.4} over {middle:.4} m", 1e3 * depth);
                if depth > PASSAGE_THRESHOLD || height < middle {
                    failed.push(format!("{name}, {grid}x{grid}, {density}: {:.3} mm", 1e3 * depth));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn no_needle_or_ridge_penetrates_a_sheet_that_lands_on_it() {
    for (angle, restitution, friction, corner) in
        [(17.0, 0.4, 0.5, true), (30.0, 0.0, 0.1, true), (30.0, 0.4, 0.5, false)]
    {
        let setup = Setup { angle, height: 1.0, restitution, friction, corner, edge_of_body: true, ..Setup::default() };
        let found = measure("edge-landing", &setup).expect("a valid set-up");
        let number = |key: &str| found[key].as_f64().expect("a number");
        assert!(number("max_body_edge_penetration_m") < 1e-4, "{found}");
        assert!(number("max_mass_penetration_m") < 5e-5 && number("energy_gain") < 1e-9, "{found}");
    }
}
