//! Level of detail: state transfer between grids, rejected changes, and the budget.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::sheet::{Sheet, Status};
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::{change_grid, shipped_scene, state_hash, world_of as world};

fn to(world: &mut World, n: u32) {
    change_grid(world, (n, n));
}

/// A clamped sheet with these fields.
fn clamped(grid: u32, more: &str) -> World {
    world(&format!(
        r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "leaf", structure: "shell", grid: ({grid}, 1, {grid}),
            size: (0.25, 0.25), material: "hips", pins: [(region: Left, clamp: true)], {more})])"#
    ))
}

const GRIDS: [u32; 3] = [11, 21, 41];

#[test]
fn no_change_pops_by_more_than_two_percent_of_the_deflection() {
    let found = measure("detail", &Setup::default()).unwrap_or_else(|e| panic!("{e}"));
    let rows = found["changes"].as_array().expect("rows");
    assert_eq!(rows.len(), 30);
    for row in rows {
        let (shape, change) = (row["shape"].as_str().expect("a name"), row["change"].as_str().expect("a name"));
        let pop = row["pop"].as_f64().expect("a number");
        assert!(pop < 0.02, "{shape} {change}: {pop}");
        let rise = row["rise"].as_f64().expect("a number");
        assert!(rise < 0.02, "{shape} {change}: energy rises by {rise}");
        let strain = row["strain_ratio"].as_f64().expect("a number");
        assert!((0.8..1.1).contains(&strain), "{shape} {change}: strain {strain}");
    }
}

#[test]
fn remapping_conserves_mass_and_momenta_of_a_flying_sheet() {
    let text = |n: u32| {
        format!(
            r#"(engine: "tr-bdf2", dt: 0.0166666, gravity: (0, 0, 0), sheets: [(structure: "shell", grid: ({n}, 1, {n}),
                size: (0.25, 0.2), material: "paper", velocity: (1, 0.5, -0.3), spin: (2, 1, 4), curl: (3, 0))])"#
        )
    };
    for from in GRIDS {
        for n in GRIDS.into_iter().filter(|n| *n != from) {
            let mut world = world(&text(from));
            world.advance(0.2);
            let of = |s: &Sheet| (s.total_mass(), s.momentum(), s.angular_momentum(), s.energy(DVec3::ZERO).kinetic);
            let before = of(&world.sheets()[0]);
            to(&mut world, n);
            let after = of(&world.sheets()[0]);
            assert!((after.0 / before.0 - 1.0).abs() < 1e-12);
            assert!(after.1.distance(before.1) < 1e-12 * before.1.length(), "{from} to {n}: {:?}", after.1 - before.1);
            assert!(after.2.distance(before.2) < 1e-9 * before.2.length(), "{from} to {n}: {:?}", after.2 - before.2);
            // The inertia depends on the spacing of the trapezoids; the angular momentum is
            // conserved.
            assert!((after.3 / before.3 - 1.0).abs() < 5e-3, "{from} to {n}: {} of {}", after.3, before.3);
            world.advance(0.1);
            let later = of(&world.sheets()[0]);
            assert!(later.1.distance(before.1) < 1e-9 * before.1.length(), "it flies on");
            assert!(world.unstable().is_none());
        }
    }
}

#[test]
fn pinned_nodes_keep_their_positions_after_remapping() {
    for from in GRIDS {
        for n in GRIDS.into_iter().filter(|n| *n != from) {
            let mut world = clamped(from, "");
            world.advance(0.3);
            to(&mut world, n);
            let check = |world: &World| {
                let sheet = &world.sheets()[0];
                for i in (0..sheet.node_count()).filter(|i| sheet.model.uv[*i].0 == 0.0) {
                    let wanted = DVec3::new(-0.125, 0.0, 0.25 * (sheet.model.uv[i].1 - 0.5));
                    assert!(sheet.is_held(i) && sheet.state.x.get(i).distance(wanted) < 1e-15, "{from} to {n}");
                }
            };
            check(&world);
            world.advance(0.1);
            check(&world);
        }
    }
}

