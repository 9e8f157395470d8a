//! Every contact solver on problems whose forces follow from statics or from a two-line
//! calculation. A node that starts at rest on a surface moves by g h² in a stage of weight h
//! without contact, and a force p displaces it by h² p/m.

use std::f64::consts::FRAC_PI_6;

use glam::{DMat3, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::contact::solver::augmented_lagrangian::SolverConstraint;
use crate::contact::solver::delassus::frame_of;
use crate::contact::solver::test_problem::{Method, SmallProblem, SmallSolution};

/// Weight of the stage, s.
const H: f64 = 0.05;
/// Acceleration of gravity, m/s².
const G: f64 = 9.81;

const FRICTIONLESS: ContactLaw = ContactLaw::Coulomb(0.0);

/// Solve `problem` by every method. Each must converge to the forces `expected` (N).
fn assert_forces(problem: impl Fn() -> SmallProblem, expected: &[DVec3]) -> Vec<SmallSolution> {
    let scale = expected.iter().map(|p| p.length()).fold(f64::MIN_POSITIVE, f64::max);
    let solve = |method: Method| {
        let solved = problem().solve(method);
        assert!(solved.converged, "{method:?}");
        for (i, (force, expected)) in solved.force.iter().zip(expected).enumerate() {
            let error = force.distance(*expected) / scale;
            assert!(error < method.accuracy(), "{method:?}, contact {i}: {force}, expected {expected}");
        }
        solved
    };
    Method::ALL.into_iter().map(solve).collect()
}

/// A node of mass `m` (kg) on a floor, under the force `f` (N).
fn node_on_floor(m: f64, f: DVec3, friction: f64) -> SmallProblem {
    let law = ContactLaw::Coulomb(friction);
    SmallProblem::new(&[m], H).contact(0, None, DVec3::Y, f * (H * H / m), law)
}

#[test]
fn floor_carries_the_weight_of_a_node() {
    let m = 0.2;
    let weight = DVec3::new(0.0, -m * G, 0.0);
    for solved in assert_forces(|| node_on_floor(m, weight, 0.5), &[-weight]) {
        assert!(solved.u[0].length() < 1e-4 * G * H * H, "the node stays where it was: {}", solved.u[0]);
    }
}

#[test]
fn node_sticks_when_pulled_by_less_than_the_friction_bound() {
    let (m, mu) = (0.2, 0.5);
    // |F| = 0.9 μ m g, in an oblique direction of the floor.
    let pull = DVec3::new(0.6, 0.0, 0.8) * (0.9 * mu * m * G);
    let load = pull + DVec3::new(0.0, -m * G, 0.0);
    for solved in assert_forces(|| node_on_floor(m, load, mu), &[-load]) {
        assert!(solved.u[0].length() < 1e-4 * G * H * H, "{}", solved.u[0]);
    }
}

#[test]
fn node_slides_with_friction_mu_n_when_pulled_by_more() {
    let (m, mu, factor) = (0.2, 0.5, 1.7);
    let along = DVec3::new(-0.6, 0.0, 0.8);
    // F = 1.7 μ m g; friction is -μ N along F, and the rest of F accelerates the node.
    let load = along * (factor * mu * m * G) + DVec3::new(0.0, -m * G, 0.0);
    let reaction = DVec3::new(0.0, m * G, 0.0) - along * (mu * m * G);
    for (method, solved) in Method::ALL.into_iter().zip(assert_forces(|| node_on_floor(m, load, mu), &[reaction])) {
        let slip = along * ((factor - 1.0) * mu * G * H * H);
        assert!(solved.u[0].distance(slip) < 10.0 * method.accuracy() * G * H * H, "{method:?}: {}", solved.u[0]);
    }
}

#[test]
fn slope_holds_a_node_up_to_the_friction_angle() {
    let (m, angle) = (0.3, FRAC_PI_6);
    let normal = DVec3::new(-angle.sin(), angle.cos(), 0.0);
    let uphill = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let slope = |mu: f64| {
        let free = DVec3::new(0.0, -G * H * H, 0.0);
        SmallProblem::new(&[m], H).contact(0, None, normal, free, ContactLaw::Coulomb(mu))
    };
    // Stick: the reaction is the weight, with friction m g sin α.
    assert_forces(|| slope(1.2 * angle.tan()), &[DVec3::new(0.0, m * G, 0.0)]);
    // Slip: N = m g cos α, and friction μ N points uphill.
    let mu = 0.6 * angle.tan();
    assert_forces(|| slope(mu), &[(normal + uphill * mu) * (m * G * angle.cos())]);
}

#[test]
fn open_contact_has_no_force() {
    // The free motion opens the gap by 1 mm and slides by 3 mm.
    let problem = || {
        let free = DVec3::new(3e-3, 1e-3, 0.0);
        SmallProblem::new(&[0.2], H).contact(0, None, DVec3::Y, free, ContactLaw::Coulomb(0.5))
    };
    for method in Method::ALL {
        let solved = problem().solve(method);
        assert!(solved.converged, "{method:?}");
        // The interior point method approaches zero along its path.
        assert!(solved.force[0].length() < 1e-6 * 0.2 * G, "{method:?}: {}", solved.force[0]);
    }
}

#[test]
fn each_contact_of_a_stack_carries_the_weight_above_it() {
    let (below, above) = (0.2, 0.5);
    let stack = || {
        let fall = DVec3::new(0.0, -G * H * H, 0.0);
        SmallProblem::new(&[below, above], H)
            .contact(0, None, DVec3::Y, fall, FRICTIONLESS)
            // Both nodes fall alike, so that their free motion leaves their gap closed.
            .contact(1, Some(0), DVec3::Y, DVec3::new(0.0, -1e-12, 0.0), FRICTIONLESS)
    };
    let weights = [DVec3::new(0.0, (below + above) * G, 0.0), DVec3::new(0.0, above * G, 0.0)];
    assert_forces(stack, &weights);
}

#[test]
fn two_blocks_part_with_the_force_of_the_schur_complement() {
    let (m1, m2, overlap) = (0.2, 0.6, 4e-3);
    let blocks = || {
        let free = DVec3::new(-overlap, 0.0, 0.0);
        SmallProblem::new(&[m1, m2], H).contact(0, Some(1), DVec3::X, free, FRICTIONLESS)
    };
    // W = h² (1/m₁ + 1/m₂), p = overlap/W.
    let p = DVec3::new(overlap / (H * H * (1.0 / m1 + 1.0 / m2)), 0.0, 0.0);
    for solved in assert_forces(blocks, &[p]) {
        let momentum = solved.displacement[0] * m1 + solved.displacement[1] * m2;
        assert!(momentum.length() < 1e-12 * overlap * m1, "action equals reaction: {momentum}");
        let share = solved.displacement[0].x / overlap;
        assert!((share - m2 / (m1 + m2)).abs() < 1e-4, "displacements are as the inverse masses: {share}");
    }
}

#[test]
fn delassus_operator_of_three_blocks_in_a_line_is_the_schur_complement() {
    let [m1, m2, m3] = [0.2, 0.6, 0.3];
    let mut blocks = SmallProblem::new(&[m1, m2, m3], H);
    let constraints = [(0, 1), (1, 2)].map(|(a, b)| {
        let mut constraint = SolverConstraint::new(frame_of(DVec3::X), FRICTIONLESS);
        constraint.add(a, DMat3::IDENTITY);
        constraint.add(b, -DMat3::IDENTITY);
        constraint
    });
    let problem = blocks.tangent.dual_space(&constraints).delassus.problem;
    // Diagonal entries h² (1/m_a + 1/m_b); the contacts share block 2 with opposite signs:
    // -h²/m₂.
    let expected = [H * H * (1.0 / m1 + 1.0 / m2), H * H * (1.0 / m2 + 1.0 / m3), -H * H / m2];
    let (other, block) = problem.columns[0][0];
    let found = [problem.diagonal[0].x_axis.x, problem.diagonal[1].x_axis.x, block.x_axis.x];
    assert_eq!(other, 1);
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
}

#[test]
fn node_in_a_groove_presses_its_walls_as_statics_demand() {
    let (m, left, right) = (0.4, 0.5_f64, 0.9_f64);
    // Normals inclined from the vertical by α to the right and by β to the left.
    let normals = [DVec3::new(left.sin(), left.cos(), 0.0), DVec3::new(-right.sin(), right.cos(), 0.0)];
    let groove = || {
        let fall = DVec3::new(0.0, -G * H * H, 0.0);
        SmallProblem::new(&[m], H).contact(0, None, normals[0], fall, FRICTIONLESS).contact(
            0,
            None,
            normals[1],
            fall,
            FRICTIONLESS,
        )
    };
    // p₁ sin α = p₂ sin β and p₁ cos α + p₂ cos β = m g.
    let per = m * G / (left + right).sin();
    assert_forces(groove, &[normals[0] * (per * right.sin()), normals[1] * (per * left.sin())]);
}

#[test]
fn spring_under_contact_adds_its_stiffness() {
    let (m, k, depth) = (0.2, 300.0, 2e-3);
    let spring = || {
        let free = DVec3::new(0.0, -depth, 0.0);
        SmallProblem::new(&[m], H).spring(0, None, k).contact(0, None, DVec3::Y, free, FRICTIONLESS)
    };
    assert_forces(spring, &[DVec3::new(0.0, depth * (m / (H * H) + k), 0.0)]);
}

#[test]
fn contact_feels_a_node_behind_a_spring_through_the_schur_complement() {
    let (m1, m2, k, depth) = (0.2, 0.7, 300.0, 2e-3);
    let pair = || {
        let free = DVec3::new(0.0, -depth, 0.0);
        SmallProblem::new(&[m1, m2], H).spring(0, Some(1), k).contact(0, None, DVec3::Y, free, FRICTIONLESS)
    };
    // Stiffness H₁₁ - H₁₂ H₂₂⁻¹ H₂₁, with H₁₂ = -k.
    let behind = m2 / (H * H) + k;
    let stiffness = m1 / (H * H) + k - k * k / behind;
    for solved in assert_forces(pair, &[DVec3::new(0.0, depth * stiffness, 0.0)]) {
        let (first, second) = (solved.displacement[0].y, solved.displacement[1].y);
        assert!((second - first * k / behind).abs() < 1e-12, "H₂₂ δ₂ = k δ₁: {first} {second}");
    }
}

#[test]
fn attachment_pulls_as_well_as_it_pushes() {
    let m = 0.2;
    let free = DVec3::new(1e-3, 2e-3, -3e-3);
    let attached = || SmallProblem::new(&[m], H).contact(0, None, DVec3::Y, free, ContactLaw::Attachment);
    // u = 0 in every direction: p = -H b. The interior point method leaves attachments to the
    // penalty ρ of the augmented Lagrangian, 100 H along the normal and 10 H across it.
    let expected = free * (-m / (H * H));
    let penalised = expected * DVec3::new(10.0 / 11.0, 100.0 / 101.0, 10.0 / 11.0);
    for method in Method::ALL {
        let solved = attached().solve(method);
        let expected = if method == Method::InteriorPoint { penalised } else { expected };
        let error = solved.force[0].distance(expected) / expected.length();
        assert!(solved.converged && error < method.accuracy(), "{method:?}: {}", solved.force[0]);
    }
}

#[test]
fn warm_start_with_the_solution_ends_in_the_first_iteration() {
    let (m, mu) = (0.2, 0.5);
    let down = DVec3::new(0.0, -m * G, 0.0);
    for factor in [0.7, 1.7] {
        let load = down + DVec3::new(factor * mu * m * G, 0.0, 0.0);
        let solution = -down - DVec3::new(f64::min(factor, 1.0) * mu * m * G, 0.0, 0.0);
        for method in [Method::Primal, Method::Dual, Method::Pgs, Method::AlartCurnier] {
            let cold = node_on_floor(m, load, mu).solve(method);
            let warm = node_on_floor(m, load, mu).solve_from(method, &[solution], factor > 1.0);
            assert!(warm.converged && warm.force[0].distance(solution) < 1e-7 * m * G, "{method:?}: {warm:?}");
            // Computing the initial displacement is one Newton step, checking the forces one sweep.
            let least = if method == Method::AlartCurnier { 0 } else { 1 };
            assert_eq!(warm.iterations, least, "{method:?}, pull {factor}");
            assert!(cold.iterations > least, "{method:?}, pull {factor}");
        }
    }
}

#[test]
fn contradicting_contacts_do_not_converge() {
    // A node between a floor and a ceiling that overlap by 2 mm: no position satisfies both.
    let pinched = || {
        SmallProblem::new(&[0.2], H).contact(0, None, DVec3::Y, DVec3::new(0.0, -1e-3, 0.0), FRICTIONLESS).contact(
            0,
            None,
            DVec3::NEG_Y,
            DVec3::new(0.0, 1e-3, 0.0),
            FRICTIONLESS,
        )
    };
    for method in Method::ALL {
        let solved = pinched().solve(method);
        assert!(!solved.converged, "{method:?}: {solved:?}");
    }
}
