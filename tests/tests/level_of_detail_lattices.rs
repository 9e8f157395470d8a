//! State transfer between grids of lattices: several layers and their springs.

use glam::DVec3;
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{Material, SpringLaw};
use sheetwork::sheet::{Sheet, Status};
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::{change_grid, state_hash, world_of as world};

/// A sheet with these fields and calibrated springs, clamped along its left edge.
fn clamped(structure: &str, layers: u32, n: u32, more: &str) -> World {
    world(&format!(
        r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "leaf", structure: "{structure}", grid: ({n}, {layers}, {n}),
            size: (0.25, 0.25), material: "hips", springs: Calibrated, pins: [(region: Left, clamp: true)], {more})])"#
    ))
}

const CHANGES: [(u32, u32); 4] = [(11, 21), (21, 11), (21, 31), (12, 17)];

/// Every change of grid of `setup`, except those from and to 41 nodes where `far` is false: bounds
/// on the pop, and on elastic energy after over before (`strain`).
fn pops(setup: &Setup, far: bool, strain: std::ops::Range<f64>) {
    let found = measure("detail", setup).unwrap_or_else(|e| panic!("{e}"));
    let rows = found["changes"].as_array().expect("rows");
    assert_eq!(rows.len(), 18);
    for row in rows {
        let (shape, change) = (row["shape"].as_str().expect("a name"), row["change"].as_str().expect("a name"));
        if !far && change.contains("41") {
            continue;
        }
        let number = |key: &str| row[key].as_f64().expect("a number");
        let what = format!("{} {shape} {change}", setup.structure);
        assert!(number("pop") < 0.02, "{what}: {}", number("pop"));
        assert!(number("rise") < 0.02, "{what}: energy rises by {}", number("rise"));
        assert!(strain.contains(&number("strain_ratio")), "{what}: strain {}", number("strain_ratio"));
        // Sheets on the box are at rest.
        assert!(shape == "box" || number("motion_ratio") > 0.9, "{what}: motion {}", number("motion_ratio"));
    }
}

#[test]
fn no_change_of_a_lattice_pops_by_more_than_two_percent_of_the_deflection() {
    for structure in [StructureKind::Trimm, StructureKind::Slamm] {
        pops(&Setup { structure, ..Setup::default() }, true, 0.9..1.25);
    }
}

#[test]
fn springs_of_the_thesis_do_not_pop() {
    // All springs have stiffness E t, and the distance between layers is constant.
    let material = Material { young: 1e6, ..Setup::default().material };
    let springs = SpringLaw::Uniform;
    let setup = Setup { structure: StructureKind::Slamm, springs, material, ..Setup::default() };
    pops(&setup, false, 0.9..1.7);
}

#[test]
fn remapping_conserves_mass_and_momenta_of_a_flying_lattice() {
    for (structure, layers) in [("trimm", 2), ("slamm", 3), ("provot3d", 2), ("provot2d", 1), ("trimm", 3)] {
        for engine in ["tr-bdf2", "verlet"] {
            for (from, n) in CHANGES {
                let mut world = world(&format!(
                    r#"(engine: "{engine}", dt: 0.0005, gravity: (0, 0, 0), sheets: [(structure: "{structure}", grid: ({from}, {layers}, {from}),
                        size: (0.25, 0.2), gap: 0.006, material: "thesis", springs: Uniform, velocity: (1, 0.5, -0.3), spin: (2, 1, 4))])"#
                ));
                world.advance(0.1);
                let of = |s: &Sheet| (s.total_mass(), s.momentum(), s.angular_momentum(), s.energy(DVec3::ZERO));
                let before = of(&world.sheets()[0]);
                change_grid(&mut world, (n, n + 1));
                let after = of(&world.sheets()[0]);
                let what = format!("{structure} of {layers}, {engine}, {from} to {n}");
                assert_eq!(world.sheets()[0].model.grid, (n, layers, n + 1));
                assert!((after.0 / before.0 - 1.0).abs() < 1e-12, "{what}");
                assert!(after.1.distance(before.1) < 1e-12 * before.1.length(), "{what}");
                assert!(after.2.distance(before.2) < 1e-9 * before.2.length(), "{what}");
                assert!(after.3.total < before.3.total * 1.005, "{what}: {:?} of {:?}", after.3, before.3);
                // As for the shell, the inertia depends on the spacing.
                assert!(
                    (after.3.kinetic / before.3.kinetic - 1.0).abs() < 0.04,
                    "{what}: {:?} of {:?}",
                    after.3,
                    before.3
                );
                world.advance(0.05);
                assert!(of(&world.sheets()[0]).1.distance(before.1) < 1e-9 * before.1.length(), "{what} flies on");
                assert!(world.unstable().is_none());
            }
        }
    }
}

