//! Instability detector and recovery policies: detection before any non-finite value, action by the
//! scene's policy, an event with numbers, equal results on any number of threads, and no effect on
//! other sheets.
//!
//! The scene is the thesis's wedge with Young's modulus a thousand and more times too high for its
//! step, which becomes unstable within a tenth of a second.

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::islands::event::{Event, EventKind, RecoveryAction};
use sheetwork::mesh::structure;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{MaterialChoice, PinSpec, Region, Scene, WhenUnstable};
use sheetwork::sheet::{Sheet, Status};
use sheetwork_tests::{
    Random, excite_randomly, scene_without_gravity, shipped_scene, shipped_scene_names, small_sheet, state_hash, world,
};

/// Recovery policies other than `stop`.
const POLICIES: [&str; 4] = ["reduce-step 1024", "implicit", "freeze", "limit 0.1"];

/// The wedge with a sheet of this modulus, Pa; the shipped one's is 185.
fn stiff_wedge(young: f64, policy: &str) -> Scene {
    let scene = shipped_scene("wedge").with_override("sheets.0.material.young", &young.to_string());
    scene.and_then(|s| s.with_override("sheets.0.when_unstable", policy)).unwrap_or_else(|e| panic!("{e}"))
}

fn steps(world: &mut World, count: u32) {
    (0..count).for_each(|_| _ = world.step());
}

fn contained(world: &World) -> Vec<&Event> {
    world.events().iter().filter(|e| e.kind == EventKind::Contained).collect()
}

fn strain(sheet: &Sheet) -> f64 {
    let springs = sheet.springs();
    let of = |i: usize| {
        let [a, b] = [springs.a[i], springs.b[i]].map(|m| sheet.x.get(m as usize));
        (a.distance(b) / springs.rest[i] - 1.0).abs()
    };
    (0..springs.len()).map(of).fold(0.0, f64::max)
}

#[test]
fn a_stopped_sheet_reports_the_reason() {
    let mut world = world(&stiff_wedge(2e5, "stop"));
    steps(&mut world, 400);
    assert!(world.unstable().is_some(), "the scene is to fly apart");
    let event = world.events().iter().find(|e| e.kind == EventKind::Unstable).expect("told");
    let alarm = event.alarm.expect("with its numbers");
    assert_eq!(alarm.handled, RecoveryAction::Stopped);
    assert!(alarm.energy_after_j > 10.0 * alarm.energy_before_j.expect("known"), "{alarm:?}");
    assert!(alarm.speed_m_s > 10.0 && alarm.strain > 1.0 && alarm.step_s == 0.005, "{alarm:?}");
    assert_eq!(event.place_m, Some(alarm.place_m));
    assert_eq!(world.report(0.0, &[]).sheets[0].when_unstable, "stop");
}

#[test]
fn every_recovery_policy_stabilises_an_unstable_sheet() {
    for policy in POLICIES {
        let mut world = world(&stiff_wedge(2e5, policy));
        for _ in 0..300 {
            world.step();
            let sheet = &world.sheets()[0];
            assert!(sheet.x.iter().chain(sheet.v.iter()).all(DVec3::is_finite), "{policy}");
            assert!(sheet.max_speed() < 10.0, "{policy}: {} m/s at {} s", sheet.max_speed(), world.time());
        }
        assert!(world.unstable().is_none() && world.report(0.0, &[]).status == "ok", "{policy}");
        let told = contained(&world);
        let alarm = told.first().and_then(|e| e.alarm).unwrap_or_else(|| panic!("{policy}: not told"));
        println!("{policy}: {} alarms, the first at {} s: {alarm:?}", told.len(), told[0].time_s);
        // Early detection: at ordinary speed and little strain.
        assert!(alarm.speed_m_s < 20.0 && alarm.strain < 2.0, "{policy}: {alarm:?}");
        assert!(alarm.energy_after_j > alarm.energy_before_j.expect("known"), "{policy}: {alarm:?}");
        let handled = match alarm.handled {
            RecoveryAction::StepReduced { parts } => (2..=1024).contains(&parts) && policy.starts_with("reduce"),
            RecoveryAction::Implicit => policy == "implicit",
            RecoveryAction::Frozen => policy == "freeze",
            RecoveryAction::Limited { strain } => strain == 0.1 && policy.starts_with("limit"),
            RecoveryAction::Stopped => false,
        };
        assert!(handled && told.len() < 20, "{policy}: {alarm:?}, {} events", told.len());
    }
}

