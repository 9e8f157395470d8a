//! Determinism: a scene gives identical bits when repeated, after a reset, on any number of
//! threads, and in later versions of the code until an intended change.
//!
//! The pinned hashes are in `tests/scenes.txt`, one per shipped scene, and `tests/hashes.txt`, one
//! per integrator. Hashes of implicit integrators name their instruction set (`@avx2`), because
//! others round differently, and are skipped on other instruction sets. After an intended change of
//! results, renew them with
//!
//! ```text
//! SHEETWORK_RENEW=1 cargo test -p sheetwork-tests --test determinism
//! ```
//!
//! and give the reason in the description of the change.

use std::path::PathBuf;

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::Scene;
use sheetwork_tests::{shipped_scene, shipped_scene_names, state_hash};

fn hash_after(scene: &Scene, threads: usize, steps: u32) -> u64 {
    let mut world = World::new(scene).unwrap_or_else(|e| panic!("{e}"));
    world.set_threads(threads).unwrap_or_else(|e| panic!("{e}"));
    (0..steps).for_each(|_| _ = world.step());
    state_hash(&world)
}

fn one_of_every_structure(engine: IntegratorKind) -> Scene {
    Scene { tolerance: 1e-6, ..sheetwork_tests::one_of_every_structure(engine, 0.25) }
}

#[test]
fn every_shipped_scene_equals_its_pinned_hash() {
    let mut found = String::new();
    for name in shipped_scene_names() {
        let scene = shipped_scene(&name);
        // Contact between many cards takes long.
        let steps = if scene.sheets.len() > 10 { 18 } else { 150 };
        let of = if scene.engine.info().implicit { path() } else { String::new() };
        found += &format!("{name}{of} {:016x}\n", hash_after(&scene, 1, steps));
    }
    compare_with_pinned("scenes.txt", &found);
}

