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
//! of the displacement matrix (`tangent`), or of the matrix of contact forces (`unknowns`).
//!
//! Two measures keep the iteration from cycling when many contacts change state: regularised steps,
//! whose D bounds the curvature of friction from above, and the interior point method
//! (`interior_point`).
//!
//! Sources: Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton
//! like solution methods", CMAME 92, 1991; Li, Sun, Toh, "A highly efficient semismooth Newton
//! augmented Lagrangian method", SIAM J. Optim. 28, 2018; Haslinger, "Approximation of the
//! Signorini problem with friction, obeying the Coulomb law", Math. Meth. Appl. Sci. 5, 1983.

pub(crate) mod block_row;
pub(crate) mod contact_state;
pub(crate) mod interior_point;
pub(crate) mod tangent;
#[cfg(test)]
mod tests;
pub(crate) mod unknowns;

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::Law;
use crate::contact::settings::{AugmentedLagrangianSettings, ContactSettings};
pub(crate) use crate::contact::solver::augmented_lagrangian::block_row::Row;
use crate::contact::solver::augmented_lagrangian::contact_state::{Rubs, State, projected, state_of, stiffness};
pub(crate) use crate::contact::solver::augmented_lagrangian::interior_point::Inside;
pub(crate) use crate::contact::solver::augmented_lagrangian::tangent::{Joint, Tangent, covers};
pub(crate) use crate::contact::solver::augmented_lagrangian::unknowns::{OnForces, OnMasses, Space};

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

/// Settings of a solve: tolerances, weights and iteration limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// Gap tolerance, m.
    pub gap: f64,
    /// ρ as a multiple of the stiffness of the sheet at the contact. With 100, a Newton step
    /// reduces the penetration to a hundredth. Friction has a smaller factor because it changes
    /// between stick and slip.
    pub stiffer: DVec3,
    /// Maximum of the normal factor when weights grow in slow convergence. Piles converge more
    /// slowly with larger weights.
    pub stiffest: f64,
    /// Weight of slip in the residual; slip of sticking contacts would add up from step to step.
    pub slip: f64,
    /// Tolerance of the force balance H δ = Jᵀ p, as a fraction of the sum of forces. A stiff
    /// contact has a force error at a small gap.
    pub balance: f64,
    /// Tolerance of the force balance in late iterations, see
    /// [`AugmentedLagrangianSettings::iterations_before_late_balance`]. When sheets slide over each
    /// other, a few contacts alternate between stick and slip for many iterations.
    pub balance_late: f64,
    /// Tolerance of the force balance after the interior point method, whose friction converges
    /// slowly.
    pub balance_inside: f64,
    /// Settings of the interior point method.
    pub inside: Inside,
    /// Maximum number of updates of the friction bounds.
    pub updates: u32,
    /// Iterations after which the interior point method is used in any case.
    pub patience: u32,
    /// Whether to regularise steps when many contacts change state: more robust, but slower near
    /// the solution.
    pub braced: bool,
}

impl Accuracy {
    /// Settings for a single sheet: sticking contacts must not creep, and momentum is conserved.
    pub const FINE: Self = Self {
        gap: 2e-7,
        slip: 10.0,
        stiffer: DVec3::new(100.0, 10.0, 10.0),
        stiffest: 1e4,
        balance: 1e-7,
        balance_late: 1e-7,
        balance_inside: 1e-3,
        inside: Inside::FINE,
        updates: 5,
        // A sheet that lies loosely around a needle, with half of its contacts near the friction
        // bound, needs between 20 and 30. A failed solve costs more than the spare iterations
        // because the step is then bisected.
        patience: 40,
        braced: false,
    };
    /// Settings for several sheets during an impact, in which some contact changes between stick
    /// and slip in every iteration. The friction bounds follow the normal forces from solve to
    /// solve.
    pub const TOGETHER: Self = Self {
        gap: 5e-6,
        slip: 1.0,
        stiffer: DVec3::new(30.0, 3.0, 3.0),
        stiffest: 0.0,
        balance: 1e-3,
        balance_late: 5e-2,
        balance_inside: 1e-2,
        inside: Inside::TOGETHER,
        updates: 0,
        patience: 14,
        braced: true,
    };
    /// Settings for several sheets without bisection. The acceleration of a sliding sheet is within
    /// 2 % of the exact one (0.5 to 7 % with `updates: 0`). [`Self::TOGETHER_FEW`] takes 1.2 to 1.6
    /// times as long for a falling house of cards.
    pub const TOGETHER_CALM: Self = Self { balance_late: 1e-2, updates: 1, ..Self::TOGETHER };
    /// Settings for a few sheets without bisection. The acceleration of a sliding sheet is within
    /// 1e-4 of the exact one. With ten times the tolerance of the balance, steps of a sheet that
    /// slides at 35° may fail to converge for seconds.
    pub const TOGETHER_FEW: Self = Self { balance_late: 1e-4, updates: 2, ..Self::TOGETHER };
    /// Settings for an outer iteration of a single sheet that is far from the solution.
    pub const ROUGH: Self = Self {
        gap: 1e-5,
        slip: 10.0,
        balance: 1e-3,
        balance_late: 1e-3,
        balance_inside: 1e-2,
        updates: 0,
        ..Self::FINE
    };
    /// Settings for an outer iteration of several sheets that is far from the solution.
    pub const ROUGH_TOGETHER: Self = Self { gap: 1e-5, slip: 10.0, stiffer: Self::FINE.stiffer, ..Self::TOGETHER };

