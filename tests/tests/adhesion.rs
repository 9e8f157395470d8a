//! Adhesion: hanging, friction, peeling and release, against weights and Coulomb's law by hand.

use glam::DVec3;
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{
    Adhesion, BodySpec, CreaseSpec, Material, MaterialChoice, PinSpec, Placement, Region, Scene, Shape, SheetSpec,
};
use sheetwork_tests::fracture::slip_angle;
use sheetwork_tests::{body, state_hash, world};

/// Weight of the sheet per area, Pa: ρ t g.
const WEIGHT: f64 = 1000.0 * 5e-4 * 9.81;

/// A sheet of 0.1 m by 0.1 m, adhesive from 80 °C with `strength` Pa, with release below 60 °C or
/// without release.
fn sheet(strength: f64, sets: bool) -> SheetSpec {
    let material = Material {
        young: 5e7,
        density: 1000.0,
        thickness: 5e-4,
        damping_ratio: 0.5,
        expansion: 0.0,
        tack: Some(Adhesion { strength, above: 80.0, lets_go_below: (!sets).then_some(60.0) }),
        ..Material::default()
    };
    SheetSpec {
        name: "sheet".into(),
        structure: StructureKind::Shell,
        grid: (11, 1, 11),
        size: (0.1, 0.1),
        material: MaterialChoice::Inline(material),
        sticky: true,
        ..SheetSpec::default()
    }
}

fn at(y: f64) -> Placement {
    Placement { position: DVec3::new(0.0, y, 0.0), ..Placement::default() }
}

/// A plate with its underside at 0, and the sheet in contact with it from below, in a room at 120
/// °C.
fn hanging_scene(sheet: SheetSpec) -> Scene {
    let half = 0.5 * 5e-4;
    Scene {
        engine: IntegratorKind::TrBdf2,
        dt: 1.0 / 60.0,
        gravity: DVec3::new(0.0, -9.81, 0.0),
        ambient_temperature: 120.0,
        sheets: vec![SheetSpec { placement: at(-half), ..sheet }],
        bodies: vec![body("plate", Shape::Box(DVec3::new(0.3, 0.02, 0.3)), at(0.01), vec![])],
        ..Scene::default()
    }
}

