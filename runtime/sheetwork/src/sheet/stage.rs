//! One implicit stage of a sheet in contact.
//!
//! [`crate::contact`] drives the stage: [`prepare_stage`], then outer iterations of
//! [`solve_free_motion`] (positions without contact, linearised at the last iterate) and
//! [`update_iterate`] (positions with contact), then [`finish_stage`]. In between,
//! the factor of the tangent gives the displacement of the nodes by contact forces.

use glam::DVec3;

use crate::elements::{Geometric, NO_BLOCK};
use crate::integrators::Integrator;
use crate::integrators::backward_euler;
use crate::integrators::implicit::ImplicitProblem;
use crate::integrators::implicit::staged::{ContactJump, StagedIntegrator};
use crate::integrators::settings::{IntegratorSettings, NewtonSettings};
use crate::linear::{HalfSolutions, SparseLoads};
use crate::math::Vectors;
use crate::rigid::BodyState;
use crate::sheet::implicit_system::{self, ContactTangent, ImplicitSheet, ImplicitSystem};
use crate::sheet::{Field, Sheet, SheetState, attachment, creep, node_contact, stage_trace};

const SETTINGS: NewtonSettings = IntegratorSettings::DEFAULT.newton;

/// Workspace and state of a stage.
#[derive(Default)]
pub(crate) struct StageWorkspace {
    /// Positions of the last iterate, m.
    pub iterate: Vectors,
    /// Positions without contact, m.
    pub free_positions: Vectors,
    /// Whether the stage needs no further outer iteration.
    pub is_finished: bool,
    /// Energy of mispredicted strain in the last outer iteration (J), and its ratio to the
    /// tolerance.
    misprediction: f64,
    pub misprediction_ratio: f64,
    /// Whether the linear system could not be solved.
    pub has_failed: bool,
    /// Whether the integrator has already advanced the sheet, and each node responds to contact
    /// with its mass alone.
    pub node_by_node: bool,
    /// Whether the step diverged: the energy of the sheet grew beyond its bound.
    pub has_diverged: bool,
    /// Velocity at the end of the stage without contact, m/s.
    pub velocity: Vectors,
    /// Length of the stage (s), and weight of the new acceleration in its displacement (s).
    pub length: f64,
    pub h: f64,
    /// Integrator of the sheet during a step of [`begin_euler`].
    own_engine: Option<Box<dyn Integrator>>,
    d: Vectors,
    reference: f64,
    scale: f64,
    right: Vec<f64>,
    /// Saved history of integrator and elements.
    saved_history: Vec<f64>,
    saved_positions: Vectors,
    saved_velocities: Vectors,
}

/// Call `work` with the equations of the sheet, its integrator, its stage, positions and
/// velocities.
fn with_scheme<R>(
    sheet: &mut Sheet,
    field: Field,
    work: impl FnOnce(&mut ImplicitSheet, &mut dyn StagedIntegrator, &mut StageWorkspace, (&mut Vectors, &mut Vectors)) -> R,
) -> Option<R> {
    let mut system = sheet.system.take()?;
    let (mut x, mut v) = (std::mem::take(&mut sheet.state.x), std::mem::take(&mut sheet.state.v));
    let mut engine = std::mem::replace(&mut sheet.engine, Box::new(crate::integrators::IdleIntegrator));
    let mut stage = std::mem::take(&mut sheet.work.stage);
    let result = engine.staged().map(|scheme| {
        implicit_system::with_implicit_sheet(sheet, field, &mut system, |problem| {
            work(problem, scheme, &mut stage, (&mut x, &mut v))
        })
    });
    (sheet.state.x, sheet.state.v, sheet.engine, sheet.system, sheet.work.stage) = (x, v, engine, Some(system), stage);
    result
}

