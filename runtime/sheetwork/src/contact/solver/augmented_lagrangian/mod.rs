//! Augmented Lagrangian method with semismooth Newton steps, in displacements or contact forces.
//!
//! Unknown is the displacement δ (m) with H δ = Jᵀ p, u = J δ + b, and Coulomb's law between u and
//! p at every contact. With constant friction bounds the problem is convex. The augmented
//! Lagrangian with weights ρ (N/m),
//!
//!   Φ(δ) = ½ δᵀ H δ + Σ |P(p - ρ u)|²/2ρ (componentwise),  p⁺ = P(p - ρ u),
//!
//! where P projects on the admissible forces (normal part ≥ 0, tangential part within a disc of the
//! friction bound), is minimised by Newton steps
//!
//!   (H + Σ Jᵀ D J) s = Jᵀ P(p - ρ u) - H δ,  D = ρ ∂P.
//!
//! A line search on Φ follows each step. If the contact states (open, stick, slip) after the step
//! are those for which D was computed, the step is exact and the forces are updated to p⁺. Once
//! gaps and slips are within tolerance, the friction bounds follow the normal forces (fixed-point
//! iteration), and the solve continues. A new factorisation is needed only after a change of state:
//! of the displacement matrix (`island_tangent`), or of the matrix of contact forces
//! (`unknown_space`).
//!
//! Two measures keep the iteration from cycling when many contacts change state: regularised steps,
//! whose D bounds the curvature of friction from above, and the interior point method
//! (`interior_point`).
//!
//! Sources: Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton
//! like solution methods", CMAME 92, 1991; Li, Sun, Toh, "A highly efficient semismooth Newton
//! augmented Lagrangian method", SIAM J. Optim. 28, 2018; Haslinger, "Approximation of the
//! Signorini problem with friction, obeying the Coulomb law", Math. Meth. Appl. Sci. 5, 1983.

