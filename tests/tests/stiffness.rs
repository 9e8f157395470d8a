//! Stiffness of sheets given by E, ν, thickness and density, against closed forms, published tables
//! and converged references. The tests cover every documented number.

use serde_json::Value;
use sheetwork::World;
use sheetwork::material::elastica::elastica;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{Material, MaterialChoice, PinSpec, PressureKey, Region, Scene, SheetSpec};
use sheetwork_rigs::measure::kicks::kick;
use sheetwork_rigs::measure::{Boundary, Setup};
use sheetwork_tests::rig::{measured, number};

/// A sheet of 0.25 m, 0.5 mm, 3 GPa, 1050 kg/m³.
fn sheet(grid: u32, poisson: f64) -> Setup {
    let base = Setup::default();
    Setup { grid: (grid, grid), material: Material { poisson, ..base.material.clone() }, ..base }
}

fn numbers(found: &Value, key: &str) -> Vec<f64> {
    let list = found[key].as_array().unwrap_or_else(|| panic!("{key} in {found}"));
    list.iter().filter_map(Value::as_f64).collect()
}

/// √(D/ρt) of a setup's sheet, m²/s.
fn speed(setup: &Setup) -> f64 {
    (setup.material.plate_stiffness() / setup.material.areal_mass()).sqrt()
}

fn close(what: &str, got: f64, wanted: f64, percent: f64) {
    let off = 100.0 * (got / wanted - 1.0);
    println!("{what}: {got:.6} against {wanted:.6}, {off:+.3} % (bound {percent} %)");
    assert!(off.abs() <= percent, "{what}: {got} is {off:+.3} % from {wanted}, more than {percent} %");
}

/// The sheet with the length that gives the load parameter Γ = ρ g t L³/D, at ν = 0.
fn hanging(grid: u32, gamma: f64) -> Setup {
    let mut setup = sheet(grid, 0.0);
    let weight = setup.material.areal_mass() * setup.gravity;
    setup.length = (gamma * setup.material.plate_stiffness() / weight).cbrt();
    setup.width = setup.length;
    setup
}

#[test]
fn the_shell_droops_like_the_elastica() {
    for (gammas, bounds) in
        [(&[0.1, 1.0, 3.0][..], [0.2, 0.05]), (&[10.0, 20.0][..], [0.4, 0.1]), (&[100.0][..], [1.0, 0.15])]
    {
        for gamma in gammas {
            for (grid, bound) in [11, 21].into_iter().zip(bounds) {
                let setup = hanging(grid, *gamma);
                let found = measured("cantilever", &setup);
                let wanted = elastica(*gamma).0 * setup.length;
                close(&format!("Γ {gamma}, {grid}"), number(&found, "drop_m"), wanted, bound);
                assert!(found["linear_solves"].as_u64() <= Some(10), "{found}");
                assert_eq!(found["settled"], true);
            }
        }
    }
}

#[test]
fn refining_the_grid_converges_with_order_two() {
    let wanted = sheet(0, 0.0);
    let weight = wanted.material.areal_mass() * wanted.gravity;
    let gamma = weight * 0.25_f64.powi(3) / wanted.material.plate_stiffness();
    let exact = 0.25 * elastica(gamma).0;
    let errors = [11, 21, 41].map(|n| (number(&measured("cantilever", &sheet(n, 0.0)), "drop_m") / exact - 1.0).abs());
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        println!("errors {errors:?}, order {order:.2}");
        assert!(order >= 1.9, "order {order}");
    }
}

#[test]
fn equilibrium_takes_few_linear_solves_at_any_grid() {
    for grid in [6, 11, 21, 41, 81] {
        let found = measured("cantilever", &sheet(grid, 0.35));
        assert!(found["linear_solves"].as_u64() <= Some(10), "{found}");
        assert_eq!(found["settled"], true);
    }
}

