//! The fallback of an implicit step: the barrier method replaces the stages of a substep whose
//! solution is not accepted.
//!
//! [`IslandSolve::apply_fallback`] is the one place that applies it. Speeds in m/s, lengths in m.

use crate::contact::IslandView;
use crate::contact::settings::{BarrierSettings, ContactSettings};
use crate::contact::solver_body::SolverBody;
use crate::islands::energy_budget::{EnergyBudget, EnergyVerdict};
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::rigid_motion::{is_free, momentum_of_island, restore_momentum};
use crate::islands::settings::{FallbackSettings, StepSettings};
use crate::islands::unstable::is_unstable;
use crate::sheet::{stage, stage_trace};

const BARRIER: BarrierSettings = ContactSettings::DEFAULT.barrier;
const SETTINGS: FallbackSettings = StepSettings::DEFAULT.fallback;

impl IslandSolve<'_, '_, '_> {
    /// Replace the solution of `substep` by that of the barrier method; without a finite one the
    /// island is stopped.
    pub fn apply_fallback(&mut self, substep: &Substep) {
        if self.solve_with_barrier(substep, SETTINGS.barrier_bisections) {
            self.view.for_each_sheet(|sheet| sheet.work.stage.has_failed = false);
        } else {
            self.progress.report.stopped = 1;
            self.view.for_each_sheet(|sheet| sheet.work.stage.has_diverged = true);
        }
        self.record_fallback_impulses(substep);
    }

    /// Stop the island: this sheet started deep inside a body, which no step resolves.
    pub fn stop_buried_sheet(&mut self, sheet: u32) {
        self.progress.report.stopped = 1;
        self.view.for_each_sheet(stage::restore_state);
        self.view.sheet_mut(sheet).work.stage.has_diverged = true;
    }

    /// Solve the substep by the barrier method, in shorter parts where a moving body does not
    /// arrive. Returns `false`, at the start of the substep, without a finite solution.
    fn solve_with_barrier(&mut self, substep: &Substep, depth: u32) -> bool {
        self.roll_back();
        let (most, depth) = match self.workspace.is_barrier_budget_spent() {
            true => (BARRIER.iterations_beyond_budget, 0),
            false => (BARRIER.maximum_iterations, depth),
        };
        let before = EnergyBudget::before(self.view, substep);
        let momentum = momentum_of_island(self.view, substep.field);
        self.view.for_each_sheet(|sheet| stage::begin_euler(sheet, substep.field, substep.dt));
        self.detection.begin_stage(self.view, substep.done, substep.done + substep.dt);
        let mut barrier = self.workspace.barrier.take().unwrap_or_default();
        let detection = &*self.detection;
        let friction = |island: &IslandView, pair| detection.friction(island, pair);
        let time = (substep.field, substep.dt);
        let attachments = detection.barrier_attachments(self.view);
        let report = barrier.solve(self.view, detection.barrier_colliders(), &attachments, &friction, time, most);
        self.workspace.work += report.work;
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
        self.progress.report.barrier += 1;
        if !report.converged || !report.arrived {
            self.workspace.counters.given_up += 1;
            self.progress.report.fallbacks += 1;
        }
        if let Some(momentum) = momentum.filter(|_| is_free(self.view, self.workspace)) {
            restore_momentum(self.view, &momentum, (substep.field, substep.dt), f64::INFINITY);
        }
        let end = substep.done + substep.dt;
        self.view
            .for_each_sheet(|sheet| stage_trace::update_trace(sheet, |trace, x| trace.ends.push((end, x.clone()))));
        if let Some(before) = before {
            let flags = (true, true, is_free(self.view, self.workspace));
            let verdict = before.check_and_scale(self.view, &substep.field, flags, &mut self.progress.energy_error);
            if verdict != EnergyVerdict::Accept {
                before.remove_gain(self.view, &substep.field);
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
}
