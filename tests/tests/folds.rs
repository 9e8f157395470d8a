//! Folds of plastic strips and loaded creases: angles that do not depend on the grid.
//!
//! Expected angles are those of the elastica, integrated by the Runge-Kutta method of fourth order:
//! with a plastic hinge at the moment M_y for a fold made by hand, with a kink for a crease.

use std::f64::consts::PI;

use sheetwork::World;
use sheetwork::sheet::Sheet;
use sheetwork_tests::world_of as world;

/// Largest difference of angles among grids that resolve the fold, and from the elastica, degrees.
const TOLERANCE: f64 = 5.0;

/// A strip whose ends, free to rotate, are brought from the distance `length` to `gap` (m).
#[derive(Clone, Copy)]
struct Fold {
    length: f64,
    gap: f64,
    thickness: f64,
    yield_stress: f64,
}

/// Modulus of the strips, Pa: paper.
const YOUNG: f64 = 4e9;

impl Fold {
    /// Curvature M_y/D at which the strip yields, 1/m.
    fn yield_curvature(&self) -> f64 {
        3.0 * self.yield_stress / (YOUNG * self.thickness)
    }

    /// World of the strip with `nodes` along it; the right end moves along a half circle until
    /// 1.1 s and is let go at 1.3 s.
    fn world(&self, nodes: u32) -> World {
        let Self { length, gap, thickness, yield_stress } = self;
        let (middle, radius) = (0.5 * (length + gap), 0.5 * (length - gap));
        let at = |k: u32| {
            let angle = PI * f64::from(k) / 24.0;
            let (x, y) = (middle + radius * angle.cos() - length, radius * angle.sin());
            format!("(time: {}, offset: ({x}, {y}, 0))", 0.1 + f64::from(k) / 24.0)
        };
        let path = (0..=24).map(at).collect::<Vec<_>>().join(", ");
        // The small curl decides to which side the strip bends.
        world(&format!(
            r#"(engine: "tr-bdf2", dt: 0.004166667, gravity: (0, 0, 0), sheets: [(name: "strip", structure: "shell",
                grid: ({nodes}, 1, 3), size: ({length}, {width}), curl: ({curl}, 0), plastic: true, material: (young: {YOUNG},
                poisson: 0, density: 800, thickness: {thickness}, damping_ratio: 0.2, yield_stress: {yield_stress}),
                pins: [(region: Rect((0, 0), (0, 1))), (region: Rect((1, 1), (0, 1)), until: 1.3, path: [{path}])])])"#,
            width = length / 6.0,
            curl = 0.003 / length,
        ))
    }

    /// Angle of the plastic hinge in the middle of the strip, degrees.
    fn hinge_angle(&self) -> f64 {
        let (half, limit) = (0.5 * self.length, self.yield_curvature());
        // Along the half from its end: κ = -q y, where q D is the force along the chord.
        let end = |[q, slope]: [f64; 2]| {
            let [x, y, turn] = integrate(half, [0.0, 0.0, slope], |_, [_, y, turn]| [turn.cos(), turn.sin(), -q * y]);
            (x, q * y, turn)
        };
        let (mut unknown, mut gap) = ([1.3 * (PI / self.length).powi(2), 1.0], 0.8 * self.length);
        let mut yields = false;
        loop {
            unknown = newton(unknown, |u| {
                let (x, curvature, turn) = end(u);
                [(2.0 * x - gap) / self.length, if yields { curvature / limit - 1.0 } else { turn }]
            });
            if !yields && end(unknown).1 > limit {
                yields = true;
            } else if gap <= self.gap {
                return 2.0 * end(unknown).2.to_degrees();
            } else {
                gap = (gap - 0.02 * self.length).max(self.gap);
            }
        }
    }
}

