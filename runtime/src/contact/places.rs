//! Where the sides of a contact are in a stage, how fast, and what contact does to both.
//!
//! A side is a point of a sheet, a weighted mean of masses, or one of a body, fixed in its frame. The gap along the normal n is
//! n · (x_a - x_b) less the offset at which the two touch. Lengths in m, speeds in m/s.

use glam::DVec3;

use super::delassus::Group;
use super::mover::Mover;
use super::row::{Contact, SheetPoint, Side};
use crate::engine::implicit::staged::Jump;
use crate::sheet::Vectors;

/// How far apart the contacts of a round are.
#[derive(Default)]
pub(super) struct Gaps {
    /// After the free motion, and with the forces of the last solve, m.
    pub free: Vec<f64>,
    pub now: Vec<f64>,
    /// At the start of the stage, along the normal of now, m.
    pub start: Vec<f64>,
    /// Where side a is after the free motion, m.
    pub places: Vec<DVec3>,
}

impl Gaps {
    /// Measures the gaps before contact does anything.
    pub fn measure(&mut self, contacts: &[Contact], group: &Group) {
        self.free.clear();
        self.start.clear();
        self.places.clear();
        for contact in contacts {
            let (a, b) = (place(group, &contact.a, At::Free), place(group, &contact.b, At::Free));
            self.free.push(contact.normal.dot(a - b) - contact.offset);
            self.start.push(gap(group, contact, At::Start));
            self.places.push(a);
        }
        self.now.clone_from(&self.free);
    }

    /// Brings `now` up to date with what contact does.
    pub fn update(&mut self, contacts: &[Contact], group: &Group) {
        for (i, contact) in contacts.iter().enumerate() {
            let by = moved(group, &contact.a) - moved(group, &contact.b);
            self.now[i] = self.free[i] + contact.normal.dot(by);
        }
    }

    /// Part of the stage that contact `i` was apart.
    pub fn airborne(&self, i: usize) -> f64 {
        let (start, end) = (self.start[i], self.free[i]);
        if start > 1e-7 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Which positions of a group a point is wanted at.
#[derive(Clone, Copy)]
pub(crate) enum At {
    Start,
    Free,
}

/// Where a side is, m.
pub(super) fn place(group: &Group, side: &Side, at: At) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.of(if matches!(at, At::Start) { &sheet.x } else { &sheet.work.stage.free })
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            if matches!(at, At::Start) { mover.start.place(*local) } else { mover.free.place(*local) }
        }
    }
}

/// How far the sides of a contact are apart along its normal, m.
pub(crate) fn gap(group: &Group, contact: &Contact, at: At) -> f64 {
    contact.normal.dot(place(group, &contact.a, at) - place(group, &contact.b, at)) - contact.offset
}

/// How far contact moves a side, m.
pub(super) fn moved(group: &Group, side: &Side) -> DVec3 {
    by_contact(group, side, |jump| &jump.dx, Mover::moved)
}

/// By how much contact changes the velocity of a side, m/s.
pub(super) fn jumped(group: &Group, side: &Side) -> DVec3 {
    by_contact(group, side, |jump| &jump.dv, |mover, arm| mover.kick + mover.twist.cross(arm))
}

fn by_contact(
    group: &Group,
    side: &Side,
    of_sheet: impl Fn(&Jump) -> &Vectors,
    of_body: impl Fn(&Mover, DVec3) -> DVec3,
) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let unit = &group.sheet(*sheet).work.unit;
            if unit.is_touched() { point.of(of_sheet(&unit.jump)) } else { DVec3::ZERO }
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            of_body(mover, mover.free.place(*local) - mover.free.centre())
        }
    }
}

/// Velocity of a side at the start of the stage, or at its end without contact, m/s.
pub(super) fn velocity(group: &Group, side: &Side, at: At) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.of(if matches!(at, At::Start) { &sheet.v } else { &sheet.work.stage.velocity })
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            let state = if matches!(at, At::Start) { &mover.start } else { &mover.free };
            state.velocity_at(state.place(*local))
        }
    }
}

/// The point of a sheet that is mass `i`.
pub(crate) fn mass_point(sheet: u32, i: u32) -> Side {
    Side::Sheet { sheet, point: SheetPoint::mass(i) }
}
