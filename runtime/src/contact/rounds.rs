//! Rounds of a stage: free motion, detection, position solve, until what came of it is what was predicted and nothing has gone
//! through anything.
//!
//! Detection sees what the free motion would touch. What contact pushes into something else is looked for in a wider search, or, where
//! it pushes one sheet so far that everything would be near everything, where that has come to. What has crossed between two sheets on
//! the way from the start of the stage to where a round has come to is looked for after it, and its rows are kept for the rounds that
//! follow. Lengths in m.

use glam::DVec3;

use super::delassus::Group;
use super::found::Found;
use super::settled;
use super::stage::Scratch;
use crate::sheet::Field;
use crate::sheet::stage::StageWork;

/// Rounds of a stage, and how many more there may be to end with one that touches what others touched.
const ROUNDS: u32 = 10;
const LAST: u32 = 3;
/// The same for several sheets, of which one or another always has something to settle where much happens; and where there is no shorter
/// step to try: what has crossed by then would keep them all where they were.
const TOGETHER: u32 = 3;
const TOGETHER_AT_LAST: u32 = 8;
/// Rounds after which a stage whose strain is still mispredicted by this many times what is let pass is left to shorter steps.
const PATIENCE: u32 = 2;
const HOPELESS: f64 = 100.0;
/// The same for several sheets, whose rounds take long, after the second round.
const HOPELESS_SOON: f64 = 1e4;
/// How far pairs may be moved into one another that are looked for, m, at most, and how often it is tried with more.
const WIDEST: f64 = 0.1;
const WIDENINGS: u32 = 3;
/// Moved further than this, m, a sheet is looked at where it has come to: as what is held and led into a body is in every step.
const FAR: f64 = 5e-3;
/// A round that leaves more than this part of the overlap before it has not helped, and the next would not.
const HELPED: f64 = 0.8;

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// What touches after the free motion, as seen from the start of the stage.
    First,
    /// The same as seen from where the last round has come to.
    Again,
    /// What touches where contact moves things in this round, as seen from the start of the stage.
    Moved,
    /// What sheets overlap of bodies where the last round has come to.
    Reached,
    /// What of sheets has met on the way from the start of the stage to there.
    Crossed,
}

/// Pairs nearer than this after the free motion get a row, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Margins {
    /// A sheet and a body.
    pub bodies: f64,
    /// Two sheets, or one and itself.
    pub sheets: f64,
}

impl Margins {
    /// At rest contact moves nothing further in a stage at 60 Hz.
    pub const NARROW: Self = Self { bodies: 5e-4, sheets: 5e-4 };
    /// Sheets that lie on each other it moves all the same, nearly.
    const PILED: Self = Self { bodies: 6e-4, sheets: 2e-4 };

    /// What to begin with for `sheets` sheets.
    pub fn of(sheets: usize) -> Self {
        if sheets > 1 { Self::PILED } else { Self::NARROW }
    }

    /// Wide enough for what contact has moved by `furthest`; false when they were already.
    fn widen(&mut self, furthest: Self) -> bool {
        let is_enough = furthest.bodies <= self.bodies && furthest.sheets <= self.sheets;
        if !is_enough {
            self.bodies = self.bodies.max((1.5 * furthest.bodies).min(WIDEST));
            self.sheets = self.sheets.max((1.5 * furthest.sheets).min(WIDEST));
        }
        !is_enough
    }
}

/// Solves for positions, and again with what is found further away when contact has moved something into that. Whether anything
/// touches; `None` where a solve did not settle.
fn solve_and_widen(
    group: &mut Group,
    scratch: &mut Scratch,
    h: f64,
    (look, rough): (Look, bool),
    mut find: impl FnMut(&Group, Look, Margins, &mut Found),
) -> Option<bool> {
    let mut touched = scratch.watched(|scratch| scratch.solve_positions(group, h, rough));
    let mut margins = Margins::of(group.members.len());
    for _ in 0..WIDENINGS {
        if !touched || scratch.failed || !margins.widen(furthest(group)) {
            break;
        }
        let is_far = group.members.len() == 1 && margins.sheets > FAR;
        let overlaps = if is_far {
            find(group, Look::Moved, Margins::NARROW, &mut scratch.seen);
            scratch.seen.leave_out_opposed(group, &scratch.memory);
            scratch.take_up_more(group)
        } else {
            find(group, look, margins, &mut scratch.seen);
            scratch.seen.leave_out_opposed(group, &scratch.memory);
            scratch.take_up_wide(group)
        };
        if !overlaps {
            break;
        }
        scratch.take_up_crossed();
        touched = scratch.watched(|scratch| scratch.solve_positions(group, h, rough));
    }
    (!scratch.failed).then_some(touched)
}

/// How far contact moves anything of `group`, m: as seen from bodies, and from the mean motion of the sheets.
fn furthest(group: &Group) -> Margins {
    let units = || group.members.iter().map(|i| &group.sheets[*i as usize].work.unit);
    let touched = || units().filter(|unit| unit.is_touched()).map(|unit| &unit.jump.dx);
    let (sum, count) = touched().fold((DVec3::ZERO, 0), |(sum, n), dx| (sum + dx.iter().sum::<DVec3>(), n + dx.len()));
    // Sheets that nothing touches stay where they are.
    let mean = if units().all(|unit| unit.is_touched()) { sum / count.max(1) as f64 } else { DVec3::ZERO };
    let most = |from: DVec3| {
        touched().flat_map(|dx| dx.iter()).map(|dx| (dx - from).length_squared()).fold(0.0, f64::max).sqrt()
    };
    let bodies = group.movers.iter().map(|m| m.shift.length()).fold(most(DVec3::ZERO), f64::max);
    Margins { bodies, sheets: most(mean) }
}

