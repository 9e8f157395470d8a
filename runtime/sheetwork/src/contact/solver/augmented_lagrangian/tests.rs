//! Tests of the augmented Lagrangian solver: primal and dual form give the same solution, which
//! obeys Coulomb's law.

use std::ops::Range;

use glam::{DMat3, DVec2, DVec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

use crate::contact::coulomb::ContactLaw;
use crate::contact::solver::augmented_lagrangian::{
    AugmentedLagrangian, AugmentedLagrangianTolerances, PrimalSpace, SolverConstraint, TangentMatrix, UnknownSpace,
};
use crate::contact::solver::delassus::frame_of;
use crate::contact::solver::test_problem::SmallTangent;

const BLOCKS: u32 = 6;

type DrawnProblem = ([f64; 6], [[f64; 3]; 6], [[f64; 3]; 5], [[f64; 3]; 5], f64);

/// A chain of nodes of mass 1, each joined to the next by a spring with stiffness `along` in its
/// direction and a tenth of it across.
fn node_chain(along: [f64; BLOCKS as usize], directions: [[f64; 3]; BLOCKS as usize]) -> SmallTangent {
    let mut chain = SmallTangent::new(BLOCKS);
    for i in 0..BLOCKS {
        chain.add(i, i, DMat3::IDENTITY);
        let d = DVec3::from(directions[i as usize]).try_normalize().unwrap_or(DVec3::X);
        let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        let k = (outer * 0.9 + DMat3::IDENTITY * 0.1) * along[i as usize];
        if i + 1 < BLOCKS {
            chain.add_spring(i, Some(i + 1), k);
        }
    }
    chain
}

/// Contacts of the first nodes with walls, and of the last two nodes with each other.
fn rows(chain: &SmallTangent, normals: &[[f64; 3]], gaps: &[[f64; 3]], friction: f64) -> Vec<SolverConstraint> {
    let make = |(i, (normal, gap)): (usize, (&[f64; 3], &[f64; 3]))| {
        let normal = DVec3::from(*normal).try_normalize().unwrap_or(DVec3::Y);
        let mut row = SolverConstraint::new(frame_of(normal), ContactLaw::Coulomb(friction));
        row.add(i as u32, DMat3::IDENTITY);
        if i == 4 {
            row.add(5, -DMat3::IDENTITY);
        }
        row.b = 0.01 * DVec3::from(*gap);
        row.compute_stiffness(|block| chain.diagonal(block));
        row
    };
    normals.iter().zip(gaps).enumerate().map(make).collect()
}

fn solve(space: &mut dyn UnknownSpace, rows: &[SolverConstraint]) -> Option<(Vec<DVec3>, Vec<DVec3>)> {
    let mut primal = AugmentedLagrangian::default();
    primal.constraints.extend_from_slice(rows);
    primal.force.resize(rows.len(), DVec3::ZERO);
    let accuracy = AugmentedLagrangianTolerances {
        gap: 1e-10,
        balance: 1e-10,
        maximum_bound_updates: 60,
        interior_point_iteration: 200,
        ..AugmentedLagrangianTolerances::SINGLE_SHEET.scaled(2.5e-4)
    };
    primal.solve(space, &accuracy).then_some((primal.force, primal.u))
}

/// Violation of Coulomb's law by forces `p` and relative displacements `u`, as a fraction of the
/// total normal force: friction above the bound, and friction below the bound in slip.
fn law_violation(p: &[DVec3], u: &[DVec3], friction: f64) -> f64 {
    let all: f64 = p.iter().map(|p| p.x).sum();
    let off = |(p, u): (&DVec3, &DVec3)| {
        let (force, slip) = (DVec2::new(p.y, p.z).length(), DVec2::new(u.y, u.z).length());
        let beyond = force - friction * p.x;
        (if slip > 1e-5 { beyond.abs() } else { beyond.max(0.0) }) / all.max(f64::MIN_POSITIVE)
    };
    p.iter().zip(u).map(off).fold(0.0, f64::max)
}

/// Check that both forms give the same solution, which obeys Coulomb's law within the tolerance of
/// the friction bounds.
fn check_agreement(
    mut chain: SmallTangent,
    normals: &[[f64; 3]],
    gaps: &[[f64; 3]],
    friction: f64,
) -> Result<(), TestCaseError> {
    let mut rows = rows(&chain, normals, gaps, friction);
    let by_forces = solve(&mut chain.dual_space(&rows), &rows);
    let mut slots = Vec::new();
    rows.iter_mut().for_each(|row| row.look_up_slots(chain.pattern(), &mut slots));
    let by_masses = solve(&mut PrimalSpace { tangent: &mut chain, slots: &slots }, &rows);
    // The fixed-point iteration on friction bounds need not converge from every initial value;
    // converged solutions agree.
    prop_assume!(by_forces.is_some() && by_masses.is_some());
    let ((p, u), (q, v)) = (by_forces.unwrap_or_default(), by_masses.unwrap_or_default());
    let all: f64 = p.iter().map(|p| p.x).sum();
    for i in 0..rows.len() {
        prop_assert!((p[i] - q[i]).length() <= 5e-3 * all, "force {i}: {} {}", p[i], q[i]);
        prop_assert!((u[i] - v[i]).length() < 1e-5, "gap {i}: {} {}", u[i], v[i]);
        prop_assert!(p[i].x >= 0.0 && u[i].x > -1e-8 && p[i].x.min(u[i].x) < 1e-8);
        let (force, slip) = (DVec2::new(p[i].y, p[i].z), DVec2::new(u[i].y, u[i].z));
        prop_assert!(force.length() <= friction * (p[i].x + 5e-3 * all));
        prop_assert!(slip.length() < 1e-5 || force.dot(slip) <= 1e-6 * all * slip.length());
    }
    Ok(())
}

/// Strategy for springs, directions, normals, gaps and friction, with a fixed seed.
fn draws(friction: Range<f64>) -> (TestRunner, impl Strategy<Value = DrawnProblem>) {
    let config = ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() };
    let runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let vector = || prop::array::uniform3(-1.0..1.0_f64);
    let drawn = (
        prop::array::uniform6(1.0..100.0_f64),
        prop::array::uniform6(vector()),
        prop::array::uniform5(vector()),
        prop::array::uniform5(vector()),
        friction,
    );
    (runner, drawn)
}

