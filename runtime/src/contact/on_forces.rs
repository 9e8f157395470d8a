//! Contact problems of implicit engines put to the solver (`primal`) on the forces of contacts, where those are few.
//!
//! It begins with the contacts that had a force and goes on with those that the others leave violated, until there are none. All
//! Newton steps are taken with one factor of each sheet's tangent. What does not settle there is tried by `at_once`.

use glam::DVec3;

use super::at_once::{self, AtOnce};
use super::delassus::{Group, frame_of};
use super::on_masses::solve_counted;
use super::pick::Picker;
use super::places::jumped;
use super::primal::{Accuracy, OnForces, Primal};
use super::stage::{ContactCounters, Scratch, Solved};

/// Block rows for each contact, from which on it is for `on_masses`: W is dense in the contacts of a sheet.
const FEW: usize = 7;
/// A factor takes as much of a step's effort as the square of the contacts by this.
const SQUARE: u64 = 16;
/// Violations up to this are let pass, m.
const DEPTH: f64 = 1e-6;
/// Times that more contacts join.
const PASSES: u32 = 40;

/// Accuracy of sweeps, m, and how many there may be.
const ACCURACY: f64 = 1e-8;
const SWEEPS: u32 = 200;

/// What it takes.
#[derive(Default)]
pub(super) struct Few {
    space: OnForces,
    at_once: AtOnce,
    picker: Picker,
    /// By how much contacts are apart, or come together in the stage, m.
    gap: Vec<f64>,
    begun: Vec<DVec3>,
    b: Vec<DVec3>,
}

impl Few {
    /// Solves, if need be from where sweeps over the contacts come to.
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
        let swept = problem.solve(&self.b, ACCURACY, SWEEPS);
        counters.sweeps += u64::from(swept.sweeps);
        self.begun.clone_from(&problem.force);
        primal.force.clone_from(&self.begun);
        if solve_counted(primal, &mut self.space, counters, accuracy) {
            return true;
        }
        primal.force.clone_from(&self.begun);
        swept.change <= ACCURACY
    }

    /// Tries all at once, from the forces it began with.
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
    /// Whether those that would overlap between several sheets are few; of one sheet a few hold up many.
    pub(super) fn are_few(&self, group: &Group) -> bool {
        group.members.len() == 1 || FEW * self.gaps.free.iter().filter(|gap| **gap < 0.0).count() <= self.joint.size()
    }

    /// Solves for the places of what would overlap: whether the solve settled, or `None` where contacts are not few.
    pub(super) fn positions_on_few(&mut self, group: &mut Group, h: f64, rough: bool) -> Option<bool> {
        self.positions_on_most(group, h, rough, self.joint.size() / FEW)
    }

    /// The same for one sheet whose contacts are no longer few, and did not settle on the masses.
    pub(super) fn positions_on_forces_after_all(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        self.positions_on_most(group, h, rough, at_once::MOST).unwrap_or(false)
    }

    /// Solves for the places of `most` contacts at most: whether the solve settled, or `None` where there are more.
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
            few.picker.pick_violated(self, &self.gaps.free, DEPTH, std::iter::empty());
        }
        if few.picker.new.is_empty() {
            few.picker.pick_deepest(&self.gaps.free);
        }
        let mut settled = Some(true);
        for _ in 0..PASSES {
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
            few.picker.pick_violated(self, &self.gaps.now, DEPTH, self.chosen.iter().map(|i| *i as usize));
            if few.picker.new.is_empty() {
                break;
            }
        }
        if settled.is_some() {
            self.remember_positions(&primal);
        }
        self.effort += (self.counters.factors - factors) * (self.chosen.len() * self.chosen.len()) as u64 / SQUARE;
        (self.few, self.primal) = (few, primal);
        settled
    }

    /// Forgets what was solved for: it was of contacts that are no more.
    pub(super) fn forget_solution(&mut self, group: &mut Group) {
        group.each(|sheet| sheet.work.unit.release());
        self.primal.clear();
        self.chosen.clear();
        self.solved = Solved::OnForces;
    }

    /// Makes what is picked part of the problem.
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

    /// Puts to the solver on forces the contacts of one sheet that were solved for on the masses; false where they are too many.
    pub(super) fn take_to_forces(&mut self, group: &mut Group, h: f64) -> bool {
        if self.chosen.len() > at_once::MOST || group.members.len() > 1 {
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

    /// Solves for the velocities of what is closed; false where the solve did not settle.
    pub(super) fn velocities_on_forces(&mut self, group: &mut Group, h: f64) -> bool {
        if self.chosen.is_empty() {
            return true;
        }
        let (mut few, mut primal) = (std::mem::take(&mut self.few), std::mem::take(&mut self.primal));
        let mut begun = 0;
        let mut settled = true;
        for pass in 0..PASSES {
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
            few.picker.pick_violated(self, &few.gap, DEPTH, self.chosen.iter().map(|i| *i as usize));
            if few.picker.new.is_empty() {
                break;
            }
        }
        self.remember_velocities(&primal);
        (self.few, self.primal) = (few, primal);
        settled
    }

    /// By how much what is closed and not in the problem comes together in a stage of weight `h`.
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