#[test]
fn remapping_conserves_mean_and_range_of_temperatures() {
    for (from, n) in [(41, 11), (41, 21), (21, 11), (11, 21), (11, 41), (21, 16)] {
        let mut world = clamped(from, "temperature: 40, temperature_gradient: true");
        let uv = world.sheets()[0].model.uv.clone();
        let warm = |i: usize| 40.0 + 60.0 * (-20.0 * ((uv[i].0 - 0.5).powi(2) + (uv[i].1 - 0.4).powi(2))).exp();
        world.sheets_mut()[0].set_temperatures(warm).unwrap_or_else(|e| panic!("{e}"));
        world.advance(0.1);
        let of = |s: &Sheet| {
            let celsius = s.temperatures().expect("warm");
            let mean = (0..s.node_count()).map(|i| s.node_mass(i) * celsius[i]).sum::<f64>() / s.total_mass();
            let range = s.heat().expect("warm").range();
            (mean, range.0, range.1)
        };
        let before = of(&world.sheets()[0]);
        to(&mut world, n);
        let after = of(&world.sheets()[0]);
        assert!((after.0 - before.0).abs() < 1e-9, "{from} to {n}: {} of {}", after.0, before.0);
        let spread = before.2 - before.1;
        assert!((after.1 - before.1).abs() < 0.02 * spread, "{from} to {n}: coldest {} of {}", after.1, before.1);
        // The mean over a cell of 11 nodes is 6 % below the maximum of a spot that is 0.22 wide.
        assert!((after.2 - before.2).abs() < 0.07 * spread, "{from} to {n}: hottest {} of {}", after.2, before.2);
        world.advance(0.1);
        let later = of(&world.sheets()[0]);
        assert!((later.0 - before.0).abs() < 0.5, "it cools on as before: {} of {}", later.0, before.0);
    }
}

/// Angle between the two ends of a sheet, rad.
fn fold(sheet: &Sheet) -> f64 {
    let at = |u: f64| {
        let near = |i: &usize| (sheet.model.uv[*i].0 - u).abs() < 1e-9 && (sheet.model.uv[*i].1 - 0.5).abs() < 1e-9;
        sheet.state.x.get((0..sheet.node_count()).find(near).expect("a mass there"))
    };
    (at(0.2) - at(0.0)).angle_between(at(1.0) - at(0.8))
}

#[test]
fn remapping_conserves_creases_and_plastic_folds() {
    for from in GRIDS {
        for n in GRIDS.into_iter().filter(|n| *n != from) {
            let mut made = clamped(from, "creases: [(from: (0.5, 0), to: (0.5, 1), angle: 40)]");
            made.set_gravity(DVec3::ZERO).unwrap_or_else(|e| panic!("{e}"));
            made.find_equilibrium(1e-9);
            let before = fold(&made.sheets()[0]);
            assert!((before.to_degrees() - 40.0).abs() < 1.0, "{}", before.to_degrees());
            to(&mut made, n);
            let at_once = fold(&made.sheets()[0]);
            made.find_equilibrium(1e-9);
            let after = fold(&made.sheets()[0]);
            assert!(
                (at_once / before - 1.0).abs() < 0.01 && (after / before - 1.0).abs() < 0.02,
                "{from} to {n}: {after}"
            );
        }
    }
}

/// Angle between the clamp and the free end, rad.
fn turned(sheet: &Sheet) -> f64 {
    let at = |u: f64| {
        let near = |i: &usize| (sheet.model.uv[*i].0 - u).abs() < 1e-9 && (sheet.model.uv[*i].1 - 0.5).abs() < 1e-9;
        sheet.state.x.get((0..sheet.node_count()).find(near).expect("a mass there"))
    };
    (at(1.0) - at(0.8)).angle_between(DVec3::X)
}

