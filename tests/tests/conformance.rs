//! Conformance of every integrator on every structure: order of convergence, momentum, pins, and
//! parameter changes during a run.
//!
//! Stability limits and energies are in `stability.rs`.

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::{IntegratorInfo, TABLE};
use sheetwork::math::Vectors;
use sheetwork::mesh::structure;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{PathKey, PinSpec, Region};
use sheetwork::sheet::select;
use sheetwork_tests::{
    distance, excite_randomly, excite_smoothly, highest_mode, run, scene_without_gravity, small_sheet, world,
};

/// Situation of the sheet whose convergence is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ConformanceCase {
    Free,
    Damped,
    /// The left edge moves sideways at a constant rate, with damping.
    Kinematic,
}

const CASES: [ConformanceCase; 3] = [ConformanceCase::Free, ConformanceCase::Damped, ConformanceCase::Kinematic];

/// A world of one small sheet, deformed and moving, and its largest frequency.
fn excited(structure: StructureKind, engine: IntegratorKind, case: ConformanceCase) -> (World, f64) {
    let mut spec = small_sheet(structure, if case == ConformanceCase::Free { 0.0 } else { 0.05 });
    if case == ConformanceCase::Kinematic {
        let path = vec![
            PathKey::default(),
            PathKey { time: 100.0, offset: DVec3::new(0.0, 10.0, 0.0), rotation: DVec3::ZERO },
        ];
        spec.pins.push(PinSpec { path, ..PinSpec::fixed(Region::Left) });
    }
    let mut world = world(&scene_without_gravity(spec, engine));
    let sheet = &mut world.sheets_mut()[0];
    let (omega, _) = highest_mode(sheet);
    let pinned =
        if case == ConformanceCase::Kinematic { select(&Region::Left, sheet).expect("a left edge") } else { vec![] };
    // Displacement as well as velocity: from an unstretched start a semi-implicit scheme appears
    // one order better. A tenth of the gap is far from a collapse of the layers and large enough
    // for geometric nonlinearity of the springs.
    excite_smoothly(sheet, 0.004, 0.2 * omega, &pinned);
    (world, omega)
}

/// Positions after `steps` equal steps over 4 radians of the highest mode, which is not a multiple
/// of a period.
fn positions(structure: StructureKind, engine: IntegratorKind, case: ConformanceCase, steps: u32) -> Vectors {
    let (mut world, omega) = excited(structure, engine, case);
    run(&mut world, steps, 4.0 / omega / f64::from(steps));
    world.sheets()[0].state.x.clone()
}

/// Steps over 4 radians at which the error is asymptotic and far above rounding.
fn coarse_steps(engine: &IntegratorInfo) -> u32 {
    match engine.order {
        1 => 400,
        2 => 100,
        4 => 24,
        _ => 24,
    }
}

#[test]
fn every_integrator_converges_with_its_order_on_every_structure() {
    for structure in structure::TABLE {
        for case in CASES {
            // 4 / 2000 radians per step: an error of order 1e-11 of the motion.
            let reference = positions(structure.kind, IntegratorKind::Rk4, case, 2000);
            for engine in TABLE {
                let n = coarse_steps(engine);
                // At a tolerance of 1 m the adaptive integrator takes the given steps.
                // A shell's damping depends on whether the integrator is implicit.
                let flat = engine.implicit && structure.kind == StructureKind::Shell;
                let own = flat.then(|| positions(structure.kind, IntegratorKind::TrBdf2, case, 4000));
                let reference = own.as_ref().unwrap_or(&reference);
                let error = |steps| distance(&positions(structure.kind, engine.kind, case, steps), reference);
                let (coarse, fine) = (error(n), error(2 * n));
                let order = (coarse / fine).log2();
                println!(
                    "{:16} {:16} {case:?}: order {order:.2}, errors {coarse:.1e} {fine:.1e} m",
                    structure.name, engine.name
                );
                assert!(
                    order >= f64::from(engine.order) - 0.2,
                    "{} on {}, {case:?}: {order}",
                    engine.name,
                    structure.name
                );
            }
        }
    }
}

#[test]
fn the_references_of_two_integrators_agree() {
    // An independent check of the reference above: rk45, which shares no coefficients with rk4,
    // must give the same motion.
    for structure in structure::TABLE {
        let (a, b) = [IntegratorKind::Rk4, IntegratorKind::Rk45]
            .map(|e| positions(structure.kind, e, ConformanceCase::Kinematic, 2000))
            .into();
        assert!(distance(&a, &b) < 1e-12, "{}: {}", structure.name, distance(&a, &b));
    }
}

