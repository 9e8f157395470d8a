//! One step of an island by an implicit integrator: sheets and bodies that may touch, stage by
//! stage.
//!
//!   lead the pins
//!     → for each stage: outer iterations of free motion, detection and position solve
//!     → velocity solve → finish
//!
//! A step whose outer iterations do not converge is rolled back and bisected, up to a maximum
//! depth.

use crate::collision::constraint::ContactConstraint;
use crate::contact::IslandView;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::outer_iteration::{ContactMargins, DetectionMode, StageSolve, solve_stage};
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::energy_budget::{EnergyBudget, EnergyVerdict, freeze_sheets};
use crate::islands::is_unstable;
use crate::islands::rigid_motion::{is_free, move_rigidly, rigid_equivalent};
use crate::islands::settings::{BisectionSettings, FallbackSettings, StepSettings};
use crate::scene::sleep::SLEEP;
use crate::sheet::Field;

const CONTACT: ContactSettings = ContactSettings::DEFAULT;
const SETTINGS: BisectionSettings = StepSettings::DEFAULT.bisection;
const FALLBACK: FallbackSettings = StepSettings::DEFAULT.fallback;
const STEP: StepSettings = StepSettings::DEFAULT;

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

/// Contact detection of an island.
pub(crate) trait ContactDetector {
    /// Move the bodies of `group` to the start of a stage from `from` to `to` (s after the start of
    /// the whole step), and set their motion without contact with sheets.
    fn begin_stage(&mut self, group: &mut IslandView, from: f64, to: f64);

    /// Write to `found` the contacts of `look` that are closer than `margins`, from the motions in
    /// the sheets of `group`.
    fn detect_contacts(
        &mut self,
        group: &IslandView,
        look: DetectionMode,
        margins: ContactMargins,
        found: &mut DetectedContacts,
    );

    /// Largest spin of the dynamic bodies with corners that may meet a sheet in this step, rad/s.
    fn max_body_spin(&self, group: &IslandView) -> f64;

    /// Set the bodies to their state at the end of the stage.
    fn end_stage(&mut self, group: &mut IslandView);
}

/// Advance an island by a substep.
pub(crate) fn advance(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: Substep,
) {
    if part.bisections == 0 {
        // After an impact the next step begins one bisection above the deepest of this step.
        scratch.initial_bisection_level =
            if group.sheets.len() > 1 { scratch.deepest_bisection_level.saturating_sub(1) } else { 0 };
        scratch.deepest_bisection_level = 0;
        scratch.is_diverged = false;
        scratch.work = 0;
        scratch.detected.clear();
        group.for_each_sheet(|sheet| sheet.update_trace(|trace, _| trace.begin()));
        if !std::mem::take(&mut scratch.was_rolled_back) {
            scratch.consecutive_rollbacks = 0;
        }
        scratch.used_fallback_before = std::mem::take(&mut scratch.used_fallback);
    } else if scratch.is_diverged {
        return;
    }
    // One stored state suffices: each half begins at the state to which its rollback returns.
    group.for_each_sheet(|sheet| {
        if !sheet.pins.is_empty() {
            sheet.pins.prescribe_velocities(part.time, part.dt, &sheet.x, &mut sheet.v);
        }
        sheet.begin_step(part.field, part.dt);
        sheet.save_state();
    });
    scratch.save_for_rollback(&group.solver_bodies);
    if part.bisections > 0 && scratch.is_work_budget_spent() {
        skip_contact(group, scratch, finder, &part);
        return;
    }
    if part.bisections >= scratch.initial_bisection_level {
        scratch.deepest_bisection_level = scratch.deepest_bisection_level.max(part.bisections);
        let met = scratch.closed_in_step.len();
        let stands = solve_stages(group, scratch, finder, &part);
        let ends = part.bisections >= max_bisections(group.sheets.len(), scratch);
        // An island of several sheets accepts the state reached at the last bisection.
        if stands || ends && group.sheets.len() > 1 {
            group.for_each_sheet(|sheet| sheet.end_inelastic_step());
            return;
        }
        scratch.closed_in_step.truncate(met);
        group.for_each_sheet(|sheet| sheet.restore_state());
        scratch.restore_saved(&mut group.solver_bodies);
        if ends {
            finish_without_bisection(group, scratch, finder, &part);
            return;
        }
        scratch.counters.halved += 1;
    }
    let half = Substep { dt: 0.5 * part.dt, bisections: part.bisections + 1, ..part };
    advance(group, scratch, finder, half);
    advance(group, scratch, finder, Substep { time: half.time + half.dt, done: half.done + half.dt, ..half });
}

