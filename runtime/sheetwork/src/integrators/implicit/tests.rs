//! Newton method and stages on one node with one spring, whose solutions are known in closed form.

use crate::elements::{Anchor, Geometric};
use crate::integrators::implicit::newton::{NewtonReport, NewtonWorkspace, solve};
use crate::integrators::implicit::{ImplicitProblem, StageProblem};
use crate::integrators::{Forces, TABLE};
use crate::linear::NotPositiveDefinite;
use crate::math::Vectors;
use crate::scene::IntegratorKind;

/// Elastic force (N) and stiffness (N/m) at a displacement (m), and the energy (J) there.
type SpringLaw = fn(f64) -> [f64; 3];

/// A node of mass `mass` (kg) that moves along x, on a spring.
struct Oscillator {
    mass: f64,
    spring: SpringLaw,
    /// 1/h of the present stage, 1/s.
    per_time: f64,
}

impl Oscillator {
    fn new(mass: f64, spring: SpringLaw) -> Self {
        Self { mass, spring, per_time: 0.0 }
    }
}

impl ImplicitProblem for Oscillator {
    fn begin_stage(&mut self, per_time: f64, _anchors: &[Anchor], _follow: f64, _x: &Vectors, _v: &Vectors) {
        self.per_time = per_time;
    }

    fn finish_stage(&mut self, _x: &Vectors) {}

    fn reset_rates(&mut self) {}

    fn potential(&mut self, stage: &StageProblem, x: &Vectors) -> f64 {
        self.inertial_potential(stage, x) + (self.spring)(x.x[0])[2]
    }

    fn inertial_potential(&self, stage: &StageProblem, x: &Vectors) -> f64 {
        0.5 * self.mass * (stage.per_time * (x.x[0] - stage.y.x[0])).powi(2)
    }

    fn kinetic_energy_at(&self, speed: f64) -> f64 {
        0.5 * self.mass * speed * speed
    }

    fn newton_direction(
        &mut self,
        stage: &StageProblem,
        x: &Vectors,
        geometric: Geometric,
        d: &mut Vectors,
    ) -> Result<f64, NotPositiveDefinite> {
        let [force, stiffness, _] = (self.spring)(x.x[0]);
        let stiffness = if geometric == Geometric::Clipped { stiffness.max(0.0) } else { stiffness };
        let inertia = self.mass * stage.per_time * stage.per_time;
        let gradient = inertia * (x.x[0] - stage.y.x[0]) + force;
        if inertia + stiffness <= 0.0 {
            return Err(NotPositiveDefinite);
        }
        d.clear();
        d.x[0] = -gradient / (inertia + stiffness);
        Ok(gradient * d.x[0])
    }

    /// The energy of the force that the linear solution misses, ½ Δf²/(m/h² + k).
    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        let [force, stiffness, _] = (self.spring)(x.x[0]);
        let missed = (self.spring)(x.x[0] + d.x[0])[0] - force - stiffness * d.x[0];
        0.5 * missed * missed / (self.mass * self.per_time * self.per_time + stiffness)
    }

    fn update_stress(&mut self, _x: &Vectors) {}

    fn zero_prescribed(&self, _a: &mut Vectors) {}

    fn copy_prescribed(&self, _x: &Vectors, _to: &mut Vectors) {}

    /// Reports no internal acceleration, so that integrators start from these accelerations.
    fn accelerations(&mut self, x: &Vectors, _v: &Vectors, a: &mut Vectors) -> f64 {
        a.x[0] = -(self.spring)(x.x[0])[0] / self.mass;
        0.0
    }
}

impl Forces for Oscillator {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        ImplicitProblem::accelerations(self, x, v, a);
    }

    fn implicit(&mut self) -> Option<&mut dyn ImplicitProblem> {
        Some(self)
    }
}

fn at(x: f64) -> Vectors {
    Vectors { x: vec![x], y: vec![0.0], z: vec![0.0] }
}

/// Solve a stage with 1/h = `per_time` and y = `y` from the present position `before`, with the
/// guess y. Returns the report and the solution.
fn solve_stage(problem: &mut Oscillator, per_time: f64, y: f64, before: f64) -> (NewtonReport, f64) {
    let (y, before) = (at(y), at(before));
    let mut x = y.clone();
    problem.begin_stage(per_time, &[], 0.0, &before, &before);
    let stage = StageProblem { per_time, y: &y, w: &before };
    let report = solve(problem, &stage, &before, &mut x, &mut NewtonWorkspace::default());
    (report, x.x[0])
}