#[test]
fn pinned_nodes_of_every_layer_keep_their_positions() {
    for springs in ["Uniform", "Calibrated"] {
        for (from, n) in CHANGES {
            let mut world = world(&format!(
                r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "leaf", structure: "trimm", grid: ({from}, 2, {from}), springs: {springs},
                    size: (0.25, 0.25), gap: 0.005, material: "thesis", damping: 0.1, pins: [(region: Left, clamp: true)])])"#
            ));
            let fresh = |n: u32, world: &World| {
                let mut scene = world.scene().clone();
                scene.sheets[0].grid = (n, 2, n);
                World::new(&scene).unwrap_or_else(|e| panic!("{e}"))
            };
            let rest = fresh(n, &world);
            world.advance(0.3);
            change_grid(&mut world, (n, n));
            let check = |world: &World| {
                let (sheet, rest) = (&world.sheets()[0], &rest.sheets()[0]);
                let held: Vec<usize> = (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).collect();
                assert!(!held.is_empty() && held.iter().all(|i| rest.is_held(*i)));
                for i in held {
                    assert!(sheet.state.x.get(i).distance(rest.state.x.get(i)) < 1e-12, "{springs} {from} to {n}: {i}");
                    assert!(sheet.state.v.get(i).length() < 1e-12);
                }
            };
            check(&world);
            world.advance(0.1);
            check(&world);
        }
    }
}

#[test]
fn kinematic_nodes_continue_their_paths_after_remapping() {
    let mut world = world(
        r#"(engine: "tr-bdf2", dt: 0.01, sheets: [(name: "leaf", structure: "slamm", grid: (11, 2, 11), size: (0.25, 0.25), gap: 0.005,
            material: "thesis", springs: Uniform, damping: 0.2, pins: [(region: Left, path: [(time: 0, offset: (0, 0, 0)), (time: 1, offset: (0, 0.5, 0))])])])"#,
    );
    world.advance(0.3);
    change_grid(&mut world, (21, 21));
    world.advance(0.2);
    let sheet = &world.sheets()[0];
    let held: Vec<usize> = (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).collect();
    for i in &held {
        let height = if sheet.model.layer_of[*i] == 1 { 0.005 } else { 0.0 };
        let wanted = 0.25 + height;
        assert!((sheet.state.x.get(*i).y - wanted).abs() < 1e-9, "{i}: {} of {wanted}", sheet.state.x.get(*i).y);
    }
    assert_eq!(held.len(), 41);
}

#[test]
fn remapping_conserves_mean_and_range_of_temperatures_of_every_layer() {
    for (structure, layers) in [("trimm", 2), ("slamm", 2), ("double-diagonal", 3)] {
        for (from, n) in CHANGES {
            let mut world = clamped(structure, layers, from, "temperature: 40");
            let (uv, layer) = (world.sheets()[0].model.uv.clone(), world.sheets()[0].model.layer_of.clone());
            let warm = |i: usize| {
                let spot = (-12.0 * ((uv[i].0 - 0.5).powi(2) + (uv[i].1 - 0.4).powi(2))).exp();
                40.0 + 10.0 * f64::from(layer[i]) + 60.0 * spot
            };
            world.sheets_mut()[0].set_temperatures(warm).unwrap_or_else(|e| panic!("{e}"));
            let of = |s: &Sheet| {
                let celsius = s.temperatures().expect("warm");
                let mean = (0..s.node_count()).map(|i| s.node_mass(i) * celsius[i]).sum::<f64>() / s.total_mass();
                let layer = |l: u32| {
                    let own: Vec<f64> =
                        (0..s.node_count()).filter(|i| s.model.layer_of[*i] == l).map(|i| celsius[i]).collect();
                    own.iter().sum::<f64>() / own.len() as f64
                };
                let range = s.heat().expect("warm").range();
                (mean, range.0, range.1, layer(1) - layer(0))
            };
            let before = of(&world.sheets()[0]);
            change_grid(&mut world, (n, n));
            let after = of(&world.sheets()[0]);
            let what = format!("{structure} of {layers}, {from} to {n}");
            assert!((after.0 - before.0).abs() < 1e-9, "{what}: {} of {}", after.0, before.0);
            let spread = before.2 - before.1;
            assert!((after.1 - before.1).abs() < 0.04 * spread, "{what}: coldest {} of {}", after.1, before.1);
            assert!((after.2 - before.2).abs() < 0.09 * spread, "{what}: hottest {} of {}", after.2, before.2);
            assert!((after.3 - before.3).abs() < 3.0, "{what}: between layers {} of {}", after.3, before.3);
            world.advance(0.05);
            assert!(world.unstable().is_none());
        }
    }
}