/// Apply the fallback to a substep: free sheets move rigidly, other sheets are frozen.
fn apply_fallback(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) {
    scratch.record_fallback();
    if !move_rigidly(group, scratch, finder, part) {
        freeze_sheets(group);
        hold_back_bodies(group, scratch, finder, part);
    }
}

/// Freeze dynamic bodies too where their motion makes one of them penetrate a frozen sheet: they
/// moved as if the sheets had moved. The bodies keep their new velocities, or, where an unconverged
/// solve has given them energy, a reduced part of the old ones.
fn hold_back_bodies(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) {
    if !group.solver_bodies.iter().any(|m| m.is_dynamic()) {
        return;
    }
    scratch.swap_saved_bodies(&mut group.solver_bodies);
    if bodies_gain_energy(group, &scratch.saved_solver_bodies, &part.field) {
        for (mover, went) in group.solver_bodies.iter_mut().zip(&scratch.saved_solver_bodies) {
            let kept = STEP.velocity_retention;
            let (v, w) = (mover.start.velocity() * kept, mover.start.spin() * kept);
            mover.start = if mover.is_dynamic() { mover.start.with_velocity(v, w) } else { went.start };
            mover.begin(mover.start);
        }
        return;
    }
    for (mover, went) in group.solver_bodies.iter_mut().zip(&scratch.saved_solver_bodies) {
        if !mover.is_dynamic() {
            mover.start = went.start;
        }
        mover.begin(went.start);
    }
    group.for_each_sheet(|sheet| sheet.work.stage.free_positions.clone_from(&sheet.x));
    finder.detect_contacts(group, DetectionMode::FromStart, ContactMargins::DEFAULT, &mut scratch.rechecked);
    let DetectedContacts { contacts, colliders: parts, .. } = &scratch.rechecked;
    let goes_in = |c: &ContactConstraint| {
        gap(group, c, StagePose::Free) < gap(group, c, StagePose::Start).min(0.0) - CONTACT.residual_penetration
    };
    let clear = !contacts[..parts.len()].iter().any(goes_in);
    for mover in &mut group.solver_bodies {
        let end = mover.free;
        mover.start = if clear { end } else { mover.start.with_velocity(end.velocity(), end.spin()) };
    }
}

/// Whether the dynamic bodies that `went` on have more kinetic and potential energy than all bodies
/// and sheets had.
fn bodies_gain_energy(group: &IslandView, went: &[SolverBody], field: &Field) -> bool {
    let sheets = group.sheets.iter().map(|sheet| sheet.energy(field.gravity));
    // Frozen sheets have lost part of their speed: kinetic energy over the squared factor.
    let kept = STEP.velocity_retention;
    let mut had: f64 = sheets.map(|energy| energy.kinetic / (kept * kept) + energy.elastic).sum();
    let mut have = 0.0;
    for (mover, went) in group.solver_bodies.iter().zip(went).filter(|(mover, _)| mover.is_dynamic()) {
        had += mover.start.kinetic_energy() + mover.start.gravity_energy(field.gravity);
        have += went.start.kinetic_energy() + went.start.gravity_energy(field.gravity);
        // Accuracy of contact, for nearly resting bodies.
        had += mover.start.mass() * FALLBACK.lift * field.gravity.length();
    }
    have > had || have.is_nan()
}

/// Apply the fallback to a diverged substep. After the maximum number of consecutive diverged
/// steps, put a slow island in contact to sleep and mark a fast one as unstable.
fn roll_back_diverged(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) {
    scratch.consecutive_rollbacks += u32::from(!std::mem::replace(&mut scratch.was_rolled_back, true));
    if scratch.consecutive_rollbacks <= FALLBACK.maximum_rollbacks {
        apply_fallback(group, scratch, finder, part);
        group.for_each_sheet(|sheet| sheet.work.stage.has_failed = false);
        return;
    }
    group.for_each_sheet(|sheet| sheet.restore_state());
    scratch.restore_saved(&mut group.solver_bodies);
    let slow = group.sheets.iter().all(|sheet| sheet.max_speed() < FALLBACK.sleep_speed);
    if slow && !scratch.detected.contacts.is_empty() {
        freeze_sheets(group);
        group.for_each_sheet(|sheet| (sheet.work.stage.has_failed, sheet.rest_time) = (false, SLEEP.delay));
    } else {
        scratch.is_diverged = true;
    }
}