#[test]
fn reduced_step_and_implicit_policy_equal_a_stable_run() {
    // Reference with a step that is stable without any action.
    let mut sound = stiff_wedge(2e4, "reduce-step 1024");
    sound.dt = 2.5e-4;
    let mut reference = world(&sound);
    steps(&mut reference, 3200);
    assert!(contained(&reference).is_empty(), "{:?}", reference.events());
    let place = |world: &World| world.sheets()[0].centre_of_mass();
    for policy in ["reduce-step 1024", "implicit"] {
        let mut world = world(&stiff_wedge(2e4, policy));
        steps(&mut world, 160);
        assert!(!contained(&world).is_empty(), "{policy}");
        assert!(world.events().iter().any(|e| e.kind == EventKind::FirstContact), "{policy}: it falls on the wedge");
        let apart = place(&world).distance(place(&reference));
        println!("{policy}: {apart:.2e} m apart at {} s", world.time());
        // A fall of 8 mm and a slide; the direction of the final tilt is sensitive.
        assert!(apart < 2e-3, "{policy}: {apart} m from {}", place(&reference));
    }
}

#[test]
fn step_and_integrator_are_restored_after_the_cause_is_gone() {
    // A soft sheet exceeds a strain of a tenth at its landing.
    for policy in ["reduce-step", "implicit", "limit 0.6"] {
        let mut world = world(&stiff_wedge(1e5, policy));
        steps(&mut world, 40);
        assert!(!contained(&world).is_empty(), "{policy}");
        let replaced = world.sheets()[0].engine() == IntegratorKind::TrBdf2;
        assert_eq!(replaced, policy == "implicit");
        world.set("sheets.sheet.material.young", "185").unwrap_or_else(|e| panic!("{e}"));
        steps(&mut world, 1500);
        let recovered = world.events().iter().rfind(|e| e.kind == EventKind::Recovered);
        assert!(recovered.is_some(), "{policy}: {:?}", world.events());
        assert_eq!(world.sheets()[0].engine(), IntegratorKind::EulerRichardson, "{policy}");
        let last = contained(&world).last().map_or(0.0, |e| e.time_s);
        assert!(recovered.is_some_and(|e| e.time_s > last), "{policy}: for good");
    }
}

#[test]
fn an_exhausted_substep_limit_freezes_and_a_change_unfreezes() {
    for policy in ["reduce-step 2", "freeze"] {
        let mut world = world(&stiff_wedge(1e6, policy));
        steps(&mut world, 100);
        assert!(matches!(world.sheets()[0].status, Status::Frozen { .. }), "{policy}");
        let report = world.report(0.0, &[]);
        assert!(report.sheets[0].status.starts_with("frozen: sheet at"), "{}", report.sheets[0].status);
        let alarm = contained(&world).last().and_then(|e| e.alarm).expect("told");
        assert_eq!(alarm.handled, RecoveryAction::Frozen);
        let before = world.sheets()[0].x.clone();
        assert!(strain(&world.sheets()[0]) < 0.5, "{policy}: in a shape that can be seen");
        steps(&mut world, 50);
        assert_eq!(world.sheets()[0].x, before);
        world.set("sheets.sheet.material.young", "185").unwrap_or_else(|e| panic!("{e}"));
        steps(&mut world, 200);
        assert_eq!(world.sheets()[0].status, Status::Awake, "{policy}");
        assert!(world.sheets()[0].centre_of_mass().y < before.bounds().map_or(0.0, |b| b.0.y), "{policy}: it falls");
    }
}

#[test]
fn strain_limiting_bounds_strain_and_conserves_momentum() {
    let mut scene = stiff_wedge(1e6, "limit 0.05");
    scene.bodies.clear();
    scene.room = None;
    scene.air.factor = 1.0;
    let mut world = world(&scene);
    let start = world.sheets()[0].centre_of_mass();
    // A velocity of one corner starts the motion.
    world.sheets_mut()[0].v.set(0, DVec3::new(0.0, 0.5, 0.0));
    let drift = world.sheets()[0].momentum() / world.sheets()[0].total_mass();
    steps(&mut world, 200);
    assert!(!contained(&world).is_empty());
    let sheet = &world.sheets()[0];
    assert_eq!(sheet.status, Status::Awake, "{:?}", world.events());
    assert!(strain(sheet) < 0.08, "{}", strain(sheet));
    // Internal forces cannot move the centre of mass, which falls freely.
    let t = world.time();
    let fall = start + drift * t + world.gravity() * (0.5 * t * t);
    assert!(sheet.centre_of_mass().distance(fall) < 1e-9, "{} {fall}", sheet.centre_of_mass());
}