fn lowest(world: &World) -> f64 {
    world.sheets()[0].state.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

/// The world of `scene` after a third of a second with reversed gravity, which presses the sheet
/// on, and `steps` further steps.
fn advanced(scene: &Scene, steps: u32) -> World {
    let mut world = world(&Scene { gravity: DVec3::new(0.0, 9.81, 0.0), ..scene.clone() });
    (0..20).for_each(|_| _ = world.step());
    world.set_gravity(scene.gravity).expect("in range");
    (0..steps).for_each(|_| _ = world.step());
    assert!(world.unstable().is_none());
    world
}

#[test]
fn a_sheet_hangs_from_a_hot_plate_if_adhesion_exceeds_its_weight() {
    for engine in [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::Bdf2] {
        // BDF2 continues the motion from before the reversal of gravity.
        let near = if engine == IntegratorKind::Bdf2 { [0.9, 1.1] } else { [0.98, 1.02] };
        for factor in [0.5, near[0], near[1], 2.0, 1e4] {
            let world = advanced(&Scene { engine, ..hanging_scene(sheet(factor * WEIGHT, false)) }, 90);
            let (y, bonds) = (lowest(&world), world.sheets()[0].bonds());
            println!("{engine}: σ = {factor} ρ t g: lowest mass at {:.3} mm, {bonds} bonds", 1e3 * y);
            if factor > 1.0 {
                assert!(y > -4e-4 && bonds == 121, "{engine}, {factor}: {y}");
            } else {
                assert!(y < -0.1 && bonds == 0, "{engine}, {factor}: {y}");
            }
        }
    }
}

#[test]
fn bonds_release_below_the_release_temperature() {
    for (sets, celsius, hangs) in [(false, 70.0, true), (false, 50.0, false), (true, 20.0, true)] {
        let mut world = advanced(&hanging_scene(sheet(20.0, sets)), 30);
        assert_eq!(world.sheets()[0].bonds(), 121);
        world.set("ambient_temperature", &celsius.to_string()).expect("a room");
        world.sheets_mut()[0].set_temperatures(|_| celsius).expect("in range");
        (0..90).for_each(|_| _ = world.step());
        println!("at {celsius} °C, sets {sets}: {:.3} mm, {} bonds", 1e3 * lowest(&world), world.sheets()[0].bonds());
        assert_eq!(lowest(&world) > -4e-4, hangs, "at {celsius} °C, sets: {sets}");
    }
    // A sheet that was never hot does not bond.
    let world = advanced(&Scene { ambient_temperature: 70.0, ..hanging_scene(sheet(20.0, false)) }, 60);
    assert!(lowest(&world) < -0.1);
}

#[test]
fn friction_on_an_incline_includes_adhesion() {
    // m g sin θ = μ (m g cos θ + σ A) with σ = s ρ t g: tan θ by bisection.
    let friction = 0.4;
    for share in [0.0_f64, 0.5, 1.5] {
        let slips_at = slip_angle(friction, share);
        for factor in [0.97, 1.03] {
            let angle = slips_at * factor;
            let mut spec = sheet((share * WEIGHT).max(1e-3), false);
            spec.friction = Some(friction);
            let mut scene = hanging_scene(spec);
            // Moves the sheet from below the plate to above it.
            scene.bodies[0].placement.position.y = -0.01;
            scene.bodies[0].friction = Some(friction);
            scene.sheets[0].placement.position.y = 2.5e-4;
            scene.gravity = DVec3::new(angle.sin(), -angle.cos(), 0.0) * 9.81;
            let mut world = world(&Scene { gravity: DVec3::new(0.0, -9.81, 0.0), ..scene.clone() });
            (0..20).for_each(|_| _ = world.step());
            world.set_gravity(scene.gravity).expect("in range");
            (0..30).for_each(|_| _ = world.step());
            let from = world.sheets()[0].centre_of_mass().x;
            (0..60).for_each(|_| _ = world.step());
            let gone = world.sheets()[0].centre_of_mass().x - from;
            println!(
                "σ = {share} ρ t g at {:.2}° of {:.2}°: {:.3e} m in 1 s",
                angle.to_degrees(),
                slips_at.to_degrees(),
                gone
            );
            assert_eq!(gone > 1e-3, factor > 1.0, "σ = {share} ρ t g at {factor} of the angle: {gone} m");
            if factor < 1.0 {
                assert!(gone.abs() < 1e-5, "it creeps: {gone} m");
            }
        }
    }
}

/// Force per width (N/m) normal to the plate at which a strip peels.
fn peel(strength: f64) -> f64 {
    let mut spec = sheet(strength, false);
    spec.grid = (41, 1, 5);
    spec.size = (0.1, 0.01);
    let mut scene = hanging_scene(spec);
    scene.gravity = DVec3::ZERO;
    let mut world = world(&scene);
    (0..10).for_each(|_| _ = world.step());
    let whole = world.sheets()[0].bonds();
    let end: Vec<usize> = (0..5).map(|j| 41 * j + 40).collect();
    for step in 0..3000 {
        let force = 1e-3 * strength * 0.01 * 0.1 * f64::from(step);
        for i in &end {
            world.sheets_mut()[0].parameters.applied.set(*i, DVec3::new(0.0, -force / 5.0, 0.0));
        }
        world.step();
        if world.sheets()[0].bonds() < whole / 2 {
            return force / 0.01;
        }
    }
    panic!("it does not peel");
}

#[test]
fn the_peel_force_grows_with_the_adhesion_strength() {
    let forces = [200.0, 400.0, 800.0].map(|strength| (strength, peel(strength)));
    for (strength, force) in forces {
        println!("σ = {strength} Pa: peels at {force:.3} N/m, as much as {:.2} mm of it bears", 1e3 * force / strength);
        // More than the strength of a row of cells and less than that of the whole strip.
        assert!(force > strength * 0.0025 && force < strength * 0.1, "{strength} Pa: {force} N/m");
    }
    assert!(forces[0].1 < forces[1].1 && forces[1].1 < forces[2].1);
}

#[test]
fn a_box_hangs_from_a_hot_sheet_and_pulls_it_down() {
    // The box covers 9 nodes of 0.01 m by 0.01 m each: σ A = 9e-4 σ against 0.01 kg · 9.81 m/s² =
    // 0.0981 N, 109 Pa.
    let hangs = |strength: f64| {
        let mut spec = sheet(strength, false);
        spec.pins = vec![PinSpec::fixed(Region::Border)];
        let mut scene = hanging_scene(spec);
        let size = DVec3::new(0.025, 0.02, 0.025);
        scene.bodies = vec![BodySpec { mass: Some(0.01), ..body("box", Shape::Box(size), at(-5e-4 - 0.01), vec![]) }];
        let mut world = world(&Scene { gravity: DVec3::ZERO, ..scene });
        for step in 0..180 {
            world.set_gravity(DVec3::new(0.0, -9.81 * (f64::from(step) / 60.0).min(1.0), 0.0)).expect("in range");
            world.step();
        }
        assert!(world.unstable().is_none());
        let y = world.body_state("box").expect("there").origin().y + 0.01;
        println!("σ = {strength} Pa: the box's upper side at {:.3} mm, {} bonds", 1e3 * y, world.sheets()[0].bonds());
        (y, world.sheets()[0].centre_of_mass().y)
    };
    let (held, fell) = (hangs(400.0), hangs(50.0));
    assert!(held.0 > -0.03 && held.0 < -6e-4, "it hangs and bends the sheet: {}", held.0);
    assert!(held.1 < fell.1, "the sheet hangs lower with it");
    assert!(fell.0 < -1.0);
}

#[test]
fn a_sheet_hangs_from_another() {
    for (factor, hangs) in [(0.8, false), (1.2, true)] {
        let mut upper = sheet(factor * WEIGHT, false);
        upper.pins = vec![PinSpec::fixed(Region::All)];
        let mut lower = sheet(factor * WEIGHT, false);
        lower.name = "lower".into();
        let mut scene = hanging_scene(upper);
        scene.bodies.clear();
        scene.sheets.push(SheetSpec { placement: at(-7.5e-4), ..lower });
        let world = advanced(&scene, 90);
        let y = world.sheets()[1].centre_of_mass().y;
        println!("two sheets, σ = {factor} ρ t g: the lower at {:.3} mm", 1e3 * y);
        assert_eq!(y > -2e-3, hangs, "{factor}: {y}");
    }
}

#[test]
fn a_sheet_between_two_surfaces_bonds_to_both_at_full_strength() {
    // The plate carries two sheets, and the upper sheet carries one; the two bonds do not reduce
    // one another.
    for (factor, hangs) in [(1.9, false), (2.1, true)] {
        let mut scene = hanging_scene(sheet(factor * WEIGHT, false));
        scene.sheets.push(SheetSpec { name: "lower".into(), placement: at(-7.5e-4), ..sheet(factor * WEIGHT, false) });
        let world = advanced(&scene, 60);
        let y = [0, 1].map(|i| world.sheets()[i].centre_of_mass().y);
        println!("two under a plate, σ = {factor} ρ t g: at {:.3} and {:.3} mm", 1e3 * y[0], 1e3 * y[1]);
        assert_eq!(y.map(|y| y > -2e-3), [hangs; 2], "{factor}: {y:?}");
    }
}

/// A strip with a crease of 140° in its middle and one half fixed. The other half is pressed onto
/// it for a moment and released. Returns the final distance (m) of its end from the fixed half, and
/// the number of bonds.
fn folded(sticky: bool) -> (f64, usize) {
    let mut spec = sheet(100.0, false);
    spec.sticky = sticky;
    spec.grid = (31, 1, 5);
    spec.size = (0.12, 0.016);
    spec.creases = vec![CreaseSpec { from: (0.5, 0.0), to: (0.5, 1.0), angle: 140.0 }];
    spec.pins = vec![PinSpec::fixed(Region::Rect((0.0, 0.45), (0.0, 1.0)))];
    if let MaterialChoice::Inline(material) = &mut spec.material {
        material.young = 1e6;
    }
    let mut scene = hanging_scene(spec);
    scene.bodies.clear();
    scene.gravity = DVec3::ZERO;
    let mut world = world(&scene);
    let sheet = &mut world.sheets_mut()[0];
    let (up, along) = 140.0_f64.to_radians().sin_cos();
    for i in 0..sheet.node_count() {
        let p = sheet.state.x.get(i);
        if p.x > 0.0 {
            sheet.state.x.set(i, DVec3::new(p.x * along, p.y + p.x * up, p.z));
        }
    }
    let press = |world: &mut World, force: f64| {
        let sheet = &mut world.sheets_mut()[0];
        for i in 0..sheet.node_count() {
            let loose = sheet.model.uv[i].0 > 0.55;
            sheet.parameters.applied.set(i, DVec3::new(0.0, if loose { -force } else { 0.0 }, 0.0));
        }
    };
    press(&mut world, 2e-4);
    (0..60).for_each(|_| _ = world.step());
    press(&mut world, 0.0);
    (0..120).for_each(|_| _ = world.step());
    assert!(world.unstable().is_none());
    let sheet = &world.sheets()[0];
    (sheet.state.x.get(31 * 2 + 30).y + 2.5e-4, sheet.bonds())
}

#[test]
fn a_hot_sheet_folded_onto_itself_stays_folded() {
    let (stuck, loose) = (folded(true), folded(false));
    println!("folded: sticky {:.3} mm apart, {} bonds; not sticky {:.3} mm", 1e3 * stuck.0, stuck.1, 1e3 * loose.0);
    assert!(stuck.0 < 8e-4 && stuck.1 > 10, "{stuck:?}");
    assert!(loose.0 > 5e-3 && loose.1 == 0, "{loose:?}");
}

#[test]
fn adhesion_is_bit_identical_on_any_number_of_threads_and_from_a_snapshot() {
    let run = |threads: usize| {
        let mut upper = sheet(3.0 * WEIGHT, false);
        upper.pins = vec![PinSpec::fixed(Region::Left)];
        let mut scene = hanging_scene(upper);
        scene.sheets.push(SheetSpec { name: "lower".into(), placement: at(-7.5e-4), ..sheet(3.0 * WEIGHT, false) });
        let mut world = advanced(&scene, 0);
        world.set_threads(threads).expect("threads");
        (0..20).for_each(|_| _ = world.step());
        world
    };
    let mut one = run(1);
    assert_eq!(state_hash(&one), state_hash(&run(2)));
    let snapshot = one.snapshot();
    (0..30).for_each(|_| _ = one.step());
    let (bonds, end) = (one.sheets()[0].bonds(), state_hash(&one));
    one.restore(&snapshot).expect("its own");
    (0..30).for_each(|_| _ = one.step());
    println!("{bonds} bonds");
    assert!(bonds == 121, "{bonds}");
    assert_eq!((one.sheets()[0].bonds(), state_hash(&one)), (bonds, end));
}

#[test]
fn adhesion_of_unsuitable_sheets_is_rejected_with_the_reason() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = hanging_scene(sheet(20.0, false));
        change(&mut scene);
        World::new(&scene).map(drop).expect_err("refused").to_string()
    };
    let clean = refused(&|s| s.sheets[0].material = MaterialChoice::Named("card".into()));
    assert!(clean.contains("sticky") && clean.contains("tack"), "{clean}");
    let weak = refused(&|s| {
        if let MaterialChoice::Inline(material) = &mut s.sheets[0].material {
            material.tack = Some(Adhesion { strength: -1.0, above: 80.0, lets_go_below: None });
        }
    });
    assert!(weak.contains("tack.strength") && weak.contains("Pa"), "{weak}");
}