#[test]
fn error_control_meets_its_tolerance_and_counts_its_steps() {
    for structure in structure::TABLE {
        let reference = positions(structure.kind, IntegratorKind::Rk4, ConformanceCase::Damped, 4000);
        let mut last = f64::INFINITY;
        for tolerance in [1e-5, 1e-7, 1e-9] {
            let (mut world, omega) = excited(structure.kind, IntegratorKind::Rk45, ConformanceCase::Damped);
            world.set_tolerance(tolerance).expect("in range");
            // A single step far too large for the tolerance, so that the integrator must choose its
            // own steps.
            run(&mut world, 1, 4.0 / omega);
            let sheet = &world.sheets()[0];
            let (accepted, rejected) = (sheet.state.counters.accepted, sheet.state.counters.rejected);
            let error = distance(&sheet.state.x, &reference);
            println!(
                "{:16} {tolerance:.0e}: error {error:.1e}, {accepted} accepted, {rejected} rejected",
                structure.name
            );
            // Errors of single steps add up; over a few radians they are hardly amplified.
            assert!(error < 2.0 * tolerance * accepted as f64, "{}: {error}", structure.name);
            assert!(error < last && rejected > 0, "{}", structure.name);
            // Every attempt costs six evaluations, and every accepted step one more.
            assert_eq!(sheet.state.counters.evaluations, 7 * accepted + 6 * rejected);
            last = error;
        }
    }
}

/// Sum of m |v|, kg m/s: the scale of rounding errors of momentum.
fn motion(world: &World) -> f64 {
    let sheet = &world.sheets()[0];
    (0..sheet.node_count()).map(|i| sheet.node_mass(i) * sheet.state.v.get(i).length()).sum()
}

#[test]
fn every_integrator_conserves_linear_momentum_of_a_free_sheet_to_rounding() {
    // Forces come in equal and opposite pairs, and every integrator sums them linearly.
    for structure in structure::TABLE {
        for engine in TABLE {
            let mut world = world(&scene_without_gravity(small_sheet(structure.kind, 0.1), engine.kind));
            let (omega, _) = highest_mode(&mut world.sheets_mut()[0]);
            excite_randomly(&mut world.sheets_mut()[0], 0.05, 2);
            let (before, scale) = (world.sheets()[0].momentum(), motion(&world));
            run(&mut world, 500, 0.05 / omega);
            let lost = world.sheets()[0].momentum().distance(before) / scale;
            // An implicit integrator computes velocities from displacements: positions of 0.2 m are
            // rounded to 1e-17 m, over steps of about 1e-4 s at 0.05 m/s, 500 times.
            let bound = if engine.implicit { 1e-9 } else { 1e-13 };
            assert!(lost < bound, "{} on {}: {lost}", engine.name, structure.name);
        }
    }
}

/// Change of angular momentum over 2 radians of the highest mode in `steps` steps, as a fraction of
/// its value.
fn turned(structure: StructureKind, engine: IntegratorKind, steps: u32) -> f64 {
    let mut spec = small_sheet(structure, 0.1);
    spec.spin = DVec3::new(1.0, 2.0, -1.5);
    let mut world = world(&scene_without_gravity(spec, engine));
    let sheet = &mut world.sheets_mut()[0];
    let (omega, _) = highest_mode(sheet);
    excite_smoothly(sheet, 0.004, 0.2 * omega, &[]);
    let before = world.sheets()[0].angular_momentum();
    run(&mut world, steps, 2.0 / omega / f64::from(steps));
    world.sheets()[0].angular_momentum().distance(before) / before.length()
}

#[test]
fn every_integrator_conserves_angular_momentum_to_its_order() {
    // Internal forces are central or, in a shell, without moment, so their moments cancel at the
    // positions of their evaluation. (A shell's damping acts along the normal and has a small
    // moment where a sheet is stretched unevenly.) Euler-Cromer and Verlet change velocities at
    // those positions and then move nodes along their velocities, which preserves x × v exactly.
    // The Runge-Kutta family (Euler, the constant-acceleration step, the midpoint rule, rk4, rk45)
    // conserves linear invariants only; x × v is quadratic and is conserved to the order of the
    // scheme.
    for structure in structure::TABLE {
        for engine in TABLE {
            // Half the time of the convergence test, and larger steps for high orders, because
            // errors below 1e-13 are rounding.
            let n = if engine.order < 4 { coarse_steps(engine) } else { 8 };
            let (coarse, fine) = (turned(structure.kind, engine.kind, n), turned(structure.kind, engine.kind, 2 * n));
            println!("{:16} {:16}: angular momentum off by {coarse:.1e}, {fine:.1e}", structure.name, engine.name);
            if matches!(engine.kind, IntegratorKind::EulerCromer | IntegratorKind::Verlet) {
                let bound = if structure.kind == StructureKind::Shell { 1e-5 } else { 1e-13 };
                assert!(coarse < bound && fine < bound, "{} on {}: {coarse} {fine}", engine.name, structure.name);
            } else if structure.kind != StructureKind::Shell {
                let order = (coarse / fine).log2();
                assert!(order > f64::from(engine.order) - 0.3, "{} on {}: {order}", engine.name, structure.name);
            }
        }
    }
}