/// Finish a substep whose further bisection is not allowed, because self-contact was found or
/// the work budget of the step is spent: take its stages once more, or apply the fallback.
fn finish_without_bisection(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) {
    if scratch.is_work_budget_spent() || !solve_stages(group, scratch, finder, part) {
        group.for_each_sheet(|sheet| sheet.restore_state());
        scratch.restore_saved(&mut group.solver_bodies);
        advance_bodies_freely(group, finder, part);
        apply_fallback(group, scratch, finder, part);
        group.for_each_sheet(|sheet| sheet.work.stage.has_failed = false);
    }
    group.for_each_sheet(|sheet| sheet.end_inelastic_step());
}

/// Advance the bodies of `group` through a substep without contact with sheets.
fn advance_bodies_freely(group: &mut IslandView, finder: &mut dyn ContactDetector, part: &Substep) {
    finder.begin_stage(group, part.done, part.done + part.dt);
    finder.end_stage(group);
}

/// Skip contact in a substep: bodies move without contact with sheets, and the fallback applies to
/// the sheets.
fn skip_contact(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) {
    advance_bodies_freely(group, finder, part);
    roll_back_diverged(group, scratch, finder, part);
    if scratch.is_diverged {
        group.for_each_sheet(|sheet| sheet.work.stage.has_diverged = true);
    }
    group.for_each_sheet(|sheet| sheet.end_inelastic_step());
}

/// Maximum number of bisections of a step for the island.
fn max_bisections(members: usize, scratch: &ContactWorkspace) -> u32 {
    match (members, scratch.is_single_sheet) {
        _ if scratch.is_work_budget_spent() => 0,
        (1, true) => SETTINGS.maximum_depth_single,
        (1, false) => SETTINGS.maximum_depth_self_contact,
        _ => SETTINGS.maximum_depth_several,
    }
}

