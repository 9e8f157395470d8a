//! Stability limits and energy of every integrator: on an oscillator with and without damping, and
//! on the highest mode of a sheet of every structure.
//!
//! The expected numbers are the classical ones for x'' = -ω²x, a = hω. Energy factors per step:
//! Euler (1 + a²), the constant-acceleration step (1 + a²/2), Euler-Richardson (1 + a⁴/4), RK4 (1 -
//! a⁶/72). Stability limits: Euler-Cromer and Verlet a = 2, RK4 2√2, the order-5 formula of rk45
//! 0.997. Implicit schemes are stable at any step and lose energy: backward Euler 1/(1 + a²), BDF2
//! (1 - a⁴/2), TR-BDF2 with γ = 2 - √2 (1 - 0.00736 a⁴), the first terms of |R(ia)|².

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::mesh::structure;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork_rigs::measure::oscillator;
use sheetwork_rigs::measure::stability_limit::{StabilityTrial, radius};
use sheetwork_tests::{excite_randomly, highest_mode, run, scene_without_gravity, small_sheet, world};

/// Smallest a at which the damped oscillator grows.
fn limit(engine: IntegratorKind, zeta: f64) -> f64 {
    let grows = |a: f64| radius(engine, a, zeta) > 1.0 + 1e-12;
    let mut high = 0.01;
    while !grows(high) && high < 10.0 {
        high += 0.01;
    }
    let mut low = high - 0.01;
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    low
}

/// Root of a function near `start` by Newton's method; `step` is its value over its slope.
fn newton(start: f64, step: impl Fn(f64) -> f64) -> f64 {
    (0..20).fold(start, |a, _| a - step(a))
}

#[test]
fn stability_limits_of_an_undamped_oscillator_equal_the_table() {
    for engine in TABLE {
        let found = oscillator::stability_limit(engine.kind);
        println!("{:16} {found:.4}, tabled {:.4}", engine.name, engine.stability_limit);
        let near = (found - engine.stability_limit).abs() <= 0.02 * engine.stability_limit;
        assert!(if engine.implicit { found == f64::INFINITY } else { near }, "{}: {found}", engine.name);
    }
}

#[test]
fn damping_changes_the_limits_as_predicted() {
    for zeta in [0.02_f64, 0.05, 0.1, 0.2] {
        // The new velocity moves x, and the dashpot acts on the old velocity: 2 (√(1 + ζ²) - ζ).
        let cromer = limit(IntegratorKind::EulerCromer, zeta);
        let expected = 2.0 * ((1.0 + zeta * zeta).sqrt() - zeta);
        assert!((cromer / expected - 1.0).abs() < 0.02, "{zeta}: {cromer}, {expected}");
        // |1 + z + z²/2| = 1 with z = a (-ζ + i √(1 - ζ²)) is a³ - 4 ζ a² + 8 ζ² a - 8 ζ = 0,
        // so about 2 ζ^(1/3).
        let richardson = limit(IntegratorKind::EulerRichardson, zeta);
        let about = 2.0 * zeta.cbrt();
        println!("{zeta}: euler-cromer {cromer:.4}, euler-richardson {richardson:.4} (about {about:.4})");
        let expected = newton(about, |a| {
            let value = a.powi(3) - 4.0 * zeta * a * a + 8.0 * zeta * zeta * a - 8.0 * zeta;
            value / (3.0 * a * a - 8.0 * zeta * a + 8.0 * zeta * zeta)
        });
        assert!((richardson / expected - 1.0).abs() < 0.02, "{zeta}: {richardson}, {expected}");
        assert!((richardson / about - 1.0).abs() < 0.2, "{zeta}: {richardson}, {about}");
        let rk4 = limit(IntegratorKind::Rk4, zeta);
        println!("{zeta}: rk4 {rk4:.4}");
        assert!((2.82..=2.96).contains(&rk4), "{zeta}: {rk4}");
    }
}

/// A free undamped sheet in its highest mode at an amplitude in the linear range, and the mode's
/// angular frequency, rad/s.
fn ringing(structure: StructureKind, engine: IntegratorKind) -> (World, f64) {
    let mut world = world(&scene_without_gravity(small_sheet(structure, 0.0), engine));
    let sheet = &mut world.sheets_mut()[0];
    let (omega, mode) = highest_mode(sheet);
    for i in 0..sheet.node_count() {
        sheet.state.v.set(i, mode.get(i) * (1e-7 * omega));
    }
    (world, omega)
}

fn energy(world: &World) -> f64 {
    world.sheets()[0].energy(DVec3::ZERO).total
}

/// Logarithmic growth of the highest mode's energy per step of `a` radians, over `steps` steps.
fn growth(structure: StructureKind, engine: IntegratorKind, a: f64, steps: u32) -> f64 {
    let (mut world, omega) = ringing(structure, engine);
    if engine.info().implicit {
        // The first step of BDF2 is backward Euler.
        run(&mut world, 50, a / omega);
    }
    let before = energy(&world);
    run(&mut world, steps, a / omega);
    (energy(&world) / before).ln() / f64::from(steps)
}