/// Begin a step of `dt` (s) that proceeds in stages.
pub(crate) fn begin_step(sheet: &mut Sheet, field: Field, dt: f64) {
    creep::begin_inelastic_step(sheet, dt);
    implicit_system::prepare_implicit(sheet, field);
    let n = sheet.node_count();
    let stage = &mut sheet.work.stage;
    stage.node_by_node = false;
    for buffer in [&mut stage.iterate, &mut stage.free_positions, &mut stage.d, &mut stage.velocity] {
        if buffer.len() != n {
            *buffer = Vectors::zeros(n);
        }
    }
    let solves = with_scheme(sheet, field, |problem, scheme, _, (x, v)| scheme.begin(problem, dt, x, v));
    sheet.state.counters.evaluations += u64::from(solves.unwrap_or(0));
    sheet.state.counters.accepted += 1;
}

/// Restart the integrator after a discontinuity of the motion; its history is discarded.
pub(crate) fn restart_engine(sheet: &mut Sheet) {
    sheet.engine.restart();
}

/// Number of stages of a step; 0 for an explicit integrator.
pub(crate) fn stages(sheet: &mut Sheet) -> usize {
    sheet.engine.staged().map_or(0, |s| s.stages())
}

/// Weight θ of an acceleration in the displacement of a step of `dt` (s): see
/// [`crate::integrators::IntegratorInfo::drift`].
pub(crate) fn drift(sheet: &Sheet, dt: f64) -> f64 {
    sheet.engine.drift(dt).unwrap_or(sheet.engine_kind.info().drift)
}

/// Begin stage `k` of a step of `dt` (s).
pub(crate) fn prepare_stage(sheet: &mut Sheet, field: Field, k: usize, dt: f64) {
    with_scheme(sheet, field, |problem, scheme, stage, (x, v)| {
        scheme.prepare(problem, k, dt, (x, v), &mut stage.iterate);
        // A film under vacuum moves slowly and turns much work into strain, so the work of
        // pressure is also a reference energy.
        let pressed = problem.pressure_work(x, &stage.iterate).abs();
        let problem_stage = scheme.stage();
        // The stage starts from the present positions, or from the extrapolated ones if their
        // potential is lower.
        stage.free_positions.copy_from(x);
        problem.copy_prescribed(&stage.iterate, &mut stage.free_positions);
        let ahead = problem.potential(&problem_stage, &stage.iterate);
        let back = problem.potential(&problem_stage, &stage.free_positions);
        if back < ahead || !ahead.is_finite() {
            stage.iterate.copy_from(&stage.free_positions);
        }
        stage.reference = back.min(ahead);
        stage.scale = problem
            .inertial_potential(&problem_stage, x)
            .max(problem.kinetic_energy_at(SETTINGS.reference_speed_stage))
            .max(pressed);
        stage.is_finished = false;
        stage.misprediction = f64::INFINITY;
        stage.has_failed = false;
        stage.length = scheme.length(k, dt);
        stage.h = 1.0 / problem_stage.per_time;
    });
}

/// Start the stage from the rigid rotation given by `own` at its start, if that has a lower
/// potential. Motion along straight lines stretches a sheet that rotates by φ by φ²/2, and the
/// outer iterations would have to remove this strain.
pub(crate) fn start_from_rotation(sheet: &mut Sheet, field: Field, own: &BodyState) {
    with_scheme(sheet, field, |problem, scheme, stage, (x, v)| {
        let end = own.free_flight(stage.length, DVec3::ZERO);
        for i in 0..x.len() {
            let within = v.get(i) - own.velocity_at(x.get(i));
            stage.free_positions.set(i, end.world_point(own.local_point(x.get(i))) + within * stage.length);
        }
        problem.copy_prescribed(&stage.iterate, &mut stage.free_positions);
        let turned = problem.potential(&scheme.stage(), &stage.free_positions);
        if turned < stage.reference {
            stage.reference = turned;
            stage.iterate.copy_from(&stage.free_positions);
        }
    });
}

