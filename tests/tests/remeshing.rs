//! Local refinement of triangle meshes (thesis 7.3 c, 7.4 v and vi): accuracy of a fold, conserved
//! quantities at a change, snapshots, and refinement of a notch before it tears.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;
use sheetwork::sheet::Sheet;
use sheetwork::world::recording::RecordedFrame;
use sheetwork_tests::{mean_and_range_of_temperatures, shipped_scene, state_hash, world_of};

/// The shipped scene with its first sheet on another mesh.
fn pressed(overrides: &[(&str, &str)]) -> World {
    let scene = shipped_scene("pressed_fold").with_overrides(overrides).unwrap_or_else(|e| panic!("{e}"));
    World::new(&scene).unwrap_or_else(|e| panic!("{e}"))
}

fn steps(world: &mut World, count: usize) {
    (0..count).for_each(|_| _ = world.step());
}

fn changes(world: &World) -> usize {
    world.events().iter().filter(|e| e.kind == EventKind::Resampled).count()
}

/// Elastic energy (J) and place of the fold's apex (m).
fn fold(world: &World) -> (f64, f64) {
    let sheet = &world.sheets()[0];
    (sheet.energy(DVec3::ZERO).elastic, sheet.state.x.bounds().map_or(0.0, |b| b.1.x))
}

