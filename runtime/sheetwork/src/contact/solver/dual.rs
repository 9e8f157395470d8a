//! Dual contact solver of implicit integrators, with contact forces as unknowns, for small working
//! sets.
//!
//! The working set starts with the contacts that had a force and grows by contacts that the
//! solution violates, until none is left. All Newton iterations use one factorisation of each
//! sheet's tangent matrix. If the augmented Lagrangian method fails, the Alart-Curnier Newton
//! method is tried; then PGS, whose result starts the augmented Lagrangian method once more.

use glam::DVec3;

use crate::contact::IslandView;
use crate::contact::counters::ContactCounters;
use crate::contact::gap::contact_velocity_jump;
use crate::contact::settings::{AlartCurnierSettings, ContactSettings, DualSettings, PgsSettings, WorkingSetSettings};
use crate::contact::solver::alart_curnier::AlartCurnierSolver;
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangian, AugmentedLagrangianTolerances, DualSpace};
use crate::contact::solver::choice::PositionSolver;
use crate::contact::solver::delassus::frame_of;
use crate::contact::solver::primal::solve_counted;
use crate::contact::solver::working_set::WorkingSet;
use crate::contact::workspace::ContactWorkspace;
use crate::sheet::stage;

const SETTINGS: DualSettings = ContactSettings::DEFAULT.dual;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;
const ALART_CURNIER: AlartCurnierSettings = ContactSettings::DEFAULT.alart_curnier;
const WORKING_SET: WorkingSetSettings = ContactSettings::DEFAULT.working_set;

/// Dual solver and its arrays.
#[derive(Default)]
pub(crate) struct DualSolver {
    space: DualSpace,
    alart_curnier: AlartCurnierSolver,
    working_set: WorkingSet,
    /// Approach of the contacts outside the working set in the stage, m; negative if they close.
    gap: Vec<f64>,
    /// Initial forces, N.
    initial_forces: Vec<DVec3>,
    /// Relative position or velocity without contact, of every contact in the problem.
    b: Vec<DVec3>,
}

impl DualSolver {
    /// Solve the working set with three methods in turn. Returns false if none converges.
    fn solve(
        &mut self,
        lagrangian: &mut AugmentedLagrangian,
        counters: &mut ContactCounters,
        accuracy: &AugmentedLagrangianTolerances,
    ) -> bool {
        self.initial_forces.clone_from(&lagrangian.force);
        if lagrangian.constraints.is_empty() || solve_counted(lagrangian, &mut self.space, counters, accuracy) {
            return true;
        }
        if self.solve_alart_curnier(lagrangian, counters, accuracy) {
            return true;
        }
        self.b.clear();
        self.b.extend(lagrangian.constraints.iter().map(|row| row.b));
        let problem = &mut self.space.delassus.problem;
        problem.force.clone_from(&self.initial_forces);
        let tolerance = PGS.tolerance * accuracy.half_thickness;
        let swept = problem.solve(&self.b, tolerance, PGS.maximum_sweeps);
        counters.sweeps += u64::from(swept.sweeps);
        self.initial_forces.clone_from(&problem.force);
        lagrangian.force.clone_from(&self.initial_forces);
        if solve_counted(lagrangian, &mut self.space, counters, accuracy) {
            return true;
        }
        lagrangian.force.clone_from(&self.initial_forces);
        swept.change <= tolerance
    }

    /// Solve by the Alart-Curnier Newton method from the initial forces.
    fn solve_alart_curnier(
        &mut self,
        lagrangian: &mut AugmentedLagrangian,
        counters: &mut ContactCounters,
        accuracy: &AugmentedLagrangianTolerances,
    ) -> bool {
        let before = self.alart_curnier.steps;
        let settled = lagrangian.adopt(&self.initial_forces, |rows, state| {
            self.alart_curnier.solve(&self.space.delassus.problem, rows, accuracy, state)
        });
        let steps = self.alart_curnier.steps - before;
        counters.newton += steps;
        counters.factors += steps;
        counters.unsettled -= u64::from(settled);
        settled
    }
}