/// Solve for the positions without contact, linearised at the iterate; false without a finite
/// solution.
pub(crate) fn solve_free_motion(sheet: &mut Sheet, field: Field) -> bool {
    sheet.state.counters.evaluations += 1;
    let found = with_scheme(sheet, field, |problem, scheme, stage, _| {
        let problem_stage = scheme.stage();
        let mut found = problem.newton_direction(&problem_stage, &stage.iterate, Geometric::Mixed, &mut stage.d);
        if found.is_err() {
            found = problem.newton_direction(&problem_stage, &stage.iterate, Geometric::Clipped, &mut stage.d);
        }
        stage.free_positions.set_sum(&stage.iterate, 1.0, &stage.d);
        found.is_ok() && stage.free_positions.max_squared() < 1e12
    });
    found.unwrap_or(false)
}

/// Move the iterate to the free positions plus the displacement by contact (m). The stage has
/// converged when the solution agrees with its prediction within the tolerance. `firm` selects
/// the tighter tolerance of attached sheets, as long as further outer iterations reduce the
/// error.
pub(crate) fn update_iterate(sheet: &mut Sheet, field: Field, contact: Option<&Vectors>, firm: bool) {
    let enough = if contact.is_some() { SETTINGS.prediction_error_contact } else { SETTINGS.prediction_error };
    let passes = if contact.is_some() && firm && attachment::has_dynamic_attachments(sheet) {
        SETTINGS.prediction_error_attached
    } else {
        enough
    };
    with_scheme(sheet, field, |problem, scheme, stage, _| {
        stage.d.set_sum(&stage.free_positions, -1.0, &stage.iterate);
        if let Some(dx) = contact {
            stage.d.add_scaled(1.0, dx);
        }
        let missed = problem.predict_stress(&stage.iterate, &stage.d);
        stage.iterate.add_scaled(1.0, &stage.d);
        let limit = passes * stage.scale;
        let stalls = missed > 0.5 * stage.misprediction && missed <= enough * stage.scale;
        let near = missed <= limit || stalls;
        (stage.misprediction, stage.misprediction_ratio) = (missed, missed / limit);
        stage.is_finished = match contact {
            Some(_) => near,
            None => {
                let rise = problem.potential(&scheme.stage(), &stage.iterate) - stage.reference;
                near && rise <= SETTINGS.potential_rise * stage.scale
            }
        };
    });
}

/// Whether the stage has moved any node further than `by` (m) so far.
pub(crate) fn has_moved(sheet: &Sheet, by: f64) -> bool {
    let (from, to) = (sheet.state.x.iter(), sheet.work.stage.iterate.iter());
    from.zip(to).any(|(p, q)| p.distance_squared(q) > by * by)
}

/// Compute the velocity at the end of the stage without contact.
pub(crate) fn compute_free_velocity(sheet: &mut Sheet, field: Field) {
    with_scheme(sheet, field, |_, scheme, stage, _| {
        let of_stage = scheme.stage();
        stage.velocity.set_sum(&stage.free_positions, -1.0, of_stage.w);
        stage.velocity.axes_mut().into_iter().flatten().for_each(|v| *v *= of_stage.per_time);
    });
}

/// Solve the stage without contact by the globalised Newton method, from the present positions.
pub(crate) fn solve_stage_alone(sheet: &mut Sheet, field: Field) {
    let solved = with_scheme(sheet, field, |problem, scheme, stage, (x, _)| {
        let mut work = std::mem::take(scheme.work());
        let solved =
            crate::integrators::implicit::newton::solve(problem, &scheme.stage(), x, &mut stage.iterate, &mut work);
        *scheme.work() = work;
        stage.is_finished = true;
        solved
    });
    let solved = solved.unwrap_or_default();
    sheet.state.counters.evaluations += u64::from(solved.solves);
    sheet.state.counters.guarded += u64::from(solved.globalised);
}

