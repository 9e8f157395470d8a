//! Stages of a few nodes and bodies whose contact forces follow from statics. With backward Euler,
//! a node at rest falls by g h² in a stage without contact, and its tangent is m/h².

use glam::DVec3;

use super::*;
use crate::collision::constraint::ContactConstraint;
use crate::contact::gap::node_side;
use crate::contact::solver::choice::PositionSolver;
use crate::contact::test_island::{TestIsland, ball, body_side, contact, fixed_body, loose_nodes, on_plane};
use crate::scene::IntegratorKind;
use crate::serialize::{StateReader, StateWriter};

const DT: f64 = 0.01;
const G: f64 = 9.81;
const M: f64 = 0.2;
const GRAVITY: DVec3 = DVec3::new(0.0, -G, 0.0);

/// Numbers of nodes along a side with which a single contact goes to the primal and to the dual
/// solver.
const SIDES: [(u32, PositionSolver); 2] = [(2, PositionSolver::Primal), (5, PositionSolver::Dual)];

/// Force (N) that moves a node by the gap tolerance of a single sheet, 2e-7 m.
const TOLERANCE: f64 = 2e-7 * M / (DT * DT);

/// Nodes at rest on a static plane.
fn nodes_on_plane(side: u32, gravity: DVec3) -> TestIsland {
    let sheet = loose_nodes(side, M, &[], IntegratorKind::BackwardEuler);
    TestIsland::new(vec![sheet], vec![fixed_body()], gravity)
}

fn with_friction(friction: f64, contact: ContactConstraint) -> ContactConstraint {
    ContactConstraint { friction, ..contact }
}

#[test]
fn plane_carries_the_weight_of_a_node() {
    for (side, solver) in SIDES {
        let mut island = nodes_on_plane(side, GRAVITY);
        let floor = on_plane(0, DVec3::Y);
        assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
        assert_eq!(island.workspace.position_solver, solver);
        assert!(island.force(&floor).distance(DVec3::Y * (M * G)) < TOLERANCE, "{}", island.force(&floor));
        assert!(island.iterate(0).length() < 2e-7, "the node rests: {}", island.iterate(0));
        let fallen = island.iterate(1) - DVec3::X;
        assert!(fallen.distance(GRAVITY * (DT * DT)) < 1e-12, "its neighbour falls: {fallen}");
    }
}

#[test]
fn stage_without_overlap_converges_without_contact() {
    // The node falls by g h² and ends 1 % of that above the plane.
    let mut island = nodes_on_plane(2, GRAVITY);
    let far = ContactConstraint { offset: -1.01 * G * DT * DT, ..on_plane(0, DVec3::Y) };
    assert_eq!(island.solve_stage(DT, &[far]), StageSolve::ConvergedWithoutContact);
    assert_eq!(island.force(&far), DVec3::ZERO);
    assert!(island.iterate(0).distance(GRAVITY * (DT * DT)) < 1e-12, "{}", island.iterate(0));
}

#[test]
fn trapezoidal_stage_balances_stored_and_new_acceleration() {
    // x₁ - x₀ = h² (a₀ + a₁) with h = γ dt/2, so that the free motion is 2 h² g and p =
    // 2 m g.
    let sheet = loose_nodes(2, M, &[], IntegratorKind::TrBdf2);
    let mut island = TestIsland::new(vec![sheet], vec![fixed_body()], GRAVITY);
    let floor = on_plane(0, DVec3::Y);
    assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
    let h = (2.0 - std::f64::consts::SQRT_2) * DT / 2.0;
    let tolerance = 2e-7 * M / (h * h);
    assert!(island.force(&floor).distance(DVec3::Y * (2.0 * M * G)) < tolerance, "{}", island.force(&floor));
}

