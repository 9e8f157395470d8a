//! Kinematics of a contact in a stage: positions and velocities of its two sides, and their change
//! by contact.
//!
//! A side is a point of a sheet (a weighted mean of nodes) or a point fixed in the frame of a body.
//! The gap along the normal n is
//!
//!   g = n · (x_a - x_b) - contact offset.
//!
//! Lengths in m, speeds in m/s.

use glam::DVec3;

use crate::collision::constraint::{Contact, SheetPoint, Side};
use crate::contact::solver::delassus::Group;
use crate::contact::solver_body::Mover;
use crate::integrators::implicit::staged::Jump;
use crate::math::Vectors;

/// Gaps of all contacts of an outer iteration, m.
#[derive(Default)]
pub(crate) struct Gaps {
    /// Gap after the free motion.
    pub free: Vec<f64>,
    /// Gap with the forces of the last solve.
    pub now: Vec<f64>,
    /// Gap at the start of the stage, along the present normal.
    pub start: Vec<f64>,
    /// Position of side a after the free motion.
    pub places: Vec<DVec3>,
}

impl Gaps {
    /// Measure the gaps without contact forces.
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

    /// Update `now` with the displacement by contact.
    pub fn update(&mut self, contacts: &[Contact], group: &Group) {
        for (i, contact) in contacts.iter().enumerate() {
            let by = moved(group, &contact.a) - moved(group, &contact.b);
            self.now[i] = self.free[i] + contact.normal.dot(by);
        }
    }

    /// Fraction of the stage before contact `i` closes, 0 to 1.
    pub fn airborne(&self, i: usize) -> f64 {
        let (start, end) = (self.start[i], self.free[i]);
        if start > 1e-7 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Instant of the stage: its start, or its end after the free motion.
#[derive(Clone, Copy)]
pub(crate) enum At {
    /// At the start of the stage.
    Start,
    /// At the end of the stage, after the free motion.
    Free,
}

/// Position of a side, m.
pub(crate) fn place(group: &Group, side: &Side, at: At) -> DVec3 {
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

/// Gap of a contact, m.
pub(crate) fn gap(group: &Group, contact: &Contact, at: At) -> f64 {
    contact.normal.dot(place(group, &contact.a, at) - place(group, &contact.b, at)) - contact.offset
}

/// Displacement of a side by contact, m.
pub(crate) fn moved(group: &Group, side: &Side) -> DVec3 {
    by_contact(group, side, |jump| &jump.dx, Mover::moved)
}

/// Velocity change of a side by contact, m/s.
pub(crate) fn jumped(group: &Group, side: &Side) -> DVec3 {
    by_contact(group, side, |jump| &jump.dv, |mover, arm| mover.kick + mover.twist.cross(arm))
}

/// Change of a side by contact, from the sheet's response `of_sheet` or the body's response
/// `of_body` at an arm (m).
fn by_contact(
    group: &Group,
    side: &Side,
    of_sheet: impl Fn(&Jump) -> &Vectors,
    of_body: impl Fn(&Mover, DVec3) -> DVec3,
) -> DVec3 {
    match side {
        Side::Sheet { sheet, point } => {
            let unit = group.unit(*sheet);
            if unit.is_touched() { point.of(of_sheet(&unit.jump)) } else { DVec3::ZERO }
        }
        Side::Body { body, local } => {
            let mover = &group.movers[*body as usize];
            of_body(mover, mover.free.place(*local) - mover.free.centre())
        }
    }
}

/// Velocity of a side at the start of the stage or at its end without contact, m/s.
pub(crate) fn velocity(group: &Group, side: &Side, at: At) -> DVec3 {
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

/// Side of a contact at node `i` of a sheet.
pub(crate) fn mass_point(sheet: u32, i: u32) -> Side {
    Side::Sheet { sheet, point: SheetPoint::mass(i) }
}
