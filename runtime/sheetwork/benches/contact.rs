//! Cost of collision detection per call, for a sheet of 21 by 21 nodes (0.25 m, 0.5 mm thick).
//!
//! `cargo bench -p sheetwork --bench contact`. `run_broad_phase` is the cost once per step; the
//! others are single calls of `find`, of which a stage makes a few.

use divan::Bencher;
use glam::{DQuat, DVec3};
use rapier3d::prelude::SharedShape;
use sheetwork::collision::collision_surface::CollisionSurface;
use sheetwork::collision::features::ColliderFeatures;
use sheetwork::collision::narrow_phase::{BodyStageMotion, CollisionDetector, DetectionInput, SheetStageMotion};
use sheetwork::math::RigidFrame;
use sheetwork::math::Vectors;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{Material, MaterialChoice, Scene, SheetSpec};
use sheetwork::sheet::Sheet;

const THICKNESS: f64 = 5e-4;

fn main() {
    divan::main();
}

fn sheet() -> (CollisionSurface, Vectors) {
    let material = Material { thickness: THICKNESS, ..Material::default() };
    let spec = SheetSpec {
        structure: StructureKind::Shell,
        grid: (21, 1, 21),
        size: (0.25, 0.25),
        material: MaterialChoice::Inline(material),
        ..SheetSpec::default()
    };
    let scene = Scene { sheets: vec![spec], ..Scene::thesis() };
    let sheet = Sheet::build(&scene, 0).expect("valid");
    (CollisionSurface::from_sheet(&sheet), sheet.state.x.clone())
}

fn moved(x: &Vectors, f: impl Fn(DVec3) -> DVec3) -> Vectors {
    let mut y = Vectors::default();
    x.iter().for_each(|p| y.push(f(p)));
    y
}

fn raised(x: &Vectors, by: f64) -> Vectors {
    moved(x, |p| p + DVec3::Y * by)
}

fn motion<'a>(id: u32, skin: &'a CollisionSurface, start: &'a Vectors, end: &'a Vectors) -> SheetStageMotion<'a> {
    SheetStageMotion { id, skin, start, base: start, end, awake: true }
}

fn find(bencher: Bencher, sheets: &[SheetStageMotion], bodies: &[BodyStageMotion]) {
    let problem =
        DetectionInput { sheets, bodies, margin: 2e-4, fall: 0.0, between: Some(2e-4), surfaces: &|_| (0.3, 0.0) };
    let (mut finder, mut rows) = (CollisionDetector::default(), Vec::new());
    finder.run_broad_phase(&problem, 0.05);
    bencher.bench_local(|| finder.detect_contacts(&problem, divan::black_box(&mut rows)));
}

/// A sheet that sinks by 0.15 mm onto a shape whose top is at `depth` below the shape's origin.
fn onto(bencher: Bencher, shape: &SharedShape, depth: f64, height: f64) {
    let (skin, x) = sheet();
    let features = ColliderFeatures::from_shape(shape.0.as_ref());
    let here = RigidFrame::from_parts(DVec3::new(1e-3, -depth, 2e-3), DQuat::IDENTITY);
    let body = BodyStageMotion { id: 0, features: &features, start: here, base: here, end: here, awake: false };
    let (start, end) = (raised(&x, height + 0.5 * THICKNESS + 1e-6), raised(&x, height + 0.5 * THICKNESS - 1.5e-4));
    find(bencher, &[motion(0, &skin, &start, &end)], &[body]);
}

/// All nodes over the top.
#[divan::bench]
fn on_a_large_box(bencher: Bencher) {
    onto(bencher, &SharedShape::cuboid(0.2, 0.05, 0.2), 0.05, 0.0);
}

/// The rim below the middle of the sheet.
#[divan::bench]
fn on_a_box(bencher: Bencher) {
    onto(bencher, &SharedShape::cuboid(0.05, 0.05, 0.05), 0.05, 0.0);
}

#[divan::bench]
fn on_a_ball(bencher: Bencher) {
    onto(bencher, &SharedShape::ball(0.05), 0.05, 0.0);
}

#[divan::bench]
fn on_a_capsule(bencher: Bencher) {
    onto(bencher, &SharedShape::capsule_x(0.05, 0.05), 0.05, 0.0);
}

#[divan::bench]
fn far_from_a_box(bencher: Bencher) {
    onto(bencher, &SharedShape::cuboid(0.05, 0.05, 0.05), 0.05, 1.0);
}

#[divan::bench]
fn on_another_sheet(bencher: Bencher) {
    let (skin, x) = sheet();
    let turned = |by: f64| moved(&x, move |p| DQuat::from_rotation_y(0.3) * p + DVec3::Y * by);
    let (start, end) = (turned(THICKNESS + 1e-6), turned(THICKNESS - 1e-4));
    find(bencher, &[motion(0, &skin, &x, &x), motion(1, &skin, &start, &end)], &[]);
}

/// Curvature beyond the bound that excludes self-contact.
#[divan::bench]
fn rolled(bencher: Bencher) {
    let (skin, x) = sheet();
    let rolled = moved(&x, |p| DVec3::new(0.05 * (p.x / 0.05).sin(), 0.05 - 0.05 * (p.x / 0.05).cos(), p.z));
    find(bencher, &[motion(0, &skin, &rolled, &rolled)], &[]);
}

/// Cost once per step.
#[divan::bench]
fn begin(bencher: Bencher) {
    let (skin, x) = sheet();
    let (sheets, problem_bodies) = ([motion(0, &skin, &x, &x)], []);
    let problem = DetectionInput {
        sheets: &sheets,
        bodies: &problem_bodies,
        margin: 2e-4,
        fall: 0.0,
        between: Some(2e-4),
        surfaces: &|_| (0.3, 0.0),
    };
    let mut finder = CollisionDetector::default();
    bencher.bench_local(|| finder.run_broad_phase(divan::black_box(&problem), 0.05));
}