/// Finish stage `k` with the displacement and velocity change by contact.
pub(crate) fn finish_stage(sheet: &mut Sheet, field: Field, k: usize, dt: f64, jump: Option<&ContactJump>) {
    with_scheme(sheet, field, |problem, scheme, stage, state| {
        scheme.finish(problem, k, dt, &stage.iterate, jump, state);
    });
}

/// Add the half solutions of `loads`, given by node, for the present tangent.
pub(crate) fn half_solve(sheet: &mut Sheet, loads: &SparseLoads, solutions: &mut HalfSolutions) {
    if node_contact::solves_node_by_node(sheet) {
        node_contact::half_solve_nodes(sheet, loads, solutions);
    } else if let Some(system) = &mut sheet.system {
        system.half_solve(loads, solutions);
    }
}

/// Displacement (m) by `force` (N) with the present tangent.
pub(crate) fn solve_displacement(sheet: &mut Sheet, force: &Vectors, dx: &mut Vectors) {
    if node_contact::solves_node_by_node(sheet) {
        dx.clear();
        node_contact::node_displacements(sheet, force, dx);
        return;
    }
    let Some(system) = &mut sheet.system else { return };
    let mut right = std::mem::take(&mut sheet.work.stage.right);
    right.clear();
    for (row, mass) in system.masses().iter().enumerate() {
        let free = system.free_axes(row as u32);
        right.extend((force.get(*mass as usize) * free).to_array());
    }
    system.solve(&mut right);
    spread_rows(sheet, &right, dx);
    sheet.work.stage.right = right;
}

/// Present tangent; `None` before the first implicit step, and where nodes respond with their
/// mass alone.
pub(crate) fn tangent(sheet: &Sheet) -> Option<ContactTangent<'_>> {
    sheet.system.as_ref().filter(|_| !node_contact::solves_node_by_node(sheet)).map(|s| s.tangent())
}

/// Linear system of the present tangent.
pub(crate) fn system_mut(sheet: &mut Sheet) -> Option<&mut ImplicitSystem> {
    sheet.system.as_deref_mut()
}

/// Restore the factor of the tangent without contact.
pub(crate) fn restore_factor(sheet: &mut Sheet) {
    if let Some(system) = &mut sheet.system {
        system.restore_factor();
    }
}

/// Node of each block row of the tangent.
pub(crate) fn block_masses(sheet: &Sheet) -> &[u32] {
    sheet.system.as_ref().map_or(&[], |s| s.masses())
}

/// Copy a vector by block rows to one by nodes.
pub(crate) fn spread_rows(sheet: &Sheet, by_row: &[f64], to: &mut Vectors) {
    to.clear();
    let Some(system) = &sheet.system else { return };
    for (step, mass) in by_row.chunks_exact(3).zip(system.masses()) {
        to.set(*mass as usize, DVec3::from_slice(step));
    }
}

/// Block row of node `i`, and its free (1) and fixed (0) directions; `None` for a fixed node.
pub(crate) fn free_row(sheet: &Sheet, i: u32) -> Option<(u32, DVec3)> {
    if node_contact::solves_node_by_node(sheet) {
        return node_contact::free_node(sheet, i);
    }
    let system = sheet.system.as_ref()?;
    let row = system.block_row(i);
    (row != NO_BLOCK).then(|| (row, system.free_axes(row)))
}

/// Begin a step of `dt` (s) of backward Euler in place of the sheet's integrator, up to
/// [`finish_euler`].
pub(crate) fn begin_euler(sheet: &mut Sheet, field: Field, dt: f64) {
    sheet.work.stage.own_engine = Some(std::mem::replace(&mut sheet.engine, (backward_euler::INFO.make)()));
    begin_step(sheet, field, dt);
    prepare_stage(sheet, field, 0, dt);
    with_scheme(sheet, field, |problem, _, stage, (x, _)| {
        // The guess holds the prescribed nodes at their end.
        std::mem::swap(&mut stage.free_positions, &mut stage.iterate);
        stage.iterate.copy_from(x);
        problem.update_stress(x);
    });
}

