//! Flat loss factor: decrement by frequency, rebound, energy, snapshots.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sheetwork::World;
use sheetwork::scene::IntegratorKind;
use sheetwork_tests::{change_grid, world_of};

/// A cantilever of loss factor `eta` without gravity whose first mode has about `frequency` (Hz).
fn strip(eta: f64, frequency: f64, dt: f64, shape: &str) -> World {
    // f = 0.5596 √(D/ρt)/L² = 3.02 Hz at 2 GPa.
    let young = 2e9 * (frequency / 3.02).powi(2);
    world_of(&format!(
        r#"(name: "strip", engine: "tr-bdf2", dt: {dt}, duration: 1, gravity: (0, 0, 0),
            sheets: [(name: "s", structure: "shell", {shape}, size: (0.2, 0.05), pins: [(region: Left, clamp: true)],
                material: (young: {young}, poisson: 0.38, density: 1045, thickness: 5e-4, loss_factor: {eta}))])"#
    ))
}

const IMPLICIT: [IntegratorKind; 3] = [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::Bdf2];
const GRID: &str = "grid: (9, 1, 3)";
const OUTLINE: &str = "grid: (9, 1, 3), outline: Polygon([(0, 0), (0.2, 0), (0.2, 0.05), (0, 0.05)])";

/// Sets velocities of the first mode in bending, or of the first stretching mode along the strip,
/// `speed` (m/s) at most; returns the mode times node mass, by which a motion is projected.
fn pluck(world: &mut World, speed: f64, stretches: bool) -> Vec<DVec3> {
    let sheet = &mut world.sheets_mut()[0];
    let mut shape = sheet.modes(1).remove(0).shape;
    if stretches {
        let x = sheet.state.x.clone();
        let left = x.axes()[0].iter().copied().fold(f64::INFINITY, f64::min);
        (0..x.len()).for_each(|i| shape.set(i, DVec3::X * (PI * (x.get(i).x - left) / 0.4).sin()));
    }
    let largest = shape.max_squared().sqrt();
    for i in 0..sheet.node_count() {
        sheet.state.v.set(i, shape.get(i) * (speed / largest));
    }
    (0..sheet.node_count()).map(|i| shape.get(i) * sheet.node_mass(i)).collect()
}

/// Logarithmic decrement of a cycle: ratio of the Fourier amplitudes of two windows of four cycles,
/// four cycles apart.
fn decrement(mut world: World, frequency: f64, stretches: bool) -> f64 {
    world.set_sleep(false);
    let (dt, mode) = (world.dt(), pluck(&mut world, 1e-3, stretches));
    let start = world.sheets()[0].state.x.clone();
    let (steps, mut sums) = ((4.0 / frequency / dt).round() as usize, [[0.0; 2]; 2]);
    for n in 0..2 * steps {
        world.step();
        let x = &world.sheets()[0].state.x;
        let amplitude: f64 = mode.iter().enumerate().map(|(i, m)| m.dot(x.get(i) - start.get(i))).sum();
        let window = amplitude * (1.0 - (TAU * (n % steps) as f64 / steps as f64).cos());
        let phase = TAU * frequency * dt * n as f64;
        let sum = &mut sums[n / steps];
        (sum[0], sum[1]) = (sum[0] + window * phase.cos(), sum[1] + window * phase.sin());
    }
    let [first, second] = sums.map(|s| (s[0].hypot(s[1]), -s[1].atan2(s[0])));
    // The phase advances by the difference to the assumed frequency.
    let drift = (second.1 - first.1 + PI).rem_euclid(TAU) - PI;
    (first.0 / second.0).ln() / (steps as f64 * dt * frequency + drift / TAU)
}

#[test]
fn a_strip_rings_down_with_the_decrement_of_the_loss_factor() {
    let hz = 1.0 / 60.0;
    for (eta, frequency, dt, shape) in [
        (0.03, 1.0_f64, hz, GRID),
        (0.03, 5.0, hz, GRID),
        (0.1, 1.0, hz, GRID),
        (0.1, 5.0, hz, OUTLINE),
        (0.03, 20.0, 0.25 * hz, OUTLINE),
        (0.1, 20.0, 0.25 * hz, GRID),
    ] {
        // E' grows as f^(2η/π), from 1 + 1.8 η at 1 Hz. In stretching f = √(E/ρ)/4L.
        let stiffened = (1.0 + 0.9 * eta) * frequency.powf(eta / PI);
        let found = decrement(strip(eta, frequency / stiffened, dt, shape), frequency, false);
        let slack = frequency * (2e9_f64 / 1045.0).sqrt() / 0.8 / 3.02;
        let soft = strip(eta, frequency / stiffened * frequency / slack, dt, shape);
        let stretched = decrement(soft, frequency, true);
        for found in [found, stretched] {
            assert!((found / (PI * eta) - 1.0).abs() < 0.05, "{eta} at {frequency} Hz: {found} for {}", PI * eta);
        }
    }
}