/// Takes every sheet of `group` through its stage's rounds: `find` writes what may touch, given the group with the free motions in
/// it, what to look for and the distances up to which things are near.
pub(crate) fn solve_rounds(
    group: &mut Group,
    scratch: &mut Scratch,
    field: Field,
    h: f64,
    mut find: impl FnMut(&Group, Look, Margins, &mut Found),
) -> Rounds {
    let sheets = group.members.len();
    // What has touched in any round may be met again: without contact it would go through.
    let mut met = false;
    let mut before = f64::INFINITY;
    let mut look = Look::First;
    scratch.begin_rounds();
    for round in 0..ROUNDS + LAST {
        scratch.effort += group.masses() as u64;
        if !move_freely(group, field) {
            return Rounds::Failed;
        }
        find(group, look, Margins::of(sheets), &mut scratch.found);
        scratch.found.leave_out_opposed(group, &scratch.memory);
        if let Some(sheet) = scratch.buried(group).filter(|_| round == 0) {
            return Rounds::Buried(sheet);
        }
        scratch.take_up_crossed();
        let rough = round == 0 && scratch.is_impact(group);
        let Some(touched) = solve_and_widen(group, scratch, h, (look, rough), &mut find) else {
            return Rounds::Failed;
        };
        met |= touched;
        let firm = scratch.is_glue_alone() || scratch.single && group.pieces() == 1;
        let worst = accept(group, field, touched, firm);
        let soon = sheets > 1 && round + 1 == PATIENCE && worst > HOPELESS_SOON;
        if (soon || round >= PATIENCE && worst > HOPELESS) && met && !scratch.last {
            return Rounds::Hopeless;
        }
        let moved = met && settled::has_moved(group);
        if moved && sheets > 1 {
            find(group, Look::Crossed, Margins::of(sheets), &mut scratch.seen);
            scratch.note_crossed(group);
        }
        look = if scratch.crossed { Look::First } else { Look::Again };
        let done = !rough && stages(group).all(|stage| stage.done);
        let mut apart = !scratch.crossed;
        if apart && done && moved {
            let overlap = scratch.overlap(group, |group, found| find(group, Look::Reached, Margins::NARROW, found));
            apart = overlap <= settled::allowed(round, sheets, overlap > HELPED * before);
            before = overlap;
        }
        if done && apart {
            return if touched { Rounds::Touched } else { Rounds::Free };
        }
        if !apart {
            group.each(|sheet| sheet.work.stage.done = false);
        }
        let rounds = most(scratch, met);
        if round + 1 >= rounds && touched == met {
            return if met { Rounds::Failed } else { Rounds::Unsettled };
        }
        if round + 1 >= rounds + LAST {
            break;
        }
    }
    Rounds::Open
}

/// How many rounds there may be, whether or not anything has been `met`.
fn most(scratch: &Scratch, met: bool) -> u32 {
    match scratch.single || scratch.is_glue_alone() || !met {
        _ if scratch.is_spent() => 1,
        true => ROUNDS,
        false if scratch.last => TOGETHER_AT_LAST,
        false => TOGETHER,
    }
}

/// The free motion of every sheet that is not done; false when one has none.
fn move_freely(group: &mut Group, field: Field) -> bool {
    group.each(|sheet| {
        if !sheet.work.stage.done && !sheet.free_motion(field) {
            sheet.work.stage.failed = true;
        }
    });
    stages(group).all(|stage| !stage.failed)
}

/// Takes every sheet to where its round has come to, `firm` where what glue holds is to settle finely; returns how many times what is let pass
/// the strain of the worst is off.
fn accept(group: &mut Group, field: Field, touched: bool, firm: bool) -> f64 {
    group.each(|sheet| {
        let unit = std::mem::take(&mut sheet.work.unit);
        let contact = (touched && unit.is_touched()).then_some(&unit.jump.dx);
        sheet.accept(field, contact, firm);
        sheet.work.unit = unit;
    });
    stages(group).filter(|stage| !stage.done).map(|stage| stage.excess).fold(0.0, f64::max)
}

fn stages<'a>(group: &'a Group) -> impl Iterator<Item = &'a StageWork> {
    group.members.iter().map(|i| &group.sheets[*i as usize].work.stage)
}

/// Takes a group of explicit engines, whose free motions are known, through its contact in a step of `h` s: `find` writes what
/// may touch. False when nothing did; else displacements and jumps of velocity are left in the units and movers.
pub(crate) fn solve_masses(
    group: &mut Group,
    scratch: &mut Scratch,
    h: f64,
    find: impl FnOnce(&Group, &mut Found),
) -> bool {
    scratch.short_steps = true;
    find(group, &mut scratch.found);
    scratch.found.leave_out_opposed(group, &scratch.memory);
    let touched = scratch.watched(|scratch| scratch.solve_positions(group, h, false));
    if touched {
        scratch.watched(|scratch| scratch.solve_velocities(group, h));
    }
    touched
}

/// How the rounds of a stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounds {
    /// Settled, nothing touched.
    Free,
    /// Settled, with contact.
    Touched,
    /// Nothing touched, and not settled.
    Unsettled,
    /// Not settled, with contact.
    Failed,
    /// Given up: a shorter step will do better.
    Hopeless,
    /// Given up: this sheet of the group was put into a body, and no step will get it out.
    Buried(u32),
    /// Not settled, with contact in some round, but not in the last.
    Open,
}