#[test]
fn node_sticks_below_the_friction_bound_and_slides_above_it() {
    let mu = 0.4;
    for (side, _) in SIDES {
        for pull in [0.8, 1.5] {
            // Gravity is inclined so that it pulls along the plane with the given part of μ m g.
            let gravity = DVec3::new(pull * mu * G, -G, 0.0);
            let mut island = nodes_on_plane(side, gravity);
            let floor = with_friction(mu, on_plane(0, DVec3::Y));
            assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
            let expected = DVec3::new(-f64::min(pull, 1.0) * mu * M * G, M * G, 0.0);
            assert!(island.force(&floor).distance(expected) < 2.0 * TOLERANCE, "{pull}: {}", island.force(&floor));
            let slip = f64::max(pull - 1.0, 0.0) * mu * G * DT * DT;
            assert!((island.iterate(0).x - slip).abs() < 4e-7, "{pull}: {}", island.iterate(0).x);
        }
    }
}

#[test]
fn impact_returns_the_approach_speed_times_the_restitution() {
    for (side, _) in SIDES {
        for (speed, restitution, after) in [(1.0, 0.6, 0.6), (1.0, 0.0, 0.0), (0.1, 0.6, 0.0)] {
            // Below 0.2 m/s a contact counts as resting.
            let mut island = nodes_on_plane(side, GRAVITY);
            island.sheets[0].state.v.set(0, DVec3::new(0.0, -speed, 0.0));
            let floor = ContactConstraint { restitution, ..on_plane(0, DVec3::Y) };
            assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
            island.finish_stage(DT);
            let v = island.sheets[0].state.v.get(0).y;
            // The gap tolerance, 2e-7 m and 5e-5 of the penetration, per stage.
            let tolerance = (2e-7 + 5e-5 * speed * DT) / DT;
            assert!((v - after).abs() < 2.0 * tolerance, "{speed} {restitution}: {v}");
        }
    }
}

#[test]
fn friction_in_an_impact_takes_mu_times_the_normal_impulse() {
    let (mu, speed, along) = (0.3, 2.0, 3.0);
    for (side, _) in SIDES {
        let mut island = nodes_on_plane(side, DVec3::ZERO);
        island.sheets[0].state.v.set(0, DVec3::new(along, -speed, 0.0));
        let floor = ContactConstraint { restitution: 0.5, ..with_friction(mu, on_plane(0, DVec3::Y)) };
        assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
        island.finish_stage(DT);
        // Normal impulse m (1 + e) v; friction impulse μ times that.
        let expected = DVec3::new(along - mu * 1.5 * speed, 0.5 * speed, 0.0);
        assert!(
            island.sheets[0].state.v.get(0).distance(expected) < 1e-3 * speed,
            "{}",
            island.sheets[0].state.v.get(0)
        );
    }
}

#[test]
fn contact_on_a_spring_bears_inertia_and_spring() {
    // Node 0 hangs 1 m below the fixed node 1; the plane lies `depth` above node 0.
    let (k, depth) = (1e4, 1e-3);
    for (side, _) in SIDES {
        let mut sheet = loose_nodes(side, M, &[(0, 1, k, 1.0)], IntegratorKind::BackwardEuler);
        sheet.state.x.set(1, DVec3::Y);
        sheet.inverse_mass[1] = 0.0;
        let mut island = TestIsland::new(vec![sheet], vec![fixed_body()], DVec3::ZERO);
        let floor = ContactConstraint { offset: depth, ..on_plane(0, DVec3::Y) };
        assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
        let stiffness = M / (DT * DT) + k;
        let force = island.force(&floor);
        assert!(force.distance(DVec3::Y * (stiffness * depth)) < 2.5e-7 * stiffness, "{force}");
    }
}

#[test]
fn stacked_ball_and_node_press_with_their_weights() {
    // A ball of 0.5 kg on node 0, which rests on the plane.
    let above = 0.5;
    let mut island = nodes_on_plane(5, GRAVITY);
    let mut ball = ball(above, DVec3::new(0.0, 0.1, 0.0));
    ball.begin(ball.start.displaced(GRAVITY * (DT * DT), DVec3::ZERO));
    island.bodies.push(ball);
    let floor = on_plane(0, DVec3::Y);
    let on_node = contact(1, node_side(0, 0), body_side(1, DVec3::new(0.0, -0.1, 0.0)), DVec3::NEG_Y);
    assert_eq!(island.solve_stage(DT, &[floor, on_node]), StageSolve::Converged);
    let (below, top) = (island.force(&floor), island.force(&on_node));
    let tolerance = 1e-6 * (M + above) / (DT * DT);
    assert!(below.distance(DVec3::Y * ((M + above) * G)) < tolerance, "{below}");
    assert!(top.distance(DVec3::NEG_Y * (above * G)) < tolerance, "{top}");
    let lifted = island.bodies[1].displacement;
    assert!(lifted.distance(-GRAVITY * (DT * DT)) < 1e-6, "the ball stays on the node: {lifted}");
}

