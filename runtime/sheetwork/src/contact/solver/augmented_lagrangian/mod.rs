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
pub(crate) mod solver_constraint;
#[cfg(test)]
mod tests;
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
pub(crate) use crate::contact::solver::augmented_lagrangian::unknown_space::{DualSpace, PrimalSpace, UnknownSpace};

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

/// Settings of a solve: tolerances, weights and iteration limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AugmentedLagrangianTolerances {
    /// Gap tolerance, m.
    pub gap: f64,
    /// ρ as a multiple of the stiffness of the sheet at the contact. With 100, a Newton step
    /// reduces the penetration to a hundredth. Friction has a smaller factor because it changes
    /// between stick and slip.
    pub weight_factor: DVec3,
    /// Maximum of the normal factor when weights grow in slow convergence. Piles converge more
    /// slowly with larger weights.
    pub maximum_weight_factor: f64,
    /// Weight of slip in the residual; slip of sticking contacts would add up from step to step.
    pub slip_weight: f64,
    /// Tolerance of the force balance H δ = Jᵀ p, as a fraction of the sum of forces. A stiff
    /// contact has a force error at a small gap.
    pub balance: f64,
    /// Tolerance of the force balance in late iterations, see
    /// [`AugmentedLagrangianSettings::iterations_before_late_balance`]. When sheets slide over each
    /// other, a few contacts alternate between stick and slip for many iterations.
    pub balance_late: f64,
    /// Tolerance of the force balance after the interior point method, whose friction converges
    /// slowly.
    pub balance_interior: f64,
    /// Settings of the interior point method.
    pub interior: InteriorPointTolerances,
    /// Maximum number of updates of the friction bounds.
    pub maximum_bound_updates: u32,
    /// Iterations after which the interior point method is used in any case.
    pub interior_point_iteration: u32,
    /// Whether to regularise steps when many contacts change state: more robust, but slower near
    /// the solution.
    pub regularised: bool,
}

impl AugmentedLagrangianTolerances {
    /// Settings for a single sheet: sticking contacts must not creep, and momentum is conserved.
    pub const SINGLE_SHEET: Self = Self {
        gap: 2e-7,
        slip_weight: 10.0,
        weight_factor: DVec3::new(100.0, 10.0, 10.0),
        maximum_weight_factor: 1e4,
        balance: 1e-7,
        balance_late: 1e-7,
        balance_interior: 1e-3,
        interior: InteriorPointTolerances::SINGLE_SHEET,
        maximum_bound_updates: 5,
        // A sheet that lies loosely around a needle, with half of its contacts near the friction
        // bound, needs between 20 and 30. A failed solve costs more than the spare iterations
        // because the step is then bisected.
        interior_point_iteration: 40,
        regularised: false,
    };
    /// Settings for several sheets during an impact, in which some contact changes between stick
    /// and slip in every iteration. The friction bounds follow the normal forces from solve to
    /// solve.
    pub const IMPACT: Self = Self {
        gap: 5e-6,
        slip_weight: 1.0,
        weight_factor: DVec3::new(30.0, 3.0, 3.0),
        maximum_weight_factor: 0.0,
        balance: 1e-3,
        balance_late: 5e-2,
        balance_interior: 1e-2,
        interior: InteriorPointTolerances::SEVERAL_SHEETS,
        maximum_bound_updates: 0,
        interior_point_iteration: 14,
        regularised: true,
    };
    /// Settings for several sheets without bisection. The acceleration of a sliding sheet is within
    /// 2 % of the exact one (0.5 to 7 % with `maximum_bound_updates: 0`). [`Self::FEW_SHEETS`]
    /// takes 1.2 to 1.6 times as long for a falling house of cards.
    pub const SEVERAL_SHEETS: Self = Self { balance_late: 1e-2, maximum_bound_updates: 1, ..Self::IMPACT };
    /// Settings for a few sheets without bisection. The acceleration of a sliding sheet is within
    /// 1e-4 of the exact one. With ten times the tolerance of the balance, steps of a sheet that
    /// slides at 35° may fail to converge for seconds.
    pub const FEW_SHEETS: Self = Self { balance_late: 1e-4, maximum_bound_updates: 2, ..Self::IMPACT };
    /// Settings for an outer iteration of a single sheet that is far from the solution.
    pub const ROUGH: Self = Self {
        gap: 1e-5,
        slip_weight: 10.0,
        balance: 1e-3,
        balance_late: 1e-3,
        balance_interior: 1e-2,
        maximum_bound_updates: 0,
        ..Self::SINGLE_SHEET
    };
    /// Settings for an outer iteration of several sheets that is far from the solution.
    pub const ROUGH_SEVERAL_SHEETS: Self =
        Self { gap: 1e-5, slip_weight: 10.0, weight_factor: Self::SINGLE_SHEET.weight_factor, ..Self::IMPACT };

