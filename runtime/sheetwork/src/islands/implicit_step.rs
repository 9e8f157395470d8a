//! One step of an island by an implicit integrator: sheets and bodies that may touch, stage by
//! stage.
//!
//!   lead the pins
//!     → for each stage: outer iterations of free motion, detection and position solve
//!     → velocity solve → finish
//!
//! A step whose outer iterations do not converge is rolled back and bisected, up to a maximum
//! depth.

use crate::collision::constraint::Contact;
use crate::contact::Group;
use crate::contact::detected::Found;
use crate::contact::gap::{At, gap};
use crate::contact::outer_iteration::{Look, Margins, Rounds, solve_rounds};
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::Mover;
use crate::contact::stage::Scratch;
use crate::islands::energy_budget::{Energies, Verdict, stay};
use crate::islands::is_unstable;
use crate::islands::rigid_motion::{go_on, is_loose, whole};
use crate::islands::settings::{BisectionSettings, FallbackSettings, StepSettings};
use crate::scene::sleep::SLEEP;
use crate::sheet::Field;

const CONTACT: ContactSettings = ContactSettings::DEFAULT;
const SETTINGS: BisectionSettings = StepSettings::DEFAULT.bisection;
const FALLBACK: FallbackSettings = StepSettings::DEFAULT.fallback;
const STEP: StepSettings = StepSettings::DEFAULT;

/// A substep.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub field: Field,
    /// Time at the start, s.
    pub time: f64,
    /// Time from the start of the whole step to the start of the substep, s.
    pub done: f64,
    /// Length, s.
    pub dt: f64,
    /// Number of bisections that lead from the step to the substep.
    pub halvings: u32,
}

/// Contact detection of an island.
pub(crate) trait Find {
    /// Move the bodies of `group` to the start of a stage from `from` to `to` (s after the start of
    /// the whole step), and set their motion without contact with sheets.
    fn begin_stage(&mut self, group: &mut Group, from: f64, to: f64);

    /// Write to `found` the contacts of `look` that are closer than `margins`, from the motions in
    /// the sheets of `group`.
    fn find(&mut self, group: &Group, look: Look, margins: Margins, found: &mut Found);

    /// Largest spin of the dynamic bodies with corners that may meet a sheet in this step, rad/s.
    fn spin(&self, group: &Group) -> f64;

    /// Set the bodies to their state at the end of the stage.
    fn end_stage(&mut self, group: &mut Group);
}

/// Advance an island by a substep.
pub(crate) fn advance(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: Part) {
    if part.halvings == 0 {
        // After an impact the next step begins one bisection above the deepest of this step.
        scratch.expected = if group.members.len() > 1 { scratch.deepest.saturating_sub(1) } else { 0 };
        scratch.deepest = 0;
        scratch.runaway = false;
        scratch.effort = 0;
        scratch.found.forget();
        group.each(|sheet| sheet.trace(|trace, _| trace.begin()));
        if !std::mem::take(&mut scratch.strayed) {
            scratch.strays = 0;
        }
        scratch.told = std::mem::take(&mut scratch.gave_up);
    } else if scratch.runaway {
        return;
    }
    // One stored state suffices: each half begins at the state to which its rollback returns.
    group.each(|sheet| {
        if !sheet.pins.is_empty() {
            sheet.pins.lead(part.time, part.dt, &sheet.x, &mut sheet.v);
        }
        sheet.begin_step(part.field, part.dt);
        sheet.keep();
    });
    scratch.keep(&group.movers);
    if part.halvings > 0 && scratch.is_spent() {
        sit_out(group, scratch, finder, &part);
        return;
    }
    if part.halvings >= scratch.expected {
        scratch.deepest = scratch.deepest.max(part.halvings);
        let met = scratch.met.len();
        let stands = attempt(group, scratch, finder, &part);
        let ends = part.halvings >= most_halvings(group.members.len(), scratch);
        // An island of several sheets accepts the state reached at the last bisection.
        if stands || ends && group.members.len() > 1 {
            group.each(|sheet| sheet.end_flow());
            return;
        }
        scratch.met.truncate(met);
        group.each(|sheet| sheet.put_back());
        scratch.put_back(&mut group.movers);
        if ends {
            end_early(group, scratch, finder, &part);
            return;
        }
        scratch.counters.halved += 1;
    }
    let half = Part { dt: 0.5 * part.dt, halvings: part.halvings + 1, ..part };
    advance(group, scratch, finder, half);
    advance(group, scratch, finder, Part { time: half.time + half.dt, done: half.done + half.dt, ..half });
}

/// Apply the fallback to a substep: free sheets move rigidly, other sheets are frozen.
fn give_up(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    scratch.note_given_up();
    if !go_on(group, scratch, finder, part) {
        stay(group);
        keep_out(group, scratch, finder, part);
    }
}