pub(crate) mod contact_state;
pub(crate) mod interior_point;
pub(crate) mod island_tangent;
mod newton_step;
pub(crate) mod solver_constraint;
#[cfg(test)]
mod tests;
mod tolerances;
pub(crate) mod unknown_space;

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::contact::settings::{AugmentedLagrangianSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::contact_state::{
    ContactState, FrictionState, derivative, project_force, state_of,
};
pub(crate) use crate::contact::solver::augmented_lagrangian::interior_point::InteriorPointTolerances;
pub(crate) use crate::contact::solver::augmented_lagrangian::island_tangent::{
    IslandTangent, TangentMatrix, covers_constraint,
};
pub(crate) use crate::contact::solver::augmented_lagrangian::solver_constraint::SolverConstraint;
pub(crate) use crate::contact::solver::augmented_lagrangian::tolerances::AugmentedLagrangianTolerances;
pub(crate) use crate::contact::solver::augmented_lagrangian::unknown_space::{DualSpace, PrimalSpace, UnknownSpace};

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

/// Augmented Lagrangian solver and its arrays.
#[derive(Default)]
pub(crate) struct AugmentedLagrangian {
    pub constraints: Vec<SolverConstraint>,
    /// Contact forces in the contact frames, N.
    pub force: Vec<DVec3>,
    /// Friction bound of each contact, N.
    friction_bounds: Vec<f64>,
    /// Difference between μ p_n and the friction bound of each contact, N.
    bound_errors: Vec<f64>,
    /// Last relaxation factor of the friction bounds.
    relaxation: f64,
    /// Contact states at the present u.
    states: Vec<ContactState>,
    /// Contact states for which the factor was computed; empty if there is none.
    factored_states: Vec<ContactState>,
    /// D of each constraint in the factor, N/m.
    weights: Vec<DMat3>,
    /// u = J δ + b, m.
    u: Vec<DVec3>,
    /// Change of u along the step, m.
    du: Vec<DVec3>,
    /// Displacement δ.
    delta: Vec<f64>,
    /// H δ, N.
    h_delta: Vec<f64>,
    /// Right-hand side of a Newton step, then the step s.
    step: Vec<f64>,
    /// H s, N.
    h_step: Vec<f64>,
    interior: interior_point::InteriorPoint,
    /// Largest sum of forces in this solve, N.
    largest_force_sum: f64,
    /// Newton iterations since the solver was created.
    pub steps: u64,
    /// ρ as a multiple of the stiffness of the sheet.
    weight_factor: DVec3,
    /// Whether steps are regularised: D of a slipping contact also resists slip along its
    /// direction, and steps have full length.
    regularised: bool,
    /// Factorisations since the solver was created.
    pub factors: u64,
}

/// Progress of the iteration of one solve.
struct SolveProgress {
    /// Updates of the friction bounds so far.
    bound_updates: u32,
    /// Whether the last step was exact, or within tolerance.
    is_exact: bool,
    /// Whether the factor at hand may serve for another step.
    trusts_factor: bool,
    tried_interior_point: bool,
    /// Whether the forces balanced the displacement in the last iteration.
    is_balanced: bool,
    /// Residual at the last update of the forces, and in the first iteration, m.
    last_residual: f64,
    first_residual: f64,
}

impl SolveProgress {
    fn new() -> Self {
        Self {
            bound_updates: 0,
            is_exact: true,
            trusts_factor: true,
            tried_interior_point: false,
            is_balanced: false,
            last_residual: f64::INFINITY,
            first_residual: f64::INFINITY,
        }
    }
}

impl AugmentedLagrangian {
    /// Start a problem with another matrix.
    pub fn clear(&mut self) {
        self.constraints.clear();
        self.force.clear();
        self.states.clear();
        self.factored_states.clear();
    }

    /// Mark the constraints of the last solve as known; constraints added later are new.
    pub fn mark_known(&mut self) {
        for (row, state) in self.constraints.iter_mut().zip(&self.states) {
            row.is_new = false;
            row.slipped = state.friction == FrictionState::Slip;
        }
        self.factored_states.clear();
    }

    /// Displacement of each block row, m; rotations in rad.
    pub fn displacement(&self) -> &[f64] {
        &self.delta
    }

    /// Let another solver, `solve`, find forces and u from the initial forces `begun`. Returns
    /// whether it converged.
    pub fn adopt(
        &mut self,
        begun: &[DVec3],
        solve: impl FnOnce(&[SolverConstraint], (&mut Vec<DVec3>, &mut Vec<DVec3>)) -> bool,
    ) -> bool {
        self.force.clear();
        self.force.extend_from_slice(begun);
        let settled = solve(&self.constraints, (&mut self.force, &mut self.u));
        if settled {
            self.friction_bounds.clear();
            self.friction_bounds.extend(self.constraints.iter().zip(&self.force).map(|(row, p)| match row.law {
                ContactLaw::Coulomb(friction) => friction * p.x.max(0.0),
                ContactLaw::Attachment => f64::INFINITY,
            }));
            self.update_states();
            self.factored_states.clear();
        }
        settled
    }

    /// Whether contact `i` slips.
    pub fn slips(&self, i: usize) -> bool {
        self.states[i].friction == FrictionState::Slip
    }

    /// Solve from the initial forces in `force`, and leave the solution there. Returns whether the
    /// iteration converged.
    ///
    /// Each iteration updates the contact states and the force balance. If the forces balance the
    /// displacement, the forces are updated; if gaps and slips are then within tolerance, the
    /// friction bounds are updated, and the solve ends when they stay constant. Otherwise a
    /// Newton step follows, with a new factor if the states have changed.
    pub fn solve(&mut self, space: &mut dyn UnknownSpace, accuracy: &AugmentedLagrangianTolerances) -> bool {
        if !self.compute_initial_displacement(space, accuracy) {
            return false;
        }
        let mut progress = SolveProgress::new();
        for round in 0.. {
            let limit = accuracy.maximum_iterations(space.has_cheap_factorisation())
                + SETTINGS.iterations_per_update * progress.bound_updates;
            if self.wants_interior_point(space, accuracy, round, limit, &mut progress) {
                // Its result may be a good initial value even if it has not converged.
                progress.tried_interior_point = true;
                if !space.has_cheap_factorisation() && self.solve_interior_point(space, accuracy) {
                    return true;
                }
            }
            if round == limit {
                return false;
            }
            self.choose_regularisation(space, accuracy, round, progress.is_exact);
            self.update_states();
            progress.is_balanced = self.compute_right_side(space) <= accuracy.balance_at(round);
            if progress.is_balanced {
                if self.update_forces_and_bounds(accuracy, &mut progress) {
                    return true;
                }
                self.update_states();
                self.compute_right_side(space);
            }
            if !self.take_newton_step(space, accuracy.gap, &mut progress) {
                return false;
            }
        }
        false
    }

    /// Whether to try the interior point method in iteration `round`: many contacts are about to
    /// change state, the regularised iteration stagnates, or the iteration limit is reached.
    fn wants_interior_point(
        &self,
        space: &dyn UnknownSpace,
        accuracy: &AugmentedLagrangianTolerances,
        round: u32,
        limit: u32,
        progress: &mut SolveProgress,
    ) -> bool {
        let many_changes = round == SETTINGS.iterations_before_interior_point
            && !accuracy.regularised
            && !progress.is_exact
            && !space.has_cheap_factorisation()
            && self.changed_fraction() > SETTINGS.changes_threshold;
        // Updated forces open contacts for one iteration.
        let stagnates = accuracy.regularised
            && !progress.is_balanced
            && self.needs_interior_point(round, &mut progress.first_residual, accuracy);
        !progress.tried_interior_point && (many_changes || stagnates || round == limit)
    }

    /// Regularise the step of iteration `round` when many contacts change state, and keep to it
    /// until a step is exact.
    fn choose_regularisation(
        &mut self,
        space: &dyn UnknownSpace,
        accuracy: &AugmentedLagrangianTolerances,
        round: u32,
        is_exact: bool,
    ) {
        let regularised = accuracy.regularised
            && !space.has_cheap_factorisation()
            && if round == 0 {
                self.changed_fraction() > SETTINGS.changes_threshold
            } else {
                self.regularised && !is_exact
            };
        if std::mem::replace(&mut self.regularised, regularised) != regularised {
            self.factored_states.clear();
        }
    }

    /// Update the forces of a balanced iterate, and the friction bounds once gaps and slips are
    /// within tolerance. Returns whether the solve has converged.
    fn update_forces_and_bounds(
        &mut self,
        accuracy: &AugmentedLagrangianTolerances,
        progress: &mut SolveProgress,
    ) -> bool {
        let (residual, tolerance) = (self.residual(accuracy.slip_weight), accuracy.gap);
        self.update_forces();
        let is_stalled = residual > (1.0 - SETTINGS.stagnation_decrease) * progress.last_residual
            && residual <= SETTINGS.stagnation_residual * tolerance;
        if residual > SETTINGS.slow_convergence_ratio * progress.last_residual
            && self.weight_factor.x < accuracy.maximum_weight_factor
        {
            self.weight_factor *= SETTINGS.weight_growth;
            self.factored_states.clear();
        }
        progress.last_residual = residual;
        if residual <= tolerance || is_stalled {
            if progress.bound_updates >= accuracy.maximum_bound_updates || !self.update_friction_bounds() {
                return true;
            }
            progress.bound_updates += 1;
        }
        false
    }

    /// Take a Newton step; `tolerance` (m) is that of the gap. Returns false if the matrix has no
    /// factor.
    fn take_newton_step(&mut self, space: &mut dyn UnknownSpace, tolerance: f64, progress: &mut SolveProgress) -> bool {
        // The factor at hand is tried first: a change of friction states alone often makes little
        // difference.
        let reuses_factor = progress.trusts_factor && self.has_same_closed_contacts();
        if !reuses_factor && !self.factorize(space) {
            return false;
        }
        self.solve_step(space);
        let is_small = self.du.iter().all(|du| du.abs().max_element() <= tolerance);
        progress.trusts_factor = !reuses_factor || (is_small && progress.is_balanced);
        progress.is_exact = self.line_search_step(space) || is_small;
        true
    }

    /// Whether the regularised iteration has not come near the solution by iteration `round`;
    /// `first` is the residual of the first iteration, m.
    fn needs_interior_point(&self, round: u32, first: &mut f64, accuracy: &AugmentedLagrangianTolerances) -> bool {
        if round > 0 && !SETTINGS.regularised_checks.contains(&round) {
            return false;
        }
        let missed = self.residual(accuracy.slip_weight);
        if round == 0 {
            *first = missed;
        }
        let [early, _] = SETTINGS.regularised_checks;
        round > 0
            && missed > SETTINGS.second_check_residual * accuracy.gap
            && (round > early || missed > SETTINGS.first_check_ratio * *first)
    }

    /// Compute the initial displacement, with the contact states of the initial forces.
    fn compute_initial_displacement(
        &mut self,
        space: &mut dyn UnknownSpace,
        accuracy: &AugmentedLagrangianTolerances,
    ) -> bool {
        self.largest_force_sum = 0.0;
        self.regularised = false;
        self.weight_factor = accuracy.weight_factor;
        let n = space.size(&self.constraints);
        for vector in [&mut self.delta, &mut self.h_delta, &mut self.step, &mut self.h_step] {
            vector.clear();
            vector.resize(n, 0.0);
        }
        self.u.clear();
        self.u.extend(self.constraints.iter().map(|r| r.b));
        self.du.clear();
        self.du.resize(self.constraints.len(), DVec3::ZERO);
        self.set_initial_states();
        for (i, row) in self.constraints.iter().enumerate() {
            let state = &self.states[i];
            if state.is_active() {
                let d = derivative(row.stiffness * self.weight_factor, state, self.regularised);
                let p = self.force[i];
                let normal = if state.is_closed { p.x } else { 0.0 };
                let held = DVec3::new(normal, p.y, p.z) - d * row.b;
                space.add_force(i, row, held, &mut self.step);
                self.largest_force_sum += held.abs().element_sum();
            }
        }
        if !self.factorize(space) {
            return false;
        }
        self.solve_step(space);
        self.move_along_step(1.0);
        true
    }

    /// Set the initial contact states. A contact is closed if it has an initial force, or if it is
    /// new with a gap below `closing_gap`.
    fn set_initial_states(&mut self) {
        self.states.clear();
        self.friction_bounds.clear();
        self.bound_errors.clear();
        for (row, p) in self.constraints.iter().zip(&mut self.force) {
            let ContactLaw::Coulomb(friction) = row.law else {
                self.friction_bounds.push(f64::INFINITY);
                self.states.push(ContactState {
                    is_closed: true,
                    friction: FrictionState::Stick,
                    ..ContactState::OPEN
                });
                continue;
            };
            if row.is_disabled {
                *p = DVec3::ZERO;
            }
            let limit = friction * p.x.max(0.0);
            let tangential = DVec2::new(p.y, p.z).clamp_length_max(limit);
            (p.y, p.z) = (tangential.x, tangential.y);
            let rubs = match limit > 0.0 {
                false => FrictionState::None,
                true if row.slipped && tangential.length() > limit * (1.0 - SETTINGS.friction_tolerance) => {
                    FrictionState::Slip
                }
                true => FrictionState::Stick,
            };
            self.friction_bounds.push(limit);
            let pushes = p.x > 0.0 || (row.is_new && !row.is_disabled && row.b.x < row.closing_gap);
            self.states.push(ContactState {
                is_closed: pushes,
                friction: rubs,
                along: tangential.normalize_or_zero(),
                across: 1.0,
            });
        }
    }

    /// Fraction of contacts that open or close unexpectedly.
    fn changed_fraction(&self) -> f64 {
        let rows = self.constraints.iter().enumerate();
        let other = rows.filter(|(i, row)| {
            let trial = self.force[*i] - row.stiffness * self.weight_factor * self.u[*i];
            state_of(row, trial, self.friction_bounds[*i]).is_closed != self.states[*i].is_closed
        });
        other.count() as f64 / self.constraints.len().max(1) as f64
    }

    /// Update the contact states from the present u.
    fn update_states(&mut self) {
        for (i, row) in self.constraints.iter().enumerate() {
            let next =
                state_of(row, self.force[i] - row.stiffness * self.weight_factor * self.u[i], self.friction_bounds[i]);
            self.states[i] = next;
        }
    }

    /// Residual: largest gap or slip that should be zero, m, with weight `slips` of the slip.
    fn residual(&self, slips: f64) -> f64 {
        let each = self.constraints.iter().zip(&self.u).zip(&self.states).map(|((row, u), state)| {
            if row.law == ContactLaw::Attachment {
                return SETTINGS.attachment_weight * u.abs().max_element();
            }
            let slip = if state.friction == FrictionState::Stick { slips * u.y.abs().max(u.z.abs()) } else { 0.0 };
            let gap = if state.is_closed { u.x.abs() } else { (-u.x).max(0.0) };
            if row.is_disabled { 0.0 } else { gap.max(slip) }
        });
        each.fold(0.0, f64::max)
    }

    /// Update the forces to P(p - ρ u).
    fn update_forces(&mut self) {
        for (i, row) in self.constraints.iter().enumerate() {
            self.force[i] = project_force(
                row,
                self.force[i] - row.stiffness * self.weight_factor * self.u[i],
                self.friction_bounds[i],
            );
        }
    }

    /// Move the friction bounds towards μ p_n. Returns false if they are within tolerance. The full
    /// update may oscillate, as for a sheet wedged between a floor and a needle; Aitken relaxation
    /// shortens it (Irons and Tuck, "A version of the Aitken accelerator for computer iteration",
    /// IJNME 1, 1969).
    fn update_friction_bounds(&mut self) -> bool {
        let all: f64 = self.force.iter().map(|p| p.x).sum();
        let first = self.bound_errors.is_empty();
        self.bound_errors.resize(self.constraints.len(), 0.0);
        let (mut changed, mut along, mut square) = (false, 0.0, 0.0);
        for (i, row) in self.constraints.iter().enumerate() {
            let ContactLaw::Coulomb(friction) = row.law else { continue };
            let normal = self.force[i].x;
            let limit = if normal > SETTINGS.negligible_force * all { friction * normal } else { 0.0 };
            let slight = SETTINGS.friction_tolerance
                * limit.max(self.friction_bounds[i]).max(SETTINGS.minimum_bound_tolerance * friction * all);
            let short = limit - self.friction_bounds[i];
            changed |= match self.states[i].friction {
                FrictionState::Stick => DVec2::new(self.force[i].y, self.force[i].z).length() > limit + slight,
                _ => short.abs() > slight,
            };
            let by = short - self.bound_errors[i];
            along += self.bound_errors[i] * by;
            square += by * by;
            self.bound_errors[i] = short;
        }
        let is_known = !first && square > 0.0;
        self.relaxation =
            if is_known { (-self.relaxation * along / square).clamp(SETTINGS.minimum_relaxation, 1.0) } else { 1.0 };
        for (limit, short) in self.friction_bounds.iter_mut().zip(&self.bound_errors) {
            *limit = (*limit + self.relaxation * short).max(0.0);
        }
        changed
    }
}