    /// Maximum number of iterations without updates of the friction bounds; `in_forces` says
    /// whether the unknowns are contact forces.
    fn maximum_iterations(&self, in_forces: bool) -> u32 {
        if in_forces {
            self.interior_point_iteration.min(SETTINGS.maximum_iterations_in_forces)
        } else {
            self.interior_point_iteration
        }
    }

    /// Tolerance of the force balance in iteration `round`.
    fn balance_at(&self, round: u32) -> f64 {
        if round < SETTINGS.iterations_before_late_balance { self.balance } else { self.balance_late }
    }
}

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
        let tolerance = accuracy.gap;
        let (mut updated, mut exact, mut trusted, mut inside) = (0, true, true, false);
        let (mut before, mut first) = (f64::INFINITY, f64::INFINITY);
        let mut just_held = false;
        for round in 0.. {
            let patience =
                accuracy.maximum_iterations(space.has_cheap_factorisation()) + SETTINGS.iterations_per_update * updated;
            let soon = round == SETTINGS.iterations_before_interior_point
                && !accuracy.regularised
                && !exact
                && !space.has_cheap_factorisation()
                && self.changed_fraction() > SETTINGS.changes_threshold;
            // Updated forces open contacts for one iteration.
            let lost = accuracy.regularised && !just_held && self.needs_interior_point(round, &mut first, accuracy);
            if !inside && (soon || lost || round == patience) {
                if !space.has_cheap_factorisation() && self.solve_interior_point(space, accuracy) {
                    return true;
                }
                // The result of the interior point method may be a good initial value even if it
                // did not converge.
                inside = true;
            }
            if round == patience {
                return false;
            }
            let braced = accuracy.regularised
                && !space.has_cheap_factorisation()
                && if round == 0 {
                    self.changed_fraction() > SETTINGS.changes_threshold
                } else {
                    self.regularised && !exact
                };
            if std::mem::replace(&mut self.regularised, braced) != braced {
                self.factored_states.clear();
            }
            self.update_states();
            let balanced = self.compute_right_side(space) <= accuracy.balance_at(round);
            just_held = balanced;
            if balanced {
                let missed = self.residual(accuracy.slip_weight);
                self.update_forces();
                let stalled = missed > (1.0 - SETTINGS.stagnation_decrease) * before
                    && missed <= SETTINGS.stagnation_residual * tolerance;
                if missed > SETTINGS.slow_convergence_ratio * before
                    && self.weight_factor.x < accuracy.maximum_weight_factor
                {
                    self.weight_factor *= SETTINGS.weight_growth;
                    self.factored_states.clear();
                }
                before = missed;
                if missed <= tolerance || stalled {
                    if updated >= accuracy.maximum_bound_updates || !self.update_friction_bounds() {
                        return true;
                    }
                    updated += 1;
                }
                self.update_states();
                self.compute_right_side(space);
            }
            // The factor at hand is tried first: a change of friction states alone often makes
            // little difference.
            let will_do = trusted && self.has_same_closed_contacts();
            if !will_do && !self.factorize(space) {
                return false;
            }
            self.solve_step(space);
            let small = self.du.iter().all(|du| du.abs().max_element() <= tolerance);
            trusted = !will_do || (small && balanced);
            exact = self.line_search_step(space) || small;
        }
        false
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

    /// Compute the right-hand side of a Newton step for the present contact states. Returns the
    /// relative imbalance of [`AugmentedLagrangian::compute_imbalance`].
    fn compute_right_side(&mut self, space: &dyn UnknownSpace) -> f64 {
        self.compute_imbalance(space, |all, i, row| {
            let p = || {
                project_force(row, all.force[i] - row.stiffness * all.weight_factor * all.u[i], all.friction_bounds[i])
            };
            all.states[i].is_active().then(p)
        })
    }

    /// Compute the imbalance Jᵀ p - H δ for the contact forces that `force` returns, and store it
    /// as the right-hand side. Returns its sum as a fraction of the sum of forces; if all contacts
    /// are open, of a fraction of the largest sum in this solve, so that rounding errors are not
    /// compared to themselves.
    fn compute_imbalance(
        &mut self,
        space: &dyn UnknownSpace,
        force: impl Fn(&Self, usize, &SolverConstraint) -> Option<DVec3>,
    ) -> f64 {
        let mut step = std::mem::take(&mut self.step);
        for (to, from) in step.iter_mut().zip(&self.h_delta) {
            *to = -from;
        }
        let mut all = 0.0;
        for (i, row) in self.constraints.iter().enumerate() {
            if let Some(p) = force(self, i, row) {
                space.add_force(i, row, p, &mut step);
                all += p.abs().element_sum();
            }
        }
        self.largest_force_sum = self.largest_force_sum.max(all);
        let short: f64 = step.iter().map(|r| r.abs()).sum();
        self.step = step;
        short / all.max(SETTINGS.rounding * self.largest_force_sum).max(f64::MIN_POSITIVE)
    }

    /// Whether the factor at hand was computed for the same set of closed contacts.
    fn has_same_closed_contacts(&self) -> bool {
        let alike = self.factored_states.len() == self.states.len();
        alike && self.factored_states.iter().zip(&self.states).all(|(a, b)| a.is_closed == b.is_closed)
    }

    /// Factorise for the present contact states. Returns false if the matrix has no factor.
    fn factorize(&mut self, space: &mut dyn UnknownSpace) -> bool {
        let alike = self.factored_states.len() == self.states.len();
        if alike && self.factored_states.iter().zip(&self.states).all(|(a, b)| a.is_near(b)) {
            return true;
        }
        self.weights.clear();
        let (braced, stiffer) = (self.regularised, self.weight_factor);
        let weight =
            |(row, state): (&SolverConstraint, &ContactState)| derivative(row.stiffness * stiffer, state, braced);
        self.weights.extend(self.constraints.iter().zip(&self.states).map(weight));
        let done = space.factorize(&self.constraints, &self.weights);
        self.factored_states.clear();
        if done {
            self.factors += 1;
            self.factored_states.extend_from_slice(&self.states);
        }
        done
    }

    /// Solve for the step s and the change of u at every contact.
    fn solve_step(&mut self, space: &mut dyn UnknownSpace) {
        self.steps += 1;
        space.solve(&self.constraints, &self.weights, (&mut self.step, &mut self.h_step), &mut self.du);
    }

    /// Move along the step to the minimum of Φ. Returns whether the contact states are then those
    /// of the factor.
    fn line_search_step(&mut self, space: &dyn UnknownSpace) -> bool {
        let supposed = |(i, row): (usize, &SolverConstraint)| {
            let trial = self.force[i] - row.stiffness * self.weight_factor * (self.u[i] + self.du[i]);
            state_of(row, trial, self.friction_bounds[i]).is_near(&self.factored_states[i])
        };
        // Φ is then quadratic along the step, and the full step is its minimum.
        let exact = self.constraints.iter().enumerate().all(supposed);
        let part = if exact || self.regularised { 1.0 } else { self.line_search(space) };
        self.move_along_step(part);
        exact
    }

    /// Move δ and u along the fraction `part` of the step.
    fn move_along_step(&mut self, part: f64) {
        for (to, by) in self.delta.iter_mut().zip(&self.step) {
            *to += part * by;
        }
        for (to, by) in self.h_delta.iter_mut().zip(&self.h_step) {
            *to += part * by;
        }
        for (to, by) in self.u.iter_mut().zip(&self.du) {
            *to += *by * part;
        }
    }

    /// Fraction of the step at which Φ is near its minimum.
    fn line_search(&self, space: &dyn UnknownSpace) -> f64 {
        let work = |forces: &[f64]| space.work(&self.step, &self.du, forces);
        let (constant, linear) = (work(&self.h_delta), work(&self.h_step));
        let slope = |part: f64| {
            let each = self.constraints.iter().enumerate().map(|(i, row)| {
                let trial = self.force[i] - row.stiffness * self.weight_factor * (self.u[i] + self.du[i] * part);
                self.du[i].dot(project_force(row, trial, self.friction_bounds[i]))
            });
            constant + part * linear - each.sum::<f64>()
        };
        let (first, last) = (slope(0.0), slope(1.0));
        let flat = SETTINGS.line_search_slope * first.abs();
        if first >= 0.0 || last <= flat {
            return 1.0;
        }
        let (mut low, mut high) = ((0.0, first), (1.0, last));
        let mut part = 1.0;
        for k in 0..SETTINGS.maximum_line_search_points {
            // The slope increases along the step. Bisection alternates with secant steps, which
            // alone converge slowly.
            let secant = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
            part = if k % 2 == 0 { secant } else { 0.5 * (low.0 + high.0) };
            let here = slope(part);
            if here.abs() <= flat {
                break;
            }
            if here < 0.0 {
                low = (part, here);
            } else {
                high = (part, here);
            }
        }
        part
    }
}
