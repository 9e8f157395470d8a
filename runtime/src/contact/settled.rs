//! Whether a stage has come to rest where nothing overlaps.
//!
//! Rounds stop when the strain that comes of one is what its linear solve had predicted. Rows are linear too: where a triangle
//! turns under a needle's tip, or the point that touches moves on to another, they may be satisfied and the surfaces overlap
//! all the same. So what is there at the place that was reached is looked at once more, unless the stage hardly moved
//! anything. Lengths in m.

use glam::DVec3;

use super::delassus::Group;
use super::row::{Contact, Side};

/// A stage that moved no mass further than this left no contact elsewhere than it was solved for, m; and of several sheets, which go into one
/// another little by little where what stages leave is not looked at.
const STILL: f64 = 2e-5;
const STILL_TOGETHER: f64 = 2e-6;

/// Overlap that is let pass, m: as long as there are rounds to spare, and then.
const FINE: f64 = 1e-5;
const ENOUGH: f64 = 6e-5;
/// The same for several sheets, of which one or another is always in motion.
const TOGETHER: f64 = 2e-4;

/// The same of two sheets as a fraction of the distance at which they touch, and by how much more than at the start: what has gone in further
/// may come out on the other side, and what a step leaves overlapping the next may not add to.
const CROSSED: f64 = 0.3;
const DEEPER: f64 = 0.2;

/// Rounds within which the finer limit is asked for.
const SPARE: u32 = 5;

/// Overlap (m) that is let pass after round number `round` of `sheets` sheets; `stalled` when that round did not help.
pub(super) fn allowed(round: u32, sheets: usize, stalled: bool) -> f64 {
    if sheets > 1 {
        TOGETHER
    } else if round < SPARE && !stalled {
        FINE
    } else {
        ENOUGH
    }
}

/// Whether the stage has moved some mass by enough to look again.
pub(super) fn has_moved(group: &Group) -> bool {
    let still = if group.members.len() > 1 { STILL_TOGETHER } else { STILL };
    group.members.iter().any(|i| group.sheets[*i as usize].has_moved(still))
}

/// Where a side is where the rounds have come to.
fn place(group: &Group, side: &Side) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => point.of(&group.sheet(*sheet).work.stage.iterate),
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            mover.free.place(*local) + mover.moved(mover.free.place(*local) - mover.free.centre())
        }
    }
}

/// By how much the sides of a contact overlap where the rounds have come to, m.
fn overlap(group: &Group, contact: &Contact) -> f64 {
    contact.offset - contact.normal.dot(place(group, &contact.a) - place(group, &contact.b))
}

/// Deepest overlap with a body among `contacts` where the rounds have come to, m; 0 where there is none. Of sheets with each
/// other not all that touch are solved for, and more rounds would not change that.
pub(super) fn deepest(group: &Group, contacts: &[Contact]) -> f64 {
    let on_body = contacts.iter().filter(|c| matches!(c.b, Side::Body { .. }));
    on_body.map(|c| overlap(group, c)).fold(0.0, f64::max)
}

/// Whether the sides of a contact of two sheets have gone into one another in the stage by more than may be mended later, or through. Those
/// whose middles had passed one another before it are on the other side already.
pub(super) fn has_crossed(group: &Group, contact: &Contact) -> bool {
    let start = |side: &Side| match side {
        Side::Sheet { sheet, point } => point.of(&group.sheet(*sheet).x),
        Side::Body { body, local } => group.movers[*body as usize].start.place(*local),
    };
    let was = contact.offset - contact.normal.dot(start(&contact.a) - start(&contact.b));
    let now = overlap(group, contact);
    now > CROSSED * contact.offset && now > was.max(0.0) + DEEPER * contact.offset && was < contact.offset
}
