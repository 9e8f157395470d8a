//! Wind zones: uniform wind, shelter, wakes, blasts, buoyancy, snapshots, threads, and the cost of
//! a hundred sheets.

use glam::DVec3;
use sheetwork::World;
use sheetwork::journal::{JournalInput, JournalWriter};
use sheetwork::scene::{FluidSpec, Scene, WindZone};
use sheetwork_tests::{shipped_scene, state_hash, world, world_of};

const PAPER: &str = r#"structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "paper""#;

fn run(world: &mut World, steps: usize) -> Vec<u64> {
    let one = |_| {
        world.step();
        state_hash(world)
    };
    (0..steps).map(one).collect()
}

/// Mean velocity of the sheet `index`, m/s.
fn velocity(world: &World, index: usize) -> DVec3 {
    let sheet = &world.sheets()[index];
    sheet.momentum() / sheet.total_mass()
}

/// Mean height of the sheet `index`, m.
fn height(world: &World, index: usize) -> f64 {
    let x = &world.sheets()[index].state.x;
    x.iter().map(|p| p.y).sum::<f64>() / x.len() as f64
}

#[test]
fn a_uniform_zone_equals_the_wind_of_the_scene() {
    for engine in ["tr-bdf2", "euler-cromer"] {
        let (dt, rest) = match engine {
            "tr-bdf2" => (0.01, r#"structure: "shell", grid: (9, 1, 5), material: "pet""#),
            _ => (2e-4, r#"structure: "slamm", grid: (7, 2, 7), material: "thesis", springs: Uniform"#),
        };
        let sheet = format!("sheets: [({rest}, size: (0.2, 0.15), pins: [(region: Left)])]");
        let text = |air: &str| format!("(engine: \"{engine}\", dt: {dt}, {air}, {sheet})");
        let mut one = world_of(&text("air: (density: 1.2, wind: (3, 1, 2))"));
        let mut two = world_of(&text("air: (density: 1.2), wind_zones: [(velocity: (3, 1, 2))]"));
        one.advance(0.3);
        two.advance(0.3);
        let pairs = one.sheets()[0].state.x.iter().zip(two.sheets()[0].state.x.iter());
        let apart = pairs.map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{engine}: {apart}");
    }
}

#[test]
fn a_body_upwind_shelters_a_sheet() {
    let mut world = world_of(&format!(
        "(dt: 0.01, gravity: (0, 0, 0), wind_zones: [(velocity: (0, 0, -5), shelter: 3)],
          sheets: [({PAPER}, placement: (position: (0, 0, 0), rotation: (90, 0, 0))),
                   ({PAPER}, placement: (position: (3, 0, 0), rotation: (90, 0, 0)))],
          bodies: [(shape: Box((1, 1, 0.2)), placement: (position: (0, 0, 1)))])"
    ));
    world.advance(0.1);
    assert!(velocity(&world, 0).length() < 1e-12);
    assert!(velocity(&world, 1).z < -2.0, "{}", velocity(&world, 1));
    let mut open = world.wind_zones().to_vec();
    open[0].shelter = 0.5;
    world.set_wind_zones(&open).expect("valid");
    world.advance(0.1);
    assert!(velocity(&world, 0).z < -2.0, "the body is farther than the shelter reaches");
}

/// Largest height of a sheet of paper on the floor while a ball passes 0.6 m beside it.
fn lifted_by_a_passing_ball(wakes: bool) -> f64 {
    let mut world = world_of(&format!(
        "(dt: 0.01, room: (x: (-9, 9), y: (0, 3), z: (-3, 3), back_wall: false), air: (density: 1.2),
          wind_zones: [(wakes: {wakes})], sheets: [({PAPER}, placement: (position: (0, 0.001, 0)))],
          bodies: [(name: \"train\", shape: Ball(1), placement: (position: (-20, 1.1, 1.2)),
                    path: [(time: 0.5), (time: 1.5, offset: (40, 0, 0))])])"
    ));
    let mut highest = 0.0_f64;
    for _ in 0..300 {
        world.step();
        highest = highest.max(world.sheets()[0].state.x.iter().map(|p| p.y).fold(0.0, f64::max));
    }
    assert!(world.unstable().is_none());
    highest
}

#[test]
fn a_passing_body_lifts_paper_from_the_floor() {
    let (with, without) = (lifted_by_a_passing_ball(true), lifted_by_a_passing_ball(false));
    assert!(without < 0.005, "{without}");
    assert!(with > 0.05, "{with}");
}

