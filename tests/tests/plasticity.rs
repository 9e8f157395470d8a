//! Rest shapes and plasticity of shells: creases, curl and yielding folds, and their energy.
//!
//! Expected numbers are return mapping by hand, and geometry.

use glam::DVec3;
use sheetwork::World;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{CreaseSpec, IntegratorKind, Material, MaterialChoice, Scene, SheetSpec};
use sheetwork::sheet::Sheet;
use sheetwork_rigs::measure::Setup;
use sheetwork_tests::card::{card, rejection};
use sheetwork_tests::rig::{measured, number};
use sheetwork_tests::{excite_randomly, world};

fn fold(angle: f64, grid: u32, hardening: f64) -> f64 {
    let mut setup = Setup { angle, grid: (grid, 11), length: 0.02, ..Setup::default() };
    setup.material.hardening = hardening;
    let found = measured("fold", &setup);
    assert!((number(&found, "folded_deg") - angle).abs() < 1e-3 * angle, "{found}");
    number(&found, "angle_deg")
}

#[test]
fn a_folded_card_keeps_the_angle_of_return_mapping_on_any_grid() {
    // D = 3e9 · 5e-4³/(12 (1 - 0.35²)), M_y = 3e7 · 5e-4²/4, H = 1e9 · 5e-4³/12.
    let (stiffness, moment) = (3e9 * 1.25e-10 / (12.0 * 0.8775), 3e7 * 2.5e-7 / 4.0);
    for (modulus, h) in [(0.0, 0.0), (1e9, 1e9 * 1.25e-10 / 12.0)] {
        for angle in [30.0_f64, 90.0, 160.0] {
            let curvature = angle.to_radians() / 0.02;
            let stays: f64 = (stiffness * curvature - moment) / (stiffness + h);
            let wanted = (stays.max(0.0) * 0.02).to_degrees();
            for grid in [11, 21, 41] {
                let kept = fold(angle, grid, modulus);
                println!("fold {angle} at {grid}, H {modulus:e}: {kept:.3}, wanted {wanted:.3}");
                assert!(
                    (kept - wanted).abs() < 0.005 * angle,
                    "{angle} at {grid}, H {modulus:e}: {kept}, not {wanted}"
                );
            }
        }
    }
}

/// Upward rotation of the right edge relative to the left one, degrees.
fn turned(sheet: &Sheet) -> f64 {
    let near = |u: f64, v: f64| {
        let far = |i: &usize| (sheet.uv[*i].0 - u).abs() + (sheet.uv[*i].1 - v).abs();
        (0..sheet.node_count()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    };
    let along = sheet.x.get(near(1.0, 0.5)) - sheet.x.get(near(0.8, 0.5));
    along.y.atan2(along.x).to_degrees()
}

fn settled(scene: &Scene) -> World {
    let mut world = world(scene);
    let found = world.find_equilibrium(1e-9);
    assert!(found[0].converged && found[0].is_stable, "{found:?}");
    world
}

#[test]
fn a_crease_has_its_rest_angle_on_any_grid() {
    for (u, angle) in [(0.5, 60.0), (0.43, 60.0), (0.5, -100.0)] {
        for grid in [11, 21, 41] {
            let mut scene = card((grid, 7));
            scene.sheets[0].creases = vec![CreaseSpec { from: (u, 0.0), to: (u, 1.0), angle }];
            let world = settled(&scene);
            let got = turned(&world.sheets()[0]);
            println!("crease {angle} at {u}, grid {grid}: {got:.4}");
            assert!((got - angle).abs() < 1e-3 * angle.abs(), "{angle} at {u}, grid {grid}: {got}");
            let energy = world.sheets()[0].energy(DVec3::ZERO).elastic;
            assert!(energy < 1e-9, "stored {energy} J");
        }
    }
}

#[test]
fn a_crease_of_a_triangle_mesh_has_its_rest_angle() {
    for u in [0.5, 0.43] {
        for grid in [11, 21] {
            let mut scene = card((grid, grid / 2 + 1));
            let corners = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)];
            scene.sheets[0].outline = Some(OutlineSpec::Polygon(corners.to_vec()));
            scene.sheets[0].creases = vec![CreaseSpec { from: (u, 0.0), to: (u, 1.0), angle: 40.0 }];
            let got = turned(&settled(&scene).sheets()[0]);
            println!("triangles, crease at {u}, grid {grid}: {got:.4}");
            assert!((got - 40.0).abs() < 1.2, "at {u}, grid {grid}: {got}");
        }
    }
}