#[test]
fn remapping_conserves_the_angle_of_a_plastic_fold() {
    for from in GRIDS {
        let more = "plastic: true, damping_ratio: 0.2";
        let mut bent = clamped(from, more);
        // A load far beyond yield, then release.
        bent.set_gravity(DVec3::new(0.0, -300.0, 0.0)).unwrap_or_else(|e| panic!("{e}"));
        bent.advance(1.0);
        bent.set_gravity(DVec3::ZERO).unwrap_or_else(|e| panic!("{e}"));
        bent.find_equilibrium(1e-9);
        let before = turned(&bent.sheets()[0]);
        assert!(before > 0.1, "it stays bent: {before}");
        let there = bent.serialise();
        for n in GRIDS.into_iter().filter(|n| *n != from) {
            bent.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
            to(&mut bent, n);
            let at_once = turned(&bent.sheets()[0]);
            assert!((at_once / before - 1.0).abs() < 0.02, "{from} to {n}: {at_once} of {before} at once");
            bent.find_equilibrium(1e-9);
            let after = turned(&bent.sheets()[0]);
            assert!((after / before - 1.0).abs() < 0.05, "{from} to {n}: {after} of {before}");
        }
    }
}

#[test]
fn remapping_conserves_creep_and_set() {
    for (from, n) in [(21, 11), (11, 21), (21, 41)] {
        let mut sagged = clamped(from, "creep: true, temperature: 115, damping_ratio: 1");
        sagged.advance(3.0);
        let low = |world: &World| world.sheets()[0].state.x.iter().map(|p| p.y).fold(0.0, f64::min);
        // Without load and cold, the remaining deflection is creep.
        sagged.set_gravity(DVec3::ZERO).unwrap_or_else(|e| panic!("{e}"));
        sagged.set("sheets.leaf.temperature", "20").unwrap_or_else(|e| panic!("{e}"));
        sagged.find_equilibrium(1e-9);
        let before = low(&sagged);
        assert!(before < -0.02, "it sagged: {before}");
        to(&mut sagged, n);
        let at_once = low(&sagged);
        sagged.find_equilibrium(1e-9);
        let after = low(&sagged);
        assert!(
            (at_once / before - 1.0).abs() < 0.01 && (after / before - 1.0).abs() < 0.05,
            "{from} to {n}: {after} of {before}"
        );
    }
}

#[test]
fn remapping_conserves_settings_and_grabs() {
    let mut world = clamped(21, "probes: { \"tip\": (1, 0.5) }, forces: [(region: Right, value: (0, -0.001, 0))]");
    for (path, value) in [("material.young", "1e9"), ("friction", "0.7"), ("damping_ratio", "0.3"), ("pressure", "2")] {
        world.set(&format!("sheets.leaf.{path}"), value).unwrap_or_else(|e| panic!("{e}"));
    }
    world.sheets_mut()[0].set_when_unstable(sheetwork::scene::WhenUnstable::Freeze).unwrap_or_else(|e| panic!("{e}"));
    world.sheets_mut()[0].grab((1.0, 0.25), 5.0).unwrap_or_else(|e| panic!("{e}"));
    world.sheets_mut()[0].pull(0, DVec3::new(0.1, 0.1, 0.0)).unwrap_or_else(|e| panic!("{e}"));
    world.advance(0.3);
    let force = |s: &Sheet| s.parameters.applied.iter().sum::<DVec3>();
    let settings = |w: &World| w.parameters().into_iter().filter(|p| !p.path.ends_with(".grid")).collect::<Vec<_>>();
    let (before, pull, load) = (settings(&world), world.sheets()[0].pulls()[0], force(&world.sheets()[0]));
    let tip = world.sheets()[0].probes[0].at(&world.sheets()[0].state.x);
    let held = pull.point(&world.sheets()[0].state.x);
    assert_eq!(world.set("sheets.leaf.grid", "11x31").unwrap_or_else(|e| panic!("{e}")), "21x21");
    let sheet = &world.sheets()[0];
    assert_eq!((sheet.model.grid, settings(&world)), ((11, 1, 31), before));
    assert!(force(sheet).distance(load) < 1e-12 && sheet.probes[0].at(&sheet.state.x).distance(tip) < 2e-4);
    let now = sheet.pulls()[0];
    assert_eq!((now.target, now.stiffness), (pull.target, pull.stiffness));
    assert!(now.point(&sheet.state.x).distance(held) < 2e-4);
    world.advance(0.2);
    assert!(world.unstable().is_none());
}

