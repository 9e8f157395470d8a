//! Interior point method for the normal forces, used when many contacts change state at once, as in
//! the impact of a pack of cards.
//!
//! An active-set method changes the set of closed contacts card by card. A path through the
//! interior does not. With gaps s > 0 and normal forces p > 0,
//!
//!   H δ = Jᵀ p,  s = J δ + b,  s p = σ m,  m the mean of s p.
//!
//! Each iteration solves (H + Jᵀ (p/s) J) Δ = ... twice with one factorisation: a predictor with σ
//! = 0, which determines σ, and a corrector with this σ and the second-order terms of the
//! predictor. Friction with bound L = μ p_n is smoothed: p_t = -L w with w √(|u_t|² + ε²) = u_t,
//! and ε decreases with m. About twenty iterations suffice for any number of contacts.
//!
//! Sources: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J.
//! Optim. 2, 1992; Chan, Golub, Mulet, "A nonlinear primal-dual method for total variation-based
//! image restoration", SIAM J. Sci. Comput. 20, 1999, for the smoothed length.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::contact::settings::{ContactSettings, InteriorPointSettings};
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangian, AugmentedLagrangianTolerances, UnknownSpace};

const SETTINGS: InteriorPointSettings = ContactSettings::DEFAULT.interior_point;

/// Settings of the interior point method: tolerances at the end of the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InteriorPointTolerances {
    /// Tolerance of m as a fraction of its initial value.
    pub path_tolerance: f64,
    /// Tolerance of gaps and slips, in half thicknesses.
    pub gap_tolerance: f64,
    /// Tolerance of the force balance as a fraction of the sum of forces.
    pub balance_tolerance: f64,
}

impl InteriorPointTolerances {
    /// Settings for a single sheet.
    pub const SINGLE_SHEET: Self = Self { path_tolerance: 1e-9, gap_tolerance: 4e-5, balance_tolerance: 1e-5 };
    /// Settings for several sheets. A tolerance of a thousandth of this takes twice the iterations.
    pub const SEVERAL_SHEETS: Self = Self { path_tolerance: 1e-6, gap_tolerance: 4e-4, balance_tolerance: 1e-2 };
}

/// Gaps (m) and normal forces (N) on the path.
#[derive(Default)]
pub(crate) struct InteriorPoint {
    gap: Vec<f64>,
    force: Vec<f64>,
    /// Friction direction w, scaled to length 1 in full slip.
    slip: Vec<DVec2>,
    /// Smoothing length ε, m.
    smooth: f64,
    /// Initial penetration, m.
    scale: f64,
    /// Steps of gaps and forces.
    gap_step: Vec<f64>,
    force_step: Vec<f64>,
    /// Target of s p, N m.
    product: Vec<f64>,
}

impl AugmentedLagrangian {
    /// Whether contact `i` is unilateral and enabled, so that the path includes it.
    fn is_unilateral(&self, i: usize) -> bool {
        !self.constraints[i].is_disabled && self.constraints[i].law != ContactLaw::Attachment
    }

    /// Follow the path to its end from the present δ and u; leaves δ, u and the forces of its end.
    /// Returns false if it is not reached.
    pub(crate) fn solve_interior_point(
        &mut self,
        space: &mut dyn UnknownSpace,
        accuracy: &AugmentedLagrangianTolerances,
    ) -> bool {
        let mut inner = std::mem::take(&mut self.interior);
        let (half, ends) = (accuracy.half_thickness, accuracy.interior);
        inner.begin(self, half);
        let (first, mut fine) = (inner.mean(self), true);
        for _ in 0..SETTINGS.maximum_iterations {
            let mean = inner.mean(self);
            let path = (mean / first).powf(SETTINGS.smoothing_exponent);
            inner.smooth = (inner.scale * path).max(SETTINGS.least_smoothing * half);
            let ended = mean <= ends.path_tolerance * first
                && inner.residual(self).max(inner.slip_residual(self)) <= ends.gap_tolerance * half;
            if ended && inner.imbalance(self, space) <= ends.balance_tolerance {
                break;
            }
            fine = self.factorize_interior(space, &inner);
            if !fine {
                break;
            }
            inner.product.iter_mut().for_each(|q| *q = 0.0);
            self.step_interior(space, &mut inner);
            let (by_gap, by_force) = inner.step_to_boundary(1.0);
            let ahead = inner.mean_after(self, by_gap.min(by_force));
            let sigma = (ahead / mean).powi(3);
            for i in 0..inner.product.len() {
                inner.product[i] = sigma * mean - inner.gap_step[i] * inner.force_step[i];
            }
            self.step_interior(space, &mut inner);
            let (by_gap, by_force) = inner.step_to_boundary(SETTINGS.boundary_fraction);
            let part = by_gap.min(by_force);
            inner.rotate_friction(self, part);
            self.move_along_step(part);
            inner.move_along_step(part);
        }
        for i in 0..self.constraints.len() {
            if self.is_unilateral(i) {
                // Either s or p is zero at the solution: the smaller one, in units of force.
                let pushes = inner.force[i] > inner.gap[i] * self.constraints[i].stiffness.x;
                let normal = if pushes { inner.force[i] } else { 0.0 };
                self.friction_bounds[i] = inner.friction_bound(&self.constraints[i], normal);
                let friction = inner.slip[i] * -self.friction_bounds[i];
                self.force[i] = DVec3::new(normal, friction.x, friction.y);
            }
        }
        self.update_states();
        self.factored_states.clear();
        fine &= inner.mean(self) <= SETTINGS.accepted_mean * first
            && inner.residual(self).max(inner.slip_residual(self)) <= SETTINGS.accepted_error * half;
        fine &= inner.imbalance(self, space) <= accuracy.balance_interior;
        for (p, (row, u)) in self.force.iter_mut().zip(self.constraints.iter().zip(&self.u)) {
            if row.law == ContactLaw::Attachment {
                *p -= row.stiffness * self.weight_factor * *u;
            }
        }
        self.interior = inner;
        fine
    }