#[test]
fn nodes_of_two_sheets_part_with_the_force_of_the_schur_complement() {
    let (m1, m2, overlap) = (M, 3.0 * M, 1e-3);
    let sheets = [m1, m2].map(|m| loose_nodes(4, m, &[], IntegratorKind::BackwardEuler)).into_iter().collect();
    let mut island = TestIsland::new(sheets, vec![], DVec3::ZERO);
    island.workspace.policy.accepts_unconverged = true;
    let pair = contact(0, node_side(0, 0), node_side(1, 0), DVec3::Y);
    let pair = ContactConstraint { offset: overlap, ..pair };
    assert_eq!(island.solve_stage(DT, &[pair]), StageSolve::Converged);
    // p = overlap/(h² (1/m₁ + 1/m₂)); the gap tolerance of several sheets is 1 % of the
    // overlap.
    let expected = overlap / (DT * DT * (1.0 / m1 + 1.0 / m2));
    let force = island.force(&pair);
    assert!((force - DVec3::Y * expected).length() < 1e-2 * expected, "{force} {expected}");
    let moved: Vec<DVec3> = island.sheets.iter().map(|s| s.work.stage.iterate.get(0) - s.state.x.get(0)).collect();
    assert!((moved[0] * m1 + moved[1] * m2).length() < 1e-12 * overlap * m1, "action equals reaction: {moved:?}");
}

#[test]
fn node_in_a_groove_presses_both_planes_as_statics_demand() {
    let (left, right) = (0.5_f64, 0.9_f64);
    let normals = [DVec3::new(left.sin(), left.cos(), 0.0), DVec3::new(-right.sin(), right.cos(), 0.0)];
    for (side, _) in SIDES {
        let mut island = nodes_on_plane(side, GRAVITY);
        let walls = [0, 1].map(|i| contact(i, node_side(0, 0), body_side(0, DVec3::ZERO), normals[i as usize]));
        assert_eq!(island.solve_stage(DT, &walls), StageSolve::Converged);
        // p₁ sin α = p₂ sin β and p₁ cos α + p₂ cos β = m g.
        let per = M * G / (left + right).sin();
        let expected = [normals[0] * (per * right.sin()), normals[1] * (per * left.sin())];
        for (wall, expected) in walls.iter().zip(expected) {
            let force = island.force(wall);
            assert!(force.distance(expected) < 2.0 * TOLERANCE / (left + right).sin(), "{force} {expected}");
        }
    }
}

#[test]
fn warm_start_needs_one_newton_step_per_solve() {
    for (side, _) in SIDES {
        let floor = with_friction(0.4, on_plane(0, DVec3::Y));
        let gravity = DVec3::new(0.2 * G, -G, 0.0);
        let mut island = nodes_on_plane(side, gravity);
        island.solve_stage(DT, &[floor]);
        let cold = island.workspace.counters;
        assert!(cold.newton > cold.rounds, "{cold:?}");
        assert_eq!(island.solve_stage(DT, &[floor]), StageSolve::Converged);
        let warm = island.workspace.counters;
        assert_eq!(warm.newton - cold.newton, warm.rounds - cold.rounds, "{cold:?} {warm:?}");
    }
}

#[test]
fn contradicting_contacts_end_at_the_iteration_limit() {
    for (side, _) in SIDES {
        // Floor and ceiling overlap by 2 mm, and the node starts 1 mm deep in both. The other nodes
        // fall, so that penetration is measured at the iterate.
        let mut island = nodes_on_plane(side, GRAVITY);
        let pinch = [(0, DVec3::Y), (1, DVec3::NEG_Y)].map(|(i, normal)| ContactConstraint {
            offset: 1e-3,
            ..contact(i, node_side(0, 0), body_side(0, DVec3::ZERO), normal)
        });
        assert_eq!(island.solve_stage(DT, &pinch), StageSolve::Unconverged);
        assert!(island.workspace.counters.unsettled > 0, "{:?}", island.workspace.counters);
    }
}