impl ContactWorkspace {
    /// Whether the penetrating contacts are few compared to the unknowns. A single sheet always
    /// qualifies, because a few contacts may carry all of it.
    pub(crate) fn is_dual_affordable(&self, island: &IslandView) -> bool {
        // Contacts of a compressed sheet are redundant, and W is singular.
        if self.detected.contacts.iter().any(|contact| contact.compressed.is_some()) {
            return false;
        }
        island.sheets.len() == 1
            || SETTINGS.minimum_rows_per_contact * self.gaps.free.iter().filter(|gap| **gap < 0.0).count()
                <= self.island_tangent.size()
    }

    /// Solve the positions. Returns whether the solver converged, or `None` if the working set
    /// grows too large.
    pub(crate) fn solve_positions_dual(&mut self, island: &mut IslandView, h: f64, rough: bool) -> Option<bool> {
        self.solve_positions_dual_up_to(
            island,
            h,
            rough,
            self.island_tangent.size() / SETTINGS.minimum_rows_per_contact,
        )
    }

    /// Solve the positions of a single sheet with a large working set, after the primal solver has
    /// failed.
    pub(crate) fn retry_positions_dual(&mut self, island: &mut IslandView, h: f64, rough: bool) -> bool {
        self.solve_positions_dual_up_to(island, h, rough, ALART_CURNIER.maximum_contacts).unwrap_or(false)
    }

    /// Solve the positions with a working set of at most `most` contacts. Returns whether the
    /// solver converged, or `None` if more are needed.
    fn solve_positions_dual_up_to(
        &mut self,
        island: &mut IslandView,
        h: f64,
        rough: bool,
        most: usize,
    ) -> Option<bool> {
        let (mut dual, mut lagrangian) =
            (std::mem::take(&mut self.dual), std::mem::take(&mut self.augmented_lagrangian));
        let factors = self.counters.factors;
        island.for_each_sheet(stage::restore_factor);
        dual.space.delassus.clear(island);
        lagrangian.clear();
        self.working_set.clear();
        dual.working_set.begin(self.detected.contacts.len());
        for i in (0..self.detected.first_attachment).filter(|i| self.is_duplicate(island, *i)) {
            dual.working_set.exclude(i);
        }
        dual.working_set.add_cached(self);
        let depth = SETTINGS.penetration * self.half_thickness;
        if dual.working_set.new.is_empty() {
            dual.working_set.add_violated(self, &self.gaps.free, depth, std::iter::empty());
        }
        if dual.working_set.new.is_empty() {
            dual.working_set.add_deepest(&self.gaps.free);
        }
        let mut settled = Some(true);
        for _ in 0..WORKING_SET.maximum_extensions {
            if self.working_set.len() + dual.working_set.new.len() > most {
                settled = None;
                break;
            }
            self.activate(&mut dual, &mut lagrangian, island, h);
            let accuracy = self.settings(rough, island.independent_parts());
            let done = dual.solve(&mut lagrangian, &mut self.counters, &accuracy);
            settled = Some(done);
            if !done && !self.policy.accepts_unconverged {
                break;
            }
            dual.space.delassus.problem.force.clone_from(&lagrangian.force);
            dual.space.delassus.displace(island, &self.detected.contacts, h);
            self.gaps.update(&self.detected.contacts, island);
            let active = self.working_set.iter().map(|i| *i as usize);
            dual.working_set.add_violated(self, &self.gaps.now, depth, active);
            if dual.working_set.new.is_empty() {
                break;
            }
        }
        if settled.is_some() {
            self.cache_position_forces(&lagrangian);
        }
        self.work += (self.counters.factors - factors) * (self.working_set.len() * self.working_set.len()) as u64
            / SETTINGS.work_divisor;
        (self.dual, self.augmented_lagrangian) = (dual, lagrangian);
        settled
    }

    /// Clear the solution of contacts that have ended.
    pub(crate) fn forget_solution(&mut self, island: &mut IslandView) {
        island.each_response(|_, response| response.remove_contacts());
        self.augmented_lagrangian.clear();
        self.working_set.clear();
        self.position_solver = PositionSolver::Dual;
    }