#[test]
fn the_decrement_is_that_of_the_loss_factor_with_every_implicit_integrator() {
    // Backward Euler adds ω dt, 1.6 % of η here.
    for engine in IMPLICIT {
        let mut world = strip(0.1, 1.0 / 1.09, 1.0 / 4000.0, GRID);
        world.set_engine(engine);
        let found = decrement(world, 1.0, false);
        assert!((found / (PI * 0.1) - 1.0).abs() < 0.05, "{engine}: {found} for {}", PI * 0.1);
    }
}

#[test]
fn the_energy_of_a_strip_and_its_arms_never_rises() {
    for (shape, engine) in [GRID, OUTLINE].iter().flat_map(|s| IMPLICIT.map(|e| (s, e))) {
        let mut world = strip(0.1, 3.0, 1.0 / 60.0, shape);
        world.set_engine(engine);
        pluck(&mut world, 0.01, false);
        let mut last = world.energy().total;
        for n in 0..120 {
            world.step();
            let now = world.energy().total;
            assert!(now <= last * (1.0 + 1e-9), "{engine} at step {n}: {now}");
            last = now;
        }
    }
}

#[test]
fn a_snapshot_of_the_arms_continues_to_the_bit() {
    for (shape, engine) in [GRID, OUTLINE].iter().flat_map(|s| IMPLICIT.map(|e| (s, e))) {
        let mut world = strip(0.1, 3.0, 1.0 / 60.0, shape);
        world.set_engine(engine);
        pluck(&mut world, 0.01, false);
        let run = |world: &mut World| (0..10).for_each(|_| _ = world.step());
        run(&mut world);
        let saved = world.serialise();
        run(&mut world);
        let end = world.serialise();
        let mut other = strip(0.1, 3.0, 1.0 / 60.0, shape);
        other.deserialise(&saved).expect("a world of this scene");
        run(&mut other);
        assert!(other.serialise() == end, "{engine} {shape}");
    }
}

#[test]
fn the_arms_follow_a_change_of_the_grid() {
    // Moved for 50 ms, then transferred: the arms have a third of the energy.
    for shape in [GRID, OUTLINE] {
        let mut world = strip(0.2, 3.0, 1.0 / 240.0, shape);
        pluck(&mut world, 0.1, false);
        (0..12).for_each(|_| _ = world.step());
        let before = world.sheets()[0].energy(DVec3::ZERO).elastic;
        change_grid(&mut world, (13, 4));
        let after = world.sheets()[0].energy(DVec3::ZERO).elastic;
        assert!((after / before - 1.0).abs() < 0.08, "{shape}: {before} J becomes {after} J");
    }
}

/// Largest height (m) of the ball's centre, and its largest speed (m/s) upwards, after it has first
/// moved up.
fn rebound(scene: &str) -> (f64, f64) {
    let mut world = world_of(scene);
    let (mut height, mut speed) = (f64::NEG_INFINITY, 0.0_f64);
    let steps = (world.scene().duration / world.dt()).round() as u32;
    for _ in 0..steps {
        world.step();
        let ball = world.body_state("ball").expect("the ball");
        let v = ball.velocity().y;
        speed = speed.max(v);
        if speed > 0.0 {
            height = height.max(ball.centre().y);
        }
    }
    (height, speed)
}

const STEPS: [f64; 2] = [1e-3, 1.0 / 240.0];

/// A ball of `mass` (kg) that falls 0.3 m onto a square membrane of 0.1 kg held around.
fn trampoline(dt: f64, mass: f64, material: &str) -> (f64, f64) {
    rebound(&format!(
        r#"(name: "trampoline", engine: "tr-bdf2", dt: {dt}, duration: 0.7, contact: (friction: 0.3, restitution: 0),
            sheets: [(name: "membrane", structure: "shell", grid: (17, 1, 17), size: (0.3, 0.3), pins: [(region: Border)],
                material: {material})],
            bodies: [(name: "ball", shape: Ball(0.02), mass: {mass}, placement: (position: (0.0011, 0.3205, 0.0007)))])"#
    ))
}