#[test]
fn recovery_is_bit_identical_on_any_number_of_threads_and_affects_no_other_sheet() {
    for policy in POLICIES {
        let mut alone =
            scene_without_gravity(small_sheet(structure::StructureKind::Trimm, 0.1), IntegratorKind::EulerRichardson);
        (alone.dt, alone.gravity) = (2e-3, DVec3::new(0.0, -1.0, 0.0));
        let mut both = alone.clone();
        for (i, structure) in structure::TABLE.iter().enumerate() {
            let mut mad = small_sheet(structure.kind, 0.1);
            mad.name = format!("mad {}", structure.name);
            mad.placement.position = DVec3::new(2.0 + i as f64, 0.0, 0.0);
            mad.when_unstable = policy.parse().unwrap_or_else(|e| panic!("{e}"));
            let MaterialChoice::Inline(material) = &mut mad.material else { panic!("in line") };
            material.young *= 1e4;
            both.sheets.push(mad);
        }
        let run = |scene: &Scene, threads: usize| {
            let mut world = world(scene);
            world.set_threads(threads).unwrap_or_else(|e| panic!("{e}"));
            for sheet in world.sheets_mut() {
                excite_randomly(sheet, 0.01, 1);
            }
            steps(&mut world, 250);
            world
        };
        let one = run(&both, 1);
        assert!(contained(&one).len() >= structure::TABLE.len(), "{policy}: {}", contained(&one).len());
        assert_eq!(one.sheets()[0].x, run(&alone, 1).sheets()[0].x, "{policy}");
        for threads in [1, 2, 3] {
            let again = run(&both, threads);
            assert_eq!(state_hash(&again), state_hash(&one), "{policy} on {threads} threads");
            assert_eq!(again.events(), one.events(), "{policy} on {threads} threads");
        }
    }
}

#[test]
fn the_detector_has_no_effect_on_a_stable_sheet() {
    for name in shipped_scene_names() {
        let scene = shipped_scene(&name);
        if scene.engine.info().implicit || scene.sheets.is_empty() {
            continue;
        }
        let run = |policy: WhenUnstable| {
            let mut scene = scene.clone();
            scene.sheets.iter_mut().for_each(|s| s.when_unstable = policy);
            let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
            steps(&mut world, 400);
            world
        };
        let (plain, watched) = (run(WhenUnstable::Stop), run(WhenUnstable::ReduceStep { parts: 64 }));
        let alarms: Vec<_> = contained(&watched).iter().map(|e| (e.time_s, e.alarm)).collect();
        assert!(alarms.is_empty(), "{name}: {alarms:?}");
        assert_eq!(state_hash(&plain), state_hash(&watched), "{name}");
    }
}

#[test]
fn slow_growth_is_detected() {
    // Explicit Euler gains 4 % per step at a = 0.2 of the fastest mode, and less in all others, so
    // no single step is conspicuous.
    let mut spec = small_sheet(structure::StructureKind::Samm, 0.0);
    spec.when_unstable = WhenUnstable::Freeze;
    let mut scene = scene_without_gravity(spec, IntegratorKind::Euler);
    scene.dt = 2e-3;
    let mut world = world(&scene);
    excite_randomly(&mut world.sheets_mut()[0], 0.1, 3);
    let before = world.sheets()[0].energy(DVec3::ZERO).total;
    steps(&mut world, 2000);
    let told = contained(&world);
    let alarm = told.first().and_then(|e| e.alarm).expect("seen");
    println!("{before} J at the start, {alarm:?}");
    assert!(alarm.energy_after_j < 4.0 * before && alarm.energy_after_j < 1.1 * alarm.energy_before_j.unwrap_or(0.0));
}

#[test]
fn kinematic_nodes_grabs_and_wind_are_not_detected_as_instability() {
    let mut scene = shipped_scene("wedge");
    let path = vec![
        sheetwork::scene::PathKey::default(),
        sheetwork::scene::PathKey { time: 0.1, offset: DVec3::new(0.005, 0.01, 0.0), rotation: DVec3::ZERO },
    ];
    scene.sheets[0].pins.push(PinSpec { path, ..PinSpec::fixed(Region::Left) });
    scene.sheets[0].when_unstable = WhenUnstable::Freeze;
    scene.air.density = 1.2;
    scene.air.wind = DVec3::new(0.5, 0.0, 0.3);
    let mut world = world(&scene);
    steps(&mut world, 200);
    assert!(contained(&world).is_empty(), "{:?}", contained(&world));
}

#[test]
fn a_snapshot_restores_the_recovery_state() {
    for policy in ["reduce-step", "implicit", "freeze"] {
        let mut world = world(&stiff_wedge(1e5, policy));
        steps(&mut world, 60);
        assert!(!contained(&world).is_empty(), "{policy}");
        let snapshot = world.snapshot();
        let engine = world.sheets()[0].engine();
        steps(&mut world, 60);
        let mut ends = Vec::new();
        for _ in 0..2 {
            // As after a trial of other parameters.
            world.set_engine(IntegratorKind::EulerRichardson);
            world.restore(&snapshot).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(world.sheets()[0].engine(), engine, "{policy}");
            steps(&mut world, 60);
            ends.push((state_hash(&world), world.events().to_vec()));
        }
        assert_eq!(ends[0], ends[1], "{policy}");
    }
}

