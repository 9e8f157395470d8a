//! Heat: conduction, radiation and cooling against closed forms and quadrature, softening and
//! setting, curling, hot bodies, shadows, random histories, and steps without allocation.

use allocation_counter::measure as count;
use glam::DVec3;
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{
    HeatMode, HeaterSpec, HotFaceSpec, Material, MaterialChoice, OvenSpec, PinSpec, Placement, Region, Scene, Shape,
    SheetSpec, SpringLaw, material,
};
use sheetwork::sheet::temperature::Softening;
use sheetwork::units::temperature::{STEFAN_BOLTZMANN, ZERO_CELSIUS};
use sheetwork_rigs::measure::{Setup, Thermal, measure};
use sheetwork_tests::{Random, body, shipped_scene, world};

/// (T - T₀)/(T₁ - T₀) of a slab with a temperature step on one side and insulation on the other, by
/// its series (Carslaw and Jaeger, *Conduction of Heat in Solids*, 3.4).
fn slab(x: f64, fourier: f64) -> f64 {
    let term = |n: i32| {
        let q = (f64::from(n) + 0.5) * std::f64::consts::PI;
        2.0 / q * (q * x).sin() * (-q * q * fourier).exp()
    };
    1.0 - (0..60).map(term).sum::<f64>()
}

/// Profile along a sheet of `columns` nodes, and its loss of heat when insulated.
fn conducted(columns: u32, fourier: f64) -> (Vec<f64>, f64) {
    let thermal = Thermal { fourier, ..Thermal::default() };
    let found = measure("conduction", &Setup { grid: (columns, 5), thermal, ..Setup::default() }).expect("valid");
    let profile = found["profile"].as_array().expect("a list").iter().filter_map(|v| v.as_f64()).collect();
    (profile, found["heat_lost"].as_f64().expect("a number"))
}

#[test]
fn conduction_along_a_sheet_equals_that_of_a_slab() {
    for (x, wanted) in [(0.1, 0.823_082), (0.25, 0.576_241), (0.5, 0.264_349), (0.75, 0.098_721), (1.0, 0.050_695)] {
        assert!((slab(x, 0.1) - wanted).abs() < 1e-6);
    }
    for fourier in [0.03, 0.1, 0.4] {
        let mut errors = Vec::new();
        for columns in [11, 21, 41] {
            let (profile, lost) = conducted(columns, fourier);
            assert!(lost.abs() < 1e-12, "{lost} lost");
            let at = |i: usize| i as f64 / f64::from(columns - 1);
            let off = profile.iter().enumerate().map(|(i, t)| (t - slab(at(i), fourier)).abs());
            errors.push(off.fold(0.0, f64::max));
        }
        assert!(errors[2] < 1e-3, "{errors:?}");
        assert!(errors[0] / errors[1] > 3.5 && errors[1] / errors[2] > 3.5, "second order: {errors:?}");
    }
    let (profile, _) = conducted(41, 0.1);
    for (i, t) in profile.iter().enumerate() {
        let wanted = slab(i as f64 / 40.0, 0.1);
        assert!((t / wanted - 1.0).abs() < 5e-3, "{t}, not {wanted}");
    }
}