#[test]
fn a_blast_gives_a_heavy_sheet_the_impulse_of_its_drag() {
    // A square that faces the blast from 3 m, too heavy to move in the wave.
    let mut world = world_of(
        r#"(dt: 0.01, gravity: (0, 0, 0),
            wind_zones: [(blast: (time: 0.02, overpressure: 6000, radius: 1, duration: 0.004))],
            sheets: [(structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), material: (young: 2e11, density: 7800,
                thickness: 0.002), placement: (position: (0, 3, 0)))])"#,
    );
    world.advance(0.2);
    let u = 6000.0 / (1.2 * 340.0) / 3.0;
    let impulse = 0.5 * 1.2 * 1.17 * 0.01 * u * u * 0.004 * (0.25 - 0.5 * (-2.0_f64).exp());
    let found = world.sheets()[0].momentum().y;
    assert!((found / impulse - 1.0).abs() < 0.02, "{found} {impulse}");
}

#[test]
fn a_sheet_in_water_has_the_acceleration_of_archimedes_and_floats_or_sinks() {
    let scene = |density: f64, dt: f64| {
        format!(
            "(dt: {dt}, wind_zones: [(fluid: (density: 1000, surface: 0))],
              sheets: [(structure: \"shell\", grid: (5, 1, 5), size: (0.1, 0.1),
                  material: (young: 1e9, density: {density}, thickness: 0.002), placement: (position: (0, -0.5, 0)))])"
        )
    };
    for density in [900.0, 1300.0] {
        let mut world = world_of(&scene(density, 1e-4));
        world.advance(2e-3);
        let exact = 9.81 * (1000.0 / density - 1.0) * 2e-3;
        let found = velocity(&world, 0).y;
        assert!((found / exact - 1.0).abs() < 0.02, "{density}: {found} {exact}");
        let mut world = world_of(&scene(density, 0.01));
        world.advance(20.0);
        let end = height(&world, 0);
        assert!(if density < 1000.0 { end.abs() < 0.003 } else { end < -2.0 }, "{density}: {end}");
    }
}

/// Sheets on a line and in the air, in gusts, turbulence, a vortex and the wake of a moving body.
fn mixed() -> Scene {
    let text = format!(
        "(dt: 0.0166666666666667, room: (x: (-2, 2), y: (0, 3), z: (-2, 2), back_wall: false),
          wind_zones: [(velocity: (3, 0, 0), gusts: (amplitude: 1, duration: 0.5, period: 0.8),
                turbulence: (intensity: 1, length: 0.6, seed: 5), shelter: 2, wakes: true),
            (volume: Cylinder(1, 3), falloff: 0.3, vortex: (circulation: 3, core: 0.2)),
            (placement: (position: (0, 0.2, 0)), blast: (time: 0.5, overpressure: 2000, radius: 0.5, duration: 0.005))],
          sheets: [({PAPER}, pins: [(region: Left)], placement: (position: (0, 1, 0))),
                   ({PAPER}, placement: (position: (0.3, 0.5, 0.3))),
                   ({PAPER}, placement: (position: (-0.5, 0.3, 0)), aerodynamics: Plate, velocity: (2, 0, 0))],
          bodies: [(name: \"post\", shape: Box((0.1, 1, 0.1)), placement: (position: (-0.6, 0.5, 0.3))),
                   (name: \"car\", shape: Ball(0.2), placement: (position: (-4, 0.3, 1)),
                    path: [(time: 0), (time: 2, offset: (8, 0, 0))])])"
    );
    Scene::parse(&text).expect("valid")
}

#[test]
fn a_world_with_zones_continues_bit_exactly_from_a_snapshot_and_on_any_number_of_threads() {
    let scene = mixed();
    let mut first = world(&scene);
    run(&mut first, 25);
    let (saved, snapshot) = (first.serialise(), first.snapshot());
    let wanted = run(&mut first, 40);
    let mut fresh = world(&scene);
    fresh.set_threads(3).expect("valid");
    fresh.set_wind_zones(&[]).expect("valid");
    fresh.deserialise(&saved).expect("of this scene");
    assert_eq!(fresh.wind_zones(), first.wind_zones());
    assert_eq!(run(&mut fresh, 40), wanted);
    first.restore(&snapshot).expect("its own");
    assert_eq!(run(&mut first, 40), wanted);
    let mut again = world(&scene);
    assert_eq!(run(&mut again, 65)[25..], wanted);
}

#[test]
fn a_journal_repeats_a_change_of_the_zones_and_a_reset_undoes_it() {
    let file = std::env::temp_dir().join(format!("sheetwork-wind-{}.journal", std::process::id()));
    let mut world = world_of(&format!("(dt: 0.01, air: (density: 1.2), sheets: [({PAPER}, pins: [(region: Left)])])"));
    let mut journal = JournalWriter::create(&file, &world, 5).expect("writable");
    for step in 0..20 {
        if step % 7 == 3 {
            let zones = vec![WindZone { velocity: DVec3::new(0.0, f64::from(step), 1.0), ..WindZone::default() }];
            journal.input(&mut world, JournalInput::SetWindZones { zones }).expect("valid");
        }
        journal.step(&mut world).expect("writable");
    }
    journal.finish().expect("writable");
    let read = sheetwork::journal::Journal::read(&file).expect("readable");
    std::fs::remove_file(&file).expect("there");
    let mut again = read.world(None).expect("valid");
    assert_eq!(read.check(&mut again).expect("applies"), None);
    world.reset().expect("valid");
    assert!(world.wind_zones().is_empty());
}

