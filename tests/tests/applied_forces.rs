//! Forces and impulses of a program on sheets: change of momentum and angular momentum, duration,
//! ranges, snapshots and journals.

use glam::DVec3;
use sheetwork::journal::JournalInput;
use sheetwork::scene::{Region, Scene};
use sheetwork::{ForceTarget, World};
use sheetwork_tests::{journal_repeats, state_hash, world, world_of};

const SHEET: &str = r#"structure: "shell", grid: (9, 1, 7), size: (0.2, 0.15), material: "pet""#;
const LATTICE: &str = r#"structure: "slamm", grid: (7, 2, 6), size: (0.2, 0.15), material: "pet""#;

fn free(engine: &str, dt: f64, sheet: &str) -> World {
    world_of(&format!("(engine: \"{engine}\", dt: {dt}, gravity: (0, 0, 0), sheets: [({sheet})])"))
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s) of the first sheet.
fn momenta(world: &World) -> (DVec3, DVec3) {
    let sheet = &world.sheets()[0];
    let each = (0..sheet.node_count()).map(|i| (sheet.state.x.get(i), sheet.state.v.get(i) * sheet.node_mass(i)));
    each.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (x, m)| (p + m, l + x.cross(m)))
}

fn targets() -> [ForceTarget; 4] {
    [
        ForceTarget::Point(0.3, 0.8),
        ForceTarget::Nearest(DVec3::new(0.03, 0.5, -0.02)),
        ForceTarget::Region(Region::All),
        ForceTarget::Region(Region::Right),
    ]
}

#[test]
fn an_impulse_changes_momentum_and_angular_momentum_by_itself_and_its_moment() {
    for sheet in [SHEET, LATTICE] {
        for (index, target) in targets().iter().enumerate() {
            let mut world = free("tr-bdf2", 0.01, sheet);
            let id = world.sheet_id("sheet 0").expect("there");
            let impulse = DVec3::new(1e-4, -2e-4, 3e-4);
            world.apply_impulse(id, target, impulse).expect("valid");
            let (p, l) = momenta(&world);
            assert!(p.distance(impulse) < 1e-15, "{target:?}: {p}");
            // Places of the point in the flat sheet, whose middle is the origin.
            let arm = match index {
                0 => DVec3::new(-0.04, 0.0, 0.045),
                1 => DVec3::new(0.03, 0.0, -0.02),
                2 if sheet == SHEET => DVec3::ZERO,
                _ => continue,
            };
            assert!(l.distance(arm.cross(impulse)) < 1e-15, "{target:?}: {l} {}", arm.cross(impulse));
        }
    }
}

#[test]
fn a_force_acts_for_one_step_or_one_advance() {
    for (engine, dt, sheet) in
        [("tr-bdf2", 0.01, SHEET), ("euler-richardson", 1e-6, LATTICE), ("backward-euler", 0.01, SHEET)]
    {
        for target in targets() {
            let force = DVec3::new(0.01, 0.02, -0.005);
            let momentum_after = |run: &dyn Fn(&mut World)| {
                let mut world = free(engine, dt, sheet);
                let id = world.sheet_id("sheet 0").expect("there");
                world.apply_force(id, &target, force * 0.5).expect("valid");
                world.apply_force(id, &target, force * 0.5).expect("valid");
                run(&mut world);
                // The scheme of tr-bdf2 weights the force at both ends of a step.
                (0..3).for_each(|_| _ = world.step());
                assert!(world.sheets()[0].parameters.applied.max_squared() == 0.0);
                momenta(&world).0
            };
            let one = momentum_after(&|world| _ = world.step());
            assert!(one.distance(force * dt) < 1e-9 * force.length() * dt, "{engine} {target:?}: {one}");
            let four = momentum_after(&|world| _ = world.advance(4.0 * dt));
            assert!(four.distance(force * (4.0 * dt)) < 1e-9 * force.length() * dt, "{engine} {target:?}: {four}");
        }
    }
}

