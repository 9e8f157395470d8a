//! One step of an island by an implicit integrator: sheets and bodies that may touch, stage by
//! stage.
//!
//!   move kinematic nodes
//!     → for each stage: outer iterations of free motion, detection and position solve
//!     → velocity solve → finish
//!     → energy budget and penetration
//!
//! [`IslandSolve::solve_stages`] returns a [`StageOutcome`]: the solution stands, a shorter substep
//! is tried (rolled back and bisected, up to a maximum depth), or the fallback replaces it.

use crate::contact::IslandView;
use crate::contact::outer_iteration::{ContactMargins, DetectionMode, StageSolve, solve_stage};
use crate::contact::settings::ContactSettings;
use crate::contact::solve_policy::SolvePolicy;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::energy_budget::{EnergyBudget, EnergyVerdict};
use crate::islands::island_detection::IslandDetection;
use crate::islands::island_progress::IslandProgress;
use crate::islands::overlap_test::TestedState;
use crate::islands::rigid_motion::{is_free, rigid_equivalent};
use crate::islands::settings::{BisectionSettings, StepSettings};
use crate::islands::unstable::is_unstable;
use crate::sheet::{Field, Sheet, attachment, creep, node_contact, stage, stage_trace};

const CONTACT: ContactSettings = ContactSettings::DEFAULT;
const SETTINGS: BisectionSettings = StepSettings::DEFAULT.bisection;

/// A substep.
#[derive(Clone, Copy)]
pub(crate) struct Substep {
    pub field: Field,
    /// Time at the start, s.
    pub time: f64,
    /// Time from the start of the whole step to the start of the substep, s.
    pub done: f64,
    /// Length, s.
    pub dt: f64,
    /// Number of bisections that lead from the step to the substep.
    pub bisections: u32,
}

/// Outcome of the stages of a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageOutcome {
    /// The solution stands.
    Accepted,
    /// A stage did not converge, or the step gained energy: a shorter substep is tried.
    Bisect,
    /// The fallback replaces the solution.
    Fallback,
    /// The island is stopped: this sheet started deep inside a body.
    Stop(u32),
}

/// Contact in the stages of a substep so far.
#[derive(Clone, Copy, Debug)]
struct StageRecord {
    /// Whether any stage had contact.
    met: bool,
    /// Whether no stage had contact with a static or kinematic body.
    has_no_fixed_body: bool,
    /// Deepest penetration of a stage that did not converge, m.
    penetration: f64,
    /// Whether sheets passed through each other.
    crossed: bool,
}

/// An island in an implicit step.
pub(crate) struct IslandSolve<'a, 'v, 'd> {
    /// Sheets and bodies.
    pub view: &'a mut IslandView<'v>,
    /// Contact problem and solvers.
    pub workspace: &'a mut ContactWorkspace,
    /// Report of this step, and the memory of earlier steps.
    pub progress: &'a mut IslandProgress,
    /// Contact detection.
    pub detection: &'a mut IslandDetection<'d>,
}

