//! Fallbacks of an implicit step: what replaces the stages of a substep whose solution is not
//! accepted. Islands with a moving led body go to the barrier method first.
//!
//! [`IslandSolve::apply_fallback`] is the one place that applies them. Speeds in m/s, lengths in m.

use crate::collision::constraint::ContactConstraint;
use crate::contact::IslandView;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::outer_iteration::{ContactMargins, DetectionMode};
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::SolverBody;
use crate::islands::energy_budget::{EnergyBudget, EnergyVerdict};
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::rigid_motion::is_free;
use crate::islands::settings::{FallbackSettings, StepSettings};
use crate::islands::unstable::is_unstable;
use crate::scene::sleep::SLEEP;
use crate::sheet::{Field, stage};

const CONTACT: ContactSettings = ContactSettings::DEFAULT;
const SETTINGS: FallbackSettings = StepSettings::DEFAULT.fallback;
const STEP: StepSettings = StepSettings::DEFAULT;

/// Replacement of the solution of a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fallback {
    /// Free sheets move rigidly with the bodies that they would penetrate (`rigid_motion`); others
    /// are frozen at the start of the substep, with bodies that would penetrate them.
    MoveOrFreeze,
    /// Free sheets move rigidly; the solution is kept where they cannot.
    MoveRigidly,
    /// The substep starts again: bodies move without contact with sheets, then `MoveOrFreeze`.
    Restart,
    /// `MoveOrFreeze` for some consecutive diverged steps. After them a slow island in contact
    /// sleeps, and a fast one is stopped for the rest of the step.
    FreezeThenStop,
    /// `FreezeThenStop`; the sheets of a stopped island are unstable.
    FreezeThenStopUnstable,
    /// The work budget is spent: bodies move without sheets, then `FreezeThenStopUnstable`.
    SkipContact,
    /// The island is stopped. This sheet, which started deep inside a body, is unstable.
    StopBuriedSheet(u32),
}