/// Freeze dynamic bodies too where their motion makes one of them penetrate a frozen sheet: they
/// moved as if the sheets had moved. The bodies keep their new velocities, or, where an unconverged
/// solve has given them energy, a reduced part of the old ones.
fn keep_out(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    if !group.movers.iter().any(|m| m.gives()) {
        return;
    }
    scratch.swap_kept(&mut group.movers);
    if gains(group, &scratch.kept_movers, &part.field) {
        for (mover, went) in group.movers.iter_mut().zip(&scratch.kept_movers) {
            let kept = STEP.velocity_retention;
            let (v, w) = (mover.start.velocity() * kept, mover.start.spin() * kept);
            mover.start = if mover.gives() { mover.start.with_velocity(v, w) } else { went.start };
            mover.begin(mover.start);
        }
        return;
    }
    for (mover, went) in group.movers.iter_mut().zip(&scratch.kept_movers) {
        if !mover.gives() {
            mover.start = went.start;
        }
        mover.begin(went.start);
    }
    group.each(|sheet| sheet.work.stage.free.clone_from(&sheet.x));
    finder.find(group, Look::First, Margins::NARROW, &mut scratch.seen);
    let Found { contacts, parts, .. } = &scratch.seen;
    let goes_in =
        |c: &Contact| gap(group, c, At::Free) < gap(group, c, At::Start).min(0.0) - CONTACT.residual_penetration;
    let clear = !contacts[..parts.len()].iter().any(goes_in);
    for mover in &mut group.movers {
        let end = mover.free;
        mover.start = if clear { end } else { mover.start.with_velocity(end.velocity(), end.spin()) };
    }
}

/// Whether the dynamic bodies that `went` on have more kinetic and potential energy than all bodies
/// and sheets had.
fn gains(group: &Group, went: &[Mover], field: &Field) -> bool {
    let sheets = group.members.iter().map(|i| group.sheets[*i as usize].energy(field.gravity));
    // Frozen sheets have lost part of their speed: kinetic energy over the squared factor.
    let kept = STEP.velocity_retention;
    let mut had: f64 = sheets.map(|energy| energy.kinetic / (kept * kept) + energy.elastic).sum();
    let mut have = 0.0;
    for (mover, went) in group.movers.iter().zip(went).filter(|(mover, _)| mover.gives()) {
        had += mover.start.kinetic_energy() + mover.start.gravity_energy(field.gravity);
        have += went.start.kinetic_energy() + went.start.gravity_energy(field.gravity);
        // Accuracy of contact, for nearly resting bodies.
        had += mover.start.mass() * FALLBACK.lift * field.gravity.length();
    }
    have > had || have.is_nan()
}

/// Apply the fallback to a diverged substep. After the maximum number of consecutive diverged
/// steps, put a slow island in contact to sleep and mark a fast one as unstable.
fn bring_back(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    scratch.strays += u32::from(!std::mem::replace(&mut scratch.strayed, true));
    if scratch.strays <= FALLBACK.maximum_rollbacks {
        give_up(group, scratch, finder, part);
        group.each(|sheet| sheet.work.stage.failed = false);
        return;
    }
    group.each(|sheet| sheet.put_back());
    scratch.put_back(&mut group.movers);
    let slow = group.members.iter().all(|i| group.sheets[*i as usize].max_speed() < FALLBACK.sleep_speed);
    if slow && !scratch.found.contacts.is_empty() {
        stay(group);
        group.each(|sheet| (sheet.work.stage.failed, sheet.quiet) = (false, SLEEP.delay));
    } else {
        scratch.runaway = true;
    }
}

/// Finish a substep whose further bisection is no longer allowed, because self-contact was found or
/// the work budget of the step is spent: take its stages once more, or apply the fallback.
fn end_early(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    if scratch.is_spent() || !attempt(group, scratch, finder, part) {
        group.each(|sheet| sheet.put_back());
        scratch.put_back(&mut group.movers);
        pass_by(group, finder, part);
        give_up(group, scratch, finder, part);
        group.each(|sheet| sheet.work.stage.failed = false);
    }
    group.each(|sheet| sheet.end_flow());
}

/// Advance the bodies of `group` through a substep without contact with sheets.
fn pass_by(group: &mut Group, finder: &mut dyn Find, part: &Part) {
    finder.begin_stage(group, part.done, part.done + part.dt);
    finder.end_stage(group);
}

/// Skip contact in a substep: bodies move without contact with sheets, and the fallback applies to
/// the sheets.
fn sit_out(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    pass_by(group, finder, part);
    bring_back(group, scratch, finder, part);
    if scratch.runaway {
        group.each(|sheet| sheet.work.stage.astray = true);
    }
    group.each(|sheet| sheet.end_flow());
}

/// Maximum number of bisections of a step for the island.
fn most_halvings(members: usize, scratch: &Scratch) -> u32 {
    match (members, scratch.single) {
        _ if scratch.is_spent() => 0,
        (1, true) => SETTINGS.maximum_depth_single,
        (1, false) => SETTINGS.maximum_depth_self_contact,
        _ => SETTINGS.maximum_depth_several,
    }
}

