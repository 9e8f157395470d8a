//! Outer iteration of a stage: free motion, detection, position solve, update of the iterate.
//!
//! The iteration ends when the strain after the update is the strain that the linear solve
//! predicted and no surface penetrates another. Detection searches for contacts of the free motion.
//! Three further detections cover the motion by contact forces:
//!
//! - with wider margins, when contact displaces something by more than the margin;
//! - at the displaced position, when a single sheet is displaced so far that wide margins would
//!   include every pair;
//! - from the start of the stage to the iterate, for sheets that passed through each other. These
//!   contacts stay in the problem for the following iterations.
//!
//! Lengths in m.

use glam::DVec3;

use crate::contact::convergence;
use crate::contact::detected::Found;
use crate::contact::settings::{ContactSettings, OuterIterationSettings};
use crate::contact::solver::delassus::Group;
use crate::contact::stage::Scratch;
use crate::sheet::Field;
use crate::sheet::stage::StageWork;

const SETTINGS: OuterIterationSettings = ContactSettings::DEFAULT.outer_iteration;

/// Positions and pairs that detection covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// Contacts of the free motion, seen from the start of the stage.
    First,
    /// Contacts of the free motion, seen from the iterate.
    Again,
    /// Contacts at the position displaced by contact in this iteration, seen from the start of the
    /// stage.
    Moved,
    /// Contacts of sheets with bodies at the iterate.
    Reached,
    /// Sheet-sheet contacts on the way from the start of the stage to the iterate.
    Crossed,
}

/// Search margins: pairs with a smaller gap after the free motion become contacts, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Margins {
    /// Margin between a sheet and a body, m.
    pub bodies: f64,
    /// Margin between two sheets and within one sheet, m.
    pub sheets: f64,
}

impl Margins {
    /// Default margins. Contact displaces a resting sheet by less in a stage at 60 Hz.
    pub const NARROW: Self = Self { bodies: 5e-4, sheets: 5e-4 };
    /// Margins for several sheets. Sheets in a pile are displaced together, so that their relative
    /// displacement is smaller.
    const PILED: Self = Self { bodies: 6e-4, sheets: 2e-4 };

    /// Initial margins for `sheets` sheets.
    pub fn of(sheets: usize) -> Self {
        if sheets > 1 { Self::PILED } else { Self::NARROW }
    }

    /// Widen the margins to cover the displacements `furthest`. Returns false if they already do.
    fn widen(&mut self, furthest: Self) -> bool {
        let is_enough = furthest.bodies <= self.bodies && furthest.sheets <= self.sheets;
        if !is_enough {
            self.bodies = self.bodies.max((1.5 * furthest.bodies).min(SETTINGS.maximum_margin));
            self.sheets = self.sheets.max((1.5 * furthest.sheets).min(SETTINGS.maximum_margin));
        }
        !is_enough
    }
}