    /// Add the new contacts of the working set to the problem.
    fn activate(
        &mut self,
        dual: &mut DualSolver,
        lagrangian: &mut AugmentedLagrangian,
        island: &mut IslandView,
        h: f64,
    ) {
        lagrangian.mark_known();
        for i in dual.working_set.new.iter().map(|i| *i as usize) {
            let (mut row, force) = self.constraint_of(island, i, h);
            row.is_new = force == DVec3::ZERO;
            lagrangian.constraints.push(row);
            lagrangian.force.push(force);
            dual.space.delassus.problem.push(self.law(i), force);
        }
        dual.space.delassus.add(island, &self.detected.contacts, &dual.working_set.new, h);
        self.working_set.extend_from_slice(&dual.working_set.new);
        dual.working_set.activate();
    }

    /// Transfer the working set of a single sheet from the primal solver. Returns false if it is
    /// too large.
    pub(crate) fn transfer_to_dual(&mut self, island: &mut IslandView, h: f64) -> bool {
        if self.working_set.len() > ALART_CURNIER.maximum_contacts || island.sheets.len() > 1 {
            return false;
        }
        let mut dual = std::mem::take(&mut self.dual);
        island.for_each_sheet(stage::restore_factor);
        dual.space.delassus.clear_for_velocities(island);
        dual.working_set.begin(self.detected.contacts.len());
        dual.working_set.new.extend_from_slice(&self.working_set);
        for i in &self.working_set {
            dual.space.delassus.problem.push(self.law(*i as usize), DVec3::ZERO);
        }
        dual.space.delassus.add(island, &self.detected.contacts, &self.working_set, h);
        dual.working_set.activate();
        self.dual = dual;
        true
    }

    /// Solve the velocities of the closed contacts. Returns false if the solver did not converge.
    pub(crate) fn solve_velocities_dual(&mut self, island: &mut IslandView, h: f64) -> bool {
        if self.working_set.is_empty() {
            return true;
        }
        let (mut dual, mut lagrangian) =
            (std::mem::take(&mut self.dual), std::mem::take(&mut self.augmented_lagrangian));
        let mut begun = 0;
        let mut settled = true;
        for pass in 0..WORKING_SET.maximum_extensions {
            if pass > 0 {
                self.activate(&mut dual, &mut lagrangian, island, h);
            }
            for (k, i) in self.working_set.iter().map(|i| *i as usize).enumerate().skip(begun) {
                let row = &mut lagrangian.constraints[k];
                let u = self.relative_velocity(island, i, &row.frame);
                let known = self.cache.of_feature(&self.detected.contacts[i].key).unwrap_or_default();
                row.slipped = known.slipped[1];
                row.b = u.map_or(DVec3::X, |u| u * h);
                row.is_new = begun > 0;
                lagrangian.force[k] = if u.is_some() { row.frame.transpose() * known.velocity } else { DVec3::ZERO };
            }
            begun = self.working_set.len();
            let accuracy = self.settings(false, island.independent_parts());
            settled = dual.solve(&mut lagrangian, &mut self.counters, &accuracy);
            if !settled && !self.policy.accepts_unconverged {
                break;
            }
            dual.space.delassus.problem.force.clone_from(&lagrangian.force);
            dual.space.delassus.apply_velocity_jumps(island, &self.detected.contacts, h);
            self.compute_approaches(&mut dual, island, h);
            dual.working_set.add_violated(
                self,
                &dual.gap,
                SETTINGS.penetration * self.half_thickness,
                self.working_set.iter().map(|i| *i as usize),
            );
            if dual.working_set.new.is_empty() {
                break;
            }
        }
        self.cache_velocity_forces(&lagrangian);
        (self.dual, self.augmented_lagrangian) = (dual, lagrangian);
        settled
    }

    /// Compute the approach of closed contacts outside the working set in a stage of weight `h`
    /// (s).
    fn compute_approaches(&self, dual: &mut DualSolver, island: &IslandView, h: f64) {
        dual.gap.clear();
        for (i, contact) in self.detected.contacts.iter().enumerate() {
            let free = if dual.working_set.is_active(i) {
                None
            } else {
                self.relative_velocity(island, i, &frame_of(contact.normal))
            };
            dual.gap.push(free.map_or(f64::INFINITY, |free| {
                let jump = contact_velocity_jump(island, &contact.a) - contact_velocity_jump(island, &contact.b);
                (free.x + contact.normal.dot(jump)) * h
            }));
        }
    }
}
