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

use crate::contact::coulomb::Law;
use crate::contact::settings::{ContactSettings, InteriorPointSettings};
use crate::contact::solver::augmented_lagrangian::{Accuracy, Primal, Space};

const SETTINGS: InteriorPointSettings = ContactSettings::DEFAULT.interior_point;

/// Settings of the interior point method: tolerances at the end of the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inside {
    /// Tolerance of m as a fraction of its initial value.
    pub down: f64,
    /// Tolerance of gaps and slips, m.
    pub miss: f64,
    /// Tolerance of the force balance as a fraction of the sum of forces.
    pub balanced: f64,
}

impl Inside {
    /// Settings for a single sheet.
    pub const FINE: Self = Self { down: 1e-9, miss: 1e-8, balanced: 1e-5 };
    /// Settings for several sheets. A tolerance of a thousandth of this takes twice the iterations.
    pub const TOGETHER: Self = Self { down: 1e-6, miss: 1e-7, balanced: 1e-2 };
}

/// Gaps (m) and normal forces (N) on the path.
#[derive(Default)]
pub(crate) struct Interior {
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

impl Primal {
    /// Whether contact `i` is unilateral and enabled, so that the path includes it.
    fn is_inner(&self, i: usize) -> bool {
        !self.rows[i].idle && self.rows[i].law != Law::Glue
    }

    /// Follow the path to its end from the present δ and u; leaves δ, u and the forces of its end.
    /// Returns false if it is not reached.
    pub(crate) fn go_inside(&mut self, space: &mut dyn Space, accuracy: &Accuracy) -> bool {
        let mut inner = std::mem::take(&mut self.interior);
        inner.begin(self);
        let first = inner.mean(self);
        let mut fine = true;
        for _ in 0..SETTINGS.maximum_iterations {
            let mean = inner.mean(self);
            inner.smooth = (inner.scale * (mean / first).powf(SETTINGS.smoothing_exponent)).max(1e-9);
            let Inside { down, miss, balanced } = accuracy.inside;
            let ended = mean <= down * first && inner.missed(self).max(inner.unturned(self)) <= miss;
            if ended && inner.unbalanced(self, space) <= balanced {
                break;
            }
            fine = self.factorize_inside(space, &inner);
            if !fine {
                break;
            }
            inner.product.iter_mut().for_each(|q| *q = 0.0);
            self.step_inside(space, &mut inner);
            let (by_gap, by_force) = inner.reach(1.0);
            let ahead = inner.mean_ahead(self, by_gap.min(by_force));
            let sigma = (ahead / mean).powi(3);
            for i in 0..inner.product.len() {
                inner.product[i] = sigma * mean - inner.gap_step[i] * inner.force_step[i];
            }
            self.step_inside(space, &mut inner);
            let (by_gap, by_force) = inner.reach(SETTINGS.boundary_fraction);
            let part = by_gap.min(by_force);
            inner.turn(self, part);
            self.go(part);
            inner.go(part);
        }
        for i in 0..self.rows.len() {
            if self.is_inner(i) {
                // Either s or p is zero at the solution: the smaller one, in units of force.
                let pushes = inner.force[i] > inner.gap[i] * self.rows[i].stiffness.x;
                let normal = if pushes { inner.force[i] } else { 0.0 };
                self.limits[i] = inner.limit(&self.rows[i], normal);
                let friction = inner.slip[i] * -self.limits[i];
                self.force[i] = DVec3::new(normal, friction.x, friction.y);
            }
        }
        self.aim();
        self.factored.clear();
        fine &= inner.mean(self) <= SETTINGS.accepted_mean * first
            && inner.missed(self).max(inner.unturned(self)) <= SETTINGS.accepted_error;
        fine &= inner.unbalanced(self, space) <= accuracy.balance_inside;
        for (p, (row, u)) in self.force.iter_mut().zip(self.rows.iter().zip(&self.u)) {
            if row.law == Law::Glue {
                *p -= row.stiffness * self.stiffer * *u;
            }
        }
        self.interior = inner;
        fine
    }

    /// Factorise with the weight p/s at every contact.
    fn factorize_inside(&mut self, space: &mut dyn Space, inner: &Interior) -> bool {
        self.factored.clear();
        self.factors += 1;
        let weight = |(i, row): (usize, &crate::contact::solver::augmented_lagrangian::Row)| {
            if row.idle { DMat3::ZERO } else { inner.weight(row, i, self.u[i], self.stiffer) }
        };
        self.weights.clear();
        self.weights.extend(self.rows.iter().enumerate().map(weight));
        space.factorize(&self.rows, &self.weights)
    }