/// Solve positions, and solve again with wider margins while contact displaces something into a
/// contact that was not detected. Returns whether anything touches, or `None` if a solve did not
/// converge.
fn solve_and_widen(
    group: &mut Group,
    scratch: &mut Scratch,
    h: f64,
    (look, rough): (Look, bool),
    mut find: impl FnMut(&Group, Look, Margins, &mut Found),
) -> Option<bool> {
    let mut touched = scratch.watched(|scratch| scratch.solve_positions(group, h, rough));
    let mut margins = Margins::of(group.members.len());
    for _ in 0..SETTINGS.maximum_widenings {
        if !touched || scratch.failed || !margins.widen(furthest(group)) {
            break;
        }
        let is_far = group.members.len() == 1 && margins.sheets > SETTINGS.displaced_search_distance;
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

/// Largest displacement by contact in the island, m: absolute, and relative to the mean
/// displacement of the sheets.
fn furthest(group: &Group) -> Margins {
    let units = || group.members.iter().map(|i| &group.contacts[*i as usize].unit);
    let touched = || units().filter(|unit| unit.is_touched()).map(|unit| &unit.jump.dx);
    let (sum, count) = touched().fold((DVec3::ZERO, 0), |(sum, n), dx| (sum + dx.iter().sum::<DVec3>(), n + dx.len()));
    // Sheets without contact have no displacement, and the mean is zero.
    let mean = if units().all(|unit| unit.is_touched()) { sum / count.max(1) as f64 } else { DVec3::ZERO };
    let most = |from: DVec3| {
        touched().flat_map(|dx| dx.iter()).map(|dx| (dx - from).length_squared()).fold(0.0, f64::max).sqrt()
    };
    let bodies = group.movers.iter().map(|m| m.shift.length()).fold(most(DVec3::ZERO), f64::max);
    Margins { bodies, sheets: most(mean) }
}

/// Run the outer iteration of one stage for all sheets of `group`. `h` is the weight of the stage
/// (s). `find` writes the contacts for a detection mode and margins, given the free motions stored
/// in the group.
pub(crate) fn solve_rounds(
    group: &mut Group,
    scratch: &mut Scratch,
    field: Field,
    h: f64,
    mut find: impl FnMut(&Group, Look, Margins, &mut Found),
) -> Rounds {
    let sheets = group.members.len();
    // A pair that touched in any iteration may touch again; ending without it would let it pass
    // through.
    let mut met = false;
    let mut before = f64::INFINITY;
    let mut look = Look::First;
    scratch.begin_rounds();
    for round in 0..SETTINGS.maximum_iterations_single + SETTINGS.additional_iterations {
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
        if met && !scratch.last && has_diverged(round, sheets, worst) {
            return Rounds::Hopeless;
        }
        let moved = met && convergence::has_moved(group);
        if moved && sheets > 1 {
            find(group, Look::Crossed, Margins::of(sheets), &mut scratch.seen);
            scratch.note_crossed(group);
        }
        look = if scratch.crossed { Look::First } else { Look::Again };
        let done = !rough && stages(group).all(|stage| stage.done);
        let mut apart = !scratch.crossed;
        if apart && done && moved {
            let overlap = scratch.overlap(group, |group, found| find(group, Look::Reached, Margins::NARROW, found));
            apart = overlap <= convergence::allowed(round, sheets, overlap > SETTINGS.stagnation_ratio * before);
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
        if round + 1 >= rounds + SETTINGS.additional_iterations {
            break;
        }
    }
    Rounds::Open
}

/// Whether the strain error `worst` after iteration `round` counts as divergence, as a multiple of
/// the tolerance.
fn has_diverged(round: u32, sheets: usize, worst: f64) -> bool {
    let early = sheets > 1 && round + 1 == SETTINGS.iterations_before_divergence;
    early && worst > SETTINGS.early_divergence_threshold
        || round >= SETTINGS.iterations_before_divergence && worst > SETTINGS.divergence_threshold
}

/// Maximum number of outer iterations; `met` says whether any contact has closed.
fn most(scratch: &Scratch, met: bool) -> u32 {
    match scratch.single || scratch.is_glue_alone() || !met {
        _ if scratch.is_spent() => 1,
        true => SETTINGS.maximum_iterations_single,
        false if scratch.last => SETTINGS.maximum_iterations_shortest_substep,
        false => SETTINGS.maximum_iterations_several,
    }
}

/// Compute the free motion of every sheet that has not converged. Returns false if a solve failed.
fn move_freely(group: &mut Group, field: Field) -> bool {
    group.each(|sheet| {
        if !sheet.work.stage.done && !sheet.free_motion(field) {
            sheet.work.stage.failed = true;
        }
    });
    stages(group).all(|stage| !stage.failed)
}

/// Move every sheet to its new iterate, with the contact displacement if `touched`; `firm` demands
/// fine convergence at attachments. Returns the largest strain error as a multiple of the
/// tolerance.
fn accept(group: &mut Group, field: Field, touched: bool, firm: bool) -> f64 {
    group.each_unit(|sheet, unit| {
        let contact = (touched && unit.is_touched()).then_some(&unit.jump.dx);
        sheet.accept(field, contact, firm);
    });
    stages(group).filter(|stage| !stage.done).map(|stage| stage.excess).fold(0.0, f64::max)
}

/// Stage data of all sheets of the island.
fn stages<'a>(group: &'a Group) -> impl Iterator<Item = &'a StageWork> {
    group.members.iter().map(|i| &group.sheets[*i as usize].work.stage)
}

/// Solve the contact of an island with explicit integrators, whose free motions are known, in a
/// step of `h` s; `find` writes the contacts. Returns false if nothing touches. Otherwise
/// displacements and velocity jumps are left in the contact arrays of the sheets and in the solver
/// bodies.
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

/// Result of the outer iteration of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounds {
    /// Converged without contact.
    Free,
    /// Converged with contact.
    Touched,
    /// Iteration limit without contact.
    Unsettled,
    /// Iteration limit with contact, or a failed solve.
    Failed,
    /// Diverged; a shorter step may converge.
    Hopeless,
    /// Cancelled: this sheet of the island started deep inside a body, which no step length
    /// resolves.
    Buried(u32),
    /// Iteration limit; an earlier iteration had contact, the last one had none.
    Open,
}
