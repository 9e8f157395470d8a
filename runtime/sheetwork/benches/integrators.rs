//! Cost of a step and of a spring, for every integrator and structure.
//!
//! `cargo bench -p sheetwork --bench integrators`. divan prints rates as items per second: spring
//! evaluations in `springs`, stepped nodes in `step`, simulated microseconds in `scene`. The
//! inverse of the last, times a million, is real time over CPU time.

use std::path::Path;

use divan::Bencher;
use divan::counter::ItemsCount;
use sheetwork::World;
use sheetwork::elements::spring::SpringWorkspace;
use sheetwork::integrators::TABLE as ENGINES;
use sheetwork::math::Vectors;
use sheetwork::mesh::structure::{StructureKind, TABLE as STRUCTURES};
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{Scene, SheetSpec};
use sheetwork::sheet::Sheet;

fn main() {
    divan::main();
}

fn structures() -> impl Iterator<Item = StructureKind> {
    STRUCTURES.iter().map(|s| s.kind)
}

fn engines() -> impl Iterator<Item = IntegratorKind> {
    ENGINES.iter().map(|e| e.kind)
}

/// A free sheet of the thesis's material with a small motion, 11 or 21 nodes per side.
fn scene(structure: StructureKind, engine: IntegratorKind, side: u32) -> Scene {
    let layers = structure.info().layers.1.min(2);
    let sheet = SheetSpec { structure, grid: (side, layers, side), node_mass: Some(4e-5), ..SheetSpec::thesis() };
    Scene { engine, dt: 1e-3, sheets: vec![sheet], ..Scene::default() }
}

/// One evaluation of all springs, with dashpots.
#[divan::bench(args = structures())]
fn springs(bencher: Bencher, structure: StructureKind) {
    let sheet = Sheet::build(&scene(structure, IntegratorKind::Verlet, 11), 0).expect("valid");
    let mut force = Vectors::zeros(sheet.node_count());
    let mut scratch = SpringWorkspace::default();
    bencher.counter(ItemsCount::new(sheet.springs().len())).bench_local(|| {
        sheet.springs().add_forces(divan::black_box(&sheet.state.x), &sheet.state.v, true, &mut scratch, &mut force);
    });
}

/// One step of every integrator, TRiMM 11x2x11.
#[divan::bench(args = engines())]
fn step(bencher: Bencher, engine: IntegratorKind) {
    let mut world = World::new(&scene(StructureKind::Trimm, engine, 11)).expect("valid");
    bencher.counter(ItemsCount::new(world.sheets()[0].node_count())).bench_local(|| world.step());
}

/// One step of every structure, Euler-Richardson.
#[divan::bench(args = structures())]
fn step_of(bencher: Bencher, structure: StructureKind) {
    let mut world = World::new(&scene(structure, IntegratorKind::EulerRichardson, 11)).expect("valid");
    bencher.counter(ItemsCount::new(world.sheets()[0].node_count())).bench_local(|| world.step());
}

/// One step of the wedge scene, with the sheet at rest on the wedge and sleeping disabled.
#[divan::bench]
fn wedge(bencher: Bencher) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/wedge.ron");
    let mut world = World::new(&Scene::load(&file).expect("valid")).expect("valid");
    world.set_sleep(false);
    world.advance(3.0);
    let microseconds = (world.dt() * 1e6).round() as usize;
    bencher.counter(ItemsCount::new(microseconds)).bench_local(|| world.step());
}
