//! One step of sheets and bodies that may touch, by an implicit engine: stage by stage together.
//!
//! lead the pins → for each stage: rounds of free motion, detection and position solve → velocity solve → finish
//!
//! A step whose rounds do not come together is taken back and halved, a few times over.

use crate::collision::constraint::Contact;
use crate::contact::Group;
use crate::contact::detected::Found;
use crate::contact::gap::{At, gap};
use crate::contact::outer_iteration::{Look, Margins, Rounds, solve_rounds};
use crate::contact::solver_body::Mover;
use crate::contact::stage::Scratch;
use crate::islands::energy_budget::{Energies, KEPT, Verdict, WITHIN, stay};
use crate::islands::rigid_motion::{go_on, is_loose, whole};
use crate::islands::{SLEEP_TIME, is_unstable};
use crate::sheet::Field;

/// How often a step may be halved. Found by trial on sheets thrown at edges at 20 m/s: with three the last part often did not settle
/// and went in by millimetres, with five or more seldom, in no more time over all. One that is folded on itself has no time for as
/// many. Several sheets settle over the next steps as well, and are halved only for what those cannot mend: energy that they
/// gain, strain from nowhere, and sheets that have gone through each other.
const HALVINGS: u32 = 6;
const HALVINGS_FOLDED: u32 = 4;
const HALVINGS_TOGETHER: u32 = 4;

/// Steps on end from which a sheet may be brought back that contact throws about beyond all measure: it may lie otherwise when what
/// it touches has moved on. One that by then is slower than this (m/s) sleeps there, held by contacts that contradict one another.
const STRAYS: u32 = 10;
const ALL_BUT_STILL: f64 = 1e-2;

/// Overlap that a body may add to that with a sheet which stays where it was, m: what contact leaves in any case.
const GONE_IN: f64 = 2e-5;

/// What contact may lift a body by in a part that is given up, m.
const LIFTS: f64 = 1e-6;

/// Overlap up to which a sheet may have come into a body where it was solved for as if there were none, m: what contact lets pass.
const UNSEEN: f64 = 6e-5;

/// Overlap with a body up to which several sheets go on from rounds that did not settle while a shorter step may do better, m.
const GONE_DEEP: f64 = 1e-4;

/// What a body with corners may turn in a part of a step near a sheet, rad. Contact is linear in how a body turns, and a needle that is struck
/// swings past the sheet in more: one in five went through, and of 216 needles and rods none since.
const TURNS: f64 = 0.2;

/// A part of a step.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub field: Field,
    /// Time at its start, s.
    pub time: f64,
    /// How much of the whole step was before it, s.
    pub done: f64,
    /// Its length, s.
    pub dt: f64,
    /// How often the step was halved to get it.
    pub halvings: u32,
}

/// Finds what may touch.
pub(crate) trait Find {
    /// Puts the bodies of `group` where they are at the start, and without sheets at the end, of a stage from `from` to `to`, s
    /// after the start of the whole step.
    fn begin_stage(&mut self, group: &mut Group, from: f64, to: f64);

    /// Writes what `look` says and comes nearer than `margins`, from the motions in the sheets of `group`.
    fn find(&mut self, group: &Group, look: Look, margins: Margins, found: &mut Found);

    /// How fast the fastest body with corners that gives way and may meet a sheet in this step turns, rad/s.
    fn spin(&self, group: &Group) -> f64;

    /// Takes up where the stage has left the bodies.
    fn end_stage(&mut self, group: &mut Group);
}