#[test]
fn pinned_nodes_are_exactly_at_their_positions_with_every_integrator() {
    let path = vec![
        PathKey { time: 0.01, ..PathKey::default() },
        PathKey { time: 0.03, offset: DVec3::new(0.01, 0.02, -0.005), rotation: DVec3::ZERO },
        PathKey { time: 0.07, offset: DVec3::new(-0.01, 0.01, 0.0), rotation: DVec3::ZERO },
    ];
    for structure in structure::TABLE {
        for engine in TABLE {
            let mut spec = small_sheet(structure.kind, 0.1);
            spec.pins =
                vec![PinSpec { path: path.clone(), ..PinSpec::fixed(Region::Left) }, PinSpec::fixed(Region::Right)];
            let mut world = world(&scene_without_gravity(spec, engine.kind));
            world.set_gravity(DVec3::new(0.0, -9.81, 0.0)).expect("in range");
            let sheet = &world.sheets()[0];
            let start = sheet.state.x.clone();
            let [led, held] = [Region::Left, Region::Right].map(|r| select(&r, sheet).expect("an edge"));
            for _ in 0..50 {
                run(&mut world, 1, 0.002);
                let offset = sheetwork::scene::path_at(&path, world.time()).0;
                let sheet = &world.sheets()[0];
                let at = |i: &u32| (sheet.state.x.get(*i as usize), start.get(*i as usize));
                assert!(led.iter().map(at).all(|(x, s)| x == s + offset), "{} on {}", engine.name, structure.name);
                assert!(held.iter().map(at).all(|(x, s)| x == s), "{} on {}", engine.name, structure.name);
            }
        }
    }
}

#[test]
fn a_switch_of_integrator_continues_from_the_present_state() {
    // An explicit integrator has no state between steps except the step size of rk45, and an
    // implicit one restarts when selected. A switched world and a new one with equal positions and
    // velocities must therefore continue bit for bit.
    for structure in structure::TABLE {
        for first in TABLE {
            for second in TABLE {
                let (mut switched, omega) = excited(structure.kind, first.kind, ConformanceCase::Damped);
                run(&mut switched, 10, 0.1 / omega);
                let (x, v) = (switched.sheets()[0].state.x.clone(), switched.sheets()[0].state.v.clone());
                switched.set_engine(second.kind);
                assert!(switched.sheets()[0].state.x == x && switched.sheets()[0].state.v == v);
                let (mut fresh, _) = excited(structure.kind, second.kind, ConformanceCase::Damped);
                fresh.sheets_mut()[0].state.x = x;
                fresh.sheets_mut()[0].state.v = v;
                // The arms of a shell's loss factor are state of the sheet.
                let keeps_arms = first.implicit && second.implicit && structure.kind == StructureKind::Shell;
                if keeps_arms || first.kind == second.kind && (first.adaptive || first.implicit) {
                    continue;
                }
                run(&mut switched, 5, 0.1 / omega);
                run(&mut fresh, 5, 0.1 / omega);
                assert_eq!(
                    switched.sheets()[0].state.x,
                    fresh.sheets()[0].state.x,
                    "{} to {}",
                    first.name,
                    second.name
                );
            }
        }
    }
}