#[test]
fn a_uniform_force_on_all_nodes_is_an_acceleration_without_deformation() {
    let mut world = free("tr-bdf2", 0.01, SHEET);
    let id = world.sheet_id("sheet 0").expect("there");
    let mass = world.sheets()[0].total_mass();
    for _ in 0..20 {
        world.apply_force(id, &ForceTarget::Region(Region::All), DVec3::Y * mass).expect("valid");
        world.step();
    }
    let v = &world.sheets()[0].state.v;
    assert!(v.iter().all(|u| u.distance(v.get(0)) < 1e-9));
}

#[test]
fn forces_out_of_range_and_targets_that_are_not_there_are_refused() {
    let mut world = free("tr-bdf2", 0.01, SHEET);
    let id = world.sheet_id("sheet 0").expect("there");
    let all = ForceTarget::Region(Region::All);
    let refuse = |world: &mut World, target: &ForceTarget, value: DVec3| {
        let force = world.apply_force(id, target, value).expect_err("refused");
        world.apply_impulse(id, target, value).expect_err("refused");
        force
    };
    let error = refuse(&mut world, &all, DVec3::new(0.0, 2e6, 0.0));
    assert!(error.field == "force.1" && error.to_string().contains(" N"), "{error}");
    refuse(&mut world, &all, DVec3::new(f64::NAN, 0.0, 0.0));
    refuse(&mut world, &ForceTarget::Point(1.5, 0.0), DVec3::X);
    refuse(&mut world, &ForceTarget::Point(f64::NAN, 0.0), DVec3::X);
    refuse(&mut world, &ForceTarget::Nearest(DVec3::splat(f64::INFINITY)), DVec3::X);
    refuse(&mut world, &ForceTarget::Region(Region::Masses(vec![1000])), DVec3::X);
    refuse(&mut world, &ForceTarget::Region(Region::Rect((0.5, 0.4), (0.0, 1.0))), DVec3::X);
    assert!(world.remove_sheet(id));
    refuse(&mut world, &all, DVec3::X);
}

fn hanging() -> Scene {
    let text = format!("(dt: 0.01, air: (density: 1.2), sheets: [({SHEET}, pins: [(region: Left, clamp: true)])])");
    Scene::parse(&text).expect("valid")
}

#[test]
fn a_snapshot_contains_the_forces_of_the_next_step() {
    let scene = hanging();
    let mut first = world(&scene);
    first.advance(0.1);
    let id = first.sheet_id("sheet 0").expect("there");
    first.apply_force(id, &ForceTarget::Point(1.0, 0.5), DVec3::Y).expect("valid");
    let (saved, snapshot) = (first.serialise(), first.snapshot());
    let run = |world: &mut World| {
        let one = |_| {
            world.step();
            state_hash(world)
        };
        (0..10).map(one).collect::<Vec<_>>()
    };
    let wanted = run(&mut first);
    let mut fresh = world(&scene);
    fresh.deserialise(&saved).expect("of this scene");
    assert!(fresh.serialise() == saved);
    assert_eq!(run(&mut fresh), wanted);
    first.restore(&snapshot).expect("its own");
    assert_eq!(run(&mut first), wanted);
    first.deserialise(&saved).expect("its own");
    assert_eq!(run(&mut first), wanted);
}

#[test]
fn a_journal_repeats_forces_and_impulses() {
    let mut world = world(&hanging());
    let input = |step: u32| {
        let (sheet, target) = ("sheet 0".to_owned(), ForceTarget::Point(1.0, 0.1 * f64::from(step % 5)));
        if step.is_multiple_of(3) {
            JournalInput::ApplyImpulse { sheet, target, impulse: DVec3::Y * 1e-3 }
        } else {
            JournalInput::ApplyForce { sheet, target, force: DVec3::Z * 0.1 }
        }
    };
    journal_repeats(&mut world, (0..12).map(input), 1);
}
