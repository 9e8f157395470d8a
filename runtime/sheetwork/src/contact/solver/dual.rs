//! Dual contact solver of implicit integrators, with contact forces as unknowns, for small working
//! sets.
//!
//! The working set starts with the contacts that had a force and grows by contacts that the
//! solution violates, until none is left. All Newton iterations use one factorisation of each
//! sheet's tangent matrix. If the augmented Lagrangian method fails, the Alart-Curnier Newton
//! method is tried; then PGS, whose result starts the augmented Lagrangian method once more.

use glam::DVec3;

use crate::contact::gap::jumped;
use crate::contact::settings::{AlartCurnierSettings, ContactSettings, DualSettings, PgsSettings, WorkingSetSettings};
use crate::contact::solver::alart_curnier::AtOnce;
use crate::contact::solver::augmented_lagrangian::{Accuracy, OnForces, Primal};
use crate::contact::solver::delassus::{Group, frame_of};
use crate::contact::solver::primal::solve_counted;
use crate::contact::solver::working_set::Picker;
use crate::contact::stage::{ContactCounters, Scratch, Solved};

const SETTINGS: DualSettings = ContactSettings::DEFAULT.dual;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;
const ALART_CURNIER: AlartCurnierSettings = ContactSettings::DEFAULT.alart_curnier;
const WORKING_SET: WorkingSetSettings = ContactSettings::DEFAULT.working_set;

/// Dual solver and its arrays.
#[derive(Default)]
pub(crate) struct Few {
    space: OnForces,
    at_once: AtOnce,
    picker: Picker,
    /// Approach of the contacts outside the working set in the stage, m; negative if they close.
    gap: Vec<f64>,
    /// Initial forces, N.
    begun: Vec<DVec3>,
    /// Relative position or velocity without contact, of every contact in the problem.
    b: Vec<DVec3>,
}

impl Few {
    /// Solve the working set with three methods in turn. Returns false if none converges.
    fn solve(&mut self, primal: &mut Primal, counters: &mut ContactCounters, accuracy: &Accuracy) -> bool {
        self.begun.clone_from(&primal.force);
        if primal.rows.is_empty() || solve_counted(primal, &mut self.space, counters, accuracy) {
            return true;
        }
        if self.solve_at_once(primal, counters, accuracy) {
            return true;
        }
        self.b.clear();
        self.b.extend(primal.rows.iter().map(|row| row.b));
        let problem = &mut self.space.delassus.problem;
        problem.force.clone_from(&self.begun);
        let swept = problem.solve(&self.b, PGS.tolerance, PGS.maximum_sweeps);
        counters.sweeps += u64::from(swept.sweeps);
        self.begun.clone_from(&problem.force);
        primal.force.clone_from(&self.begun);
        if solve_counted(primal, &mut self.space, counters, accuracy) {
            return true;
        }
        primal.force.clone_from(&self.begun);
        swept.change <= PGS.tolerance
    }

    /// Solve by the Alart-Curnier Newton method from the initial forces.
    fn solve_at_once(&mut self, primal: &mut Primal, counters: &mut ContactCounters, accuracy: &Accuracy) -> bool {
        let before = self.at_once.steps;
        let settled = primal
            .adopt(&self.begun, |rows, state| self.at_once.solve(&self.space.delassus.problem, rows, accuracy, state));
        let steps = self.at_once.steps - before;
        counters.newton += steps;
        counters.factors += steps;
        counters.unsettled -= u64::from(settled);
        settled
    }
}

impl Scratch {
    /// Whether the penetrating contacts are few compared to the unknowns. A single sheet always
    /// qualifies, because a few contacts may carry all of it.
    pub(crate) fn are_few(&self, group: &Group) -> bool {
        group.members.len() == 1
            || SETTINGS.minimum_rows_per_contact * self.gaps.free.iter().filter(|gap| **gap < 0.0).count()
                <= self.joint.size()
    }

    /// Solve the positions. Returns whether the solver converged, or `None` if the working set
    /// grows too large.
    pub(crate) fn positions_on_few(&mut self, group: &mut Group, h: f64, rough: bool) -> Option<bool> {
        self.positions_on_most(group, h, rough, self.joint.size() / SETTINGS.minimum_rows_per_contact)
    }

    /// Solve the positions of a single sheet with a large working set, after the primal solver has
    /// failed.
    pub(crate) fn positions_on_forces_after_all(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        self.positions_on_most(group, h, rough, ALART_CURNIER.maximum_contacts).unwrap_or(false)
    }