#[test]
fn a_curled_sheet_is_an_arc_of_its_curvature() {
    for curl in [6.0, -10.0] {
        let mut scene = card((21, 7));
        scene.sheets[0].curl = (curl, 0.0);
        let world = settled(&scene);
        let sheet = &world.sheets()[0];
        // The last half cell is straight.
        let end = sheet.x.get(3 * 21 + 20) - sheet.x.get(3 * 21 + 19);
        let wanted = (curl * (0.2 - 0.005)).to_degrees();
        assert!((end.y.atan2(end.x).to_degrees() - wanted).abs() < 0.002 * wanted.abs(), "{end} {wanted}");
    }
}

/// A free undamped card of 11 x 7 nodes with a crease, flat at the start.
fn springing() -> Scene {
    let mut scene = card((11, 7));
    let sheet = &mut scene.sheets[0];
    sheet.pins.clear();
    sheet.creases = vec![CreaseSpec { from: (0.5, 0.0), to: (0.5, 1.0), angle: 70.0 }];
    sheet.damping_ratio = Some(0.0);
    scene
}

#[test]
fn a_creased_sheet_in_flight_gains_neither_energy_nor_momentum() {
    let energy = |world: &World| world.sheets()[0].energy(DVec3::ZERO).total;
    // Flat at the start, so that the card springs into its fold.
    let mut springs = world(&springing());
    let start = energy(&springs);
    for step in 0..240 {
        springs.step();
        assert!(energy(&springs) <= start * (1.0 + 1e-3), "{step}: {} of {start}", energy(&springs));
    }
    assert!(springs.unstable().is_none());
    let sheet = &springs.sheets()[0];
    assert!(sheet.momentum().length() < 1e-9 * sheet.total_mass(), "{}", sheet.momentum());
    // In its rest shape, and rotating.
    let mut turns = world(&springing());
    turns.find_equilibrium(1e-9);
    let sheet = &mut turns.sheets_mut()[0];
    let (spin, centre) = (DVec3::new(3.0, 1.0, -5.0), sheet.centre_of_mass());
    (0..sheet.node_count()).for_each(|i| sheet.v.set(i, spin.cross(sheet.x.get(i) - centre)));
    let turning = turns.sheets()[0].angular_momentum();
    let start = energy(&turns);
    for step in 0..120 {
        turns.step();
        assert!(energy(&turns) <= start * (1.0 + 1e-3), "{step}: {} of {start}", energy(&turns));
    }
    let change = turns.sheets()[0].angular_momentum() - turning;
    println!("creased spin: energy {} of {start}, turning {}", energy(&turns), change.length() / turning.length());
    assert!(change.length() < 0.02 * turning.length(), "{change} of {turning}");
}

/// A clamped card that yields at a fiftieth of its ordinary yield stress.
fn weak(hardening: f64) -> Scene {
    let mut scene = card((11, 7));
    let card =
        Material { yield_stress: Some(3e5), hardening, ..sheetwork::scene::material::by_name("card").expect("there") };
    scene.sheets[0].material = MaterialChoice::Inline(card);
    scene.sheets[0].plastic = true;
    scene.sheets[0].damping_ratio = Some(0.0);
    scene
}

