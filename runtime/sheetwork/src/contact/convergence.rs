//! Convergence test of the outer iteration: penetration at the iterate.
//!
//! The strain test compares the strain of an iteration with the prediction of its linear solve.
//! Contact constraints are linear too: where a triangle turns under a needle's tip, or the nearest
//! point moves to another triangle, they may be satisfied while the surfaces overlap. The
//! penetration is therefore measured once more at the iterate, unless the stage hardly moved any
//! node. Lengths in m.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::settings::{ContactSettings, ConvergenceSettings};

const SETTINGS: ConvergenceSettings = ContactSettings::DEFAULT.convergence;

/// Penetration tolerance (m) after iteration `round` with `sheets` sheets; `stalled` says whether
/// the iteration has stagnated.
pub(crate) fn penetration_tolerance(round: u32, sheets: usize, stalled: bool) -> f64 {
    if sheets > 1 {
        SETTINGS.penetration_several
    } else if round < SETTINGS.fine_iterations && !stalled {
        SETTINGS.fine_penetration
    } else {
        SETTINGS.penetration_single
    }
}

/// Whether any node moved far enough in the stage to require another detection.
pub(crate) fn has_moved(group: &IslandView) -> bool {
    let still = if group.sheets.len() > 1 { SETTINGS.displacement_several } else { SETTINGS.displacement_single };
    group.sheets.iter().any(|sheet| sheet.has_moved(still))
}

/// Position of a side of a contact at the iterate, m.
fn position(group: &IslandView, side: &ContactSide) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => point.position(&group.sheet(*sheet).work.stage.iterate),
        ContactSide::Body { body, local } => {
            let mover = &group.solver_bodies[*body as usize];
            mover.free.world_point(*local) + mover.displacement_at(mover.free.world_point(*local) - mover.free.centre())
        }
    }
}

/// Penetration of a contact at the iterate, m; negative if it is open.
fn penetration(group: &IslandView, contact: &ContactConstraint) -> f64 {
    contact.offset - contact.normal.dot(position(group, &contact.a) - position(group, &contact.b))
}

/// Deepest penetration into a body among `contacts` at the iterate, m; 0 if there is none.
/// Sheet-sheet contacts are left out: not all of them are in the problem, and further iterations do
/// not reduce their penetration.
pub(crate) fn deepest_body_penetration(group: &IslandView, contacts: &[ContactConstraint]) -> f64 {
    let on_body = contacts.iter().filter(|c| matches!(c.b, ContactSide::Body { .. }));
    on_body.map(|c| penetration(group, c)).fold(0.0, f64::max)
}

/// Whether the two sides of a sheet-sheet contact have penetrated in the stage by more than later
/// steps can recover, or have passed through. Pairs whose mid-surfaces had already passed each
/// other at the start do not count.
pub(crate) fn has_crossed(group: &IslandView, contact: &ContactConstraint) -> bool {
    let start = |side: &ContactSide| match side {
        ContactSide::Sheet { sheet, point } => point.position(&group.sheet(*sheet).x),
        ContactSide::Body { body, local } => group.solver_bodies[*body as usize].start.world_point(*local),
    };
    let was = contact.offset - contact.normal.dot(start(&contact.a) - start(&contact.b));
    let now = penetration(group, contact);
    now > SETTINGS.crossed_penetration * contact.offset
        && now > was.max(0.0) + SETTINGS.crossed_growth * contact.offset
        && was < contact.offset
}