/// Largest kinetic plus elastic energy (J) of the first sheet in `seconds`, and its initial energy
/// plus that of a fall of the sheet and the dynamic bodies by 0.5 m.
fn largest_and_available_energy(world: &mut World, seconds: f64) -> (f64, f64) {
    let own = |world: &World| {
        let energy = world.sheets()[0].energy(DVec3::ZERO);
        energy.kinetic + energy.elastic
    };
    let weight = world.sheets()[0].total_mass() * 9.81;
    let balls = world.rigid().map_or(0.0, |r| {
        (0..r.bodies().len()).filter_map(|i| r.state(i)).map(|b| b.mass()).filter(|m| m.is_finite()).sum()
    });
    let fall = own(world) + (weight + balls * 9.81) * 0.5;
    let mut most = own(world);
    while world.time() < seconds {
        world.step();
        most = most.max(own(world));
    }
    (most, fall)
}

#[test]
fn no_policy_has_an_energy_error_in_contact() {
    // Impacts on a ball or the floor beyond the stability limit, where an undetected instability
    // would gain a thousand joules.
    let lattice = r#"(engine: "euler-richardson", dt: 0.005, sheets: [(structure: "trimm", grid: (9, 2, 9), size: (0.03, 0.03), gap: 0.001,
        material: (name: "thesis", young: 2e8), node_mass: 4e-5, damping: 0.115, placement: (position: (0.06, 0.05, 0)), when_unstable: "reduce-step 4096")],
        bodies: [(name: "ball", shape: Ball(0.02), density: 100, placement: (position: (0.06, 0.12, 0))), (shape: HalfSpace, placement: (position: (0, -0.1, 0)))])"#;
    let shell = |engine: &str, dt: f64, material: &str, pins: &str| {
        format!(
            r#"(engine: "{engine}", dt: {dt}, sheets: [(structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "{material}",
                placement: (position: (0, 0.3, 0)), {pins} when_unstable: "limit")],
                bodies: [(name: "ball", shape: Ball(0.02), density: 100, placement: (position: (0.05, 0.4, 0))), (shape: HalfSpace)])"#
        )
    };
    let paper = shell("rk4", 0.01, "paper", "pins: [(region: Left, clamp: true)],");
    let rubber = shell("verlet", 0.001, "rubber", "");
    for text in [lattice, &paper, &rubber] {
        let scene = Scene::parse(text).unwrap_or_else(|e| panic!("{e}"));
        let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        let (most, fall) = largest_and_available_energy(&mut world, 1.0);
        assert!(most < 1.5 * fall, "{text}: {most} J, {fall} J by falling");
        assert!(!contained(&world).is_empty() && world.unstable().is_none(), "it is told");
    }
}

#[test]
fn random_sheets_with_a_policy_stay_stable() {
    let engines: Vec<IntegratorKind> = TABLE.iter().filter(|e| !e.adaptive).map(|e| e.kind).collect();
    for seed in 0..60_u64 {
        let mut random = Random::new(seed);
        let mut pick = |n: usize| ((random.signed() * 0.5 + 0.5) * n as f64).min(n as f64 - 1.0) as usize;
        let structure = structure::TABLE[pick(structure::TABLE.len())].kind;
        let (engine, policy) = (engines[pick(engines.len())], POLICIES[pick(4)]);
        let mut spec = small_sheet(structure, 0.1);
        let MaterialChoice::Inline(material) = &mut spec.material else { panic!("in line") };
        material.young *= 10.0_f64.powi(pick(10) as i32 - 2);
        spec.when_unstable = policy.parse().unwrap_or_else(|e| panic!("{e}"));
        spec.placement.position.y = 0.2;
        spec.placement.rotation = DVec3::new(31.0 * pick(8) as f64, 0.0, 17.0);
        let mut scene = scene_without_gravity(spec, engine);
        scene.gravity = DVec3::new(0.0, -9.81, 0.0);
        scene.dt = 1.0 / 60.0 / f64::from(1 << pick(5));
        scene.bodies.push(sheetwork_tests::body(
            "floor",
            sheetwork::scene::Shape::HalfSpace,
            Default::default(),
            vec![],
        ));
        let mut world = world(&scene);
        let (most, fall) = largest_and_available_energy(&mut world, 1.0);
        let sheet = &world.sheets()[0];
        let case = format!("seed {seed}: {engine} on {structure}, {policy}");
        assert!(most < 10.0 * fall, "{case}: {most} J, {fall} J by falling");
        assert!(world.unstable().is_none(), "{case}: {:?}", world.events().last());
        assert!(sheet.x.iter().chain(sheet.v.iter()).all(DVec3::is_finite), "{case}");
    }
}
