//! The flexion angle limit holds in contact, at the step of the scene, and lets the sheet rest.

use glam::DVec2;
use sheetwork::World;
use sheetwork::sheet::Sheet;
use sheetwork_tests::{shipped_scene, world};

/// A provot sheet on the wedge of the thesis, at the scene's own step of 5 ms.
fn on_the_wedge(structure: &str, limit: f64, engine: &str) -> World {
    let grid = if structure == "provot2d" { "(11, 1, 11)" } else { "(11, 2, 11)" };
    let limit = limit.to_string();
    let set = [
        ("engine", engine),
        ("sheets.0.structure", structure),
        ("sheets.0.grid", grid),
        ("sheets.0.flexion_limit", &limit),
    ];
    let scene = shipped_scene("wedge").with_overrides(&set).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.dt, 0.005);
    world(&scene)
}

fn angle(world: &World) -> f64 {
    world.sheets()[0].largest_flexion_angle().unwrap_or_else(|| panic!("a structure with flexion"))
}

/// Largest displacement of a node in the next step over its length, m/s.
fn speed(world: &mut World) -> f64 {
    let before = world.sheets()[0].state.x.clone();
    world.step();
    let moved = before.iter().zip(world.sheets()[0].state.x.iter()).map(|(a, b)| a.distance(b));
    moved.fold(0.0, f64::max) / world.dt()
}

#[test]
fn the_flexion_limit_holds_within_a_degree_in_contact_and_the_sheet_rests() {
    for structure in ["provot2d", "provot3d", "provot-trimm"] {
        for (limit, engine) in
            [(60.0, "euler-richardson"), (40.0, "euler-richardson"), (20.0, "rk4"), (20.0, "euler-richardson")]
                .into_iter()
                .chain([(10.0, "euler-richardson")])
        {
            let mut world = on_the_wedge(structure, limit, engine);
            // The sheet sleeps when it has rested for half a second.
            world.set_sleep(true);
            let (mut peak, mut last_motion) = (0.0_f64, 0.0);
            while world.time() < 8.0 {
                if speed(&mut world) > 1e-3 {
                    last_motion = world.time();
                }
                peak = peak.max(angle(&world));
            }
            let end = angle(&world);
            println!("{structure} {limit} {engine}: end {end:.2}, peak {peak:.2}, at rest from {last_motion:.2} s");
            assert!(peak < limit + 1.0, "{structure} {limit} {engine}: {peak}");
            assert!((end - limit).abs() < 1.0, "{structure} {limit} {engine}: {end}");
            assert!(last_motion < 4.0, "{structure} {limit} {engine}: moves until {last_motion} s");
            assert_eq!(world.sheets()[0].max_speed(), 0.0);
        }
    }
}

#[test]
fn a_sheet_at_its_flexion_limit_continues_from_a_snapshot_bit_for_bit() {
    for structure in ["provot2d", "provot3d", "provot-trimm"] {
        let mut world = on_the_wedge(structure, 20.0, "euler-richardson");
        for _ in 0..80 {
            world.step();
        }
        let snapshot = world.snapshot();
        let mut other = on_the_wedge(structure, 20.0, "euler-richardson");
        other.restore(&snapshot).unwrap_or_else(|e| panic!("{e}"));
        for _ in 0..20 {
            world.step();
            other.step();
            assert_eq!(world.state_hash(), other.state_hash(), "{structure} at {} s", world.time());
        }
    }
}

/// Turn about the vertical between two states, degrees: least squares over the bottom layer in
/// plan.
fn yaw(before: &Sheet, after: &Sheet) -> f64 {
    let plan = |sheet: &Sheet| -> Vec<DVec2> {
        let bottom = sheet.model.layers[0].range().map(|i| sheet.state.x.get(i));
        let points: Vec<DVec2> = bottom.map(|p| DVec2::new(p.z, p.x)).collect();
        let middle = points.iter().sum::<DVec2>() / points.len() as f64;
        points.into_iter().map(|p| p - middle).collect()
    };
    let pairs = || plan(before).into_iter().zip(plan(after));
    let (sine, cosine): (f64, f64) = (pairs().map(|(p, q)| p.perp_dot(q)).sum(), pairs().map(|(p, q)| p.dot(q)).sum());
    sine.atan2(cosine).to_degrees()
}

#[test]
fn a_triangular_sheet_with_flexion_bends_over_the_wedge_without_yaw() {
    let turned = |structure: &str| {
        let scene = shipped_scene("wedge").with_override("sheets.0.structure", structure).expect("valid");
        let (start, mut world) = (world(&scene), world(&scene));
        world.set_sleep(true);
        (0..1600).for_each(|_| {
            world.step();
        });
        let sheet = &world.sheets()[0];
        assert!(world.unstable().is_none() && sheet.max_speed() == 0.0, "{structure}: {} m/s", sheet.max_speed());
        yaw(&start.sheets()[0], sheet)
    };
    let (flexion, plain, slamm) = (turned("provot-trimm"), turned("trimm"), turned("slamm"));
    println!("yaw: provot-trimm {flexion:.3}, trimm {plain:.3}, slamm {slamm:.3} degrees");
    // Thesis 5.3.4 and figure 5.18: TRiMM deforms regularly, where the diagonals of SLaMM turn it.
    assert!(flexion.abs() < 0.5 && flexion.abs() < 0.5 * slamm.abs(), "{flexion} degrees, slamm {slamm}");
}