    /// Maximum number of iterations without updates of the friction bounds; `in_forces` says
    /// whether the unknowns are contact forces.
    fn maximum_iterations(&self, in_forces: bool) -> u32 {
        if in_forces { self.patience.min(SETTINGS.maximum_iterations_in_forces) } else { self.patience }
    }

    /// Tolerance of the force balance in iteration `round`.
    fn balance_at(&self, round: u32) -> f64 {
        if round < SETTINGS.iterations_before_late_balance { self.balance } else { self.balance_late }
    }
}

/// Augmented Lagrangian solver and its arrays.
#[derive(Default)]
pub(crate) struct Primal {
    pub rows: Vec<Row>,
    /// Contact forces in the contact frames, N.
    pub force: Vec<DVec3>,
    /// Friction bound of each contact, N.
    limits: Vec<f64>,
    /// Difference between μ p_n and the friction bound of each contact, N.
    short: Vec<f64>,
    /// Last relaxation factor of the friction bounds.
    part: f64,
    /// Contact states at the present u.
    states: Vec<State>,
    /// Contact states for which the factor was computed; empty if there is none.
    factored: Vec<State>,
    /// D of each constraint in the factor, N/m.
    weights: Vec<DMat3>,
    /// u = J δ + b, m.
    u: Vec<DVec3>,
    /// Change of u along the step, m.
    du: Vec<DVec3>,
    /// Displacement δ.
    delta: Vec<f64>,
    /// H δ, N.
    pull: Vec<f64>,
    /// Right-hand side of a Newton step, then the step s.
    step: Vec<f64>,
    /// H s, N.
    step_pull: Vec<f64>,
    interior: interior_point::Interior,
    /// Largest sum of forces in this solve, N.
    most: f64,
    /// Newton iterations since the solver was created.
    pub steps: u64,
    /// ρ as a multiple of the stiffness of the sheet.
    stiffer: DVec3,
    /// Whether steps are regularised: D of a slipping contact also resists slip along its
    /// direction, and steps have full length.
    braced: bool,
    /// Factorisations since the solver was created.
    pub factors: u64,
}