/// Prints a line that is visible in a passing test.
fn print_line(line: &str) {
    use std::io::Write;
    // Bypasses the capture of test output; a failure to print is ignored.
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Suffix of the name for an implicit integrator: its bits depend on the instruction set of the
/// linear solver.
fn path() -> String {
    format!("@{:?}", sheetwork::linear::InstructionSet::best()).to_lowercase()
}

/// Name of a line: the scene or integrator, and its instruction set if it has one.
fn name_of(line: &str) -> &str {
    line.split(' ').next().unwrap_or_default()
}

/// Lines of a file of pinned hashes, renewed with `found` on request. A renewal keeps the hashes of
/// other instruction sets where the one of this set has not changed.
fn pinned(name: &str, found: &str) -> String {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join(name);
    let old = std::fs::read_to_string(&file).unwrap_or_default();
    if std::env::var_os("SHEETWORK_RENEW").is_none() {
        return old;
    }
    let same: Vec<&str> = found.lines().filter(|line| old.lines().any(|o| o == *line)).collect();
    let bare = |line: &str| name_of(line).split('@').next().unwrap_or_default().to_owned();
    let keeps = |line: &&str| !found.lines().any(|f| name_of(f) == name_of(line));
    let others = old.lines().filter(keeps).filter(|line| same.iter().any(|s| bare(s) == bare(line)));
    let mut all: Vec<&str> = found.lines().chain(others).collect();
    // In the order of `found`, by instruction set within a name.
    all.sort_by_key(|line| (found.lines().position(|f| bare(f) == bare(line)), *line));
    let text = all.iter().map(|line| format!("{line}\n")).collect::<String>();
    std::fs::write(&file, &text).unwrap_or_else(|e| panic!("{e}"));
    text
}

/// Compares `found` with the hashes pinned in `file`. A hash that is pinned for another instruction
/// set only is reported and skipped.
fn compare_with_pinned(file: &str, found: &str) {
    let pinned = pinned(file, found);
    for line in found.lines() {
        let name = name_of(line);
        let bare = name.split('@').next().unwrap_or_default();
        match pinned.lines().find(|wanted| name_of(wanted) == name) {
            Some(wanted) => {
                assert_eq!(line, wanted, "results changed; if that is meant, renew them as the head of this file says");
            }
            None if pinned.lines().any(|other| other.starts_with(&format!("{bare}@"))) => {
                print_line(&format!("skipped: {bare} in {file}, which has no hash for {}", path()));
            }
            None => panic!("{name} has no hash in {file}: renew them"),
        }
    }
    for line in pinned.lines() {
        let bare = name_of(line).split('@').next().unwrap_or_default();
        let is_there = found.lines().any(|f| name_of(f).split('@').next() == Some(bare));
        assert!(is_there, "the hash {} in {file} has no scene: renew them", name_of(line));
    }
}

#[test]
fn results_and_events_are_identical_on_any_number_of_threads() {
    for engine in [IntegratorKind::EulerRichardson, IntegratorKind::Rk45] {
        let scene = one_of_every_structure(engine);
        let run = |threads: usize| {
            let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
            world.set_threads(threads).unwrap_or_else(|e| panic!("{e}"));
            (0..300).for_each(|_| _ = world.step());
            (state_hash(&world), world.events().to_vec())
        };
        let one = run(1);
        assert!(one.1.len() >= 6, "little happened: {:?}", one.1);
        for threads in [2, 3, 8] {
            assert_eq!(run(threads), one, "{engine} on {threads} threads");
        }
    }
}

#[test]
fn sheets_in_contact_are_bit_identical_on_any_number_of_threads() {
    // The pack lands in the fifth step.
    let scene = shipped_scene("cards_pack");
    let one = hash_after(&scene, 1, 8);
    for threads in [2, 3, 8] {
        assert_eq!(hash_after(&scene, threads, 8), one, "{threads} threads");
    }
}

#[test]
fn heat_creep_fracture_and_adhesion_are_bit_identical_on_any_number_of_threads() {
    // A single sheet is not parallel, so each scene has two copies of it side by side.
    for (name, steps) in
        [("hot_sag", 60), ("torn_strip", 60), ("sticky_film", 40), ("creased_sheet", 30), ("heat_gun", 40)]
    {
        let mut scene = shipped_scene(name);
        let mut other = scene.sheets[0].clone();
        other.name = "the other".into();
        other.placement.position.z += 3.0;
        scene.sheets.push(other);
        let one = hash_after(&scene, 1, steps);
        for threads in [2, 3, 8] {
            assert_eq!(hash_after(&scene, threads, steps), one, "{name} on {threads} threads");
        }
    }
}

#[test]
fn a_reset_world_equals_a_new_one() {
    for engine in TABLE {
        let scene = one_of_every_structure(engine.kind);
        let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        (0..100).for_each(|_| _ = world.step());
        // A reset must also discard changes made during the run.
        world.set_gravity(DVec3::new(1.0, -2.0, 0.5)).unwrap_or_else(|e| panic!("{e}"));
        world.set("sheets.trimm.material.young", "5e3").unwrap_or_else(|e| panic!("{e}"));
        world.set_engine(IntegratorKind::Verlet);
        (0..50).for_each(|_| _ = world.step());
        world.reset().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(world.time(), 0.0);
        assert!(world.events().is_empty());
        (0..100).for_each(|_| _ = world.step());
        assert_eq!(state_hash(&world), hash_after(&scene, 1, 100), "{}", engine.name);
    }
}

#[test]
fn every_integrator_equals_its_pinned_hash() {
    let mut found = String::new();
    for engine in TABLE {
        let of = if engine.implicit { path() } else { String::new() };
        found +=
            &format!("crowd-{}{of} {:016x}\n", engine.name, hash_after(&one_of_every_structure(engine.kind), 2, 200));
    }
    compare_with_pinned("hashes.txt", &found);
}