    /// Factorise with the weight p/s at every contact.
    fn factorize_interior(&mut self, space: &mut dyn UnknownSpace, inner: &InteriorPoint) -> bool {
        self.factored_states.clear();
        self.factors += 1;
        let weight = |(i, row): (usize, &crate::contact::solver::augmented_lagrangian::SolverConstraint)| {
            if row.is_disabled { DMat3::ZERO } else { inner.weight(row, i, self.u[i], self.weight_factor) }
        };
        self.weights.clear();
        self.weights.extend(self.constraints.iter().enumerate().map(weight));
        space.factorize(&self.constraints, &self.weights)
    }

    /// Solve for the step that brings s p to `product`, with the factor at hand.
    fn step_interior(&mut self, space: &mut dyn UnknownSpace, inner: &mut InteriorPoint) {
        self.steps += 1;
        self.compute_imbalance(space, |all, i, row| {
            if row.law == ContactLaw::Attachment {
                return Some(all.force[i] - all.weights[i] * all.u[i]);
            }
            let (s, p) = (inner.gap[i], inner.force[i]);
            let forces = || {
                let normal = p - (s * p - inner.product[i]) / s - p / s * (all.u[i].x - s);
                let slip = DVec2::new(all.u[i].y, all.u[i].z);
                let friction = slip * (-inner.friction_bound(row, p) / inner.length(slip));
                DVec3::new(normal, friction.x, friction.y)
            };
            (!row.is_disabled).then(forces)
        });
        space.solve(&self.constraints, &self.weights, (&mut self.step, &mut self.h_step), &mut self.du);
        for (i, du) in self.du.iter().enumerate() {
            if self.is_unilateral(i) {
                let (s, p) = (inner.gap[i], inner.force[i]);
                inner.gap_step[i] = du.x + self.u[i].x - s;
                inner.force_step[i] = -(s * p - inner.product[i]) / s - p / s * inner.gap_step[i];
            }
        }
    }
}

impl InteriorPoint {
    /// Set initial gaps and forces, both positive.
    fn begin(&mut self, primal: &AugmentedLagrangian, half_thickness: f64) {
        let count = primal.constraints.len();
        for list in [&mut self.gap, &mut self.force, &mut self.gap_step, &mut self.force_step, &mut self.product] {
            list.clear();
            list.resize(count, 0.0);
        }
        self.slip.clear();
        self.slip.resize(count, DVec2::ZERO);
        let deepest = primal.u.iter().enumerate().filter(|(i, _)| primal.is_unilateral(*i));
        let scale = deepest.map(|(_, u)| -u.x).fold(SETTINGS.least_penetration * half_thickness, f64::max);
        self.scale = scale;
        for (i, row) in primal.constraints.iter().enumerate().filter(|(i, _)| primal.is_unilateral(*i)) {
            self.gap[i] = primal.u[i].x.max(scale);
            self.force[i] = primal.force[i].x.max(row.stiffness.x * scale);
        }
    }

    /// Friction bound of a contact with normal force `p` (N), N.
    fn friction_bound(&self, row: &crate::contact::solver::augmented_lagrangian::SolverConstraint, p: f64) -> f64 {
        match row.law {
            ContactLaw::Coulomb(friction) => friction * p,
            ContactLaw::Attachment => 0.0,
        }
    }

