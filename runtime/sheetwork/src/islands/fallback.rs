//! Fallback of an implicit step: the barrier method, which replaces the stages of a substep whose
//! solution is not accepted, and the checks that decide on it.
//!
//! [`IslandSolve::apply_fallback`] is the one place that applies it. Speeds in m/s, lengths in m.

use crate::contact::IslandView;
use crate::contact::solver_body::SolverBody;
use crate::islands::energy_budget::{EnergyBudget, EnergyVerdict};
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::rigid_motion::is_free;
use crate::islands::settings::{FallbackSettings, StepSettings};
use crate::islands::unstable::is_unstable;
use crate::sheet::stage;

const SETTINGS: FallbackSettings = StepSettings::DEFAULT.fallback;

/// Replacement of the solution of a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fallback {
    /// The barrier method solves the substep ([`crate::contact::barrier`]). Where even that has no
    /// finite solution, the sheets return to the start and are unstable.
    Barrier,
    /// The sheets return to the start of the substep and the island is stopped. This sheet of it,
    /// which started deep inside a body, is unstable.
    StopBuriedSheet(u32),
}

impl IslandSolve<'_, '_, '_> {
    /// Apply `fallback` to the substep `substep`.
    pub fn apply_fallback(&mut self, fallback: Fallback, substep: &Substep) {
        match fallback {
            Fallback::Barrier => {
                if self.solve_with_barrier(substep, SETTINGS.barrier_bisections) {
                    self.workspace.counters.given_up += 1;
                    self.progress.report.fallbacks += 1;
                    self.view.for_each_sheet(|sheet| sheet.work.stage.has_failed = false);
                } else {
                    self.progress.report.stopped = 1;
                    self.view.for_each_sheet(|sheet| sheet.work.stage.has_diverged = true);
                }
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

    /// Whether the substep goes to the barrier method at once: a led body moves among the sheets.
    /// The contact solver may leave nodes behind the faces of such a body.
    pub fn is_led(&self) -> bool {
        self.view.solver_bodies.iter().any(|body| !body.is_dynamic() && body.start.is_moving())
    }

    /// Fraction of a substep after which a fast body with prescribed motion first meets a sheet;
    /// `None` without one. The substep is split there: a sheet has the velocity of the body that
    /// struck it only from then on.
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

    /// Whether features passed through each other in the substep.
    pub fn passes_through(&mut self) -> bool {
        let mut barrier = self.workspace.barrier.take().unwrap_or_default();
        let detection = &*self.detection;
        let friction = |island: &IslandView, pair| detection.friction(island, pair);
        let saved = &self.workspace.saved_solver_bodies;
        let attachments = detection.barrier_attachments(self.view);
        let found = barrier.passes_through(self.view, detection.barrier_colliders(), &attachments, &friction, saved);
        self.workspace.barrier = Some(barrier);
        found
    }
}
