//! One Newton step of the augmented Lagrangian method: right-hand side, factor, line search.
//!
//! The step s (m) solves
//!
//!   (H + Σ Jᵀ D J) s = Jᵀ P(p - ρ u) - H δ,  D = ρ ∂P,
//!
//! with P the projection on the admissible forces (N) and D (N/m) its derivative at the present
//! contact states. The factor is renewed when the states change. A line search on
//!
//!   dΦ/dα = sᵀ H (δ + α s) - Σ (J s)ᵀ P(p - ρ (u + α J s))
//!
//! finds the fraction α of the step, unless the step is exact or regularised.

use glam::DVec3;

use crate::contact::settings::{AugmentedLagrangianSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::contact_state::{ContactState, derivative, project_force, state_of};
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangian, SolverConstraint, UnknownSpace};

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

impl AugmentedLagrangian {
    /// Compute the right-hand side of a Newton step for the present contact states. Returns the
    /// relative imbalance of [`AugmentedLagrangian::compute_imbalance`].
    pub(super) fn compute_right_side(&mut self, space: &dyn UnknownSpace) -> f64 {
        self.compute_imbalance(space, |all, i, row| {
            let p = || {
                project_force(row, all.force[i] - row.stiffness * all.weight_factor * all.u[i], all.friction_bounds[i])
            };
            all.states[i].is_active().then(p)
        })
    }

    /// Compute the imbalance Jᵀ p - H δ for the contact forces that `force` returns, and store
    /// it as the right-hand side. Returns its sum as a fraction of the sum of forces; if all
    /// contacts are open, of a fraction of the largest sum in this solve, so that rounding errors
    /// are not compared to themselves.
    pub(super) fn compute_imbalance(
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
    pub(super) fn has_same_closed_contacts(&self) -> bool {
        let alike = self.factored_states.len() == self.states.len();
        alike && self.factored_states.iter().zip(&self.states).all(|(a, b)| a.is_closed == b.is_closed)
    }

    /// Factorise for the present contact states. Returns false if the matrix has no factor.
    pub(super) fn factorize(&mut self, space: &mut dyn UnknownSpace) -> bool {
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
    pub(super) fn solve_step(&mut self, space: &mut dyn UnknownSpace) {
        self.steps += 1;
        space.solve(&self.constraints, &self.weights, (&mut self.step, &mut self.h_step), &mut self.du);
    }

    /// Move along the step to the minimum of Φ. Returns whether the contact states are then those
    /// of the factor.
    pub(super) fn line_search_step(&mut self, space: &dyn UnknownSpace) -> bool {
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
    pub(super) fn move_along_step(&mut self, part: f64) {
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