#[test]
fn a_change_of_gravity_acts_from_the_next_step() {
    // Centre of mass: v = g₁ T + g₂ T exactly, with every integrator; x = ½ g₁ T² + g₁ T² + ½ g₂ T²
    // for integrators that are exact for constant acceleration (all but Euler and Euler-Cromer,
    // whose error is ∓½ T h (g₁ + g₂)).
    let (g1, g2, steps, h) = (DVec3::new(0.5, -9.81, 0.0), DVec3::new(-1.0, 3.0, 2.0), 64, 1.0 / 4096.0);
    let t = f64::from(steps) * h;
    for structure in structure::TABLE {
        for engine in TABLE {
            let mut world = world(&scene_without_gravity(small_sheet(structure.kind, 0.1), engine.kind));
            excite_randomly(&mut world.sheets_mut()[0], 0.02, 3);
            let (x0, v0) = centre(&world);
            world.set_gravity(g1).expect("in range");
            run(&mut world, steps, h);
            world.set_gravity(g2).expect("in range");
            run(&mut world, steps, h);
            let (x1, v1) = centre(&world);
            let sign = match engine.kind {
                IntegratorKind::Euler => -1.0,
                IntegratorKind::EulerCromer | IntegratorKind::BackwardEuler => 1.0,
                _ => 0.0,
            };
            let x = x0 + v0 * (2.0 * t) + (1.5 * g1 + 0.5 * g2) * (t * t) + (g1 + g2) * (0.5 * sign * t * h);
            // The two implicit integrators of order 2 use the previous step, so a part of the
            // change acts one step late.
            let late = matches!(engine.kind, IntegratorKind::TrBdf2 | IntegratorKind::Bdf2);
            let rounding = if engine.implicit { 1e-9 } else { 1e-13 };
            let (dv, dx) =
                if late { ((g2 - g1).length() * h, (g1.length() + g2.length()) * t * h) } else { (0.0, 0.0) };
            let (off_v, off_x) = (v1.distance(v0 + (g1 + g2) * t), x1.distance(x));
            println!("{} on {}: off by {off_v:.1e} m/s, {off_x:.1e} m", engine.name, structure.name);
            assert!(off_v < 0.51 * dv + rounding, "{} on {}: {off_v}", engine.name, structure.name);
            assert!(off_x < dx + rounding, "{} on {}: {off_x}", engine.name, structure.name);
        }
    }
}

fn centre(world: &World) -> (DVec3, DVec3) {
    let sheet = &world.sheets()[0];
    (sheet.centre_of_mass(), sheet.momentum() / sheet.total_mass())
}

#[test]
fn the_flexion_limit_bounds_the_angle_and_conserves_momenta() {
    for structure in structure::TABLE.iter().filter(|s| s.flexion) {
        let thrown = |limit: Option<f64>, engine: IntegratorKind| {
            let mut spec = small_sheet(structure.kind, 0.02);
            spec.grid = (9, spec.grid.1, 5);
            spec.size = (0.8, 0.4);
            spec.gap = 0.02;
            spec.flexion_stiffness = 0.01;
            spec.flexion_limit = limit;
            let mut world = world(&scene_without_gravity(spec, engine));
            let sheet = &mut world.sheets_mut()[0];
            // An upward velocity at both ends and a downward one in the middle: a fold along z.
            for i in 0..sheet.node_count() {
                let u = sheet.model.uv[i].0;
                sheet.state.v.set(i, DVec3::new(0.0, 1.5 * (4.0 * (u - 0.5).powi(2) - 0.3), 0.2 * u));
            }
            world
        };
        let limit = 20.0;
        for engine in TABLE {
            let (mut with, mut without) = (thrown(Some(limit), engine.kind), thrown(None, engine.kind));
            let (omega, _) = highest_mode(&mut with.sheets_mut()[0]);
            let (scale, p, l) = (motion(&with), with.sheets()[0].momentum(), with.sheets()[0].angular_momentum());
            let (mut largest, mut free) = (0.0_f64, 0.0_f64);
            for _ in 0..800 {
                run(&mut with, 1, 0.1 / omega);
                run(&mut without, 1, 0.1 / omega);
                let angle = |w: &World| w.sheets()[0].largest_flexion_angle().expect("a structure with flexion");
                (largest, free) = (largest.max(angle(&with)), free.max(angle(&without)));
            }
            println!("{} {}: {largest:.2} degrees, without limit {free:.1}", structure.name, engine.name);
            assert!(free > 2.0 * limit, "the throw is too weak to test anything: {free}");
            // The angle may exceed the limit within the step that detects it: 1.5 m/s over 0.1 m in
            // a step is one degree.
            assert!(largest < limit + 1.5, "{} on {}: {largest}", engine.name, structure.name);
            let rounding = if engine.implicit { 1e-8 } else { 1e-12 };
            assert!(with.sheets()[0].momentum().distance(p) < rounding * scale, "{}", engine.name);
            // Impulses of the limit have no moment; the remaining change is that of the integrator
            // (see above).
            if matches!(engine.kind, IntegratorKind::EulerCromer | IntegratorKind::Verlet) {
                let turned = with.sheets()[0].angular_momentum().distance(l);
                assert!(turned < 1e-12 * scale, "{}: {turned}", engine.name);
            }
        }
    }
}