/// Finish a step of [`begin_euler`] at the iterate; the sheet's integrator restarts.
pub(crate) fn finish_euler(sheet: &mut Sheet, field: Field, dt: f64) {
    finish_stage(sheet, field, 0, dt, None);
    if let Some(own) = sheet.work.stage.own_engine.take() {
        sheet.engine = own;
    }
    restart_engine(sheet);
}

/// Assemble the gradient and the positive definite tangent of the potential at the iterate.
pub(crate) fn linearise(sheet: &mut Sheet, field: Field) {
    with_scheme(sheet, field, |problem, scheme, stage, _| {
        problem.update_stress(&stage.iterate);
        problem.linearise(&scheme.stage(), &stage.iterate);
    });
}

/// Call `visit` with each block row and the gradient (N) of the last [`linearise`].
pub(crate) fn for_each_gradient_row(sheet: &Sheet, visit: impl FnMut(u32, DVec3)) {
    if let Some(system) = &sheet.system {
        system.for_each_gradient_row(visit);
    }
}

/// Incremental potential at the iterate, J.
pub(crate) fn iterate_potential(sheet: &mut Sheet, field: Field) -> f64 {
    let found =
        with_scheme(sheet, field, |problem, scheme, stage, _| problem.potential(&scheme.stage(), &stage.iterate));
    found.unwrap_or(f64::NAN)
}

/// Save the state of the sheet for [`restore_state`].
pub(crate) fn save_state(sheet: &mut Sheet) {
    stage_trace::update_trace(sheet, |trace, _| trace.mark_saved());
    let Sheet { work, state: SheetState { x, v, .. }, engine, .. } = sheet;
    let stage = &mut work.stage;
    stage.saved_positions.clone_from(x);
    stage.saved_velocities.clone_from(v);
    stage.saved_history.clear();
    let kept = &mut stage.saved_history;
    engine.visit_history(&mut |numbers| kept.extend_from_slice(numbers));
    for_each_element(&mut sheet.system, &mut sheet.elements, |e| visit_history(e, &mut |n| kept.extend_from_slice(n)));
}

/// Saved positions, m.
pub(crate) fn saved_positions(sheet: &Sheet) -> &Vectors {
    &sheet.work.stage.saved_positions
}

/// Momentum of the saved state, kg m/s.
pub(crate) fn saved_momentum(sheet: &Sheet) -> DVec3 {
    sheet.work.stage.saved_velocities.iter().zip(&sheet.model.mass).map(|(v, m)| v * *m).sum()
}

/// Restore the saved state.
pub(crate) fn restore_state(sheet: &mut Sheet) {
    stage_trace::update_trace(sheet, |trace, _| trace.truncate_to_saved());
    let Sheet { work, state: SheetState { x, v, .. }, engine, .. } = sheet;
    x.clone_from(&work.stage.saved_positions);
    v.clone_from(&work.stage.saved_velocities);
    let mut rest = work.stage.saved_history.as_slice();
    let mut take = |numbers: &mut [f64]| {
        let (these, others) = rest.split_at(numbers.len().min(rest.len()));
        if these.len() == numbers.len() {
            numbers.copy_from_slice(these);
        }
        rest = others;
    };
    engine.visit_history(&mut take);
    for_each_element(&mut sheet.system, &mut sheet.elements, |e| visit_history(e, &mut take));
}

fn visit_history(element: &mut dyn crate::elements::Element, visit: &mut dyn FnMut(&mut [f64])) {
    element.visit_history(visit);
    element.arms_mut().into_iter().for_each(|arms| arms.visit(visit));
}

fn for_each_element(
    system: &mut Option<Box<ImplicitSystem>>,
    elements: &mut [Box<dyn crate::elements::Element>],
    mut visit: impl FnMut(&mut dyn crate::elements::Element),
) {
    if let Some(system) = system {
        visit(&mut system.springs);
    }
    elements.iter_mut().for_each(|e| visit(&mut **e));
}