/// Rubber of 1 mm with this damping.
fn rubber(damping: &str) -> String {
    format!("(young: 3e6, poisson: 0.49, density: 1100, thickness: 1e-3, {damping})")
}

#[test]
fn a_heavy_ball_leaves_a_slack_membrane_by_its_loss_factor() {
    // A membrane without pretension, F = k w³: e(η)/e(0) = 0.896 at η = 0.1, of a one-mode model
    // with the arms at rest at impact.
    let speed = |damping: &str| trampoline(1e-3, 0.5, &rubber(damping)).1;
    let (lossless, lossy) = (speed("damping_ratio: 0"), speed("loss_factor: 0.1"));
    assert!((lossy / lossless - 0.896).abs() < 0.02, "{lossy} of {lossless} m/s");
}

#[test]
fn a_light_ball_rebounds_to_half_its_height_or_more() {
    // Waves in the membrane take a part of the energy, 0.31 of the height without damping.
    let damped = rubber("damping_ratio: 0.05");
    for (dt, (mass, material)) in STEPS.into_iter().flat_map(|dt| {
        [(0.05, damped.as_str()), (0.1, &damped), (0.2, &damped), (0.05, r#""rubber""#), (0.05, r#""hips""#)]
            .map(|c| (dt, c))
    }) {
        let height = (trampoline(dt, mass, material).0 - 0.0205) / 0.3;
        println!("{dt} s, {mass} kg, {material}: {height} of the height");
        assert!((0.5..0.8).contains(&height), "{dt} s, {mass} kg, {material}: {height} of the height");
    }
}

#[test]
fn a_fast_ball_leaves_a_thin_polystyrene_sheet() {
    // Half of its speed at the least: the sheet's loss factor is 0.03.
    let inline = "(young: 2e9, poisson: 0.38, density: 1045, thickness: 5e-4, damping_ratio: 0.015)";
    for (dt, material, into) in
        STEPS.iter().flat_map(|dt| [(dt, inline, 50.0), (dt, r#""hips""#, 50.0), (dt, inline, 20.0)])
    {
        let (_, speed) = rebound(&format!(
            r#"(name: "fast ball", engine: "tr-bdf2", dt: {dt}, duration: 0.1, contact: (friction: 0.3, restitution: 0.3),
                sheets: [(name: "sheet", structure: "shell", grid: (21, 1, 21), size: (0.3, 0.3), pins: [(region: Border)],
                    material: {material})],
                bodies: [(name: "ball", shape: Ball(0.01), mass: 0.03, placement: (position: (0.0031, 0.02, 0.0017)),
                    velocity: (0, {}, 0))])"#,
            -into
        ));
        println!("{dt} s, {material}: {speed} of {into} m/s");
        assert!(speed > 0.5 * into, "{dt} s, {material}: {speed} of {into} m/s");
    }
}

/// Root mean square speed (m/s) of a flag of PET in a wind of 6 m/s, over the last of three
/// seconds.
fn flutter(damping: &str) -> f64 {
    let mut world = world_of(&format!(
        r#"(name: "flag", engine: "tr-bdf2", dt: 0.004, duration: 3, air: (density: 1.2, wind: (6, 0, 0.3)),
            sheets: [(name: "s", structure: "shell", grid: (17, 1, 9), size: (0.3, 0.15), material: "pet", {damping}
                placement: (rotation: (90, 0, 0)), pins: [(region: Left)])])"#
    ));
    world.advance(2.0);
    let sum: f64 = (0..250)
        .map(|_| {
            world.step();
            world.sheets()[0].energy(DVec3::ZERO).kinetic
        })
        .sum();
    (2.0 * sum / 250.0 / world.sheets()[0].total_mass()).sqrt()
}

#[test]
fn a_flag_flutters_in_the_wind() {
    let (own, heavy) = (flutter(""), flutter("damping_ratio: 1,"));
    println!("{own} m/s, with a Kelvin-Voigt damping of the first mode {heavy} m/s");
    assert!(own > 0.3 && own > 3.0 * heavy, "{own} m/s, heavily damped {heavy} m/s");
}