impl IslandSolve<'_, '_, '_> {
    /// Apply `fallback` to the substep `substep`.
    pub fn apply_fallback(&mut self, fallback: Fallback, substep: &Substep) {
        if !matches!(fallback, Fallback::StopBuriedSheet(_))
            && self.view.solver_bodies.iter().any(|body| !body.is_dynamic() && body.start.is_moving())
            && self.solve_with_barrier(substep, SETTINGS.barrier_bisections)
        {
            self.clear_failures();
            return self.record_fallback_impulses(substep);
        }
        match fallback {
            Fallback::MoveOrFreeze => self.move_or_freeze(substep),
            Fallback::MoveRigidly => {
                if !self.move_rigidly(substep) {
                    return;
                }
                self.record_fallback();
            }
            Fallback::Restart => {
                self.roll_back();
                self.advance_bodies_freely(substep);
                self.move_or_freeze(substep);
                self.clear_failures();
            }
            Fallback::FreezeThenStop => self.roll_back_diverged(substep),
            Fallback::FreezeThenStopUnstable => {
                self.roll_back_diverged(substep);
                self.mark_stopped_sheets();
            }
            Fallback::SkipContact => {
                self.advance_bodies_freely(substep);
                self.roll_back_diverged(substep);
                self.mark_stopped_sheets();
            }
            Fallback::StopBuriedSheet(sheet) => {
                self.progress.report.stopped = 1;
                self.view.for_each_sheet(stage::restore_state);
                self.view.sheet_mut(sheet).work.stage.has_diverged = true;
            }
        }
        self.record_fallback_impulses(substep);
    }

    /// Solve the substep by the barrier method, in shorter parts where a moving body does not
    /// arrive. Returns `false`, at the start of the substep, without a finite solution.
    fn solve_with_barrier(&mut self, substep: &Substep, depth: u32) -> bool {
        self.roll_back();
        let before = EnergyBudget::before(self.view, substep);
        self.view.for_each_sheet(|sheet| stage::begin_euler(sheet, substep.field, substep.dt));
        self.detection.begin_stage(self.view, substep.done, substep.done + substep.dt);
        let mut barrier = self.workspace.barrier.take().unwrap_or_default();
        let detection = &*self.detection;
        let friction = |island: &IslandView, pair| detection.friction(island, pair);
        let time = (substep.field, substep.dt);
        let attachments = detection.barrier_attachments(self.view);
        let report = barrier.solve(self.view, detection.barrier_colliders(), &attachments, &friction, time);
        self.view.for_each_sheet(|sheet| stage::finish_euler(sheet, substep.field, substep.dt));
        barrier.finish(self.view, &friction, substep.dt);
        self.workspace.barrier = Some(barrier);
        let fails = self.view.sheets.iter().any(is_unstable);
        if (fails || !report.arrived) && depth > 0 {
            self.roll_back();
            let half = Substep { dt: 0.5 * substep.dt, bisections: substep.bisections + 1, ..*substep };
            let first = self.solve_with_barrier(&half, depth - 1);
            let half = Substep { time: half.time + half.dt, done: half.done + half.dt, ..half };
            self.begin_substep(&half);
            return self.solve_with_barrier(&half, depth - 1) && first;
        }
        if !report.converged || !report.arrived {
            self.record_fallback();
        }
        if fails {
            self.roll_back();
            return false;
        }
        if let Some(before) = before {
            let flags = (true, true, is_free(self.view, self.workspace));
            let verdict = before.check_and_scale(self.view, &substep.field, flags, &mut self.progress.energy_error);
            if verdict != EnergyVerdict::Accept {
                self.view.for_each_sheet(|sheet| sheet.state.v.clear());
            }
        }
        true
    }

    /// Fraction of a substep after which a fast body with prescribed motion first meets a sheet,
    /// which has the velocity of the body from then on; `None` without one.
    pub fn first_impact(&mut self, substep: &Substep) -> Option<f64> {
        let size = self.view.sheets.iter().map(|sheet| sheet.model.initial_diagonal).fold(f64::INFINITY, f64::min);
        let fast = SETTINGS.impact_displacement * size / substep.dt;
        let is_fast = |body: &SolverBody| !body.is_dynamic() && body.start.velocity().length() > fast;
        if !self.view.solver_bodies.iter().any(is_fast) {
            return None;
        }
        let mut barrier = self.workspace.barrier.take().unwrap_or_default();
        let detection = &*self.detection;
        let friction = |island: &IslandView, pair| detection.friction(island, pair);
        let part = barrier.first_impact(self.view, detection.barrier_colliders(), &friction, substep.dt);
        self.workspace.barrier = Some(barrier);
        (part > SETTINGS.impact_fraction && part < 1.0 - SETTINGS.impact_fraction).then_some(part)
    }

    fn record_fallback(&mut self) {
        self.workspace.counters.given_up += 1;
        self.progress.report.fallbacks += 1;
    }

    fn clear_failures(&mut self) {
        self.view.for_each_sheet(|sheet| sheet.work.stage.has_failed = false);
    }

    /// Mark the sheets of a stopped island as unstable.
    fn mark_stopped_sheets(&mut self) {
        if self.progress.report.stopped > 0 {
            self.view.for_each_sheet(|sheet| sheet.work.stage.has_diverged = true);
        }
    }

    fn move_or_freeze(&mut self, substep: &Substep) {
        self.record_fallback();
        if !self.move_rigidly(substep) {
            self.freeze_sheets();
            self.hold_back_bodies(substep);
        }
    }

    fn roll_back_diverged(&mut self, substep: &Substep) {
        let progress = &mut *self.progress;
        progress.consecutive_rollbacks += u32::from(progress.report.rollbacks == 0);
        progress.report.rollbacks += 1;
        if progress.consecutive_rollbacks <= SETTINGS.maximum_rollbacks {
            self.move_or_freeze(substep);
            self.clear_failures();
            return;
        }
        self.roll_back();
        let slow = self.view.sheets.iter().all(|sheet| sheet.max_speed() < SETTINGS.sleep_speed);
        if slow && !self.workspace.detected.contacts.is_empty() {
            self.freeze_sheets();
            self.view
                .for_each_sheet(|sheet| (sheet.work.stage.has_failed, sheet.state.rest_time) = (false, SLEEP.delay));
        } else {
            self.progress.report.stopped = 1;
        }
    }

    /// Advance the bodies through a substep without contact with sheets.
    fn advance_bodies_freely(&mut self, substep: &Substep) {
        self.detection.begin_stage(self.view, substep.done, substep.done + substep.dt);
        self.detection.end_stage(self.view);
    }

    /// Freeze the sheets at the start of the substep; dynamic bodies keep their motion.
    fn freeze_sheets(&mut self) {
        self.view.for_each_sheet(|sheet| {
            stage::restore_state(sheet);
            sheet.state.v.axes_mut().into_iter().flatten().for_each(|v| *v *= STEP.velocity_retention);
            stage::restart_engine(sheet);
        });
    }

    /// Freeze dynamic bodies too where one of them would penetrate a frozen sheet. They keep their
    /// new velocities, or, where these have gained energy, a part of the old ones.
    fn hold_back_bodies(&mut self, substep: &Substep) {
        let (island, workspace) = (&mut *self.view, &mut *self.workspace);
        if !island.solver_bodies.iter().any(|body| body.is_dynamic()) {
            return;
        }
        workspace.swap_saved_bodies(&mut island.solver_bodies);
        if bodies_gain_energy(island, &workspace.saved_solver_bodies, &substep.field) {
            for (body, went) in island.solver_bodies.iter_mut().zip(&workspace.saved_solver_bodies) {
                let kept = STEP.velocity_retention;
                let (v, w) = (body.start.velocity() * kept, body.start.spin() * kept);
                body.start = if body.is_dynamic() { body.start.with_velocity(v, w) } else { went.start };
                body.begin(body.start);
            }
            return;
        }
        for (body, went) in island.solver_bodies.iter_mut().zip(&workspace.saved_solver_bodies) {
            if !body.is_dynamic() {
                body.start = went.start;
            }
            body.begin(went.start);
        }
        island.for_each_sheet(|sheet| sheet.work.stage.free_positions.clone_from(&sheet.state.x));
        let found = &mut workspace.rechecked;
        self.detection.detect_contacts(island, DetectionMode::FromStart, ContactMargins::resting(island), found);
        let DetectedContacts { contacts, colliders, .. } = &*found;
        let residual = CONTACT.residual_penetration * island.half_thickness();
        let penetrates = |c: &ContactConstraint| {
            gap(island, c, StagePose::Free) < gap(island, c, StagePose::Start).min(0.0) - residual
        };
        let clear = !contacts[..colliders.len()].iter().any(penetrates);
        for body in &mut island.solver_bodies {
            let end = body.free;
            body.start = if clear { end } else { body.start.with_velocity(end.velocity(), end.spin()) };
        }
    }
}

/// Whether the dynamic bodies that `went` on have more kinetic and potential energy than all bodies
/// and sheets had.
fn bodies_gain_energy(island: &IslandView, went: &[SolverBody], field: &Field) -> bool {
    let sheets = island.sheets.iter().map(|sheet| sheet.energy(field.gravity));
    // Frozen sheets have lost part of their speed: kinetic energy over the squared factor.
    let kept = STEP.velocity_retention;
    let mut had: f64 = sheets.map(|energy| energy.kinetic / (kept * kept) + energy.elastic).sum();
    let mut have = 0.0;
    for (body, went) in island.solver_bodies.iter().zip(went).filter(|(body, _)| body.is_dynamic()) {
        had += body.start.kinetic_energy() + body.start.gravity_energy(field.gravity);
        have += went.start.kinetic_energy() + went.start.gravity_energy(field.gravity);
        // Accuracy of contact, for nearly resting bodies.
        had += body.start.mass() * SETTINGS.lift * island.half_thickness() * field.gravity.length();
    }
    have > had || have.is_nan()
}