    /// Smoothed length √(|u_t|² + ε²) of a slip, m.
    fn length(&self, slip: DVec2) -> f64 {
        (slip.length_squared() + self.smooth * self.smooth).sqrt()
    }

    /// D of a contact with relative displacement `u`, N/m.
    fn weight(
        &self,
        row: &crate::contact::solver::augmented_lagrangian::SolverConstraint,
        i: usize,
        u: DVec3,
        stiffer: DVec3,
    ) -> DMat3 {
        if row.law == ContactLaw::Attachment {
            return DMat3::from_diagonal(row.stiffness * stiffer);
        }
        let (slip, limit) = (DVec2::new(u.y, u.z), self.friction_bound(row, self.force[i]));
        let (length, w) = (self.length(slip), self.slip[i]);
        let turned = DMat2::from_cols(w * slip.x, w * slip.y);
        let across = (DMat2::IDENTITY - (turned + turned.transpose()) * (0.5 / length)) * (limit / length);
        DMat3::from_cols(
            DVec3::new(self.force[i] / self.gap[i], 0.0, 0.0),
            DVec3::new(0.0, across.x_axis.x, across.x_axis.y),
            DVec3::new(0.0, across.y_axis.x, across.y_axis.y),
        )
    }

    /// Move the friction directions w by the fraction `part` of the step.
    fn rotate_friction(&mut self, primal: &AugmentedLagrangian, part: f64) {
        for i in (0..self.gap.len()).filter(|i| primal.is_unilateral(*i)) {
            let slip = DVec2::new(primal.u[i].y, primal.u[i].z);
            let step = DVec2::new(primal.du[i].y, primal.du[i].z);
            let (length, w) = (self.length(slip), self.slip[i]);
            let by = (step - w * (slip.dot(step) / length) - (w * length - slip)) / length;
            self.slip[i] = (w + by * part).clamp_length_max(1.0 - 1e-9);
        }
    }

    /// Mean m of s p, N m.
    fn mean(&self, primal: &AugmentedLagrangian) -> f64 {
        self.mean_after(primal, 0.0)
    }

    /// Mean of s p after the fraction `part` of the step.
    fn mean_after(&self, primal: &AugmentedLagrangian, part: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for i in (0..self.gap.len()).filter(|i| primal.is_unilateral(*i)) {
            sum += (self.gap[i] + part * self.gap_step[i]) * (self.force[i] + part * self.force_step[i]);
            count += 1;
        }
        sum / f64::from(count.max(1))
    }

    /// Largest difference between s and J δ + b, m.
    fn residual(&self, primal: &AugmentedLagrangian) -> f64 {
        let inner = (0..self.gap.len()).filter(|i| primal.is_unilateral(*i));
        inner.map(|i| (primal.u[i].x - self.gap[i]).abs()).fold(0.0, f64::max)
    }

    /// Imbalance of forces as a fraction of their sum.
    fn imbalance(&self, primal: &mut AugmentedLagrangian, space: &dyn UnknownSpace) -> f64 {
        primal.compute_imbalance(space, |all, i, row| {
            if row.law == ContactLaw::Attachment {
                return Some(all.force[i] - row.stiffness * all.weight_factor * all.u[i]);
            }
            let friction = self.slip[i] * -self.friction_bound(row, self.force[i]);
            (!row.is_disabled).then(|| DVec3::new(self.force[i], friction.x, friction.y))
        })
    }

    /// Largest difference between u_t and the slip that corresponds to w, m.
    fn slip_residual(&self, primal: &AugmentedLagrangian) -> f64 {
        let inner = (0..self.gap.len()).filter(|i| primal.is_unilateral(*i));
        let each = inner.map(|i| {
            let slip = DVec2::new(primal.u[i].y, primal.u[i].z);
            // A contact without normal force has no friction.
            let rubs = self.force[i] > self.gap[i] * primal.constraints[i].stiffness.x;
            if rubs { (self.slip[i] * self.length(slip) - slip).length() } else { 0.0 }
        });
        each.fold(0.0, f64::max)
    }

    /// Fractions of the step, times `within`, that keep gaps and forces positive; at most 1.
    fn step_to_boundary(&self, within: f64) -> (f64, f64) {
        let most = |values: &[f64], steps: &[f64]| {
            let each =
                values.iter().zip(steps).filter(|(_, step)| **step < 0.0).map(|(value, step)| -within * value / step);
            each.fold(1.0, f64::min)
        };
        (most(&self.gap, &self.gap_step), most(&self.force, &self.force_step))
    }

    /// Move gaps and forces along the fraction `part` of the step.
    fn move_along_step(&mut self, part: f64) {
        for (to, by) in self.gap.iter_mut().zip(&self.gap_step).chain(self.force.iter_mut().zip(&self.force_step)) {
            *to += part * by;
        }
    }
}