/// Values at `length` of the solution of y' = f(s, y), by 400 steps.
fn integrate(length: f64, start: [f64; 3], f: impl Fn(f64, [f64; 3]) -> [f64; 3]) -> [f64; 3] {
    let h = length / 400.0;
    let ahead = |y: [f64; 3], by: f64, k: [f64; 3]| [0, 1, 2].map(|i| y[i] + by * k[i]);
    (0..400).fold(start, |y, n| {
        let s = h * f64::from(n);
        let a = f(s, y);
        let b = f(s + 0.5 * h, ahead(y, 0.5 * h, a));
        let c = f(s + 0.5 * h, ahead(y, 0.5 * h, b));
        let d = f(s + h, ahead(y, h, c));
        ahead(y, h / 6.0, [0, 1, 2].map(|i| a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    })
}

/// Zero of `f` near `at`, by Newton's method with differences and steps of at most a fifth.
fn newton(mut at: [f64; 2], f: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
    for _ in 0..60 {
        let r = f(at);
        let small = [1e-6 * at[0].abs().max(1e-3), 1e-6];
        let (p, q) = (f([at[0] + small[0], at[1]]), f([at[0], at[1] + small[1]]));
        let [a, b, c, d] =
            [(p[0] - r[0]) / small[0], (q[0] - r[0]) / small[1], (p[1] - r[1]) / small[0], (q[1] - r[1]) / small[1]];
        let step = [(r[0] * d - r[1] * b) / (a * d - b * c), (a * r[1] - c * r[0]) / (a * d - b * c)];
        let scale = (5.0 * step[0].abs() / at[0].abs().max(1.0)).max(5.0 * step[1].abs()).max(1.0);
        at = [at[0] - step[0] / scale, at[1] - step[1] / scale];
    }
    at
}

/// Angle from the first to the last edge along the middle of a strip of `nodes` by `rows` nodes,
/// degrees, by the angles between neighbouring edges.
fn turned(sheet: &Sheet, nodes: usize, rows: usize) -> f64 {
    let at = |i: usize| sheet.state.x.get(rows / 2 * nodes + i);
    let edge = |i: usize| at(i + 1) - at(i);
    let bend = |i: usize| {
        let (a, b) = (edge(i), edge(i + 1));
        (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)
    };
    (0..nodes - 2).map(bend).sum::<f64>().to_degrees()
}

#[test]
fn a_folded_strip_keeps_one_angle_on_four_grids() {
    let strips = [
        Fold { length: 0.06, gap: 0.01, thickness: 1e-4, yield_stress: 1e7 },
        Fold { length: 0.06, gap: 0.004, thickness: 1e-4, yield_stress: 6e6 },
        Fold { length: 0.12, gap: 0.03, thickness: 3e-4, yield_stress: 1.2e7 },
    ];
    for (k, fold) in strips.iter().enumerate() {
        let wanted = fold.hinge_angle();
        for nodes in [13, 25, 49, 97] {
            let mut world = fold.world(nodes);
            world.advance(2.5);
            assert_eq!(world.report(0.0, &[]).sheets[0].unresolved_folds, None);
            let kept = turned(&world.sheets()[0], nodes as usize, 3).abs();
            println!("strip {k}, {nodes} nodes: {kept:.2}, elastica {wanted:.2}");
            assert!((kept - wanted).abs() < TOLERANCE, "strip {k}, {nodes} nodes: {kept}, not {wanted}");
        }
    }
}

#[test]
fn a_strip_folded_between_plates_keeps_one_angle_on_grids_that_resolve_it() {
    let kept = [49, 97].map(|nodes| {
        // The right end is led over the left third, then a plate presses the loop to 2 mm.
        let at = |k: u32| {
            let (part, angle) = (f64::from(k) / 24.0, PI * f64::from(k) / 24.0);
            let (x, y) = (0.024 * (angle.cos() - 1.0), 0.0258 * angle.sin() + 0.001 * part);
            format!("(time: {}, offset: ({x}, {y}, 0))", 0.1 + 0.9 * part)
        };
        let path = (0..=24).map(at).collect::<Vec<_>>().join(", ");
        let mut world = world(&format!(
            r#"(engine: "tr-bdf2", dt: 0.004166667, gravity: (0, 0, 0), sheets: [(name: "strip", structure: "shell",
                grid: ({nodes}, 1, 3), size: (0.06, 0.01), plastic: true, material: (young: {YOUNG}, poisson: 0.3,
                density: 800, thickness: 1e-4, damping_ratio: 0.2, yield_stress: 3e7),
                pins: [(region: Rect((0, 0.3334), (0, 1))), (region: Rect((1, 1), (0, 1)), until: 2.5, path: [{path}])])],
                bodies: [(shape: Box((0.2, 0.02, 0.1)), placement: (position: (0, 0.06, 0)), path: [(time: 0), (time: 1.3),
                (time: 1.6, offset: (0, -0.035, 0)), (time: 2.4, offset: (0, -0.048, 0)), (time: 2.6, offset: (0, -0.048, 0)),
                (time: 3)])])"#
        ));
        world.advance(4.0);
        assert_eq!(world.report(0.0, &[]).sheets[0].unresolved_folds, None);
        turned(&world.sheets()[0], nodes as usize, 3)
    });
    println!("between plates: {kept:?}");
    assert!(kept[0] > 40.0 && (kept[0] - kept[1]).abs() < TOLERANCE, "{kept:?}");
}