#[test]
fn deserialised_workspace_finds_the_same_forces_to_the_bit() {
    for (side, _) in SIDES {
        let floor = with_friction(0.4, on_plane(0, DVec3::Y));
        let gravity = DVec3::new(0.2 * G, -G, 0.0);
        let mut island = nodes_on_plane(side, gravity);
        island.solve_stage(DT, &[floor]);
        let mut writer = StateWriter::default();
        island.workspace.serialise(&mut writer);
        let mut restored = nodes_on_plane(side, gravity);
        restored.workspace.deserialise(&mut StateReader::new(&writer.bytes)).expect("what was written");
        assert_eq!(restored.force(&floor), island.force(&floor));
        // From the same cache both take the same steps.
        island.solve_stage(DT, &[floor]);
        restored.solve_stage(DT, &[floor]);
        assert_eq!(restored.force(&floor), island.force(&floor));
        assert_eq!(restored.workspace.counters.newton, island.workspace.counters.newton);
    }
}

#[test]
fn explicit_node_is_stopped_by_projected_gauss_seidel() {
    let (speed, mu) = (1.5, 0.25);
    let sheet = loose_nodes(2, M, &[], IntegratorKind::EulerRichardson);
    let mut island = TestIsland::new(vec![sheet], vec![fixed_body()], DVec3::ZERO);
    island.sheets[0].state.v.set(0, DVec3::new(2.0, -speed, 0.0));
    let floor = ContactConstraint { restitution: 0.4, ..with_friction(mu, on_plane(0, DVec3::Y)) };
    assert!(island.solve_explicit(DT, &[floor]));
    assert_eq!(island.workspace.position_solver, PositionSolver::Pgs);
    // H = m/h²: the position force removes the penetration v h, the impulse m (1 + e) v the speed.
    let normal = speed * DT * M / (DT * DT);
    let force = island.force(&floor);
    assert!(force.distance(DVec3::new(-mu, 1.0, 0.0) * normal) < 1e-8 * M / (DT * DT), "{force}");
    let expected = DVec3::new(2.0 - mu * 1.4 * speed, 0.4 * speed, 0.0);
    assert!(island.sheets[0].state.v.get(0).distance(expected) < 1e-8 / DT, "{}", island.sheets[0].state.v.get(0));
    let unmoved = (island.sheets[0].state.x.get(1), island.sheets[0].state.v.get(1));
    assert_eq!(unmoved, (DVec3::X, DVec3::ZERO));
}

#[test]
fn contact_beyond_the_margin_is_detected_where_contact_pushes_a_node_against_it() {
    // A plane inclined by 45° pushes the node by d = 2 mm, a wall stops it at x = d/2.
    let d = 2e-3;
    let slope = DVec3::new(1.0, 1.0, 0.0).normalize();
    let floor = ContactConstraint { offset: d, ..on_plane(0, slope) };
    let wall = contact(1, node_side(0, 0), body_side(0, DVec3::X * (0.5 * d)), DVec3::NEG_X);
    let both = [floor, wall];
    for (side, _) in SIDES {
        let mut island = nodes_on_plane(side, DVec3::ZERO);
        let outcome = island.solve_stage_with(DT, |mode, margins| match mode {
            DetectionMode::FromStart | DetectionMode::FromIterate => {
                &both[..if margins.bodies < 0.5 * d { 1 } else { 2 }]
            }
            _ => &[],
        });
        assert_eq!(outcome, StageSolve::Converged);
        // x = d/2 and x + y = √2 d.
        let expected = DVec3::new(0.5, std::f64::consts::SQRT_2 - 0.5, 0.0) * d;
        assert!(island.iterate(0).distance(expected) < 1e-6, "{} {expected}", island.iterate(0));
        // The wall bears the difference between the components of m δ/h².
        let force = DVec3::NEG_X * ((expected.y - expected.x) * M / (DT * DT));
        assert!(island.force(&wall).distance(force) < 6.0 * TOLERANCE, "{} {force}", island.force(&wall));
    }
}

