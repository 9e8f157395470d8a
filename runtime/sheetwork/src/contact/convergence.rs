//! Convergence test of the outer iteration: penetration at the iterate.
//!
//! The strain test compares the strain of an iteration with the prediction of its linear solve.
//! Contact constraints are linear too: where a triangle turns under a needle's tip, or the nearest
//! point moves to another triangle, they may be satisfied while the surfaces overlap. The
//! penetration is therefore measured once more at the iterate, unless the stage hardly moved any
//! node. Lengths in m.

use glam::DVec3;

use crate::collision::constraint::{Contact, Side};
use crate::contact::settings::{ContactSettings, ConvergenceSettings};
use crate::contact::solver::delassus::Group;

const SETTINGS: ConvergenceSettings = ContactSettings::DEFAULT.convergence;

/// Penetration tolerance (m) after iteration `round` with `sheets` sheets; `stalled` says whether
/// the iteration has stagnated.
pub(crate) fn allowed(round: u32, sheets: usize, stalled: bool) -> f64 {
    if sheets > 1 {
        SETTINGS.penetration_several
    } else if round < SETTINGS.fine_iterations && !stalled {
        SETTINGS.fine_penetration
    } else {
        SETTINGS.penetration_single
    }
}

/// Whether any node moved far enough in the stage to require another detection.
pub(crate) fn has_moved(group: &Group) -> bool {
    let still = if group.members.len() > 1 { SETTINGS.displacement_several } else { SETTINGS.displacement_single };
    group.members.iter().any(|i| group.sheets[*i as usize].has_moved(still))
}

/// Position of a side of a contact at the iterate, m.
fn place(group: &Group, side: &Side) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => point.of(&group.sheet(*sheet).work.stage.iterate),
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            mover.free.place(*local) + mover.moved(mover.free.place(*local) - mover.free.centre())
        }
    }
}

/// Penetration of a contact at the iterate, m; negative if it is open.
fn overlap(group: &Group, contact: &Contact) -> f64 {
    contact.offset - contact.normal.dot(place(group, &contact.a) - place(group, &contact.b))
}

/// Deepest penetration into a body among `contacts` at the iterate, m; 0 if there is none.
/// Sheet-sheet contacts are left out: not all of them are in the problem, and further iterations do
/// not reduce their penetration.
pub(crate) fn deepest(group: &Group, contacts: &[Contact]) -> f64 {
    let on_body = contacts.iter().filter(|c| matches!(c.b, Side::Body { .. }));
    on_body.map(|c| overlap(group, c)).fold(0.0, f64::max)
}

/// Whether the two sides of a sheet-sheet contact have penetrated in the stage by more than later
/// steps can recover, or have passed through. Pairs whose mid-surfaces had already passed each
/// other at the start do not count.
pub(crate) fn has_crossed(group: &Group, contact: &Contact) -> bool {
    let start = |side: &Side| match side {
        Side::Sheet { sheet, point } => point.of(&group.sheet(*sheet).x),
        Side::Body { body, local } => group.movers[*body as usize].start.place(*local),
    };
    let was = contact.offset - contact.normal.dot(start(&contact.a) - start(&contact.b));
    let now = overlap(group, contact);
    now > SETTINGS.crossed_penetration * contact.offset
        && now > was.max(0.0) + SETTINGS.crossed_growth * contact.offset
        && was < contact.offset
}
