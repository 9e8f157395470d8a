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

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::contact::IslandView;
use crate::contact::solver_body::SolverBody;
use crate::integrators::implicit::staged::ContactJump;
use crate::math::Vectors;

/// Gaps of all contacts of an outer iteration, m.
#[derive(Default)]
pub(crate) struct ContactGaps {
    /// Gap after the free motion.
    pub free: Vec<f64>,
    /// Gap with the forces of the last solve.
    pub now: Vec<f64>,
    /// Gap at the start of the stage, along the present normal.
    pub start: Vec<f64>,
    /// Position of side a after the free motion.
    pub positions_a: Vec<DVec3>,
}

impl ContactGaps {
    /// Measure the gaps without contact forces.
    pub fn measure(&mut self, contacts: &[ContactConstraint], group: &IslandView) {
        self.free.clear();
        self.start.clear();
        self.positions_a.clear();
        for contact in contacts {
            let (a, b) = (position(group, &contact.a, StagePose::Free), position(group, &contact.b, StagePose::Free));
            self.free.push(contact.normal.dot(a - b) - contact.offset);
            self.start.push(gap(group, contact, StagePose::Start));
            self.positions_a.push(a);
        }
        self.now.clone_from(&self.free);
    }

    /// Update `now` with the displacement by contact.
    pub fn update(&mut self, contacts: &[ContactConstraint], group: &IslandView) {
        for (i, contact) in contacts.iter().enumerate() {
            let by = contact_displacement(group, &contact.a) - contact_displacement(group, &contact.b);
            self.now[i] = self.free[i] + contact.normal.dot(by);
        }
    }

    /// Fraction of the stage before contact `i` closes, 0 to 1.
    pub fn open_fraction(&self, i: usize) -> f64 {
        let (start, end) = (self.start[i], self.free[i]);
        if start > 1e-7 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Instant of the stage: its start, or its end after the free motion.
#[derive(Clone, Copy)]
pub(crate) enum StagePose {
    /// At the start of the stage.
    Start,
    /// At the end of the stage, after the free motion.
    Free,
}

/// Position of a side, m.
pub(crate) fn position(group: &IslandView, side: &ContactSide, at: StagePose) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.position(if matches!(at, StagePose::Start) { &sheet.x } else { &sheet.work.stage.free_positions })
        }
        ContactSide::Body { body, local } => {
            let mover = &group.solver_bodies[*body as usize];
            if matches!(at, StagePose::Start) {
                mover.start.world_point(*local)
            } else {
                mover.free.world_point(*local)
            }
        }
    }
}

/// Gap of a contact, m.
pub(crate) fn gap(group: &IslandView, contact: &ContactConstraint, at: StagePose) -> f64 {
    contact.normal.dot(position(group, &contact.a, at) - position(group, &contact.b, at)) - contact.offset
}

/// Displacement of a side by contact, m.
pub(crate) fn contact_displacement(group: &IslandView, side: &ContactSide) -> DVec3 {
    by_contact(group, side, |jump| &jump.dx, SolverBody::displacement_at)
}

/// Velocity change of a side by contact, m/s.
pub(crate) fn contact_velocity_jump(group: &IslandView, side: &ContactSide) -> DVec3 {
    by_contact(group, side, |jump| &jump.dv, |mover, arm| mover.kick + mover.spin_jump.cross(arm))
}

/// Change of a side by contact, from the sheet's response `of_sheet` or the body's response
/// `of_body` at an arm (m).
fn by_contact(
    group: &IslandView,
    side: &ContactSide,
    of_sheet: impl Fn(&ContactJump) -> &Vectors,
    of_body: impl Fn(&SolverBody, DVec3) -> DVec3,
) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let unit = group.unit(*sheet);
            if unit.is_touched() { point.position(of_sheet(&unit.jump)) } else { DVec3::ZERO }
        }
        ContactSide::Body { body, local } => {
            let mover = &group.solver_bodies[*body as usize];
            of_body(mover, mover.free.world_point(*local) - mover.free.centre())
        }
    }
}

/// Velocity of a side at the start of the stage or at its end without contact, m/s.
pub(crate) fn velocity(group: &IslandView, side: &ContactSide, at: StagePose) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let sheet = group.sheet(*sheet);
            point.position(if matches!(at, StagePose::Start) { &sheet.v } else { &sheet.work.stage.velocity })
        }
        ContactSide::Body { body, local } => {
            let mover = &group.solver_bodies[*body as usize];
            let state = if matches!(at, StagePose::Start) { &mover.start } else { &mover.free };
            state.velocity_at(state.world_point(*local))
        }
    }
}

/// Side of a contact at node `i` of a sheet.
pub(crate) fn node_side(sheet: u32, i: u32) -> ContactSide {
    ContactSide::Sheet { sheet, point: SheetPoint::node(i) }
}