impl Primal {
    /// Start a problem with another matrix.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.force.clear();
        self.states.clear();
        self.factored.clear();
    }

    /// Mark the constraints of the last solve as known; constraints added from now on are new.
    pub fn go_on(&mut self) {
        for (row, state) in self.rows.iter_mut().zip(&self.states) {
            row.new = false;
            row.slid = state.rubs == Rubs::Slides;
        }
        self.factored.clear();
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
        solve: impl FnOnce(&[Row], (&mut Vec<DVec3>, &mut Vec<DVec3>)) -> bool,
    ) -> bool {
        self.force.clear();
        self.force.extend_from_slice(begun);
        let settled = solve(&self.rows, (&mut self.force, &mut self.u));
        if settled {
            self.limits.clear();
            self.limits.extend(self.rows.iter().zip(&self.force).map(|(row, p)| match row.law {
                Law::Coulomb(friction) => friction * p.x.max(0.0),
                Law::Glue => f64::INFINITY,
            }));
            self.aim();
            self.factored.clear();
        }
        settled
    }

    /// Whether contact `i` slips.
    pub fn slides(&self, i: usize) -> bool {
        self.states[i].rubs == Rubs::Slides
    }

    /// Solve from the initial forces in `force`, and leave the solution there. Returns whether the
    /// iteration converged.
    ///
    /// Each iteration updates the contact states and the force balance. If the forces balance the
    /// displacement, the forces are updated; if gaps and slips are then within tolerance, the
    /// friction bounds are updated, and the solve ends when they no longer change. Otherwise a
    /// Newton step follows, with a new factor if the states have changed.
    pub fn solve(&mut self, space: &mut dyn Space, accuracy: &Accuracy) -> bool {
        if !self.guess(space, accuracy) {
            return false;
        }
        let tolerance = accuracy.gap;
        let (mut updated, mut exact, mut trusted, mut inside) = (0, true, true, false);
        let (mut before, mut first) = (f64::INFINITY, f64::INFINITY);
        let mut just_held = false;
        for round in 0.. {
            let patience = accuracy.maximum_iterations(space.is_cheap()) + SETTINGS.iterations_per_update * updated;
            let soon = round == SETTINGS.iterations_before_interior_point
                && !accuracy.braced
                && !exact
                && !space.is_cheap()
                && self.changes() > SETTINGS.changes_threshold;
            // Updated forces open contacts for one iteration.
            let lost = accuracy.braced && !just_held && self.is_lost(round, &mut first, accuracy);
            if !inside && (soon || lost || round == patience) {
                if !space.is_cheap() && self.go_inside(space, accuracy) {
                    return true;
                }
                // The result of the interior point method may be a good initial value even if it
                // did not converge.
                inside = true;
            }
            if round == patience {
                return false;
            }
            let braced = accuracy.braced
                && !space.is_cheap()
                && if round == 0 { self.changes() > SETTINGS.changes_threshold } else { self.braced && !exact };
            if std::mem::replace(&mut self.braced, braced) != braced {
                self.factored.clear();
            }
            self.aim();
            let balanced = self.load(space) <= accuracy.balance_at(round);
            just_held = balanced;
            if balanced {
                let missed = self.missed(accuracy.slip);
                self.project();
                let stalled = missed > (1.0 - SETTINGS.stagnation_decrease) * before
                    && missed <= SETTINGS.stagnation_residual * tolerance;
                if missed > SETTINGS.slow_convergence_ratio * before && self.stiffer.x < accuracy.stiffest {
                    self.stiffer *= SETTINGS.weight_growth;
                    self.factored.clear();
                }
                before = missed;
                if missed <= tolerance || stalled {
                    if updated >= accuracy.updates || !self.limit_friction() {
                        return true;
                    }
                    updated += 1;
                }
                self.aim();
                self.load(space);
            }
            // The factor at hand is tried first: a change of friction states alone often makes
            // little difference.
            let will_do = trusted && self.pushes_alike();
            if !will_do && !self.factorize(space) {
                return false;
            }
            self.solve_step(space);
            let small = self.du.iter().all(|du| du.abs().max_element() <= tolerance);
            trusted = !will_do || (small && balanced);
            exact = self.advance(space) || small;
        }
        false
    }

    /// Whether the regularised iteration has not come near the solution by iteration `round`;
    /// `first` is the residual of the first iteration, m.
    fn is_lost(&self, round: u32, first: &mut f64, accuracy: &Accuracy) -> bool {
        if round > 0 && !SETTINGS.regularised_checks.contains(&round) {
            return false;
        }
        let missed = self.missed(accuracy.slip);
        if round == 0 {
            *first = missed;
        }
        let [early, _] = SETTINGS.regularised_checks;
        round > 0
            && missed > SETTINGS.second_check_residual * accuracy.gap
            && (round > early || missed > SETTINGS.first_check_ratio * *first)
    }

    /// Compute the initial displacement, with the contact states of the initial forces.
    fn guess(&mut self, space: &mut dyn Space, accuracy: &Accuracy) -> bool {
        self.most = 0.0;
        self.braced = false;
        self.stiffer = accuracy.stiffer;
        let n = space.size(&self.rows);
        for vector in [&mut self.delta, &mut self.pull, &mut self.step, &mut self.step_pull] {
            vector.clear();
            vector.resize(n, 0.0);
        }
        self.u.clear();
        self.u.extend(self.rows.iter().map(|r| r.b));
        self.du.clear();
        self.du.resize(self.rows.len(), DVec3::ZERO);
        self.begin();
        for (i, row) in self.rows.iter().enumerate() {
            let state = &self.states[i];
            if state.acts() {
                let d = stiffness(row.stiffness * self.stiffer, state, self.braced);
                let p = self.force[i];
                let normal = if state.pushes { p.x } else { 0.0 };
                let held = DVec3::new(normal, p.y, p.z) - d * row.b;
                space.push(i, row, held, &mut self.step);
                self.most += held.abs().element_sum();
            }
        }
        if !self.factorize(space) {
            return false;
        }
        self.solve_step(space);
        self.go(1.0);
        true
    }

    /// Set the initial contact states. A contact is closed if it has an initial force, or if it is
    /// new with a gap below `eager`.
    fn begin(&mut self) {
        self.states.clear();
        self.limits.clear();
        self.short.clear();
        for (row, p) in self.rows.iter().zip(&mut self.force) {
            let Law::Coulomb(friction) = row.law else {
                self.limits.push(f64::INFINITY);
                self.states.push(State { pushes: true, rubs: Rubs::Sticks, ..State::OPEN });
                continue;
            };
            if row.idle {
                *p = DVec3::ZERO;
            }
            let limit = friction * p.x.max(0.0);
            let tangential = DVec2::new(p.y, p.z).clamp_length_max(limit);
            (p.y, p.z) = (tangential.x, tangential.y);
            let rubs = match limit > 0.0 {
                false => Rubs::No,
                true if row.slid && tangential.length() > limit * (1.0 - SETTINGS.friction_tolerance) => Rubs::Slides,
                true => Rubs::Sticks,
            };
            self.limits.push(limit);
            let pushes = p.x > 0.0 || (row.new && !row.idle && row.b.x < row.eager);
            self.states.push(State { pushes, rubs, along: tangential.normalize_or_zero(), across: 1.0 });
        }
    }

    /// Fraction of contacts that open or close unexpectedly.
    fn changes(&self) -> f64 {
        let rows = self.rows.iter().enumerate();
        let other = rows.filter(|(i, row)| {
            let trial = self.force[*i] - row.stiffness * self.stiffer * self.u[*i];
            state_of(row, trial, self.limits[*i]).pushes != self.states[*i].pushes
        });
        other.count() as f64 / self.rows.len().max(1) as f64
    }

    /// Update the contact states from the present u.
    fn aim(&mut self) {
        for (i, row) in self.rows.iter().enumerate() {
            let next = state_of(row, self.force[i] - row.stiffness * self.stiffer * self.u[i], self.limits[i]);
            self.states[i] = next;
        }
    }

    /// Residual: largest gap or slip that should be zero, m, with weight `slips` of the slip.
    fn missed(&self, slips: f64) -> f64 {
        let each = self.rows.iter().zip(&self.u).zip(&self.states).map(|((row, u), state)| {
            if row.law == Law::Glue {
                return SETTINGS.attachment_weight * u.abs().max_element();
            }
            let slip = if state.rubs == Rubs::Sticks { slips * u.y.abs().max(u.z.abs()) } else { 0.0 };
            let gap = if state.pushes { u.x.abs() } else { (-u.x).max(0.0) };
            if row.idle { 0.0 } else { gap.max(slip) }
        });
        each.fold(0.0, f64::max)
    }

    /// Update the forces to P(p - ρ u).
    fn project(&mut self) {
        for (i, row) in self.rows.iter().enumerate() {
            self.force[i] = projected(row, self.force[i] - row.stiffness * self.stiffer * self.u[i], self.limits[i]);
        }
    }

    /// Move the friction bounds towards μ p_n. Returns false if they are within tolerance. The full
    /// update may oscillate, as for a sheet wedged between a floor and a needle; Aitken relaxation
    /// shortens it (Irons and Tuck, "A version of the Aitken accelerator for computer iteration",
    /// IJNME 1, 1969).
    fn limit_friction(&mut self) -> bool {
        let all: f64 = self.force.iter().map(|p| p.x).sum();
        let first = self.short.is_empty();
        self.short.resize(self.rows.len(), 0.0);
        let (mut changed, mut along, mut square) = (false, 0.0, 0.0);
        for (i, row) in self.rows.iter().enumerate() {
            let Law::Coulomb(friction) = row.law else { continue };
            let normal = self.force[i].x;
            let limit = if normal > SETTINGS.negligible_force * all { friction * normal } else { 0.0 };
            let slight = SETTINGS.friction_tolerance
                * limit.max(self.limits[i]).max(SETTINGS.minimum_bound_tolerance * friction * all);
            let short = limit - self.limits[i];
            changed |= match self.states[i].rubs {
                Rubs::Sticks => DVec2::new(self.force[i].y, self.force[i].z).length() > limit + slight,
                _ => short.abs() > slight,
            };
            let by = short - self.short[i];
            along += self.short[i] * by;
            square += by * by;
            self.short[i] = short;
        }
        let is_known = !first && square > 0.0;
        self.part = if is_known { (-self.part * along / square).clamp(SETTINGS.minimum_relaxation, 1.0) } else { 1.0 };
        for (limit, short) in self.limits.iter_mut().zip(&self.short) {
            *limit = (*limit + self.part * short).max(0.0);
        }
        changed
    }

    /// Compute the right-hand side of a Newton step for the present contact states. Returns the
    /// relative imbalance of [`Primal::fall_short`].
    fn load(&mut self, space: &dyn Space) -> f64 {
        self.fall_short(space, |all, i, row| {
            let p = || projected(row, all.force[i] - row.stiffness * all.stiffer * all.u[i], all.limits[i]);
            all.states[i].acts().then(p)
        })
    }

    /// Compute the imbalance Jᵀ p - H δ for the contact forces that `force` returns, and store it
    /// as the right-hand side. Returns its sum as a fraction of the sum of forces; if all contacts
    /// are open, of a fraction of the largest sum in this solve, so that rounding errors are not
    /// compared to themselves.
    fn fall_short(&mut self, space: &dyn Space, force: impl Fn(&Self, usize, &Row) -> Option<DVec3>) -> f64 {
        let mut step = std::mem::take(&mut self.step);
        for (to, from) in step.iter_mut().zip(&self.pull) {
            *to = -from;
        }
        let mut all = 0.0;
        for (i, row) in self.rows.iter().enumerate() {
            if let Some(p) = force(self, i, row) {
                space.push(i, row, p, &mut step);
                all += p.abs().element_sum();
            }
        }
        self.most = self.most.max(all);
        let short: f64 = step.iter().map(|r| r.abs()).sum();
        self.step = step;
        short / all.max(SETTINGS.rounding * self.most).max(f64::MIN_POSITIVE)
    }

    /// Whether the factor at hand was computed for the same set of closed contacts.
    fn pushes_alike(&self) -> bool {
        let alike = self.factored.len() == self.states.len();
        alike && self.factored.iter().zip(&self.states).all(|(a, b)| a.pushes == b.pushes)
    }

    /// Factorise for the present contact states. Returns false if the matrix has no factor.
    fn factorize(&mut self, space: &mut dyn Space) -> bool {
        let alike = self.factored.len() == self.states.len();
        if alike && self.factored.iter().zip(&self.states).all(|(a, b)| a.is_near(b)) {
            return true;
        }
        self.weights.clear();
        let (braced, stiffer) = (self.braced, self.stiffer);
        let weight = |(row, state): (&Row, &State)| stiffness(row.stiffness * stiffer, state, braced);
        self.weights.extend(self.rows.iter().zip(&self.states).map(weight));
        let done = space.factorize(&self.rows, &self.weights);
        self.factored.clear();
        if done {
            self.factors += 1;
            self.factored.extend_from_slice(&self.states);
        }
        done
    }

    /// Solve for the step s and the change of u at every contact.
    fn solve_step(&mut self, space: &mut dyn Space) {
        self.steps += 1;
        space.solve(&self.rows, &self.weights, (&mut self.step, &mut self.step_pull), &mut self.du);
    }

    /// Move along the step to the minimum of Φ. Returns whether the contact states are then those
    /// of the factor.
    fn advance(&mut self, space: &dyn Space) -> bool {
        let supposed = |(i, row): (usize, &Row)| {
            let trial = self.force[i] - row.stiffness * self.stiffer * (self.u[i] + self.du[i]);
            state_of(row, trial, self.limits[i]).is_near(&self.factored[i])
        };
        // Φ is then quadratic along the step, and the full step is its minimum.
        let exact = self.rows.iter().enumerate().all(supposed);
        let part = if exact || self.braced { 1.0 } else { self.search(space) };
        self.go(part);
        exact
    }

    /// Move δ and u along the fraction `part` of the step.
    fn go(&mut self, part: f64) {
        for (to, by) in self.delta.iter_mut().zip(&self.step) {
            *to += part * by;
        }
        for (to, by) in self.pull.iter_mut().zip(&self.step_pull) {
            *to += part * by;
        }
        for (to, by) in self.u.iter_mut().zip(&self.du) {
            *to += *by * part;
        }
    }

    /// Fraction of the step at which Φ is near its minimum.
    fn search(&self, space: &dyn Space) -> f64 {
        let work = |forces: &[f64]| space.work(&self.step, &self.du, forces);
        let (constant, linear) = (work(&self.pull), work(&self.step_pull));
        let slope = |part: f64| {
            let each = self.rows.iter().enumerate().map(|(i, row)| {
                let trial = self.force[i] - row.stiffness * self.stiffer * (self.u[i] + self.du[i] * part);
                self.du[i].dot(projected(row, trial, self.limits[i]))
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