#[test]
fn zones_out_of_range_are_refused_with_field_and_unit() {
    let parse = |zone: &str| Scene::parse(&format!("(wind_zones: [({zone})])"));
    for (zone, field) in [
        ("velocity: (0, 2000, 0)", "wind_zones.0.velocity.1"),
        ("falloff: -1", "wind_zones.0.falloff"),
        ("volume: Ball(0)", "wind_zones.0.volume"),
        ("gusts: (amplitude: 1, duration: 2, period: 1)", "wind_zones.0.gusts.period"),
        ("turbulence: (intensity: 1, length: 0)", "wind_zones.0.turbulence.length"),
        ("vortex: (circulation: 1, core: 0)", "wind_zones.0.vortex.core"),
        ("blast: (time: 0, overpressure: 2e5, radius: 1, duration: 0.01)", "wind_zones.0.blast.overpressure"),
        ("fluid: (density: 0, surface: 0)", "wind_zones.0.fluid.density"),
        ("placement: (position: (1e9, 0, 0))", "wind_zones.0.placement.position.0"),
    ] {
        let error = parse(zone).expect_err(zone);
        assert_eq!(error.field, field, "{error}");
    }
    let mut world = world(&mixed());
    let before = world.wind_zones().to_vec();
    let fluid = Some(FluidSpec { density: f64::NAN, surface: 0.0 });
    let error = world.set_wind_zones(&[WindZone { fluid, ..WindZone::default() }]).expect_err("not finite");
    assert!(error.to_string().contains("kg/m³"), "{error}");
    assert_eq!(world.wind_zones(), before);
}

#[test]
fn a_sheet_that_sleeps_wakes_in_a_gust() {
    let mut world = world_of(&format!(
        "(dt: 0.0166666666666667, room: (x: (-2, 2), y: (0, 3), z: (-2, 2), back_wall: false),
          wind_zones: [(volume: Box((4, 4, 4)), velocity: (0.01, 0.01, 0))],
          sheets: [({PAPER}, placement: (position: (0, 0.002, 0)))])"
    ));
    world.advance(6.0);
    assert!(world.is_resting());
    let mut zones = world.wind_zones().to_vec();
    zones[0].blast = Some(sheetwork::scene::BlastSpec { time: 15.0, overpressure: 3e3, radius: 1.0, duration: 0.01 });
    world.set_wind_zones(&zones).expect("valid");
    world.advance(8.5);
    assert!(world.is_resting(), "before the blast");
    world.advance(0.6);
    assert!(!world.is_resting(), "after the blast");
}

#[test]
fn shipped_scenes_of_the_air_stay_stable_and_show_what_they_say() {
    let after = |name: &str, seconds: f64| {
        let mut world = world(&shipped_scene(name));
        world.advance(seconds);
        assert!(world.unstable().is_none(), "{name}");
        let deepest = world.penetration();
        println!(
            "{name}: {deepest:.1e} m deep, fastest {:.2} m/s",
            world.sheets().iter().map(sheetwork::Sheet::max_speed).fold(0.0, f64::max)
        );
        assert!(deepest < 1e-4, "{name}: {deepest}");
        world
    };
    let centre = |world: &World, index: usize| world.sheets()[index].centre_of_mass();
    let gliding = after("gliding_card", 1.5);
    assert!(centre(&gliding, 0).y > centre(&gliding, 1).y, "{} {}", centre(&gliding, 0), centre(&gliding, 1));
    assert!(after("gliding_card", 8.0).sheets().iter().all(|sheet| sheet.max_speed() < 1.0));
    let floating = after("floating_film", 10.0);
    assert!(centre(&floating, 0).y.abs() < 0.02 && centre(&floating, 1).y < -0.2);
    let gusty = after("paper_in_gusts", 1.0);
    let lean = |index: usize| centre(&gusty, index).z;
    assert!(lean(0) > lean(2) + 0.005, "{} {}", lean(0), lean(2));
    let blown = after("explosion", 0.3);
    assert!((0..6).all(|index| centre(&blown, index).with_y(0.0).length() > 0.75));
    let flying = after("passing_train", 2.5);
    assert!((0..4).any(|index| centre(&flying, index).y > 0.1));
    after("paper_storm", 1.0);
}