/// Solve the stages of a substep. Returns `false` when a stage did not converge and a shorter
/// substep is to be tried.
fn attempt(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) -> bool {
    let Some(first) = group.members.first() else { return true };
    scratch.failed = false;
    let last = part.halvings >= most_halvings(group.members.len(), scratch);
    scratch.last = last;
    scratch.last_resort = last || group.members.len() > 1;
    if !last && finder.spin(group) * part.dt > SETTINGS.maximum_rotation {
        return false;
    }
    let mut before = Energies::before(group, part);
    let (mut met, mut overlap, mut crossed, mut loose) = (false, 0.0_f64, false, true);
    let stages = group.sheets[*first as usize].stages();
    let mut at = part.done;
    for k in 0..stages {
        scratch.begin_stage(k);
        group.each(|sheet| {
            sheet.prepare_stage(part.field, k, part.dt);
            if sheet.is_glued()
                && let Some(own) = whole(sheet)
            {
                sheet.begin_turned(part.field, &own);
            }
        });
        let lead = &group.sheet(0).work.stage;
        let (length, h) = (lead.length, lead.h);
        finder.begin_stage(group, at, at + length);
        let rounds = solve_rounds(group, scratch, part.field, h, |group, look, margins, found| {
            finder.find(group, look, margins, found);
        });
        if let Some(before) = before.as_mut().filter(|_| k == 0) {
            before.lift_out(group, &part.field, (scratch.overlapped(group), scratch.found.parted(group)));
        }
        match rounds {
            Rounds::Hopeless => return false,
            Rounds::Buried(sheet) => {
                scratch.runaway = true;
                group.each(|sheet| sheet.put_back());
                group.sheets[group.members[sheet as usize] as usize].work.stage.astray = true;
                return true;
            }
            Rounds::Failed | Rounds::Open if !scratch.last_resort => return false,
            Rounds::Unsettled => group.each(|sheet| {
                if !sheet.work.stage.done {
                    sheet.solve_stage_alone(part.field);
                }
            }),
            _ => {}
        }
        // A lone sheet that was solved without contact differs from its outer iterations, and may
        // penetrate a body.
        let by_itself = rounds == Rounds::Unsettled && group.members.len() == 1;
        if by_itself || matches!(rounds, Rounds::Failed | Rounds::Open) {
            overlap = overlap
                .max(scratch.overlap(group, |group, found| finder.find(group, Look::Reached, Margins::NARROW, found)));
            if !last
                && overlap
                    > if by_itself { CONTACT.convergence.penetration_single } else { SETTINGS.penetration_several }
            {
                return false;
            }
        }
        crossed |= scratch.crossed;
        if crossed && !last {
            return false;
        }
        if group.members.iter().any(|i| group.sheets[*i as usize].work.stage.failed) {
            if last {
                bring_back(group, scratch, finder, part);
            }
            return last;
        }
        let touched = matches!(rounds, Rounds::Touched | Rounds::Failed);
        met |= touched;
        loose &= !touched || is_loose(group, scratch);
        if touched {
            group.each(|sheet| sheet.free_velocity(part.field));
            scratch.turn_back(group, h);
            scratch.watched(|scratch| scratch.solve_velocities(group, h));
            if scratch.failed {
                return false;
            }
            scratch.note_met();
        }
        group.each_unit(|sheet, unit| {
            let jump = (touched && unit.is_touched()).then_some(&unit.jump);
            sheet.finish_stage(part.field, k, part.dt, jump);
        });
        if group.members.len() == 1 && is_unstable(group.sheet(0)) {
            if last {
                bring_back(group, scratch, finder, part);
            }
            return last;
        }
        finder.end_stage(group);
        at += length;
        group.each(|sheet| sheet.trace(|trace, x| trace.ends.push((at, x.clone()))));
    }
    conclude(group, scratch, finder, part, (before, met, loose), (overlap, crossed))
}

/// Check a substep after its stages against the energies `before` it, and apply the fallback on
/// failure. Returns `false` when the substep is to be bisected.
fn conclude(
    group: &mut Group,
    scratch: &mut Scratch,
    finder: &mut dyn Find,
    part: &Part,
    (before, met, loose): (Option<Energies>, bool, bool),
    (overlap, crossed): (f64, bool),
) -> bool {
    let last = scratch.last;
    // After an impact the swinging part of a lone sheet moves along as large an arc as the struck
    // part: its energy is checked in free flight too.
    let judged = met || group.members.len() == 1;
    let judge = |before: Energies| before.judge(group, &part.field, (last, met, loose), &mut scratch.owed);
    let verdict = before.filter(|_| judged).map_or(Verdict::Stands, judge);
    let gives = group.movers.iter().any(|m| m.gives());
    let within = before.is_some() && overlap > FALLBACK.penetration && verdict == Verdict::Stands;
    if crossed || verdict == Verdict::Fails || within && !gives {
        give_up(group, scratch, finder, part);
    } else if within && loose && group.members.len() == 1 && go_on(group, scratch, finder, part) {
        scratch.note_given_up();
    }
    if verdict == Verdict::Runaway {
        bring_back(group, scratch, finder, part);
        if scratch.runaway {
            group.each(|sheet| sheet.work.stage.astray = true);
        }
    }
    verdict != Verdict::Again
}