    /// Solve the positions with a working set of at most `most` contacts. Returns whether the
    /// solver converged, or `None` if more are needed.
    fn positions_on_most(&mut self, group: &mut Group, h: f64, rough: bool, most: usize) -> Option<bool> {
        let (mut few, mut primal) = (std::mem::take(&mut self.few), std::mem::take(&mut self.primal));
        let factors = self.counters.factors;
        group.each(|sheet| sheet.restore_factor());
        few.space.delassus.clear(group);
        primal.clear();
        self.chosen.clear();
        few.picker.begin(self.found.contacts.len());
        for i in (0..self.found.glue_from).filter(|i| self.is_doubled(group, *i)) {
            few.picker.leave_out(i);
        }
        few.picker.pick_known(self);
        if few.picker.new.is_empty() {
            few.picker.pick_violated(self, &self.gaps.free, SETTINGS.penetration, std::iter::empty());
        }
        if few.picker.new.is_empty() {
            few.picker.pick_deepest(&self.gaps.free);
        }
        let mut settled = Some(true);
        for _ in 0..WORKING_SET.maximum_extensions {
            if self.chosen.len() + few.picker.new.len() > most {
                settled = None;
                break;
            }
            self.activate(&mut few, &mut primal, group, h);
            let accuracy = self.accuracy(rough, group.pieces());
            let done = few.solve(&mut primal, &mut self.counters, &accuracy);
            settled = Some(done);
            if !done && !self.last_resort {
                break;
            }
            few.space.delassus.problem.force.clone_from(&primal.force);
            few.space.delassus.displace(group, &self.found.contacts, h);
            self.gaps.update(&self.found.contacts, group);
            few.picker.pick_violated(
                self,
                &self.gaps.now,
                SETTINGS.penetration,
                self.chosen.iter().map(|i| *i as usize),
            );
            if few.picker.new.is_empty() {
                break;
            }
        }
        if settled.is_some() {
            self.remember_positions(&primal);
        }
        self.effort +=
            (self.counters.factors - factors) * (self.chosen.len() * self.chosen.len()) as u64 / SETTINGS.work_divisor;
        (self.few, self.primal) = (few, primal);
        settled
    }

    /// Clear the solution of contacts that no longer exist.
    pub(crate) fn forget_solution(&mut self, group: &mut Group) {
        group.each_unit(|_, unit| unit.release());
        self.primal.clear();
        self.chosen.clear();
        self.solved = Solved::OnForces;
    }

    /// Add the new contacts of the working set to the problem.
    fn activate(&mut self, few: &mut Few, primal: &mut Primal, group: &mut Group, h: f64) {
        primal.go_on();
        for i in few.picker.new.iter().map(|i| *i as usize) {
            let (mut row, force) = self.row_of(group, i, h);
            row.new = force == DVec3::ZERO;
            primal.rows.push(row);
            primal.force.push(force);
            few.space.delassus.problem.push(self.law(i), force);
        }
        few.space.delassus.add(group, &self.found.contacts, &few.picker.new, h);
        self.chosen.extend_from_slice(&few.picker.new);
        few.picker.activate();
    }

    /// Transfer the working set of a single sheet from the primal solver. Returns false if it is
    /// too large.
    pub(crate) fn take_to_forces(&mut self, group: &mut Group, h: f64) -> bool {
        if self.chosen.len() > ALART_CURNIER.maximum_contacts || group.members.len() > 1 {
            return false;
        }
        let mut few = std::mem::take(&mut self.few);
        group.each(|sheet| sheet.restore_factor());
        few.space.delassus.clear_for_velocities(group);
        few.picker.begin(self.found.contacts.len());
        few.picker.new.extend_from_slice(&self.chosen);
        for i in &self.chosen {
            few.space.delassus.problem.push(self.law(*i as usize), DVec3::ZERO);
        }
        few.space.delassus.add(group, &self.found.contacts, &self.chosen, h);
        few.picker.activate();
        self.few = few;
        true
    }

    /// Solve the velocities of the closed contacts. Returns false if the solver did not converge.
    pub(crate) fn velocities_on_forces(&mut self, group: &mut Group, h: f64) -> bool {
        if self.chosen.is_empty() {
            return true;
        }
        let (mut few, mut primal) = (std::mem::take(&mut self.few), std::mem::take(&mut self.primal));
        let mut begun = 0;
        let mut settled = true;
        for pass in 0..WORKING_SET.maximum_extensions {
            if pass > 0 {
                self.activate(&mut few, &mut primal, group, h);
            }
            for (k, i) in self.chosen.iter().map(|i| *i as usize).enumerate().skip(begun) {
                let row = &mut primal.rows[k];
                let u = self.velocity_of(group, i, &row.frame);
                let known = self.memory.near(&self.found.contacts[i].key).unwrap_or_default();
                row.slid = known.slides[1];
                row.b = u.map_or(DVec3::X, |u| u * h);
                row.new = begun > 0;
                primal.force[k] = if u.is_some() { row.frame.transpose() * known.velocity } else { DVec3::ZERO };
            }
            begun = self.chosen.len();
            let accuracy = self.accuracy(false, group.pieces());
            settled = few.solve(&mut primal, &mut self.counters, &accuracy);
            if !settled && !self.last_resort {
                break;
            }
            few.space.delassus.problem.force.clone_from(&primal.force);
            few.space.delassus.kick(group, &self.found.contacts, h);
            self.approaches(&mut few, group, h);
            few.picker.pick_violated(self, &few.gap, SETTINGS.penetration, self.chosen.iter().map(|i| *i as usize));
            if few.picker.new.is_empty() {
                break;
            }
        }
        self.remember_velocities(&primal);
        (self.few, self.primal) = (few, primal);
        settled
    }

    /// Compute the approach of closed contacts outside the working set in a stage of weight `h`
    /// (s).
    fn approaches(&self, few: &mut Few, group: &Group, h: f64) {
        few.gap.clear();
        for (i, contact) in self.found.contacts.iter().enumerate() {
            let free =
                if few.picker.is_active(i) { None } else { self.velocity_of(group, i, &frame_of(contact.normal)) };
            few.gap.push(free.map_or(f64::INFINITY, |free| {
                let jump = jumped(group, &contact.a) - jumped(group, &contact.b);
                (free.x + contact.normal.dot(jump)) * h
            }));
        }
    }
}