#[test]
fn linear_stage_converges_in_one_step() {
    let (m, per_time, y) = (2.0, 10.0, 0.3);
    let mut problem = Oscillator::new(m, |x| [50.0 * x, 50.0, 25.0 * x * x]);
    let (report, x) = solve_stage(&mut problem, per_time, y, 0.0);
    assert_eq!(report, NewtonReport { solves: 1, globalised: false });
    // m (x - y)/h² + k x = 0.
    let inertia = m * per_time * per_time;
    assert!((x - inertia * y / (inertia + 50.0)).abs() < 1e-16, "{x}");
}

#[test]
fn cubic_spring_takes_the_steps_of_newtons_recurrence() {
    // x - 2 + x³ = 0 has the root 1. Φ(0) = 2 is less than Φ(2) = 4, so that the iteration
    // starts at 0 and follows x ← (2 x³ + 2)/(3 x² + 1): 0, 2, 1.3846, 1.0826, 1.0048, 1.00002.
    // The force missed by the fourth step is 0.0192 N, with an energy of 0.0192²/(2 · 4.52) =
    // 4.1e-5 J. That of the third is 9.1e-3 J, and the tolerance is 1e-4 of the inertial energy 2
    // J.
    let mut problem = Oscillator::new(1.0, |x| [x * x * x, 3.0 * x * x, 0.25 * x.powi(4)]);
    let (report, x) = solve_stage(&mut problem, 1.0, 2.0, 0.0);
    let expected = (0..4).fold(0.0_f64, |x, _| (2.0 * x * x * x + 2.0) / (3.0 * x * x + 1.0));
    assert_eq!(report, NewtonReport { solves: 4, globalised: false });
    assert!((x - expected).abs() < 1e-14 && (x - 1.0).abs() < 5e-3, "{x} {expected}");
}

#[test]
fn stage_on_which_full_steps_diverge_is_solved_by_the_globalised_method() {
    // Full steps on √(1 + x²) map x to about -x³ and diverge from 3; inertia is negligible.
    let mut problem = Oscillator::new(1e-3, |x| {
        let root = (1.0 + x * x).sqrt();
        [x / root, 1.0 / (root * root * root), root]
    });
    let (report, x) = solve_stage(&mut problem, 1.0, 3.0, 3.0);
    assert!(report.globalised, "{report:?}");
    // The gradient 1e-3 (x - 3) + x/√(1 + x²) vanishes at x = 0.003 to first order. The last
    // step lowers Φ, about 1 + x²/2, by less than 1e-3 of its whole fall √10 - 1 = 2.2: it
    // starts within 0.07 of the solution and ends within the cube of that, 3e-4.
    assert!((x - 3e-3).abs() < 4e-4, "{x}");
}

#[test]
fn globalised_method_does_not_raise_the_potential() {
    let mut problem = Oscillator::new(1e-3, |x| {
        let root = (1.0 + x * x).sqrt();
        [x / root, 1.0 / (root * root * root), root]
    });
    for start in [1.5, 5.0, 40.0, -7.0] {
        let (_, x) = solve_stage(&mut problem, 1.0, start, start);
        let y = at(start);
        let stage = StageProblem { per_time: 1.0, y: &y, w: &y };
        let (before, after) = (problem.potential(&stage, &at(start)), problem.potential(&stage, &at(x)));
        assert!(after <= before, "from {start} to {x}: {before} {after}");
    }
}

#[test]
fn non_finite_state_is_returned_without_a_solve() {
    let mut problem = Oscillator::new(1.0, |x| [x, 1.0, 0.5 * x * x]);
    let (report, x) = solve_stage(&mut problem, 1.0, f64::NAN, f64::NAN);
    assert_eq!(report, NewtonReport::default());
    assert!(x.is_nan());
}

/// Displacement and scaled velocity (x, v/ω) after `steps` steps of x'' = -ω² x from (1, 0),
/// with ω dt = `angle`.
fn oscillate(kind: IntegratorKind, angle: f64, steps: u32) -> [f64; 2] {
    let omega: f64 = 5.0;
    let mut problem = Oscillator::new(1.0, |x| [25.0 * x, 25.0, 12.5 * x * x]);
    let mut integrator = kind.construct();
    let (mut x, mut v) = (at(1.0), at(0.0));
    for _ in 0..steps {
        let report = integrator.advance(&mut problem, 0.0, angle / omega, &mut x, &mut v);
        assert_eq!(report.globalised, 0);
    }
    [x.x[0], v.x[0] / omega]
}