fn low(world: &World) -> f64 {
    world.sheets()[0].state.x.iter().map(|p| p.y).fold(0.0, f64::min)
}

/// Remaining sag after removal of load and heat: before a change of grid, just after it, and at
/// equilibrium.
fn left(world: &mut World, n: u32) -> [f64; 3] {
    world.set_gravity(DVec3::ZERO).unwrap_or_else(|e| panic!("{e}"));
    world.sheets_mut()[0].set_temperatures(|_| 20.0).unwrap_or_else(|e| panic!("{e}"));
    world.find_equilibrium(1e-9);
    let before = low(world);
    change_grid(world, (n, n));
    let at_once = low(world);
    world.find_equilibrium(1e-9);
    [before, at_once, low(world)]
}

#[test]
fn remapping_conserves_set_and_creep_of_springs() {
    for structure in ["trimm", "slamm"] {
        for (from, n) in [(11, 21), (21, 11), (21, 31)] {
            for more in ["temperature: 20, damping_ratio: 1", "creep: true, temperature: 104, damping_ratio: 1"] {
                let mut sagged = clamped(structure, 2, from, more);
                // Without creep the sheet sags while it is soft and keeps the sag when cold.
                if !more.contains("creep") {
                    sagged.advance(0.5);
                    sagged.sheets_mut()[0].set_temperatures(|_| 90.0).unwrap_or_else(|e| panic!("{e}"));
                }
                sagged.advance(1.0);
                let [before, at_once, after] = left(&mut sagged, n);
                let what = format!("{structure} {from} to {n}, {more}");
                assert!(before < -0.01, "{what}: it sagged: {before}");
                assert!((at_once / before - 1.0).abs() < 0.01, "{what}: {at_once} of {before} at once");
                assert!((after / before - 1.0).abs() < 0.01, "{what}: {after} of {before}");
            }
        }
    }
}

#[test]
fn remapping_conserves_forces_settings_and_grabs_of_a_lattice() {
    let mut world = world(
        r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "leaf", structure: "provot3d", grid: (11, 2, 11), size: (0.25, 0.25), gap: 0.004,
            material: "thesis", springs: Uniform, node_mass: 4e-5, damping: 0.2, flexion_limit: Some(40), pins: [(region: Left)], probes: { "tip": (1, 0.5) },
            forces: [(region: Right, value: (0, -0.0004, 0))])])"#,
    );
    for (path, value) in [("material.young", "1e5"), ("friction", "0.7"), ("damping", "0.3"), ("flexion_limit", "55")] {
        world.set(&format!("sheets.leaf.{path}"), value).unwrap_or_else(|e| panic!("{path}: {e}"));
    }
    world.sheets_mut()[0].grab((1.0, 0.25), 5.0).unwrap_or_else(|e| panic!("{e}"));
    world.sheets_mut()[0].pull(0, DVec3::new(0.1, 0.05, 0.0)).unwrap_or_else(|e| panic!("{e}"));
    world.advance(0.3);
    let load = |s: &Sheet| {
        let moment = |i: usize| s.parameters.applied.get(i) * s.model.uv[i].0;
        (s.parameters.applied.iter().sum::<DVec3>(), (0..s.node_count()).map(moment).sum::<DVec3>())
    };
    let settings = |w: &World| w.parameters().into_iter().filter(|p| !p.path.ends_with(".grid")).collect::<Vec<_>>();
    let (before, force, mass) = (settings(&world), load(&world.sheets()[0]), world.sheets()[0].total_mass());
    let tip = world.sheets()[0].probes[0].at(&world.sheets()[0].state.x);
    assert_eq!(world.set("sheets.leaf.grid", "21x17").unwrap_or_else(|e| panic!("{e}")), "11x11");
    let sheet = &world.sheets()[0];
    assert_eq!((sheet.model.grid, settings(&world)), ((21, 2, 17), before));
    let now = load(sheet);
    assert!(now.0.distance(force.0) < 1e-12 && now.1.distance(force.1) < 1e-12, "{now:?} of {force:?}");
    // Given node masses keep their sum.
    assert!((sheet.total_mass() / mass - 1.0).abs() < 1e-12);
    assert!(sheet.probes[0].at(&sheet.state.x).distance(tip) < 2e-3 && sheet.pulls().len() == 1);
    world.advance(0.2);
    assert!(world.unstable().is_none());
}