impl IslandSolve<'_, '_, '_> {
    /// Advance the island by a substep.
    pub fn advance(&mut self, substep: Substep) {
        if substep.bisections == 0 {
            self.begin_step();
            if let Some(part) = self.first_impact(&substep) {
                let first = Substep { dt: part * substep.dt, bisections: 1, ..substep };
                self.advance(first);
                let dt = substep.dt - first.dt;
                return self.advance(Substep { time: first.time + first.dt, done: first.done + first.dt, dt, ..first });
            }
        } else if self.progress.report.stopped > 0 {
            return;
        }
        self.begin_substep(&substep);
        if substep.bisections > 0 && self.workspace.is_work_budget_spent() {
            self.apply_fallback(&substep);
            return self.end_substep();
        }
        if substep.bisections >= self.progress.initial_bisection_level(self.view.sheets.len()) {
            let deepest = &mut self.progress.report.deepest_bisection;
            *deepest = substep.bisections.max(*deepest);
            let closed = self.workspace.closed_in_step.len();
            let is_shortest = self.is_shortest(&substep);
            let outcome = self.solve_stages(&substep);
            match outcome {
                StageOutcome::Accepted => return self.end_substep(),
                StageOutcome::Fallback => {
                    self.apply_fallback(&substep);
                    return self.end_substep();
                }
                StageOutcome::Stop(sheet) => return self.stop_buried_sheet(sheet),
                // An island of several sheets accepts the state reached at the last bisection.
                StageOutcome::Bisect if is_shortest && self.view.sheets.len() > 1 => {
                    self.progress.report.unconverged += 1;
                    return self.end_substep();
                }
                StageOutcome::Bisect => {}
            }
            self.workspace.closed_in_step.truncate(closed);
            self.roll_back();
            if is_shortest {
                self.finish_without_bisection(&substep);
                return self.end_substep();
            }
            self.workspace.counters.halved += 1;
        }
        let half = Substep { dt: 0.5 * substep.dt, bisections: substep.bisections + 1, ..substep };
        self.advance(half);
        self.advance(Substep { time: half.time + half.dt, done: half.done + half.dt, ..half });
    }

    fn begin_step(&mut self) {
        self.progress.begin_step();
        self.workspace.begin_step();
        self.view.for_each_sheet(|sheet| stage_trace::update_trace(sheet, |trace, _| trace.begin()));
    }

    /// Prescribe velocities and save the state. One saved state suffices: each half begins at the
    /// state to which its rollback returns.
    pub fn begin_substep(&mut self, substep: &Substep) {
        self.view.for_each_sheet(|sheet| {
            if !sheet.pins.is_empty() {
                sheet.pins.prescribe_velocities(substep.time, substep.dt, &sheet.state.x, &mut sheet.state.v);
            }
            stage::begin_step(sheet, substep.field, substep.dt);
            stage::save_state(sheet);
        });
        self.workspace.save_for_rollback(&self.view.solver_bodies);
    }

    fn end_substep(&mut self) {
        self.view.for_each_sheet(creep::end_inelastic_step);
    }

    /// Return to the start of the substep.
    pub fn roll_back(&mut self) {
        self.view.for_each_sheet(stage::restore_state);
        self.workspace.restore_saved(&mut self.view.solver_bodies);
    }

    /// Finish a substep whose further bisection is not allowed, because self-contact was found or
    /// the work budget of the step is spent: solve its stages once more, or apply the fallback.
    fn finish_without_bisection(&mut self, substep: &Substep) {
        let is_affordable = !self.workspace.is_work_budget_spent();
        if !is_affordable || self.solve_stages(substep) != StageOutcome::Accepted {
            self.apply_fallback(substep);
        }
    }

    /// Whether the substep may not be bisected further.
    fn is_shortest(&self, substep: &Substep) -> bool {
        let most = match (self.view.sheets.len(), self.workspace.is_single_unfolded_sheet) {
            _ if self.workspace.is_work_budget_spent() => 0,
            (1, true) => SETTINGS.maximum_depth_single,
            (1, false) => SETTINGS.maximum_depth_self_contact,
            _ => SETTINGS.maximum_depth_several,
        };
        substep.bisections >= most
    }

    /// Solve the stages of a substep.
    fn solve_stages(&mut self, substep: &Substep) -> StageOutcome {
        if self.view.sheets.is_empty() {
            return StageOutcome::Accepted;
        }
        let is_shortest = self.is_shortest(substep);
        self.workspace.policy = SolvePolicy {
            is_explicit: false,
            is_shortest_substep: is_shortest,
            accepts_unconverged: is_shortest || self.view.sheets.len() > 1,
            is_unbisected_step: self.progress.report.deepest_bisection == 0,
        };
        if !is_shortest && self.detection.max_body_spin(self.view) * substep.dt > SETTINGS.maximum_rotation {
            return StageOutcome::Bisect;
        }
        let mut before = EnergyBudget::before(self.view, substep);
        let mut record = StageRecord { met: false, has_no_fixed_body: true, penetration: 0.0, crossed: false };
        let stages = stage::stages(self.view.sheet_mut(0));
        let mut at = substep.done;
        for k in 0..stages {
            let outcome = self.solve_stage(substep, k, &mut at, &mut before, &mut record);
            if outcome != StageOutcome::Accepted {
                return outcome;
            }
        }
        self.check_energy_and_penetration(substep, before, &record)
    }

    /// Solve stage `k` from the time `at` (s after the start of the whole step) on, and move `at`
    /// to its end.
    fn solve_stage(
        &mut self,
        substep: &Substep,
        k: usize,
        at: &mut f64,
        before: &mut Option<EnergyBudget>,
        record: &mut StageRecord,
    ) -> StageOutcome {
        let h = self.begin_stage(substep, k, *at);
        let length = self.view.sheet(0).work.stage.length;
        let detection = &mut *self.detection;
        let solved = solve_stage(self.view, self.workspace, substep.field, h, |island, mode, margins, found| {
            detection.detect_contacts(island, mode, margins, found);
        });
        if let Some(before) = before.as_mut().filter(|_| k == 0) {
            let initial = self.workspace.initial_penetration(self.view);
            let largest = self.workspace.detected.largest_body_penetration(self.view);
            before.add_depenetration_work(self.view, &substep.field, (initial, largest));
        }
        let outcome = self.accept_stage(substep, solved, record);
        if outcome != StageOutcome::Accepted {
            return outcome;
        }
        let touched = matches!(solved, StageSolve::Converged | StageSolve::Unconverged);
        record.met |= touched;
        record.has_no_fixed_body &= !touched || is_free(self.view, self.workspace);
        if touched && !self.solve_velocities(substep, h) {
            return StageOutcome::Bisect;
        }
        self.view.each_response(|sheet, response| {
            let jump = (touched && response.is_touched()).then_some(&response.jump);
            stage::finish_stage(sheet, substep.field, k, substep.dt, jump);
        });
        if touched {
            self.workspace.log_stage_impulses(self.view, h);
        }
        if self.view.sheets.len() == 1 && is_unstable(self.view.sheet(0)) {
            return self.bisect_or_fall_back();
        }
        self.detection.end_stage(self.view);
        *at += length;
        self.view
            .for_each_sheet(|sheet| stage_trace::update_trace(sheet, |trace, x| trace.ends.push((*at, x.clone()))));
        StageOutcome::Accepted
    }

    /// Begin stage `k` at the time `at` (s after the start of the whole step). Returns the weight
    /// of its acceleration, s.
    fn begin_stage(&mut self, substep: &Substep, k: usize, at: f64) -> f64 {
        self.workspace.begin_stage(k);
        self.view.for_each_sheet(|sheet| {
            stage::prepare_stage(sheet, substep.field, k, substep.dt);
            if attachment::has_dynamic_attachments(sheet)
                && let Some(own) = rigid_equivalent(sheet)
            {
                stage::start_from_rotation(sheet, substep.field, &own);
            }
        });
        let lead = &self.view.sheet(0).work.stage;
        let (length, h) = (lead.length, lead.h);
        self.detection.begin_stage(self.view, at, at + length);
        h
    }

    /// Judge the end of the outer iteration of a stage.
    fn accept_stage(&mut self, substep: &Substep, solved: StageSolve, record: &mut StageRecord) -> StageOutcome {
        let policy = self.workspace.policy;
        match solved {
            StageSolve::Diverged => return StageOutcome::Bisect,
            StageSolve::InitialPenetration(sheet) => return StageOutcome::Stop(sheet),
            StageSolve::Unconverged | StageSolve::Separated if !policy.accepts_unconverged => {
                return StageOutcome::Bisect;
            }
            StageSolve::UnconvergedWithoutContact => self.view.for_each_sheet(|sheet| {
                if !sheet.work.stage.is_finished {
                    stage::solve_stage_alone(sheet, substep.field);
                }
            }),
            _ => {}
        }
        // A lone sheet that was solved without contact differs from its outer iterations, and may
        // penetrate a body.
        let by_itself = solved == StageSolve::UnconvergedWithoutContact && self.view.sheets.len() == 1;
        if by_itself || matches!(solved, StageSolve::Unconverged | StageSolve::Separated) {
            let detection = &mut *self.detection;
            let deepest = self.workspace.deepest_penetration(self.view, |island, found| {
                let margins = ContactMargins::resting(island);
                detection.detect_contacts(island, DetectionMode::BodyPenetration, margins, found)
            });
            record.penetration = record.penetration.max(deepest);
            if !policy.is_shortest_substep && record.penetration > self.accepted_penetration() {
                return StageOutcome::Bisect;
            }
        }
        record.crossed |= self.workspace.has_crossed;
        if record.crossed && !policy.is_shortest_substep {
            return StageOutcome::Bisect;
        }
        if self.view.sheets.iter().any(|sheet| sheet.work.stage.has_failed) {
            return self.bisect_or_fall_back();
        }
        StageOutcome::Accepted
    }

    /// Accepted penetration of an unconverged stage, m.
    fn accepted_penetration(&self) -> f64 {
        CONTACT.convergence.penetration * self.view.half_thickness()
    }

    /// Bisection, or the fallback at the shortest substep.
    fn bisect_or_fall_back(&self) -> StageOutcome {
        if self.workspace.policy.is_shortest_substep { StageOutcome::Fallback } else { StageOutcome::Bisect }
    }

    /// Solve the velocities of the closed contacts of a stage of weight `h` (s). Returns whether
    /// the solution is accepted.
    fn solve_velocities(&mut self, substep: &Substep, h: f64) -> bool {
        let (island, workspace) = (&mut *self.view, &mut *self.workspace);
        island.for_each_sheet(|sheet| stage::compute_free_velocity(sheet, substep.field));
        workspace.restore_spin(island, h);
        let accepted = workspace.profile(|workspace| workspace.solve_velocities(island, h));
        if accepted {
            workspace.record_closed_contacts();
        }
        accepted
    }

    /// Check a substep after its stages against the energies `before` it, and its penetrations.
    fn check_energy_and_penetration(
        &mut self,
        substep: &Substep,
        before: Option<EnergyBudget>,
        record: &StageRecord,
    ) -> StageOutcome {
        let StageRecord { met, has_no_fixed_body, penetration, crossed } = *record;
        let is_single = self.view.sheets.len() == 1;
        // After an impact the swinging part of a lone sheet moves along as large an arc as the
        // struck part: its energy is checked in free flight too.
        let verdict = match &before {
            Some(before) if met || is_single => {
                let flags = (self.workspace.policy.is_shortest_substep, met, has_no_fixed_body);
                self.workspace.impulses.add_momenta(self.view, -1.0);
                let verdict = before.check_and_scale(self.view, &substep.field, flags, &mut self.progress.energy_error);
                self.workspace.impulses.add_momenta(self.view, 1.0);
                verdict
            }
            _ => EnergyVerdict::Accept,
        };
        let is_inside = before.is_some() && penetration > self.accepted_penetration();
        match verdict {
            EnergyVerdict::Bisect => StageOutcome::Bisect,
            EnergyVerdict::Fallback => StageOutcome::Fallback,
            EnergyVerdict::Accept if crossed || is_inside => StageOutcome::Fallback,
            EnergyVerdict::Accept => self.accept_without_overlap(),
        }
    }

    /// Accept a substep unless a sheet ends in something. Where one began in something already, the
    /// substep stands, and the check of the step reports it. Shorter substeps help where nodes have
    /// moved by more than the half thickness.
    fn accept_without_overlap(&mut self) -> StageOutcome {
        if !self.detection.finds_overlap(self.view, self.workspace, TestedState::End) {
            return StageOutcome::Accepted;
        }
        if self.detection.finds_overlap(self.view, self.workspace, TestedState::Start) {
            self.progress.starts_in_something = true;
            return StageOutcome::Accepted;
        }
        if self.view.sheets.iter().any(has_moved) { self.bisect_or_fall_back() } else { StageOutcome::Fallback }
    }
}

/// Whether a node has moved by more than the half thickness in the substep.
fn has_moved(sheet: &Sheet) -> bool {
    let half = node_contact::contact_offset(sheet);
    let before = stage::saved_positions(sheet).iter();
    sheet.state.x.iter().zip(before).any(|(x, before)| x.distance_squared(before) > half * half)
}
