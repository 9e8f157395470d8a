//! State transfer between grids of sheets with an outline, holes or cuts.

use glam::DVec3;
use sheetwork::World;
use sheetwork::scene::Scene;
use sheetwork::sheet::Sheet;
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::{change_grid, mean_and_range_of_temperatures, state_hash, world_of as world};

const GRIDS: [u32; 3] = [11, 21, 41];

fn to(world: &mut World, n: u32) {
    change_grid(world, (n, n));
}

/// A tag clamped along its straight end, with a hole, and with the fields `more`.
fn tag(grid: u32, more: &str) -> World {
    world(&format!(
        r#"(engine: "tr-bdf2", dt: 0.0166666, sheets: [(name: "tag", structure: "shell", grid: ({grid}, 1, {grid}), size: (0.25, 0.25),
            outline: Polygon([(-0.125, -0.125), (0.06, -0.125), (0.125, 0), (0.06, 0.125), (-0.125, 0.125)]),
            holes: [Disc(centre: (0.03, 0.02), radius: 0.03)], material: "hips", pins: [(region: Left, clamp: true)], {more})])"#
    ))
}

#[test]
fn no_change_pops_by_more_than_two_percent_of_the_deflection() {
    let found = measure("detail", &Setup { outlined: true, ..Setup::default() }).unwrap_or_else(|e| panic!("{e}"));
    for row in found["changes"].as_array().expect("rows") {
        let (shape, change) = (row["shape"].as_str().expect("a name"), row["change"].as_str().expect("a name"));
        // A fold is three cells wide on any grid, and the edge of a box is resolved by one cell:
        // docs/detail.md.
        let most = match shape {
            "crease" => 0.05,
            "box" => 0.03,
            _ => 0.02,
        };
        let pop = row["pop"].as_f64().expect("a number");
        assert!(pop < most, "{shape} {change}: {pop}");
        let rise = row["rise"].as_f64().expect("a number");
        assert!(rise < 0.02, "{shape} {change}: energy rises by {rise}");
        let strain = row["strain_ratio"].as_f64().expect("a number");
        assert!(shape == "crease" || (0.8..1.2).contains(&strain), "{shape} {change}: strain {strain}");
    }
}

#[test]
fn remapping_conserves_mass_and_momenta_of_a_flying_disc() {
    let text = |n: u32, more: &str| {
        format!(
            r#"(engine: "tr-bdf2", dt: 0.0166666, gravity: (0, 0, 0), sheets: [(structure: "shell", grid: ({n}, 1, {n}), size: (0.25, 0.25),
                outline: Disc(radius: 0.125), cuts: [[(0, 0), (0.2, 0)]], {more} material: "paper", velocity: (1, 0.5, -0.3), spin: (2, 1, 4))])"#
        )
    };
    for more in ["", "node_mass: 1e-5,"] {
        for from in GRIDS {
            for n in GRIDS.into_iter().filter(|n| *n != from) {
                let mut world = world(&text(from, more));
                world.advance(0.2);
                let of =
                    |s: &Sheet| (s.total_mass(), s.momentum(), s.angular_momentum(), s.energy(DVec3::ZERO).kinetic);
                let before = of(&world.sheets()[0]);
                to(&mut world, n);
                let after = of(&world.sheets()[0]);
                // Chords of a coarse circle lose a part of its area; given node masses keep their
                // sum.
                let weight = if more.is_empty() { 0.01 } else { 1e-12 };
                assert!((after.0 / before.0 - 1.0).abs() < weight, "{from} to {n}: {} kg of {}", after.0, before.0);
                assert!(after.1.distance(before.1) < 1e-12 * before.1.length(), "{from} to {n}");
                assert!(after.2.distance(before.2) < 1e-9 * before.2.length(), "{from} to {n}");
                assert!((after.3 / before.3 - 1.0).abs() < 0.03, "{from} to {n}: {} of {} J", after.3, before.3);
                world.advance(0.1);
                assert!(world.unstable().is_none());
            }
        }
    }
}

#[test]
fn pinned_nodes_keep_their_positions_after_remapping() {
    for (from, n) in [(11, 21), (21, 11), (21, 41)] {
        let mut world = tag(from, "");
        world.advance(0.3);
        to(&mut world, n);
        let check = |world: &World| {
            let sheet = &world.sheets()[0];
            let held: Vec<usize> = (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).collect();
            assert_eq!(held.len(), n as usize);
            for i in held {
                let wanted = DVec3::new(-0.125, 0.0, 0.25 * (sheet.model.uv[i].1 - 0.5));
                assert!(sheet.state.x.get(i).distance(wanted) < 1e-15, "{from} to {n}");
            }
        };
        check(&world);
        world.advance(0.1);
        check(&world);
    }
}

