//! Steps without heap allocation after a warm-up, measured by a counting allocator.

use allocation_counter::measure;
use glam::DVec3;
use sheetwork::integrators::TABLE;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{Air, MaterialChoice, PathKey, PinSpec, Placement, Region, Scene, Shape, SheetSpec, SpringLaw};
use sheetwork_tests::{body, excite_randomly, scene_without_gravity, shipped_scene, small_sheet, world};

/// Allocations in 200 steps of `scene` after 1.3 s of warm-up, by which every kind of contact and
/// event has occurred. An event allocates its name, and none occurs twice.
fn allocations(scene: &Scene) -> u64 {
    let mut world = world(scene);
    world.set_sleep(false);
    world.advance(1.3);
    let counted = measure(|| (0..200).for_each(|_| _ = world.step()));
    assert!(world.unstable().is_none());
    counted.count_total
}

#[test]
fn the_counting_allocator_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1);
}

#[test]
fn a_warm_step_of_a_free_sheet_allocates_nothing_with_any_integrator_and_structure() {
    for structure in structure::TABLE {
        for engine in TABLE {
            let mut scene = scene_without_gravity(small_sheet(structure.kind, 0.1), engine.kind);
            scene.dt = 5e-4;
            scene.tolerance = 1e-7;
            scene.gravity = DVec3::new(0.0, -1.0, 0.0);
            let mut world = world(&scene);
            excite_randomly(&mut world.sheets_mut()[0], 0.01, 1);
            (0..5).for_each(|_| _ = world.step());
            let counted = measure(|| (0..100).for_each(|_| _ = world.step())).count_total;
            assert_eq!(counted, 0, "{} on {}", engine.name, structure.name);
        }
    }
}

/// A stiff sheet of `structure`, clamped at one edge, in a wind.
fn clamped(structure: structure::StructureKind, engine: IntegratorKind) -> Scene {
    let sheet = SheetSpec {
        structure,
        grid: (11, if structure == structure::StructureKind::Shell { 1 } else { 2 }, 11),
        size: (0.25, 0.25),
        material: MaterialChoice::Named("pet".into()),
        springs: SpringLaw::Calibrated,
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    };
    let air = Air { density: 1.2, wind: DVec3::new(2.0, 0.0, 3.0), ..Air::default() };
    Scene { engine, dt: 1.0 / 60.0, air, sheets: vec![sheet], ..Scene::default() }
}

#[test]
fn a_warm_implicit_step_of_a_stiff_sheet_allocates_nothing() {
    use sheetwork::mesh::structure::StructureKind::{DoubleDiagonal, Shell, Trimm};
    for structure in [Shell, Trimm, DoubleDiagonal] {
        for engine in TABLE.iter().filter(|e| e.implicit) {
            assert_eq!(allocations(&clamped(structure, engine.kind)), 0, "{} on {structure}", engine.name);
        }
    }
    let mut disc = clamped(Shell, IntegratorKind::TrBdf2);
    disc.sheets[0].outline = Some(OutlineSpec::Disc { radius: 0.1 });
    disc.sheets[0].pins = vec![PinSpec::clamped(Region::Point(0.5, 0.5))];
    assert_eq!(allocations(&disc), 0, "a disc");
}

#[test]
fn a_warm_step_in_contact_with_static_bodies_allocates_nothing() {
    for name in ["wedge", "slide_17", "two_walls", "hemisphere", "cube"] {
        assert_eq!(allocations(&shipped_scene(name)), 0, "{name}");
    }
    // With the instability detector, and with a permanently reduced step.
    for young in ["185", "1e5"] {
        let watched = shipped_scene("wedge").with_override("sheets.0.when_unstable", "reduce-step");
        let scene = watched.and_then(|s| s.with_override("sheets.0.material.young", young));
        let mut world = world(&scene.unwrap_or_else(|e| panic!("{e}")));
        world.advance(1.3);
        // The step is lengthened on trial at intervals, with an event.
        let counted = (0..100).map(|_| measure(|| _ = world.step()).count_total).filter(|n| *n == 0).count();
        assert!(counted >= 95 && world.unstable().is_none(), "{young} Pa: {counted} of 100 steps allocate nothing");
    }
    // A pile of layers at rest on a tilted box and a half space at once.
    for engine in TABLE {
        let mut scene = scene_without_gravity(small_sheet(structure::StructureKind::Samm, 0.3), engine.kind);
        scene.sheets[0].grid = (6, 3, 6);
        scene.tolerance = 1e-6;
        scene.dt = 1e-3;
        scene.gravity = DVec3::new(0.0, -9.81, 0.0);
        let tilt = Placement { position: DVec3::new(0.1, -0.05, 0.0), rotation: DVec3::new(0.0, 0.0, 20.0) };
        scene.bodies.push(body("box", Shape::Box(DVec3::new(0.2, 0.1, 0.2)), tilt, vec![]));
        scene.bodies.push(body("floor", Shape::HalfSpace, Placement::default(), vec![]));
        scene.sheets[0].placement.position = DVec3::new(0.0, 0.05, 0.0);
        assert_eq!(allocations(&scene), 0, "{}", engine.name);
    }
}

#[test]
fn pins_paths_and_a_flexion_limit_allocate_nothing() {
    let mut sheet = small_sheet(structure::StructureKind::Provot2d, 0.1);
    let path =
        vec![PathKey::default(), PathKey { time: 1.0, offset: DVec3::new(0.05, 0.1, 0.0), rotation: DVec3::ZERO }];
    sheet.pins.push(PinSpec { path, ..PinSpec::fixed(Region::Left) });
    sheet.flexion_limit = Some(10.0);
    let mut scene = scene_without_gravity(sheet, IntegratorKind::EulerRichardson);
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.dt = 1e-3;
    assert_eq!(allocations(&scene), 0);
}

#[test]
fn a_warm_step_in_wind_zones_allocates_nothing() {
    let mut scene = clamped(structure::StructureKind::Shell, IntegratorKind::TrBdf2);
    let zones = r#"(wind_zones: [(velocity: (3, 0, 0), gusts: (amplitude: 1, duration: 0.5, period: 0.8),
        turbulence: (intensity: 1, length: 0.6), vortex: (circulation: 1, core: 0.1), shelter: 2, wakes: true),
        (fluid: (density: 10, surface: -0.01))])"#;
    scene.wind_zones = Scene::parse(zones).expect("valid").wind_zones;
    // A step of the rigid bodies allocates, so the wall stands still.
    let place = Placement { position: DVec3::new(-0.5, 0.0, 0.0), ..Placement::default() };
    scene.bodies = vec![body("wall", Shape::Ball(0.1), place, Vec::new())];
    assert_eq!(allocations(&scene), 0);
}
