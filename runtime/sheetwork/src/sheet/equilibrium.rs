//! Equilibrium of a sheet under constant forces, without time integration.
//!
//! Mixed-stress Newton from the present state takes about six linear solves on any grid for sheets
//! that bend with little stretch (see [`crate::elements`]). Where it does not converge (a buckled
//! or a free sheet), backward Euler steps without velocity and with growing length follow; they
//! reduce the energy and end in a stable equilibrium.

use crate::elements::{Anchor, Geometric};
use crate::integrators::implicit::newton::{NewtonWorkspace, solve};
use crate::integrators::implicit::{ImplicitProblem, StageProblem};
use crate::math::Vectors;
use crate::sheet::implicit_system::{self, ImplicitSystem};
use crate::sheet::{Field, Sheet, creep};

/// Result of the search for an equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equilibrium {
    /// Number of linear solves.
    pub solves: u32,
    /// Length of the last step of the iteration, m.
    pub last_step: f64,
    /// Whether the iteration converged.
    pub converged: bool,
    /// Whether Newton's method converged from the initial state, without relaxation.
    pub by_newton_alone: bool,
    /// Whether the equilibrium is stable.
    pub is_stable: bool,
}

/// Maximum number of steps of Newton's method.
const MAX_NEWTON_STEPS: u32 = 25;
/// Maximum number of relaxation steps.
const MAX_RELAXATION_STEPS: u32 = 400;

/// Move the sheet to equilibrium under `field`, with a last step of at most `tolerance` (m),
/// and set its velocities to zero.
pub fn find_equilibrium(sheet: &mut Sheet, field: Field, tolerance: f64) -> Equilibrium {
    creep::use_instantaneous_law(sheet);
    let found = iterate_to_equilibrium(sheet, field, tolerance);
    Equilibrium { is_stable: sheet.is_stable(), ..found }
}

/// Let the sheet creep for `dt` (s) in equilibrium under `field`, with a last step of at most
/// `tolerance` (m), and set its velocities to zero. Stability is not tested.
pub fn creep_in_equilibrium(sheet: &mut Sheet, field: Field, dt: f64, tolerance: f64) -> Equilibrium {
    creep::begin_inelastic_step(sheet, dt);
    let found = iterate_to_equilibrium(sheet, field, tolerance);
    creep::end_inelastic_step(sheet);
    found
}

fn iterate_to_equilibrium(sheet: &mut Sheet, field: Field, tolerance: f64) -> Equilibrium {
    let mut system = sheet.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(sheet)));
    system.forget_constant();
    let mut x = sheet.state.x.clone();
    let (start, size) = (sheet.state.x.clone(), sheet.model.initial_diagonal);
    let found = implicit_system::with_implicit_sheet(sheet, field, &mut system, |problem| {
        let mut found = newton(problem, &mut x, tolerance, size);
        if !found.converged {
            x.copy_from(&start);
            relax(problem, &mut x, tolerance, &mut found);
        }
        found
    });
    system.forget_constant();
    sheet.system = Some(system);
    sheet.state.x.copy_from(&x);
    sheet.state.v.clear();
    sheet.elements.iter_mut().filter_map(|e| e.arms_mut()).for_each(|arms| arms.relax());
    sheet.engine.restart();
    found
}

fn newton(problem: &mut dyn ImplicitProblem, x: &mut Vectors, tolerance: f64, size: f64) -> Equilibrium {
    let still = Vectors::zeros(x.len());
    let mut d = still.clone();
    let mut found = Equilibrium { by_newton_alone: true, ..Equilibrium::default() };
    problem.begin_stage(0.0, &[], 0.0, x, &still);
    problem.update_stress(x);
    let stage = StageProblem { per_time: 0.0, y: &still, w: &still };
    for _ in 0..MAX_NEWTON_STEPS {
        let mut done = problem.newton_direction(&stage, x, Geometric::Mixed, &mut d);
        if done.is_err() {
            done = problem.newton_direction(&stage, x, Geometric::Clipped, &mut d);
        }
        if done.is_err() {
            break;
        }
        found.solves += 1;
        problem.predict_stress(x, &d);
        x.add_scaled(1.0, &d);
        found.last_step = d.max_squared().sqrt();
        if found.last_step <= tolerance {
            found.converged = true;
            break;
        }
        if found.last_step.is_nan() || found.last_step > 100.0 * size {
            break;
        }
    }
    found
}

/// Relax by backward Euler steps without velocity, doubling the step after each unguarded solution.
fn relax(problem: &mut dyn ImplicitProblem, x: &mut Vectors, tolerance: f64, found: &mut Equilibrium) {
    let still = Vectors::zeros(x.len());
    let mut work = NewtonWorkspace::default();
    let mut before = x.clone();
    let mut h = 1e-2;
    found.by_newton_alone = false;
    for _ in 0..MAX_RELAXATION_STEPS {
        before.copy_from(x);
        problem.begin_stage(1.0 / h, &[Anchor { weight: 1.0, x: &before }], 0.0, &before, &still);
        let stage = StageProblem { per_time: 1.0 / h, y: &before, w: &before };
        let solved = solve(problem, &stage, &before, x, &mut work);
        found.solves += solved.solves;
        let moved = (0..x.len()).map(|i| x.get(i).distance_squared(before.get(i))).fold(0.0, f64::max).sqrt();
        found.last_step = moved;
        if moved <= tolerance && h > 1.0 {
            found.converged = true;
            return;
        }
        h = if solved.globalised { (0.5 * h).max(1e-4) } else { (2.0 * h).min(1e3) };
    }
}