#[test]
fn primal_and_dual_agree_and_obey_coulombs_law() {
    let (mut runner, draws) = draws(0.0..0.4);
    let done = runner.run(&draws, |(along, directions, normals, gaps, friction)| {
        check_agreement(node_chain(along, directions), &normals, &gaps, friction)
    });
    done.unwrap_or_else(|e| panic!("{e}"));
}

/// With friction this large, unrelaxed friction bounds oscillate in some problems.
#[test]
fn oscillating_friction_bounds_converge() {
    let (mut runner, draws) = draws(0.5..1.0);
    let accuracy = AugmentedLagrangianTolerances {
        gap: 1e-10,
        balance: 1e-10,
        maximum_bound_updates: 12,
        interior_point_iteration: 60,
        ..AugmentedLagrangianTolerances::SINGLE_SHEET.scaled(2.5e-4)
    };
    let (mut settled, mut kept) = (0, 0);
    for _ in 0..300 {
        let tree = draws.new_tree(&mut runner).expect("no filter");
        let (along, directions, normals, gaps, friction) = tree.current();
        let mut chain = node_chain(along, directions);
        let mut rows = rows(&chain, &normals, &gaps, friction);
        let mut slots = Vec::new();
        rows.iter_mut().for_each(|row| row.look_up_slots(chain.pattern(), &mut slots));
        let mut primal = AugmentedLagrangian {
            constraints: rows.clone(),
            force: vec![DVec3::ZERO; rows.len()],
            ..AugmentedLagrangian::default()
        };
        if primal.solve(&mut PrimalSpace { tangent: &mut chain, slots: &slots }, &accuracy) {
            settled += 1;
            kept += u32::from(law_violation(&primal.force, &primal.u, friction) < 5e-3);
        }
    }
    println!("{settled} settled, {kept} by the law");
    assert!(kept >= 290, "{settled} settled, {kept} by the law");
}