#[test]
fn remapping_conserves_mean_and_range_of_temperatures() {
    for (from, n) in [(41, 11), (41, 21), (21, 11), (11, 21), (11, 41), (21, 16)] {
        let mut world = tag(from, "temperature: 40, temperature_gradient: true");
        let uv = world.sheets()[0].model.uv.clone();
        let warm = |i: usize| 40.0 + 60.0 * (-20.0 * ((uv[i].0 - 0.4).powi(2) + (uv[i].1 - 0.3).powi(2))).exp();
        world.sheets_mut()[0].set_temperatures(warm).unwrap_or_else(|e| panic!("{e}"));
        let of = mean_and_range_of_temperatures;
        let before = of(&world.sheets()[0]);
        to(&mut world, n);
        let after = of(&world.sheets()[0]);
        assert!((after.0 - before.0).abs() < 1e-9, "{from} to {n}: {} of {}", after.0, before.0);
        let spread = before.2 - before.1;
        assert!((after.1 - before.1).abs() < 0.03 * spread, "{from} to {n}: coldest {} of {}", after.1, before.1);
        assert!((after.2 - before.2).abs() < 0.09 * spread, "{from} to {n}: hottest {} of {}", after.2, before.2);
    }
}

/// Droop of the tag's point, m.
fn hangs(sheet: &Sheet) -> f64 {
    let tip = (0..sheet.node_count()).find(|i| (sheet.model.uv[*i].0 - 1.0).abs() < 1e-12).expect("a corner");
    -sheet.state.x.get(tip).y
}

#[test]
fn remapping_conserves_a_plastic_fold_and_creep() {
    for (from, n) in [(11, 21), (21, 11)] {
        let mut bent = tag(from, "plastic: true, damping_ratio: 0.2");
        bent.set_gravity(DVec3::new(0.0, -700.0, 0.0)).unwrap_or_else(|e| panic!("{e}"));
        bent.advance(1.0);
        let mut sagged = tag(from, "creep: true, temperature: 115, damping_ratio: 1");
        sagged.advance(3.0);
        sagged.set("sheets.tag.temperature", "20").unwrap_or_else(|e| panic!("{e}"));
        for (what, mut world) in [("bent", bent), ("sagged", sagged)] {
            world.set_gravity(DVec3::ZERO).unwrap_or_else(|e| panic!("{e}"));
            world.find_equilibrium(1e-9);
            let before = hangs(&world.sheets()[0]);
            assert!(before > 0.01, "it is {what}: {before}");
            to(&mut world, n);
            let at_once = hangs(&world.sheets()[0]);
            world.find_equilibrium(1e-9);
            let after = hangs(&world.sheets()[0]);
            assert!((at_once / before - 1.0).abs() < 0.03, "{what}, {from} to {n}: {at_once} of {before} at once");
            assert!((after / before - 1.0).abs() < 0.15, "{what}, {from} to {n}: {after} of {before}");
        }
    }
}

#[test]
fn snapshots_and_recordings_restore_their_mesh() {
    let mut world = tag(21, "forces: [(region: Right, value: (0, -0.001, 0))]");
    world.advance(0.2);
    let first = world.serialise();
    let force = |w: &World| w.sheets()[0].parameters.applied.iter().sum::<DVec3>();
    let load = force(&world);
    to(&mut world, 11);
    assert!(force(&world).distance(load) < 1e-12);
    world.advance(0.1);
    let coarse = world.serialise();
    // A recording has the nodes of the scene's grid.
    let frame = sheetwork::world::recording::RecordedFrame::of(&world);
    world.deserialise(&first).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((world.sheets()[0].model.grid, frame.sheets[0].len()), ((21, 1, 21), world.sheets()[0].node_count()));
    world.deserialise(&coarse).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(world.sheets()[0].model.grid, (11, 1, 11));
    world.advance(0.3);
    let mut other = tag(21, "forces: [(region: Right, value: (0, -0.001, 0))]");
    other.deserialise(&coarse).unwrap_or_else(|e| panic!("{e}"));
    other.advance(0.3);
    assert_eq!(state_hash(&world), state_hash(&other), "to the bit");
}

#[test]
fn a_level_too_coarse_for_its_hole_is_rejected() {
    let levels = |n: u32| format!("detail: (levels: [(grid: (21, 21), within: 1), (grid: ({n}, {n}))])");
    assert_eq!(tag(21, &levels(11)).sheets()[0].model.grid, (21, 1, 21));
    let text = |n| {
        format!(
            r#"(engine: "tr-bdf2", sheets: [(structure: "shell", grid: (21, 1, 21), size: (0.25, 0.25),
                holes: [Disc(centre: (0, 0), radius: 0.015)], {})])"#,
            levels(n)
        )
    };
    let scene = Scene::parse(&text(5)).unwrap_or_else(|e| panic!("{e}"));
    let e = World::new(&scene).err().expect("refused");
    assert!(e.field.ends_with("detail.levels.1.grid") && e.problem.contains("too coarse"), "{e}");
    let mut world = world(&text(16));
    let e = world.remap("sheet 0", (5, 5)).expect_err("refused");
    assert!(e.field.starts_with("sheets.sheet 0.holes.0"), "{e}");
}