#[test]
fn stage_continues_while_the_iterate_penetrates_a_body() {
    // The first iteration detects only the contact of node 1. Node 0 ends it with a penetration of
    // d = 1 mm, which the second iteration removes with the force m d/h².
    let d = 1e-3;
    let both = [0, 1].map(|i| ContactConstraint { offset: d, ..on_plane(i, DVec3::Y) });
    for (side, _) in SIDES {
        let mut island = nodes_on_plane(side, DVec3::ZERO);
        let outcome = island.solve_stage_with(DT, |mode, _| match mode {
            DetectionMode::FromStart => &both[1..],
            _ => &both,
        });
        assert_eq!(outcome, StageSolve::Converged);
        for contact in &both {
            let force = island.force(contact);
            assert!(force.distance(DVec3::Y * (M * d / (DT * DT))) < 2.0 * TOLERANCE, "{force}");
        }
    }
}

#[test]
fn sheet_that_starts_inside_a_body_cancels_the_stage() {
    // Three of four nodes start 1 m deep. The diagonal of the nodes is 3 m, and a tenth of it is
    // the threshold.
    let mut island = nodes_on_plane(2, GRAVITY);
    let deep = [0, 1, 2].map(|i| ContactConstraint { offset: 1.0, ..on_plane(i, DVec3::Y) });
    assert_eq!(island.solve_stage(DT, &deep), StageSolve::InitialPenetration(0));
    let mut island = nodes_on_plane(2, GRAVITY);
    assert_eq!(island.solve_stage(DT, &deep[..1]), StageSolve::Converged, "fewer than half of the nodes");
}

#[test]
fn margins_widen_to_one_and_a_half_displacements_and_no_further_than_the_maximum() {
    let half = 2.5e-4;
    let mut margins = ContactMargins { bodies: 5e-4, sheets: 5e-4 };
    assert!(!margins.widen(ContactMargins { bodies: 4e-4, sheets: 5e-4 }, half), "the margins suffice");
    assert!(margins.widen(ContactMargins { bodies: 2e-3, sheets: 1e-4 }, half));
    assert_eq!(margins, ContactMargins { bodies: 3e-3, sheets: 5e-4 });
    assert!(margins.widen(ContactMargins { bodies: 1.0, sheets: 1.0 }, half));
    let most = SETTINGS.maximum_margin * half;
    assert_eq!(margins, ContactMargins { bodies: most, sheets: most });
}

#[test]
fn strain_error_counts_as_divergence_after_the_second_iteration() {
    let (some, huge) = (2.0 * SETTINGS.divergence_threshold, 2.0 * SETTINGS.early_divergence_threshold);
    assert!(!has_diverged(0, 1, huge) && !has_diverged(1, 1, huge), "the first iterations are free");
    assert!(has_diverged(2, 1, some) && !has_diverged(2, 1, 0.5 * SETTINGS.divergence_threshold));
    assert!(has_diverged(1, 2, huge) && !has_diverged(1, 2, some), "several sheets are judged earlier");
}

#[test]
fn iteration_limit_follows_sheets_substep_and_work() {
    let mut workspace = ContactWorkspace::default();
    workspace.is_single_unfolded_sheet = true;
    assert_eq!(maximum_iterations(&workspace, true), SETTINGS.maximum_iterations_single);
    workspace.is_single_unfolded_sheet = false;
    assert_eq!(maximum_iterations(&workspace, false), SETTINGS.maximum_iterations_single, "nothing has touched");
    assert_eq!(maximum_iterations(&workspace, true), SETTINGS.maximum_iterations_several);
    workspace.policy.is_shortest_substep = true;
    assert_eq!(maximum_iterations(&workspace, true), SETTINGS.maximum_iterations_shortest_substep);
    workspace.work = ContactSettings::DEFAULT.maximum_work + 1;
    assert_eq!(maximum_iterations(&workspace, true), 1, "the work budget is spent");
}