    /// Solve for the step that brings s p to `product`, with the factor at hand.
    fn step_inside(&mut self, space: &mut dyn Space, inner: &mut Interior) {
        self.steps += 1;
        self.fall_short(space, |all, i, row| {
            if row.law == Law::Glue {
                return Some(all.force[i] - all.weights[i] * all.u[i]);
            }
            let (s, p) = (inner.gap[i], inner.force[i]);
            let forces = || {
                let normal = p - (s * p - inner.product[i]) / s - p / s * (all.u[i].x - s);
                let slip = DVec2::new(all.u[i].y, all.u[i].z);
                let friction = slip * (-inner.limit(row, p) / inner.length(slip));
                DVec3::new(normal, friction.x, friction.y)
            };
            (!row.idle).then(forces)
        });
        space.solve(&self.rows, &self.weights, (&mut self.step, &mut self.step_pull), &mut self.du);
        for (i, du) in self.du.iter().enumerate() {
            if self.is_inner(i) {
                let (s, p) = (inner.gap[i], inner.force[i]);
                inner.gap_step[i] = du.x + self.u[i].x - s;
                inner.force_step[i] = -(s * p - inner.product[i]) / s - p / s * inner.gap_step[i];
            }
        }
    }
}

impl Interior {
    /// Set initial gaps and forces, both positive.
    fn begin(&mut self, primal: &Primal) {
        let count = primal.rows.len();
        for list in [&mut self.gap, &mut self.force, &mut self.gap_step, &mut self.force_step, &mut self.product] {
            list.clear();
            list.resize(count, 0.0);
        }
        self.slip.clear();
        self.slip.resize(count, DVec2::ZERO);
        let deepest = primal.u.iter().enumerate().filter(|(i, _)| primal.is_inner(*i));
        let scale = deepest.map(|(_, u)| -u.x).fold(1e-6, f64::max);
        self.scale = scale;
        for (i, row) in primal.rows.iter().enumerate().filter(|(i, _)| primal.is_inner(*i)) {
            self.gap[i] = primal.u[i].x.max(scale);
            self.force[i] = primal.force[i].x.max(row.stiffness.x * scale);
        }
    }

    /// Friction bound of a contact with normal force `p` (N), N.
    fn limit(&self, row: &crate::contact::solver::augmented_lagrangian::Row, p: f64) -> f64 {
        match row.law {
            Law::Coulomb(friction) => friction * p,
            Law::Glue => 0.0,
        }
    }

    /// Smoothed length √(|u_t|² + ε²) of a slip, m.
    fn length(&self, slip: DVec2) -> f64 {
        (slip.length_squared() + self.smooth * self.smooth).sqrt()
    }

    /// D of a contact with relative displacement `u`, N/m.
    fn weight(
        &self,
        row: &crate::contact::solver::augmented_lagrangian::Row,
        i: usize,
        u: DVec3,
        stiffer: DVec3,
    ) -> DMat3 {
        if row.law == Law::Glue {
            return DMat3::from_diagonal(row.stiffness * stiffer);
        }
        let (slip, limit) = (DVec2::new(u.y, u.z), self.limit(row, self.force[i]));
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
    fn turn(&mut self, primal: &Primal, part: f64) {
        for i in (0..self.gap.len()).filter(|i| primal.is_inner(*i)) {
            let slip = DVec2::new(primal.u[i].y, primal.u[i].z);
            let step = DVec2::new(primal.du[i].y, primal.du[i].z);
            let (length, w) = (self.length(slip), self.slip[i]);
            let by = (step - w * (slip.dot(step) / length) - (w * length - slip)) / length;
            self.slip[i] = (w + by * part).clamp_length_max(1.0 - 1e-9);
        }
    }

    /// Mean m of s p, N m.
    fn mean(&self, primal: &Primal) -> f64 {
        self.mean_ahead(primal, 0.0)
    }

    /// Mean of s p after the fraction `part` of the step.
    fn mean_ahead(&self, primal: &Primal, part: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for i in (0..self.gap.len()).filter(|i| primal.is_inner(*i)) {
            sum += (self.gap[i] + part * self.gap_step[i]) * (self.force[i] + part * self.force_step[i]);
            count += 1;
        }
        sum / f64::from(count.max(1))
    }

    /// Largest difference between s and J δ + b, m.
    fn missed(&self, primal: &Primal) -> f64 {
        let inner = (0..self.gap.len()).filter(|i| primal.is_inner(*i));
        inner.map(|i| (primal.u[i].x - self.gap[i]).abs()).fold(0.0, f64::max)
    }

    /// Imbalance of forces as a fraction of their sum.
    fn unbalanced(&self, primal: &mut Primal, space: &dyn Space) -> f64 {
        primal.fall_short(space, |all, i, row| {
            if row.law == Law::Glue {
                return Some(all.force[i] - row.stiffness * all.stiffer * all.u[i]);
            }
            let friction = self.slip[i] * -self.limit(row, self.force[i]);
            (!row.idle).then(|| DVec3::new(self.force[i], friction.x, friction.y))
        })
    }

    /// Largest difference between u_t and the slip that corresponds to w, m.
    fn unturned(&self, primal: &Primal) -> f64 {
        let inner = (0..self.gap.len()).filter(|i| primal.is_inner(*i));
        let each = inner.map(|i| {
            let slip = DVec2::new(primal.u[i].y, primal.u[i].z);
            // A contact without normal force has no friction.
            let rubs = self.force[i] > self.gap[i] * primal.rows[i].stiffness.x;
            if rubs { (self.slip[i] * self.length(slip) - slip).length() } else { 0.0 }
        });
        each.fold(0.0, f64::max)
    }

    /// Fractions of the step, times `within`, that keep gaps and forces positive; at most 1.
    fn reach(&self, within: f64) -> (f64, f64) {
        let most = |values: &[f64], steps: &[f64]| {
            let each =
                values.iter().zip(steps).filter(|(_, step)| **step < 0.0).map(|(value, step)| -within * value / step);
            each.fold(1.0, f64::min)
        };
        (most(&self.gap, &self.gap_step), most(&self.force, &self.force_step))
    }

    /// Move gaps and forces along the fraction `part` of the step.
    fn go(&mut self, part: f64) {
        for (to, by) in self.gap.iter_mut().zip(&self.gap_step).chain(self.force.iter_mut().zip(&self.force_step)) {
            *to += part * by;
        }
    }
}