#[test]
fn a_sleeping_sheet_stays_asleep_after_remapping() {
    let mut world = clamped(21, "damping_ratio: 1");
    world.advance(6.0);
    assert_eq!(world.sheets()[0].state.status, Status::Asleep);
    to(&mut world, 41);
    assert_eq!(world.sheets()[0].state.status, Status::Asleep);
    let x = world.sheets()[0].state.x.clone();
    world.advance(0.5);
    assert_eq!(world.sheets()[0].state.x, x, "nothing moves");
}

#[test]
fn an_impossible_change_of_grid_is_rejected_with_the_reason() {
    let refused = |fields: &str, extra: &str, grid: (u32, u32)| {
        let mut world =
            world(&format!(r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "leaf", {fields})], {extra})"#));
        let x = world.sheets()[0].state.x.clone();
        let e = world.remap("leaf", grid).expect_err("refused");
        assert_eq!((world.sheets()[0].state.x.clone(), e.field.as_str()), (x, "sheets.leaf.grid"), "{}", e.problem);
        e.problem
    };
    let shell = r#"structure: "shell", grid: (11, 1, 11), size: (0.25, 0.25), material: "hips""#;
    assert!(refused(r#"structure: "slamm", grid: (5, 2, 5), tearing: true, slits: [((0.2, 0.5), (0.8, 0.5))], material: "hips""#, "", (9, 9)).contains("open"));
    assert!(refused(&format!("{shell}, slits: [((0.2, 0.5), (0.8, 0.5))]"), "", (9, 9)).contains("open"));
    assert!(refused(&format!("{shell}, pins: [(region: Masses([3]))]"), "", (9, 9)).contains("number"));
    assert!(refused(&format!("{shell}, pins: [(region: Point(0.3, 0.5))]"), "", (9, 9)).contains("no mass at"));
    let glued = format!(r#"{shell}, pins: [(region: Left, body: "box")]"#);
    assert!(
        refused(
            &glued,
            r#"bodies: [(name: "box", shape: Box((0.1, 0.1, 0.1)), placement: (position: (-0.2, 0, 0)))]"#,
            (9, 9)
        )
        .contains("glued")
    );
    assert!(refused(shell, "", (1, 9)).contains("2 to 2000"));
    let mut world = world(&format!("(sheets: [(name: \"leaf\", {shell})])"));
    assert!(world.remap("none", (9, 9)).expect_err("refused").problem.contains("no sheet"));
    assert!(world.set("sheets.leaf.grid", "many").expect_err("refused").problem.contains("21x11"));
}

#[test]
fn snapshots_and_journals_restore_their_grid() {
    let scene = || clamped(11, "creases: [(from: (0.5, 0), to: (0.5, 1), angle: 20)], plastic: true, temperature: 60");
    let mut world = scene();
    world.advance(0.2);
    let first = world.serialise();
    to(&mut world, 21);
    world.advance(0.1);
    let there = world.serialise();
    let run = |world: &mut World| {
        world.advance(0.2);
        state_hash(world)
    };
    let wanted = run(&mut world);
    // In the same world, in a new one, and from another grid.
    world.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((world.sheets()[0].model.grid.0, run(&mut world)), (21, wanted));
    let mut new = scene();
    new.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(run(&mut new), wanted);
    new.deserialise(&first).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(new.sheets()[0].model.grid.0, 11);
    assert!(new.serialise() == first, "back on the first grid");
    new.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(run(&mut new), wanted);
    new.reset().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(new.sheets()[0].model.grid.0, 11);
    // With parameters that keep their present values.
    let snapshot = world.snapshot();
    to(&mut world, 41);
    world.set("sheets.leaf.friction", "0.9").unwrap_or_else(|e| panic!("{e}"));
    world.restore(&snapshot).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((world.sheets()[0].model.grid.0, world.sheets()[0].parameters.friction), (21, 0.9));
}

/// Swinging sheets with three levels each, at several distances from an eye.
fn many(budget: &str, levels: bool) -> String {
    let sheet = |i: u32| {
        let levels = if levels {
            "detail: (levels: [(grid: (21, 21), within: 1), (grid: (11, 11), within: 2), (grid: (6, 6))]),"
        } else {
            ""
        };
        format!(
            r#"(name: "sail {i}", structure: "shell", grid: (21, 1, 21), size: (0.25, 0.25), material: "hips", damping_ratio: 0.005,
                pins: [(region: Left, clamp: true)], placement: (position: ({}, 0, 0)), {levels})"#,
            0.65 * f64::from(i)
        )
    };
    let sheets: Vec<String> = (0..5).map(sheet).collect();
    format!(
        r#"(engine: "tr-bdf2", dt: 0.0166666, {budget} camera: (eye: (0, 0, 0.2), target: (0, 0, 0)), sheets: [{}])"#,
        sheets.join(",")
    )
}

#[test]
fn grids_follow_the_distance_of_the_viewpoint() {
    let mut world = world(&many("", true));
    let grids = |world: &World| world.sheets().iter().map(|s| s.model.grid.0).collect::<Vec<_>>();
    world.advance(1.0);
    assert_eq!(grids(&world), [21, 21, 11, 11, 6]);
    // Small changes of distance do not change the grid each time (hysteresis).
    let steps = 60;
    let mut changes = 0;
    for k in 0..steps {
        let by = if k % 2 == 0 { 0.02 } else { -0.02 };
        world.set_viewpoint(Some(DVec3::new(by, 0.0, 0.2))).unwrap_or_else(|e| panic!("{e}"));
        let before = grids(&world);
        world.step();
        changes += u32::from(before != grids(&world));
    }
    assert!(changes <= 2, "{changes} changes");
    world.set("viewpoint", "(2.6, 0, 0.2)").unwrap_or_else(|e| panic!("{e}"));
    world.advance(4.0);
    assert_eq!(grids(&world), [6, 11, 11, 21, 21]);
    assert!(world.unstable().is_none());
}

#[test]
fn the_budget_is_respected_without_oscillation() {
    let mut free = world(&many("", true));
    free.set_viewpoint(None).unwrap_or_else(|e| panic!("{e}"));
    free.advance(0.5);
    let whole = free.detail_cost().expect("levels");
    let budget = 0.4 * whole;
    let mut world = world(&many(&format!("detail_budget: {budget},"), true));
    world.set_viewpoint(None).unwrap_or_else(|e| panic!("{e}"));
    world.advance(0.5);
    let (mut over, mut changes, mut mean) = (0, 0, 0.0);
    for _ in 0..240 {
        let before: Vec<_> = world.sheets().iter().map(|s| s.model.grid).collect();
        world.step();
        changes += u32::from(before != world.sheets().iter().map(|s| s.model.grid).collect::<Vec<_>>());
        let cost = world.detail_cost().expect("levels");
        mean += cost / 240.0;
        over += u32::from(cost > 1.2 * budget);
    }
    assert!(mean <= budget && mean > 0.3 * budget, "{mean} of {budget}, {whole} without");
    assert!(over <= 12, "{over} steps of 240 far over the budget");
    assert!(changes <= 8, "{changes} changes in four seconds");
}

#[test]
fn level_of_detail_is_bit_identical_on_any_number_of_threads() {
    let run = |threads: usize| {
        let mut world = world(&many("detail_budget: 1.5,", true));
        world.set_threads(threads).unwrap_or_else(|e| panic!("{e}"));
        (0..90).for_each(|_| _ = world.step());
        (state_hash(&world), world.sheets().iter().map(|s| s.model.grid).collect::<Vec<_>>())
    };
    let one = run(1);
    for threads in [2, 3] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
    assert!(one.1.iter().any(|g| g.0 < 21), "{:?}", one.1);
    // A snapshot in the middle of the run.
    let mut world = world(&many("detail_budget: 1.5,", true));
    (0..40).for_each(|_| _ = world.step());
    let there = world.serialise();
    let mut other = self::world(&many("detail_budget: 1.5,", true));
    other.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    (0..50).for_each(|_| _ = other.step());
    assert_eq!(state_hash(&other), one.0);
}

#[test]
fn an_explicit_integrator_takes_the_substeps_of_a_finer_grid() {
    let mut world = world(
        r#"(engine: "verlet", dt: 0.00002, sheets: [(name: "leaf", structure: "shell", grid: (6, 1, 6), size: (0.25, 0.25),
            material: "rubber", damping_ratio: 0, pins: [(region: Left, clamp: true)])])"#,
    );
    world.advance(0.02);
    assert_eq!(world.sheets()[0].substeps_of_step(world.dt()), 1);
    to(&mut world, 21);
    let parts = world.sheets()[0].substeps_of_step(world.dt());
    world.set_dt(1e-3).unwrap_or_else(|e| panic!("{e}"));
    assert!(world.sheets()[0].substeps_of_step(1e-3) > 3 && parts >= 1);
    world.advance(0.1);
    assert!(world.unstable().is_none() && world.sheets()[0].max_speed() < 10.0);
}