/// Two free strips that are struck in the middle, so that they bend and fly. Without damping the
/// integrator raises the energy of such strips by a percent in a step.
fn struck(damping_ratio: f64, more: &str) -> World {
    let strip = |name: &str, z: f64| {
        format!(
            r#"(name: "{name}", structure: "shell", grid: (17, 1, 5), size: (0.16, 0.04), material: "hips", damping_ratio: {damping_ratio},
                outline: Polygon([(-0.08, -0.02), (0.08, -0.02), (0.08, 0.02), (-0.08, 0.02)]), placement: (position: (0, 0, {z})),
                velocities: [(region: Rect((0.35, 0.65), (0, 1)), value: (0, 8, 0))], velocity: (0.3, 0, 0.1), spin: (0, 2, 0),
                refine: (levels: 2, fold: 4, every: 5), {more})"#
        )
    };
    let (a, b) = (strip("a", 0.0), strip("b", 0.3));
    world_of(&format!(r#"(engine: "tr-bdf2", dt: 0.002, gravity: (0, 0, 0), sheets: [{a}, {b}])"#))
}

#[test]
fn a_pressed_fold_is_as_accurate_as_on_a_fine_mesh_with_half_its_nodes() {
    let run = |overrides: &[(&str, &str)]| {
        let mut world = pressed(overrides);
        steps(&mut world, 58);
        assert!(world.unstable().is_none());
        (fold(&world), world.sheets()[0].node_count(), changes(&world))
    };
    let fixed = ("sheets.0.refine", "none");
    let ((energy, apex), nodes, _) = run(&[fixed]);
    let ((fine_energy, fine_apex), fine_nodes, _) = run(&[fixed, ("sheets.0.grid", "(65, 1, 13)")]);
    let ((own_energy, own_apex), own_nodes, times) = run(&[]);
    println!("energy {energy:.4e} {own_energy:.4e} {fine_energy:.4e} J; apex {apex:.5} {own_apex:.5} {fine_apex:.5} m");
    println!("nodes {nodes} {own_nodes} {fine_nodes}, {times} changes");
    assert!(own_nodes < fine_nodes / 2, "{own_nodes} of {fine_nodes} nodes");
    let off = |e: f64| (e / fine_energy - 1.0).abs();
    assert!(off(energy) > 0.15 && off(own_energy) < 0.02, "{energy} and {own_energy} of {fine_energy} J");
    let away = |x: f64| (x - fine_apex).abs();
    assert!(away(apex) > 1e-3 && away(own_apex) < away(apex) / 3.0, "{apex} and {own_apex}, not {fine_apex} m");
    // At most one in ten steps.
    assert!((2..=5).contains(&times), "{times} changes");
}

#[test]
fn the_refinement_goes_away_when_the_sheet_is_flat_again() {
    let mut world = pressed(&[]);
    let first = world.sheets()[0].node_count();
    steps(&mut world, 58);
    assert!(world.sheets()[0].node_count() > 3 * first);
    assert!(world.sheets()[0].model.refinement.as_ref().expect("refined").contains(&2));
    steps(&mut world, 62);
    assert_eq!(world.sheets()[0].node_count(), first);
    assert!(world.sheets()[0].model.refinement.as_ref().expect("refined").iter().all(|level| *level == 0));
    // Only changes of the mesh are events of this kind, each at a multiple of ten steps.
    let due = |time: f64| ((time / world.dt()).round() as u64).is_multiple_of(10);
    assert!(world.events().iter().filter(|e| e.kind == EventKind::Resampled).all(|e| due(e.time_s)));
}

#[test]
fn a_change_conserves_momentum_and_raises_energy_by_at_most_two_percent() {
    let mut world = struck(0.015, "");
    let of = |s: &Sheet| (s.total_mass(), s.momentum(), s.angular_momentum(), s.energy(DVec3::ZERO).total);
    let (mut changed, mut coarsened) = (0, 0);
    // Largest change of the angular momentum, by the integrator in steps that keep the mesh, and in
    // the others.
    let mut turned = [0.0_f64; 2];
    // Largest rise of the energy at a change: vibration pays for the gain of elastic energy, and
    // rigid motion, which stays, cannot.
    let mut rise = 0.0_f64;
    let start = of(&world.sheets()[0]).3;
    for _ in 0..200 {
        let (before, nodes) = (of(&world.sheets()[0]), world.sheets()[0].node_count());
        world.step();
        let (after, now) = (of(&world.sheets()[0]), world.sheets()[0].node_count());
        assert!((after.0 / before.0 - 1.0).abs() < 1e-12, "mass");
        assert!(after.1.distance(before.1) < 1e-9 * before.1.length(), "momentum at {}", world.time());
        let turn = &mut turned[usize::from(now != nodes)];
        *turn = turn.max(after.2.distance(before.2) / before.2.length());
        if now == nodes {
            assert!(after.3 < before.3 * (1.0 + 1e-6), "{} of {} J at {}", after.3, before.3, world.time());
        }
        rise = rise.max(after.3 / before.3 - 1.0);
        changed += usize::from(now != nodes);
        coarsened += usize::from(now < nodes);
    }
    assert!(world.unstable().is_none());
    println!("angular momentum {turned:?}, energy rises by {rise:.4}, {changed} changes");
    assert!(rise < 0.02 && of(&world.sheets()[0]).3 < start, "energy rises by {rise}");
    assert!(turned[1] <= 1.5 * turned[0], "angular momentum at a change {} and without {}", turned[1], turned[0]);
    assert!(changed > 8 && coarsened > 3, "{changed} changes, {coarsened} of them coarser");
}

#[test]
fn temperatures_keep_their_mean_and_range() {
    let mut world = struck(0.002, "temperature: 40, temperature_gradient: true");
    let uv = world.sheets()[0].model.uv.clone();
    let warm = |i: usize| 40.0 + 60.0 * (-20.0 * ((uv[i].0 - 0.5).powi(2) + (uv[i].1 - 0.3).powi(2))).exp();
    world.sheets_mut()[0].set_temperatures(warm).unwrap_or_else(|e| panic!("{e}"));
    let of = mean_and_range_of_temperatures;
    let mut changed = 0;
    for _ in 0..60 {
        let (before, nodes) = (of(&world.sheets()[0]), world.sheets()[0].node_count());
        world.step();
        let (after, now) = (of(&world.sheets()[0]), world.sheets()[0].node_count());
        // A change may move heat by a hundredth of the range, a step by less.
        assert!((after.0 - before.0).abs() < 0.05, "{} of {}", after.0, before.0);
        assert!(after.1 > before.1 - 0.6 && after.2 < before.2 + 0.6, "{after:?} of {before:?}");
        changed += usize::from(now != nodes);
    }
    assert!(changed > 3, "{changed} changes");
}

#[test]
fn snapshots_resets_and_threads_continue_to_the_bit() {
    let mut world = struck(0.002, "");
    let first = world.serialise();
    steps(&mut world, 36);
    let (there, kept) = (world.serialise(), world.snapshot());
    let levels = world.sheets()[0].model.refinement.clone();
    assert!(changes(&world) > 2 && levels.as_ref().is_some_and(|l| l.contains(&2)));
    steps(&mut world, 40);
    let end = state_hash(&world);
    assert_ne!(world.sheets()[0].model.refinement.clone(), levels);
    // This world, another one, and one with two threads.
    world.restore(&kept).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(world.sheets()[0].model.refinement.clone(), levels);
    steps(&mut world, 40);
    assert_eq!(state_hash(&world), end, "restored");
    let mut other = struck(0.002, "");
    other.deserialise(&there).unwrap_or_else(|e| panic!("{e}"));
    steps(&mut other, 40);
    assert_eq!(state_hash(&other), end, "another world");
    let mut threads = struck(0.002, "");
    threads.set_threads(2).unwrap_or_else(|e| panic!("{e}"));
    steps(&mut threads, 76);
    assert_eq!(state_hash(&threads), end, "two threads");
    // Back to the start, with the mesh of the scene.
    world.deserialise(&first).unwrap_or_else(|e| panic!("{e}"));
    assert!(world.sheets()[0].model.refinement.as_ref().expect("refined").iter().all(|level| *level == 0));
    steps(&mut world, 76);
    assert_eq!(state_hash(&world), end, "from the start");
}

#[test]
fn a_recording_has_the_nodes_of_the_scene_and_a_damaged_snapshot_is_refused() {
    let mut world = struck(0.002, "");
    let first = world.sheets()[0].node_count();
    steps(&mut world, 5);
    assert!(world.sheets()[0].node_count() > first);
    let frame = RecordedFrame::of(&world);
    assert_eq!(frame.sheets[0].len(), first);
    let places = world.sheets()[0].state.x.iter().take(first).map(|p| p.as_vec3());
    assert!(frame.sheets[0].iter().copied().eq(places), "base nodes come first");
    let text = world.serialise();
    let mut fewer = world_of(
        r#"(sheets: [(structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), outline: Disc(radius: 0.05), refine: ())])"#,
    );
    assert!(fewer.deserialise(&text).is_err() && fewer.sheets()[0].node_count() < first);
}

#[test]
fn sheets_without_a_triangle_mesh_are_rejected_with_the_remedy() {
    let problem = |fields: &str| {
        let text = format!("(sheets: [({fields}, refine: ())])");
        let scene = Scene::parse(&text).map_err(|e| e.to_string());
        scene.and_then(|s| World::new(&s).map_err(|e| e.to_string())).err().expect("refused")
    };
    let grid = problem(r#"structure: "shell", grid: (5, 1, 5), size: (0.2, 0.1)"#);
    assert!(grid.contains("refine") && grid.contains("Polygon([(-0.1, -0.05), (0.1, -0.05)"), "{grid}");
    let lattice = problem(r#"structure: "slamm", grid: (5, 2, 5), size: (0.2, 0.1)"#);
    assert!(lattice.contains("use structure \"shell\" with an outline"), "{lattice}");
}

#[test]
fn a_notched_sheet_refines_at_its_notch_before_it_tears() {
    let mut world = world_of(
        r#"(engine: "tr-bdf2", dt: 0.01, gravity: (0, 0, 0), sheets: [(name: "strip", structure: "shell", grid: (21, 1, 13), size: (0.1, 0.06),
            outline: Polygon([(-0.05, -0.03), (0.05, -0.03), (0.05, 0.03), (-0.05, 0.03)]), cuts: [[(0, -0.04), (0, -0.01)]],
            material: "paper", damping_ratio: 0.5, tearing: true, refine: (levels: 2, fold: 60, strain: 0.4, every: 5),
            pins: [(region: Left), (region: Right, path: [(time: 0), (time: 2, offset: (0.002, 0, 0))])])])"#,
    );
    let tip = [0.0, -0.01];
    let torn = |world: &World| world.events().iter().any(|e| e.kind == EventKind::Torn);
    let mut before = None;
    for _ in 0..200 {
        let levels = world.sheets()[0].model.refinement.clone();
        world.step();
        if torn(&world) {
            before = levels;
            break;
        }
    }
    let levels = before.expect("it tears");
    let sheet = &world.sheets()[0];
    assert_eq!(sheet.model.refinement.as_ref(), Some(&levels), "the mesh that tears is that of the step before");
    // Cells of 5 mm are divided twice at the end of the notch, and stay away from it.
    let mesh = sheet.mesh().expect("a mesh");
    let smallest = |near: &dyn Fn(f64) -> bool| {
        let away = |k: &usize| {
            let [u, v] = mesh.middle_of(*k);
            near((u - tip[0]).hypot(v - tip[1]))
        };
        (0..mesh.triangles.len()).filter(away).map(|k| mesh.areas[k]).fold(f64::INFINITY, f64::min)
    };
    let whole = 0.5 * 0.005 * 0.005;
    assert!(smallest(&|d| d < 0.004) < 0.07 * whole, "{}", smallest(&|d| d < 0.004) / whole);
    assert!(smallest(&|d| d > 0.03) > 0.4 * whole, "{}", smallest(&|d| d > 0.03) / whole);
    let event = world.events().iter().find(|e| e.kind == EventKind::Torn).and_then(|e| e.opening).expect("an opening");
    let place = event.place_m;
    assert!((place[0] - tip[0]).hypot(place[2] - tip[1]) < 0.004, "{place:?}");
    // The mesh stays while the crack grows.
    let open = sheet.open_count();
    steps(&mut world, 40);
    let sheet = &world.sheets()[0];
    assert!(
        sheet.open_count() > open && sheet.model.refinement.as_ref() == Some(&levels),
        "{} cells",
        sheet.open_count()
    );
}