#[test]
fn energy_in_the_highest_mode_grows_or_decays_as_tabled() {
    for structure in structure::TABLE {
        let check = |engine: IntegratorKind, a: f64, steps: u32, expected: f64| {
            let found = growth(structure.kind, engine, a, steps);
            println!(
                "{:16} {:16} a = {a}: {found:+.4e} a step, {expected:+.4e} expected",
                structure.name,
                engine.name()
            );
            let off = (found / expected - 1.0).abs();
            assert!(off < 0.02, "{} on {} at {a}: {found}, {expected}", engine.name(), structure.name);
        };
        for a in [0.05_f64, 0.1] {
            check(IntegratorKind::Euler, a, 500, (a * a).ln_1p());
        }
        // The step is not a rotation, so the energy also oscillates by ±a/2 within a period; many
        // steps make this negligible.
        check(IntegratorKind::Analytical, 0.1, 3000, 0.005_f64.ln_1p());
        for a in [0.2_f64, 0.4] {
            check(IntegratorKind::EulerRichardson, a, 400, (a.powi(4) / 4.0).ln_1p());
        }
        // The next term of RK4's decay is a⁸/576: an eighth of a² of the first.
        check(IntegratorKind::Rk4, 0.35, 4000, -(0.35_f64.powi(6)) / 72.0);
        check(IntegratorKind::Rk4, 1.0, 400, (-1.0 / 72.0 + 1.0 / 576.0_f64).ln_1p());
        // |R(ia)|² - 1 of the order-5 formula with its seventh-stage term z⁶/600:
        // -a⁶/1800 + a⁸/1600 - ...
        let u = 0.25_f64;
        let fifth = u.powi(3) * (-1.0 / 1800.0 + u / 1600.0 - u * u / 14400.0 + u.powi(3) / 360_000.0);
        check(IntegratorKind::Rk45, 0.5, 8000, fifth);
        check(IntegratorKind::BackwardEuler, 0.1, 500, -(0.01_f64.ln_1p()));
        check(IntegratorKind::Bdf2, 0.05, 4000, -0.5 * 0.05_f64.powi(4));
        check(IntegratorKind::TrBdf2, 0.2, 3000, -0.00736 * 0.2_f64.powi(4));
    }
}

#[test]
fn symplectic_integrators_bound_the_energy_of_the_highest_mode() {
    // Euler-Cromer conserves v² + ω²x² - hω² x v, so the energy stays within ±a/2 of its mean.
    // Verlet conserves v² + ω²x² (1 - a²/4), so the energy oscillates by a²/4 of its maximum.
    for structure in structure::TABLE {
        for (engine, a) in [
            (IntegratorKind::EulerCromer, 0.1),
            (IntegratorKind::EulerCromer, 0.5),
            (IntegratorKind::Verlet, 0.2),
            (IntegratorKind::Verlet, 0.8),
        ] {
            let (mut world, omega) = ringing(structure.kind, engine);
            let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
            for _ in 0..10_000 {
                run(&mut world, 1, a / omega);
                (low, high) = (low.min(energy(&world)), high.max(energy(&world)));
            }
            let cromer = engine == IntegratorKind::EulerCromer;
            let found = if cromer { (high - low) / (high + low) } else { (high - low) / high };
            let expected = if cromer { a / 2.0 } else { a * a / 4.0 };
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{} on {}: {found}, {expected}",
                engine.name(),
                structure.name
            );
        }
    }
}

#[test]
fn the_limits_hold_for_sheets_of_every_structure_to_two_percent() {
    // Random velocities excite every mode. At 0.98 of the limit for the largest frequency the
    // energy stays within the bound of the integrator's invariant, at most (1 + a/2) / (1 - a/2) =
    // 99. At 1.02 the highest mode dominates and grows by at least a seventh per step.
    for structure in structure::TABLE {
        for engine in TABLE
            .iter()
            .filter(|e| matches!(e.kind, IntegratorKind::EulerCromer | IntegratorKind::Verlet | IntegratorKind::Rk4))
        {
            let ratio = |fraction: f64, steps: u32| {
                let mut world = world(&scene_without_gravity(small_sheet(structure.kind, 0.0), engine.kind));
                let (omega, _) = highest_mode(&mut world.sheets_mut()[0]);
                excite_randomly(&mut world.sheets_mut()[0], 1e-7, 4);
                let before = energy(&world);
                let mut most = 0.0_f64;
                for _ in 0..steps {
                    run(&mut world, 1, fraction * engine.stability_limit / omega);
                    most = most.max(energy(&world) / before);
                    if most > 1e6 {
                        break;
                    }
                }
                most
            };
            let (below, above) = (ratio(0.98, 5000), ratio(1.02, 100));
            println!("{:16} {:16}: {below:.3} below, {above:.1e} above", structure.name, engine.name);
            assert!(below < 100.0 && above > 1e6, "{} on {}: {below}, {above}", engine.name, structure.name);
        }
    }
}