/// Solve the stages of a substep. Returns `false` when a stage did not converge and a shorter
/// substep is to be tried.
fn solve_stages(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
) -> bool {
    if group.sheets.is_empty() {
        return true;
    }
    scratch.solve_failed = false;
    let last = part.bisections >= max_bisections(group.sheets.len(), scratch);
    scratch.is_shortest_substep = last;
    scratch.accepts_unconverged = last || group.sheets.len() > 1;
    if !last && finder.max_body_spin(group) * part.dt > SETTINGS.maximum_rotation {
        return false;
    }
    let mut before = EnergyBudget::before(group, part);
    let (mut met, mut overlap, mut crossed, mut has_no_fixed_body) = (false, 0.0_f64, false, true);
    let stages = group.sheet_mut(0).stages();
    let mut at = part.done;
    for k in 0..stages {
        scratch.begin_stage(k);
        group.for_each_sheet(|sheet| {
            sheet.prepare_stage(part.field, k, part.dt);
            if sheet.has_dynamic_attachments()
                && let Some(own) = rigid_equivalent(sheet)
            {
                sheet.start_from_rotation(part.field, &own);
            }
        });
        let lead = &group.sheet(0).work.stage;
        let (length, h) = (lead.length, lead.h);
        finder.begin_stage(group, at, at + length);
        let rounds = solve_stage(group, scratch, part.field, h, |group, look, margins, found| {
            finder.detect_contacts(group, look, margins, found);
        });
        if let Some(before) = before.as_mut().filter(|_| k == 0) {
            before.add_depenetration_work(
                group,
                &part.field,
                (scratch.initial_penetration(group), scratch.detected.largest_body_penetration(group)),
            );
        }
        match rounds {
            StageSolve::Diverged => return false,
            StageSolve::InitialPenetration(sheet) => {
                scratch.is_diverged = true;
                group.for_each_sheet(|sheet| sheet.restore_state());
                group.sheet_mut(sheet).work.stage.has_diverged = true;
                return true;
            }
            StageSolve::IterationLimit | StageSolve::Separated if !scratch.accepts_unconverged => return false,
            StageSolve::IterationLimitWithoutContact => group.for_each_sheet(|sheet| {
                if !sheet.work.stage.is_finished {
                    sheet.solve_stage_alone(part.field);
                }
            }),
            _ => {}
        }
        // A lone sheet that was solved without contact differs from its outer iterations, and may
        // penetrate a body.
        let by_itself = rounds == StageSolve::IterationLimitWithoutContact && group.sheets.len() == 1;
        if by_itself || matches!(rounds, StageSolve::IterationLimit | StageSolve::Separated) {
            overlap = overlap.max(scratch.deepest_penetration(group, |group, found| {
                finder.detect_contacts(group, DetectionMode::BodyPenetration, ContactMargins::DEFAULT, found)
            }));
            if !last
                && overlap
                    > if by_itself { CONTACT.convergence.penetration_single } else { SETTINGS.penetration_several }
            {
                return false;
            }
        }
        crossed |= scratch.has_crossed;
        if crossed && !last {
            return false;
        }
        if group.sheets.iter().any(|sheet| sheet.work.stage.has_failed) {
            if last {
                roll_back_diverged(group, scratch, finder, part);
            }
            return last;
        }
        let touched = matches!(rounds, StageSolve::Converged | StageSolve::IterationLimit);
        met |= touched;
        has_no_fixed_body &= !touched || is_free(group, scratch);
        if touched {
            group.for_each_sheet(|sheet| sheet.compute_free_velocity(part.field));
            scratch.restore_spin(group, h);
            scratch.profile(|scratch| scratch.solve_velocities(group, h));
            if scratch.solve_failed {
                return false;
            }
            scratch.record_closed_contacts();
        }
        group.each_unit(|sheet, unit| {
            let jump = (touched && unit.is_touched()).then_some(&unit.jump);
            sheet.finish_stage(part.field, k, part.dt, jump);
        });
        if group.sheets.len() == 1 && is_unstable(group.sheet(0)) {
            if last {
                roll_back_diverged(group, scratch, finder, part);
            }
            return last;
        }
        finder.end_stage(group);
        at += length;
        group.for_each_sheet(|sheet| sheet.update_trace(|trace, x| trace.ends.push((at, x.clone()))));
    }
    check_energy_and_penetration(group, scratch, finder, part, (before, met, has_no_fixed_body), (overlap, crossed))
}

/// Check a substep after its stages against the energies `before` it, and apply the fallback on
/// failure. Returns `false` when the substep is to be bisected.
fn check_energy_and_penetration(
    group: &mut IslandView,
    scratch: &mut ContactWorkspace,
    finder: &mut dyn ContactDetector,
    part: &Substep,
    (before, met, has_no_fixed_body): (Option<EnergyBudget>, bool, bool),
    (overlap, crossed): (f64, bool),
) -> bool {
    let last = scratch.is_shortest_substep;
    // After an impact the swinging part of a lone sheet moves along as large an arc as the struck
    // part: its energy is checked in free flight too.
    let judged = met || group.sheets.len() == 1;
    let judge = |before: EnergyBudget| {
        before.check(group, &part.field, (last, met, has_no_fixed_body), &mut scratch.energy_error)
    };
    let verdict = before.filter(|_| judged).map_or(EnergyVerdict::Stands, judge);
    let gives = group.solver_bodies.iter().any(|m| m.is_dynamic());
    let within = before.is_some() && overlap > FALLBACK.penetration && verdict == EnergyVerdict::Stands;
    if crossed || verdict == EnergyVerdict::Fails || within && !gives {
        apply_fallback(group, scratch, finder, part);
    } else if within && has_no_fixed_body && group.sheets.len() == 1 && move_rigidly(group, scratch, finder, part) {
        scratch.record_fallback();
    }
    if verdict == EnergyVerdict::Runaway {
        roll_back_diverged(group, scratch, finder, part);
        if scratch.is_diverged {
            group.for_each_sheet(|sheet| sheet.work.stage.has_diverged = true);
        }
    }
    verdict != EnergyVerdict::Again
}