/// Time (s) from one temperature to another by quadrature of ρ c t dT/(q(T)), Simpson's rule.
fn time_by_quadrature(m: &Material, (from, to, ambient): (f64, f64, f64), convection: f64) -> f64 {
    let fourth = |c: f64| (c + ZERO_CELSIUS).powi(4);
    let loss =
        |t: f64| 2.0 * m.emissivity * STEFAN_BOLTZMANN * (fourth(t) - fourth(ambient)) + convection * (t - ambient);
    let n = 2000;
    let h = (from - to) / f64::from(n);
    let weight = |i: i32| {
        if i == 0 || i == n {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    let sum: f64 = (0..=n).map(|i| weight(i) / loss(to + h * f64::from(i))).sum();
    m.density * m.specific_heat * m.thickness * sum * h / 3.0
}

fn cooled(material: Material, thermal: Thermal, dt: Option<f64>) -> f64 {
    let found = measure("cooling", &Setup { material, thermal, dt, ..Setup::default() }).expect("valid");
    found["time_s"].as_f64().expect("it gets there")
}

#[test]
fn cooling_times_equal_the_integral_of_the_losses() {
    let hips = material::by_name("hips").expect("there");
    assert!((time_by_quadrature(&hips, (120.0, 60.0, 20.0), 0.0) - 43.79).abs() < 0.01);
    for name in ["hips", "packaging-pvc", "steel-foil", "rubber"] {
        let m = material::by_name(name).expect("there");
        for (from, to, ambient, convection) in
            [(120.0, 60.0, 20.0, 0.0), (200.0, 21.0, 20.0, 12.0), (-20.0, 70.0, 90.0, 5.0)]
        {
            let wanted = time_by_quadrature(&m, (from, to, ambient), convection);
            let thermal = Thermal { from: Some(from), to, ambient, convection, ..Thermal::default() };
            let found = cooled(m.clone(), thermal, None);
            assert!((found / wanted - 1.0).abs() < 1e-3, "{name} from {from} to {to}: {found}, not {wanted}");
        }
    }
    // The steps of a time lapse with a factor of a hundred.
    let thermal = Thermal::default();
    let found = cooled(hips, thermal, Some(100.0 / 60.0 * 0.5));
    assert!((found / 43.79 - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn convective_cooling_is_exponential() {
    let m = Material { emissivity: 0.0, ..material::by_name("pet").expect("there") };
    let wanted = m.density * m.specific_heat * m.thickness / 8.0 * 4.0_f64.ln();
    let thermal = Thermal { from: Some(100.0), to: 40.0, ambient: 20.0, convection: 8.0, ..Thermal::default() };
    let found = cooled(m, thermal, None);
    assert!((found / wanted - 1.0).abs() < 1e-4, "{found}, not {wanted}");
}

#[test]
fn a_heated_sheet_reaches_its_radiative_balance() {
    let m = material::by_name("pvc").expect("there");
    for (heater, view, seconds, ambient) in
        [(400.0, 0.5, 20.0, 20.0), (250.0, 0.9, 60.0, 30.0), (600.0, 0.1, 200.0, 0.0)]
    {
        let fourth = |c: f64| (c + ZERO_CELSIUS).powi(4);
        let rate = |t: f64| {
            let taken = view * fourth(heater) + (2.0 - view) * fourth(ambient) - 2.0 * fourth(t);
            m.emissivity * STEFAN_BOLTZMANN * taken / (m.density * m.specific_heat * m.thickness)
        };
        let (mut wanted, h) = (ambient, seconds / 20_000.0);
        for _ in 0..20_000 {
            let half = wanted + 0.5 * h * rate(wanted);
            wanted += h * rate(half);
        }
        let thermal = Thermal { heater, view, seconds: Some(seconds), ambient, ..Thermal::default() };
        let setup = Setup { material: m.clone(), grid: (5, 5), thermal, ..Setup::default() };
        let found = measure("radiate", &setup).expect("valid")["temperature_c"].as_f64().expect("a number");
        assert!((found - wanted).abs() < 1e-3 * (wanted - ambient), "{found}, not {wanted}");
    }
}

#[test]
fn the_droop_of_a_warm_sheet_follows_its_modulus() {
    let hips = material::by_name("hips").expect("there");
    for celsius in [20.0, 60.0, 95.0, 103.0] {
        let young = hips.young * Softening::of(&hips).fraction(celsius);
        let cold = Setup { material: Material { young, ..hips.clone() }, length: 0.1, width: 0.1, ..Setup::default() };
        let thermal = Thermal { celsius: Some(celsius), ..Thermal::default() };
        let warm = Setup { material: hips.clone(), thermal, ..cold.clone() };
        let wanted = measure("cantilever", &cold).expect("valid")["drop_m"].as_f64().expect("a number");
        let found = measure("softening", &warm).expect("valid");
        assert!((found["young_pa"].as_f64().expect("a number") / young - 1.0).abs() < 1e-12);
        let droop = found["droop_m"].as_f64().expect("a number");
        assert!((droop / wanted - 1.0).abs() < 1e-6, "{droop}, not {wanted} at {celsius}");
    }
}

/// A polystyrene sheet of `structure` with these pins.
fn sheet(structure: StructureKind, pins: Vec<PinSpec>) -> SheetSpec {
    SheetSpec {
        structure,
        grid: (9, if structure == StructureKind::Shell { 1 } else { 2 }, 5),
        size: (0.16, 0.08),
        material: "hips".into(),
        springs: SpringLaw::Calibrated,
        damping_ratio: Some(0.5),
        pins,
        ..SheetSpec::default()
    }
}

fn scene(sheet: SheetSpec) -> Scene {
    Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, sheets: vec![sheet], ..Scene::default() }
}

#[test]
fn a_scene_without_heat_has_no_temperatures() {
    let mut cold = world(&scene(sheet(StructureKind::Shell, vec![])));
    cold.advance(0.1);
    assert!(cold.sheets()[0].heat().is_none() && cold.sheets()[0].temperatures().is_none());
    let report = cold.report(0.0, &[]).sheets[0].temperature_c;
    assert_eq!((report.min, report.mean, report.max), (20.0, 20.0, 20.0));
    assert!(cold.parameters().iter().all(|p| p.path != "ambient_temperature"));
}

#[test]
fn a_sheet_that_sags_in_an_oven_keeps_its_shape_and_gains_no_energy() {
    let ends = vec![PinSpec::clamped(Region::Left), PinSpec::clamped(Region::Right)];
    for structure in [StructureKind::Shell, StructureKind::DoubleDiagonal] {
        let mut scene = scene(sheet(structure, ends.clone()));
        // Without expansion, because a sheet that expands between its clamps gains height from
        // heat.
        let hips = Material { expansion: 0.0, ..material::by_name("hips").expect("there") };
        scene.sheets[0].material = MaterialChoice::Inline(hips);
        scene.oven = Some(OvenSpec { temperature: 140.0, on: false, ..OvenSpec::default() });
        scene.time_lapse = 40.0;
        let mut world = world(&scene);
        let start = world.energy().total;
        let sag = |w: &World| w.sheets()[0].state.x.y.iter().fold(0.0, |low: f64, y| low.min(*y));
        let mut before = start;
        let mut watch = |world: &mut World, seconds: f64| {
            for _ in 0..(seconds * 60.0) as u32 {
                world.step();
                let now = world.energy().total;
                let scale = 1e-9 + 1e-6 * start.abs();
                assert!(now <= before + scale, "{structure}: {before} to {now} J at {} s", world.time());
                before = now;
            }
        };
        watch(&mut world, 1.0);
        let cold = sag(&world);
        world.set("oven.on", "true").expect("an oven");
        watch(&mut world, 9.0);
        let hot = sag(&world);
        assert!(hot < 2.0 * cold && hot < -1e-3, "{structure}: it sags from {cold} to {hot}");
        world.set("oven.on", "false").expect("an oven");
        watch(&mut world, 12.0);
        let celsius = world.sheets()[0].temperatures().expect("warm")[0];
        assert!((celsius - 20.0).abs() < 5.0, "{celsius}");
        let kept = sag(&world);
        assert!((kept / hot - 1.0).abs() < 0.05, "{structure}: {hot} hot, {kept} cold again");
    }
}

#[test]
fn a_sheet_that_is_heated_on_one_side_curls_away() {
    let pins = vec![PinSpec::clamped(Region::Left)];
    let mut scene = scene(SheetSpec { temperature_gradient: true, ..sheet(StructureKind::Shell, pins) });
    scene.gravity = DVec3::ZERO;
    let thick = Material { thickness: 2e-3, ..material::by_name("hips").expect("there") };
    scene.sheets[0].material = MaterialChoice::Inline(thick.clone());
    scene.heaters = vec![HeaterSpec {
        name: "lamp".into(),
        file: None,
        polyhedron: None,
        size: Some(DVec3::new(4.0, 0.1, 4.0)),
        hot: vec![HotFaceSpec { face: 2, temperature: 300.0, emissivity: 1.0 }],
        on: true,
        placement: Placement { position: DVec3::new(0.0, 0.3, 0.0), ..Placement::default() },
    }];
    let mut world = world(&scene);
    world.advance(12.0);
    let sheet = &world.sheets()[0];
    let (lower, upper) = sheet.heat().and_then(|h| h.halves()).expect("two halves");
    let middle = 2 * 9 + 4;
    let difference = upper[middle] - lower[middle];
    assert!(difference > 3.0, "{difference} K");
    // The two sides are half a thickness apart: κ = α ΔT/(t/2); the tip of a clamped strip then
    // drops by κ L²/2.
    let curvature = 2.0 * thick.expansion * difference / thick.thickness;
    let tip = sheet.state.x.get(2 * 9 + 8).y;
    let wanted = -0.5 * curvature * 0.16 * 0.16;
    assert!((tip / wanted - 1.0).abs() < 0.08, "{tip}, not {wanted}");
    assert!(upper[middle] < 80.0, "still stiff");
}

#[test]
fn a_sheet_on_a_hot_body_reaches_the_balance_of_contact_and_losses() {
    let mut scene = scene(sheet(StructureKind::Shell, vec![]));
    scene.sheets[0].placement.position.y = 2.6e-4;
    scene.time_lapse = 50.0;
    scene.bodies.push(sheetwork::scene::BodySpec {
        temperature: Some(70.0),
        ..body(
            "plate",
            Shape::Box(DVec3::new(1.0, 0.1, 1.0)),
            Placement { position: DVec3::new(0.0, -0.05, 0.0), ..Placement::default() },
            vec![],
        )
    });
    let mut world = world(&scene);
    world.advance(6.0);
    let m = material::by_name("hips").expect("there");
    // Both sides exchange heat with the room.
    let fourth = |c: f64| (c + ZERO_CELSIUS).powi(4);
    let balance = |t: f64| {
        500.0 * (70.0 - t) - 10.0 * (t - 20.0) - 2.0 * m.emissivity * STEFAN_BOLTZMANN * (fourth(t) - fourth(20.0))
    };
    let (mut low, mut high) = (20.0, 70.0);
    for _ in 0..60 {
        let t = 0.5 * (low + high);
        if balance(t) > 0.0 { low = t } else { high = t }
    }
    let found = world.sheets()[0].temperatures().expect("warm");
    for t in found {
        assert!((t - low).abs() < 1.0, "{t}, not {low}");
    }
}

#[test]
fn an_added_hot_body_heats_the_sheet_on_it() {
    let mut spec = sheet(StructureKind::Shell, vec![]);
    spec.placement.position.y = 0.0503;
    let mut world =
        world(&Scene { dt: 1.0 / 60.0, engine: IntegratorKind::TrBdf2, sheets: vec![spec], ..Scene::default() });
    let plate = sheetwork::scene::BodySpec {
        temperature: Some(90.0),
        ..body("plate", Shape::Box(DVec3::new(1.0, 0.1, 1.0)), Placement::default(), vec![])
    };
    let plate = world.add_body(&plate).expect("valid");
    let name = world.body_name(plate).expect("there").to_owned();
    world.advance(1.0);
    let warm = world.sheets()[0].temperatures().expect("warm")[0];
    assert!(warm > 40.0, "{warm}");
    world.set(&format!("bodies.{name}.temperature"), "0").expect("there");
    world.advance(3.0);
    let cold = world.sheets()[0].temperatures().expect("warm")[0];
    assert!(cold < 15.0, "{cold}");
}

#[test]
fn a_body_before_a_heater_throws_a_shadow() {
    let lit = |with_body: bool| {
        let mut scene = scene(sheet(StructureKind::Shell, vec![PinSpec::fixed(Region::All)]));
        scene.sheets[0].grid = (17, 1, 9);
        scene.heaters = vec![HeaterSpec {
            name: String::new(),
            file: None,
            polyhedron: None,
            size: Some(DVec3::new(0.01, 0.002, 0.01)),
            hot: vec![HotFaceSpec { face: 2, temperature: 900.0, emissivity: 1.0 }],
            on: true,
            placement: Placement { position: DVec3::new(-0.05, 0.05, 0.0), ..Placement::default() },
        }];
        if with_body {
            let place = Placement { position: DVec3::new(-0.05, 0.025, 0.0), ..Placement::default() };
            scene.bodies.push(body("screen", Shape::Box(DVec3::new(0.04, 0.002, 0.06)), place, vec![]));
        }
        let mut world = world(&scene);
        world.advance(1.0);
        let sheet = &world.sheets()[0];
        let under = 4 * 17 + 3;
        (sheet.temperatures().expect("warm")[under], sheet.temperatures().expect("warm")[4 * 17 + 16])
    };
    let (bright, shaded) = (lit(false), lit(true));
    assert!(bright.0 > 20.5, "{bright:?}");
    assert!(shaded.0 < 20.01, "{shaded:?}");
    assert!(bright.1 > 20.001 && (shaded.1 / bright.1 - 1.0).abs() < 0.01, "{bright:?} {shaded:?}");
}

#[test]
fn the_thesis_heat_model_softens_by_its_formula() {
    let spec = SheetSpec { pins: vec![PinSpec::fixed(Region::Left)], node_mass: Some(4e-5), ..SheetSpec::thesis() };
    let mut scene = Scene { dt: 2e-3, gravity: DVec3::new(0.0, -0.981, 0.0), sheets: vec![spec], ..Scene::thesis() };
    scene.heat_mode = HeatMode::Thesis { sensitivity: 0.1, conductivity: 0.0 };
    scene.oven = Some(OvenSpec { temperature: 21.0, ..OvenSpec::default() });
    let mut world = world(&scene);
    let stiff = world.sheets()[0].springs().stiffness.clone();
    world.advance(0.1);
    for (soft, stiff) in world.sheets()[0].springs().stiffness.iter().zip(stiff) {
        assert!((soft / stiff - (1.0 - 0.1 / 0.185)).abs() < 1e-12, "{soft} of {stiff}");
    }
}

#[test]
fn the_thesis_heat_model_follows_the_heater_its_switch_and_the_material() {
    // Least remaining stiffness of a spring.
    let softest = |settings: &[(&str, &str)]| {
        let mut world = world(&shipped_scene("heater_wedge"));
        let stiff = world.sheets()[0].springs().stiffness.clone();
        for (path, value) in settings {
            world.set(path, value).expect("a parameter of this scene");
        }
        world.advance(2.0);
        let soft = &world.sheets()[0].springs().stiffness;
        soft.iter().zip(stiff).fold(1.0, |least: f64, (soft, stiff)| least.min(soft / stiff))
    };
    let given = softest(&[]);
    assert!(given < 0.99, "{given}");
    assert!(softest(&[("heaters.panel.temperature", "1000")]) < given - 0.01);
    assert_eq!(softest(&[("heaters.panel.temperature", "20")]), 1.0);
    assert_eq!(softest(&[("heaters.panel.on", "false")]), 1.0);
    assert_eq!(softest(&[("sheets.sheet.material.thesis_sensitivity", "0")]), 1.0);
    assert_ne!(softest(&[("sheets.sheet.material.thesis_conductivity", "0")]), given);
}

/// Length of a row of the bottom layer from the ridge of the wedge to either edge, over that at the
/// start: left, right.
fn arms(world: &World, rest: Option<[f64; 2]>) -> [f64; 2] {
    let sheet = &world.sheets()[0];
    let layer = &sheet.model.layers[0];
    let row: Vec<DVec3> = (0..layer.nx).map(|i| sheet.state.x.get(layer.at(i, layer.nz / 2) as usize)).collect();
    let (left, right) = row.split_at(layer.nx as usize / 2);
    let length = |part: &[DVec3]| part.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
    let now = [length(left), length(right)];
    [0, 1].map(|i| now[i] / rest.map_or(1.0, |rest| rest[i]))
}

#[test]
fn a_heater_to_the_right_extends_the_right_side_of_a_sheet_on_a_wedge() {
    let scene = shipped_scene("heater_wedge");
    let run = |heated: bool| {
        let mut world = world(&scene);
        let rest = arms(&world, None);
        world.set("heaters.panel.on", if heated { "true" } else { "false" }).expect("a switch");
        world.advance(scene.duration);
        arms(&world, Some(rest))
    };
    let (cold, hot) = (run(false), run(true));
    // Thesis figure 5.25, d to f: the right side extends, the left stays.
    assert!(hot[1] / cold[1] > 1.1 && hot[0] / cold[0] < 1.05, "cold {cold:?}, hot {hot:?}");
}

#[test]
fn a_thousand_random_heat_histories_are_stable() {
    let mut random = Random::new(7);
    let mut draw = |low: f64, high: f64| low + (high - low) * 0.5 * (1.0 + random.signed());
    let structures = [
        StructureKind::Shell,
        StructureKind::Shell,
        StructureKind::DoubleDiagonal,
        StructureKind::Trimm,
        StructureKind::Samm,
    ];
    for history in 0..1000 {
        let structure = structures[draw(0.0, 4.999) as usize];
        let mut spec =
            sheet(structure, vec![PinSpec::clamped(if history % 2 == 0 { Region::Left } else { Region::Back })]);
        spec.grid = (5, spec.grid.1, 4);
        spec.damping_ratio = None;
        spec.temperature_gradient = structure == StructureKind::Shell && history % 3 == 0;
        let mut scene = scene(spec);
        scene.time_lapse = 10.0_f64.powf(draw(-1.0, 2.5));
        scene.oven = Some(OvenSpec::default());
        let mut world = world(&scene);
        let (mut coldest, mut hottest) = (20.0_f64, 20.0_f64);
        for _ in 0..4 {
            let celsius = draw(-50.0, 250.0);
            (coldest, hottest) = (coldest.min(celsius), hottest.max(celsius));
            world.set("oven.temperature", &celsius.to_string()).expect("an oven");
            (0..10).for_each(|_| _ = world.step());
        }
        assert!(world.unstable().is_none(), "history {history}, {structure}");
        let celsius = world.sheets()[0].temperatures().expect("warm");
        assert!(celsius.iter().all(|t| (coldest - 1.0..hottest + 1.0).contains(t)), "history {history}");
    }
}

#[test]
fn a_warm_step_with_heat_allocates_nothing() {
    for structure in [StructureKind::Shell, StructureKind::Trimm] {
        let mut scene = scene(sheet(structure, vec![PinSpec::clamped(Region::Left)]));
        scene.sheets[0].temperature_gradient = structure == StructureKind::Shell;
        scene.oven = Some(OvenSpec { temperature: 120.0, ..OvenSpec::default() });
        scene.heat_gun = Some(Default::default());
        scene.heaters = vec![HeaterSpec {
            name: String::new(),
            file: None,
            polyhedron: None,
            size: Some(DVec3::new(0.1, 0.02, 0.1)),
            hot: (0..6).map(|face| HotFaceSpec { face, temperature: 300.0, emissivity: 0.9 }).collect(),
            on: true,
            placement: Placement { position: DVec3::new(0.0, 0.1, 0.0), ..Placement::default() },
        }];
        scene.bodies.push(sheetwork::scene::BodySpec {
            temperature: Some(90.0),
            ..body(
                "ball",
                Shape::Ball(0.04),
                Placement { position: DVec3::new(0.05, -0.06, 0.0), ..Placement::default() },
                vec![],
            )
        });
        let mut world = world(&scene);
        (0..60).for_each(|_| _ = world.step());
        let counted = count(|| (0..60).for_each(|_| _ = world.step()));
        assert!(world.unstable().is_none());
        assert_eq!(counted.count_total, 0, "{structure}");
    }
}

#[test]
fn a_vacuum_draws_a_hot_sheet_over_a_mould_and_it_keeps_the_shape() {
    let mut scene = shipped_scene("vacuum_forming");
    scene.sheets[0].grid = (13, 1, 13);
    let mut world = world(&scene);
    let (frame, ball) = (scene.sheets[0].placement.position.y, 0.05);
    let low = |w: &World| w.sheets()[0].state.x.y.iter().fold(frame, |low: f64, y| low.min(*y));
    world.advance(1.9);
    assert!(low(&world) > frame - 0.01, "softened only: {}", low(&world));
    world.advance(4.05);
    let (drawn, formed) = (low(&world), world.sheets()[0].state.x.clone());
    assert!(drawn < frame - 0.012, "{drawn}");
    let on_mould = formed.iter().filter(|p| p.length() < ball + 2e-3).count();
    assert!(on_mould >= 21, "{on_mould} masses lie on the mould");
    world.advance(1.05);
    assert!(world.sheets()[0].pressure() == 0.0 && world.sheets()[0].temperatures().is_some_and(|t| t[0] < 40.0));
    let kept = low(&world);
    assert!(((frame - kept) / (frame - drawn) - 1.0).abs() < 0.05, "drawn to {drawn}, kept {kept}");
    // Released from the mould, the sheet springs further: it has shrunk between frame and mould.
    let most = formed.iter().zip(world.sheets()[0].state.x.iter()).map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
    assert!(most < 0.1 * (frame - drawn), "sprang back by {most} m of {}", frame - drawn);
    assert!(world.penetration() < 1e-4);
}