#[test]
fn yield_only_dissipates_energy() {
    for (seed, speed) in [(1, 0.3), (2, 2.0), (3, 8.0)] {
        let mut world = world(&weak(1e8));
        excite_randomly(&mut world.sheets_mut()[0], speed, seed);
        for i in 0..7 {
            world.sheets_mut()[0].v.set(11 * i, DVec3::ZERO);
        }
        let energy = |world: &World| world.sheets()[0].energy(DVec3::ZERO).total;
        let start = energy(&world);
        for step in 0..240 {
            world.step();
            assert!(energy(&world) <= start * (1.0 + 1e-3), "{speed} m/s, {step}: {} of {start}", energy(&world));
        }
        assert!(world.unstable().is_none());
        println!("yield at {speed} m/s: energy {} of {start}", energy(&world));
    }
}

#[test]
fn plastic_strain_remains_and_elastic_strain_recovers() {
    for (plastic, stays) in [(true, true), (false, false)] {
        let mut scene = weak(0.0);
        scene.sheets[0].plastic = plastic;
        scene.sheets[0].damping_ratio = Some(0.3);
        scene.gravity = DVec3::new(0.0, -9.81, 0.0);
        let mut world = world(&scene);
        world.advance(1.0);
        world.set_gravity(DVec3::ZERO).expect("in range");
        world.advance(3.0);
        let drop = -world.sheets()[0].x.get(3 * 11 + 10).y;
        assert!((drop.abs() > 0.01) == stays && drop > -1e-3, "plastic {plastic}: {drop}");
    }
}

#[test]
fn explicit_and_implicit_integrators_yield_equally() {
    let mut drops = Vec::new();
    for (engine, dt) in [(IntegratorKind::TrBdf2, 2e-4), (IntegratorKind::Verlet, 1e-5), (IntegratorKind::Rk4, 1e-5)] {
        let mut scene = weak(1e8);
        // Soft and thick, for a practical step of explicit integrators.
        let soft = Material {
            young: 2e5,
            thickness: 8e-3,
            density: 60.0,
            yield_stress: Some(150.0),
            ..scene.sheets[0].material.resolve("".as_ref()).expect("there")
        };
        scene.sheets[0].material = MaterialChoice::Inline(Material { hardening: 1e4, ..soft });
        scene.sheets[0].grid = (6, 1, 4);
        scene.gravity = DVec3::new(0.0, -9.81, 0.0);
        scene.engine = engine;
        scene.dt = dt;
        let mut world = world(&scene);
        world.advance(0.25);
        assert!(world.unstable().is_none());
        drops.push(-world.sheets()[0].x.get(11).y);
        let bent = world.sheets()[0].rest_angles().map(|k| k[0].abs()).fold(0.0, f64::max);
        assert!(bent > 0.0, "{engine} did not yield");
    }
    println!("drops {drops:?}");
    assert!(drops.iter().all(|d| (d / drops[0] - 1.0).abs() < 0.01), "{drops:?}");
}

#[test]
fn creases_and_plasticity_of_unsuitable_sheets_are_rejected() {
    let lattice = |s: &mut SheetSpec| {
        s.structure = StructureKind::Samm;
        s.grid.1 = 2;
        s.pins.clear();
    };
    let of_lattice = |change: fn(&mut SheetSpec)| {
        rejection(&move |s| {
            lattice(s);
            change(s);
        })
    };
    assert!(of_lattice(|s| s.plastic = true).1.contains("shell only, not for samm"));
    assert_eq!(of_lattice(|s| s.curl.0 = 1.0).0, "sheets.0.curl");
    let rubber = rejection(&|s| {
        s.material = MaterialChoice::Named("rubber".into());
        s.plastic = true;
    });
    assert!(rubber.1.contains("yield stress"));
    let creased = |from, to, angle| rejection(&move |s| s.creases = vec![CreaseSpec { from, to, angle }]);
    assert_eq!(creased((0.0, 0.5), (1.2, 0.5), 10.0).0, "sheets.0.creases.0.to.0");
    assert!(creased((0.0, 0.5), (1.0, 0.5), 180.0).1.contains("degrees is outside -175 to 175"));
    assert!(creased((0.5, 0.5), (0.5, 0.5), 10.0).1.contains("begins"));
    assert!(creased((f64::NAN, 0.5), (0.5, 0.5), 10.0).0.ends_with("from.0"));
}