#[test]
fn the_shell_vibrates_like_beams_and_plates() {
    let frequency = |grid: u32, poisson: f64, boundary: Boundary| {
        let setup = Setup { boundary, ..sheet(grid, poisson) };
        let unit = speed(&setup) / (setup.length * setup.length);
        numbers(&measured("frequency", &setup), "omega_rad_s").into_iter().map(move |w| w / unit).collect::<Vec<f64>>()
    };
    for (grid, bound) in [(11, 0.5), (21, 0.15)] {
        close("cantilever beam", frequency(grid, 0.0, Boundary::Cantilever)[0], 1.875_104_f64.powi(2), bound);
    }
    // Leissa, "The free vibration of rectangular plates", J. Sound Vib. 31, 1973, with later
    // refinements (ν = 0.3).
    for (boundary, wanted) in [
        (Boundary::Cantilever, [3.471, 8.507, 21.285]),
        (Boundary::Free, [13.468, 19.596, 24.270]),
        (Boundary::Clamped, [35.985, 73.394, 73.394]),
        (Boundary::Supported, [19.739, 49.348, 49.348]),
    ] {
        let found = frequency(21, 0.3, boundary);
        for (got, wanted) in found.iter().zip(wanted) {
            close(boundary.name(), *got, wanted, 1.5);
        }
    }
}

#[test]
fn the_simulated_frequency_equals_the_linear_one() {
    let found = measured("frequency", &sheet(21, 0.0));
    close("as it moves", number(&found, "omega_motion_rad_s"), numbers(&found, "omega_rad_s")[0], 0.3);
}

#[test]
fn sheets_with_an_outline_have_the_requested_stiffness() {
    let exact = number(&measured("cantilever", &sheet(11, 0.0)), "reference_drop_m");
    let outlined = Setup { outlined: true, ..sheet(21, 0.0) };
    close("outlined cantilever", number(&measured("cantilever", &outlined), "drop_m"), exact, 0.2);
    for (grid, bound) in [(21, 1.0), (41, 0.25)] {
        let setup = Setup { boundary: Boundary::Clamped, modes: 1, ..sheet(grid, 0.35) };
        let wanted = 10.2158 * speed(&setup) / (setup.radius * setup.radius);
        close("clamped disc", numbers(&measured("disc", &setup), "omega_rad_s")[0], wanted, bound);
    }
    // A square with a round hole of 0.4 of its side, ν = 0.3: converged on meshes of 101 nodes
    // across.
    for (boundary, lambda) in [(Boundary::Supported, 20.43), (Boundary::Clamped, 45.47)] {
        for (grid, bound) in [(21, 1.0), (41, 0.25)] {
            let setup = Setup { boundary, modes: 1, ..sheet(grid, 0.3) };
            let wanted = lambda * speed(&setup) / (setup.length * setup.length);
            close("hole", numbers(&measured("hole", &setup), "omega_rad_s")[0], wanted, bound);
        }
    }
}

#[test]
fn calibrated_lattices_bend_like_their_material() {
    let poisson = 1.0 / 3.0;
    let fine = sheet(41, poisson);
    let drop = number(&measured("cantilever", &fine), "drop_m");
    let omega = numbers(&measured("frequency", &Setup { modes: 1, ..fine }), "omega_rad_s")[0];
    for structure in [StructureKind::Trimm, StructureKind::DoubleDiagonal] {
        let setup = Setup { structure, modes: 1, ..sheet(21, poisson) };
        let found = measured("stiffness", &setup);
        for bending in numbers(&found, "bending_0_45_90_135") {
            close("homogenised bending", bending, 1.0, 0.5);
        }
        close("tip", number(&measured("cantilever", &setup), "drop_m"), drop, 2.2);
        close("first frequency", numbers(&measured("frequency", &setup), "omega_rad_s")[0], omega, 0.5);
    }
}

#[test]
fn anisotropic_structures_are_reported() {
    for structure in [StructureKind::Samm, StructureKind::Slamm, StructureKind::Provot2d] {
        let found = measured("stiffness", &Setup { structure, ..sheet(11, 0.35) });
        assert!(found["notes"].as_array().is_some_and(|n| !n.is_empty()), "{found}");
    }
    assert!(
        number(&measured("stiffness", &Setup { structure: StructureKind::Samm, ..sheet(11, 0.35) }), "twist") < 0.01
    );
}

#[test]
fn an_undamped_sheet_gains_no_energy_and_conserves_angular_momentum() {
    let found = measured("energy", &sheet(11, 0.35));
    assert!(number(&found, "energy_gain") <= 1e-3, "{found}");
    let spun = measured("spin", &sheet(11, 0.35));
    assert!(number(&spun, "angular_momentum_ratio") >= 0.99, "{spun}");
    assert!(number(&spun, "angular_momentum_ratio") <= 1.001, "{spun}");
}

#[test]
fn lateral_buckling_begins_at_the_theoretical_load() {
    // Slender strip: 12.8538 √(2/(1+ν)) (Timoshenko and Gere). A width of a tenth of the length and
    // a coarse grid add a little.
    let setup = Setup { length: 0.4, width: 0.02, grid: (61, 5), ..sheet(11, 0.35) };
    let found = measured("buckling", &setup);
    close("onset", number(&found, "onset_gamma"), 12.8538 * (2.0_f64 / 1.35).sqrt(), 6.0);
}