/// Product of complex numbers.
fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// Quotient of complex numbers.
fn over(a: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    times(a, [c / (c * c + d * d), -d / (c * c + d * d)])
}

/// Check that `steps` steps multiply x + i v/ω, which obeys c' = -iω c, by the powers of
/// R(-iω dt) = `factor`, and that the table of integrators says the same.
fn assert_amplification(kind: IntegratorKind, angle: f64, factor: [f64; 2]) {
    let mut expected = [1.0, 0.0];
    for steps in 1..=5 {
        expected = times(expected, factor);
        let found = oscillate(kind, angle, steps);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{kind:?}, ω dt = {angle}, {steps}: {found} {expected}");
        }
    }
    let row = TABLE.iter().find(|row| row.kind == kind).expect("in the table");
    let (remaining, advance) = row.amplification.expect("implicit")(angle);
    assert!((remaining - factor[0].hypot(factor[1])).abs() < 1e-14, "{kind:?}");
    assert!((advance + factor[1].atan2(factor[0])).abs() < 1e-14, "{kind:?}");
}

#[test]
fn backward_euler_multiplies_an_oscillation_by_its_stability_function() {
    for angle in [0.1, 1.0, 20.0] {
        // R(z) = 1/(1 - z).
        assert_amplification(IntegratorKind::BackwardEuler, angle, over([1.0, 0.0], [1.0, angle]));
    }
}

#[test]
fn tr_bdf2_multiplies_an_oscillation_by_its_stability_function() {
    let g = 2.0 - std::f64::consts::SQRT_2;
    for angle in [0.1, 1.0, 20.0] {
        // R(z) = (1 + z (1 + (1-γ)²)/(2 (2-γ)))/(1 - γ z/2)².
        let numerator = [1.0, -angle * (1.0 + (1.0 - g).powi(2)) / (2.0 * (2.0 - g))];
        let root = [1.0, 0.5 * g * angle];
        assert_amplification(IntegratorKind::TrBdf2, angle, over(numerator, times(root, root)));
    }
}

#[test]
fn bdf2_obeys_its_recurrence_after_a_step_of_backward_euler() {
    for angle in [0.1, 1.0, 20.0] {
        // With z = -iω dt: c₁ = c₀/(1 - z), and (3/2 - z) c₂ = 2 c₁ - c₀/2.
        let mut before = [1.0, 0.0];
        let mut last = over(before, [1.0, angle]);
        for steps in 1..=5 {
            let found = oscillate(IntegratorKind::Bdf2, angle, steps);
            for (found, expected) in found.into_iter().zip(last) {
                assert!((found - expected).abs() < 1e-13, "ω dt = {angle}, {steps}: {found} {expected}");
            }
            let sum = [2.0 * last[0] - 0.5 * before[0], 2.0 * last[1] - 0.5 * before[1]];
            (before, last) = (last, over(sum, [1.5, angle]));
        }
    }
}

#[test]
fn stages_of_tr_bdf2_fill_the_step_with_one_weight() {
    // Both stages weight the new acceleration with h = γ dt/2, so that one factorisation serves.
    let (dt, g) = (0.02, 2.0 - std::f64::consts::SQRT_2);
    let mut problem = Oscillator::new(1.0, |x| [x, 1.0, 0.5 * x * x]);
    let mut integrator = IntegratorKind::TrBdf2.construct();
    let scheme = integrator.staged().expect("implicit");
    let (mut x, mut v) = (at(1.0), at(0.5));
    scheme.begin(&mut problem, dt, &x, &v);
    for k in 0..scheme.stages() {
        let mut guess = at(0.0);
        scheme.prepare(&mut problem, k, dt, (&x, &v), &mut guess);
        assert!((1.0 / scheme.stage().per_time - 0.5 * g * dt).abs() < 1e-17);
        scheme.finish(&mut problem, k, dt, &guess, None, (&mut x, &mut v));
    }
    assert_eq!(scheme.stages(), 2);
    assert!((scheme.length(0, dt) + scheme.length(1, dt) - dt).abs() < 1e-17);
}