#[test]
fn snapshots_and_recorded_frames_restore_their_grid() {
    let scene = || clamped("trimm", 2, 11, "temperature: 60, creep: true");
    let mut world = scene();
    world.advance(0.2);
    let first = world.serialise();
    let masses = world.sheets()[0].node_count();
    change_grid(&mut world, (21, 25));
    world.advance(0.1);
    let there = world.serialise();
    let frame = sheetwork::world::recording::RecordedFrame::of(&world);
    assert_eq!((frame.sheets[0].len(), frame.temperatures_of(0).values().len()), (masses, masses));
    let run = |world: &mut World| {
        world.advance(0.2);
        state_hash(world)
    };
    let wanted = run(&mut world);
    world.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((world.sheets()[0].model.grid, run(&mut world)), ((21, 2, 25), wanted));
    let mut new = scene();
    new.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(run(&mut new), wanted);
    new.deserialise(&first).unwrap_or_else(|e| panic!("{e}"));
    assert!(new.serialise() == first, "back on the first grid");
    new.reset().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(new.sheets()[0].model.grid, (11, 2, 11));
}

#[test]
fn a_sleeping_lattice_stays_asleep_after_remapping() {
    let mut world = clamped("trimm", 2, 11, "damping_ratio: 1");
    world.advance(8.0);
    assert_eq!(world.sheets()[0].state.status, Status::Asleep);
    change_grid(&mut world, (21, 21));
    let x = world.sheets()[0].state.x.clone();
    world.advance(0.5);
    assert_eq!((world.sheets()[0].state.status, world.sheets()[0].state.x.clone()), (Status::Asleep, x));
}

#[test]
fn an_explicit_integrator_takes_the_substeps_of_a_finer_lattice() {
    let mut world = world(
        r#"(engine: "verlet", dt: 0.0005, sheets: [(name: "leaf", structure: "trimm", grid: (8, 2, 8), size: (0.025, 0.025), gap: 0.001,
            material: "thesis", springs: Uniform, node_mass: 4e-5, damping: 0.05, pins: [(region: Left)])])"#,
    );
    world.advance(0.1);
    assert_eq!(world.sheets()[0].substeps_of_step(world.dt()), 1);
    change_grid(&mut world, (29, 29));
    assert!(world.sheets()[0].substeps_of_step(5e-3) > 1);
    world.set_dt(5e-3).unwrap_or_else(|e| panic!("{e}"));
    world.advance(0.2);
    assert!(world.unstable().is_none() && world.sheets()[0].max_speed() < 10.0);
}

#[test]
fn levels_of_lattices_are_bit_identical_on_any_number_of_threads() {
    let sheet = |i: u32| {
        format!(
            r#"(name: "sail {i}", structure: "trimm", grid: (21, 2, 21), size: (0.25, 0.25), material: "hips", springs: Calibrated,
                damping_ratio: 0.01, pins: [(region: Left, clamp: true)], placement: (position: ({}, 0, 0)),
                detail: (levels: [(grid: (21, 21), within: 1), (grid: (11, 11), within: 2), (grid: (6, 6))]))"#,
            0.65 * f64::from(i)
        )
    };
    let sheets: Vec<String> = (0..5).map(sheet).collect();
    let text = format!(
        r#"(engine: "tr-bdf2", dt: 0.0166666, camera: (eye: (0, 0, 0.2), target: (0, 0, 0)), sheets: [{}])"#,
        sheets.join(",")
    );
    let run = |threads: usize| {
        let mut world = world(&text);
        world.set_threads(threads).unwrap_or_else(|e| panic!("{e}"));
        world.advance(0.5);
        world.set_viewpoint(Some(DVec3::new(2.6, 0.0, 0.2))).unwrap_or_else(|e| panic!("{e}"));
        world.advance(1.0);
        assert!(world.unstable().is_none());
        (state_hash(&world), world.sheets().iter().map(|s| s.model.grid.0).collect::<Vec<_>>())
    };
    let one = run(1);
    assert_eq!(one.1[0], 6, "{:?}", one.1);
    assert_eq!(run(3), one);
}