#[test]
fn kicked_sheets_of_any_material_stay_stable() {
    // A sample; `sheetwork bench kicks` runs a thousand.
    let structures = [StructureKind::Shell, StructureKind::Shell, StructureKind::Trimm, StructureKind::DoubleDiagonal];
    for index in 0..60 {
        let found = kick(index, &structures, 1.0).expect("a valid draw");
        assert_eq!(found.unstable, None, "{found:?}");
        assert!(found.energy_ratio.is_finite(), "{found:?}");
    }
}

#[test]
fn stiffness_thickness_and_damping_change_without_a_jump() {
    let mut scene = Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, ..Scene::default() };
    scene.sheets = vec![SheetSpec {
        name: "sheet".into(),
        structure: StructureKind::Shell,
        grid: (11, 1, 11),
        size: (0.25, 0.25),
        material: MaterialChoice::Named("hips".into()),
        damping_ratio: Some(0.1),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    }];
    let mut world = World::new(&scene).expect("valid");
    world.set_sleep(false);
    (0..200).for_each(|_| _ = world.step());
    for (path, value) in [
        ("sheets.sheet.material.young", "4e9"),
        ("sheets.sheet.material.thickness", "0.0004"),
        ("sheets.sheet.damping_ratio", "1"),
        ("sheets.sheet.material.young", "1e9"),
    ] {
        let gravity = scene.gravity;
        let before = world.sheets()[0].state.x.clone();
        world.set(path, value).expect("a parameter");
        assert_eq!(world.sheets()[0].state.x, before, "{path} moved the sheet");
        let changed = world.sheets()[0].energy(gravity);
        world.step();
        let sheet = &world.sheets()[0];
        // The released energy accelerates nodes by at most several g; a jump of a node would be
        // larger.
        let moved = (0..sheet.node_count()).map(|i| sheet.state.x.get(i).distance(before.get(i))).fold(0.0, f64::max);
        assert!(moved < 0.01, "{path} = {value}: a mass jumped {moved} m in a step");
        let scale = changed.elastic.abs() + changed.kinetic;
        for _ in 0..60 {
            world.step();
            let rise = world.sheets()[0].energy(gravity).total - changed.total;
            assert!(rise < 1e-3 * scale, "{path} = {value}: energy rose by {rise} J of {scale} J");
        }
    }
}

#[test]
fn a_sheet_reports_its_delivered_stiffness() {
    let found = measured("stiffness", &sheet(21, 0.0));
    close("bends as", number(&found, "bends_as_pa"), 3e9, 0.5);
    // Against the slowest vibration: stiffness is proportional to the square of the frequency.
    for grid in [11, 21] {
        let setup = sheet(grid, 0.0);
        let told = number(&measured("stiffness", &setup), "bends_as_pa");
        let omega = numbers(&measured("frequency", &setup), "omega_rad_s")[0];
        let exact = 1.875_104_f64.powi(2) * speed(&setup) / (setup.length * setup.length);
        close("told", told, 3e9 * (omega / exact).powi(2), 0.4);
    }
    // Equilibria are independent of the step; short waves are reported as softer.
    let mut scene = Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, ..Scene::default() };
    scene.sheets = vec![SheetSpec {
        structure: StructureKind::Shell,
        grid: (21, 1, 5),
        size: (0.25, 0.1),
        material: MaterialChoice::Inline(sheet(11, 0.0).material),
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    }];
    let mut world = World::new(&scene).expect("valid");
    world.find_equilibrium(1e-9);
    let told = world.sheets()[0].delivered_stiffness(world.dt()).expect("a shell");
    assert!(told.step == 1.0 && (0.95..1.0).contains(&told.grid), "{told:?}");
}

#[test]
fn the_first_swing_of_a_released_sheet_equals_the_elastica_in_motion() {
    // A chain of rigid links with bending joints, independent of the sheet's code, extrapolated to
    // infinitely many links: `sheetwork bench pareto`.
    let found = measured("release", &sheet(21, 0.0));
    close("depth", number(&found, "first_extreme_m"), 0.13918, 1.0);
    close("time", number(&found, "first_extreme_s"), 0.2183, 1.2);
}

