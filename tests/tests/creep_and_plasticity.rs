//! Permanent deformation: yielding folds, creases, curl and creep, and their energy.
//!
//! Expected numbers are return mapping and Burgers' creep compliance by hand, and geometry.

use glam::DVec3;
use serde_json::Value;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::islands::event::EventKind;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{
    BurgersCreep, CreaseSpec, Material, MaterialChoice, PinSpec, Placement, Region, Scene, Shape, SheetSpec, SpringLaw,
};
use sheetwork::sheet::Sheet;
use sheetwork_rigs::measure::{Setup, measure};
use sheetwork_tests::{body, excite_randomly, state_hash, world};

fn number(found: &Value, key: &str) -> f64 {
    found[key].as_f64().unwrap_or_else(|| panic!("{key} in {found}"))
}

fn found(case: &str, setup: &Setup) -> Value {
    measure(case, setup).unwrap_or_else(|e| panic!("{e}"))
}

fn fold(angle: f64, grid: u32, hardening: f64) -> f64 {
    let mut setup = Setup { angle, grid: (grid, 11), length: 0.02, ..Setup::default() };
    setup.material.hardening = hardening;
    let found = found("fold", &setup);
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

/// A card of 0.2 m by 0.1 m, clamped at its left edge.
fn card(grid: (u32, u32)) -> Scene {
    let sheet = SheetSpec {
        name: "card".into(),
        structure: StructureKind::Shell,
        grid: (grid.0, 1, grid.1),
        size: (0.2, 0.1),
        material: MaterialChoice::Named("card".into()),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    };
    let dt = 1.0 / 60.0;
    Scene { gravity: DVec3::ZERO, engine: IntegratorKind::TrBdf2, dt, sheets: vec![sheet], ..Scene::default() }
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
fn creep_follows_burgers_compliance_on_every_structure() {
    let base = Setup { grid: (11, 7), seconds: 10.0, ..Setup::default() };
    let lattice = Setup { structure: StructureKind::DoubleDiagonal, layers: 2, ..base.clone() };
    let triangles = Setup { outlined: true, ..base.clone() };
    let soft = Setup { structure: StructureKind::Trimm, layers: 2, ..base.clone() };
    for setup in [base.clone(), triangles, lattice, soft] {
        let found = found("creep", &setup);
        println!("{}: {}", found["structure"], found["largest_error"]);
        // 1 + 10/10 + 0.5 (1 - e^-10).
        assert!((number(&found, "expected_compliance") - 2.499_977_3).abs() < 1e-7);
        assert!(number(&found, "largest_error") < 5e-4, "{found}");
    }
    // A dashpot alone creeps at its rate in steps of any length.
    let mut alone = Setup { dt: Some(1.0), ..base };
    alone.material.burgers = Some(BurgersCreep { relaxation_time: 0.2, retardation_time: 1.0, retarded: 0.0 });
    assert!(number(&found("creep", &alone), "largest_error") < 1e-4);
}

#[test]
fn dynamic_creep_equals_quasi_static_creep_up_to_inertia() {
    let setup = Setup { grid: (11, 7), seconds: 4.0, dynamic: true, damping_ratio: 0.1, ..Setup::default() };
    let found = found("creep", &setup);
    println!("dynamic creep: {} {}", found["compliance_error"], found["largest_error"]);
    assert!(number(&found, "compliance_error").abs() < 5e-3, "{found}");
}

#[test]
fn temperature_shifts_creep() {
    let setup = |celsius: f64| {
        let material = sheetwork::scene::material::by_name("hips").expect("there");
        Setup { grid: (11, 5), seconds: 60.0, celsius: Some(celsius), material, ..Setup::default() }
    };
    // log10 a_T = -17.44 · 40/91.6; 1e9 s become 24.23 s and 1e8 s 2.423 s: 1 + 60/24.23 + 0.5.
    let hot = found("creep", &setup(140.0));
    assert!((number(&hot, "compliance") - 3.976).abs() < 0.01, "{hot}");
    assert!((number(&found("creep", &setup(20.0)), "compliance") - 1.0).abs() < 1e-9);
}

/// A polystyrene sheet fixed at two edges, with a relaxation time of 2.4 s at 140 °C.
fn held(engine: IntegratorKind) -> Scene {
    let mut scene = card((11, 7));
    let hips = sheetwork::scene::material::by_name("hips").expect("there");
    let burgers = Some(BurgersCreep { relaxation_time: 1e8, retardation_time: 1e7, retarded: 0.5 });
    let sheet = &mut scene.sheets[0];
    // Without expansion, because shrinkage on cooling would tighten it between its edges.
    sheet.material = MaterialChoice::Inline(Material { burgers, expansion: 0.0, ..hips });
    sheet.pins = vec![PinSpec::fixed(Region::Left), PinSpec::fixed(Region::Right)];
    sheet.creep = true;
    sheet.temperature = Some(20.0);
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.engine = engine;
    scene
}

#[test]
fn a_hot_sag_remains_when_cold() {
    let mut world = world(&held(IntegratorKind::TrBdf2));
    let sag = |world: &World| -world.sheets()[0].x.get(3 * 11 + 5).y;
    let energy = |world: &World| world.sheets()[0].energy(DVec3::new(0.0, -9.81, 0.0)).total;
    world.advance(2.0);
    let mut highest = energy(&world);
    let stiff = sag(&world);
    // 20 to 140 °C and back, 4 K per step.
    let path = (0..30).map(|k| 24.0 + 4.0 * f64::from(k)).chain((0..1200).map(|_| 140.0));
    let path = path.chain((0..30).map(|k| 136.0 - 4.0 * f64::from(k)));
    let mut hot = 0.0;
    for celsius in path {
        world.set("sheets.card.temperature", &celsius.to_string()).expect("a temperature");
        world.step();
        let now = energy(&world);
        assert!(now <= highest + 1e-9, "{celsius} °C: {now} J after {highest} J");
        highest = now;
        hot = if celsius >= 140.0 { sag(&world) } else { hot };
    }
    let cold = sag(&world);
    world.set_gravity(DVec3::ZERO).expect("in range");
    world.advance(4.0);
    let kept = sag(&world);
    println!("sag {stiff:.5} stiff, {hot:.5} hot, {cold:.5} cold, {kept:.5} without load");
    assert!(hot > 2.0 * stiff, "{hot} after {stiff}");
    assert!((cold / hot - 1.0).abs() < 0.01, "{cold} after {hot}");
    assert!((kept / cold - 1.0).abs() < 0.05, "{kept} after {cold}");
}

#[test]
fn a_creeping_sheet_does_not_fall_asleep() {
    let mut scene = held(IntegratorKind::TrBdf2);
    scene.sheets[0].temperature = Some(125.0);
    scene.sheets[0].damping_ratio = Some(0.5);
    let mut world = World::new(&scene).expect("valid");
    world.advance(3.0);
    let sag = |world: &World| -world.sheets()[0].x.get(3 * 11 + 5).y;
    let before = sag(&world);
    world.advance(3.0);
    assert!(sag(&world) > before + 1e-8, "{} after {before}", sag(&world));
    world.set("sheets.card.temperature", "20").expect("a temperature");
    world.advance(3.0);
    assert!(world.sheets()[0].status == sheetwork::sheet::Status::Asleep);
}

#[test]
fn hot_sheets_gain_no_energy_with_any_implicit_integrator_and_structure() {
    for engine in TABLE.iter().filter(|e| e.implicit) {
        for structure in [StructureKind::Shell, StructureKind::DoubleDiagonal] {
            let mut scene = held(engine.kind);
            let sheet = &mut scene.sheets[0];
            sheet.structure = structure;
            sheet.springs = SpringLaw::Calibrated;
            sheet.grid.1 = if structure == StructureKind::Shell { 1 } else { 2 };
            sheet.temperature = Some(130.0);
            sheet.damping_ratio = Some(0.02);
            scene.gravity = DVec3::ZERO;
            let mut world = world(&scene);
            let still: Vec<usize> =
                (0..world.sheets()[0].node_count()).filter(|i| world.sheets()[0].is_held(*i)).collect();
            excite_randomly(&mut world.sheets_mut()[0], 0.5, 5);
            still.iter().for_each(|i| world.sheets_mut()[0].v.set(*i, DVec3::ZERO));
            let energy = |world: &World| world.sheets()[0].energy(DVec3::ZERO).total;
            let mut before = energy(&world);
            let start = before;
            for step in 0..180 {
                world.step();
                let now = energy(&world);
                assert!(now <= before + 1e-3 * start, "{} {structure}, step {step}: {now} after {before}", engine.name);
                before = now;
            }
            assert!(world.unstable().is_none());
        }
    }
}

#[test]
fn pins_are_released_at_their_end_time() {
    let mut scene = card((11, 7));
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.sheets[0].pins = vec![PinSpec { until: Some(0.5), ..PinSpec::fixed(Region::All) }];
    let mut world = world(&scene);
    world.advance(0.5);
    assert_eq!(world.sheets()[0].max_speed(), 0.0);
    world.advance(0.5);
    let fallen = -world.sheets()[0].centre_of_mass().y;
    assert!((fallen - 0.5 * 9.81 * 0.25).abs() < 1e-6, "{fallen}");
}

#[test]
fn a_sleeping_sheet_wakes_when_its_pins_are_released() {
    let mut scene = card((11, 7));
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.sheets[0].pins = vec![PinSpec { until: Some(1.0), ..PinSpec::fixed(Region::All) }];
    let mut world = world(&scene);
    world.set_sleep(true);
    world.advance(1.25);
    let kinds: Vec<EventKind> = world.events().iter().map(|e| e.kind).collect();
    assert_eq!(kinds, [EventKind::AtRest, EventKind::Woke]);
    assert!((world.events()[1].time_s - 1.0).abs() < 1e-6, "{}", world.events()[1].time_s);
}

/// Sheets with creases, plasticity and creep, side by side.
fn all_that_flows(engine: IntegratorKind) -> Scene {
    let mut scene = held(engine);
    // Full stiffness at all temperatures, because limp sheets would fold onto themselves.
    let stiff = scene.sheets[0].material.resolve("".as_ref()).expect("there");
    let softening = vec![(0.0, 1.0), (200.0, 1.0)];
    scene.sheets[0].material = MaterialChoice::Inline(Material { softening, ..stiff });
    scene.sheets[0].temperature = Some(120.0);
    scene.sheets[0].plastic = true;
    scene.sheets[0].creases = vec![CreaseSpec { from: (0.2, 0.0), to: (0.9, 1.0), angle: 30.0 }];
    let mut triangles = scene.sheets[0].clone();
    triangles.name = "triangles".into();
    triangles.placement.position.z = 0.5;
    triangles.outline = Some(OutlineSpec::Disc { radius: 0.08 });
    triangles.pins = vec![PinSpec::fixed(Region::Left), PinSpec::fixed(Region::Right)];
    let mut lattice = scene.sheets[0].clone();
    lattice.name = "lattice".into();
    lattice.placement.position.z = 1.0;
    lattice.structure = StructureKind::DoubleDiagonal;
    lattice.springs = SpringLaw::Calibrated;
    lattice.grid.1 = 2;
    lattice.plastic = false;
    lattice.creases.clear();
    lattice.pins = vec![PinSpec::clamped(Region::Left)];
    scene.sheets.extend([triangles, lattice]);
    scene
}

#[test]
fn creep_and_plasticity_are_bit_identical_on_any_number_of_threads() {
    let scene = all_that_flows(IntegratorKind::TrBdf2);
    let run = |threads: usize| {
        let mut world = world(&scene);
        world.set_threads(threads).expect("in range");
        (0..40).for_each(|_| world.step());
        assert!(world.unstable().is_none());
        state_hash(&world)
    };
    let one = run(1);
    assert!([2, 3].into_iter().all(|threads| run(threads) == one));
}

#[test]
fn a_warm_step_with_creep_and_plasticity_allocates_nothing() {
    for engine in TABLE.iter().filter(|e| e.implicit) {
        let mut world = world(&all_that_flows(engine.kind));
        let change = |world: &mut World, celsius: &str| {
            for sheet in world.sheets_mut() {
                sheet.set_temperature(celsius.parse().expect("a number")).expect("in range");
            }
        };
        (0..20).for_each(|_| world.step());
        change(&mut world, "123");
        (0..3).for_each(|_| world.step());
        let counted = allocation_counter::measure(|| {
            change(&mut world, "121");
            (0..20).for_each(|_| world.step());
        });
        assert_eq!(counted.count_total, 0, "{}", engine.name);
    }
}

#[test]
fn creep_and_plasticity_of_unsuitable_sheets_are_rejected() {
    let refused = |change: &dyn Fn(&mut SheetSpec)| {
        let mut scene = card((11, 7));
        change(&mut scene.sheets[0]);
        let error = World::new(&scene).err().expect("refused");
        (error.field, error.problem)
    };
    let lattice = |s: &mut SheetSpec| {
        s.structure = StructureKind::Samm;
        s.grid.1 = 2;
        s.pins.clear();
    };
    let crease = |from, to, angle| vec![CreaseSpec { from, to, angle }];
    assert!(
        refused(&|s| {
            lattice(s);
            s.plastic = true
        })
        .1
        .contains("shell only, not for samm")
    );
    assert_eq!(
        refused(&|s| {
            lattice(s);
            s.curl.0 = 1.0
        })
        .0,
        "sheets.0.curl"
    );
    let rubber = |s: &mut SheetSpec| s.material = MaterialChoice::Named("rubber".into());
    assert!(
        refused(&|s| {
            rubber(s);
            s.plastic = true
        })
        .1
        .contains("yield stress")
    );
    assert!(
        refused(&|s| {
            rubber(s);
            s.creep = true
        })
        .1
        .contains("burgers")
    );
    assert_eq!(refused(&|s| s.creases = crease((0.0, 0.5), (1.2, 0.5), 10.0)).0, "sheets.0.creases.0.to.0");
    assert!(
        refused(&|s| s.creases = crease((0.0, 0.5), (1.0, 0.5), 180.0)).1.contains("degrees is outside -175 to 175")
    );
    assert!(refused(&|s| s.creases = crease((0.5, 0.5), (0.5, 0.5), 10.0)).1.contains("begins"));
    assert!(refused(&|s| s.creases = crease((f64::NAN, 0.5), (0.5, 0.5), 10.0)).0.ends_with("from.0"));
    assert!(refused(&|s| s.temperature = Some(-300.0)).1.contains("°C"));
    assert!(refused(&|s| s.pins[0].until = Some(1.0)).1.contains("without clamp"));
    let bad = |b: BurgersCreep| {
        refused(&move |s: &mut SheetSpec| {
            s.material = MaterialChoice::Inline(Material { burgers: Some(b), ..Material::default() });
        })
    };
    let good = BurgersCreep { relaxation_time: 1.0, retardation_time: 1.0, retarded: 1.0 };
    assert!(bad(BurgersCreep { relaxation_time: 0.0, ..good }).1.contains("0 s is outside 1e-6 to 1e30 s"));
    assert!(bad(BurgersCreep { retarded: -1.0, ..good }).0.ends_with("burgers.retarded"));
}

#[test]
fn a_sheet_formed_hot_over_a_ball_keeps_its_shape_cold() {
    let mut scene = held(IntegratorKind::TrBdf2);
    let sheet = &mut scene.sheets[0];
    let hips = sheet.material.resolve("".as_ref()).expect("there");
    // A relaxation time of 0.24 s at 140 °C.
    let burgers = Some(BurgersCreep { relaxation_time: 1e7, retardation_time: 1e6, retarded: 0.5 });
    sheet.material = MaterialChoice::Inline(Material { burgers, ..hips });
    sheet.size = (0.2, 0.2);
    sheet.grid = (13, 1, 13);
    sheet.pins.clear();
    sheet.damping_ratio = Some(0.2);
    sheet.placement.position.y = 0.0505;
    scene.bodies = vec![body("mould", Shape::Ball(0.05), Placement::default(), Vec::new())];
    scene.contact.friction = 0.6;
    let mut world = world(&scene);
    let sag = |world: &World| {
        let x = &world.sheets()[0].x;
        let corners = [0, 12, 156, 168].map(|i| x.get(i).y);
        x.get(84).y - 0.25 * corners.iter().sum::<f64>()
    };
    let energy = |world: &World| world.sheets()[0].energy(DVec3::new(0.0, -9.81, 0.0)).total;
    world.advance(1.0);
    let stiff = sag(&world);
    // Energy of the depenetration that contact allows in a step, 0.1 mm.
    let lift = 1e-4 * 9.81 * world.sheets()[0].total_mass();
    let (start, mut before) = (energy(&world), energy(&world));
    let path = (0..60).map(|k| 22.0 + 2.0 * f64::from(k)).chain((0..480).map(|_| 140.0));
    for celsius in path.chain((0..60).map(|k| 138.0 - 2.0 * f64::from(k))) {
        world.set("sheets.card.temperature", &celsius.to_string()).expect("a temperature");
        world.step();
        let now = energy(&world);
        assert!(now <= before + lift && now <= start + lift, "{celsius} °C: {now} J after {before} J of {start} J");
        before = now;
    }
    assert!(world.unstable().is_none());
    let cold = sag(&world);
    world.set_gravity(DVec3::ZERO).expect("in range");
    world.advance(2.0);
    let kept = sag(&world);
    println!("over a ball: {stiff:.5} stiff, {cold:.5} formed, {kept:.5} without load");
    assert!(cold > 3.0 * stiff.max(1e-3), "{cold} after {stiff}");
    assert!((kept / cold - 1.0).abs() < 0.05, "{kept} after {cold}");
}

#[test]
fn a_sheet_creeps_and_softens_where_it_is_hot() {
    // A cantilever that is hot at its root bends in its middle; one that is hot at its tip does
    // not.
    let bent = |hot: &dyn Fn(f64) -> bool| {
        let mut scene = held(IntegratorKind::TrBdf2);
        scene.sheets[0].pins = vec![PinSpec::clamped(Region::Left)];
        scene.sheets[0].damping_ratio = Some(0.2);
        let mut world = world(&scene);
        let sheet = &mut world.sheets_mut()[0];
        let uv = sheet.uv.clone();
        sheet.set_temperatures(|i| if hot(uv[i].0) { 125.0 } else { 20.0 }).expect("in range");
        world.advance(2.0);
        world.sheets_mut()[0].set_temperatures(|_| 20.0).expect("in range");
        world.set_gravity(DVec3::ZERO).expect("in range");
        world.advance(3.0);
        assert!(world.unstable().is_none());
        -world.sheets()[0].x.get(3 * 11 + 5).y
    };
    let (none, tip, root) = (bent(&|_| false), bent(&|u| u > 0.7), bent(&|u| u < 0.4));
    println!("set by heat: {none:.6} nowhere, {tip:.5} at the tip, {root:.5} at the root");
    assert!(none.abs() < 1e-4 && tip.abs() < 2e-3 && root > 0.02, "{none} {tip} {root}");
}