#[test]
fn cells_too_long_for_a_fold_are_reported_with_radius_and_cell() {
    let fold = Fold { length: 0.06, gap: 0.01, thickness: 1e-4, yield_stress: 3e7 };
    let radius = 1.0 / fold.yield_curvature();
    for (nodes, is_resolved) in [(13, false), (25, false), (49, true), (97, true)] {
        let report = fold.world(nodes).report(0.0, &[]);
        let found = report.sheets[0].unresolved_folds;
        assert_eq!(found.is_none(), is_resolved, "{nodes}: {found:?}");
        if let Some(found) = found {
            assert!((found.yield_radius_m / radius - 1.0).abs() < 1e-12, "{found:?}");
            assert!((found.cell_m * f64::from(nodes - 1) / 0.06 - 1.0).abs() < 1e-9, "{found:?}");
            assert!((found.resolving_cell_m / (0.4 * radius) - 1.0).abs() < 1e-12, "{found:?}");
        }
    }
}

/// Length (m), bending stiffness D (N m) and weight (N/m²) of the creased strip.
const CREASED: (f64, f64, f64) = (0.2, 4e9 * 2.7e-11 / 12.0, 9.81 * 800.0 * 3e-4);

/// Angle through which a clamped strip with a crease of `angle` (°) in its middle turns under its
/// weight, degrees.
fn elastica_with_kink(angle: f64) -> f64 {
    let (length, stiffness, weight) = CREASED;
    let half = 0.5 * length;
    let by_weight = |from: f64| {
        move |s: f64, [_, turn, curvature]: [f64; 3]| {
            [0.0, curvature, weight / stiffness * (length - from - s) * turn.cos()]
        }
    };
    let end = |root: f64| {
        let [_, turn, curvature] = integrate(half, [0.0, 0.0, root], by_weight(0.0));
        integrate(half, [0.0, turn + angle.to_radians(), curvature], by_weight(half))
    };
    // The curvature at the free end is zero; that at the root is found by the secant method.
    let (mut before, mut root) = (0.0, -1.0);
    for _ in 0..50 {
        let (f, g) = (end(before)[2], end(root)[2]);
        if (g - f).abs() < 1e-12 {
            break;
        }
        (before, root) = (root, root - g * (root - before) / (g - f));
    }
    end(root)[1].to_degrees()
}

#[test]
fn a_loaded_crease_opens_by_one_angle_on_any_grid() {
    for angle in [60.0, 120.0, -120.0, 150.0] {
        let wanted = elastica_with_kink(angle) - angle;
        for nodes in [21, 41, 81] {
            let mut world = world(&format!(
                r#"(engine: "tr-bdf2", dt: 0.0083333, sheets: [(name: "strip", structure: "shell", grid: ({nodes}, 1, 3),
                    size: ({}, 0.04), material: (young: 4e9, poisson: 0, density: 800, thickness: 3e-4),
                    creases: [(from: (0.5, 0), to: (0.5, 1), angle: {angle})], pins: [(region: Left, clamp: true)])])"#,
                CREASED.0
            ));
            let found = world.find_equilibrium(1e-9);
            assert!(found[0].converged, "{angle}, {nodes} nodes: {found:?}");
            let sheet = &world.sheets()[0];
            let first = sheet.state.x.get(nodes + 1) - sheet.state.x.get(nodes);
            let opened = turned(sheet, nodes, 3) + first.y.atan2(first.x).to_degrees() - angle;
            println!("crease {angle}, {nodes} nodes: {opened:.3}, elastica {wanted:.3}");
            assert!((opened / wanted - 1.0).abs() < 0.05, "{angle}, {nodes} nodes: {opened}, not {wanted}");
        }
    }
}