#[test]
fn the_largest_frequency_equals_that_of_the_highest_mode() {
    for structure in structure::TABLE {
        let mut spec = small_sheet(structure.kind, 0.0);
        spec.grid = (9, spec.grid.1, 7);
        let mut world = world(&scene_without_gravity(spec, IntegratorKind::Verlet));
        let (exact, _) = highest_mode(&mut world.sheets_mut()[0]);
        let found = world.sheets()[0].largest_frequency(200);
        println!("{:16}: {found:.3} of {exact:.3} rad/s", structure.name);
        assert!((found / exact - 1.0).abs() < 0.01, "{}: {found}, {exact}", structure.name);
    }
}

#[test]
fn measured_stability_limits_equal_predicted_ones() {
    // Integrators and structures at the thesis's damping; measured limits are within 5 % of
    // predicted ones.
    for engine in TABLE.iter().filter(|e| !e.adaptive && !e.implicit) {
        for structure in structure::TABLE {
            let setting =
                StabilityTrial { engine: engine.kind, structure: structure.kind, ..StabilityTrial::default() };
            let predicted = setting.predict_longest_step().unwrap_or_else(|e| panic!("{e}"));
            let found = setting.find_longest_step(predicted).unwrap_or_else(|e| panic!("{e}")).unwrap_or(f64::INFINITY);
            println!("{:16} {:16}: {found:.3e} s, {predicted:.3e} s predicted", engine.name, structure.name);
            assert!(
                (found / predicted - 1.0).abs() < 0.05,
                "{} on {}: {found}, {predicted}",
                engine.name,
                structure.name
            );
        }
    }
    // A shell with a thickness close to the node spacing, whose retardation damps in-plane motion
    // less.
    for engine in
        [IntegratorKind::EulerCromer, IntegratorKind::EulerRichardson, IntegratorKind::Verlet, IntegratorKind::Rk4]
    {
        let setting =
            StabilityTrial { engine, structure: StructureKind::Shell, thickness: 6e-3, ..StabilityTrial::default() };
        let predicted = setting.predict_longest_step().unwrap_or_else(|e| panic!("{e}"));
        let found = setting.find_longest_step(predicted).unwrap_or_else(|e| panic!("{e}")).unwrap_or(f64::INFINITY);
        println!("{engine} on a shell of 6 mm: {found:.3e} s, {predicted:.3e} s predicted");
        assert!((found / predicted - 1.0).abs() < 0.05, "{engine}: {found}, {predicted}");
    }
    for engine in TABLE.iter().filter(|e| e.implicit) {
        let setting = StabilityTrial { engine: engine.kind, stiffness: 2e4, ..StabilityTrial::default() };
        assert_eq!(setting.find_longest_step(f64::INFINITY).unwrap_or_else(|e| panic!("{e}")), None, "{}", engine.name);
    }
}

#[test]
fn limits_follow_stiffness_mass_and_temperature() {
    let base = StabilityTrial::default();
    let of = |s: StabilityTrial| {
        s.find_longest_step(s.predict_longest_step().unwrap_or(1e-2))
            .unwrap_or_else(|e| panic!("{e}"))
            .unwrap_or(f64::INFINITY)
    };
    let plain = of(base);
    // Proportional to the square root of mass over stiffness.
    assert!((of(StabilityTrial { stiffness: 100.0 * base.stiffness, ..base }) / plain * 10.0 - 1.0).abs() < 0.02);
    assert!((of(StabilityTrial { mass: 0.01 * base.mass, ..base }) / plain * 10.0 - 1.0).abs() < 0.02);
    // 100 K change the stiffness by a factor of ten.
    let warm = of(StabilityTrial { jump: 100.0, ..base }) / plain;
    let cold = of(StabilityTrial { jump: -100.0, ..base }) / plain;
    println!("100 K up: {warm:.3}, 100 K down: {cold:.3} of the step");
    let root = 10.0_f64.sqrt();
    assert!((warm / root - 1.0).abs() < 0.05 && (cold * root - 1.0).abs() < 0.05, "{warm} {cold}");
    // A shell's retardation time is independent of temperature, so its limit does not follow the
    // square root; the prediction covers this.
    for engine in [IntegratorKind::EulerCromer, IntegratorKind::EulerRichardson, IntegratorKind::Rk4] {
        for jump in [-100.0, 100.0] {
            let shell = StabilityTrial { structure: StructureKind::Shell, engine, jump, ..base };
            let ratio = of(shell) / shell.predict_longest_step().unwrap_or_else(|e| panic!("{e}"));
            assert!((ratio - 1.0).abs() < 0.05, "{engine}, {jump} K: {ratio}");
        }
    }
}