#[test]
fn levels_have_no_effect_on_other_sheets() {
    // A sheet whose only level is its own grid is bit-identical to one without levels.
    let off = many("", false);
    let one = off.replace("damping_ratio: 0.005,", "damping_ratio: 0.005, detail: (levels: [(grid: (21, 21))]),");
    let run = |text: &str| {
        let mut world = world(text);
        (0..40).for_each(|_| _ = world.step());
        world.sheets().iter().map(|s| s.state.x.clone()).collect::<Vec<_>>()
    };
    assert!(run(&off) == run(&one));
    // A change of a neighbour's grid leaves a sheet bit-identical.
    let mut world = world(&off);
    (0..20).for_each(|_| _ = world.step());
    world.remap("sail 0", (11, 11)).unwrap_or_else(|e| panic!("{e}"));
    (0..20).for_each(|_| _ = world.step());
    let there: Vec<_> = world.sheets().iter().map(|s| s.state.x.clone()).collect();
    assert!(there[1..] == run(&off)[1..]);
}

#[test]
fn a_change_of_grid_sends_an_event() {
    let mut world = clamped(11, "");
    world.step();
    to(&mut world, 11);
    assert!(world.events().is_empty(), "it has that grid");
    to(&mut world, 21);
    let [event] = world.events() else { panic!("{:?}", world.events()) };
    assert_eq!((event.kind, event.sheet.as_str(), event.grid), (EventKind::Resampled, "leaf", Some((21, 21))));
    assert_eq!(event.time_s, world.time());
}

#[test]
fn the_shipped_scene_changes_grids() {
    let mut world = World::new(&shipped_scene("detail")).unwrap_or_else(|e| panic!("{e}"));
    assert!(world.has_detail());
    world.advance(2.0);
    let grids: Vec<_> = world.sheets().iter().map(|s| s.model.grid.0).collect();
    assert!(world.events().iter().any(|e| e.kind == EventKind::Resampled));
    assert!(grids.iter().any(|g| *g == grids[0]) && grids.iter().any(|g| *g != grids[0]), "{grids:?}");
}