/// Steps a group.
pub(crate) fn advance(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: Part) {
    if part.halvings == 0 {
        // What is in the midst of a hard blow is so in the next step.
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
    // One state is enough to keep: a half begins where it would come back to.
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
        // Several sheets go on from where they have come to.
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

/// Gives a part of a step up: sheets that nothing holds go on as a stiff body, others stay where they were.
fn give_up(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    scratch.note_given_up();
    if !go_on(group, scratch, finder, part) {
        stay(group);
        keep_out(group, scratch, finder, part);
    }
}

/// Has bodies that give way stay where they were, too, where going on has taken one of them into a sheet that stays: they went as the
/// sheets would have let them had they moved. They keep the speeds they have come to; but where a solve that did not settle has given them
/// energy from nowhere they stay as the sheets do.
fn keep_out(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    if !group.movers.iter().any(|m| m.gives()) {
        return;
    }
    scratch.swap_kept(&mut group.movers);
    if gains(group, &scratch.kept_movers, &part.field) {
        for (mover, went) in group.movers.iter_mut().zip(&scratch.kept_movers) {
            let (v, w) = (mover.start.velocity() * KEPT, mover.start.spin() * KEPT);
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
    let goes_in = |c: &Contact| gap(group, c, At::Free) < gap(group, c, At::Start).min(0.0) - GONE_IN;
    let clear = !contacts[..parts.len()].iter().any(goes_in);
    for mover in &mut group.movers {
        let end = mover.free;
        mover.start = if clear { end } else { mover.start.with_velocity(end.velocity(), end.spin()) };
    }
}

/// Whether the bodies of `group` that `went` on have more energy than they, and the sheets, which now stay, could have given them.
fn gains(group: &Group, went: &[Mover], field: &Field) -> bool {
    let sheets = group.members.iter().map(|i| group.sheets[*i as usize].energy(field.gravity));
    // Sheets that stay have lost part of their speed.
    let mut had: f64 = sheets.map(|energy| energy.kinetic / (KEPT * KEPT) + energy.elastic).sum();
    let mut have = 0.0;
    for (mover, went) in group.movers.iter().zip(went).filter(|(mover, _)| mover.gives()) {
        had += mover.start.kinetic_energy() + mover.start.gravity_energy(field.gravity);
        have += went.start.kinetic_energy() + went.start.gravity_energy(field.gravity);
        // Of a body that is all but still: what contact is accurate to.
        had += mover.start.mass() * LIFTS * field.gravity.length();
    }
    have > had || have.is_nan()
}

/// Gives the part up in which a sheet was thrown about beyond all measure, unless it has been for too many steps on end.
fn bring_back(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    scratch.strays += u32::from(!std::mem::replace(&mut scratch.strayed, true));
    if scratch.strays <= STRAYS {
        give_up(group, scratch, finder, part);
        group.each(|sheet| sheet.work.stage.failed = false);
        return;
    }
    group.each(|sheet| sheet.put_back());
    scratch.put_back(&mut group.movers);
    let slow = group.members.iter().all(|i| group.sheets[*i as usize].max_speed() < ALL_BUT_STILL);
    if slow && !scratch.found.contacts.is_empty() {
        stay(group);
        group.each(|sheet| (sheet.work.stage.failed, sheet.quiet) = (false, SLEEP_TIME));
    } else {
        scratch.runaway = true;
    }
}

/// Ends a part of which a shorter one was to be tried when it was begun, and now is not: the sheet has turned out to be folded on itself, or
/// has taken all that a step may.
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

/// Takes the bodies of `group` through a part of a step as if there were no sheets.
fn pass_by(group: &mut Group, finder: &mut dyn Find, part: &Part) {
    finder.begin_stage(group, part.done, part.done + part.dt);
    finder.end_stage(group);
}

/// Does without contact in a part of a step: where the sheets stay, bodies go on as if there were none.
fn sit_out(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) {
    pass_by(group, finder, part);
    bring_back(group, scratch, finder, part);
    if scratch.runaway {
        group.each(|sheet| sheet.work.stage.astray = true);
    }
    group.each(|sheet| sheet.end_flow());
}

/// How often a step may be halved.
fn most_halvings(members: usize, scratch: &Scratch) -> u32 {
    match (members, scratch.single) {
        _ if scratch.is_spent() => 0,
        (1, true) => HALVINGS,
        (1, false) => HALVINGS_FOLDED,
        _ => HALVINGS_TOGETHER,
    }
}

/// Takes the stages of a part; false when one did not settle and there is something left to try.
fn attempt(group: &mut Group, scratch: &mut Scratch, finder: &mut dyn Find, part: &Part) -> bool {
    let Some(first) = group.members.first() else { return true };
    scratch.failed = false;
    let last = part.halvings >= most_halvings(group.members.len(), scratch);
    scratch.last = last;
    scratch.last_resort = last || group.members.len() > 1;
    if !last && finder.spin(group) * part.dt > TURNS {
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
        // A lone sheet that was solved for by itself has come to another place than its rounds, and may be in something there.
        let by_itself = rounds == Rounds::Unsettled && group.members.len() == 1;
        if by_itself || matches!(rounds, Rounds::Failed | Rounds::Open) {
            overlap = overlap
                .max(scratch.overlap(group, |group, found| finder.find(group, Look::Reached, Margins::NARROW, found)));
            if !last && overlap > if by_itself { UNSEEN } else { GONE_DEEP } {
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
        group.each(|sheet| {
            let unit = std::mem::take(&mut sheet.work.unit);
            let jump = (touched && unit.is_touched()).then_some(&unit.jump);
            sheet.finish_stage(part.field, k, part.dt, jump);
            sheet.work.unit = unit;
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

/// Judges a part whose stages have been taken, with the energies `before` it, and gives it up where it may not stand; false when it is to be
/// taken again.
fn conclude(
    group: &mut Group,
    scratch: &mut Scratch,
    finder: &mut dyn Find,
    part: &Part,
    (before, met, loose): (Option<Energies>, bool, bool),
    (overlap, crossed): (f64, bool),
) -> bool {
    let last = scratch.last;
    // What swings after a blow goes around as large an arc as what is struck: a lone sheet is judged in free flight too.
    let judged = met || group.members.len() == 1;
    let judge = |before: Energies| before.judge(group, &part.field, (last, met, loose), &mut scratch.owed);
    let verdict = before.filter(|_| judged).map_or(Verdict::Stands, judge);
    let gives = group.movers.iter().any(|m| m.gives());
    let within = before.is_some() && overlap > WITHIN && verdict == Verdict::Stands;
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