/// A sheet of 0.25 m under `pressure` (Pa), without weight and air.
fn pressed(pressure: f64, grid: (u32, u32, u32), size: (f64, f64), pins: Vec<PinSpec>) -> Scene {
    let material = Material { young: 3e9, poisson: 0.35, density: 1050.0, thickness: 5e-4, ..Material::default() };
    let spec = SheetSpec {
        structure: StructureKind::Shell,
        grid,
        size,
        material: MaterialChoice::Inline(material),
        damping_ratio: Some(1.0),
        pins,
        pressure: vec![PressureKey { time: 0.0, pressure }],
        ..SheetSpec::default()
    };
    Scene {
        engine: IntegratorKind::TrBdf2,
        dt: 1.0 / 60.0,
        gravity: glam::DVec3::ZERO,
        sheets: vec![spec],
        ..Scene::default()
    }
}

#[test]
fn pressure_bends_a_plate_like_a_uniform_load() {
    // Timoshenko and Woinowsky-Krieger, *Theory of Plates and Shells*, tables 8 and 35: a
    // deflection far below the thickness.
    for (pin, part) in
        [(PinSpec::fixed(Region::Border), 0.004_062_35), (PinSpec::clamped(Region::Border), 0.001_265_32)]
    {
        let mut world = World::new(&pressed(0.02, (41, 1, 41), (0.25, 0.25), vec![pin])).expect("valid");
        world.find_equilibrium(1e-12);
        let sheet = &world.sheets()[0];
        let wanted = part * 0.02 * 0.25_f64.powi(4) / sheet.material().plate_stiffness();
        close("deflection", -sheet.state.x.get(20 * 41 + 20).y, wanted, 0.6);
    }
}

#[test]
fn pressure_follows_the_normal_of_the_sheet() {
    // A strip longer than the distance of its fixed ends, under pressure from below, is an arc of a
    // circle; under a vertical load it would be a catenary or a parabola.
    let ends = |path: f64, region| {
        let key =
            |time, offset| sheetwork::scene::PathKey { time, offset: glam::DVec3::X * offset, ..Default::default() };
        PinSpec { path: vec![key(0.0, 0.0), key(1.0, path)], ..PinSpec::fixed(region) }
    };
    let pins = vec![ends(0.04, Region::Left), ends(-0.04, Region::Right)];
    let mut scene = pressed(-2000.0, (61, 1, 4), (0.2, 0.01), pins);
    if let MaterialChoice::Inline(material) = &mut scene.sheets[0].material {
        material.thickness = 2e-4;
    }
    let mut world = World::new(&scene).expect("valid");
    world.advance(4.0);
    let sheet = &world.sheets()[0];
    let high = sheet.state.x.get(61 + 30).y;
    // sin θ/θ = c/L, by bisection; R = L/2θ, the rise R (1 - cos θ).
    let (mut low, mut top) = (0.1, 3.0);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + top);
        if middle.sin() / middle > 0.6 { low = middle } else { top = middle }
    }
    let radius = 0.1 / low;
    close("rise", high, radius * (1.0 - low.cos()), 1.0);
    let (a, b, c) = (sheet.state.x.get(61 + 10), sheet.state.x.get(61 + 30), sheet.state.x.get(61 + 50));
    let round = (a - b).length() * (b - c).length() * (c - a).length() / (2.0 * (b - a).cross(c - a).length());
    close("radius", round, radius, 1.0);
}

#[test]
fn pressure_accelerates_a_free_sheet_exactly_with_every_integrator() {
    for engine in
        [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::EulerRichardson, IntegratorKind::Rk4]
    {
        for (structure, layers) in [(StructureKind::Shell, 1), (StructureKind::DoubleDiagonal, 2)] {
            let mut scene = pressed(0.5, (7, layers, 7), (0.25, 0.25), vec![]);
            (scene.engine, scene.sheets[0].structure) = (engine, structure);
            if !engine.info().implicit {
                scene.dt = 1e-5;
                scene.sheets[0].damping_ratio = Some(0.01);
                let soft = Material { young: 3e5, thickness: 5e-4, ..Material::default() };
                scene.sheets[0].material = MaterialChoice::Inline(soft);
            }
            let mut world = World::new(&scene).expect("valid");
            (0..60).for_each(|_| _ = world.step());
            let sheet = &world.sheets()[0];
            assert!(world.unstable().is_none(), "{engine} {structure}");
            let got = sheet.momentum() / (0.5 * 0.25 * 0.25 * world.time());
            close(&format!("{engine} {structure}"), -got.y, 1.0, 0.2);
        }
    }
}
